//! Turns of the wall that the readings leave open: corners that a way may have missed, or taken elsewhere.
//!
//! Walls turn little, and seldom much. About a way through a stretch the seldom turns are alternatives that a linearised
//! covariance does not know: behind a corner that the readings hardly tell, the whole way is off by an angle. So each step's turn
//! is looked at by itself: what the readings say of it without what is known of walls, and what the heavy tail of turns makes of
//! that. Where much is left away from the way, the way around is tried; what remains widens the standard deviations.

use super::node::{NodePrediction, UNKNOWNS};
use super::problem::{TraceProblem, Way, seldom_share, seldom_weight};
use super::search::{SAME, apart};
use crate::least_squares::Factor;

/// Most steps whose turns are looked at; of longer ways some are left out, evenly.
const MOST_STEPS: usize = 400;
/// Largest turn of a wall in one step (rad).
const LARGEST_TURN: f64 = 1.5;
/// Points of a quadrature over the turn, from the largest to one side to that to the other.
const POINTS: i32 = 160;
/// Standard deviations beyond which a turn is away from the way.
const AWAY: f64 = 3.0;
/// Share of what a turn may be that has to be away before the way around is tried.
const LIKELY: f64 = 0.1;
/// Ways around that are tried at once, and how often.
const TRIED: usize = 3;
const ROUNDS: usize = 2;
/// Steps nearer than this to one that is tried already are the same corner.
const NEIGHBOURS: usize = 4;
/// Shares of a turn that are tried, the first one that bends the whisker counts.
const SHARES: [f64; 3] = [1.0, 0.5, 0.25];
/// What a way around has to save before it is taken (half a sum of squares).
const SAVES: f64 = 0.1;

/// What is open about one turn.
struct OpenTurn {
    step: usize,
    /// By how much it would be other, did the wall not matter (rad).
    by: f64,
    /// The share of what it may be that is away from the way.
    away: f64,
    /// Mean square about the way, less what the linearised covariance holds (rad²).
    open: f64,
    /// How the unknowns go with it (per rad).
    field: Vec<f64>,
}

impl TraceProblem<'_> {
    /// The cheapest way among this one and those around corners that it may have missed; and the others.
    pub(super) fn around(&self, way: Way) -> (Way, Vec<Way>) {
        let (mut best, mut others) = (way, Vec::new());
        for _ in 0..ROUNDS {
            let mut found = self.ways_around(&best);
            let cost = |way: &Way| self.cost_of(way, way.state.len());
            found.sort_by(|a, b| cost(a).total_cmp(&cost(b)));
            let better = found.first().is_some_and(|first| cost(first) < cost(&best) - SAVES);
            if better {
                others.push(core::mem::replace(&mut best, found.remove(0)));
            }
            others.extend(found);
            if !better {
                break;
            }
        }
        let mut distinct: Vec<Way> = Vec::new();
        for way in others {
            if apart(&way, &best) > SAME && distinct.iter().all(|other| apart(other, &way) > SAME) {
                distinct.push(way);
            }
        }
        (best, distinct)
    }

    /// Where the likeliest other corners lead.
    fn ways_around(&self, way: &Way) -> Vec<Way> {
        let mut turns = self.factor(way).map_or_else(Vec::new, |factor| self.turns(way, &factor));
        turns.retain(|turn| turn.away > LIKELY);
        turns.sort_by(|a, b| b.away.total_cmp(&a.away));
        let mut tried: Vec<&OpenTurn> = Vec::new();
        for turn in &turns {
            if tried.len() < TRIED && tried.iter().all(|other| other.step.abs_diff(turn.step) > NEIGHBOURS) {
                tried.push(turn);
            }
        }
        let moved = |turn: &OpenTurn, share: f64| {
            let add = |(x, d): (&f64, &f64)| x + share * turn.by * d;
            self.settle(way.unknowns.iter().zip(&turn.field).map(add).collect())
        };
        let one = |turn: &&OpenTurn| SHARES.into_iter().find_map(|share| moved(turn, share));
        let whole = |found: &Way| apart(found, way) > SAME && self.torn(&found.state).is_none();
        tried.iter().filter_map(one).filter(whole).collect()
    }

    /// The variance across the wall at each node that the turns leave open (m²).
    pub(super) fn open(&self, way: &Way, factor: &Factor) -> Vec<f64> {
        let mut open = vec![0.0; way.state.len()];
        let stride = stride(way.state.len());
        for turn in self.turns(way, factor).iter().filter(|turn| turn.open > 0.0) {
            for (i, (here, sum)) in way.state.iter().zip(&mut open).enumerate() {
                *sum += stride as f64 * turn.open * across(here, &turn.field[UNKNOWNS * i..]).powi(2);
            }
        }
        open
    }

    /// What is open about each turn.
    fn turns(&self, way: &Way, factor: &Factor) -> Vec<OpenTurn> {
        let steps = (0..way.state.len().saturating_sub(1)).step_by(stride(way.state.len()));
        steps.filter_map(|step| self.turn(way, factor, step)).collect()
    }

    fn turn(&self, way: &Way, factor: &Factor, step: usize) -> Option<OpenTurn> {
        let (felt, std) = (&way.state, self.turn_std(step));
        let row = Self::turning(felt, step);
        let mut right = vec![0.0; way.unknowns.len()];
        right[UNKNOWNS * step..UNKNOWNS * step + row.len()].copy_from_slice(&row);
        let spread = factor.solve(right);
        let variance: f64 = row.iter().zip(&spread[UNKNOWNS * step..]).map(|(a, b)| a * b).sum();
        let here = felt[step + 1].along - felt[step].along;
        let weight = seldom_weight(here / std) / (std * std);
        // What is left when what is known of walls is taken away.
        let precision = 1.0 / variance - weight;
        if !(variance > 0.0 && precision > 0.0) {
            return None;
        }
        let mean = here / (variance * precision);
        let (away, square) = tail((mean, 1.0 / precision), (here, AWAY * variance.sqrt()), std)?;
        Some(OpenTurn {
            step,
            by: mean.clamp(-LARGEST_TURN, LARGEST_TURN) - here,
            away,
            open: (square - variance).max(0.0),
            field: spread.iter().map(|s| s / variance).collect(),
        })
    }
}

fn stride(nodes: usize) -> usize {
    nodes.div_ceil(MOST_STEPS).max(1)
}

/// How far a node goes across the wall with its unknowns.
fn across(here: &NodePrediction, by: &[f64]) -> f64 {
    let normal = crate::plane::Vec2::from_angle(here.along).perp();
    (0..UNKNOWNS).map(|k| by[k] * here.position_by[k].dot(normal)).sum()
}

/// Of a turn that the readings say to be `free` (mean and variance), with what is known of walls: the share farther from `here`
/// than it reaches, and the mean square about it; none where the readings tell it well.
fn tail(free: (f64, f64), (here, reach): (f64, f64), std: f64) -> Option<(f64, f64)> {
    let (mean, variance) = free;
    // Evenly in the hyperbolic angle: fine about no turn, coarse about large ones.
    let spacing = 2.0 * (LARGEST_TURN / std).asinh() / f64::from(POINTS);
    if variance.sqrt() < 2.0 * spacing * std.hypot(mean) {
        return None;
    }
    let (mut total, mut away, mut square) = (0.0, 0.0, 0.0);
    for k in -POINTS / 2..=POINTS / 2 {
        let turn = std * (spacing * f64::from(k)).sinh();
        let weight = (-0.5 * (turn - mean).powi(2) / variance).exp() * seldom_share(turn / std) * std.hypot(turn);
        let off = turn - here;
        total += weight;
        square += weight * off * off;
        away += if off.abs() > reach { weight } else { 0.0 };
    }
    (total > 0.0).then(|| (away / total, square / total))
}
