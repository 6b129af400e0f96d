//! Moments of the posterior around a place by adaptive importance sampling \[oh1992adaptive, cappe2004population\], with the
//! deterministic mixture's weights \[owen2000safe\] and tempered weights where few samples count \[koblents2015population\].
//!
//! On a map of facets, in corners and near a snap the cost is no parabola, so that the curvature at its least says little
//! about a millimetre around it. Weighted samples from Gaussians around the hypotheses (importance sampling, with fixed
//! points instead of random ones) give the mean, the covariance and the mass of the likelihood itself.

use super::measurement::{difference, moved};
use super::optimisation::{Mode, Rerun};
use crate::linear_algebra::{Cholesky, Square, determinant, dot, times};
use crate::plane::Pose2;

/// Samples of one place, and hypotheses at most that they are drawn around.
pub(super) const SAMPLES: usize = 112;
const MOST_CENTRES: usize = 12;
/// How many are drawn around the hypotheses; the rest is drawn from the Gaussian that those have found, so
/// much wider.
const FIRST: usize = 56;
const WIDER: f64 = 1.3;
const ENOUGH: f64 = 40.0;
/// Half of the samples are drawn from Gaussians this much wider than the linearisation says, half from the other.
const WIDTHS: [f64; 2] = [1.2, 2.5];
/// After so many samples around a single hypothesis nothing more is asked where its parabola has told their costs: to this
/// much (nats), and to this share of how much costlier they are.
const TRIED: usize = 20;
const GAUSSIAN_ERROR: [f64; 2] = [0.15, 0.15];
/// A sample that has come to cost so much more than the best (nats) is left: it weighs nothing.
const NOTHING: f64 = 15.0;
/// The linearisation counts like so many effective samples.
const PRIOR_SAMPLES: f64 = 6.0;

/// The likelihood around a place.
#[derive(Clone, Debug)]
pub(super) struct PosteriorMoments {
    /// The mean, as a move of the first hypothesis' frame about the pivot.
    pub(super) mean: [f64; 3],
    /// The covariance about that mean.
    pub(super) covariance: Square<3>,
    /// The integral of `exp(least - cost)`, over `(2 pi)^(3/2)`.
    pub(super) mass: f64,
}

/// A hypothesis that samples are drawn around.
pub(super) struct ProposalCentre<'a> {
    pub(super) place: &'a Mode,
    /// The covariance of its pose.
    pub(super) own: &'a Square<3>,
}

/// What is sampled.
pub(super) struct ImportanceSampler<'a> {
    pub(super) rerun: &'a Rerun<'a>,
    /// The cost that masses are relative to.
    pub(super) least: f64,
    /// Where the odometry frame may be; elsewhere counts nothing.
    pub(super) admits: &'a dyn Fn(Pose2) -> bool,
    /// Whether the first samples will not do.
    pub(super) thorough: bool,
}

/// Mean, covariance and mass of weighted samples, and how many of them count.
#[derive(Clone, Copy, Debug)]
struct WeightedMoments<const N: usize> {
    mean: [f64; N],
    covariance: [[f64; N]; N],
    mass: f64,
    effective_size: f64,
}

/// How many samples are drawn.
struct SampleCounts {
    first: usize,
    batch: usize,
    batches: usize,
    /// See [`LEAST_EFFECTIVE_SIZE`].
    least_effective_size: f64,
}

/// A Gaussian that samples are drawn from.
struct ProposalComponent<const N: usize> {
    at: [f64; N],
    factor: Cholesky<N>,
}

impl<const N: usize> ProposalComponent<N> {
    fn new(at: [f64; N], covariance: &[[f64; N]; N]) -> Option<Self> {
        Some(Self { at, factor: Cholesky::new(covariance)? })
    }

    /// Its density at a point when widened, without `(2 pi)^(N/2)`.
    fn density(&self, point: [f64; N], width: f64) -> f64 {
        let off = self.factor.whitened(&core::array::from_fn(|i| (point[i] - self.at[i]) / width));
        (-0.5 * dot(off, off)).exp() / (self.factor.root_determinant() * width.powi(N as i32))
    }

    /// Its n-th sample when widened.
    fn sample(&self, n: usize, width: f64) -> [f64; N] {
        let off = times(&self.factor.lower(), quasi_normal_point::<N>(n));
        core::array::from_fn(|i| self.at[i] + width * off[i])
    }
}

impl ImportanceSampler<'_> {
    /// The spread of the place of these hypotheses, the best first. None where it cannot be sampled.
    pub(super) fn posterior_moments(&self, members: &[ProposalCentre<'_>]) -> Option<PosteriorMoments> {
        let first = members.first()?;
        let model = self.rerun.model;
        let to = |mode: &Mode| difference(first.place.state.frame, mode.state.frame, model.pivot());
        let centres: Vec<_> =
            members.iter().take(MOST_CENTRES).filter_map(|m| ProposalComponent::new(to(m.place), m.own)).collect();
        let cost = |d: [f64; 3]| self.cost(first.place, d);
        let told = |drawn: &[([f64; 3], Option<f64>)]| {
            let parabola = first.place.marginal(model);
            is_gaussian(drawn, parabola.constant, |d| parabola.shifted(d).constant).then_some(())?;
            let covariance = parabola.covariance([0.0; 3])?;
            let (cost, mean) = parabola.least([0.0; 3]);
            let mass = (self.least - cost).exp() * determinant(&covariance).sqrt();
            Some(WeightedMoments { mean, covariance, mass, effective_size: f64::INFINITY })
        };
        let batch = SAMPLES - FIRST;
        let effort =
            SampleCounts { first: FIRST, batch, batches: usize::from(self.thorough), least_effective_size: 0.0 };
        let found = sample_adaptively(&centres, first.own, (&effort, self.least), cost, told)?;
        let WeightedMoments { mean, covariance, mass, .. } = found;
        Some(PosteriorMoments { mean, covariance, mass })
    }

    /// What the readings cost where the frame is moved by `d`; infinity for much more than they usually do, none where the frame cannot
    /// be.
    fn cost(&self, place: &Mode, d: [f64; 3]) -> Option<f64> {
        let model = self.rerun.model;
        let frame = moved(place.state.frame, model.pivot(), d);
        (self.admits)(frame).then_some(())?;
        let cost = self.rerun.at(place, frame).cost(model);
        Some(if cost > self.least + NOTHING { f64::INFINITY } else { cost })
    }
}

/// Draws samples around these, and then from what those have found, until enough count; masses are relative to the least cost.
fn sample_adaptively<const N: usize>(
    centres: &[ProposalComponent<N>],
    own: &[[f64; N]; N],
    (effort, least): (&SampleCounts, f64),
    cost: impl Fn([f64; N]) -> Option<f64>,
    told: impl Fn(&[([f64; N], Option<f64>)]) -> Option<WeightedMoments<N>>,
) -> Option<WeightedMoments<N>> {
    let around = |point: [f64; N]| {
        let drawn: f64 = centres.iter().flat_map(|c| WIDTHS.map(|w| c.density(point, w))).sum();
        drawn / (centres.len() * WIDTHS.len()) as f64
    };
    let mut drawn: Vec<([f64; N], Option<f64>)> = Vec::with_capacity(effort.first + effort.batches * effort.batch);
    for index in 0..effort.first / centres.len().max(1) * centres.len() {
        let centre = &centres[index % centres.len()];
        let point = centre.sample(index, WIDTHS[index / centres.len() % WIDTHS.len()]);
        drawn.push((point, cost(point)));
        if centres.len() == 1
            && drawn.len() == TRIED
            && let Some(told) = told(&drawn)
        {
            return Some(told);
        }
    }
    let early = drawn.len();
    let mut later: Vec<ProposalComponent<N>> = Vec::new();
    loop {
        // Each sample is weighed as one of the mixture that all were drawn from.
        let density = |point: [f64; N]| {
            let all = early + later.len() * effort.batch;
            let wide: f64 = later.iter().map(|c| c.density(point, WIDER)).sum();
            (early as f64 * around(point) + effort.batch as f64 * wide) / all as f64
        };
        // What costs infinitely much weighs nothing.
        let weight = |cost: Option<f64>, density: f64| cost.map_or(0.0, |cost| (least - cost).exp() / density);
        let weighed: Vec<_> = drawn.iter().map(|&(point, c)| (point, weight(c, density(point)))).collect();
        let found = weighted_moments(&weighed, own)?;
        if later.len() == effort.batches || later.len() > 1 && found.effective_size > ENOUGH {
            return Some(found);
        }
        let guide = if found.effective_size < effort.least_effective_size {
            weighted_moments(&tempered(&weighed, effort.least_effective_size), own)?
        } else {
            found
        };
        let Some(centre) = ProposalComponent::new(guide.mean, &guide.covariance) else { return Some(found) };
        for index in drawn.len()..drawn.len() + effort.batch {
            let point = centre.sample(index, WIDER);
            drawn.push((point, cost(point)));
        }
        later.push(centre);
    }
}

/// Whether a parabola with this least cost tells what all these samples cost.
fn is_gaussian<const N: usize>(
    drawn: &[([f64; N], Option<f64>)],
    least: f64,
    parabola: impl Fn([f64; N]) -> f64,
) -> bool {
    let told = |&(point, cost): &([f64; N], Option<f64>)| {
        let more = parabola(point) - least;
        cost.is_some_and(|cost| {
            let most = GAUSSIAN_ERROR[0] + GAUSSIAN_ERROR[1] * more.abs();
            (cost - least - more).abs() <= most || cost.is_infinite() && more + most > NOTHING
        })
    };
    drawn.iter().all(told)
}

/// How many of these weights count.
fn effective_size(weights: impl Iterator<Item = f64> + Clone) -> f64 {
    let (total, squares): (f64, f64) = (weights.clone().sum(), weights.map(|w| w * w).sum());
    total * total / squares
}

/// The same samples with weights so even that this many of them count, as far as that goes.
fn tempered<const N: usize>(samples: &[([f64; N], f64)], least: f64) -> Vec<([f64; N], f64)> {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..20 {
        let power = 0.5 * (low + high);
        let even = samples.iter().filter(|s| s.1 > 0.0).map(|s| s.1.powf(power));
        *(if effective_size(even) < least { &mut high } else { &mut low }) = power;
    }
    let power = |w: f64| if w > 0.0 { w.powf(low) } else { 0.0 };
    samples.iter().map(|&(point, w)| (point, power(w))).collect()
}

/// Mean, covariance and mass of weighted samples; where few of them count, the linearisation's covariance does.
fn weighted_moments<const N: usize>(samples: &[([f64; N], f64)], own: &[[f64; N]; N]) -> Option<WeightedMoments<N>> {
    let total: f64 = samples.iter().map(|s| s.1).sum();
    let effective_size = effective_size(samples.iter().map(|s| s.1));
    (total.is_finite() && total > 0.0 && effective_size.is_finite()).then_some(())?;
    let mean: [f64; N] = core::array::from_fn(|i| samples.iter().map(|(d, w)| w * d[i]).sum::<f64>() / total);
    let share = effective_size / (effective_size + PRIOR_SAMPLES);
    let mut covariance = [[0.0; N]; N];
    for (i, row) in covariance.iter_mut().enumerate() {
        for (j, value) in row.iter_mut().enumerate() {
            let sampled = samples.iter().map(|(d, w)| w * (d[i] - mean[i]) * (d[j] - mean[j])).sum::<f64>() / total;
            // The mean is that of the same few samples: they lie too near to it, and it is off itself.
            let fair = sampled / (1.0 - 1.0 / effective_size.max(2.0));
            *value = (share * fair + (1.0 - share) * own[i][j]) * (1.0 + 1.0 / effective_size);
        }
    }
    Some(WeightedMoments { mean, covariance, mass: total / samples.len() as f64, effective_size })
}

/// The n-th of evenly spread points of the standard normal law: multiples of powers of the root of `x^(k + 1) = x + 1`, where `k` is
/// the dimension, if even, modulo one, through Box and Muller's map.
fn quasi_normal_point<const N: usize>(n: usize) -> [f64; N] {
    let step = if N <= 4 { 0.856_674_883_854_502_9_f64 } else { 0.898_653_712_628_699_3 };
    let u = |power: usize| ((n as f64 + 1.0) * step.powi(power as i32) + 0.5).fract();
    core::array::from_fn(|i| {
        let pair = i - i % 2;
        let radius = (-2.0 * (1.0 - u(pair + 1)).max(1e-12).ln()).sqrt();
        let (sin, cos) = (core::f64::consts::TAU * u(pair + 2)).sin_cos();
        radius * if i % 2 == 0 { cos } else { sin }
    })
}
