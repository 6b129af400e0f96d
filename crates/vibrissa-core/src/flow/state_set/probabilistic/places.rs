//! The posterior as places: refinement of all modes, then weights and covariances \[cappe2004population\].

use super::adaptive_sampling::SAMPLES;
use super::admission::{Admission, Admits};
use super::bank::{Bank, Effort, SLACK, WEAK_PRIOR};
use super::goodness_of_fit::{self, Fit};
use super::importance_sampling::{ImportanceSampler, PosteriorMoments, ProposalCentre};
use super::log_window::LogWindow;
use super::map_symmetry::MapSymmetries;
use super::measurement::{Linearisation, MeasurementModel};
use super::optimisation::{Mode, Rerun};
use super::scene::Scene;
use super::state::{difference, moved};
use super::unknowns::{POSE, Parameter};
use super::unobservable::{CurveTracer, Metric};
use crate::contact::follow::Mechanics;
use crate::coroutine::completed;
use crate::flow::pose::Nuisance;
use crate::linear_algebra::{Square, add, congruent, determinant, dot, inverse, times};
use crate::plane::{Pose2, Vec2};

/// Steps in closed form of so many of the best.
const EXACT: usize = 4;
const EXACT_STEPS: usize = 2;
/// With more modes than this those within each other's region are joined at first, and no more are looked at.
const MANY_AT_THE_END: usize = 100;
const MOST_AT_THE_END: usize = 500;
/// A mode this much less likely than the best (nats) is not told.
const REPORTED: f64 = 12.0;
/// Modes nearer than so many standard deviations are one place,
const LINKED: f64 = 9.0;
/// or nearer than this (m, rad).
const LINK_PLACE: f64 = 4e-3;
const LINK_TURN: f64 = 0.04;
/// The share of an unobservable direction that one of its modes stands for: the standard deviation of a Gaussian as wide (m).
const UNOBSERVABLE_STD: f64 = 5.6e-3;
/// Modes further apart than this are not compared (m).
const FARTHEST: f64 = 0.1;
/// Area and volume of the regions that hold 95 % of a Gaussian, per root of its covariance's determinant: `pi chi²` and
/// `4/3 pi chi³` with the 95 % points of chi² for two and three degrees of freedom.
const AREA_95: f64 = 18.82;
const VOLUME_95: f64 = 91.5;
/// Places that are sampled: so many, with more than this share of the heaviest one's weight, and no more readings for all
/// samples than this.
const MOST_SAMPLED: usize = 8;
const SAMPLED_ABOVE: f64 = 1e-3;
/// Places with less than this share of it are sampled only once.
const THOROUGH_ABOVE: f64 = 0.02;
const MOST_SAMPLED_TAKES: usize = 600_000;
/// Readings that the walks along unobservable directions may run, of all places.
const MOST_WALKED_TAKES: usize = 600_000;
/// Most modes that are looked at while rows come.
const MOST_NOW: usize = 40;
/// An error that the robot does not bound is told where it is more than so many standard deviations from none.
const TELLING: f64 = 3.0;
/// One place that explains the readings.
#[derive(Clone, Debug, PartialEq)]
pub struct PosteriorPlace {
    /// The odometry frame in the map frame at the last row, of the place's best mode.
    pub map_from_odom: Pose2,
    /// Its share among all places.
    pub weight: f64,
    /// Covariance of the robot's pose (x, y, heading; map frame) at the last row.
    pub covariance: [[f64; 3]; 3],
    /// The robot's poses at the last row, of all modes of this place, the best first, each with its covariance.
    pub members: Vec<(Pose2, [[f64; 3]; 3])>,
    /// The robot's poses at the last row along the curve on which the readings leave it, where that is long; else empty.
    pub ridge: Vec<Pose2>,
    /// Share of the rows whose reading breaks its declared bound at the best mode.
    pub broken: f64,
    /// The calibration parameters by which the odometry's increments are too short, go aside (rad) and turn too little, each with its standard
    /// deviation; none where it is declared right.
    pub calibration: Option<[[f64; 2]; 3]>,
    /// What the readings say of other quantities that the robot bounds.
    pub nuisances: Vec<Nuisance>,
}

/// Area and volume of all modes' 95 % regions, overlaps counted twice.
pub(super) async fn size(bank: &Bank, model: &MeasurementModel<'_>) -> (f64, f64) {
    let mut size = (0.0, 0.0);
    for mode in &bank.modes {
        let c = covariance(mode, model);
        let area = (c[0][0] * c[1][1] - c[0][1] * c[1][0]).max(0.0).sqrt();
        size = (size.0 + AREA_95 * area, size.1 + VOLUME_95 * determinant(&c).max(0.0).sqrt());
        model.works(1).await;
    }
    size
}

/// The covariance of a mode's pose at the anchor.
fn covariance(mode: &Mode, model: &MeasurementModel<'_>) -> Square<3> {
    mode.marginal(model).covariance(WEAK_PRIOR).unwrap_or([
        [WEAK_PRIOR[0].recip(), 0.0, 0.0],
        [0.0, WEAK_PRIOR[1].recip(), 0.0],
        [0.0, 0.0, WEAK_PRIOR[2].recip()],
    ])
}

/// What is said before the end: modes as they are linearised now, nothing run again and nothing sampled.
pub(super) fn linearised(bank: &Bank, scene: &Scene<'_>, window: &LogWindow) -> Vec<PosteriorPlace> {
    let (first, end) = (scene.model(window, 0), window.len() - 1);
    let last = scene.model(window, end);
    let modes: Vec<Mode> = bank
        .modes
        .iter()
        .take(MOST_NOW)
        .map(|mode| {
            let equations = first.equations_at(mode.equations(), &mode.state, end);
            mode.told_by(first.anchored(&mode.state, end), equations)
        })
        .collect();
    let told: Vec<Square<3>> = modes.iter().map(|mode| covariance(mode, &last)).collect();
    let least = modes.first().map_or(0.0, |mode| mode.cost(&last));
    let by_symmetry = bank.by_symmetry;
    let posterior =
        Posterior { scene, window, model: &last, modes: &modes, told: &told, least, by_symmetry, rerun: None };
    // Nothing is run again, and so nothing pauses.
    completed(posterior.places())
}

/// Settles the modes, weighs and groups them.
pub(super) async fn choose(
    bank: &mut Bank,
    scene: &Scene<'_>,
    window: &LogWindow,
) -> (Vec<PosteriorPlace>, Option<Fit>) {
    let admission = Admission::new(scene, window);
    let admits = |frame: Pose2| admission.is_allowed(frame);
    let first = scene.model(window, 0);
    bank.extend(&first, &admits, Effort { gate: REPORTED + 2.0 * SLACK, ..Effort::ONLINE }).await;
    if window.heading().is_some() {
        bank.expand_images(&scene.symmetries);
    }
    // Most lie along straight walls, where their neighbours say the same.
    if bank.modes.len() > MANY_AT_THE_END {
        bank.join_overlapping(&first).await;
    }
    bank.modes.truncate(MOST_AT_THE_END);
    let end = window.len() - 1;
    bank.anchor(&first, end);
    let model = scene.model(window, end);
    bank.refine(&model, REPORTED).await;
    settle_exactly(bank, &model).await;
    bank.modes.retain(|mode| admits(first_frame(&model, mode)));
    bank.gather_images(&scene.symmetries, &model).await;
    bank.join_overlapping(&model).await;
    if bank.modes.is_empty() {
        return (Vec::new(), None);
    }
    let fit = goodness_of_fit::of_bank(bank, &model).await;
    if fit.is_disputed {
        bank.discount_refuted(&model).await;
    }
    let told: Vec<Square<3>> = bank.modes.iter().map(|mode| covariance(mode, &model)).collect();
    let least = bank.modes.iter().map(|mode| mode.cost(&model)).fold(f64::INFINITY, f64::min);
    let rerun = Rerun { model: &model, rows: &bank.rows };
    let posterior = Posterior {
        scene,
        window,
        model: &model,
        modes: &bank.modes,
        told: &told,
        least,
        by_symmetry: bank.by_symmetry,
        rerun: Some(&rerun),
    };
    (posterior.places().await, Some(fit))
}

/// The frame of a mode with the path held at the first row.
fn first_frame(model: &MeasurementModel<'_>, mode: &Mode) -> Pose2 {
    model.anchored(&mode.state, 0).frame
}

/// Moves the best modes on in closed form.
async fn settle_exactly(bank: &mut Bank, model: &MeasurementModel<'_>) {
    let exact = MeasurementModel { solver: Mechanics::ClosedForm, ..*model };
    let mut scratch = Linearisation::default();
    for mode in bank.modes.iter_mut().take(EXACT) {
        let before = mode.clone();
        mode.relinearise(&exact, &bank.rows, &mut scratch).await;
        mode.descend(&exact, &bank.rows, EXACT_STEPS, &mut scratch).await;
        if mode.cost(model) > before.cost(model) + 1.0 {
            *mode = before;
        }
    }
    bank.sort(model).await;
}

/// The modes at the end, each with the covariance of its pose at the last row.
struct Posterior<'a> {
    scene: &'a Scene<'a>,
    window: &'a LogWindow,
    model: &'a MeasurementModel<'a>,
    modes: &'a [Mode],
    told: &'a [Square<3>],
    /// The least cost of all.
    least: f64,
    /// Whether each mode stands for all its images.
    by_symmetry: bool,
    /// What it takes to sample and to trace.
    rerun: Option<&'a Rerun<'a>>,
}

impl Posterior<'_> {
    /// Places of modes that overlap, weighed by their shares of the likelihood.
    async fn places(&self) -> Vec<PosteriorPlace> {
        let mut groups: Vec<(f64, Vec<usize>)> =
            self.groups().into_iter().map(|members| (self.mass(&members), members)).collect();
        groups.sort_by(|a, b| b.0.total_cmp(&a.0));
        let most = groups.first().map_or(0.0, |g| g.0);
        let admission = Admission::new(self.scene, self.window);
        let lever = self.scene.sensors.iter().map(|f| f.length).fold(f64::MIN_POSITIVE, f64::max);
        let admits = |frame: Pose2| admission.is_allowed(frame);
        let stands = |frame: Pose2| admits(frame) && self.stands_free(frame);
        let mut tracer = self.rerun.map(|rerun| CurveTracer {
            rerun,
            metric: Metric { pivot: self.model.pivot(), lever },
            admits: &stands,
            left: MOST_WALKED_TAKES,
            known: Vec::new(),
        });
        let afford = self.rerun.map_or(0, |rerun| (MOST_SAMPLED_TAKES / (SAMPLES * rerun.rows.len()).max(1)).max(1));
        let last = self.window.last_pose();
        let mut places: Vec<PosteriorPlace> = Vec::with_capacity(groups.len());
        for (index, (mass, members)) in groups.iter().enumerate() {
            let near = index < afford.min(MOST_SAMPLED) && *mass > SAMPLED_ABOVE * most;
            let thorough = *mass > THOROUGH_ABOVE * most;
            let spread = if near { self.moments(members, thorough, &admits).await } else { None };
            let with: Vec<_> = members.iter().map(|&i| (&self.modes[i], &self.told[i])).collect();
            let frames = match tracer.as_mut().filter(|_| *mass > SAMPLED_ABOVE * most) {
                Some(tracer) => tracer.trace(&with).await,
                None => Vec::new(),
            };
            let ridge = frames.into_iter().map(|frame| frame.compose(last)).collect();
            places.push(PosteriorPlace { ridge, ..self.place(members, *mass, spread).await });
        }
        if self.by_symmetry {
            places = places.iter().flat_map(|place| images_of(&self.scene.symmetries, place)).collect();
        }
        let total: f64 = places.iter().map(|p| p.weight).sum();
        places.iter_mut().for_each(|p| p.weight /= total);
        places.sort_by(|a, b| b.weight.total_cmp(&a.weight));
        places
    }

    /// Whether the robot's origin and its whiskers' bases are in free space at the last row.
    fn stands_free(&self, frame: Pose2) -> bool {
        let robot = frame.compose(self.window.last_pose());
        let mounts = self.scene.sensors.iter().map(|sensor| sensor.robot_from_whisker.position());
        mounts.chain([Vec2::ZERO]).all(|place| self.scene.map.is_free(robot.transform_point(place)))
    }

    /// Modes that are linked, directly or through others, the best first.
    fn groups(&self) -> Vec<Vec<usize>> {
        let mut open: Vec<usize> = (0..self.modes.len()).collect();
        let mut groups = Vec::new();
        while !open.is_empty() {
            let mut members = vec![open.remove(0)];
            let mut next = 0;
            while next < members.len() {
                let at = members[next];
                let (joined, left): (Vec<_>, Vec<_>) = open.iter().partition(|&&i| self.are_linked(at, i));
                members.extend(joined);
                open = left;
                next += 1;
            }
            groups.push(members);
        }
        groups
    }

    fn are_linked(&self, a: usize, b: usize) -> bool {
        let pivot: Vec2 = self.model.pivot();
        let d = difference(self.modes[a].state.frame, self.modes[b].state.frame, pivot);
        if d[0].hypot(d[1]) > FARTHEST {
            return false;
        }
        if d[0].hypot(d[1]) < LINK_PLACE && d[2].abs() < LINK_TURN {
            return true;
        }
        let mut sum = self.told[a];
        add(&mut sum, &self.told[b]);
        inverse(&sum).is_some_and(|i| dot(times(&i, d), d) < LINKED)
    }

    /// The share of the likelihood as the linearisations say it.
    fn mass(&self, members: &[usize]) -> f64 {
        // Neighbours on an unobservable direction share its length among them.
        let narrow = if members.len() > 1 { UNOBSERVABLE_STD.powi(-2) } else { 0.0 };
        let one = |&i: &usize| {
            let mut curvature = inverse(&self.told[i]).unwrap_or_default();
            (0..2).for_each(|k| curvature[k][k] += narrow);
            let less = self.least - self.modes[i].cost(self.model);
            less.exp() / determinant(&curvature).max(f64::MIN_POSITIVE).sqrt()
        };
        members.iter().map(one).sum()
    }

    /// What sampling says about a place.
    async fn moments(&self, members: &[usize], thorough: bool, admits: &Admits<'_>) -> Option<PosteriorMoments> {
        let member = |&i: &usize| ProposalCentre { place: &self.modes[i], own: &self.told[i] };
        let members: Vec<ProposalCentre<'_>> = members.iter().map(member).collect();
        ImportanceSampler { rerun: self.rerun?, least: self.least, admits, thorough }.posterior_moments(&members).await
    }

    async fn place(&self, members: &[usize], mass: f64, spread: Option<PosteriorMoments>) -> PosteriorPlace {
        let (first, last) = (&self.modes[members[0]], self.window.last_pose());
        let (map_from_odom, weight, told) = match spread {
            Some(spread) => {
                let mean = moved(first.state.frame, self.model.pivot(), spread.mean);
                (mean, spread.mass, vec![(mean.compose(last), spread.covariance)])
            }
            None => {
                let linear = |&i: &usize| (self.modes[i].state.frame.compose(last), self.told[i]);
                (first.state.frame, mass, members.iter().map(linear).collect())
            }
        };
        let state = first.state_at(self.model, map_from_odom);
        let covariance = told[0].1;
        let stds: Vec<f64> = first
            .response()
            .map_or_else(Vec::new, |response| (0..state.values.len()).map(|k| response.std(k, &covariance)).collect());
        let calibration = self.model.unknowns.odometry.map(|at| {
            [0, 1, 2].map(|k| [state.values[at - POSE + k], stds.get(at - POSE + k).copied().unwrap_or(0.0)])
        });
        let broken = match self.rerun {
            Some(rerun) => {
                let mut told = Linearisation::default();
                self.model.run(&first.state, &first.start, rerun.rows, &mut told).await;
                goodness_of_fit::of_run(&told, first.fit().noise, self.model.noise_model).broken
            }
            None => 0.0,
        };
        PosteriorPlace {
            map_from_odom,
            weight,
            covariance,
            members: told,
            ridge: Vec::new(),
            broken,
            calibration,
            nuisances: self.nuisances(&state.values, &stds),
        }
    }

    /// The nuisance parameters as they are told.
    fn nuisances(&self, values: &[f64], stds: &[f64]) -> Vec<Nuisance> {
        let (robot, declared) = (&self.scene.robot, self.scene.declared);
        let one = |((unknown, value), std): ((&super::unknowns::Unknown, &f64), &f64)| {
            let parameter: Parameter = unknown.parameter;
            let (quantity, whisker, per, bound) = parameter.told(robot, &self.scene.senses)?;
            let name = |at: usize| robot.whiskers.get(at).map(|w| w.name.clone());
            let tared = match (parameter, &self.scene.tare) {
                (Parameter::Zero(sensor), Some(tare)) => tare[sensor],
                _ => 0.0,
            };
            let is_declared = parameter.told(declared, &self.scene.senses)?.3 > 0.0;
            let is_telling = (value + tared).abs() > TELLING * std;
            (bound > 0.0 && (is_declared || is_telling)).then(|| Nuisance {
                quantity,
                whisker: whisker.and_then(name),
                estimate: (value + tared) * per,
                std: std * per,
                bound,
            })
        };
        self.model.unknowns.all().iter().zip(values).zip(stds).filter_map(one).collect()
    }
}

/// A place and its images: no log tells them apart, so they weigh the same.
fn images_of(symmetries: &MapSymmetries, place: &PosteriorPlace) -> Vec<PosteriorPlace> {
    let turned = |frame: Pose2| {
        let motion = frame.compose(place.map_from_odom.inverse());
        let (sin, cos) = motion.theta.sin_cos();
        let own = |m: &Square<3>| congruent(&[[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]], m);
        PosteriorPlace {
            map_from_odom: frame,
            covariance: own(&place.covariance),
            members: place.members.iter().map(|(pose, c)| (motion.compose(*pose), own(c))).collect(),
            nuisances: place.nuisances.clone(),
            ridge: place.ridge.iter().map(|pose| motion.compose(*pose)).collect(),
            ..*place
        }
    };
    symmetries.images(place.map_from_odom).map(turned).collect()
}
