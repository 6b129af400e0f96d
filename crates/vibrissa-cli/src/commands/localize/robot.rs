//! The robot that is to be found.

use std::path::Path;
use vibrissa::world::Robot;
use vibrissa::{Method, Result};

/// The robot of the file, or the paper's; its whiskers are those that the method takes.
pub(in crate::commands) fn read(path: Option<&Path>, method: &Method) -> Result<Robot> {
    let Some(path) = path else { return Ok(Robot::default()) };
    let robot = vibrissa::read_robot(path)?;
    for whisker in &robot.whiskers {
        let taken = method.takes(&whisker.beam);
        taken.map_err(|error| error.about(&format!("whisker \"{}\"", whisker.name)).in_file(path))?;
    }
    Ok(robot)
}
