//! Where the robot is: the one-call door to the whole corridor.

use crate::Result;
use crate::flow::pose::{Localization, Method, Status};
use crate::flow::sensor_log::SensorLog;
use crate::world::{Map, Robot};

/// What can be chosen about a localization.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LocalizeOptions {
    /// The estimator.
    pub method: Method,
}

impl Default for LocalizeOptions {
    fn default() -> Self {
        Self { method: Method::Deterministic }
    }
}

/// Localizes a robot from what it recorded; `observer` is called with the index of each row once it is used.
///
/// # Errors
///
/// None yet.
pub fn localize(
    log: &SensorLog,
    _map: &Map,
    _robot: &Robot,
    options: &LocalizeOptions,
    observer: &mut dyn FnMut(usize),
) -> Result<Localization> {
    (0..log.rows.len()).for_each(observer);
    Ok(Localization {
        method: options.method,
        status: Status::NoContact,
        estimate: None,
        hypotheses: Vec::new(),
        trajectory: Vec::new(),
        states: Vec::new(),
        first_states: Vec::new(),
        steps: Vec::new(),
        events: Vec::new(),
        shapes: Vec::new(),
    })
}
