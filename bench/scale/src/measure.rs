//! Times of one case, and its memory.

use crate::Case;
use crate::world::World;
use serde_json::{Value, json};
use std::time::{Duration, Instant};
use vibrissa::flow::pose::{Estimate, Localization};
use vibrissa::flow::sensor_log::LogRow;
use vibrissa::plane::Vec2;
use vibrissa::world::Map;
use vibrissa::{Error, Localizer, Method, Result};
use vibrissa_live::estimate::LiveEstimator;
use vibrissa_live::join::JoinedRow;

/// Estimates a second of a live run.
const TOLD: f64 = 30.0;
/// An answer nearer than this to the truth is right (m).
const RIGHT: f64 = 5e-3;

/// A localizer of a whole log, or of a running robot.
enum Runner<'a> {
    Whole(Localizer<'a>),
    Live(Box<LiveEstimator<'a>>),
}

impl<'a> Runner<'a> {
    fn new(case: &Case, map: &'a Map, world: &'a World) -> Result<Self> {
        if case.method == "live" {
            let estimator = LiveEstimator::new(map, &world.robot, &world.channels, &method(case, world)?, TOLD)?;
            return Ok(Self::Live(Box::new(estimator)));
        }
        Ok(Self::Whole(Localizer::new(map, &world.robot, &world.channels, &method(case, world)?)?))
    }

    fn step(&mut self, row: LogRow) -> Result<()> {
        match self {
            Self::Whole(localizer) => localizer.step(&row),
            Self::Live(estimator) => {
                let arrival = row.t;
                estimator.step(&JoinedRow { row, arrival, travel: [0.0; 2] }).map(|_| ())
            }
        }
    }

    fn estimate(&self) -> Estimate {
        match self {
            Self::Whole(localizer) => localizer.estimate(),
            Self::Live(estimator) => estimator.estimate(),
        }
    }

    fn finish(self) -> Localization {
        match self {
            Self::Whole(localizer) => localizer.finish(),
            Self::Live(estimator) => estimator.finish(),
        }
    }
}

fn method(case: &Case, world: &World) -> Result<Method> {
    let name = if case.method == "live" { "probabilistic" } else { &case.method };
    let all: Vec<&str> = Method::all().iter().map(Method::name).collect();
    let mut method = Method::all()
        .into_iter()
        .find(|method| method.name() == name)
        .ok_or_else(|| Error::usage("method").value(&case.method).allowed(format!("{}, live", all.join(", "))))?;
    let prior = case.within.then(|| world.region());
    match &mut method {
        Method::Deterministic(options) => options.prior = prior,
        Method::Possibilistic(options) => options.prior = prior,
        Method::Probabilistic(options) => options.prior = prior,
    }
    Ok(method)
}

/// Times of the processor between calls.
struct Clock {
    begun: Option<Duration>,
    wall: Instant,
}

impl Clock {
    fn start() -> Self {
        Self { begun: worked(), wall: Instant::now() }
    }

    /// Seconds since the start, which begins anew.
    fn lap(&mut self) -> f64 {
        let now = worked();
        let worked = now.zip(self.begun).map_or(self.wall.elapsed(), |(now, begun)| now.saturating_sub(begun));
        *self = Self { begun: now, wall: Instant::now() };
        worked.as_secs_f64()
    }
}

/// How long this thread has worked, where the system tells.
fn worked() -> Option<Duration> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    text.split(' ').next()?.parse().ok().map(Duration::from_nanos)
}

/// The largest memory so far (MB), where the system tells.
fn most_memory() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.split_whitespace().next()?.parse::<f64>().ok().map(|kilobytes| kilobytes / 1024.0)
}

/// Measures a case.
///
/// # Errors
///
/// A case that the method refuses.
pub(crate) fn measured(case: &Case) -> Result<Value> {
    let world = World::new(case)?;
    let mut clock = Clock::start();
    let map = world.map()?;
    let read_s = clock.lap();
    let mut runner = Runner::new(case, &map, &world)?;
    let new_s = clock.lap();
    let mut rows = world.rows(case.rows);
    // Up to the first row at which places are told, a row at a time.
    let (mut told, mut early_s, mut longest_s, mut before) = (false, 0.0, 0.0_f64, 0);
    for row in rows.by_ref() {
        clock.lap();
        runner.step(row)?;
        let step = clock.lap();
        (early_s, longest_s) = (early_s + step, longest_s.max(step));
        before += 1;
        told = !runner.estimate().hypotheses.is_empty();
        if told {
            break;
        }
    }
    clock.lap();
    // The rest in one go: reading the clock takes as long as a row.
    let mut after = 0_usize;
    let mut half = (0_usize, 0.0);
    for row in rows {
        runner.step(row)?;
        after += 1;
        if after == (case.rows - before) / 2 {
            half = (after, clock.lap());
        }
    }
    let second = clock.lap();
    let row_us = 1e6 * (half.1 + second) / after.max(1) as f64;
    let late_row_us = 1e6 * second / (after - half.0).max(1) as f64;
    let before_end = most_memory();
    let answer = runner.finish();
    let end_s = clock.lap();
    // Where no row tells places, the end does.
    let first_s = if told { new_s + early_s } else { new_s + early_s + end_s };
    let truth = Vec2::new(world.last().x, world.last().y);
    let off = answer.estimate.map(|pose| pose.position().distance(truth));
    Ok(json!({
        "method": case.method, "outline_m": case.outline, "vertices": case.vertices, "rows": case.rows,
        "whiskers": case.whiskers, "within": case.within, "read_s": read_s, "new_s": new_s, "first_places_s": first_s,
        "first_places_row": told.then_some(before), "longest_early_row_s": longest_s, "row_us": row_us, "late_row_us": late_row_us, "end_s": end_s,
        "total_s": read_s + new_s + early_s + half.1 + second + end_s, "rows_mb": before_end, "mb": most_memory(),
        "status": answer.status.as_str(), "places": answer.hypotheses.len(), "off_mm": off.map(|metres| 1e3 * metres),
        "right": off.is_some_and(|metres| metres < RIGHT),
    }))
}
