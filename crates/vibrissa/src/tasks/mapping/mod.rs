//! A map without a map: the outline of what whiskers felt along the robot's way, the way itself, and where the robot came back.
//!
//! | file | what it knows |
//! | --- | --- |
//! | `front_end` | rows in, stretches of felt wall out, each rigid on a key pose |
//! | `odometry` | the way between key poses, and how it changes with the shares by which odometry is wrong |
//! | `submap` | what was felt and passed over a stretch of the way, with bounds |
//! | `free_space` | how deep in passed space a place lies |
//! | `closure` | proofs that the robot came back, by set inversion |
//! | `closures` | where along the way it may have come back, and within which bounds |
//! | `overlap` | later contacts on earlier walls |
//! | `graph` | key poses and shares by least squares |
//! | `merge` | stretches of all passes as one outline with bands |

mod closure;
mod closures;
mod free_space;
mod front_end;
mod graph;
mod merge;
mod odometry;
mod overlap;
mod submap;

use super::profile::AssembledMap;
use crate::config::MappingOptions;
use crate::flow::pose::StampedPose;
use crate::flow::sensor_log::{LogRow, SensorLog};
use crate::plane::Pose2;
use crate::world::Robot;
use crate::{Error, Result, Stop};
use closures::closures;
use front_end::FrontEnd;
use graph::{Graph, LegNoise, Solution};
use odometry::{Leg, SHARES};

const SQRT_3: f64 = 1.732_050_807_568_877_2;
/// Independent errors of odometry: this share of its bounds over this way (m), and what nothing is more exact than (m, rad).
const NOISE_SHARE: f64 = 0.1;
const NOISE_WAY: f64 = 0.05;
const LEAST_PLACE: f64 = 1e-5;
const LEAST_TURN: f64 = 2e-5;
/// Rounds of finding what lies on what, and solving.
const ROUNDS: usize = 5;

/// Whether the robot came back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ClosureVerdict {
    /// No other place within the declared odometry bounds explains what was felt.
    Proved,
    /// Other places do, so many of them, or one that is too large to tell.
    Hypothesis,
    /// No place does: the declared bounds do not hold.
    Contradiction,
    /// The search was cut short.
    Unfinished,
}

impl ClosureVerdict {
    /// The verdict in a word, for files.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Proved => "proved",
            Self::Hypothesis => "hypothesis",
            Self::Contradiction => "contradiction",
            Self::Unfinished => "unfinished",
        }
    }
}

/// A place where the robot may have come back.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Closure {
    /// When it was there later, and earlier (s).
    pub later: f64,
    /// See `later`.
    pub earlier: f64,
    /// What is known of it.
    pub verdict: ClosureVerdict,
    /// How many separate places are left, and half of their extent: x, y (m) and heading (rad).
    pub places: usize,
    /// See `places`.
    pub extent: [f64; 3],
}

/// A quantity with its standard deviation.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Share {
    /// The value.
    pub value: f64,
    /// Its standard deviation.
    pub std: f64,
}

/// By which shares the odometry is wrong.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OdometryShares {
    /// Ways are longer than told by this share.
    pub scale: Share,
    /// Turns are larger than told by this share.
    pub turn: Share,
    /// The heading turns by so much more along the way (rad/m).
    pub drift: Share,
}

/// What mapping found, in the frame of the first row's odometry.
#[derive(Clone, Debug)]
pub struct Mapped {
    /// The outline: boundaries with bands, corners, unknown stretches.
    pub outline: AssembledMap,
    /// The robot at every row.
    pub trajectory: Vec<StampedPose>,
    /// Covariances of its pose at some rows, relative to the first: when, and by x, y (m), heading (rad).
    pub covariances: Vec<(f64, [[f64; 3]; 3])>,
    /// The odometry's shares.
    pub shares: OdometryShares,
    /// Where it came back, or may have.
    pub closures: Vec<Closure>,
    /// How many felt points the outline is made of.
    pub points: usize,
}

/// A map in the making, row by row.
pub struct Mapper {
    options: MappingOptions,
    robot: Robot,
    front: FrontEnd,
    rows: Vec<(f64, Pose2)>,
    stop: Stop,
}

impl Mapper {
    /// Before the first row of a log with these channels.
    ///
    /// # Errors
    ///
    /// Options out of range, whiskers that lean, or a whisker without a moment column.
    pub fn new(robot: &Robot, log: &SensorLog, options: MappingOptions) -> Result<Self> {
        options.check()?;
        robot.require_level("mapping")?;
        robot.whiskers.iter().try_for_each(|whisker| log.moment_channel(&whisker.name).map(|_| ()))?;
        let front = FrontEnd::new(robot, log, options);
        Ok(Self { options, robot: robot.clone(), front, rows: Vec::new(), stop: Stop::default() })
    }

    /// Takes a request to end early.
    pub fn heed(&mut self, stop: &Stop) {
        self.stop = stop.clone();
    }

    /// Takes a row.
    ///
    /// # Errors
    ///
    /// A log whose readings cannot be traced, a row that is not in numbers.
    pub fn push(&mut self, row: &LogRow) -> Result<()> {
        row.check([])?;
        self.rows.push((row.t, row.odom_from_robot));
        self.front.push(row, &self.stop)
    }

    /// The map of all rows so far; more may come.
    ///
    /// # Errors
    ///
    /// Nothing was felt that makes an outline.
    pub fn map(&mut self) -> Result<Mapped> {
        self.front.cut(&self.stop)?;
        let Some(first) = self.front.keys.first() else {
            return Err(Error::data("the log has no row").remedy("record the robot while its whisker touches walls"));
        };
        let legs = self.legs();
        let shares = self.share_stds();
        let start = Graph { legs: &legs, overlaps: &[], shares }.dead_reckoned(first.odom_from_key);
        let (closures, ties) = closures(&self.front, &self.robot, &self.options, &self.stop);
        let mut solution = start;
        let mut overlaps = Vec::new();
        for round in 0..ROUNDS {
            overlaps = overlap::overlaps(&self.front, &ties, (round > 0).then_some(&solution), &self.options);
            if overlaps.is_empty() {
                break;
            }
            solution = Graph { legs: &legs, overlaps: &overlaps, shares }.solve(solution);
        }
        let graph = Graph { legs: &legs, overlaps: &overlaps, shares };
        let marginals = graph.marginals(&solution).ok_or_else(|| {
            Error::data("the key poses are not determined").remedy("this is a defect; please report the log")
        })?;
        let outline = merge::outline(&self.front, &solution, &marginals.poses, &self.options)?;
        let share = |k: usize| Share { value: solution.shares[k], std: marginals.shares[k] };
        let covariances = self.front.keys.iter().zip(&marginals.poses).map(|(key, own)| (key.t, *own)).collect();
        Ok(Mapped {
            outline,
            trajectory: self.trajectory(&solution),
            covariances,
            shares: OdometryShares { scale: share(0), turn: share(1), drift: share(2) },
            closures,
            points: self.front.stretches.iter().map(|stretch| stretch.points.len()).sum(),
        })
    }

    /// The legs between key poses, with what their errors are beside the shares.
    fn legs(&self) -> Vec<(Leg, LegNoise)> {
        let odometry = &self.robot.odometry;
        let noise = |leg: &Leg| {
            let way = NOISE_SHARE * odometry.translation_relative * (leg.way * NOISE_WAY).sqrt();
            let turn = NOISE_SHARE * odometry.rotation_relative * leg.turned.sqrt() * 0.2_f64;
            let drift = NOISE_SHARE * self.options.drift * (leg.way * NOISE_WAY).sqrt();
            LegNoise { place: way.hypot(LEAST_PLACE), turn: turn.hypot(drift).hypot(LEAST_TURN) }
        };
        self.front.keys.iter().skip(1).map(|key| (key.leg, noise(&key.leg))).collect()
    }

    /// Standard deviations of the shares: even within their bounds.
    fn share_stds(&self) -> [f64; SHARES] {
        let odometry = &self.robot.odometry;
        [odometry.translation_relative, odometry.rotation_relative, self.options.drift].map(|bound| bound / SQRT_3)
    }

    /// The robot at every row: from the key pose before, by the odometry with its shares taken into account.
    fn trajectory(&self, solution: &Solution) -> Vec<StampedPose> {
        let keys = &self.front.keys;
        let mut all = Vec::with_capacity(self.rows.len());
        let (mut key, mut leg, mut last) = (0, Leg::default(), None::<Pose2>);
        for &(t, odom_from_robot) in &self.rows {
            if let Some(last) = last {
                leg.add(last.between(odom_from_robot));
            }
            last = Some(odom_from_robot);
            while keys.get(key + 1).is_some_and(|next| next.t <= t) {
                key += 1;
                leg = Leg::default();
            }
            let from = solution.poses[key];
            let mut map_from_robot = from.compose(leg.corrected(&solution.shares));
            // What the next key pose says beyond the odometry comes in along the way to it.
            if let (Some(next), Some(there)) = (keys.get(key + 1), solution.poses.get(key + 1)) {
                let whole = from.compose(next.leg.corrected(&solution.shares));
                let share = if next.leg.way > 0.0 { (leg.way / next.leg.way).min(1.0) } else { 0.0 };
                map_from_robot.x += share * (there.x - whole.x);
                map_from_robot.y += share * (there.y - whole.y);
                map_from_robot.theta += share * crate::plane::wrap_angle(there.theta - whole.theta);
            }
            all.push(StampedPose { t, map_from_robot });
        }
        all
    }
}

/// The map of a log, until `stop` is asked for; `observer` is told how many of its rows are taken.
///
/// # Errors
///
/// Options out of range, a whisker without a moment column, or nothing that was felt.
pub fn map_log(
    log: &SensorLog,
    robot: &Robot,
    options: MappingOptions,
    stop: &Stop,
    observer: &mut dyn FnMut(usize, usize),
) -> Result<Mapped> {
    let (log, robot) = crate::io::calibrated(log, robot)?;
    let mut mapper = Mapper::new(&robot, &log, options)?;
    mapper.heed(stop);
    for (index, row) in log.rows.iter().enumerate() {
        mapper.push(row)?;
        observer(index + 1, log.rows.len());
    }
    mapper.map()
}
