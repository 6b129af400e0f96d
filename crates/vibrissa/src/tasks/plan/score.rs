//! Which states stay together, and how much they leave open.

use super::predict::{At, Felt};
use super::{Criterion, PlanOptions, RemainingState};
use crate::plane::{Pose2, wrap_angle};

/// What a radian of turn counts as way (m), and what each motion costs besides (m): it has to be thought about.
const TURN: f64 = 0.01;
const EACH: f64 = 0.02;
/// What a radian between two states counts (m).
const RADIAN: f64 = 0.05;
/// States are parted where their readings disagree at this many steps: one alone may be a snap that comes a little sooner.
const PARTED: u8 = 3;
/// States of a place that are no further apart are not told apart (m): the place is small enough to be called known.
pub(super) const SMALL: f64 = 0.012;

/// For each state which others read alike.
pub(super) type Alike = Vec<Vec<bool>>;

pub(super) struct Table<'a> {
    states: &'a [RemainingState],
    distances: Vec<Vec<f64>>,
    weights: Vec<f64>,
    /// How likely each state is the true one: as its weight, but for one who knows.
    chances: Vec<f64>,
    criterion: Criterion,
    places_only: bool,
}

/// What a motion leaves.
#[derive(Clone, Debug)]
pub(super) struct Judged {
    pub(super) places: [usize; 2],
    pub(super) extent: [f64; 2],
}

/// What a motion brings up to one of its steps.
#[derive(Clone, Debug)]
pub(super) struct Worth {
    /// Index of the step.
    pub(super) step: usize,
    pub(super) alike: Alike,
    /// For each state what is gained if it is the true one.
    pub(super) gains: Vec<f64>,
    pub(super) gain: f64,
    pub(super) cost: f64,
}

impl Worth {
    pub(super) fn rate(&self) -> f64 {
        self.gain / self.cost
    }
}

impl<'a> Table<'a> {
    pub(super) fn new(states: &'a [RemainingState], options: &PlanOptions, truth: Option<Pose2>) -> Self {
        let off =
            |a: Pose2, b: Pose2| a.position().distance(b.position()) + RADIAN * wrap_angle(a.theta - b.theta).abs();
        let distances = states.iter().map(|a| states.iter().map(|b| off(a.pose, b.pose)).collect()).collect();
        let sum: f64 = states.iter().map(|s| s.weight).sum();
        let even = 1.0 / states.len().max(1) as f64;
        let weights: Vec<f64> = states.iter().map(|s| if sum > 0.0 { s.weight / sum } else { even }).collect();
        let known = |truth: Pose2| {
            let nearest =
                (0..states.len()).min_by(|&i, &j| off(states[i].pose, truth).total_cmp(&off(states[j].pose, truth)));
            (0..states.len()).map(|i| f64::from(u8::from(Some(i) == nearest))).collect()
        };
        let chances = truth.map_or_else(|| weights.clone(), known);
        let places_only = options.places_only && states.iter().any(|s| s.place != states[0].place);
        Self { states, distances, weights, chances, criterion: options.criterion, places_only }
    }

    pub(super) fn together(&self) -> Alike {
        vec![vec![true; self.states.len()]; self.states.len()]
    }

    pub(super) fn places(&self) -> usize {
        let mut places: Vec<usize> = self.states.iter().map(|s| s.place).collect();
        places.sort_unstable();
        places.dedup();
        places.len()
    }

    /// What a motion brings up to the step at which it brings most for its way, if it brings anything.
    pub(super) fn best(&self, before: &Alike, felt: &Felt, least: f64) -> Option<Worth> {
        let n = self.states.len();
        let mut apart = vec![0_u8; n * n];
        let mut alike = before.clone();
        let mut best: Option<Worth> = None;
        let had = self.left(before);
        // Way and turn of each state, which ends where it stops.
        let mut costs = vec![0.0; n];
        for (index, (step, at)) in felt.steps.iter().zip(&felt.at).enumerate() {
            let mut changed = false;
            for i in 0..n {
                if !matches!(at[i], At::Stopped) {
                    costs[i] = step.way + TURN * step.turn + EACH;
                }
                for j in 0..i {
                    if alike[i][j] && self.counts(i, j) && disagree(&at[i], &at[j]) {
                        apart[i * n + j] += 1;
                        if apart[i * n + j] >= PARTED {
                            (alike[i][j], alike[j][i], changed) = (false, false, true);
                        }
                    }
                }
            }
            if changed {
                let seen = self.seen(&alike);
                let gains = self.gains(&had, &seen);
                let gain = self.over_states(&gains);
                let cost = self.over_states(&costs);
                let worth = Worth { step: index, alike: Vec::new(), gains, gain, cost };
                if gain > least && best.as_ref().is_none_or(|best| worth.rate() > best.rate()) {
                    best = Some(Worth { alike: seen, ..worth });
                }
            }
        }
        best
    }

    /// Which states count as alike: where places alone count, all of two places as long as any of them are.
    fn seen(&self, alike: &Alike) -> Alike {
        if !self.places_only {
            return alike.clone();
        }
        let places = self.states.iter().map(|s| s.place).max().map_or(0, |last| last + 1);
        let mut linked = vec![vec![false; places]; places];
        for (a, row) in self.states.iter().zip(alike) {
            for (b, _) in self.states.iter().zip(row).filter(|(_, alike)| **alike) {
                linked[a.place][b.place] = true;
            }
        }
        self.states.iter().map(|a| self.states.iter().map(|b| linked[a.place][b.place]).collect()).collect()
    }

    /// Whether two states are worth telling apart.
    fn counts(&self, i: usize, j: usize) -> bool {
        self.states[i].place != self.states[j].place || (!self.places_only && self.distances[i][j] > SMALL)
    }

    fn over_states(&self, values: &[f64]) -> f64 {
        values.iter().zip(&self.chances).map(|(value, chance)| value * chance).sum()
    }

    /// For each state how much is left open with those that are alike: the logarithm of their weight, or of their extent at worst.
    fn left(&self, alike: &Alike) -> Vec<f64> {
        alike
            .iter()
            .enumerate()
            .map(|(i, row)| {
                let own = row.iter().enumerate().filter(|(_, alike)| **alike);
                match self.criterion {
                    Criterion::Expected => own.map(|(j, _)| self.weights[j]).sum::<f64>().max(1e-12).ln(),
                    Criterion::Worst => (own.map(|(j, _)| self.distances[i][j]).fold(0.0, f64::max) + SMALL).ln(),
                }
            })
            .collect()
    }

    /// For each state how much less is left open; at worst it is the least for all.
    fn gains(&self, had: &[f64], alike: &Alike) -> Vec<f64> {
        let now = self.left(alike);
        match self.criterion {
            Criterion::Expected => had.iter().zip(&now).map(|(had, now)| had - now).collect(),
            Criterion::Worst => {
                let most = |values: &[f64]| values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
                vec![(most(had) - most(&now)).max(0.0); had.len()]
            }
        }
    }

    /// How many places and how much extent readings leave that are alike.
    pub(super) fn judge(&self, alike: &Alike) -> Judged {
        let (mut places, mut extent) = ([usize::MAX, 0], [0.0, 0.0_f64]);
        for (i, row) in alike.iter().enumerate() {
            let with = || row.iter().enumerate().filter(|(_, alike)| **alike).map(|(j, _)| j);
            let mut own: Vec<usize> = with().map(|j| self.states[j].place).collect();
            own.sort_unstable();
            own.dedup();
            places = [places[0].min(own.len()), places[1].max(own.len())];
            let weight: f64 = with().map(|j| self.weights[j]).sum();
            let sum: f64 = with().map(|j| self.weights[j] * self.distances[i][j]).sum();
            extent[0] += self.weights[i] * if weight > 0.0 { sum / weight } else { 0.0 };
            extent[1] = with().map(|j| self.distances[i][j]).fold(extent[1], f64::max);
        }
        Judged { places, extent }
    }

    /// What a motion brings for its cost together with the second motion that is best for each of its outcomes.
    pub(super) fn deep(&self, first: &Worth, seconds: &[Worth]) -> f64 {
        let (mut gain, mut cost) = (0.0, 0.0);
        for (i, row) in first.alike.iter().enumerate() {
            let weight: f64 = row.iter().zip(&self.chances).filter(|(alike, _)| **alike).map(|(_, w)| w).sum();
            let mean = |second: &Worth| {
                let own = row.iter().zip(&self.chances).zip(&second.gains).filter(|((alike, _), _)| **alike);
                own.map(|((_, w), gain)| w * gain).sum::<f64>() / weight.max(f64::MIN_POSITIVE)
            };
            let options = seconds.iter().map(|second| (mean(second), second.cost));
            let best = options.fold((0.0, 0.0), |best, one| {
                let rate = |(more, way): (f64, f64)| (first.gain + more) / (first.cost + way);
                if rate(one) > rate(best) { one } else { best }
            });
            gain += self.chances[i] * best.0;
            cost += self.chances[i] * best.1;
        }
        (first.gain + gain) / (first.cost + cost)
    }
}

/// Whether two states cannot both read this.
fn disagree(a: &At, b: &At) -> bool {
    match (a, b) {
        (At::Stopped, At::Runs(_)) | (At::Runs(_), At::Stopped) => true,
        (At::Stopped | At::Blind, _) | (_, At::Stopped | At::Blind) => false,
        (At::Runs(a) | At::May(a), At::Runs(b) | At::May(b)) => {
            a.iter().zip(b).any(|(a, b)| a.low > b.high || b.low > a.high)
        }
    }
}
