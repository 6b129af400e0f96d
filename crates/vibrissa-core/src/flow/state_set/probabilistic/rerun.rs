//! Running the history anew for a hypothesis from where it would be best, a share of the readings at a time.
//!
//! That is what costs most once hypotheses are tracked: a window of a thousand rows takes some milliseconds. So it takes as many
//! rows as it must, and what has been run so far waits in the hypothesis.

use super::bank::{LOOSE, cut};
use super::hypothesis::{Hypothesis, LOOKED_AT, Limits, Scene, moved};
use super::slide::Slide;
use super::twins::Track;
use core::ops::Range;

/// The parts of a step that are tried, and by how much each may make things worse (nats).
const SHARES: [f64; 2] = [1.0, 0.25];
const WORSE: f64 = 0.5;
/// So many rows are run before it is asked whether to go on where one is linearised anew, and what later rows may take back of
/// what it costs by then (nats).
const LOOKED_AT_AGAIN: usize = 16;
const EXPLAINED: f64 = 3.0;
/// So often a run that exceeds its limits begins anew from where the rows that it has come through lead, as long as it comes further every
/// time.
const LED: usize = 4;
/// What one that has been slid costs must be below its limits by this share of what it may cost more than usual.
const SPARE: f64 = 0.5;
/// It is slid by what the last rows say, of which there are at least so many, and only where it exceeds its limits no more than so many
/// rows before it was given up: before, a corner is not why.
const LOOKED_BACK: usize = 8;
const GIVEN_UP: usize = 32;

/// A hypothesis on its way through the rows that are used, a step or a part of it from where it is linearised.
#[derive(Clone, Debug)]
pub(super) struct Rerun {
    next: Hypothesis,
    step: [f64; 3],
    /// Which part of the step is tried.
    part: usize,
    /// How many of the used rows it has taken.
    done: usize,
    /// How often it has been moved on, and how many rows it had come through then.
    led: usize,
    reached: usize,
    /// As it was some rows ago, and some more, each with how many rows it had taken.
    before: [Option<(Box<Hypothesis>, usize)>; 2],
    /// Where its tip has been, wherever it began.
    track: Track,
    /// The search for a slide, and the used rows that are to be explained by it.
    slide: Option<(Box<Slide>, Range<usize>)>,
}

/// How far a run goes before it is looked at, how often it is led on from where it exceeds its limits, and whether it is slid then: to what
/// is below them by so much (nats).
#[derive(Clone, Copy)]
struct Lead {
    every: usize,
    times: usize,
    spare: Option<f64>,
}

impl Hypothesis {
    /// Linearises one that waits or was given up anew a step `d` away, or a part of it where the whole goes beyond the limits, and where
    /// it `slides`, slid to where it meets corners in time, with no more than this much work (readings); whether it is below them, and
    /// where its tip has been, once that is known. A run that is under way is gone on with.
    pub(super) fn revive(
        &mut self,
        scene: &Scene<'_>,
        d: [f64; 3],
        rows: &[usize],
        most: Limits<'_>,
        slides: bool,
        work: &mut usize,
    ) -> Option<(bool, Track)> {
        let exceeds = |cost: f64, done: usize| cost > most.usual[done - 1] + most.more;
        let lead = Lead { every: LOOKED_AT, times: LED, spare: slides.then_some(SPARE * most.more) };
        self.run_again(scene, d, rows, lead, &exceeds, work)
    }

    /// Linearises anew a step `d` away, or a part of it where the whole makes things worse, with no more than this much work
    /// (readings); whether that is finished. A run that is under way is gone on with.
    pub(super) fn improve(&mut self, scene: &Scene<'_>, d: [f64; 3], rows: &[usize], work: &mut usize) -> bool {
        let most = self.cost(scene.shared) + WORSE;
        // Costs only add up, but for what a shared error explains away later.
        let exceeds = |cost: f64, done: usize| cost > most + if done < rows.len() { EXPLAINED } else { 0.0 };
        let lead = Lead { every: LOOKED_AT_AGAIN, times: 0, spare: None };
        self.run_again(scene, d, rows, lead, &exceeds, work).is_some()
    }

    /// Goes on with a run through these rows until it is finished or the work is done; it takes the hypothesis' place unless it exceeds
    /// what is asked with its cost and the number of rows so far, after every so many of them.
    fn run_again(
        &mut self,
        scene: &Scene<'_>,
        d: [f64; 3],
        rows: &[usize],
        lead: Lead,
        exceeds: &dyn Fn(f64, usize) -> bool,
        work: &mut usize,
    ) -> Option<(bool, Track)> {
        let mut run = self.rerun.take().unwrap_or_else(|| Box::new(self.begin(scene, d, 0)));
        while run.done < rows.len() || run.slide.is_some() {
            if *work == 0 {
                self.rerun = Some(run);
                return None;
            }
            let led = if let Some((slide, those)) = &mut run.slide {
                if !slide.step(scene, &rows[those.clone()], work) {
                    continue;
                }
                run.slid(scene, lead, exceeds)
            } else {
                run.take(scene, rows, lead, work);
                if !exceeds(run.next.cost(scene.shared), run.done) {
                    continue;
                }
                let led = run.led_on(scene, lead, exceeds);
                // A corner is only why where it was given up lately.
                let lately = run.done + GIVEN_UP > rows.partition_point(|&row| row <= self.row);
                if led.is_none() && lately && run.begin_slide(scene, lead) {
                    continue;
                }
                led
            };
            if let Some(led) = led {
                *run = led;
                continue;
            }
            if run.led > 0 || run.part + 1 == SHARES.len() {
                self.age = 0;
                return Some((false, run.track));
            }
            *run = Rerun { track: run.track, ..self.begin(scene, run.step, run.part + 1) };
        }
        (run.next.age, run.next.rests) = (0, self.rests);
        *self = run.next;
        Some((true, run.track))
    }

    /// One that begins anew a part of a step away.
    fn begin(&self, scene: &Scene<'_>, step: [f64; 3], part: usize) -> Rerun {
        let mut next = self.clone();
        let to = moved(self.map_from_odom, scene.pivot, step.map(|v| SHARES[part] * v));
        next.run(scene, to, core::iter::empty());
        Rerun {
            next,
            step,
            part,
            done: 0,
            led: 0,
            reached: 0,
            before: [None, None],
            track: Track::Nowhere,
            slide: None,
        }
    }
}

impl Rerun {
    /// Takes some more rows.
    fn take(&mut self, scene: &Scene<'_>, rows: &[usize], lead: Lead, work: &mut usize) {
        if lead.spare.is_some() && self.before[1].as_ref().is_none_or(|(_, then)| self.done >= then + LOOKED_BACK) {
            self.before.swap(0, 1);
            self.before[1] = Some((Box::new(self.next.clone()), self.done));
        }
        let some = &rows[self.done..rows.len().min(self.done + lead.every)];
        for &row in some {
            self.next.take(scene, row);
            self.track.add(scene, &self.next);
        }
        self.done += some.len();
        *work = work.saturating_sub(some.len());
    }

    /// Whether it may begin anew elsewhere: it has come further than last time.
    fn may_be_led(&self, lead: Lead) -> bool {
        self.led < lead.times && self.done > self.reached
    }

    /// A run that begins anew this far from here.
    fn from(&self, scene: &Scene<'_>, d: [f64; 3]) -> Self {
        Self { led: self.led + 1, reached: self.done, track: self.track, ..self.next.begin(scene, d, 0) }
    }

    /// A run from where the rows that it has come through lead, if they are within the limits there.
    fn led_on(&self, scene: &Scene<'_>, lead: Lead, exceeds: &dyn Fn(f64, usize) -> bool) -> Option<Self> {
        // A step from an old linearisation goes only part of the way.
        let (promise, d) = self.next.best(LOOSE, scene.shared);
        (self.may_be_led(lead) && !exceeds(promise, self.done)).then(|| self.from(scene, cut(d)))
    }

    /// Begins to look for where the last rows are explained best, if that is asked for; whether it has.
    fn begin_slide(&mut self, scene: &Scene<'_>, lead: Lead) -> bool {
        if lead.spare.is_some()
            && self.may_be_led(lead)
            && let Some((before, then)) = self.before[0].take()
            && let Some(slide) = before.begin_slide(scene.shared)
        {
            self.slide = Some((Box::new(slide), then..self.done));
        }
        self.slide.is_some()
    }

    /// A run from where the last rows are explained best, if that is well within the limits.
    fn slid(&mut self, scene: &Scene<'_>, lead: Lead, exceeds: &dyn Fn(f64, usize) -> bool) -> Option<Self> {
        let (d, cost) = self.slide.take()?.0.found()?;
        (!exceeds(cost + lead.spare?, self.done)).then(|| self.from(scene, d))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

    use super::super::feeler::{Feeler, Judge};
    use super::super::history::History;
    use super::super::predicted_moments;
    use super::super::shares::Shared;
    use super::super::twins::Before;
    use super::*;
    use crate::beam::{TipModel, TipTable, Whisker};
    use crate::contact::follow::{Mechanics, WhiskerState};
    use crate::contact::{Boundaries, Sense};
    use crate::plane::{Curve, Pose2, Vec2};
    use crate::world::{Boundary, Map, Robot, Role};

    /// Calls this with a scene, its rows, and a hypothesis that is 0.4 mm from where they were felt.
    fn near_the_truth(then: impl Fn(&Scene<'_>, &[usize], Hypothesis)) {
        // Presses on the right wall with a lean.
        let pose = |s: f64| Pose2::new(0.11 + 0.3 * s, -0.03 + 0.4 * s, -0.5 + s);
        along(&(0..90).map(|k| pose(f64::from(k) * 1e-3)).collect::<Vec<_>>(), |scene, rows, h| {
            assert!(h.states.iter().all(|state| matches!(state, WhiskerState::Touching(_))), "{:?}", h.states);
            then(scene, rows, h);
        });
    }

    /// The same for the path of a robot in a room.
    fn along(path: &[Pose2], then: impl Fn(&Scene<'_>, &[usize], Hypothesis)) {
        let corners = [(-0.2, -0.1), (0.2, -0.1), (0.2, 0.1), (-0.2, 0.1)].map(|(x, y)| Vec2::new(x, y));
        let walls = Boundary::new(Role::Arena, Curve::polyline(&corners, true).unwrap(), None).unwrap();
        let map = Map::new(vec![walls]).unwrap();
        let tip = TipModel::new(&Whisker::default()).unwrap();
        let (ground, table) = (Boundaries::new(&map).with_clearance(&map), TipTable::new());
        let feelers = [Feeler::new(&Robot::default().whiskers[0], tip.clone(), Sense::Moment)];
        let mut history = History::new(&feelers);
        for (pose, felt) in path.iter().zip(predicted_moments(&map, &tip, path)) {
            history.push(path[0].between(*pose), &[felt.moment * feelers[0].per_reading]);
        }
        let scene = Scene {
            solver: Mechanics::Table(&table),
            map: &map,
            ground: &ground,
            feelers: &feelers,
            history: &history,
            pivot: Vec2::ZERO,
            judge: Judge::FAIR,
            shared: Shared { gain: 0.01, ..Shared::default() },
            blur: false,
            whole: true,
            heading_std: 1.0,
        };
        let rows: Vec<usize> = (0..path.len()).collect();
        let mut h = Hypothesis::new(path[0], vec![WhiskerState::Free], 0);
        h.run(&scene, moved(path[0], scene.pivot, [4e-4, 1e-4, 1e-3]), rows.iter().copied());
        then(&scene, &rows, h);
    }

    #[test]
    fn a_run_in_shares_ends_where_one_at_once_does() {
        near_the_truth(|scene, rows, h| {
            let (_, d) = h.best(LOOSE, scene.shared);
            let mut whole = h.clone();
            assert!(whole.improve(scene, d, rows, &mut usize::MAX.clone()));
            assert!(whole.cost(scene.shared) < h.cost(scene.shared) - 1.0);
            for share in [1, 7, 16, 40] {
                let mut part = h.clone();
                let mut calls = 1;
                while !part.improve(scene, d, rows, &mut share.clone()) {
                    assert_eq!(part.map_from_odom, h.map_from_odom, "it stays where it is until the run is finished");
                    calls += 1;
                }
                assert!(calls > 1 && calls <= rows.len(), "{calls}");
                assert_eq!((part.map_from_odom, part.belief), (whole.map_from_odom, whole.belief));
                assert!(part.rerun.is_none() && part.age == 0);
            }
        });
    }

    #[test]
    fn rows_that_come_meanwhile_are_taken_too() {
        near_the_truth(|scene, rows, h| {
            let mut early = h.clone();
            early.run(scene, h.map_from_odom, rows[..60].iter().copied());
            let (_, d) = early.best(LOOSE, scene.shared);
            assert!(!early.improve(scene, d, &rows[..60], &mut 32));
            rows[60..].iter().for_each(|&row| early.take(scene, row));
            assert!(early.improve(scene, d, rows, &mut 1000));
            let mut whole = h.clone();
            whole.run(scene, early.map_from_odom, rows.iter().copied());
            assert!((early.cost(scene.shared) - whole.cost(scene.shared)).abs() < 1e-9);
            assert_eq!(early.row, rows[rows.len() - 1]);
        });
    }

    #[test]
    fn rows_that_are_come_through_lead_on() {
        near_the_truth(|scene, rows, h| {
            // Linearised by the first rows only and far off, where one step goes only part of the way.
            let usual = h.costs(scene, rows);
            let limits = Limits { usual: &usual, more: 10.0 };
            for off in [[0.0, 0.0, 0.06], [0.0, -5e-4, 0.04]] {
                let mut far = h.clone();
                far.run(scene, moved(h.map_from_odom, scene.pivot, off), rows[..40].iter().copied());
                let (_, d) = far.best(LOOSE, scene.shared);
                assert!(!far.clone().run_below(scene, moved(far.map_from_odom, scene.pivot, cut(d)), rows, limits));
                let mut whole = far.clone();
                assert!(whole.revive(scene, cut(d), rows, limits, false, &mut usize::MAX.clone()).unwrap().0);
                assert!(whole.cost(scene.shared) <= usual[rows.len() - 1] + limits.more);
                // The same a few readings at a time.
                while far.revive(scene, cut(d), rows, limits, false, &mut 5).is_none() {}
                assert_eq!(far.map_from_odom, whole.map_from_odom);
            }
        });
    }

    #[test]
    fn a_place_along_a_wall_is_slid_to_where_it_meets_the_corner_in_time() {
        // The tip goes ahead up the right wall, about which nothing but the wall at its end tells where, and into the corner.
        let pose = |s: f64| Pose2::new(0.12 + 0.3 * s.min(0.08), -0.03 + s, 0.5);
        let path: Vec<Pose2> = (0..110).map(|k| pose(f64::from(k) * 1e-3)).collect();
        along(&path, |scene, rows, h| {
            let mut truth = h.clone();
            truth.run(scene, path[0], core::iter::empty());
            let mut on = Vec::new();
            for &row in rows {
                truth.take(scene, row);
                on.push(truth.states[0].tip_on().map(|(piece, _)| piece));
            }
            let wall = on.iter().flatten().next().copied();
            let corner = on.iter().rposition(|&piece| piece == wall).unwrap();
            assert!(wall.is_some() && corner + 12 < rows.len(), "{on:?}");
            let (before, after) = rows.split_at(corner - 6);
            for off in [1.9e-3, -2.4e-3] {
                let mut early = h.clone();
                early.run(scene, moved(path[0], scene.pivot, [0.0, off, 0.0]), before.iter().copied());
                let best_slide = |h: &Hypothesis, rows: &[usize]| {
                    let mut slide = h.clone().begin_slide(scene.shared).unwrap();
                    let mut work = 10_000;
                    while !slide.step(scene, rows, &mut work) {}
                    assert!(work <= 10_000 - 3 * rows.len() && work > 10_000 - 20 * rows.len(), "{work}");
                    slide.found()
                };
                let (d, cost) = best_slide(&early, &after[..16]).unwrap();
                assert!((d[1] + off).abs() < 0.5e-3 && d[0].abs() < 2e-4, "{d:?} for {off}");
                let mut here = early.clone();
                after[..16].iter().for_each(|&row| here.take(scene, row));
                assert!(cost < here.cost(scene.shared) - 2.0, "{cost} {}", here.cost(scene.shared));
                // Where nothing changes nothing is slid.
                let mut earlier = h.clone();
                earlier.run(scene, early.map_from_odom, before[..corner - 18].iter().copied());
                assert!(earlier.is_open(scene.shared));
                assert!(best_slide(&earlier, &before[corner - 18..corner - 14]).is_none());
            }
        });
    }

    #[test]
    fn along_a_straight_wall_others_come_to_the_same() {
        near_the_truth(|scene, rows, h| {
            let usual = h.costs(scene, rows);
            let limits = Limits { usual: &usual, more: 30.0 };
            let off = |d: [f64; 3]| {
                let mut there = h.clone();
                there.run(scene, moved(h.map_from_odom, scene.pivot, d), rows.iter().copied());
                there.look(LOOSE, scene.shared);
                there
            };
            let one = off([3e-4, 0.0, 0.02]);
            let (before, mut outcome) = (Before::of(&one), one.clone());
            let (alive, track) =
                outcome.revive(scene, one.promise.1, rows, limits, false, &mut usize::MAX.clone()).unwrap();
            assert!(alive && matches!(track, Track::On(..)), "{track:?}");
            for along in [0.013, -0.02, 0.031] {
                let other = off([3e-4, along, 0.02]);
                let told = before.at(scene.ground, track, &outcome, &other).unwrap();
                let mut wanted = other.clone();
                wanted.revive(scene, other.promise.1, rows, limits, false, &mut usize::MAX.clone());
                let apart = told.map_from_odom.position().distance(wanted.map_from_odom.position());
                assert!(apart < 1e-9 && (told.map_from_odom.theta - wanted.map_from_odom.theta).abs() < 1e-9);
                assert!((told.cost(scene.shared) - wanted.cost(scene.shared)).abs() < 1e-6);
                let places = [&told, &wanted].map(|h| h.states[0].on_piece().unwrap());
                assert!(places[0].0 == places[1].0 && (places[0].1 - places[1].1).abs() < 1e-6, "{places:?}");
            }
            // Not beyond the wall's end, at another angle, or off the wall.
            for d in [[3e-4, 0.2, 0.02], [3e-4, 0.01, 0.021], [4e-4, 0.01, 0.02]] {
                assert!(before.at(scene.ground, track, &outcome, &off(d)).is_none(), "{d:?}");
            }
        });
    }

    #[test]
    fn one_that_waits_keeps_what_it_costs() {
        near_the_truth(|scene, _, mut h| {
            h.look(LOOSE, scene.shared);
            let (cost, d) = h.promise;
            h.waits = true;
            h.promise = (cost + 40.0, [0.0; 3]);
            h.look(LOOSE, scene.shared);
            assert_eq!(h.promise, (cost + 40.0, d));
        });
    }

    #[test]
    fn what_makes_things_worse_is_not_kept() {
        near_the_truth(|scene, rows, h| {
            let mut kept = h.clone();
            assert!(kept.improve(scene, [0.02, -0.01, 0.3], rows, &mut 1000));
            assert_eq!((kept.map_from_odom, kept.belief), (h.map_from_odom, h.belief));
            let usual = vec![0.0; rows.len()];
            let mut lost = h.clone();
            lost.waits = true;
            let limits = |more: f64| Limits { usual: &usual, more };
            assert_eq!(
                lost.revive(scene, [0.0; 3], rows, limits(-1.0), false, &mut 1000).map(|(alive, _)| alive),
                Some(false)
            );
            assert_eq!(lost.revive(scene, [0.0; 3], rows, limits(1e3), false, &mut 10).map(|(alive, _)| alive), None);
            assert_eq!(
                lost.revive(scene, [0.0; 3], rows, limits(1e3), false, &mut 1000).map(|(alive, _)| alive),
                Some(true)
            );
            assert!(!lost.waits);
        });
    }
}
