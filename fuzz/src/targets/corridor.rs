//! Whole commands on damaged logs: an answer or a refusal, whatever the method.

use super::{Verdict, promise, read, refused, size};
use std::sync::LazyLock;
use vibrissa::config::{
    ContactOptions, DeterministicOptions, PossibilisticOptions, ProbabilisticOptions, ProfileOptions,
};
use vibrissa::flow::sensor_log::SensorLog;
use vibrissa::plane::Vec2;
use vibrissa::tasks::contact::contacts;
use vibrissa::tasks::{demo, profile::profile};
use vibrissa::world::{Map, Robot};
use vibrissa::{Method, localize};

static ARENA: LazyLock<vibrissa::Result<Map>> = LazyLock::new(demo::arena);

/// Logs of more rows than this take longer than a try may.
const MOST_ROWS: usize = 100;

// Coarse options, since most inputs are better than good ones.

pub(crate) fn deterministic(bytes: &[u8]) -> Verdict {
    let options = DeterministicOptions { boundary_spacing: 0.05, ..DeterministicOptions::default() };
    place(bytes, &Method::Deterministic(options))
}

pub(crate) fn possibilistic(bytes: &[u8]) -> Verdict {
    let options = PossibilisticOptions { work: 5, last_work: 0, ..PossibilisticOptions::default() };
    place(bytes, &Method::Possibilistic(options))
}

pub(crate) fn probabilistic(bytes: &[u8]) -> Verdict {
    let options = ProbabilisticOptions { seed_spacing: 0.02, seed_turn: 0.2, ..ProbabilisticOptions::default() };
    place(bytes, &Method::Probabilistic(options))
}

/// The log of a file of `bytes`, as far as a try has time for.
fn log(bytes: &[u8]) -> vibrissa::Result<SensorLog> {
    let mut log = vibrissa::io::log::from_csv(&String::from_utf8_lossy(bytes), "log.csv")?;
    log.rows.truncate(MOST_ROWS);
    Ok(log)
}

fn place(bytes: &[u8], method: &Method) -> Verdict {
    let arena = ARENA.as_ref().map_err(ToString::to_string)?;
    let found = log(bytes).and_then(|log| localize(&log, arena, &Robot::default(), method, &mut |_| {}));
    let answer = match found {
        Ok(answer) => answer,
        Err(error) => return refused(&error),
    };
    let weights: f64 = answer.hypotheses.iter().map(|h| h.weight).sum();
    let sane = answer.hypotheses.is_empty() || (weights > 0.0 && weights <= 1.0 + 1e-9);
    promise(sane, || format!("weights that sum to {weights}"))?;
    let places =
        answer.hypotheses.iter().all(|h| Vec2::new(h.pose.x, h.pose.y).is_finite() && h.pose.theta.is_finite());
    promise(places, || format!("a place that is no numbers: {:?}", answer.hypotheses))?;
    let sizes = answer.steps.iter().all(|s| s.area_m2 >= 0.0 && s.volume >= 0.0);
    promise(sizes, || format!("a set of no size: {:?}", answer.steps))?;
    read((answer.status as u8, size(answer.steps.len()), size(answer.events.len()), size(answer.hypotheses.len())))
}

pub(crate) fn contact(bytes: &[u8]) -> Verdict {
    match log(bytes).and_then(|log| contacts(&log, &Robot::default(), &ContactOptions::default())) {
        Err(error) => refused(&error),
        Ok(report) => {
            let whole = report.steps.iter().filter_map(|s| s.position()).all(Vec2::is_finite);
            promise(whole, || "a contact that is no numbers".into())?;
            read((size(report.steps.len()), size(report.events.len())))
        }
    }
}

pub(crate) fn outline(bytes: &[u8]) -> Verdict {
    let found = log(bytes)
        .and_then(|log| profile(&[log], &Robot::default(), &ContactOptions::default(), &ProfileOptions::default()));
    match found {
        Err(error) => refused(&error),
        Ok(found) => {
            let mut points = found.outlines.iter().flat_map(|o| &o.points);
            promise(points.all(|p| p.position.is_finite() && p.std >= 0.0), || "an outline of no numbers".into())?;
            read((size(found.outlines.len()), size(found.pegs.len()), size(found.left_out)))
        }
    }
}
