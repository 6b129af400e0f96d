//! How wide a place really is: the likelihood around its hypotheses, sampled.
//!
//! On a map of facets, in corners and near a snap the cost is no parabola, so that the curvature at its least says little
//! about a millimetre around it. Weighted samples from Gaussians around the hypotheses (importance sampling, with fixed
//! points instead of random ones) give the mean, the covariance and the mass of the likelihood itself.

use super::hypothesis::{Hypothesis, Limits, Scene, difference, moved};
use super::normal::{Matrix, determinant, dot, inverse, times};
use crate::plane::Pose2;

/// Samples of one place, and hypotheses at most that they are drawn around.
pub(super) const SAMPLES: usize = 112;
const MOST_CENTRES: usize = 12;
/// The share of them that is drawn around the hypotheses; the rest is drawn from the Gaussian that those have found, so
/// much wider.
const FIRST: usize = 56;
const WIDER: f64 = 1.3;
/// Half of the samples are drawn from Gaussians this much wider than the linearisation says, half from the other.
const WIDTHS: [f64; 2] = [1.2, 2.5];
/// After so many samples around a single hypothesis nothing more is asked where its parabola has told their costs: to this
/// much (nats), and to this share of how much dearer they are.
const TRIED: usize = 20;
const AS_TOLD: [f64; 2] = [0.15, 0.15];
/// A sample that has come to cost so much more than the best (nats) is left: it weighs nothing.
const NOTHING: f64 = 15.0;
/// The linearisation counts like so many effective samples.
const PRIOR_SAMPLES: f64 = 6.0;

/// The likelihood around a place.
#[derive(Clone, Debug)]
pub(super) struct Spread {
    /// The mean, as a move of the first hypothesis' frame about the pivot.
    pub(super) mean: [f64; 3],
    /// The covariance about that mean.
    pub(super) covariance: Matrix,
    /// The integral of `exp(least - cost)`, over `(2 pi)^(3/2)`.
    pub(super) mass: f64,
}

/// A Gaussian that samples are drawn from.
struct Centre {
    at: [f64; 3],
    root: Matrix,
    inverse: Matrix,
    per_volume: f64,
}

impl Centre {
    fn new(at: [f64; 3], covariance: &Matrix) -> Option<Self> {
        let volume = determinant(covariance).sqrt();
        (volume.is_finite() && volume > 0.0).then_some(())?;
        Some(Self { at, root: root(covariance)?, inverse: inverse(covariance)?, per_volume: 1.0 / volume })
    }

    /// Its density at `d` when widened, without `(2 pi)^(3/2)`.
    fn density(&self, d: [f64; 3], width: f64) -> f64 {
        let off = [0, 1, 2].map(|i| (d[i] - self.at[i]) / width);
        self.per_volume / width.powi(3) * (-0.5 * dot(times(&self.inverse, off), off)).exp()
    }
}

/// The spread of the place of these hypotheses, each with its covariance, the best first; `least` is the cost that
/// masses are relative to, and what is not admitted counts nothing. Where it need not be `thorough`, the first samples do. None where it cannot be sampled.
pub(super) fn spread(
    scene: &Scene<'_>,
    members: &[(&Hypothesis, &Matrix)],
    rows: &[usize],
    least: f64,
    admits: &dyn Fn(Pose2) -> bool,
    thorough: bool,
) -> Option<Spread> {
    let (first, own) = *members.first()?;
    let centres: Vec<Centre> = members
        .iter()
        .take(MOST_CENTRES)
        .filter_map(|(h, c)| Centre::new(difference(first.map_from_odom, h.map_from_odom, scene.pivot), c))
        .collect();
    let usual = first.costs(scene, rows);
    let cost = |d: [f64; 3]| {
        let frame = moved(first.map_from_odom, scene.pivot, d);
        let mut there = first.clone();
        let limits = Limits { usual: &usual, more: NOTHING };
        let mut asked = |frame: Pose2| {
            if there.run_below(scene, frame, rows, limits) { there.cost(scene.shared) } else { f64::INFINITY }
        };
        admits(frame).then(|| asked(frame))
    };
    let around = |d: [f64; 3]| {
        let drawn: f64 = centres.iter().flat_map(|c| WIDTHS.map(|w| c.density(d, w))).sum();
        drawn / (centres.len() * WIDTHS.len()) as f64
    };
    // What costs infinitely much weighs nothing.
    let weight = |cost: Option<f64>, drawn: f64| cost.map_or(0.0, |cost| (least - cost).exp() / drawn);
    let mut drawn: Vec<([f64; 3], Option<f64>)> = Vec::with_capacity(SAMPLES);
    for index in 0..FIRST / centres.len().max(1) * centres.len() {
        let centre = &centres[index % centres.len()];
        let width = WIDTHS[index / centres.len() % WIDTHS.len()];
        let step = times(&centre.root, normal_point(index));
        let d = [0, 1, 2].map(|i| centre.at[i] + width * step[i]);
        drawn.push((d, cost(d)));
        if centres.len() == 1
            && drawn.len() == TRIED
            && let Some(told) = as_told(scene, first, &drawn, least)
        {
            return Some(told);
        }
    }
    let early = drawn.len();
    let weighed: Vec<_> = drawn.iter().map(|&(d, c)| (d, weight(c, around(d)))).collect();
    let found = summary(&weighed, own)?;
    if !thorough {
        return Some(found);
    }
    let Some(centre) = Centre::new(found.mean, &found.covariance) else { return Some(found) };
    for index in early..SAMPLES {
        let step = times(&centre.root, normal_point(index));
        let d = [0, 1, 2].map(|i| centre.at[i] + WIDER * step[i]);
        drawn.push((d, cost(d)));
    }
    // Each sample is weighed as one of the mixture that all were drawn from.
    let share = early as f64 / SAMPLES as f64;
    let mixture = |d: [f64; 3]| share * around(d) + (1.0 - share) * centre.density(d, WIDER);
    let weighed: Vec<_> = drawn.iter().map(|&(d, c)| (d, weight(c, mixture(d)))).collect();
    summary(&weighed, own)
}

/// The hypothesis' own Gaussian, if its parabola tells what all these samples cost.
fn as_told(scene: &Scene<'_>, own: &Hypothesis, drawn: &[([f64; 3], Option<f64>)], least: f64) -> Option<Spread> {
    let parabola = own.marginal(scene.shared);
    let told = |&(d, cost): &([f64; 3], Option<f64>)| {
        let more = parabola.moved(d).cost - parabola.cost;
        cost.is_some_and(|cost| {
            let most = AS_TOLD[0] + AS_TOLD[1] * more.abs();
            (cost - parabola.cost - more).abs() <= most || cost.is_infinite() && more + most > NOTHING
        })
    };
    let covariance = inverse(&parabola.curvature)?;
    let mean = parabola.step([0.0; 3])?;
    let mass = (least - parabola.moved(mean).cost).exp() * determinant(&covariance).sqrt();
    drawn.iter().all(told).then_some(Spread { mean, covariance, mass })
}

/// Mean, covariance and mass of weighted samples; where few of them count, the linearisation's covariance does.
fn summary(samples: &[([f64; 3], f64)], own: &Matrix) -> Option<Spread> {
    let total: f64 = samples.iter().map(|s| s.1).sum();
    let squares: f64 = samples.iter().map(|s| s.1 * s.1).sum();
    (total.is_finite() && total > 0.0 && squares > 0.0).then_some(())?;
    let mean = [0, 1, 2].map(|i| samples.iter().map(|(d, w)| w * d[i]).sum::<f64>() / total);
    let effective = total * total / squares;
    let share = effective / (effective + PRIOR_SAMPLES);
    let mut covariance = [[0.0; 3]; 3];
    for (i, row) in covariance.iter_mut().enumerate() {
        for (j, value) in row.iter_mut().enumerate() {
            let sampled = samples.iter().map(|(d, w)| w * (d[i] - mean[i]) * (d[j] - mean[j])).sum::<f64>() / total;
            // The mean is that of the same few samples: they lie too near to it, and it is off itself.
            let fair = sampled / (1.0 - 1.0 / effective.max(2.0));
            *value = (share * fair + (1.0 - share) * own[i][j]) * (1.0 + 1.0 / effective);
        }
    }
    Some(Spread { mean, covariance, mass: total / samples.len() as f64 })
}

/// The lower triangular root of a symmetric positive matrix.
fn root(m: &Matrix) -> Option<Matrix> {
    let mut l = [[0.0; 3]; 3];
    for i in 0..3 {
        for j in 0..=i {
            let rest = m[i][j] - (0..j).map(|k| l[i][k] * l[j][k]).sum::<f64>();
            l[i][j] = if i == j { rest.sqrt() } else { rest / l[j][j] };
            l[i][j].is_finite().then_some(())?;
        }
    }
    Some(l)
}

/// The n-th of evenly spread points of the standard normal law in three dimensions: multiples of powers of the root of
/// `x⁵ = x + 1`, modulo one, through Box and Muller's map.
fn normal_point(n: usize) -> [f64; 3] {
    const STEP: f64 = 0.856_674_883_854_502_9;
    let u = |power: i32| ((n as f64 + 1.0) * STEP.powi(power) + 0.5).fract();
    let radius = |v: f64| (-2.0 * (1.0 - v).max(1e-12).ln()).sqrt();
    let (sin, cos) = (core::f64::consts::TAU * u(2)).sin_cos();
    let (a, b) = (radius(u(1)), radius(u(3)));
    [a * cos, a * sin, b * (core::f64::consts::TAU * u(4)).cos()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_of_a_gaussian_give_it_back() {
        // A Gaussian away from the one that is drawn from, with a known mass.
        let own = [[4.0, 1.0, 0.0], [1.0, 2.0, 0.3], [0.0, 0.3, 1.0]];
        let target = [[3.0, -0.5, 0.2], [-0.5, 2.5, 0.0], [0.2, 0.0, 0.7]];
        let at = [0.4, -0.3, 0.2];
        let centre = Centre::new([0.0; 3], &own).unwrap_or_else(|| unreachable!());
        let precise = inverse(&target).unwrap_or_default();
        let samples: Vec<_> = (0..4000)
            .map(|index| {
                let width = WIDTHS[index % 2];
                let d = times(&centre.root, normal_point(index)).map(|v| width * v);
                let off = [0, 1, 2].map(|i| d[i] - at[i]);
                let drawn = WIDTHS.map(|w| centre.density(d, w)).iter().sum::<f64>() / 2.0;
                (d, (-0.5 * dot(times(&precise, off), off)).exp() / drawn)
            })
            .collect();
        let found = summary(&samples, &own).unwrap_or_else(|| unreachable!());
        assert!((found.mass / determinant(&target).sqrt() - 1.0).abs() < 0.05, "{found:?}");
        for i in 0..3 {
            assert!((found.mean[i] - at[i]).abs() < 0.1, "{found:?}");
            (0..3).for_each(|j| assert!((found.covariance[i][j] - target[i][j]).abs() < 0.25, "{found:?}"));
        }
    }
}
