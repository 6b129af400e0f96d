//! What is kept of each row: the odometry with its error bounds, and the contacts that a reading allows.

use super::errors::{PoseSlack, RestShape, StepBounds, UncertainWhisker};
use super::parallelotope::HEADING_ARM;
use crate::beam::press::{ContactTable, PressEntry, PressSlice};
use crate::math;
use crate::plane::{Bounds, Pose2, Vec2};
use core::sync::atomic::{AtomicU32, Ordering};
use std::sync::Arc;

/// Where the odometry stood, with the bounds on its errors summed up from the start.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct OdometryRecord {
    pub(super) odom_from_robot: Pose2,
    path: f64,
    /// The way with turns, by an arm of a tenth of a metre (m).
    swept: f64,
    translation: f64,
    rotation: f64,
}

impl OdometryRecord {
    /// The first stand.
    pub(super) fn first(odom_from_robot: Pose2) -> Self {
        Self { odom_from_robot, ..Self::default() }
    }

    /// The next stand, with the odometry at `odom_from_robot`.
    pub(super) fn next(&self, odom_from_robot: Pose2, bounds: &StepBounds) -> Self {
        let step = self.odom_from_robot.between(odom_from_robot);
        let (way, turn) = (step.position().norm(), step.theta.abs());
        Self {
            odom_from_robot,
            // Bounds are relative to what the odometry says or to the truth: take the larger.
            path: self.path + way / bounds.least,
            swept: self.swept + way + HEADING_ARM * turn,
            translation: self.translation + way * bounds.translation,
            rotation: self.rotation + turn * bounds.rotation,
        }
    }

    /// The way so far (m).
    pub(super) fn path(&self) -> f64 {
        self.path
    }

    /// The way so far, turns included (m).
    pub(super) fn swept(&self) -> f64 {
        self.swept
    }

    /// How the robot moved until `later` (or, for an earlier stand, from there), and how far that may be off: place (m)
    /// and turn (rad).
    pub(super) fn until(&self, later: &Self) -> (Pose2, f64, f64) {
        let step = self.odom_from_robot.between(later.odom_from_robot);
        let turn = (later.rotation - self.rotation).abs();
        let place = (later.translation - self.translation).abs() + turn * (later.path - self.path).abs();
        (step, place, turn)
    }
}

/// Without friction only a boundary with a radius below three lengths of the whisker holds a shape with an inflection
/// (the least eigenvalue of the second variation, all amplitudes); this is its curvature over the whisker's length, with
/// a margin.
const INFLECTION_CURVATURE: f64 = 0.28;

/// What one reading of one whisker allows.
#[derive(Clone, Debug)]
pub(super) struct ReadingContacts {
    /// The base, turned by the moment where it is elastic, and how far it may be from there.
    pub(super) robot_from_whisker: Pose2,
    pub(super) base: PoseSlack,
    /// The longest that the whisker may be (m), and its shape at rest.
    pub(super) length: f64,
    pub(super) rest: Arc<RestShape>,
    /// Whether it is uniform.
    pub(super) is_uniform: bool,
    /// How far the force may lean from the normal (rad).
    pub(super) friction_angle: f64,
    /// Contacts where the whisker slopes to the left (1) or to the right (-1), in metres.
    pub(super) sides: Vec<SideContacts>,
    /// Whether the whisker may be free.
    pub(super) free: bool,
    /// Boundaries that curve towards free space by no less than this (1/m) can hold a whisker with an inflection.
    pub(super) holding: f64,
    /// What the curvature at the base may be (1/m).
    pub(super) curvature: (f64, f64),
    /// What the moment may be (N m).
    range: (f64, f64),
}

/// The contacts on one side.
#[derive(Clone, Debug)]
pub(super) struct SideContacts {
    /// 1 for slopes towards +y at the contact, -1 for the mirror image.
    pub(super) side: f64,
    /// The same contacts by directions of the wall, from fine to coarse.
    pub(super) slices: Vec<PressSlice>,
    /// The rectangle around all contacts, whisker frame, and the largest distance from the base in it (m).
    pub(super) bounds: Bounds,
    pub(super) farthest: f64,
    /// Whether all these contacts have an inflection.
    pub(super) all_inflected: bool,
    /// Where the whisker last stood in all of a cell.
    pub(super) last_piece: LastPiece,
}

/// The piece of boundary of each grade that last explained a reading in all of a cell. It saves time and changes no answer,
/// and is therefore kept where all else is only read.
#[derive(Debug, Default)]
pub(super) struct LastPiece([AtomicU32; 3]);

impl Clone for LastPiece {
    fn clone(&self) -> Self {
        Self([0, 1, 2].map(|grade: usize| AtomicU32::new(self.0[grade].load(Ordering::Relaxed))))
    }
}

impl LastPiece {
    /// The index of the piece of a grade.
    pub(super) fn of(&self, grade: usize) -> Option<usize> {
        self.0[grade].load(Ordering::Relaxed).checked_sub(1).map(|index| index as usize)
    }

    /// Notes a piece.
    pub(super) fn note(&self, grade: usize, index: usize) {
        self.0[grade].store(index as u32 + 1, Ordering::Relaxed);
    }
}

impl ReadingContacts {
    /// What a moment in `[lo, hi]` (N m) allows.
    pub(super) fn new(whisker: &UncertainWhisker, tables: &[ContactTable], lo: f64, hi: f64) -> Self {
        let stand = whisker.stand(lo, hi);
        Self {
            robot_from_whisker: stand.robot_from_whisker,
            base: stand.slack,
            length: whisker.longest,
            rest: Arc::clone(whisker.rest()),
            is_uniform: whisker.rod.is_none(),
            friction_angle: tables.first().map_or(0.0, ContactTable::friction_angle),
            sides: side_contacts(whisker, tables, lo, hi),
            curvature: whisker.curvature(lo, hi),
            range: (lo, hi),
            free: lo <= 0.0 && hi >= 0.0,
            holding: if whisker.friction > 0.0 { 0.0 } else { INFLECTION_CURVATURE / whisker.longest },
        }
    }
}

impl ReadingContacts {
    /// Adds the contacts by a finer table.
    pub(super) fn add_finer(&mut self, whisker: &UncertainWhisker, table: &ContactTable) {
        let (lo, hi) = self.range;
        let mut finer = side_contacts(whisker, core::slice::from_ref(table), lo, hi);
        // A table that knows no contact is right.
        self.sides.retain_mut(|bending| {
            let Some(fine) = finer.iter_mut().find(|fine| fine.side.to_bits() == bending.side.to_bits()) else {
                return false;
            };
            fine.slices.append(&mut bending.slices);
            core::mem::swap(fine, bending);
            true
        });
    }
}

/// What a moment in `[lo, hi]` (N m) allows on either side.
fn side_contacts(whisker: &UncertainWhisker, tables: &[ContactTable], lo: f64, hi: f64) -> Vec<SideContacts> {
    let mut sides = Vec::new();
    for (side, least, most) in [(1.0, lo, hi), (-1.0, -hi, -lo)] {
        let (least, most) = whisker.dimensionless(least, most);
        let cut = |table: &ContactTable| table.slice(side, least, most).widened(whisker.stretch).scaled(whisker.length);
        let Some(finest) = tables.first().map(cut) else { continue };
        // A table that knows no contact is right, however fine the others are.
        if !finest.entries().is_empty() {
            let bounds = around(&finest, side);
            let all_inflected = finest.entries().iter().all(|entry| entry.inflected);
            let slices: Vec<PressSlice> = core::iter::once(finest).chain(tables[1..].iter().map(cut)).collect();
            let Bounds { min, max } = bounds;
            let farthest = math::hypot(min.x.abs().max(max.x.abs()), min.y.abs().max(max.y.abs()));
            sides.push(SideContacts {
                side,
                slices,
                bounds,
                farthest,
                all_inflected,
                last_piece: LastPiece::default(),
            });
        }
    }
    sides
}

impl SideContacts {
    /// The slice for a range of directions of `2 wide` (rad): as coarse as that needs.
    pub(super) fn level(&self, wide: f64) -> &PressSlice {
        let fits = |slice: &&PressSlice| slice.width() >= FILLED * wide;
        let Some(at) = self.slices.iter().position(|s| fits(&s)) else {
            return &self.slices[self.slices.len() - 1];
        };
        &self.slices[at]
    }
}

/// A range of directions fills this share of a bucket at least, or less than two: what finer buckets cut off wide cells
/// is worth looking at more of them.
const FILLED: f64 = 0.25;

/// The rectangle around the contacts of a slice.
fn around(slice: &PressSlice, side: f64) -> Bounds {
    slice.entries().iter().fold(Bounds::EMPTY, |bounds, entry| {
        let half = spread(entry);
        let center = Vec2::new(entry.center.x, side * entry.center.y);
        bounds.including(center + half).including(center - half)
    })
}

/// Half the rectangle around the contacts of an entry.
pub(super) fn spread(entry: &PressEntry) -> Vec2 {
    let of = |a: f64, b: f64| a.abs() * entry.half + b.abs() + entry.radius;
    Vec2::new(of(entry.by_direction.x, entry.by_moment.x), of(entry.by_direction.y, entry.by_moment.y))
}
