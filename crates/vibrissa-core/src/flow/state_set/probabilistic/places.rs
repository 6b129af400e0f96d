//! The posterior as places: refinement of all hypotheses, then weights and covariances \[cappe2004population\].

use super::bank::{BankContext, HypothesisBank, WEAK_PRIOR};
use super::calibrated_path::CALIBRATION_SIZE;
use super::congruent_places::{congruent_places, is_free_throughout};
use super::consistency::{Consistency, fit, fit_by};
use super::hypothesis::{GaussianHypothesis, MeasurementModel, difference, moved};
use super::importance_sampling::{
    ImportanceSampler, JOINT_SIZE, PosteriorMoments, ProposalCentre, SAMPLES, SAMPLES_WITH_CALIBRATION,
};
use super::log_window::LogWindow;
use super::map_symmetry::MapSymmetries;
use super::multistart::multistart;
use super::odometry_calibration::Matrix;
use super::sensor::LikelihoodOptions;
use super::unobservable::{CurveTracer, Metric};
use crate::contact::follow::Mechanics;
use crate::flow::pose::Nuisance;
use crate::linear_algebra::{add, congruent, determinant, dot, inverse, times};
use crate::plane::{Pose2, Vec2};
use crate::world::Odometry;

/// Hypotheses that are refined to the end in closed form, the best first.
const EXACT: usize = 4;
/// Rows that the first Gauss-Newton steps of all hypotheses take, and how many steps there are; then those over all rows.
const FIRST_ROWS: [usize; 2] = [24, 48];
const FIRST_ROUNDS: [usize; 2] = [1, 2];
const ROUNDS: usize = 3;
pub(super) const LAST_ROUNDS: usize = 8;
/// Those in closed form that follow.
const EXACT_ROUNDS: usize = 2;
/// How often the odometry is corrected and all are moved to their least cost again.
const CORRECTIONS: usize = 4;
/// Errors of the odometry that are not the same share of every increment come to as much as one share that is smaller by the root of
/// how many there are, times this.
const VARYING: f64 = 4.0;
/// Readings, times hypotheses, that are run again at the end; beyond, every second, every third … row must do.
const MOST_TAKES: usize = 150_000;
/// The same for the second round of all that are left, before the few that stay take all rows.
const SECOND_TAKES: usize = 15_000;
/// The best few are kept as they are, too, while the others are sorted out with some of the rows: a whisker that springs from
/// facet to facet is somewhere else where rows are left out. So many steps they take over all rows.
const FOREMOST: usize = 4;
const FOREMOST_ROUNDS: usize = 2;
/// Most hypotheses that are looked at in the end.
const MOST: usize = 500;
/// Every so many rows the robot's origin must stand in free space.
const STANDS_EVERY: usize = 10;
/// Slack for those that are not at their least yet (nats).
const SLACK: f64 = 6.0;
/// Slack for those that have been moved only once since these rows are asked (nats).
const UNSETTLED: f64 = 20.0;
/// A hypothesis this much less likely than the best (nats) is not told.
pub(super) const REPORTED: f64 = 12.0;
/// Hypotheses nearer than so many standard deviations are one place,
const LINKED: f64 = 9.0;
/// or nearer than this (m, rad).
const LINK_PLACE: f64 = 4e-3;
const LINK_TURN: f64 = 0.04;
/// The share of an unobservable direction that one of its hypotheses stands for: the standard deviation of a Gaussian as wide (m).
const UNOBSERVABLE_STD: f64 = 5.6e-3;
/// Hypotheses further apart than this are not compared (m).
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
const MOST_WALKED_TAKES: usize = 300_000;

/// One place that explains the readings.
#[derive(Clone, Debug, PartialEq)]
pub struct PosteriorPlace {
    /// The odometry frame in the map frame at the last row, of the place's best hypothesis.
    pub map_from_odom: Pose2,
    /// Its share among all places.
    pub weight: f64,
    /// Covariance of the robot's pose (x, y, heading; map frame) at the last row.
    pub covariance: [[f64; 3]; 3],
    /// The robot's poses at the last row, of all hypotheses of this place, the best first, each with its covariance.
    pub members: Vec<(Pose2, [[f64; 3]; 3])>,
    /// The robot's poses at the last row along the curve on which the readings leave it, where that is long; else empty.
    pub ridge: Vec<Pose2>,
    /// Share of the rows whose reading breaks its declared bound at the best hypothesis.
    pub broken: f64,
    /// The calibration parameters by which the odometry's increments are too short, go aside (rad) and turn too little, each with its standard
    /// deviation; none where it is declared right.
    pub calibration: Option<[[f64; 2]; 3]>,
    /// What the readings say of other quantities that the robot bounds.
    pub nuisances: Vec<Nuisance>,
}

/// Area and volume of all hypotheses' 95 % regions, overlaps counted twice.
pub(super) fn size(bank: &HypothesisBank) -> (f64, f64) {
    let one = |h: &GaussianHypothesis| {
        let c = covariance(h, bank);
        let area = (c[0][0] * c[1][1] - c[0][1] * c[1][0]).max(0.0).sqrt();
        (AREA_95 * area, VOLUME_95 * determinant(&c).max(0.0).sqrt())
    };
    bank.hypotheses.iter().map(one).fold((0.0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1))
}

/// Settles the hypotheses, weighs and groups them.
pub(super) fn choose(
    bank: &mut HypothesisBank,
    context: &BankContext<'_>,
    history: &mut LogWindow,
) -> (Vec<PosteriorPlace>, Option<Consistency>) {
    let shared = bank.shared;
    if shared.has_odometry() {
        history.end();
    }
    bank.hypotheses
        .sort_by(|a, b| a.predicted_cost(WEAK_PRIOR, shared).total_cmp(&b.predicted_cost(WEAK_PRIOR, shared)));
    bank.hypotheses.truncate(MOST);
    let foremost = leading(bank, context, history);
    let stages = [(FIRST_ROWS[0], FIRST_ROUNDS[0], 3.0), (FIRST_ROWS[1], FIRST_ROUNDS[1], 1.0), (0, ROUNDS, 1.0)];
    for (rows, rounds, slack) in stages {
        let rows = if rows > 0 { rows } else { SECOND_TAKES / bank.hypotheses.len().max(1) };
        bank.use_rows(context, history, rows, REPORTED + slack * SLACK + UNSETTLED);
        bank.optimise(context, history, rounds, 0);
        let least = bank.hypotheses.iter().map(|h| h.cost(shared)).fold(f64::INFINITY, f64::min);
        bank.hypotheses.retain(|h| h.cost(shared) <= least + REPORTED + slack * SLACK);
    }
    bank.gather_images(context.symmetries);
    let asked = bank.hypotheses.first().map(|h| h.map_from_odom);
    let equals = congruent_places(bank, context, history);
    bank.hypotheses.extend(equals);
    let afford = MOST_TAKES / bank.hypotheses.len().max(1);
    if bank.leaves_out_rows(history) && afford > bank.used.len() {
        bank.use_rows(context, history, afford, REPORTED + UNSETTLED);
    }
    bank.readmit(context, history, foremost);
    bank.optimise(context, history, LAST_ROUNDS, 0);
    if !bank.hypotheses.first().zip(asked).is_some_and(|(best, asked)| is_near(asked, best, bank)) {
        // Its equals may stand where others have got stuck.
        let equals = congruent_places(bank, context, history);
        bank.hypotheses.extend(equals);
        bank.optimise(context, history, LAST_ROUNDS, 0);
    }
    for _ in 0..CORRECTIONS {
        if !bank.recalibrate_odometry(context, history) {
            break;
        }
        bank.optimise(context, history, LAST_ROUNDS, 0);
    }
    if bank.search_calibration(context, history) {
        bank.optimise(context, history, LAST_ROUNDS, 0);
    }
    multistart(bank, context, history);
    if bank.recalibrate_odometry(context, history) {
        bank.optimise(context, history, LAST_ROUNDS, 0);
    }
    bank.optimise(context, history, EXACT_ROUNDS, EXACT);
    bank.hypotheses.retain(|h| is_allowed(context, history, h.map_from_odom));
    let least = bank.hypotheses.iter().map(|h| h.cost(bank.shared)).fold(f64::INFINITY, f64::min);
    bank.hypotheses.retain(|h| h.cost(shared) <= least + REPORTED);
    bank.gather_images(context.symmetries);
    let mut fit = bank.hypotheses.first().map(|h| fit(h, bank, context, history));
    let blurred = MeasurementModel {
        model_error: true,
        ..context.model(history, bank.pivot, LikelihoodOptions::DECLARED, bank.shared)
    };
    let quick = context.model(history, bank.pivot, LikelihoodOptions::DECLARED, bank.shared);
    let last = history.pose(history.len() - 1);
    let bounds = &context.robot.odometry;
    let mut told = Vec::with_capacity(bank.hypotheses.len());
    for h in &bank.hypotheses {
        let mut again = h.clone();
        again.relinearise(&blurred, h.map_from_odom, bank.used.iter().copied());
        if let Some(fit) = fit.as_mut().filter(|_| told.is_empty()) {
            fit.odometry = again.belief.squares(bounds) / f64::from(fit.touching.max(1) as u32);
        }
        let arm = h.map_from_odom.transform_point(last.position()) - h.map_from_odom.transform_point(bank.pivot);
        let (turn, rest) = (h.map_from_odom.theta, rest(bounds, history.len()));
        let place = covariance(&again, bank);
        let response = again.belief.calibration(bank.shared);
        told.push(SettledHypothesis {
            place,
            with_calibration: response.map(|response| response.joint(&place)),
            calibration: response.map(|response| again.belief.calibrated(&response, &place)),
            rest: again.belief.covariance(bank.shared, WEAK_PRIOR, turn, arm, &rest),
            broken: fit_by(Mechanics::Table(context.table), h, bank, context, history).broken,
        });
    }
    (FinalSet { context, history, bank, told: &told, last, least }.places(&quick), fit)
}

/// Whether a hypothesis stands where this frame does, give or take what joins two.
fn is_near(frame: Pose2, h: &GaussianHypothesis, bank: &HypothesisBank) -> bool {
    let [x, y, turn] = difference(frame, h.map_from_odom, bank.pivot);
    x.hypot(y) < LINK_PLACE && turn.abs() < LINK_TURN
}

/// The best few that stand apart, moved to their least cost over the rows that they have taken.
fn leading(bank: &HypothesisBank, context: &BankContext<'_>, history: &LogWindow) -> Vec<GaussianHypothesis> {
    let chosen = bank.apart(0..bank.hypotheses.len(), FOREMOST);
    let mut few =
        bank.with_hypotheses(chosen.iter().map(|&index| bank.hypotheses[index].clone()).collect(), bank.used.clone());
    few.optimise(context, history, FOREMOST_ROUNDS, 0);
    few.hypotheses
}

/// Whether the robot may have been where this frame says.
fn is_allowed(context: &BankContext<'_>, history: &LogWindow, frame: Pose2) -> bool {
    let mut rows = (0..history.len()).rev().step_by(STANDS_EVERY);
    context.satisfies_prior(history, frame) && rows.all(|row| context.origin_is_free(history, frame, row))
}

/// The covariance of the estimate about the pivot.
pub(super) fn covariance(h: &GaussianHypothesis, bank: &HypothesisBank) -> Matrix {
    h.marginal(bank.shared).covariance(WEAK_PRIOR).unwrap_or([
        [WEAK_PRIOR[0].recip(), 0.0, 0.0],
        [0.0, WEAK_PRIOR[1].recip(), 0.0],
        [0.0, 0.0, WEAK_PRIOR[2].recip()],
    ])
}

/// What a hypothesis says at the end.
struct SettledHypothesis {
    /// The covariance of its place, and that of place and shares together where these are looked for.
    place: Matrix,
    with_calibration: Option<[[f64; JOINT_SIZE]; JOINT_SIZE]>,
    /// The odometry's calibration parameters, each with its standard deviation.
    calibration: Option<[[f64; 2]; CALIBRATION_SIZE]>,
    /// What errors of the odometry add to its covariance that are not alike for all rows.
    rest: Matrix,
    /// Share of the readings that break their bounds.
    broken: f64,
}

/// The hypotheses at the end, each with what it says.
struct FinalSet<'a> {
    context: &'a BankContext<'a>,
    history: &'a LogWindow,
    bank: &'a HypothesisBank,
    told: &'a [SettledHypothesis],
    /// The odometry at the last row.
    last: Pose2,
    /// The least cost of all.
    least: f64,
}

impl FinalSet<'_> {
    /// Places of hypotheses that overlap, weighed by their shares of the likelihood.
    fn places(&self, model: &MeasurementModel<'_>) -> Vec<PosteriorPlace> {
        let mut groups: Vec<(f64, Vec<usize>)> =
            self.groups().into_iter().map(|members| (self.mass(&members), members)).collect();
        groups.sort_by(|a, b| b.0.total_cmp(&a.0));
        let most = groups.first().map_or(0.0, |g| g.0);
        let samples = if self.bank.shared.has_odometry() { SAMPLES_WITH_CALIBRATION } else { SAMPLES };
        let afford = (MOST_SAMPLED_TAKES / (samples * self.bank.used.len()).max(1)).max(1);
        let mut walker = CurveTracer {
            model,
            rows: &self.bank.used,
            metric: Metric {
                pivot: model.pivot,
                lever: self.context.sensors.iter().map(|f| f.length).fold(f64::MIN_POSITIVE, f64::max),
            },
            admits: &|frame| {
                is_allowed(self.context, self.history, frame)
                    && is_free_throughout(self.context, self.history, frame, &self.bank.used)
            },
            left: MOST_WALKED_TAKES,
            known: Vec::new(),
        };
        let mut places: Vec<PosteriorPlace> = groups
            .iter()
            .enumerate()
            .map(|(index, (mass, members))| {
                let near = index < afford.min(MOST_SAMPLED) && *mass > SAMPLED_ABOVE * most;
                let spread =
                    if near { self.posterior_moments(model, members, *mass > THOROUGH_ABOVE * most) } else { None };
                let with: Vec<_> = members.iter().map(|&i| (&self.bank.hypotheses[i], &self.told[i].place)).collect();
                let frames = if *mass > SAMPLED_ABOVE * most { walker.trace(&with) } else { Vec::new() };
                let ridge: Vec<Pose2> = frames.into_iter().map(|frame| frame.compose(self.last)).collect();
                PosteriorPlace { ridge, ..self.place(members, *mass, spread) }
            })
            .collect();
        if self.bank.by_symmetry {
            places = places.iter().flat_map(|place| images_of(self.context.symmetries, place)).collect();
        }
        let total: f64 = places.iter().map(|p| p.weight).sum();
        places.iter_mut().for_each(|p| p.weight /= total);
        places.sort_by(|a, b| b.weight.total_cmp(&a.weight));
        places
    }

    /// Hypotheses that are linked, directly or through others, the best first.
    fn groups(&self) -> Vec<Vec<usize>> {
        let mut open: Vec<usize> = (0..self.bank.hypotheses.len()).collect();
        let mut groups = Vec::new();
        while !open.is_empty() {
            let mut members = vec![open.remove(0)];
            let mut next = 0;
            while next < members.len() {
                let at = members[next];
                let near = |&i: &usize| linked(self.bank, self.told, at, i);
                members.extend(open.iter().copied().filter(near));
                open.retain(|i| !members.contains(i));
                next += 1;
            }
            groups.push(members);
        }
        groups
    }

    /// The share of the likelihood as the linearisations say it.
    fn mass(&self, members: &[usize]) -> f64 {
        let more = |i: usize| self.least - self.bank.hypotheses[i].cost(self.bank.shared);
        members.iter().map(|&i| mass(more(i), &self.told[i].place, members.len() > 1)).sum()
    }

    /// What sampling says about a place.
    fn posterior_moments(
        &self,
        model: &MeasurementModel<'_>,
        members: &[usize],
        thorough: bool,
    ) -> Option<PosteriorMoments> {
        let member = |&i: &usize| ProposalCentre {
            place: &self.bank.hypotheses[i],
            own: &self.told[i].place,
            with_calibration: self.told[i].with_calibration.as_ref(),
        };
        let members: Vec<ProposalCentre<'_>> = members.iter().map(member).collect();
        let sampled = ImportanceSampler {
            model,
            rows: &self.bank.used,
            least: self.least,
            admits: &|frame| self.context.satisfies_prior(self.history, frame),
            bounds: &self.context.robot.odometry,
            thorough,
        };
        sampled.posterior_moments(&members)
    }

    fn place(&self, members: &[usize], mass: f64, spread: Option<PosteriorMoments>) -> PosteriorPlace {
        let first = &self.bank.hypotheses[members[0]];
        let at = |frame: Pose2, own: &Matrix, index: usize| {
            let (pose, mut covariance) = at_robot(frame, self.bank, own, self.last);
            add(&mut covariance, &self.told[index].rest);
            (pose, covariance)
        };
        let broken = members.iter().map(|&i| self.told[i].broken).fold(1.0, f64::min);
        let calibration = spread.as_ref().and_then(|spread| spread.calibration).or(self.told[members[0]].calibration);
        let (map_from_odom, weight, members) = match spread {
            Some(spread) => {
                let mean = moved(first.map_from_odom, self.bank.pivot, spread.mean);
                (mean, spread.mass, vec![at(mean, &spread.covariance, members[0])])
            }
            None => {
                let linear = members.iter().map(|&i| at(self.bank.hypotheses[i].map_from_odom, &self.told[i].place, i));
                (first.map_from_odom, mass, linear.collect())
            }
        };
        PosteriorPlace {
            map_from_odom,
            weight,
            covariance: members[0].1,
            members,
            ridge: Vec::new(),
            broken,
            calibration,
            nuisances: Vec::new(),
        }
    }
}

/// The share of the likelihood of a hypothesis that costs so much less than the best (nats), by its linearisation.
pub(super) fn mass(less: f64, place: &Matrix, among_others: bool) -> f64 {
    // Neighbours on an unobservable direction share its length among them.
    let narrow = UNOBSERVABLE_STD.powi(-2);
    let mut curvature = inverse(place).unwrap_or_default();
    if among_others {
        (0..2).for_each(|k| curvature[k][k] += narrow);
    }
    less.exp() / determinant(&curvature).max(f64::MIN_POSITIVE).sqrt()
}

/// Whether two hypotheses are one place.
fn linked(bank: &HypothesisBank, told: &[SettledHypothesis], a: usize, b: usize) -> bool {
    let of = |i: usize| (bank.hypotheses[i].map_from_odom, &told[i].place);
    are_linked(of(a), of(b), bank.pivot)
}

/// Whether two odometry frames in the map frame, each with its covariance about the pivot, are one place.
pub(super) fn are_linked(a: (Pose2, &Matrix), b: (Pose2, &Matrix), pivot: Vec2) -> bool {
    let d = difference(a.0, b.0, pivot);
    if d[0].hypot(d[1]) > FARTHEST {
        return false;
    }
    if d[0].hypot(d[1]) < LINK_PLACE && d[2].abs() < LINK_TURN {
        return true;
    }
    let mut sum = *a.1;
    add(&mut sum, b.1);
    inverse(&sum).is_some_and(|i| dot(times(&i, d), d) < LINKED)
}

/// A place and its images: no log tells them apart, so they weigh the same.
pub(super) fn images_of(symmetries: &MapSymmetries, place: &PosteriorPlace) -> Vec<PosteriorPlace> {
    let turned = |frame: Pose2| {
        let motion = frame.compose(place.map_from_odom.inverse());
        let (sin, cos) = motion.theta.sin_cos();
        let own = |m: &Matrix| congruent(&[[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]], m);
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

/// The robot's pose at the last row and its covariance there.
pub(super) fn at_robot(
    map_from_odom: Pose2,
    bank: &HypothesisBank,
    own: &Matrix,
    odom_from_robot: Pose2,
) -> (Pose2, Matrix) {
    let pose = map_from_odom.compose(odom_from_robot);
    let arm = (pose.position() - map_from_odom.transform_point(bank.pivot)).perp();
    (pose, congruent(&[[1.0, 0.0, arm.x], [0.0, 1.0, arm.y], [0.0, 0.0, 1.0]], own))
}

/// The declared bounds of odometry, by as much as errors that are not alike for all of so many rows come to.
pub(super) fn rest(bounds: &Odometry, rows: usize) -> Odometry {
    let share = (VARYING / (rows.max(1) as f64).sqrt()).min(1.0);
    Odometry {
        translation_relative: share * bounds.translation_relative,
        rotation_relative: share * bounds.rotation_relative,
        ..*bounds
    }
}
