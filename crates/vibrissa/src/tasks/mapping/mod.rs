//! A map without a map: the outline of what whiskers felt along the robot's ways, the ways themselves, where the robot came back, and what has
//! changed since.
//!
//! | file | what it knows |
//! | --- | --- |
//! | `front_end` | rows in, stretches of felt wall out, each rigid on a key pose |
//! | `odometry` | the way between key poses, and how it changes with the shares by which odometry is wrong |
//! | `submap` | what was felt and passed over a stretch of the way, with bounds |
//! | `passed_cells` | the space that was passed, as it is kept |
//! | `free_space` | how deep in passed space a place lies |
//! | `closure` | proofs that the robot came back, by set inversion |
//! | `visit` | where a later log begins in the outline of those before |
//! | `changes` | walls that are not where an earlier log felt them |
//! | `closures` | where along the way it may have come back, and within which bounds |
//! | `overlap` | later contacts on earlier walls |
//! | `graph` | key poses and shares by least squares |
//! | `merge` | stretches of all passes as one outline with bands |
//! | `told` | what is told of all that |
//! | `json` | the factor graph for other solvers |

mod changes;
mod closure;
mod closures;
mod free_space;
mod front_end;
mod graph;
mod json;
mod merge;
mod odometry;
mod overlap;
mod passed_cells;
mod submap;
mod told;
mod visit;

use super::profile::AssembledMap;
use crate::config::MappingOptions;
use crate::flow::pose::StampedPose;
use crate::flow::sensor_log::{LogRow, SensorLog};
use crate::plane::Pose2;
use crate::world::Robot;
use crate::{Error, Result, Stop};
use changes::{Outdated, changes};
use closures::closures;
use front_end::{FrontEnd, Key};
use graph::{Graph, LegNoise, Marginals, Solution};
use odometry::{Leg, SHARES};
use overlap::Tie;
use visit::Placed;

pub use changes::{Change, ChangeKind};
pub use json::graph_to_json;
pub use told::{Closure, ClosureVerdict, ContactFactor, FactorGraph, LegFactor, Mapped, OdometryShares, Share, Visit};

const SQRT_3: f64 = 1.732_050_807_568_877_2;
/// Independent errors of odometry: this share of its bounds over this way (m), and what nothing is more exact than (m, rad).
const NOISE_SHARE: f64 = 0.1;
const NOISE_WAY: f64 = 0.05;
const LEAST_PLACE: f64 = 1e-5;
const LEAST_TURN: f64 = 2e-5;
/// How little is known of the way between logs (m, rad): nothing, beside a wall that both felt.
const BETWEEN_LOGS: (f64, f64) = (1.0, 1.0);
/// How often walls that have moved are left out and looked for again, at most.
const RECHECKS: usize = 4;
/// Rounds of finding what lies on what, and solving.
const ROUNDS: usize = 8;

/// A map in the making, row by row.
#[derive(Clone)]
pub struct Mapper {
    options: MappingOptions,
    robot: Robot,
    front: FrontEnd,
    /// The rows of each log: when, and the odometry.
    rows: Vec<Vec<(f64, Pose2)>>,
    stop: Stop,
}

/// What the back end has so far.
struct Progress {
    solution: Solution,
    marginals: Marginals,
    graph: FactorGraph,
    closures: Vec<Closure>,
    ties: Vec<Tie>,
    /// For each log whether it is placed, and how many places are left.
    placed: Vec<(ClosureVerdict, usize)>,
    changes: Vec<Change>,
    outdated: Outdated,
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
        Ok(Self { options, robot: robot.clone(), front, rows: vec![Vec::new()], stop: Stop::default() })
    }

    /// Takes a request to end early.
    pub fn heed(&mut self, stop: &Stop) {
        self.stop = stop.clone();
    }

    /// The rows that come next are those of another log of the same robot and place, with these channels: from anywhere, at any time.
    ///
    /// # Errors
    ///
    /// A whisker without a moment column, or a log whose readings cannot be traced.
    pub fn begin(&mut self, log: &SensorLog) -> Result<()> {
        self.robot.whiskers.iter().try_for_each(|whisker| log.moment_channel(&whisker.name).map(|_| ()))?;
        self.rows.push(Vec::new());
        self.front.begin(log, &self.stop)
    }

    /// Takes a row.
    ///
    /// # Errors
    ///
    /// A log whose readings cannot be traced, a row that is not in numbers.
    pub fn push(&mut self, row: &LogRow) -> Result<()> {
        row.check([])?;
        if let Some(rows) = self.rows.last_mut() {
            rows.push((row.t, row.odom_from_robot));
        }
        self.front.push(row, &self.stop)
    }

    /// The map of all rows so far; more may come.
    ///
    /// # Errors
    ///
    /// Nothing was felt that makes an outline.
    pub fn map(&mut self) -> Result<Mapped> {
        self.front.cut(&self.stop)?;
        let mut progress = self.first()?;
        for visit in 1..self.rows.len() {
            self.add(visit, &mut progress)?;
        }
        let outline = self.outline(&progress)?;
        let Progress { solution, marginals, graph, closures, placed, changes, .. } = progress;
        let [scale, turn, drift] = graph.shares;
        let visits = placed.iter().enumerate().map(|(visit, &(placed, places))| {
            let keys = self.front.visit(visit);
            let covariances = keys.clone().map(|key| (self.front.keys[key].t, marginals.poses[key])).collect();
            let trajectory = trajectory(&self.rows[visit], &self.front.keys, keys, &solution);
            Visit { placed, places, trajectory, covariances }
        });
        Ok(Mapped {
            outline,
            visits: visits.collect(),
            shares: OdometryShares { scale, turn, drift },
            closures,
            changes,
            points: self.front.stretches.iter().map(|stretch| stretch.points.len()).sum(),
            graph,
        })
    }

    /// The first log by itself.
    fn first(&self) -> Result<Progress> {
        let keys = self.front.visit(0);
        let Some(first) = self.front.keys[keys.clone()].first() else {
            return Err(Error::data("the log has no row").remedy("record the robot while its whisker touches walls"));
        };
        let legs = self.legs(&keys, None);
        let solution =
            Graph { legs: &legs, overlaps: &[], shares: self.share_stds() }.dead_reckoned(first.odom_from_key);
        let (closures, ties) = closures((&self.front, 0), &self.robot, &self.options, None, &self.stop);
        let (solution, marginals, graph) = self.solve(&legs, (&ties, &Outdated::new()), solution)?;
        let placed = vec![(ClosureVerdict::Proved, 1)];
        let (changes, outdated) = (Vec::new(), Outdated::new());
        Ok(Progress { solution, marginals, graph, closures, ties, placed, changes, outdated })
    }

    /// One more log: where it begins in the outline so far, what it adds, and what has changed.
    fn add(&self, visit: usize, progress: &mut Progress) -> Result<()> {
        let keys = self.front.visit(visit);
        let (front, robot, options, stop) = (&self.front, &self.robot, &self.options, &self.stop);
        let outline = self.outline(progress)?;
        let placed = progress.placed.clone();
        let is_known =
            |key: usize| placed.get(front.keys[key].visit).is_some_and(|(placed, _)| *placed == ClosureVerdict::Proved);
        let known = (&outline.map, &progress.solution, &is_known as &dyn Fn(usize) -> bool);
        let Placed { verdict, places, tie } = visit::place((front, visit), known, robot, options, stop);
        progress.placed.push((verdict, places));
        let odom = |key: usize| front.keys[key].odom_from_key;
        // A log that is not placed hangs on the end of the one before, and has no part in anything.
        let map_from_odom = match tie {
            Some(Tie { earlier, later, earlier_from_later, .. }) => {
                progress.solution.poses[earlier].compose(earlier_from_later).compose(odom(later).inverse())
            }
            None => Pose2::IDENTITY,
        };
        let mut start = progress.solution.clone();
        start.poses.extend(keys.clone().map(|key| map_from_odom.compose(odom(key))));
        if tie.is_some() {
            let (closures, ties) = closures((front, visit), robot, options, tie, stop);
            progress.closures.extend(closures);
            progress.ties.extend(ties);
        }
        let legs = self.legs(&(0..keys.end), Some(&start));
        let (before, mut found) = (progress.outdated.clone(), Vec::new());
        for _ in 0..RECHECKS {
            let known = (&progress.ties[..], &progress.outdated);
            (progress.solution, progress.marginals, progress.graph) = self.solve(&legs, known, start)?;
            start = progress.solution.clone();
            if tie.is_none() {
                break;
            }
            // What has moved says nothing of where the log is: once more without it.
            let last = core::mem::replace(&mut progress.outdated, before.clone());
            let known = (&progress.solution, &progress.marginals, &is_known as &dyn Fn(usize) -> bool);
            found = changes((front, visit), known, options, &mut progress.outdated);
            if progress.outdated == last {
                break;
            }
        }
        progress.changes.extend(found);
        Ok(())
    }

    /// Finds what lies on what, and solves, in turns.
    fn solve(
        &self,
        legs: &[(Leg, LegNoise)],
        (ties, outdated): (&[Tie], &Outdated),
        start: Solution,
    ) -> Result<(Solution, Marginals, FactorGraph)> {
        let shares = self.share_stds();
        let (mut solution, mut overlaps) = (start, Vec::new());
        for round in 0..ROUNDS {
            let near = (round > 0).then_some((&solution, round > 1));
            overlaps = overlap::overlaps(&self.front, ties, near, outdated, &self.options);
            if overlaps.is_empty() {
                break;
            }
            solution = Graph { legs, overlaps: &overlaps, shares }.solve(solution);
        }
        let graph = Graph { legs, overlaps: &overlaps, shares };
        let marginals = graph.marginals(&solution).ok_or_else(|| {
            Error::data("the key poses are not determined").remedy("this is a defect; please report the log")
        })?;
        let told = graph.told(&solution, &marginals);
        Ok((solution, marginals, told))
    }

    fn outline(&self, progress: &Progress) -> Result<AssembledMap> {
        let is_left_out = |stretch: usize, point: usize| {
            let visit = self.front.keys[self.front.stretches[stretch].key].visit;
            let is_placed = progress.placed.get(visit).is_some_and(|(placed, _)| *placed == ClosureVerdict::Proved);
            !is_placed || progress.outdated.contains(&(stretch, point))
        };
        merge::outline(&self.front, &progress.solution, &progress.marginals.poses, &self.options, &is_left_out)
    }

    /// The legs between key poses, with what their errors are beside the shares; between logs nothing is known, and `start` is as good as
    /// anything.
    fn legs(&self, keys: &core::ops::Range<usize>, start: Option<&Solution>) -> Vec<(Leg, LegNoise)> {
        let odometry = &self.robot.odometry;
        let noise = |leg: &Leg| {
            let way = NOISE_SHARE * odometry.translation_relative * (leg.way * NOISE_WAY).sqrt();
            let turn = NOISE_SHARE * odometry.rotation_relative * leg.turned.sqrt() * 0.2_f64;
            let drift = NOISE_SHARE * self.options.drift * (leg.way * NOISE_WAY).sqrt();
            LegNoise { place: way.hypot(LEAST_PLACE), turn: turn.hypot(drift).hypot(LEAST_TURN) }
        };
        let leg = |key: usize| {
            let Key { leg, visit, .. } = &self.front.keys[key];
            match start {
                Some(start) if *visit != self.front.keys[key - 1].visit => {
                    let step = start.poses[key - 1].between(start.poses[key]);
                    (Leg { step, ..Leg::default() }, LegNoise { place: BETWEEN_LOGS.0, turn: BETWEEN_LOGS.1 })
                }
                _ => (*leg, noise(leg)),
            }
        };
        keys.clone().skip(1).map(leg).collect()
    }

    /// Standard deviations of the shares: even within their bounds.
    fn share_stds(&self) -> [f64; SHARES] {
        let odometry = &self.robot.odometry;
        [odometry.translation_relative, odometry.rotation_relative, self.options.drift].map(|bound| bound / SQRT_3)
    }
}

/// The robot at every row: from the key pose before, by the odometry with its shares taken into account.
fn trajectory(
    rows: &[(f64, Pose2)],
    all: &[Key],
    visit: core::ops::Range<usize>,
    solution: &Solution,
) -> Vec<StampedPose> {
    let (keys, poses) = (&all[visit.clone()], &solution.poses[visit]);
    let mut told = Vec::with_capacity(rows.len());
    let (mut key, mut leg, mut last) = (0, Leg::default(), None::<Pose2>);
    for &(t, odom_from_robot) in rows {
        if let Some(last) = last {
            leg.add(last.between(odom_from_robot));
        }
        last = Some(odom_from_robot);
        while keys.get(key + 1).is_some_and(|next| next.t <= t) {
            key += 1;
            leg = Leg::default();
        }
        let Some(from) = poses.get(key) else { break };
        let mut map_from_robot = from.compose(leg.corrected(&solution.shares));
        // What the next key pose says beyond the odometry comes in along the way to it.
        if let (Some(next), Some(there)) = (keys.get(key + 1), poses.get(key + 1)) {
            let whole = from.compose(next.leg.corrected(&solution.shares));
            let share = if next.leg.way > 0.0 { (leg.way / next.leg.way).min(1.0) } else { 0.0 };
            map_from_robot.x += share * (there.x - whole.x);
            map_from_robot.y += share * (there.y - whole.y);
            map_from_robot.theta += share * crate::plane::wrap_angle(there.theta - whole.theta);
        }
        told.push(StampedPose { t, map_from_robot });
    }
    told
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
    map_logs(core::slice::from_ref(log), robot, options, stop, observer)
}

/// The map of several logs of one robot in one place, each of which may begin anywhere; as [`map_log`].
///
/// Later logs are placed in the outline of those before, and tell where walls have moved since. The frame is that of the first one's odometry.
///
/// # Errors
///
/// No log, options out of range, a whisker without a moment column, or nothing that was felt; with the log's name.
pub fn map_logs(
    logs: &[SensorLog],
    robot: &Robot,
    options: MappingOptions,
    stop: &Stop,
    observer: &mut dyn FnMut(usize, usize),
) -> Result<Mapped> {
    let all = logs.iter().map(|log| log.rows.len()).sum();
    let (mut mapper, mut done) = (None::<Mapper>, 0);
    for log in logs {
        let in_file = |error: Error| match &log.source {
            Some(file) => error.in_file(file),
            None => error,
        };
        let (log, robot) = crate::io::calibrated(log, robot).map_err(in_file)?;
        let mapper = match &mut mapper {
            Some(mapper) => {
                mapper.begin(&log).map_err(in_file)?;
                mapper
            }
            None => {
                let first = Mapper::new(&robot, &log, options).map_err(in_file)?;
                let first = mapper.insert(first);
                first.heed(stop);
                first
            }
        };
        for row in &log.rows {
            mapper.push(row).map_err(in_file)?;
            done += 1;
            observer(done, all);
        }
    }
    let Some(mut mapper) = mapper else {
        return Err(Error::usage("no log").remedy("give one or more logs"));
    };
    mapper.map()
}
