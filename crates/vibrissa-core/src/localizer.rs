//! The corridor as one object: each row of a log goes through every door, in flow order.
//!
//! [`crate::localize`] is the one-call door for whole logs; this is the same, row by row, for robots that are running.

mod deterministic;
mod drawn;
mod limit_check;
mod possibilistic;
mod probabilistic;
mod sampling;

pub use deterministic::Localizer;
pub use possibilistic::PossibilisticLocalizer;
pub use probabilistic::ProbabilisticLocalizer;

use crate::config::limits::COARSEST_SPACING;
use crate::flow::sensor_log::{Channel, Quantity};
use crate::world::{Map, Robot};
use crate::{Error, Result};
use limit_check::LimitCheck;

/// At least this many observations are kept for drawing, where there are as many.
const SHAPES: usize = 512;

/// Refuses a column without a name where several whiskers would share it.
fn one_column_each(robot: &Robot, channels: &[Channel]) -> Result<()> {
    let nameless = channels.iter().any(|c| c.quantity == Quantity::Moment && c.whisker.is_empty());
    if robot.whiskers.len() < 2 || !nameless {
        return Ok(());
    }
    let columns: Vec<String> = robot.whiskers.iter().map(|w| format!("{}.moment", w.name)).collect();
    Err(Error::data("the robot has several whiskers, but the log's column `moment` does not say whose it is")
        .value(format!("{} whiskers", robot.whiskers.len()))
        .allowed(columns.join(", "))
        .remedy("rename the column after its whisker, and take whiskers without a column out of the robot file"))
}

/// Refuses a map with more boundary than a search without a region goes through in a time that anybody waits.
fn searchable(map: &Map, prior: Option<[[f64; 2]; 3]>, most: f64) -> Result<()> {
    let (walked, _) = map.walk_in(map.bounds(), COARSEST_SPACING);
    if prior.is_some() || walked <= most {
        return Ok(());
    }
    Err(Error::data("the map has too much boundary to search all of it for the robot")
        .value(format!("{walked:.1} m"))
        .allowed(format!("up to {most} m, or a region for the first pose"))
        .remedy("say where the robot is at the first row (--within), or use the part of the map that it can be in"))
}
