//! The robot that is to be found.

use std::path::Path;
use vibrissa::Result;
use vibrissa::flow::pose::Method;
use vibrissa::world::Robot;

/// The robot of the file, or the paper's; its whiskers are those that the method takes.
pub(super) fn read(path: Option<&Path>, method: Method) -> Result<Robot> {
    let Some(path) = path else { return Ok(Robot::default()) };
    let robot = vibrissa::read_robot(path)?;
    for whisker in &robot.whiskers {
        let (taken, remedy) = match method {
            Method::Possibilistic => (
                whisker.beam.require_uniform(),
                "the possibilistic method takes uniform, straight, clamped whiskers only; --method probabilistic and \
                 deterministic take tapered and jointed ones and elastic bases, too",
            ),
            Method::Deterministic | Method::Probabilistic => (
                whisker.beam.require_straight(),
                "`localize` takes whiskers that are straight at rest; `contact`, `profile` and `preimage` take this one, too",
            ),
        };
        taken.map_err(|error| error.about(&format!("whisker \"{}\"", whisker.name)).in_file(path).remedy(remedy))?;
    }
    Ok(robot)
}
