//! Hypotheses that are dropped, and where they would have had to stand.
//!
//! Along a straight wall hypotheses stand millimetres apart, and all explain the readings. The corner at its end does not
//! forgive that: a whisker snaps out of it at one millimetre of the way. Of several corners the one whose hypothesis happened to
//! stand best would be told as the only place. So those that were dropped are tried again: slid along the wall to where they
//! meet their own corner in time, and, where other corners are alike, where the best one's place would be at those.

use super::super::feeler::Judge;
use super::super::history::History;
use super::super::hypothesis::{Hypothesis, Limits, Scene, difference};
use super::super::twins::Before;
use super::{Bank, Field, LOOSE, MUCH, cut, is_stale};
use crate::plane::{Pose2, Vec2};
use std::collections::VecDeque;

/// A hypothesis less likely than the best by this (nats) is dropped; the second part shrinks with the share of the rows
/// that are used.
const DROP: f64 = 30.0;
const DROP_MORE: f64 = 20.0;
/// Readings that may be run again, for each new row, for those that are linearised anew before they are dropped.
const URGENT: usize = 200;
/// One that is revived may have come only part of the way: it is, so often in turn.
const REVIVED: u32 = 3;
/// What has become dearer than the best was then by this many times what drops a hypothesis is given up while it is still being
/// run.
const HOPELESS: f64 = 1.3;
/// So many of those dropped last are kept, for so many used rows, and looked for at corners that are alike for so many.
const KEPT: usize = 256;
const KEPT_ROWS: usize = 384;
const ROWS: usize = 96;
/// With no more hypotheses than this those that were dropped are slid to where they meet corners in time.
const REGAINED_AMONG: usize = 64;
/// Readings that may be run for that for each new row, and before everything is given up; beginning with one counts like so many.
const REGAINED: usize = 80;
const LAST_REGAINED: usize = 200_000;
const BEGUN: usize = 20;
/// With more hypotheses than this nothing is called back.
const FEW: usize = 24;
/// How far one that was dropped may have stood from where it should have (m, rad).
const REACH: [f64; 2] = [10e-3, 0.06];
/// What is no further than this from a hypothesis is known (m, rad).
const KNOWN: [f64; 2] = [3e-3, 0.03];

/// Those that were dropped last.
#[derive(Default)]
pub(super) struct Dropped(VecDeque<Lost>);

/// One that was dropped.
struct Lost {
    h: Hypothesis,
    /// How many rows had been used when it was last thought of.
    then: usize,
    /// By how much it was dearer than the best (nats).
    dearer: f64,
    /// Whether it has been tried again since.
    tried: bool,
}

impl Dropped {
    pub(super) fn push(&mut self, h: Hypothesis, then: usize, least: f64) {
        if self.0.len() == KEPT {
            self.0.pop_front();
        }
        let dearer = h.promise.0 - least;
        self.0.push_back(Lost { h, then, dearer, tried: false });
    }

    /// All of them.
    pub(super) fn all(&mut self) -> impl Iterator<Item = &mut Hypothesis> {
        self.0.iter_mut().map(|lost| &mut lost.h)
    }

    /// Tries those that were dropped, first those that had come furthest, and slides them to where they meet corners in time, with no more
    /// than this much work (readings); those that come through all rows.
    fn regained(&mut self, scene: &Scene<'_>, rows: &[usize], most: Limits<'_>, work: &mut usize) -> Vec<Hypothesis> {
        let mut back = Vec::new();
        while *work > 0 {
            let open = self.0.iter_mut().filter(|lost| !lost.tried);
            let first = |a: &&mut Lost, b: &&mut Lost| {
                let begun = b.h.rerun.is_some().cmp(&a.h.rerun.is_some());
                begun.then(b.h.row.cmp(&a.h.row)).then(a.dearer.total_cmp(&b.dearer))
            };
            let Some(next) = open.min_by(first) else { break };
            let d = cut(next.h.promise.1);
            // What was dropped long ago was not for a corner.
            let early = 2 * next.h.row < rows.last().copied().unwrap_or(0);
            next.tried = early || !next.h.is_open(scene.shared);
            *work = work.saturating_sub(BEGUN);
            if next.tried {
                continue;
            }
            let Some((alive, _)) = next.h.revive(scene, d, rows, most, true, work) else { break };
            next.tried = true;
            if alive {
                next.h.look(LOOSE, scene.shared);
                back.push(next.h.clone());
            }
        }
        back
    }

    /// Forgets those that had been dropped by the first `early` of the used rows, which are summed up now, and some of those
    /// that stand together; gives the others, for which these rows have to be summed up, too.
    pub(super) fn since(&mut self, early: usize, pivot: Vec2) -> impl Iterator<Item = &mut Hypothesis> {
        let mut stay: Vec<Pose2> = Vec::new();
        self.0.retain_mut(|Lost { h, then, .. }| {
            let near = |frame: &Pose2| {
                let [x, y, turn] = difference(*frame, h.map_from_odom, pivot);
                x.hypot(y) < 0.5 * REACH[0] && turn.abs() < 0.5 * REACH[1]
            };
            if *then <= early || stay.iter().any(near) {
                return false;
            }
            *then -= early;
            stay.push(h.map_from_odom);
            true
        });
        self.all()
    }
}

impl Bank {
    /// What a hypothesis may cost more than the best one (nats).
    pub(super) fn drop(&self, history: &History) -> f64 {
        DROP + DROP_MORE * self.used.len() as f64 / history.len() as f64
    }

    /// Drops what is much less likely than the best; each gets one more chance at its best place.
    pub(super) fn drop_unlikely(&mut self, field: &Field<'_>, history: &History) {
        let least = self.least();
        let drop = self.drop(history);
        let scene = field.scene(history, self.pivot, Judge::FAIR, self.shared);
        let (used, shared) = (&self.used, self.shared);
        let limits = Limits { usual: &self.usual, more: HOPELESS * drop };
        let may_move = |h: &Hypothesis| is_stale(h.promise.1) || h.cost(shared) - h.promise.0 > MUCH;
        let mut dropped = core::mem::take(&mut self.dropped);
        let lost = self.hypotheses.extract_if(.., |h| {
            if h.waits || h.promise.0 <= least + drop {
                return false;
            }
            // What it costs may say only that its linearisation is old. Until it is run anew it takes none of the rows to come.
            let old = h.age * 6 > used.len();
            if old {
                h.revived = 0;
            }
            h.waits = (old || (1..REVIVED).contains(&h.revived)) && may_move(h);
            h.rerun = None;
            !h.waits
        });
        lost.for_each(|h| dropped.push(h, used.len(), least));
        let waiting = self.hypotheses.iter().enumerate().filter(|(_, h)| h.waits);
        let mut waiting: Vec<(bool, f64, usize)> =
            waiting.map(|(index, h)| (h.rerun.is_none(), h.promise.0, index)).collect();
        waiting.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        let mut dead = vec![false; self.hypotheses.len()];
        let mut work = URGENT;
        for (.., index) in waiting {
            if work == 0 {
                break;
            }
            let h = &mut self.hypotheses[index];
            if !h.waits || dead[index] {
                continue;
            }
            let before = Before::of(h);
            let Some((alive, track)) = h.revive(&scene, cut(h.promise.1), used, limits, false, &mut work) else {
                break;
            };
            h.look(LOOSE, shared);
            h.revived += 1;
            let dear = h.promise.0 > least + drop;
            h.waits = alive && dear && h.revived < REVIVED && may_move(h);
            dead[index] = !alive || dear && !h.waits;
            // Along a straight wall others come to the same.
            let outcome = h.clone();
            for (other, h) in self.hypotheses.iter_mut().enumerate().filter(|(_, h)| h.waits) {
                if let Some(there) = before.at(field.ground, track, &outcome, h).filter(|_| other != index) {
                    dead[other] = dead[index];
                    if alive {
                        *h = there;
                    }
                }
            }
        }
        let mut dead = dead.into_iter();
        let lost = self.hypotheses.extract_if(.., |_| dead.next() == Some(true));
        lost.for_each(|h| dropped.push(h, used.len(), least));
        self.dropped = dropped;
        if self.hypotheses.len() <= REGAINED_AMONG {
            self.regain(field, history, REGAINED);
        }
    }

    /// Tries those that were dropped, slid to where they meet corners in time, with so much work (readings), and takes back what then
    /// explains the rows nearly as well as the best.
    fn regain(&mut self, field: &Field<'_>, history: &History, mut work: usize) {
        let scene = field.scene(history, self.pivot, Judge::FAIR, self.shared);
        let limits = Limits { usual: &self.usual, more: self.drop(history) };
        let back = self.dropped.regained(&scene, &self.used, limits, &mut work);
        self.hypotheses.extend(back);
    }

    /// Before all is given up: tries all that were dropped once more, along the path as the odometry has it; whether any comes back.
    pub(in super::super) fn regain_any(&mut self, field: &Field<'_>, history: &mut History) -> bool {
        self.forget_corrections(field, history);
        self.dropped.0.iter_mut().for_each(|lost| lost.tried = false);
        let before = self.hypotheses.len();
        self.regain(field, history, LAST_REGAINED);
        self.hypotheses.len() > before
    }

    /// Tries those that were dropped again, where the best one's place would be at other corners; what is dearer than the best
    /// by no more than this (nats) is called back.
    pub(super) fn recall(&mut self, field: &Field<'_>, history: &History, more: f64) {
        let used = self.used.len();
        if self.hypotheses.len() > FEW {
            // As long as there are many, more are dropped at every row: what is gone first must not be forgotten before it is asked for.
            self.dropped.0.iter_mut().for_each(|lost| lost.then = used);
            return;
        }
        self.dropped.0.retain(|lost| lost.then + KEPT_ROWS > used);
        if !self.dropped.0.iter().any(|lost| lost.then + ROWS > used) {
            return;
        }
        let best = self.hypotheses.iter().filter(|h| !h.waits).min_by(|a, b| a.promise.0.total_cmp(&b.promise.0));
        let Some(best) = best else { return };
        let Some(contact) = best.states.iter().find_map(|state| state.tip_on()) else { return };
        let places = alike(field, contact, best.map_from_odom);
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
            let late = self.dropped.0.iter().filter(|lost| lost.then + ROWS > used);
            let near = late.map(|lost| &lost.h).filter(|h| within(h, REACH));
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

/// Where a frame with a contact of the tip (piece and parameter) would stand if it were as far from other corners that are alike.
pub(super) fn alike(field: &Field<'_>, contact: (u32, f64), frame: Pose2) -> impl Iterator<Item = Pose2> {
    let spot = |(piece, at): (u32, f64)| field.ground.pieces[piece as usize].spot(at);
    let from = spot(contact);
    field.ground.as_far_from_corners(contact).into_iter().map(move |place| {
        let to = spot(place);
        let turn = to.normal - from.normal;
        let origin = to.position + (frame.position() - from.position).rotated(turn);
        Pose2::new(origin.x, origin.y, frame.theta + turn)
    })
}
