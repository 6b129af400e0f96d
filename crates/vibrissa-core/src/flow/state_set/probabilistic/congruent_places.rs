//! Congruent places: the best place's contact, moved to every other place of the boundary where the predictions agree.
//!
//! A search that starts from cells can miss one of several places that are congruent, or lose it where a wall ends. With
//! one place fitted, its equals are found directly: the frame is moved so that a contact which it has made lies on each
//! other place of the boundary in turn, at the same angle, and few of the rows tell whether it feels the same there.

use super::bank::{BankContext, DAMPING, HypothesisBank};
use super::grid_search::for_each_place;
use super::hypothesis::{CostLimits, GaussianHypothesis, MeasurementModel, difference, moved};
use super::log_window::LogWindow;
use super::sensor::LikelihoodOptions;
use crate::plane::{Pose2, Vec2};

/// Spacing of the places (m).
const SPACING: f64 = 2e-3;
/// On straight pieces longer than this (m) one place of so many will do.
const LONG: f64 = 30e-3;
const FEWER: usize = 3;
/// So many places that the tip has touched must lie on boundaries, too, give or take so much (m, and m for each metre from
/// the contact that was moved, since its angle is that of a facet).
const TOUCHED: usize = 8;
const OFF: [f64; 2] = [2e-3, 0.05];
/// Rows that tell, how much larger their standard deviations are taken, since a place is up to half a spacing off, and the
/// cost (nats) above which a place is left.
const ROWS: usize = 24;
const STD_INFLATION: f64 = 3.0;
const MOST_COST: f64 = 40.0;
/// The same once it has been moved to where its cost is least, above the cost of the best.
const MOST_MORE: f64 = 8.0;
/// So many places are fitted, with standard deviations enlarged so much at first; and how far apart they are (m, rad).
const FITTED: usize = 16;
const STD_INFLATIONS: [f64; 3] = [3.0, 2.0, 1.5];
const APART: [f64; 2] = [4e-3, 0.05];
/// What is no costlier than the best by more than this (nats) is not looked for again.
const KNOWN: f64 = 2.0;
/// Rows of the first fit, and its rounds.
const SOME: usize = 48;
const FIRST_ROUNDS: usize = 4;
/// Rounds of the fit, and how much costlier than the best a place may be after it (nats).
const ROUNDS: usize = 8;
const REPORTED: f64 = 30.0;

/// Hypotheses at places that feel like the best one's, fitted to the bank's rows; none where the log began in contact or its
/// first rows have been marginalised.
pub(super) fn congruent_places(
    bank: &HypothesisBank,
    context: &BankContext<'_>,
    history: &LogWindow,
) -> Vec<GaussianHypothesis> {
    let best = bank.hypotheses.iter().min_by(|a, b| a.cost(bank.shared).total_cmp(&b.cost(bank.shared)));
    let Some(best) = best.filter(|h| h.starts_free() && !bank.has_marginalised()) else { return Vec::new() };
    let rows: Vec<usize> = bank.used.iter().copied().step_by(bank.used.len().div_ceil(ROWS).max(1)).collect();
    let likelihood = LikelihoodOptions { std_inflation: STD_INFLATION, outlier_cost: f64::INFINITY };
    let model = context.model(history, bank.pivot, likelihood, bank.shared);
    let touched = contacts(best, &model, &bank.used);
    let Some(&(piece, at)) = touched.get(touched.len() / 2) else { return Vec::new() };
    let some = touched.iter().step_by(touched.len().div_ceil(TOUCHED));
    let touched: Vec<Vec2> = some.map(|&(piece, at)| context.ground.pieces[piece as usize].spot(at).position).collect();
    let mut own = best.clone();
    own.relinearise(&model, best.map_from_odom, rows.iter().copied());
    let most = own.damped_step(DAMPING, bank.shared).0;
    let reference_costs = own.costs(&model, &rows);
    let limits = CostLimits { reference_costs: &reference_costs, more: MOST_COST };
    let from = context.ground.pieces[piece as usize].spot(at);
    let mut found: Vec<GaussianHypothesis> = Vec::new();
    let mut look_at = |piece: u32, at: f64| {
        let spot = context.ground.pieces[piece as usize].spot(at);
        if bank.by_symmetry && !context.symmetries.is_representative(spot.position) {
            return;
        }
        let turn = spot.normal - from.normal;
        let place = spot.position + (best.map_from_odom.position() - from.position).rotated(turn);
        let frame = Pose2::new(place.x, place.y, best.map_from_odom.theta + turn);
        let lies = |place: &Vec2| {
            let arm = *place - from.position;
            let reach = OFF[0] + OFF[1] * arm.norm();
            context.map.nearest_within(spot.position + arm.rotated(turn), reach).is_some()
        };
        if !touched.iter().all(lies)
            || !context.satisfies_prior(history, frame)
            || !is_free_throughout(context, history, frame, &rows)
        {
            return;
        }
        let mut there = best.clone();
        if there.relinearise_below(&model, frame, &rows, limits) {
            there.update_prediction(DAMPING, bank.shared);
            if there.predicted.0 <= most + MOST_MORE {
                found.push(there);
            }
        }
    };
    let mut count = 0;
    for_each_place(&context.ground.pieces, SPACING, |piece, at| {
        let here = &context.ground.pieces[piece as usize];
        count += 1;
        if !here.is_straight() || here.length() <= LONG || count % FEWER == 0 {
            look_at(piece, at);
        }
    });
    context.ground.as_far_from_corners((piece, at)).into_iter().for_each(|(piece, at)| look_at(piece, at));
    found.sort_by(|a, b| a.predicted.0.total_cmp(&b.predicted.0));
    fitted(bank, context, history, &rows, apart(found, bank, context))
}

/// The contacts of the tip: pieces and parameters.
pub(super) fn contacts(h: &GaussianHypothesis, model: &MeasurementModel<'_>, rows: &[usize]) -> Vec<(u32, f64)> {
    let mut again = h.clone();
    again.relinearise(model, h.map_from_odom, core::iter::empty());
    let mut held = Vec::new();
    for &row in rows {
        again.add_row(model, row);
        held.extend(again.states.iter().find_map(|state| state.tip_on()));
    }
    held
}

/// Whether the robot and its whiskers' bases stand in free space at the first and the last of these rows.
pub(super) fn is_free_throughout(context: &BankContext<'_>, history: &LogWindow, frame: Pose2, rows: &[usize]) -> bool {
    [rows.first(), rows.last()].into_iter().flatten().all(|&row| {
        let base = |index: usize| context.map.is_free(frame.transform_point(history.base(row, index).position()));
        context.origin_is_free(history, frame, row) && (0..context.sensors.len()).all(base)
    })
}

/// The first of these that stand apart from each other and from the bank's best.
fn apart(found: Vec<GaussianHypothesis>, bank: &HypothesisBank, context: &BankContext<'_>) -> Vec<GaussianHypothesis> {
    let least = bank.hypotheses.iter().map(|h| h.cost(bank.shared)).fold(f64::INFINITY, f64::min);
    let known: Vec<&GaussianHypothesis> =
        bank.hypotheses.iter().filter(|h| h.cost(bank.shared) <= least + KNOWN).collect();
    let mut chosen: Vec<GaussianHypothesis> = Vec::new();
    for h in found {
        let to = moved(h.map_from_odom, bank.pivot, super::bank::trust_region_step(h.predicted.1));
        let near = |other: &GaussianHypothesis| {
            let close = |frame: Pose2| {
                let [x, y, turn] = difference(frame, to, bank.pivot);
                x.hypot(y) < APART[0] && turn.abs() < APART[1]
            };
            let own = close(other.map_from_odom);
            own || bank.by_symmetry && context.symmetries.images(other.map_from_odom).any(close)
        };
        if chosen.len() < FITTED && !chosen.iter().any(near) && !known.iter().any(|h| near(h)) {
            chosen.push(h);
        }
    }
    chosen
}

/// These fitted to few rows, then to all; those that stay much costlier than the best are left out.
fn fitted(
    bank: &HypothesisBank,
    context: &BankContext<'_>,
    history: &LogWindow,
    rows: &[usize],
    found: Vec<GaussianHypothesis>,
) -> Vec<GaussianHypothesis> {
    let fair = context.model(history, bank.pivot, LikelihoodOptions::DECLARED, bank.shared);
    let some = bank.used.len().div_ceil(SOME).max(1);
    let mut few = bank.with_hypotheses(found, rows.to_vec());
    let found: Vec<Pose2> = few.hypotheses.iter().map(|h| h.map_from_odom).collect();
    for std_inflation in STD_INFLATIONS {
        let likelihood = LikelihoodOptions { std_inflation, outlier_cost: f64::INFINITY };
        let model = context.model(history, bank.pivot, likelihood, bank.shared);
        for h in &mut few.hypotheses {
            h.relinearise(&model, h.map_from_odom, rows.iter().copied());
            let (_, d) = h.damped_step(DAMPING, bank.shared);
            h.map_from_odom = moved(h.map_from_odom, bank.pivot, super::bank::trust_region_step(d));
        }
    }
    for (h, found) in few.hypotheses.iter_mut().zip(found) {
        // One that was right where it was found may have been led away.
        let mut stayed = h.clone();
        stayed.relinearise(&fair, found, bank.used.iter().copied().step_by(some));
        h.relinearise(&fair, h.map_from_odom, bank.used.iter().copied().step_by(some));
        if stayed.cost(bank.shared) < h.cost(bank.shared) {
            *h = stayed;
        }
    }
    let least = bank.hypotheses.iter().map(|h| h.cost(bank.shared)).fold(f64::INFINITY, f64::min);
    let mut own = bank.hypotheses.iter().min_by(|a, b| a.cost(bank.shared).total_cmp(&b.cost(bank.shared))).cloned();
    for (stride, rounds) in [(some, FIRST_ROUNDS), (1, ROUNDS)] {
        few.used = bank.used.iter().copied().step_by(stride).collect();
        for h in own.iter_mut().filter(|_| stride > 1).chain(&mut few.hypotheses) {
            h.relinearise(&fair, h.map_from_odom, few.used.iter().copied());
        }
        few.optimise(context, history, rounds, 0);
        let most = own.as_ref().filter(|_| stride > 1).map_or(least, |h| h.cost(bank.shared)) + REPORTED;
        few.hypotheses.retain(|h| h.cost(bank.shared) <= most);
    }
    few.hypotheses.iter_mut().for_each(|h| h.update_prediction(DAMPING, bank.shared));
    few.hypotheses
}
