//! Where a contact may begin: the straight whisker's tip on the boundary, a tip that is loaded already, or the side on a sharp corner.

use super::super::admission::Admits;
use super::super::measurement::MeasurementModel;
use super::ContactOnset;
use super::cell::forward;
use crate::contact::follow::WhiskerState;
use crate::flow::contact_set::TipContactSet;
use crate::plane::{Pose2, Vec2, wrap_angle};
use core::f64::consts::FRAC_PI_2;

/// Headings further than this from the boundary's normal are left out (rad).
const WIDEST: f64 = 1.45;
/// Headings about head-on, in shares of their spacing: there a whisker buckles to one side or the other, and its readings change with the
/// heading as nowhere else. Of 165 sweeps by moments in rooms drawn at random 30 were inconsistent without these and with contacts that had
/// to be known at once, 3 with them.
const HEAD_ON: [f64; 2] = [0.15, 0.5];
/// Share of the whisker that is kept clear of the boundaries when it begins to touch.
const CLEAR: f64 = 0.98;
/// Corners that turn by more than this (rad) are touched with the side.
const SHARP: f64 = 0.3;

/// Headings from head-on (rad) at which a free whisker is taken to come to a wall: evenly spaced, and denser about head-on.
pub(super) fn headings_at_touch(turn: f64) -> impl Iterator<Item = f64> {
    let count = (WIDEST / turn - 0.5).ceil() as usize;
    let even = (1..=count).map(move |k| k as f64 * turn);
    HEAD_ON.into_iter().map(move |share| share * turn).chain(even).flat_map(|off| [off, -off])
}

/// Calls `visit(piece, parameter)` every `spacing` metres along all pieces.
pub(super) fn for_each_place(pieces: &[crate::contact::Piece], spacing: f64, mut visit: impl FnMut(u32, f64)) {
    let mut next = 0.5 * spacing;
    for (index, piece) in pieces.iter().enumerate() {
        while next < piece.length() {
            visit(index as u32, piece.parameter_at(next));
            next += spacing;
        }
        next -= piece.length();
    }
}

/// The corners that a side can lie on, each with the direction in which it points.
pub(super) fn sharp_corners(model: &MeasurementModel<'_>) -> Vec<(Vec2, f64)> {
    let mut seen = Vec::new();
    let mut corners = Vec::new();
    for piece in 0..model.ground.pieces.len() as u32 {
        for forward in [false, true] {
            let Some((id, corner)) = model.ground.corner_of(piece, forward) else { continue };
            if corner.is_convex() && corner.turn.abs() > SHARP && !seen.contains(&id) {
                seen.push(id);
                corners.push((corner.position, corner.outward()));
            }
        }
    }
    corners
}

/// A pose of the whisker's base that may begin a contact: its state, and up to where it must be clear of boundaries.
pub(super) struct Seed {
    pub(super) pose: Pose2,
    pub(super) state: WhiskerState,
    clear: Vec2,
}

impl Seed {
    pub(super) fn is_clear(&self, model: &MeasurementModel<'_>) -> bool {
        let base = self.pose.position();
        !model.map.crosses(base, self.clear) && model.map.is_free(base)
    }
}

/// The whisker's base and state where the straight whisker's tip touched here, if it can have.
pub(super) fn touching(
    model: &MeasurementModel<'_>,
    onset: &ContactOnset,
    piece: u32,
    at: f64,
    heading: f64,
    admits: &Admits<'_>,
) -> Option<Seed> {
    let sensor = &model.sensors[onset.sensor];
    let z = model.window.readings(onset.row)[onset.sensor] - onset.level;
    let spot = model.ground.pieces[piece as usize].spot(at);
    let push = (spot.normal - heading).sin();
    let along = Vec2::from_angle(heading);
    let normal = Vec2::from_angle(spot.normal);
    if push * z < 0.0 || onset.approach.rotated(heading).dot(normal) > 0.0 {
        return None;
    }
    let base = spot.position - along * sensor.length;
    let pose = Pose2::new(base.x, base.y, heading);
    // The region is asked first: on a large map little is left.
    if !admits(from_odom(model, onset, pose)) {
        return None;
    }
    let state = WhiskerState::Touching(forward(model, sensor).untouched(piece, at, heading));
    Some(Seed { pose, state, clear: base + along * (CLEAR * sensor.length) })
}

/// The same where the tip was pressed with the reading of the first row.
pub(super) fn loaded(
    model: &MeasurementModel<'_>,
    onset: &ContactOnset,
    set: &TipContactSet,
    piece: u32,
    at: f64,
    heading: f64,
    admits: &Admits<'_>,
) -> Option<Seed> {
    let sensor = &model.sensors[onset.sensor];
    let spot = model.ground.pieces[piece as usize].spot(at);
    let contact = set.at_direction(spot.normal - heading)?;
    let base = spot.position - contact.position.rotated(heading);
    let chord = spot.position - base;
    // The whisker comes to the boundary from its free side.
    let aslant = Vec2::from_angle(heading + contact.slope).dot(Vec2::from_angle(spot.normal));
    let pose = Pose2::new(base.x, base.y, heading);
    if aslant >= 0.0 || !admits(from_odom(model, onset, pose)) {
        return None;
    }
    let q = contact.force.abs() * sensor.length.powi(2) / sensor.tip.rigidity();
    let beta = wrap_angle(spot.normal - heading - contact.slope - FRAC_PI_2);
    let state = WhiskerState::Touching(forward(model, sensor).loaded(piece, at, q, beta, contact.slope));
    Some(Seed { pose, state, clear: base + chord * 0.5 })
}

/// The odometry frame in the map when the whisker's base is there at the first touch.
pub(super) fn from_odom(model: &MeasurementModel<'_>, onset: &ContactOnset, map_from_whisker: Pose2) -> Pose2 {
    let odom_from_whisker = model.window.pose(onset.row).compose(model.sensors[onset.sensor].robot_from_whisker);
    map_from_whisker.compose(odom_from_whisker.inverse())
}
