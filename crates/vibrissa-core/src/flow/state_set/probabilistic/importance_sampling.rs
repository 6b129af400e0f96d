//! Moments of the posterior around a place by adaptive importance sampling \[oh1992adaptive, cappe2004population\]: each sample is a pose,
//! with the nuisance parameters marginalised around it.

use super::adaptive_sampling::{
    Cost, FIRST, MOST_CENTRES, NOTHING, ProposalComponent, SAMPLES, SampleCounts, WeightedMoments, is_gaussian,
    sample_adaptively,
};
use super::admission::Admits;
use super::optimisation::{Mode, Rerun};
use super::state::{difference, moved};
use crate::linear_algebra::{Square, determinant};

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
    pub(super) admits: &'a Admits<'a>,
    /// Whether the first samples will not do.
    pub(super) thorough: bool,
}

impl ImportanceSampler<'_> {
    /// The spread of the place of these hypotheses, the best first. None where it cannot be sampled.
    pub(super) async fn posterior_moments(&self, members: &[ProposalCentre<'_>]) -> Option<PosteriorMoments> {
        let first = members.first()?;
        let model = self.rerun.model;
        let to = |mode: &Mode| difference(first.place.state.frame, mode.state.frame, model.pivot());
        let centres: Vec<_> =
            members.iter().take(MOST_CENTRES).filter_map(|m| ProposalComponent::new(to(m.place), m.own)).collect();
        let cost = AroundPlace { sampler: self, place: first.place };
        let told = |drawn: &[([f64; 3], Option<f64>)]| {
            let parabola = first.place.marginal(model);
            is_gaussian(drawn, parabola.constant, |d| parabola.shifted(d).constant).then_some(())?;
            let covariance = parabola.covariance([0.0; 3])?;
            let (cost, mean) = parabola.least([0.0; 3]);
            let mass = (self.least - cost).exp() * determinant(&covariance).sqrt();
            Some(WeightedMoments { mean, covariance, mass, effective_size: f64::INFINITY })
        };
        let batch = SAMPLES - FIRST;
        let effort = SampleCounts { first: FIRST, batch, batches: usize::from(self.thorough) };
        let found = sample_adaptively(&centres, first.own, (&effort, self.least), &cost, told).await?;
        let WeightedMoments { mean, covariance, mass, .. } = found;
        Some(PosteriorMoments { mean, covariance, mass })
    }
}

/// What the readings cost where the frame of a place is moved.
struct AroundPlace<'a> {
    sampler: &'a ImportanceSampler<'a>,
    place: &'a Mode,
}

impl Cost<3> for AroundPlace<'_> {
    async fn at(&self, d: [f64; 3]) -> Option<f64> {
        let ImportanceSampler { rerun, least, admits, .. } = self.sampler;
        let frame = moved(self.place.state.frame, rerun.model.pivot(), d);
        admits(frame).then_some(())?;
        let cost = rerun.at(self.place, frame).await.cost(rerun.model);
        Some(if cost > least + NOTHING { f64::INFINITY } else { cost })
    }
}
