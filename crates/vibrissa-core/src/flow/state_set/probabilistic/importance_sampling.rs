//! Moments of the posterior around a place by adaptive importance sampling \[oh1992adaptive, cappe2004population\] over pose and nuisance
//! parameters, the latter drawn from the linearisation's law given the pose \[geweke1989bayesian\].
//!
//! Snaps make the likelihood a set of narrow slots. Which of them a pose is in depends on mounts and lengths as well: with these at their best for each
//! pose, a slot of the pose would be as narrow as if they were known.

use super::adaptive_sampling::{
    Cost, FIRST, LinearMoments, MOST_CENTRES, NOTHING, ProposalComponent, SAMPLES, SampleCounts, TRIED, WIDTHS,
    WeightedMoments, is_gaussian, normal_numbers, sample_adaptively,
};
use super::admission::Admits;
use super::measurement::{Linearisation, MeasurementModel};
use super::normal_equations::Response;
use super::optimisation::{Mode, Rerun};
use super::state::{State, difference, moved};
use super::unknowns::POSE;
use crate::linear_algebra::{DenseCholesky, Square, determinant};
use crate::plane::Pose2;

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
        if let [_] = &centres[..]
            && let Some(moments) = self.moments_by_parabola(first.place, &centres[0]).await
        {
            return Some(moments);
        }
        let batch = SAMPLES - FIRST;
        let effort = SampleCounts { first: FIRST, batch, batches: usize::from(self.thorough) };
        let cost =
            JointCost { sampler: self, place: first.place, nuisances: NuisanceProposal::new(first.place, model) };
        let linear = linear_moments(members, model)?;
        let found = sample_adaptively(&centres, &linear, (&effort, self.least), &cost).await?;
        let WeightedMoments { mean, covariance, mass, .. } = found;
        Some(PosteriorMoments { mean, covariance, mass })
    }

    /// Those of the parabola around a place, if it tells what poses around it cost where the nuisance parameters are as the readings would have them
    /// there.
    async fn moments_by_parabola(&self, place: &Mode, around: &ProposalComponent<POSE>) -> Option<PosteriorMoments> {
        let model = self.rerun.model;
        let mut drawn = Vec::with_capacity(TRIED);
        for index in 0..TRIED {
            let point = around.sample(index, WIDTHS[index % WIDTHS.len()]);
            let cost = match self.frame(place, point) {
                Some(frame) => Some(self.rerun.at(place, frame).await.cost(model)),
                None => None,
            };
            drawn.push((point, cost.map(|cost| self.cut(cost))));
        }
        let parabola = place.marginal(model);
        is_gaussian(&drawn, parabola.constant, |d| parabola.shifted(d).constant).then_some(())?;
        let covariance = parabola.covariance([0.0; POSE])?;
        let (cost, mean) = parabola.least([0.0; POSE]);
        Some(PosteriorMoments { mean, covariance, mass: (self.least - cost).exp() * determinant(&covariance).sqrt() })
    }

    /// The frame of a place moved by this, where it may be.
    fn frame(&self, place: &Mode, d: [f64; POSE]) -> Option<Pose2> {
        let frame = moved(place.state.frame, self.rerun.model.pivot(), d);
        (self.admits)(frame).then_some(frame)
    }

    /// A cost, or infinitely much where it is that of what weighs nothing.
    fn cut(&self, cost: f64) -> f64 {
        if cost > self.least + NOTHING { f64::INFINITY } else { cost }
    }
}

/// The moments of a mixture of the linearisations around these hypotheses \[mclachlan2000finite\].
fn linear_moments(members: &[ProposalCentre<'_>], model: &MeasurementModel<'_>) -> Option<LinearMoments<POSE>> {
    let first = members.first()?.place;
    let least = members.iter().map(|member| member.place.cost(model)).fold(f64::INFINITY, f64::min);
    let weight = |member: &ProposalCentre<'_>| {
        (least - member.place.cost(model)).exp() * determinant(member.own).max(0.0).sqrt()
    };
    let weights: Vec<f64> = members.iter().map(weight).collect();
    let total: f64 = weights.iter().sum();
    let at = |member: &ProposalCentre<'_>| difference(first.state.frame, member.place.state.frame, model.pivot());
    let places: Vec<[f64; POSE]> = members.iter().map(at).collect();
    let mean: [f64; POSE] =
        core::array::from_fn(|i| weights.iter().zip(&places).map(|(w, d)| w * d[i]).sum::<f64>() / total);
    let mut covariance = [[0.0; POSE]; POSE];
    for ((member, weight), d) in members.iter().zip(&weights).zip(&places) {
        for (i, row) in covariance.iter_mut().enumerate() {
            for (j, value) in row.iter_mut().enumerate() {
                *value += weight / total * (member.own[i][j] + (d[i] - mean[i]) * (d[j] - mean[j]));
            }
        }
    }
    Some(LinearMoments { mean, covariance })
}

/// The law from which nuisance parameters are drawn where the pose is given: the linearisation's around a place.
struct NuisanceProposal {
    response: Response,
    factor: DenseCholesky,
    /// Half the logarithm of their information's determinant, in units of what was known before.
    half_ln_information: f64,
}

impl NuisanceProposal {
    /// None where there are no such parameters, or the readings leave one undetermined.
    fn new(place: &Mode, model: &MeasurementModel<'_>) -> Option<Self> {
        let response = place.response()?;
        let factor = DenseCholesky::new(response.mean.len(), &response.covariance)?;
        let known: f64 = model.unknowns.all().iter().map(|unknown| unknown.std.ln()).sum();
        let half_ln_information = known - 0.5 * factor.ln_determinant();
        Some(Self { response, factor, half_ln_information })
    }

    /// The `n`-th step of the parameters for a step of the pose, and minus the logarithm of its density, with what was known before as the unit.
    fn sample(&self, n: usize, d: [f64; POSE]) -> (Vec<f64>, f64) {
        let off = normal_numbers(n, self.response.mean.len());
        let steps = self.response.given(d).into_iter().zip(self.factor.lower_times(&off)).map(|(mean, off)| mean + off);
        (steps.collect(), 0.5 * off.iter().map(|z| z * z).sum::<f64>() - self.half_ln_information)
    }
}

/// What the readings cost at a pose and at nuisance parameters drawn around those that they would have there, over the density of these: in the
/// mean over many it is what the pose costs with the parameters marginalised.
struct JointCost<'a> {
    sampler: &'a ImportanceSampler<'a>,
    place: &'a Mode,
    nuisances: Option<NuisanceProposal>,
}

impl Cost<POSE> for JointCost<'_> {
    async fn at(&self, n: usize, d: [f64; POSE]) -> Option<f64> {
        let Self { sampler, place, nuisances } = self;
        let frame = sampler.frame(place, d)?;
        let (steps, density) = nuisances.as_ref().map_or_else(Default::default, |nuisances| nuisances.sample(n, d));
        let mut values = place.state.values.clone();
        values.iter_mut().zip(steps).for_each(|(value, step)| *value += step);
        let Rerun { model, rows } = sampler.rerun;
        let there = place.at(State { frame, values }, model, rows, &mut Linearisation::default()).await;
        Some(sampler.cut(there.equations().constant - there.fit().credit - density))
    }
}
