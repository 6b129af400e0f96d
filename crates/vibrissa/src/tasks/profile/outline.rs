//! The line with its uncertainty, from all sweeps.

use super::assembly::{AssembledMap, FeltLine, FeltPoint, assemble};
use super::chain::{Chain, chains};
use super::near_points::NearPoints;
use super::run::{Sample, pegs, runs};
use crate::config::{ContactOptions, MapAssemblyOptions, ProfileOptions};
use crate::flow::pose::Event;
use crate::flow::sensor_log::SensorLog;
use crate::plane::Vec2;
use crate::tasks::contact::contacts_until;
use crate::world::{Band, Robot};
use crate::{Error, Result, Stop};

/// Smallest standard deviation that a run is believed (m).
const LEAST_STD: f64 = 1e-5;
/// How far from the middle of at least three runs one of them may lie, in standard deviations.
const OUTLIER: f64 = 5.0;

/// A point of an outline, odometry frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OutlinePoint {
    /// Where (m).
    pub position: Vec2,
    /// The unit normal, away from the wall.
    pub normal: Vec2,
    /// Standard deviation across the wall (m).
    pub std: f64,
    /// How many runs it is from.
    pub runs: usize,
}

/// A line along a wall.
#[derive(Clone, Debug, PartialEq)]
pub struct Outline {
    /// Its points, evenly spaced.
    pub points: Vec<OutlinePoint>,
    /// Whether the last point comes before the first.
    pub closed: bool,
}

impl Outline {
    /// The edges of the band of `width` standard deviations on either side (m): outer first.
    #[must_use]
    pub fn band(&self, width: f64) -> [Vec<Vec2>; 2] {
        [1.0, -1.0].map(|side| self.points.iter().map(|p| p.position + p.normal * (side * width * p.std)).collect())
    }
}

impl Outline {
    /// The outline as a line with bands, free space on its left.
    #[must_use]
    pub fn felt(&self, options: &MapAssemblyOptions) -> FeltLine {
        let mut points: Vec<FeltPoint> = self.points.iter().map(|point| felt_point(point, options)).collect();
        let leftwards = |pair: &[OutlinePoint]| (pair[1].position - pair[0].position).cross(pair[0].normal);
        if self.points.windows(2).map(leftwards).sum::<f64>() < 0.0 {
            points.reverse();
        }
        FeltLine { points, closed: self.closed }
    }
}

fn felt_point(point: &OutlinePoint, options: &MapAssemblyOptions) -> FeltPoint {
    let bound = (options.stds_in_bound * point.std).max(options.least_bound);
    FeltPoint { position: point.position, band: Band { std: point.std.min(bound), bound }, drift: Band::default() }
}

impl Profile {
    /// The map that the outlines make: with bands, corners and unknown stretches; odometry frame.
    ///
    /// # Errors
    ///
    /// No outline.
    pub fn map(&self, options: &MapAssemblyOptions) -> Result<AssembledMap> {
        let lines: Vec<FeltLine> = self.outlines.iter().map(|outline| outline.felt(options)).collect();
        assemble(&lines, options)
    }
}

/// What sweeps found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Profile {
    /// Lines that tips slid along, the longest first.
    pub outlines: Vec<Outline>,
    /// Points that the whiskers' sides leant on, with their standard deviations (m).
    pub pegs: Vec<(Vec2, f64)>,
    /// What happened in each log.
    pub events: Vec<Vec<Event>>,
    /// Sliding contacts, and how many of them are on no outline since they are not known well enough.
    pub contacts: usize,
    /// See `contacts`.
    pub left_out: usize,
    /// Where the search was stopped: the log's index, and from when on contacts are missing (s), as those of the logs after it are.
    pub stopped_at: Option<(usize, f64)>,
}

/// The outline that one or more sweeps in one odometry frame felt.
///
/// # Errors
///
/// No log, options out of range, or a log without moments, with its name.
pub fn profile(
    logs: &[SensorLog],
    robot: &Robot,
    contact: &ContactOptions,
    options: &ProfileOptions,
) -> Result<Profile> {
    profile_until(logs, robot, contact, options, &Stop::default(), &mut |_, _, _| {})
}

/// As [`profile`], until `stop` is asked for; `observer` is told the log's index and how many of all its readings in contact are gone
/// through.
///
/// What a stopped search leaves are the outlines of the contacts before; [`Profile::stopped_at`] says where it was.
///
/// # Errors
///
/// As [`profile`].
pub fn profile_until(
    logs: &[SensorLog],
    robot: &Robot,
    contact: &ContactOptions,
    options: &ProfileOptions,
    stop: &Stop,
    observer: &mut dyn FnMut(usize, usize, usize),
) -> Result<Profile> {
    options.check()?;
    if logs.is_empty() {
        return Err(Error::usage("no log").remedy("give one or more logs"));
    }
    let mut profile = Profile::default();
    let mut all: Vec<Vec<Sample>> = Vec::new();
    for (index, log) in logs.iter().enumerate() {
        let name = |error: Error| match &log.source {
            Some(file) => error.in_file(file),
            None => error,
        };
        let mut tell = |done, all| observer(index, done, all);
        let report = contacts_until(log, robot, contact, stop, &mut tell).map_err(name)?;
        profile.contacts += report.steps.len();
        profile.pegs.extend(pegs(&report));
        let found = runs(&report, options);
        profile.left_out += report.steps.len() - found.iter().map(Vec::len).sum::<usize>();
        all.extend(found);
        profile.events.push(report.events);
        if let Some(t) = report.stopped_at {
            profile.stopped_at = Some((index, t));
            break;
        }
    }
    profile.outlines = chains(all, options.reach).iter().map(|chain| outline(chain, options)).collect();
    profile.outlines.retain(|outline| outline.points.len() > 1);
    profile.outlines.sort_by_key(|outline| core::cmp::Reverse(outline.points.len()));
    Ok(profile)
}

/// The outlines of runs of felt points, those that run along each other as their mean; the longest first.
pub(crate) fn merged(runs: &[Vec<OutlinePoint>], options: &ProfileOptions) -> Vec<Outline> {
    let sample = |p: &OutlinePoint| Sample { position: p.position, normal: p.normal, std: p.std };
    let runs = runs.iter().map(|run| run.iter().map(sample).collect()).collect();
    let mut outlines: Vec<Outline> = chains(runs, options.reach).iter().map(|chain| outline(chain, options)).collect();
    outlines.retain(|outline| outline.points.len() > 1);
    outlines.sort_by_key(|outline| core::cmp::Reverse(outline.points.len()));
    outlines
}

/// Evenly spaced points of a line, each moved to the mean of the runs beside it.
fn outline(chain: &Chain, options: &ProfileOptions) -> Outline {
    let mut points = Vec::new();
    let (mut along, mut due) = (0.0, 0.0);
    let mut last: Option<Vec2> = None;
    let runs = chain.runs.iter().enumerate();
    let points_of =
        runs.flat_map(|(run, samples)| samples.iter().enumerate().map(move |(k, s)| (s.position, (run, k))));
    let near = NearPoints::new(options.resolution.hypot(options.reach), points_of);
    for sample in &chain.line {
        along += last.map_or(0.0, |last| last.distance(sample.position));
        last = Some(sample.position);
        if along >= due {
            points.push(averaged(sample, &near, &chain.runs, options));
            due = along + options.resolution;
        }
    }
    Outline { points, closed: chain.closed }
}

/// The mean of all runs beside a sample, weighted by what each is worth.
fn averaged(
    sample: &Sample,
    near: &NearPoints<(usize, usize)>,
    runs: &[Vec<Sample>],
    options: &ProfileOptions,
) -> OutlinePoint {
    let tangent = sample.normal.perp();
    let is_beside = |&(run, k): &(usize, usize)| {
        let other = &runs[run][k];
        let d = other.position - sample.position;
        d.dot(tangent).abs() <= options.resolution
            && d.dot(sample.normal).abs() <= options.reach
            && other.normal.dot(sample.normal) > 0.5
    };
    let mut found: Vec<(usize, usize)> =
        near.around(sample.position).map(|(_, index)| index).filter(is_beside).collect();
    found.sort_unstable();
    let of_run = |some: &[(usize, usize)]| {
        let (mut offset, mut std) = (0.0, 0.0);
        for &(run, k) in some {
            let other = &runs[run][k];
            offset += (other.position - sample.position).dot(sample.normal);
            std += other.std;
        }
        let count = some.len() as f64;
        (offset / count, (std / count).max(LEAST_STD))
    };
    let mut beside: Vec<(f64, f64)> = found.chunk_by(|a, b| a.0 == b.0).map(of_run).collect();
    reject(&mut beside);
    let weight: f64 = beside.iter().map(|(_, std)| 1.0 / (std * std)).sum();
    let sum: f64 = beside.iter().map(|(offset, std)| offset / (std * std)).sum();
    let (offset, std) = if weight > 0.0 { (sum / weight, 1.0 / weight.sqrt()) } else { (0.0, sample.std) };
    OutlinePoint { position: sample.position + sample.normal * offset, normal: sample.normal, std, runs: beside.len() }
}

/// Drops runs that contradict the middle one of at least three.
fn reject(beside: &mut Vec<(f64, f64)>) {
    if beside.len() < 3 {
        return;
    }
    let mut offsets: Vec<f64> = beside.iter().map(|(offset, _)| *offset).collect();
    offsets.sort_by(f64::total_cmp);
    let middle = offsets[offsets.len() / 2];
    beside.retain(|(offset, std)| (offset - middle).abs() <= OUTLIER * std);
}
