//! The robot that is to be found.

use std::path::Path;
use vibrissa::Result;
use vibrissa::world::Robot;

/// The robot of the file, or the paper's; its whiskers are those that the methods take.
pub(super) fn read(path: Option<&Path>) -> Result<Robot> {
    let Some(path) = path else { return Ok(Robot::default()) };
    let robot = Robot::read(path)?;
    for whisker in &robot.whiskers {
        whisker.beam.require_uniform().map_err(|error| {
            error.about(&format!("whisker \"{}\"", whisker.name)).in_file(path).remedy(
                "`localize` takes uniform, straight, clamped whiskers only; `contact`, `profile` and `preimage` take this one, too",
            )
        })?;
    }
    Ok(robot)
}
