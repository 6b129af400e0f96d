//! The whole corridor on damaged logs: an answer or a refusal.

use super::{Verdict, promise, read, refused, size};
use std::sync::LazyLock;
use vibrissa::config::DeterministicOptions;
use vibrissa::flow::sensor_log::SensorLog;
use vibrissa::plane::Vec2;
use vibrissa::tasks::demo;
use vibrissa::world::{Map, Robot};
use vibrissa::{LocalizeOptions, localize as run};

static ARENA: LazyLock<vibrissa::Result<Map>> = LazyLock::new(demo::arena);

/// Logs of more rows than this take longer than a try may.
const MOST_ROWS: usize = 100;

pub(crate) fn localize(bytes: &[u8]) -> Verdict {
    let arena = ARENA.as_ref().map_err(ToString::to_string)?;
    let mut log = match SensorLog::from_csv(&String::from_utf8_lossy(bytes), "log.csv") {
        Ok(log) => log,
        Err(error) => return refused(&error),
    };
    log.rows.truncate(MOST_ROWS);
    let deterministic = DeterministicOptions { boundary_spacing: 0.05, ..DeterministicOptions::default() };
    let options = LocalizeOptions { deterministic, ..LocalizeOptions::default() };
    let answer = match run(&log, arena, &Robot::default(), &options, &mut |_| {}) {
        Ok(answer) => answer,
        Err(error) => return refused(&error),
    };
    let weights: f64 = answer.hypotheses.iter().map(|h| h.weight).sum();
    let sane = answer.hypotheses.is_empty() || (weights > 0.0 && weights <= 1.0 + 1e-9);
    promise(sane, || format!("weights that sum to {weights}"))?;
    let places =
        answer.hypotheses.iter().all(|h| Vec2::new(h.pose.x, h.pose.y).is_finite() && h.pose.theta.is_finite());
    promise(places, || format!("a place that is no numbers: {:?}", answer.hypotheses))?;
    read((answer.status as u8, size(answer.steps.len()), size(answer.events.len()), size(answer.hypotheses.len())))
}
