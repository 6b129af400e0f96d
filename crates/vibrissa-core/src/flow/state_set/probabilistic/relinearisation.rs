//! Relinearisation of a hypothesis around its estimate, a share of the readings at a time \[kaess2012isam2\].
//!
//! That is what costs most once hypotheses are tracked: a window of a thousand rows takes some milliseconds. So it takes as many
//! rows as it must, and what has been run so far waits in the hypothesis.

use super::bank::{DAMPING, trust_region_step};
use super::hypothesis::{CHECK_EVERY, CostLimits, GaussianHypothesis, MeasurementModel, moved};
use super::line_search::LineSearch;
use super::shared_runs::ContactTrack;
use core::ops::Range;

/// The parts of a step that are tried, and by how much each may make things worse (nats).
const STEP_FRACTIONS: [f64; 2] = [1.0, 0.25];
const WORSE: f64 = 0.5;
/// So many rows are run before it is asked whether to go on where one is relinearised, and what later rows may take back of
/// what it costs by then (nats).
const CHECK_RELINEARISATION_EVERY: usize = 16;
const EXPLAINED: f64 = 3.0;
/// So often a run that exceeds its limits begins anew from where the rows that it has come through lead, as long as it comes further every
/// time.
const MOST_RESTARTS: usize = 4;
/// What one that has been slid costs must be below its limits by this share of what it may cost more than usual.
const SPARE: f64 = 0.5;
/// It is slid by what the last rows say, of which there are at least so many, and only where it exceeds its limits no more than so many
/// rows before it was given up: before, a corner is not why.
const LOOKED_BACK: usize = 8;
const GIVEN_UP: usize = 32;

/// A hypothesis on its way through the rows that are used, a step or a part of it from where it is linearised.
#[derive(Clone, Debug)]
pub(super) struct Relinearisation {
    next: GaussianHypothesis,
    step: [f64; 3],
    /// Which part of the step is tried.
    part: usize,
    /// How many of the used rows it has taken.
    done: usize,
    /// How often it has been moved on, and how many rows it had come through then.
    restarts: usize,
    reached: usize,
    /// As it was some rows ago, and some more, each with how many rows it had taken.
    before: [Option<(Box<GaussianHypothesis>, usize)>; 2],
    /// Where its tip has been, wherever it began.
    track: ContactTrack,
    /// The search for a slide, and the used rows that are to be explained by it.
    line_search: Option<(Box<LineSearch>, Range<usize>)>,
}

/// How far a run goes before it is looked at, how often it is led on from where it exceeds its limits, and whether it is slid then: to what
/// is below them by so much (nats).
#[derive(Clone, Copy)]
struct RestartPolicy {
    every: usize,
    times: usize,
    spare: Option<f64>,
}

impl GaussianHypothesis {
    /// Linearises one that waits or was given up anew a step `d` away, or a part of it where the whole goes beyond the limits, and where
    /// it `with_line_search`, slid to where it meets corners in time, with no more than this much work (readings); whether it is below them, and
    /// where its tip has been, once that is known. A run that is under way is gone on with.
    pub(super) fn retry(
        &mut self,
        model: &MeasurementModel<'_>,
        d: [f64; 3],
        rows: &[usize],
        most: CostLimits<'_>,
        with_line_search: bool,
        work: &mut usize,
    ) -> Option<(bool, ContactTrack)> {
        let exceeds = |cost: f64, done: usize| cost > most.reference_costs[done - 1] + most.more;
        let policy = RestartPolicy {
            every: CHECK_EVERY,
            times: MOST_RESTARTS,
            spare: with_line_search.then_some(SPARE * most.more),
        };
        self.continue_run(model, d, rows, policy, &exceeds, work)
    }

    /// Relinearises a step `d` away, or a part of it where the whole makes things worse, with no more than this much work
    /// (readings); whether that is finished. A run that is under way is gone on with.
    pub(super) fn relinearise_step(
        &mut self,
        model: &MeasurementModel<'_>,
        d: [f64; 3],
        rows: &[usize],
        work: &mut usize,
    ) -> bool {
        let most = self.cost(model.shared) + WORSE;
        // Costs only add up, but for what a shared error explains away later.
        let exceeds = |cost: f64, done: usize| cost > most + if done < rows.len() { EXPLAINED } else { 0.0 };
        let policy = RestartPolicy { every: CHECK_RELINEARISATION_EVERY, times: 0, spare: None };
        self.continue_run(model, d, rows, policy, &exceeds, work).is_some()
    }

    /// Goes on with a run through these rows until it is finished or the work is done; it takes the hypothesis' place unless it exceeds
    /// what is asked with its cost and the number of rows so far, after every so many of them.
    fn continue_run(
        &mut self,
        model: &MeasurementModel<'_>,
        d: [f64; 3],
        rows: &[usize],
        policy: RestartPolicy,
        exceeds: &dyn Fn(f64, usize) -> bool,
        work: &mut usize,
    ) -> Option<(bool, ContactTrack)> {
        let mut run = self.relinearisation.take().unwrap_or_else(|| Box::new(self.begin(model, d, 0)));
        while run.done < rows.len() || run.line_search.is_some() {
            if *work == 0 {
                self.relinearisation = Some(run);
                return None;
            }
            let led = if let Some((line_search, those)) = &mut run.line_search {
                if !line_search.step(model, &rows[those.clone()], work) {
                    continue;
                }
                run.restarted_by_line_search(model, policy, exceeds)
            } else {
                run.add_rows(model, rows, policy, work);
                if !exceeds(run.next.cost(model.shared), run.done) {
                    continue;
                }
                let led = run.restarted(model, policy, exceeds);
                // A corner is only why where it was given up lately.
                let lately = run.done + GIVEN_UP > rows.partition_point(|&row| row <= self.row);
                if led.is_none() && lately && run.begin_line_search(model, policy) {
                    continue;
                }
                led
            };
            if let Some(led) = led {
                *run = led;
                continue;
            }
            if run.restarts > 0 || run.part + 1 == STEP_FRACTIONS.len() {
                self.age = 0;
                return Some((false, run.track));
            }
            *run = Relinearisation { track: run.track, ..self.begin(model, run.step, run.part + 1) };
        }
        (run.next.age, run.next.cooldown) = (0, self.cooldown);
        *self = run.next;
        Some((true, run.track))
    }

    /// One that begins anew a part of a step away.
    fn begin(&self, model: &MeasurementModel<'_>, step: [f64; 3], part: usize) -> Relinearisation {
        let mut next = self.clone();
        let to = moved(self.map_from_odom, model.pivot, step.map(|v| STEP_FRACTIONS[part] * v));
        next.relinearise(model, to, core::iter::empty());
        Relinearisation {
            next,
            step,
            part,
            done: 0,
            restarts: 0,
            reached: 0,
            before: [None, None],
            track: ContactTrack::Nowhere,
            line_search: None,
        }
    }
}

impl Relinearisation {
    /// Takes some more rows.
    fn add_rows(&mut self, model: &MeasurementModel<'_>, rows: &[usize], policy: RestartPolicy, work: &mut usize) {
        if policy.spare.is_some() && self.before[1].as_ref().is_none_or(|(_, then)| self.done >= then + LOOKED_BACK) {
            self.before.swap(0, 1);
            self.before[1] = Some((Box::new(self.next.clone()), self.done));
        }
        let some = &rows[self.done..rows.len().min(self.done + policy.every)];
        for &row in some {
            self.next.add_row(model, row);
            self.track.add(model, &self.next);
        }
        self.done += some.len();
        *work = work.saturating_sub(some.len());
    }

    /// Whether it may begin anew elsewhere: it has come further than last time.
    fn may_restart(&self, policy: RestartPolicy) -> bool {
        self.restarts < policy.times && self.done > self.reached
    }

    /// A run that begins anew this far from here.
    fn from(&self, model: &MeasurementModel<'_>, d: [f64; 3]) -> Self {
        Self { restarts: self.restarts + 1, reached: self.done, track: self.track, ..self.next.begin(model, d, 0) }
    }

    /// A run from where the rows that it has come through lead, if they are within the limits there.
    fn restarted(
        &self,
        model: &MeasurementModel<'_>,
        policy: RestartPolicy,
        exceeds: &dyn Fn(f64, usize) -> bool,
    ) -> Option<Self> {
        // A step from an old linearisation goes only part of the way.
        let (predicted, d) = self.next.damped_step(DAMPING, model.shared);
        (self.may_restart(policy) && !exceeds(predicted, self.done)).then(|| self.from(model, trust_region_step(d)))
    }

    /// Begins to look for where the last rows are explained best, if that is asked for; whether it has.
    fn begin_line_search(&mut self, model: &MeasurementModel<'_>, policy: RestartPolicy) -> bool {
        if policy.spare.is_some()
            && self.may_restart(policy)
            && let Some((before, then)) = self.before[0].take()
            && let Some(line_search) = before.begin_line_search(model.shared)
        {
            self.line_search = Some((Box::new(line_search), then..self.done));
        }
        self.line_search.is_some()
    }

    /// A run from where the last rows are explained best, if that is well within the limits.
    fn restarted_by_line_search(
        &mut self,
        model: &MeasurementModel<'_>,
        policy: RestartPolicy,
        exceeds: &dyn Fn(f64, usize) -> bool,
    ) -> Option<Self> {
        let (d, cost) = self.line_search.take()?.0.found()?;
        (!exceeds(cost + policy.spare?, self.done)).then(|| self.from(model, d))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

    use super::super::calibrated_path::CalibrationPrior;
    use super::super::log_window::LogWindow;
    use super::super::predicted_moments;
    use super::super::sensor::{LikelihoodOptions, Sensor};
    use super::super::shared_runs::RunKey;
    use super::*;
    use crate::beam::{TipModel, TipTable, Whisker};
    use crate::contact::follow::{Mechanics, WhiskerState};
    use crate::contact::{Boundaries, SensedQuantity};
    use crate::plane::{Curve, Pose2, Vec2};
    use crate::world::{Boundary, Map, Robot, Role};

    /// Calls this with a scene, its rows, and a hypothesis that is 0.4 mm from where they were felt.
    fn near_the_truth(then: impl Fn(&MeasurementModel<'_>, &[usize], GaussianHypothesis)) {
        // Presses on the right wall with a lean.
        let pose = |s: f64| Pose2::new(0.11 + 0.3 * s, -0.03 + 0.4 * s, -0.5 + s);
        along(&(0..90).map(|k| pose(f64::from(k) * 1e-3)).collect::<Vec<_>>(), |model, rows, h| {
            assert!(h.states.iter().all(|state| matches!(state, WhiskerState::Touching(_))), "{:?}", h.states);
            then(model, rows, h);
        });
    }

    /// The same for the path of a robot in a room.
    fn along(path: &[Pose2], then: impl Fn(&MeasurementModel<'_>, &[usize], GaussianHypothesis)) {
        let corners = [(-0.2, -0.1), (0.2, -0.1), (0.2, 0.1), (-0.2, 0.1)].map(|(x, y)| Vec2::new(x, y));
        let walls = Boundary::new(Role::Arena, Curve::polyline(&corners, true).unwrap(), None).unwrap();
        let map = Map::new(vec![walls]).unwrap();
        let tip = TipModel::new(&Whisker::default()).unwrap();
        let (ground, table) = (Boundaries::new(&map).with_clearance(&map), TipTable::new());
        let sensors = [Sensor::new(&Robot::default().whiskers[0], tip.clone(), SensedQuantity::Moment)];
        let mut history = LogWindow::new(&sensors);
        for (pose, felt) in path.iter().zip(predicted_moments(&map, &tip, path)) {
            history.push(path[0].between(*pose), &[felt.moment * sensors[0].per_reading]);
        }
        let model = MeasurementModel {
            solver: Mechanics::Table(&table),
            map: &map,
            ground: &ground,
            sensors: &sensors,
            history: &history,
            pivot: Vec2::ZERO,
            likelihood: LikelihoodOptions::DECLARED,
            shared: CalibrationPrior { gain: 0.01, ..CalibrationPrior::default() },
            model_error: false,
            whole: true,
            heading_std: 1.0,
        };
        let rows: Vec<usize> = (0..path.len()).collect();
        let mut h = GaussianHypothesis::new(path[0], vec![WhiskerState::Free], 0);
        h.relinearise(&model, moved(path[0], model.pivot, [4e-4, 1e-4, 1e-3]), rows.iter().copied());
        then(&model, &rows, h);
    }

    #[test]
    fn a_run_in_shares_ends_where_one_at_once_does() {
        near_the_truth(|model, rows, h| {
            let (_, d) = h.damped_step(DAMPING, model.shared);
            let mut whole = h.clone();
            assert!(whole.relinearise_step(model, d, rows, &mut usize::MAX.clone()));
            assert!(whole.cost(model.shared) < h.cost(model.shared) - 1.0);
            for share in [1, 7, 16, 40] {
                let mut part = h.clone();
                let mut calls = 1;
                while !part.relinearise_step(model, d, rows, &mut share.clone()) {
                    assert_eq!(part.map_from_odom, h.map_from_odom, "it stays where it is until the run is finished");
                    calls += 1;
                }
                assert!(calls > 1 && calls <= rows.len(), "{calls}");
                assert_eq!((part.map_from_odom, part.belief), (whole.map_from_odom, whole.belief));
                assert!(part.relinearisation.is_none() && part.age == 0);
            }
        });
    }

    #[test]
    fn rows_that_come_meanwhile_are_taken_too() {
        near_the_truth(|model, rows, h| {
            let mut early = h.clone();
            early.relinearise(model, h.map_from_odom, rows[..60].iter().copied());
            let (_, d) = early.damped_step(DAMPING, model.shared);
            assert!(!early.relinearise_step(model, d, &rows[..60], &mut 32));
            rows[60..].iter().for_each(|&row| early.add_row(model, row));
            assert!(early.relinearise_step(model, d, rows, &mut 1000));
            let mut whole = h.clone();
            whole.relinearise(model, early.map_from_odom, rows.iter().copied());
            assert!((early.cost(model.shared) - whole.cost(model.shared)).abs() < 1e-9);
            assert_eq!(early.row, rows[rows.len() - 1]);
        });
    }

    #[test]
    fn rows_that_are_come_through_lead_on() {
        near_the_truth(|model, rows, h| {
            // Linearised by the first rows only and far off, where one step goes only part of the way.
            let reference_costs = h.costs(model, rows);
            let limits = CostLimits { reference_costs: &reference_costs, more: 10.0 };
            for off in [[0.0, 0.0, 0.06], [0.0, -5e-4, 0.04]] {
                let mut far = h.clone();
                far.relinearise(model, moved(h.map_from_odom, model.pivot, off), rows[..40].iter().copied());
                let (_, d) = far.damped_step(DAMPING, model.shared);
                assert!(!far.clone().relinearise_below(
                    model,
                    moved(far.map_from_odom, model.pivot, trust_region_step(d)),
                    rows,
                    limits
                ));
                let mut whole = far.clone();
                assert!(
                    whole.retry(model, trust_region_step(d), rows, limits, false, &mut usize::MAX.clone()).unwrap().0
                );
                assert!(whole.cost(model.shared) <= reference_costs[rows.len() - 1] + limits.more);
                // The same a few readings at a time.
                while far.retry(model, trust_region_step(d), rows, limits, false, &mut 5).is_none() {}
                assert_eq!(far.map_from_odom, whole.map_from_odom);
            }
        });
    }

    #[test]
    fn a_place_along_a_wall_is_slid_to_where_it_meets_the_corner_in_time() {
        // The tip goes ahead up the right wall, about which nothing but the wall at its end tells where, and into the corner.
        let pose = |s: f64| Pose2::new(0.12 + 0.3 * s.min(0.08), -0.03 + s, 0.5);
        let path: Vec<Pose2> = (0..110).map(|k| pose(f64::from(k) * 1e-3)).collect();
        along(&path, |model, rows, h| {
            let mut truth = h.clone();
            truth.relinearise(model, path[0], core::iter::empty());
            let mut on = Vec::new();
            for &row in rows {
                truth.add_row(model, row);
                on.push(truth.states[0].tip_on().map(|(piece, _)| piece));
            }
            let wall = on.iter().flatten().next().copied();
            let corner = on.iter().rposition(|&piece| piece == wall).unwrap();
            assert!(wall.is_some() && corner + 12 < rows.len(), "{on:?}");
            let (before, after) = rows.split_at(corner - 6);
            for off in [1.9e-3, -2.4e-3] {
                let mut early = h.clone();
                early.relinearise(model, moved(path[0], model.pivot, [0.0, off, 0.0]), before.iter().copied());
                let best_slide = |h: &GaussianHypothesis, rows: &[usize]| {
                    let mut line_search = h.clone().begin_line_search(model.shared).unwrap();
                    let mut work = 10_000;
                    while !line_search.step(model, rows, &mut work) {}
                    assert!(work <= 10_000 - 3 * rows.len() && work > 10_000 - 20 * rows.len(), "{work}");
                    line_search.found()
                };
                let (d, cost) = best_slide(&early, &after[..16]).unwrap();
                assert!((d[1] + off).abs() < 0.5e-3 && d[0].abs() < 2e-4, "{d:?} for {off}");
                let mut here = early.clone();
                after[..16].iter().for_each(|&row| here.add_row(model, row));
                assert!(cost < here.cost(model.shared) - 2.0, "{cost} {}", here.cost(model.shared));
                // Where nothing changes nothing is slid.
                let mut earlier = h.clone();
                earlier.relinearise(model, early.map_from_odom, before[..corner - 18].iter().copied());
                assert!(earlier.has_unobservable_direction(model.shared));
                assert!(best_slide(&earlier, &before[corner - 18..corner - 14]).is_none());
            }
        });
    }

    #[test]
    fn along_a_straight_wall_others_come_to_the_same() {
        near_the_truth(|model, rows, h| {
            let reference_costs = h.costs(model, rows);
            let limits = CostLimits { reference_costs: &reference_costs, more: 30.0 };
            let off = |d: [f64; 3]| {
                let mut there = h.clone();
                there.relinearise(model, moved(h.map_from_odom, model.pivot, d), rows.iter().copied());
                there.update_prediction(DAMPING, model.shared);
                there
            };
            let one = off([3e-4, 0.0, 0.02]);
            let (before, mut outcome) = (RunKey::of(&one), one.clone());
            let (alive, track) =
                outcome.retry(model, one.predicted.1, rows, limits, false, &mut usize::MAX.clone()).unwrap();
            assert!(alive && matches!(track, ContactTrack::On(..)), "{track:?}");
            for along in [0.013, -0.02, 0.031] {
                let other = off([3e-4, along, 0.02]);
                let told = before.at(model.ground, track, &outcome, &other).unwrap();
                let mut wanted = other.clone();
                wanted.retry(model, other.predicted.1, rows, limits, false, &mut usize::MAX.clone());
                let apart = told.map_from_odom.position().distance(wanted.map_from_odom.position());
                assert!(apart < 1e-9 && (told.map_from_odom.theta - wanted.map_from_odom.theta).abs() < 1e-9);
                assert!((told.cost(model.shared) - wanted.cost(model.shared)).abs() < 1e-6);
                let places = [&told, &wanted].map(|h| h.states[0].on_piece().unwrap());
                assert!(places[0].0 == places[1].0 && (places[0].1 - places[1].1).abs() < 1e-6, "{places:?}");
            }
            // Not beyond the wall's end, at another angle, or off the wall.
            for d in [[3e-4, 0.2, 0.02], [3e-4, 0.01, 0.021], [4e-4, 0.01, 0.02]] {
                assert!(before.at(model.ground, track, &outcome, &off(d)).is_none(), "{d:?}");
            }
        });
    }

    #[test]
    fn one_that_waits_keeps_what_it_costs() {
        near_the_truth(|model, _, mut h| {
            h.update_prediction(DAMPING, model.shared);
            let (cost, d) = h.predicted;
            h.is_pending = true;
            h.predicted = (cost + 40.0, [0.0; 3]);
            h.update_prediction(DAMPING, model.shared);
            assert_eq!(h.predicted, (cost + 40.0, d));
        });
    }

    #[test]
    fn what_makes_things_worse_is_not_kept() {
        near_the_truth(|model, rows, h| {
            let mut kept = h.clone();
            assert!(kept.relinearise_step(model, [0.02, -0.01, 0.3], rows, &mut 1000));
            assert_eq!((kept.map_from_odom, kept.belief), (h.map_from_odom, h.belief));
            let reference_costs = vec![0.0; rows.len()];
            let mut lost = h.clone();
            lost.is_pending = true;
            let limits = |more: f64| CostLimits { reference_costs: &reference_costs, more };
            assert_eq!(
                lost.retry(model, [0.0; 3], rows, limits(-1.0), false, &mut 1000).map(|(alive, _)| alive),
                Some(false)
            );
            assert_eq!(lost.retry(model, [0.0; 3], rows, limits(1e3), false, &mut 10).map(|(alive, _)| alive), None);
            assert_eq!(
                lost.retry(model, [0.0; 3], rows, limits(1e3), false, &mut 1000).map(|(alive, _)| alive),
                Some(true)
            );
            assert!(!lost.is_pending);
        });
    }
}
