//! Multistart around the best few places \[rinnooykan1987stochastic\]: on a map of facets the cost has many shallow minima.

use super::bank::{BankContext, HypothesisBank, trust_region_step};
use super::hypothesis::{GaussianHypothesis, MeasurementModel, difference, moved};
use super::log_window::LogWindow;
use super::places::{LAST_ROUNDS, REPORTED, covariance};
use super::sensor::LikelihoodOptions;

/// So many of the best hypotheses that stand apart, and so many of the best, are started anew from around them, and from
/// where (m, m, rad); rows that this takes at least.
const STARTS_APART: usize = 6;
const STARTS_AROUND: usize = 3;
const START_ROWS: usize = 64;
const PERTURBATIONS: [[f64; 3]; 3] = [[7e-4, 7e-4, 0.0], [7e-4, -7e-4, 0.0], [0.0, 0.0, 0.012]];
/// Where those end lie in a valley with more minima between them: what is no costlier than the best by so much (nats) and no
/// further from it (m, rad) tells where the valley goes.
const VALLEY: f64 = 30.0;
const REACH: [f64; 2] = [3e-3, 0.03];
/// The cost is looked at along so many lines from the best to others, and along the unobservable direction of its likelihood to either side so far
/// (standard deviations), in steps of no more than this (m, rad), and no more of them.
const LINES: usize = 6;
const UNOBSERVABLE_REACH: f64 = 6.0;
const STEP: [f64; 2] = [5e-5, 3e-4];
const MOST_STEPS: f64 = 16.0;
/// So many of the minima on these lines are followed.
const FOLLOWED: usize = 6;

/// Starts the best few anew from places around them, and from minima between those where these end.
///
/// Places that stand apart are shaken alike: of two that are each other's image one would otherwise be told as less likely
/// for having been left in the shallower of its minima.
pub(super) fn multistart(bank: &mut HypothesisBank, context: &BankContext<'_>, history: &LogWindow) {
    let model = context.model(history, bank.pivot, LikelihoodOptions::DECLARED, bank.shared);
    let stride = (bank.used.len() / START_ROWS).clamp(1, 4);
    let rows: Vec<usize> = bank.used.iter().copied().step_by(stride).collect();
    let starts = || [[0.0; 3]].into_iter().chain(PERTURBATIONS.into_iter().flat_map(|d| [d, d.map(|v| -v)]));
    let around =
        start_hypotheses(bank).into_iter().flat_map(|index| starts().map(move |d| (index, d))).map(|(index, d)| {
            let mut next = bank.hypotheses[index].clone();
            next.relinearise(&model, moved(next.map_from_odom, model.pivot, d), rows.iter().copied());
            next
        });
    let mut few = bank.with_hypotheses(around.collect(), rows);
    few.optimise(context, history, LAST_ROUNDS, 0);
    let between = between(&few, &model);
    few.hypotheses.extend(between);
    few.optimise(context, history, LAST_ROUNDS, 0);
    let least = few.hypotheses.first().map_or(0.0, |h| h.cost(bank.shared));
    few.hypotheses.retain(|h| h.cost(bank.shared) <= least + REPORTED);
    for mut h in few.hypotheses {
        h.relinearise(&model, h.map_from_odom, bank.used.iter().copied());
        bank.hypotheses.push(h);
    }
    bank.optimise(context, history, LAST_ROUNDS, 0);
    let shared = bank.shared;
    bank.hypotheses.iter_mut().for_each(|h| h.update_prediction(super::bank::WEAK_PRIOR, shared));
}

/// Which hypotheses are started anew.
fn start_hypotheses(bank: &HypothesisBank) -> Vec<usize> {
    let least = bank.hypotheses.first().map_or(0.0, |h| h.cost(bank.shared));
    let told = bank.hypotheses.iter().take_while(|h| h.cost(bank.shared) <= least + REPORTED).count();
    let mut shaken = bank.apart(0..told, STARTS_APART);
    (0..told.min(STARTS_AROUND)).for_each(|index| {
        if shaken.len() < STARTS_AROUND && !shaken.contains(&index) {
            shaken.push(index);
        }
    });
    shaken
}

/// Minima of the cost on lines through the valleys in which these lie, the best first.
fn between(few: &HypothesisBank, model: &MeasurementModel<'_>) -> Vec<GaussianHypothesis> {
    let shared = few.shared;
    let mut found: Vec<GaussianHypothesis> =
        lines(few).into_iter().flat_map(|(from, d)| minima(&few.hypotheses[from], d, few, model)).collect();
    found.sort_by(|a, b| a.cost(shared).total_cmp(&b.cost(shared)));
    found.truncate(FOLLOWED);
    found
}

/// Lines that may go through more minima: from which hypothesis, and the move to where they end.
fn lines(few: &HypothesisBank) -> Vec<(usize, [f64; 3])> {
    let cost = |index: usize| few.hypotheses[index].cost(few.shared);
    let mut lines = Vec::new();
    // Of those that lie together the first is the best.
    let mut first: Vec<usize> = Vec::new();
    for (index, h) in few.hypotheses.iter().enumerate() {
        let to = |from: usize| difference(few.hypotheses[from].map_from_odom, h.map_from_odom, few.pivot);
        let near = |from: &usize| {
            let [x, y, turn] = to(*from);
            x.hypot(y) < REACH[0] && turn.abs() < REACH[1]
        };
        match first.iter().copied().find(near) {
            Some(from) if lines.len() < LINES && cost(index) <= cost(from) + VALLEY => lines.push((from, to(from))),
            Some(_) => {}
            None => first.push(index),
        }
    }
    let told = first.into_iter().filter(|&from| cost(from) <= cost(0) + REPORTED).take(STARTS_APART);
    let ridges = told.flat_map(|from| {
        let own = covariance(&few.hypotheses[from], few);
        let std = own[2][2].sqrt();
        [UNOBSERVABLE_REACH, -UNOBSERVABLE_REACH]
            .map(|share| (from, trust_region_step([0, 1, 2].map(|i: usize| share * own[i][2] / std))))
    });
    lines.extend(ridges);
    lines
}

/// Minima of the cost along the line, without its ends.
fn minima(
    from: &GaussianHypothesis,
    d: [f64; 3],
    few: &HypothesisBank,
    model: &MeasurementModel<'_>,
) -> Vec<GaussianHypothesis> {
    let steps = (d[0].hypot(d[1]) / STEP[0]).max(d[2].abs() / STEP[1]).ceil().clamp(2.0, MOST_STEPS);
    let at = |step: usize| {
        let mut next = from.clone();
        let to = moved(from.map_from_odom, model.pivot, d.map(|v| v * step as f64 / steps));
        next.relinearise(model, to, few.used.iter().copied());
        next
    };
    let line: Vec<GaussianHypothesis> = (0..=steps as usize).map(at).collect();
    let costs: Vec<f64> = line.iter().map(|h| h.cost(few.shared)).collect();
    let is_least = |step: usize| {
        let cost = costs[step];
        cost < costs[step - 1] && cost <= costs[step + 1] && cost <= costs[0] + REPORTED
    };
    let inner = line.into_iter().enumerate().skip(1).take(steps as usize - 1);
    inner.filter(|&(step, _)| is_least(step)).map(|(_, h)| h).collect()
}
