//! Contacts laid along the boundary: which states of the grid they make.

use super::reading_preimage::BODY_POINTS;
use super::solid::Solid;
use super::state_grid::{Raster, StateGrid};
use super::thin::ThinWalls;
use super::touch::BoundaryTouch;
use crate::flow::contact_set::{ContactCell, ContactRegion};
use crate::plane::{Pose2, Vec2};
use core::f64::consts::{PI, TAU};

/// What is laid where.
pub(super) struct Painter<'a> {
    pub(super) region: &'a ContactRegion,
    pub(super) places: &'a [BoundaryTouch],
    pub(super) solid: Option<&'a Solid>,
    pub(super) thin: Option<&'a ThinWalls>,
    pub(super) robot_from_whisker: Pose2,
}

impl Painter<'_> {
    /// Lays every contact along every stretch of the boundary.
    pub(super) fn align(&self, states: &mut StateGrid) {
        let frames: Vec<Vec2> = self.places.iter().map(|t| Vec2::from_angle(t.tangent)).collect();
        let steps = self.steps();
        for cell in &self.region.cells {
            let body = self.body(cell);
            let mut turned = body.clone();
            let half = 0.5 * cell.wall.width();
            let wall = cell.wall.lo() + half;
            for (side, pushes) in [(0.0, cell.force.hi() >= 0.0), (PI, cell.force.lo() <= 0.0)] {
                if !pushes {
                    continue;
                }
                // The whisker's heading is the boundary's direction less the wall's; pushed to the right it lies the other way.
                let turn = Vec2::from_angle(side - wall);
                let offset = side - wall - self.robot_from_whisker.theta;
                let mut walk = Walk::default();
                let mut bins = (0, 0);
                let mut same = f64::NAN;
                for ((touch, frame), step) in self.places.iter().zip(&frames).zip(&steps) {
                    if touch.inner && !cell.is_tip {
                        walk = Walk::default();
                        continue;
                    }
                    // Along a straight wall only the place changes.
                    if step.is_none() {
                        walk = Walk::default();
                        let turned_by =
                            Vec2::new(frame.x * turn.x - frame.y * turn.y, frame.y * turn.x + frame.x * turn.y);
                        rotate(&body, turned_by, &mut turned);
                    }
                    if step.is_none() || touch.half_turn.to_bits() != same.to_bits() {
                        let (theta, spread) = (touch.tangent + offset, half + touch.half_turn);
                        (bins, same) = (states.bins_of(theta - spread, theta + spread), touch.half_turn);
                    }
                    let free = self.walk(&mut walk, step.unwrap_or_default(), touch.position, &turned);
                    if let Some(index) = states.raster().index(touch.position + turned[0]).filter(|_| free) {
                        states.add_bins(index, bins);
                    }
                }
            }
        }
    }

    /// How far each place is from the one before, where both lie on the same straight wall (m).
    fn steps(&self) -> Vec<Option<f64>> {
        let straight = |w: &[BoundaryTouch]| {
            let same = w[0].tangent.to_bits() == w[1].tangent.to_bits() && w[0].inner == w[1].inner;
            same.then(|| w[0].position.distance(w[1].position))
        };
        core::iter::once(None).chain(self.places.windows(2).map(straight)).collect()
    }

    /// Lays every contact on every stretch of the boundary at every heading.
    pub(super) fn turn(&self, states: &mut StateGrid, headings: usize) {
        for cell in &self.region.cells {
            let body = self.body(cell);
            let mut turned = body.clone();
            for bin in 0..headings {
                let theta = (bin as f64 + 0.5) * TAU / headings as f64;
                rotate(&body, Vec2::from_angle(theta + self.robot_from_whisker.theta), &mut turned);
                for touch in self.places {
                    if let Some(index) = self.place(states.raster(), touch.position, &turned) {
                        states.add_bin(index, bin);
                    }
                }
            }
        }
    }

    /// The robot's and the whisker's points seen from the contact, whisker axes: robot, base, tip, then the rest.
    fn body(&self, cell: &ContactCell) -> Vec<Vec2> {
        let contact = cell.contact.position;
        let robot = self.robot_from_whisker.inverse().position();
        let mut points = vec![robot - contact, -contact];
        if self.solid.is_some() {
            let shape = self.region.model().shape(&cell.contact, BODY_POINTS);
            points.extend(shape.iter().rev().map(|&p| p - contact));
        }
        points
    }

    /// The cell of the robot when the contact lies at `place` and the whisker is turned; none where it cannot be.
    #[inline]
    fn place(&self, raster: &Raster, place: Vec2, turned: &[Vec2]) -> Option<usize> {
        let index = raster.index(place + turned[0])?;
        self.walk(&mut Walk::default(), 0.0, place, turned).then_some(index)
    }

    /// Whether the turned whisker is free with its contact at `place`, `step` (m) on from the place before.
    #[inline]
    fn walk(&self, walk: &mut Walk, step: f64, place: Vec2, turned: &[Vec2]) -> bool {
        if let Some(solid) = self.solid {
            walk.room -= step as f32;
            if walk.room <= 0.0 {
                *walk = Walk::at(solid, place, &turned[1..]);
            }
        }
        walk.free && self.thin.is_none_or(|thin| !thin.stop(place, &turned[2..]))
    }
}

/// A whisker on its way along a straight wall: whether it is out of solids, and how far that stays as it is.
struct Walk {
    free: bool,
    /// (m); nothing is known without.
    room: f32,
}

impl Default for Walk {
    fn default() -> Self {
        Self { free: true, room: 0.0 }
    }
}

impl Walk {
    #[inline]
    fn at(solid: &Solid, place: Vec2, points: &[Vec2]) -> Self {
        let mut room = f32::INFINITY;
        for &p in points {
            let here = solid.room(place + p);
            if here < 0.0 {
                return Self { free: false, room: -here };
            }
            room = if here < room { here } else { room };
        }
        Self { free: true, room }
    }
}

/// The points turned to `heading`, a unit vector.
fn rotate(points: &[Vec2], heading: Vec2, turned: &mut [Vec2]) {
    for (to, p) in turned.iter_mut().zip(points) {
        *to = Vec2::new(heading.x * p.x - heading.y * p.y, heading.y * p.x + heading.x * p.y);
    }
}
