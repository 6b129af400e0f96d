//! A recorded run again: the same bytes in, the same lines out.

use crate::carry::carried;
use crate::estimate::{LiveEstimator, Told, UsedRow};
use crate::join::JoinedRow;
use crate::journal::{Recorded, chunks};
use crate::pipeline::{Notice, Pipeline};
use crate::setup::Setup;
use crate::{Error, Result};
use core::ops::ControlFlow;
use std::collections::VecDeque;
use std::time::{Duration, Instant};
use vibrissa_core::flow::pose::{Estimate, Localization};
use vibrissa_core::world::{Map, Odometry, Robot};

/// How a recording is played.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pace {
    /// Times its own speed; none for as fast as it goes.
    pub speed: Option<f64>,
    /// Whether every row is taken, also those that others stood for during the run.
    pub every_row: bool,
}

/// What is told while a recording is played.
#[derive(Debug)]
pub enum Played<'a> {
    /// An estimate is due.
    Estimate(&'a Told),
    /// Something happened to a source, or to a row.
    Notice(&'a Notice),
}

/// What a recording that was played ends with.
#[derive(Debug)]
pub struct Replayed {
    /// The estimate after the last row.
    pub estimate: Estimate,
    /// The answer; none where there was no row.
    pub answer: Option<Localization>,
    /// Rows that the estimator took.
    pub rows: u64,
    /// Rows that it took during the run and that the raw bytes do not give again: raw bytes were dropped, or lost at the cut.
    pub missing: u64,
}

/// Plays a recording through a setup, which may be another than the recorded one but has its sources; `watch` may break off.
///
/// Rows that piled up during the run are merged as they were then, so that the estimates are the same to the byte.
///
/// # Errors
///
/// A recording that cannot be read, sources that cannot be joined, a robot or a map that the method does not cover.
pub fn replay(
    recorded: &Recorded,
    setup: &Setup,
    map: &Map,
    robot: &Robot,
    pace: Pace,
    watch: &mut dyn FnMut(Played<'_>) -> ControlFlow<()>,
) -> Result<Replayed> {
    let mut pipeline = Pipeline::new(setup, robot)?;
    let mut rows = Vec::new();
    let (mut began, mut stopped) = (None, false);
    let mut player =
        Player { used: &recorded.used, next: 0, every_row: pace.every_row, passed: 0, rows: 0, missing: 0 };
    let mut teller = Teller {
        // By another setup, or with other rows, what was told then means nothing.
        told: if pace.every_row { &[] } else { &recorded.told },
        next: 0,
        kept: VecDeque::new(),
        odometry: robot.odometry,
    };
    // The estimator borrows a robot that is known only when the sources have said what they hold.
    let known = robot_of(recorded, setup, robot)?;
    let mut estimator = match &known {
        Some((channels, robot)) => Some(LiveEstimator::new(map, robot, channels, &setup.method, setup.estimate_rate)?),
        None => None,
    };
    let mut feed = |pipeline: &mut Pipeline, rows: &mut Vec<JoinedRow>, stopped: &mut bool| {
        for notice in pipeline.take_notices() {
            *stopped |= watch(Played::Notice(&notice)).is_break();
        }
        for joined in rows.drain(..) {
            let Some(estimator) = estimator.as_mut() else { continue };
            let step = player.take(&joined).map_or(Ok(None), |used| estimator.step(&used.joined));
            let told = step.unwrap_or_else(|error| {
                let text = error.to_string().replace("\n  help: ", "; ");
                let notice = Notice { t: joined.row.t, source: "rows".to_owned(), text };
                *stopped |= watch(Played::Notice(&notice)).is_break();
                None
            });
            for told in teller.tell(&joined, told) {
                *stopped |= watch(Played::Estimate(&told)).is_break();
            }
        }
    };
    let result = chunks(recorded, |chunk| {
        if stopped {
            return Err(broken_off());
        }
        if let Some(speed) = pace.speed {
            let (start, first) = *began.get_or_insert((Instant::now(), chunk.arrival));
            let due = Duration::try_from_secs_f64((chunk.arrival - first) / speed).unwrap_or_default();
            std::thread::sleep(due.saturating_sub(start.elapsed()));
        }
        pipeline.push(&chunk, &mut |row| rows.push(row))?;
        feed(&mut pipeline, &mut rows, &mut stopped);
        Ok(())
    });
    if !stopped {
        result?;
    }
    pipeline.finish(&mut |row| rows.push(row));
    feed(&mut pipeline, &mut rows, &mut stopped);
    let estimate = estimator.as_ref().map(LiveEstimator::estimate).unwrap_or_default();
    let missing = if stopped { 0 } else { player.missing + (recorded.used.len() - player.next) as u64 };
    Ok(Replayed { estimate, answer: estimator.map(LiveEstimator::finish), rows: player.rows, missing })
}

/// Ends the reading of a recording; never told.
fn broken_off() -> Error {
    Error::data("broken off")
}

/// The channels of the rows and the robot with its calibrations' bounds, as the recorded bytes say them.
fn robot_of(
    recorded: &Recorded,
    setup: &Setup,
    robot: &Robot,
) -> Result<Option<(Vec<vibrissa_core::flow::sensor_log::Channel>, Robot)>> {
    let mut pipeline = Pipeline::new(setup, robot)?;
    let mut known = pipeline.channels().map(<[_]>::to_vec);
    let result = chunks(recorded, |chunk| {
        if known.is_some() {
            return Err(broken_off());
        }
        pipeline.push(&chunk, &mut |_| {})?;
        known = pipeline.channels().map(<[_]>::to_vec);
        Ok(())
    });
    if known.is_none() {
        result?;
    }
    Ok(known.map(|channels| (channels, pipeline.robot())))
}

/// Tells estimates when they were told during the run, carried on as they were then.
struct Teller<'a> {
    told: &'a [(u64, u64)],
    next: usize,
    /// Estimates that may still be told or carried on.
    kept: VecDeque<Told>,
    odometry: Odometry,
}

impl Teller<'_> {
    /// What was told at a row, after which the estimator says `told`.
    fn tell(&mut self, joined: &JoinedRow, told: Option<Told>) -> Vec<Told> {
        if self.told.is_empty() {
            return told.into_iter().collect();
        }
        self.kept.extend(told);
        let mut out = Vec::new();
        while let Some(&(row, from)) = self.told.get(self.next).filter(|(row, _)| *row <= joined.row.line as u64) {
            self.next += 1;
            while self.kept.front().is_some_and(|kept| kept.from < from) {
                self.kept.pop_front();
            }
            let Some(kept) = self.kept.front().filter(|kept| kept.from == from) else { continue };
            if row == joined.row.line as u64 {
                out.push(if row == from { kept.clone() } else { carried(kept, joined, &self.odometry) });
            }
        }
        out
    }
}

/// Takes the rows that were taken during the run.
struct Player<'a> {
    used: &'a [u64],
    next: usize,
    every_row: bool,
    passed: u64,
    rows: u64,
    missing: u64,
}

impl Player<'_> {
    fn take(&mut self, joined: &JoinedRow) -> Option<UsedRow> {
        let number = joined.row.line as u64;
        if !self.every_row {
            while self.used.get(self.next).is_some_and(|used| *used < number) {
                self.next += 1;
                self.missing += 1;
            }
            if self.used.get(self.next) != Some(&number) {
                self.passed += 1;
                return None;
            }
        }
        self.next = (self.next + 1).min(self.used.len());
        self.rows += 1;
        Some(UsedRow { joined: joined.clone(), merged: 1 + core::mem::take(&mut self.passed) })
    }
}
