//! Whether the way is free: the robot, its outline and the bases of its whiskers never meet a boundary.

use super::Scenario;
use crate::Error;
use crate::plane::{Pose2, Vec2};

/// A fault of the way and when it shows.
pub(super) struct Fault {
    pub(super) error: Error,
    pub(super) t: f64,
}

/// Checks every row.
pub(super) fn free(scenario: &Scenario) -> Result<(), Fault> {
    let mut before: Option<Pose2> = None;
    for pose in &scenario.path {
        let here = pose.map_from_robot;
        let met = match before {
            Some(before) => passed(scenario, before, here),
            None => standing(scenario, here),
        }
        .or_else(|| overlapping(scenario, here));
        if let Some((what, place)) = met {
            let error = Error::data(format!("{what} at t = {:.3} s", pose.t))
                .value(format!("near ({:.4}, {:.4}) m", place.x, place.y))
                .remedy("keep the path clear of walls; the map frame has x to the right, y up");
            return Err(Fault { error, t: pose.t });
        }
        before = Some(here);
    }
    Ok(())
}

type Met = Option<(String, Vec2)>;

/// What is not in free space at the first pose.
fn standing(scenario: &Scenario, here: Pose2) -> Met {
    scenario.robot.whiskers.iter().find_map(|whisker| {
        let base = here.transform_point(whisker.robot_from_whisker.position());
        (!scenario.map.is_free(base))
            .then(|| (format!("the base of the whisker {} is inside a wall", whisker.name), base))
    })
}

/// What goes through a boundary between two poses.
fn passed(scenario: &Scenario, before: Pose2, here: Pose2) -> Met {
    let (from, to) = (before.position(), here.position());
    if scenario.map.crosses(from, to) {
        return Some(("the path goes through a wall".into(), to));
    }
    scenario.robot.whiskers.iter().find_map(|whisker| {
        let mount = whisker.robot_from_whisker.position();
        let (from, to) = (before.transform_point(mount), here.transform_point(mount));
        scenario.map.crosses(from, to).then(|| (format!("the base of the whisker {} meets a wall", whisker.name), to))
    })
}

/// Where the outline meets a boundary.
fn overlapping(scenario: &Scenario, here: Pose2) -> Met {
    let points = &scenario.outline;
    (0..points.len()).find_map(|k| {
        let edge = [points[k], points[(k + 1) % points.len()]].map(|p| here.transform_point(p));
        let met = scenario.map.crosses(edge[0], edge[1]);
        met.then(|| ("the robot's outline meets a wall".into(), edge[0]))
    })
}
