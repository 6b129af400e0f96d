//! Adaptive importance sampling \[oh1992adaptive, cappe2004population\], with the
//! deterministic mixture's weights \[owen2000safe\].
//!
//! On a map of facets, in corners and near a snap the cost is no parabola, so that the curvature at its least says little
//! about a millimetre around it. Weighted samples from Gaussians around the hypotheses (importance sampling, with fixed
//! points instead of random ones) give the mean, the covariance and the mass of the likelihood itself.

use crate::linear_algebra::{Cholesky, dot, times};
use crate::math::{cos, ln, sin};

/// Samples of one place, and hypotheses at most that they are drawn around.
pub(super) const SAMPLES: usize = 112;
pub(super) const MOST_CENTRES: usize = 12;
/// How many are drawn around the hypotheses; the rest is drawn from the Gaussian that those have found, so
/// much wider.
pub(super) const FIRST: usize = 56;
const WIDER: f64 = 1.3;
const ENOUGH: f64 = 40.0;
/// Half of the samples are drawn from Gaussians this much wider than the linearisation says, half from the other.
pub(super) const WIDTHS: [f64; 2] = [1.2, 2.5];
/// So many samples around a single hypothesis tell whether its parabola tells their costs: to this much (nats), and to this share of how much costlier they
/// are. Nothing more is asked then.
pub(super) const TRIED: usize = 20;
const GAUSSIAN_ERROR: [f64; 2] = [0.15, 0.15];
/// A sample that has come to cost so much more than the best (nats) is left: it weighs nothing.
pub(super) const NOTHING: f64 = 15.0;
/// The linearisation counts like so many effective samples.
const PRIOR_SAMPLES: f64 = 6.0;

/// Mean, covariance and mass of weighted samples, and how many of them count.
#[derive(Clone, Copy, Debug)]
pub(super) struct WeightedMoments<const N: usize> {
    pub(super) mean: [f64; N],
    pub(super) covariance: [[f64; N]; N],
    pub(super) mass: f64,
    pub(super) effective_size: f64,
}

/// What linearisations say of what is sampled.
pub(super) struct LinearMoments<const N: usize> {
    pub(super) mean: [f64; N],
    pub(super) covariance: [[f64; N]; N],
}

/// How many samples are drawn.
pub(super) struct SampleCounts {
    pub(super) first: usize,
    pub(super) batch: usize,
    pub(super) batches: usize,
}

/// A Gaussian that samples are drawn from.
pub(super) struct ProposalComponent<const N: usize> {
    at: [f64; N],
    factor: Cholesky<N>,
}

impl<const N: usize> ProposalComponent<N> {
    pub(super) fn new(at: [f64; N], covariance: &[[f64; N]; N]) -> Option<Self> {
        Some(Self { at, factor: Cholesky::new(covariance)? })
    }

    /// Its density at a point when widened, without `(2 pi)^(N/2)`.
    fn density(&self, point: [f64; N], width: f64) -> f64 {
        let off = self.factor.whitened(&core::array::from_fn(|i| (point[i] - self.at[i]) / width));
        (-0.5 * dot(off, off)).exp() / (self.factor.root_determinant() * width.powi(N as i32))
    }

    /// Its n-th sample when widened.
    pub(super) fn sample(&self, n: usize, width: f64) -> [f64; N] {
        let off = times(&self.factor.lower(), quasi_normal_point::<N>(n));
        core::array::from_fn(|i| self.at[i] + width * off[i])
    }
}

/// What is sampled.
pub(super) trait Cost<const N: usize> {
    /// Minus the logarithm of the likelihood at a point (nats); infinite for much more than the least, none where nothing can be.
    ///
    /// `n` counts the samples.
    async fn at(&self, n: usize, point: [f64; N]) -> Option<f64>;
}

/// Draws samples around these, and then from what those have found, until enough count; masses are relative to the least cost.
pub(super) async fn sample_adaptively<const N: usize>(
    centres: &[ProposalComponent<N>],
    linear: &LinearMoments<N>,
    (effort, least): (&SampleCounts, f64),
    cost: &impl Cost<N>,
) -> Option<WeightedMoments<N>> {
    let around = |point: [f64; N]| {
        let drawn: f64 = centres.iter().flat_map(|c| WIDTHS.map(|w| c.density(point, w))).sum();
        drawn / (centres.len() * WIDTHS.len()) as f64
    };
    let mut drawn: Vec<([f64; N], Option<f64>)> = Vec::with_capacity(effort.first + effort.batches * effort.batch);
    for index in 0..effort.first / centres.len().max(1) * centres.len() {
        let centre = &centres[index % centres.len()];
        let point = centre.sample(index, WIDTHS[index / centres.len() % WIDTHS.len()]);
        drawn.push((point, cost.at(index, point).await));
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
        let found = weighted_moments(&weighed, linear)?;
        if later.len() == effort.batches || later.len() > 1 && found.effective_size > ENOUGH {
            return Some(found);
        }
        let Some(centre) = ProposalComponent::new(found.mean, &found.covariance) else { return Some(found) };
        for index in drawn.len()..drawn.len() + effort.batch {
            let point = centre.sample(index, WIDER);
            drawn.push((point, cost.at(index, point).await));
        }
        later.push(centre);
    }
}

/// Whether a parabola with this least cost tells what all these samples cost.
pub(super) fn is_gaussian<const N: usize>(
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

/// Mean, covariance and mass of weighted samples, to which the linearisation's are added as those of so many more.
fn weighted_moments<const N: usize>(
    samples: &[([f64; N], f64)],
    linear: &LinearMoments<N>,
) -> Option<WeightedMoments<N>> {
    let total: f64 = samples.iter().map(|s| s.1).sum();
    let effective_size = effective_size(samples.iter().map(|s| s.1));
    (total.is_finite() && total > 0.0 && effective_size.is_finite()).then_some(())?;
    let sampled: [f64; N] = core::array::from_fn(|i| samples.iter().map(|(d, w)| w * d[i]).sum::<f64>() / total);
    let share = effective_size / (effective_size + PRIOR_SAMPLES);
    let mean: [f64; N] = core::array::from_fn(|i| share * sampled[i] + (1.0 - share) * linear.mean[i]);
    // The sampled mean is that of the same few samples: they lie too near to it, and it is off itself.
    let (fair, off) = ((1.0 - 1.0 / effective_size.max(2.0)).recip(), 1.0 + share * share / effective_size);
    let mut covariance = [[0.0; N]; N];
    for (i, row) in covariance.iter_mut().enumerate() {
        for (j, value) in row.iter_mut().enumerate() {
            let product = |(d, w): &([f64; N], f64)| w * (d[i] - sampled[i]) * (d[j] - sampled[j]);
            let own = samples.iter().map(product).sum::<f64>() / total;
            let apart = (sampled[i] - linear.mean[i]) * (sampled[j] - linear.mean[j]);
            let all = share * fair * own + (1.0 - share) * linear.covariance[i][j] + share * (1.0 - share) * apart;
            *value = off * all;
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

/// The n-th of points of the standard normal law of any dimension: numbers of the generator splitmix64 \[steele2014fast\] through Box and Muller's map.
pub(super) fn normal_numbers(n: usize, dimension: usize) -> Vec<f64> {
    const STEP: u64 = 0x9e37_79b9_7f4a_7c15;
    let mut state = (n as u64).wrapping_mul(STEP).rotate_left(32);
    let mut even = || {
        state = state.wrapping_add(STEP);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (((z ^ (z >> 31)) >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
    };
    let pair = |_| {
        let (radius, turn) = ((-2.0 * ln(even())).sqrt(), core::f64::consts::TAU * even());
        [radius * cos(turn), radius * sin(turn)]
    };
    (0..dimension.div_ceil(2)).flat_map(pair).take(dimension).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::coroutine::completed;
    use crate::linear_algebra::{determinant, inverse};

    /// A cost of six unknowns that is a parabola with this mean, and inverse variances that a chain of them shares.
    fn chained(mean: [f64; 6]) -> impl Fn([f64; 6]) -> f64 {
        move |point| {
            let off: [f64; 6] = core::array::from_fn(|i| point[i] - mean[i]);
            let links: f64 = off.windows(2).map(|w| (w[1] - 0.6 * w[0]).powi(2)).sum();
            0.5 * (off[0] * off[0] + links / 0.64)
        }
    }

    /// A cost that takes no time.
    struct Computed<F>(F);

    impl<const N: usize, F: Fn([f64; N]) -> f64> Cost<N> for Computed<F> {
        async fn at(&self, _: usize, point: [f64; N]) -> Option<f64> {
            Some(self.0(point))
        }
    }

    const EFFORT: SampleCounts = SampleCounts { first: 84, batch: 56, batches: 20 };

    #[test]
    fn batches_go_where_the_likelihood_is() {
        // Every unknown has the variance 1 and 0.6 in common with the one before; drawn around a place five standard deviations off.
        let mean = [3.0, -2.0, 1.0, 0.0, 2.0, -3.0];
        let cost = chained(mean);
        let own: [[f64; 6]; 6] = core::array::from_fn(|i| core::array::from_fn(|j| 0.6_f64.powi(i.abs_diff(j) as i32)));
        let centre = ProposalComponent::new([0.0; 6], &own).unwrap_or_else(|| unreachable!());
        let linear = LinearMoments { mean: [0.0; 6], covariance: own };
        let found = completed(sample_adaptively(&[centre], &linear, (&EFFORT, 0.0), &Computed(cost)));
        let found = found.unwrap_or_else(|| unreachable!());
        assert!(found.effective_size > ENOUGH, "{found:?}");
        // Beside what is sampled stands a small share of the linearisation, which is elsewhere.
        let share = found.effective_size / (found.effective_size + PRIOR_SAMPLES);
        for i in 0..6 {
            assert!((found.mean[i] - share * mean[i]).abs() < 0.5, "{found:?}");
            for j in 0..6 {
                let expected = own[i][j] + share * (1.0 - share) * mean[i] * mean[j];
                assert!((found.covariance[i][j] - expected).abs() < 0.6, "{i} {j}: {expected}, {found:?}");
            }
        }
        let volume = 0.64_f64.powf(2.5);
        assert!((found.mass / volume - 1.0).abs() < 0.3, "{} of {volume}", found.mass);
    }

    #[test]
    fn a_parabola_that_tells_what_samples_cost_is_believed() {
        let cost = chained([0.0; 6]);
        let points: Vec<[f64; 6]> = (0..TRIED).map(quasi_normal_point).collect();
        let told = |more: f64| {
            let drawn: Vec<_> = points.iter().map(|&p| (p, Some(cost(p) + more * p[0].abs()))).collect();
            is_gaussian(&drawn, 0.0, &cost)
        };
        assert!(told(0.0) && told(0.05) && !told(2.0));
        assert!(!is_gaussian(&[(points[0], None)], 0.0, &cost));
    }

    #[test]
    fn normal_numbers_are_those_of_independent_standard_normal_laws() {
        let points: Vec<Vec<f64>> = (0..4000).map(|n| normal_numbers(n, 7)).collect();
        let mean = |of: &dyn Fn(&[f64]) -> f64| points.iter().map(|p| of(p)).sum::<f64>() / points.len() as f64;
        for i in 0..7 {
            assert!(mean(&|p| p[i]).abs() < 0.06, "{i}");
            assert!((mean(&|p| p[i].powi(4)) - 3.0).abs() < 0.5, "{i}");
            for j in 0..=i {
                let expected = f64::from(u8::from(i == j));
                assert!((mean(&|p| p[i] * p[j]) - expected).abs() < 0.1, "{i} {j}");
            }
        }
        // One point does not foretell the next.
        let next: f64 = points.windows(2).map(|w| w[0][0] * w[1][0]).sum::<f64>() / points.len() as f64;
        assert!(next.abs() < 0.06, "{next}");
    }

    #[test]
    fn samples_of_a_gaussian_give_it_back() {
        // A Gaussian away from the one that is drawn from, with a known mass.
        let own = [[4.0, 1.0, 0.0], [1.0, 2.0, 0.3], [0.0, 0.3, 1.0]];
        let target = [[3.0, -0.5, 0.2], [-0.5, 2.5, 0.0], [0.2, 0.0, 0.7]];
        let at = [0.4, -0.3, 0.2];
        let centre = ProposalComponent::new([0.0; 3], &own).unwrap_or_else(|| unreachable!());
        let precise = inverse(&target).unwrap_or_default();
        let samples: Vec<_> = (0..4000)
            .map(|index| {
                let width = WIDTHS[index % 2];
                let d = centre.sample(index, width);
                let off = [0, 1, 2].map(|i| d[i] - at[i]);
                let drawn = WIDTHS.map(|w| centre.density(d, w)).iter().sum::<f64>() / 2.0;
                (d, (-0.5 * dot(times(&precise, off), off)).exp() / drawn)
            })
            .collect();
        let found = weighted_moments(&samples, &LinearMoments { mean: [0.0; 3], covariance: own })
            .unwrap_or_else(|| unreachable!());
        assert!((found.mass / determinant(&target).sqrt() - 1.0).abs() < 0.05, "{found:?}");
        for i in 0..3 {
            assert!((found.mean[i] - at[i]).abs() < 0.1, "{found:?}");
            (0..3).for_each(|j| assert!((found.covariance[i][j] - target[i][j]).abs() < 0.25, "{found:?}"));
        }
    }
}
