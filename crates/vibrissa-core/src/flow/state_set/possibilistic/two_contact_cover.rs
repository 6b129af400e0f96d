//! The initial cover of states with two contacts: set inversion of "may touch in two places" (SIVIA, \[jaulin2001applied, ch. 3\]).

use super::contractor::BaseView;
use super::errors::PoseSlack;
use super::free_space;
use super::initial_cover::{new_cell, robot_slack};
use super::parallelotope::Parallelotope;
use super::record::ReadingContacts;
use super::two_contacts::TwoContacts;
use crate::config::two_contacts::{COVER_PLACE, COVER_TURN};
use crate::plane::{Bounds, Pose2, Vec2};
use crate::world::Map;
use core::f64::consts::PI;

/// Bases and headings of a whisker: a box of its poses.
#[derive(Clone, Copy)]
struct PoseBox {
    place: Bounds,
    /// Middle and half (rad).
    heading: (f64, f64),
}

/// Cells that hold every state, with the whisker's base in `near` where that is known, in which the whisker may read this with
/// more than one contact.
pub(super) fn initial_cells(
    map: &Map,
    two: &TwoContacts,
    near: Option<Bounds>,
    touch: &ReadingContacts,
    (record, late): (u32, PoseSlack),
) -> Vec<Parallelotope> {
    let mut cells = Vec::new();
    if !two.is_possible() {
        return cells;
    }
    let off = robot_slack(touch, late);
    let around = two.places().fold(Bounds::EMPTY, |all, one| all.hull(one)).inflated(touch.length);
    let place = near.map_or(around, |near| Bounds {
        min: Vec2::new(around.min.x.max(near.min.x), around.min.y.max(near.min.y)),
        max: Vec2::new(around.max.x.min(near.max.x), around.max.y.min(near.max.y)),
    });
    let mut boxes = if place.is_empty() { Vec::new() } else { vec![PoseBox { place, heading: (0.0, PI) }] };
    while let Some(pose) = boxes.pop() {
        let cell = pose.cell(touch, record);
        let view = BaseView::new(&pose.bases(), Pose2::IDENTITY, (0.0, 0.0), Pose2::IDENTITY);
        if !two.may_explain(&view, touch, &mut 0) || !free_space::base_may_be_free(&view, map) {
            continue;
        }
        match pose.halves() {
            Some(halves) => boxes.extend(halves),
            None => cells.push(cell),
        }
    }
    cells.iter_mut().for_each(|cell| cell.inflate(off.place, off.turn));
    cells
}

impl PoseBox {
    fn center_and_sides(&self) -> (Pose2, [[f64; 3]; 3]) {
        let (middle, half) = ((self.place.min + self.place.max) * 0.5, self.place.size() * 0.5);
        let center = Pose2::new(middle.x, middle.y, self.heading.0);
        // Halves share a face, whatever is rounded.
        let grown = 1e-9;
        (center, [[half.x + grown, 0.0, 0.0], [0.0, half.y + grown, 0.0], [0.0, 0.0, self.heading.1 + grown]])
    }

    /// The box as a cell of the bases themselves.
    fn bases(&self) -> Parallelotope {
        let (center, sides) = self.center_and_sides();
        Parallelotope { center, sides, anchor: 0, seen: 0, missed: 0, rest_until: 0, patience: 8, is_fresh: true }
    }

    fn cell(&self, touch: &ReadingContacts, record: u32) -> Parallelotope {
        let (center, sides) = self.center_and_sides();
        new_cell(center, sides, touch, record)
    }

    /// Its halves along the side that is longest for what a cell may be; none where it is small enough.
    fn halves(&self) -> Option<[Self; 2]> {
        let size = self.place.size();
        let (place, turn) = (size.x.max(size.y) / COVER_PLACE, 2.0 * self.heading.1 / COVER_TURN);
        if place <= 1.0 && turn <= 1.0 {
            return None;
        }
        let (mut a, mut b) = (*self, *self);
        if turn > place {
            let (middle, half) = (self.heading.0, 0.5 * self.heading.1);
            (a.heading, b.heading) = ((middle - half, half), (middle + half, half));
        } else if size.x > size.y {
            let x = 0.5 * (self.place.min.x + self.place.max.x);
            (a.place.max.x, b.place.min.x) = (x, x);
        } else {
            let y = 0.5 * (self.place.min.y + self.place.max.y);
            (a.place.max.y, b.place.min.y) = (y, y);
        }
        Some([a, b])
    }
}
