//! What was felt, and how likely it is: rows of odometry with readings, and their noise.

use super::contact::Solver;
use super::drift::Drift;
use super::shares::{Shares, corrected};
use crate::beam::{TipChart, TipModel, TipReading};
use crate::plane::{Pose2, Vec2};
use crate::world::{MountedWhisker, ReadingNoise};

/// The most that one reading can speak against a place: a false reading costs this, not more.
pub(super) const OUTLIER_COST: f64 = 6.0;
/// What a reading costs while the whisker is in a contact that the model does not cover.
const UNKNOWN_COST: f64 = 3.0;

/// What of a whisker is read; readings are dimensionless, as [`TipModel`] has them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sense {
    /// The moment at the base, `M0 L / EI`.
    Moment,
    /// The contact force `F L² / EI`, negative when it pushes towards -y.
    Force,
    /// The slope at the contact (rad).
    Slope,
}

impl Sense {
    /// The declared bound on its readings (N m, N, rad).
    pub(crate) fn noise(self, whisker: &MountedWhisker) -> ReadingNoise {
        match self {
            Self::Moment => whisker.noise.into(),
            Self::Force => whisker.force_noise,
            Self::Slope => whisker.slope_noise,
        }
    }

    /// The reading of a whisker with its tip under this load, and its derivatives by force and tilt.
    pub(super) fn at_tip(self, tip: &TipChart, q: f64, beta: f64) -> (f64, [f64; 2]) {
        match self {
            Self::Moment => (tip.moment, [tip.by_force.moment, tip.by_tilt.moment]),
            Self::Force => {
                let side = 1.0_f64.copysign(beta.cos());
                (side * q, [side, 0.0])
            }
            Self::Slope => (tip.slope, [tip.by_force.slope, tip.by_tilt.slope]),
        }
    }

    /// The reading of a uniform whisker that is touched at the share `s` of its length, normal to it and from the side that
    /// `beta` says; `tip` is the part up to there at its own scale, under `q`. Derivatives by `q` and `s`.
    pub(super) fn at_side(self, tip: &TipChart, q: f64, s: f64, beta: f64) -> (f64, [f64; 2]) {
        match self {
            Self::Moment => (tip.moment / s, [tip.by_force.moment / s, -tip.moment / (s * s)]),
            Self::Force => {
                let per = 1.0_f64.copysign(beta.cos()) / (s * s);
                (per * q, [per, -2.0 * per * q / s])
            }
            Self::Slope => (tip.slope, [tip.by_force.slope, 0.0]),
        }
    }
}

/// One sense of one whisker as the estimator needs it.
#[derive(Clone, Debug)]
pub(super) struct Feeler {
    pub(super) tip: TipModel,
    pub(super) sense: Sense,
    pub(super) robot_from_whisker: Pose2,
    /// Length (m).
    pub(super) length: f64,
    /// Dimensionless reading per N m, N or rad.
    pub(super) per_reading: f64,
    relative: f64,
    absolute: f64,
}

/// How readings are judged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Judge {
    /// Standard deviations are enlarged by this.
    pub(super) temper: f64,
    /// The most that one reading costs.
    pub(super) outlier_cost: f64,
}

impl Judge {
    /// As declared.
    pub(super) const FAIR: Self = Self { temper: 1.0, outlier_cost: OUTLIER_COST };
}

/// A reading against a prediction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Misfit {
    /// Cost: minus the logarithm of the likelihood.
    pub(super) cost: f64,
    /// Residual (dimensionless moment).
    pub(super) residual: f64,
    /// Weight of its square in the normal equations.
    pub(super) weight: f64,
    /// The residual in standard deviations.
    pub(super) sigmas: f64,
}

impl Feeler {
    pub(super) fn new(whisker: &MountedWhisker, tip: TipModel, sense: Sense) -> Self {
        let (length, rigidity) = (whisker.beam.length, tip.rigidity());
        let noise = sense.noise(whisker);
        let per_reading = match sense {
            Sense::Moment => length / rigidity,
            Sense::Force => length * length / rigidity,
            Sense::Slope => 1.0,
        };
        Self {
            tip,
            sense,
            robot_from_whisker: whisker.robot_from_whisker,
            length: whisker.beam.length,
            per_reading,
            relative: noise.relative,
            absolute: (noise.absolute * per_reading).max(LEAST_ABSOLUTE),
        }
    }

    /// A dimensionless reading as it is measured.
    pub(super) fn reading(&self, z: f64) -> TipReading {
        let value = z / self.per_reading;
        match self.sense {
            Sense::Moment => TipReading::Moment(value),
            Sense::Force => TipReading::Force(value),
            Sense::Slope => TipReading::Slope(value),
        }
    }

    /// How its equilibria are solved, if those of a uniform whisker are solved like this.
    pub(super) fn solver<'a>(&'a self, uniform: Solver<'a>) -> Solver<'a> {
        if self.tip.is_uniform() { uniform } else { Solver::Table(&self.tip) }
    }

    /// Whether a reading is more than noise on a free whisker.
    pub(super) fn is_contact(&self, z: f64) -> bool {
        z.abs() * (1.0 - self.relative) > self.absolute
    }

    /// Mean and standard deviation of the readings of a moment: they lie evenly where `|h - z| <= r |z| + a`.
    pub(super) fn expected(&self, h: f64) -> (f64, f64) {
        let per = 1.0 / (1.0 - self.relative * self.relative);
        if h.abs() < self.absolute {
            return (h, self.absolute * per / SQRT_3);
        }
        let mean = (h.abs() + self.relative * self.absolute) * per;
        (mean.copysign(h), (self.relative * h.abs() + self.absolute) * per / SQRT_3)
    }

    /// The residual in standard deviations as a logarithm's, for a moment of this sign, above the absolute error.
    ///
    /// Errors grow with the moment, so that in plain residuals a larger moment explains all readings better, all the more
    /// where a shared gain makes up for it. The ratio of the bound's width at the reading to that at the moment lies evenly
    /// between `1 - r` and `1 + r` whatever the moment, so its logarithm has the same law everywhere; its mean is taken
    /// off, and what is far below is continued in a straight line.
    fn evened(&self, sigmas: f64, sign: f64) -> f64 {
        let r = self.relative;
        if r < LEAST_RELATIVE {
            return sigmas;
        }
        let ratio = 1.0 - r * sign * sigmas / SQRT_3;
        let log = if ratio > 0.5 { ratio.ln() } else { 0.5_f64.ln() + 2.0 * ratio - 1.0 };
        let mean = ((1.0 + r) * r.ln_1p() - (1.0 - r) * (-r).ln_1p()) / (2.0 * r) - 1.0;
        sign * SQRT_3 / r * (mean - log)
    }

    /// Standard deviation of the relative error that all readings share, where nothing is said: a quarter of the bound.
    pub(super) fn shared_share(&self) -> f64 {
        0.25 * self.relative
    }

    /// The residual of a reading in standard deviations, once a shared relative error has been taken out.
    pub(super) fn sigmas_without(&self, h: f64, gain: f64, z: f64) -> f64 {
        let (mean, std) = self.expected(h);
        (mean + gain * h - z) / std
    }

    /// A reading against a moment; `pressed` where the whisker is held by
    /// a boundary, `glued` where it almost is and `h` is what a pull would make.
    pub(super) fn misfit(&self, h: f64, z: f64, pressed: bool, glued: bool, judge: Judge) -> Misfit {
        let wanted = glued && self.is_contact(z);
        let (mean, std) = if pressed {
            self.expected(h)
        } else if wanted {
            (h, self.expected(z).1)
        } else {
            (0.0, self.expected(0.0).1)
        };
        let sigmas = (mean - z) / std;
        let even = if pressed && h.abs() >= self.absolute { self.evened(sigmas, h.signum()) } else { sigmas };
        let std = std * judge.temper;
        let residual = even * std / judge.temper;
        let sigmas = sigmas / judge.temper;
        let (cost, trust) = robust(even / judge.temper, judge.outlier_cost);
        let weight = if pressed || wanted { trust / (std * std) } else { 0.0 };
        Misfit { cost, residual, weight, sigmas }
    }

    /// The cost of a reading that the model cannot predict.
    pub(super) fn unknown() -> Misfit {
        Misfit { cost: UNKNOWN_COST, sigmas: f64::INFINITY, ..Misfit::default() }
    }
}

const SQRT_3: f64 = 1.732_050_807_568_877_2;
/// Readings are never taken to be more exact than this (dimensionless moment): a tip known to about a micrometre.
const LEAST_ABSOLUTE: f64 = 2e-5;

/// Below this relative bound residuals are taken plain: the logarithm's are the same, but for rounding.
const LEAST_RELATIVE: f64 = 1e-5;

/// Cost and weight of a residual in standard deviations: Gaussian with a floor for false readings.
fn robust(sigmas: f64, outlier_cost: f64) -> (f64, f64) {
    if outlier_cost.is_infinite() {
        return (0.5 * sigmas * sigmas, 1.0);
    }
    let kernel = (-0.5 * sigmas * sigmas).exp();
    let floor = (-outlier_cost).exp();
    (-((kernel + floor) / (1.0 + floor)).ln(), kernel / (kernel + floor))
}

/// Rows that were kept, each with one reading for each whisker (dimensionless).
#[derive(Clone, Debug, Default)]
pub(super) struct History {
    mounts: Vec<Pose2>,
    /// The robot as its odometry says, and once that is corrected.
    raw: Vec<Pose2>,
    poses: Vec<Pose2>,
    /// The shares that it is corrected by, and the way when no row will follow.
    shares: Shares,
    is_corrected: bool,
    whole: Option<Drift>,
    /// The bases of all whiskers, odometry frame.
    bases: Vec<Pose2>,
    readings: Vec<f64>,
    /// Sum of unit vectors: the heading of the odometry frame by each absolute heading.
    compass: Vec2,
}

impl History {
    pub(super) fn new(feelers: &[Feeler]) -> Self {
        Self { mounts: feelers.iter().map(|f| f.robot_from_whisker).collect(), ..Self::default() }
    }

    pub(super) fn push(&mut self, odom_from_robot: Pose2, readings: &[f64]) {
        let pose = match (self.raw.last(), self.poses.last()) {
            (Some(&raw), Some(&last)) if self.is_corrected => {
                last.compose(corrected(raw.between(odom_from_robot), self.shares))
            }
            _ => odom_from_robot,
        };
        self.raw.push(odom_from_robot);
        self.poses.push(pose);
        self.bases.extend(self.mounts.iter().map(|mount| pose.compose(*mount)));
        self.readings.extend_from_slice(readings);
    }

    /// The shares that the odometry is corrected by.
    pub(super) fn shares(&self) -> Shares {
        self.shares
    }

    /// Corrects the odometry by these shares; the last row stays where it is.
    pub(super) fn correct(&mut self, shares: Shares) {
        let Some(&last) = self.poses.last() else { return };
        (self.shares, self.is_corrected) = (shares, true);
        let Some((&raw, before)) = self.raw.split_last() else { return };
        self.poses = led_back(before, (raw, last), shares);
        self.poses.push(last);
        self.whole = self.whole.map(|_| Drift::along(&self.poses));
        let mounts = &self.mounts;
        self.bases = self.poses.iter().flat_map(|pose| mounts.iter().map(|mount| pose.compose(*mount))).collect();
    }

    /// Where the robot was before the first row, by what its odometry said, as far as that has been corrected.
    pub(super) fn earlier(&self, raw: &[Pose2]) -> Vec<Pose2> {
        match (self.raw.first(), self.poses.first()) {
            (Some(&first), Some(&pose)) if self.is_corrected => led_back(raw, (first, pose), self.shares),
            _ => raw.to_vec(),
        }
    }

    /// No row will follow: what the odometry's shares do is told from the last row on, which is what is asked for.
    pub(super) fn end(&mut self) {
        self.whole = Some(Drift::along(&self.poses));
    }

    /// The way when no row will follow.
    pub(super) fn whole(&self) -> Option<&Drift> {
        self.whole.as_ref()
    }

    /// The robot's way from the first row to the last.
    pub(super) fn way(&self) -> Drift {
        Drift::along(&self.poses)
    }

    /// The odometry's own frame in that of the corrected one, at the last row.
    pub(super) fn corrected_from_raw(&self) -> Pose2 {
        match (self.raw.last(), self.poses.last()) {
            (Some(raw), Some(pose)) if self.is_corrected => pose.compose(raw.inverse()),
            _ => Pose2::IDENTITY,
        }
    }

    /// Takes in the absolute heading of the last row (map frame).
    pub(super) fn point(&mut self, map_heading: f64) {
        if let Some(last) = self.poses.last() {
            self.compass += Vec2::from_angle(map_heading - last.theta);
        }
    }

    /// The heading of the odometry frame in the map by all absolute headings so far.
    pub(super) fn heading(&self) -> Option<f64> {
        (self.compass.norm_squared() > 0.0).then(|| self.compass.angle())
    }

    pub(super) fn len(&self) -> usize {
        self.poses.len()
    }

    pub(super) fn pose(&self, row: usize) -> Pose2 {
        self.poses[row]
    }

    /// The same before any correction.
    pub(super) fn raw(&self, row: usize) -> Pose2 {
        self.raw[row]
    }

    pub(super) fn readings(&self, row: usize) -> &[f64] {
        &self.readings[row * self.mounts.len()..(row + 1) * self.mounts.len()]
    }

    /// The base of a whisker, `odom_from_whisker`.
    pub(super) fn base(&self, row: usize, feeler: usize) -> Pose2 {
        self.bases[row * self.mounts.len() + feeler]
    }

    /// Forgets the rows before `row`.
    pub(super) fn forget(&mut self, row: usize) {
        self.raw.drain(..row);
        self.poses.drain(..row);
        self.bases.drain(..row * self.mounts.len());
        self.readings.drain(..row * self.mounts.len());
    }

    /// Forgets one row.
    pub(super) fn drop_row(&mut self, row: usize) {
        self.raw.remove(row);
        self.poses.remove(row);
        let these = row * self.mounts.len()..(row + 1) * self.mounts.len();
        self.bases.drain(these.clone());
        self.readings.drain(these);
    }
}

/// The path that ends before this pose, each given as the odometry says and once corrected by these shares.
fn led_back(before: &[Pose2], (mut raw, mut pose): (Pose2, Pose2), shares: Shares) -> Vec<Pose2> {
    let mut path = before.to_vec();
    for there in path.iter_mut().rev() {
        pose = pose.compose(corrected(there.between(raw), shares).inverse());
        (raw, *there) = (*there, pose);
    }
    path
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

    use super::*;
    use crate::beam::Whisker;

    fn feeler(relative: f64, absolute: f64) -> Feeler {
        let tip = TipModel::new(&Whisker::default()).unwrap();
        let sense = Sense::Moment;
        Feeler { tip, sense, robot_from_whisker: Pose2::IDENTITY, length: 0.075, per_reading: 1.0, relative, absolute }
    }

    #[test]
    fn rows_before_the_first_are_corrected_like_those_after() {
        let poses: Vec<Pose2> =
            (0..40).map(|k| 0.004 * f64::from(k)).map(|s| Pose2::new(s, 0.3 * s.sin(), 2.0 * s)).collect();
        let mut history = History::new(&[feeler(0.05, 1e-3)]);
        poses.iter().for_each(|&pose| history.push(pose, &[0.0]));
        assert_eq!(history.earlier(&poses[..3]), poses[..3]);
        history.correct([0.01, -0.004, 0.007]);
        let whole: Vec<Pose2> = (0..40).map(|row| history.pose(row)).collect();
        assert!(whole[0].position().distance(poses[0].position()) > 1e-4 && whole[39] == poses[39]);
        history.forget(25);
        let earlier = history.earlier(&poses[..25]);
        for (ours, before) in earlier.iter().zip(&whole) {
            assert!(ours.position().distance(before.position()) < 1e-12 && (ours.theta - before.theta).abs() < 1e-12);
        }
        // Every second of them lies where it lay: a correction turns and stretches, and bends but little.
        let some: Vec<Pose2> = poses[..25].iter().step_by(2).copied().collect();
        for (ours, before) in history.earlier(&some).iter().zip(whole.iter().step_by(2)) {
            assert!(ours.position().distance(before.position()) < 2e-5, "{ours:?}, not {before:?}");
        }
    }

    /// The readings that the declared bound allows, evenly: from `|h - z| <= r |z| + a` by hand, for `z` of `h`'s sign.
    fn readings(h: f64, r: f64, a: f64) -> impl Iterator<Item = f64> {
        let (low, high) = ((h.abs() - a) / (1.0 + r), (h.abs() + a) / (1.0 - r));
        (0..2000).map(move |i| (low + (f64::from(i) + 0.5) / 2000.0 * (high - low)).copysign(h))
    }

    #[test]
    fn residuals_have_one_law_whatever_the_moment() {
        for (r, a) in [(0.05, 1e-3), (0.2, 1e-4), (1e-3, 2e-2), (0.0, 1e-2), (0.4, 0.0)] {
            for h in [0.03, -0.3, 2.5] {
                let feeler = feeler(r, a);
                let all: Vec<Misfit> =
                    readings(h, r, a).map(|z| feeler.misfit(h, z, true, true, Judge::FAIR)).collect();
                let std = feeler.expected(h).1;
                let mean = all.iter().map(|m| m.residual / std).sum::<f64>() / all.len() as f64;
                let square = all.iter().map(|m| (m.residual / std).powi(2)).sum::<f64>() / all.len() as f64;
                assert!(mean.abs() < 1e-3, "{r} {a} {h}: {mean}");
                assert!((square - 1.0).abs() < 1e-3 + r * r, "{r} {a} {h}: {square}");
            }
        }
    }

    #[test]
    fn moments_that_are_all_too_large_explain_no_better() {
        // With relative errors alone, moments and readings that are larger by the same share cost the same: nothing is won
        // by scaling both, as a shared gain does. Moments that are too large and too small by as much cost alike.
        let feeler = feeler(0.05, 1e-9);
        let cost = |h: f64, scale: f64| {
            readings(h, 0.05, 0.0).map(|z| feeler.misfit(h * scale, z, true, true, Judge::FAIR).cost).sum::<f64>()
                / 2000.0
        };
        for h in [0.1, -1.0] {
            assert!((cost(h, 1.0) - cost(2.0 * h, 1.0)).abs() < 1e-6);
            let (more, less) = (cost(h, 1.02), cost(h, 1.0 / 1.02));
            assert!(more > cost(h, 1.0) + 0.1 && (more - less).abs() < 0.02, "{more} {less}");
        }
    }

    #[test]
    fn a_corrected_path_is_the_one_that_was_gone() {
        let feelers = [feeler(0.05, 0.0)];
        let gone: Vec<Pose2> =
            (0..50).map(|k| f64::from(k) * 0.03).map(|s| Pose2::new(s.sin(), s, 2.0 * s.cos())).collect();
        let shares = [0.01, -0.004, 0.008];
        // What odometry that is wrong by these shares says of it.
        let wrong = |step: Pose2| {
            let place = step.position().rotated(-shares[1]) * (1.0 / (1.0 + shares[0]));
            Pose2 { x: place.x, y: place.y, theta: step.theta / (1.0 + shares[2]) }
        };
        let mut history = History::new(&feelers);
        let mut raw = gone[0];
        for (row, pose) in gone.iter().enumerate() {
            if row > 0 {
                raw = raw.compose(wrong(gone[row - 1].between(*pose)));
            }
            if row == 30 {
                assert_eq!(history.pose(29), history.raw[29]);
                history.correct(shares);
            }
            history.push(raw, &[0.0]);
        }
        // The last row then stayed where it was, and all others stand to it as they did.
        let from = history.pose(29).compose(gone[29].inverse());
        for (row, pose) in gone.iter().enumerate() {
            let off = history.pose(row).between(from.compose(*pose));
            assert!(off.position().norm() < 1e-12 && off.theta.abs() < 1e-12, "{row}: {off:?}");
            assert!(history.base(row, 0).between(history.pose(row)).position().norm() < 1e-12);
        }
        let now = history.corrected_from_raw().compose(raw);
        assert!(now.between(history.pose(49)).position().norm() < 1e-12);
        history.forget(20);
        history.correct([0.0; 3]);
        assert!(history.pose(29).between(now).position().norm() < 1e-12);
        let (a, b) = (history.raw[0].between(history.raw[29]), history.pose(0).between(history.pose(29)));
        assert!(a.between(b).position().norm() < 1e-12);
    }
}
