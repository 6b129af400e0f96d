//! Hypotheses that were dropped, and where they would have had to stand.
//!
//! Along a straight wall hypotheses stand millimetres apart, and all explain the readings. The corner at its end does not
//! forgive that: a whisker snaps out of it at one millimetre of the way. Of several corners that are alike, the one whose
//! hypothesis happened to stand best would be told as the only place. Once that one is fitted, it is known where the others
//! would have had to stand, and those that were dropped there are tried again.

use super::super::history::{History, Judge};
use super::super::hypothesis::{Hypothesis, Limits, difference};
use super::{Bank, Field, LOOSE};
use crate::plane::Pose2;
use std::collections::VecDeque;

/// So many of those dropped last are kept, for so many used rows.
const KEPT: usize = 128;
const ROWS: usize = 96;
/// With more hypotheses than this nothing is called back.
const FEW: usize = 24;
/// How far one that was dropped may have stood from where it should have (m, rad).
const REACH: [f64; 2] = [10e-3, 0.06];
/// What is no further than this from a hypothesis is known (m, rad).
const KNOWN: [f64; 2] = [3e-3, 0.03];

/// Those that were dropped last, each with how many rows had been used by then.
#[derive(Default)]
pub(super) struct Dropped(VecDeque<(Hypothesis, usize)>);

impl Dropped {
    pub(super) fn push(&mut self, h: Hypothesis, used: usize) {
        if self.0.len() == KEPT {
            self.0.pop_front();
        }
        self.0.push_back((h, used));
    }

    /// Forgets what rows that are summed up now have said against them.
    pub(super) fn clear(&mut self) {
        self.0.clear();
    }
}

impl Bank {
    /// Tries those that were dropped again, where the best one's place would be at other corners; what is dearer than the best
    /// by no more than this (nats) is called back.
    pub(super) fn recall(&mut self, field: &Field<'_>, history: &History, more: f64) {
        let used = self.used.len();
        self.dropped.0.retain(|(_, then)| then + ROWS > used);
        if self.dropped.0.is_empty() || self.hypotheses.len() > FEW {
            return;
        }
        let best = self.hypotheses.iter().filter(|h| !h.waits).min_by(|a, b| a.promise.0.total_cmp(&b.promise.0));
        let Some(best) = best else { return };
        let Some(contact) = best.states.iter().find_map(|state| state.tip_on()) else { return };
        let spot = |(piece, at): (u32, f64)| field.ground.pieces[piece as usize].spot(at);
        let (from, own) = (spot(contact), best.map_from_odom);
        let places = field.ground.as_far_from_corners(contact).into_iter().map(|place| {
            let to = spot(place);
            let turn = to.normal - from.normal;
            let origin = to.position + (own.position() - from.position).rotated(turn);
            Pose2::new(origin.x, origin.y, own.theta + turn)
        });
        let scene = field.scene(history, self.pivot, Judge::FAIR, self.shared);
        let least = self.least();
        let mut back: Vec<Hypothesis> = Vec::new();
        for frame in places {
            let off = |h: &Hypothesis| {
                let [x, y, turn] = difference(frame, h.map_from_odom, self.pivot);
                (x.hypot(y), turn.abs())
            };
            let within = |h: &Hypothesis, [place, angle]: [f64; 2]| off(h).0 < place && off(h).1 < angle;
            if self.hypotheses.iter().chain(&back).any(|h| within(h, KNOWN)) {
                continue;
            }
            let near = self.dropped.0.iter().map(|(h, _)| h).filter(|h| within(h, REACH));
            let Some(near) = near.min_by(|a, b| off(a).0.total_cmp(&off(b).0)) else { continue };
            let mut again = near.clone();
            if again.run_below(&scene, frame, &self.used, Limits { usual: &self.usual, more }) {
                again.look(LOOSE, self.shared);
                if again.promise.0 <= least + more {
                    back.push(again);
                }
            }
        }
        self.hypotheses.extend(back);
    }
}
