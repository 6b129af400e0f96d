//! The whiskers of a robot at a row of the log, as the map bends them there.

use crate::host::Host;
use vibrissa::contact::{Bending, BentWhisker};
use vibrissa::flow::sensor_log::{LogRow, Quantity};
use vibrissa::plane::{Pose2, Vec2};
use vibrissa::{Error, Result};

/// Points of a bent whisker.
const POINTS: usize = 25;
/// Rows along which a whisker is followed until then, at most: it hangs on walls as it came to them.
const LEAD: usize = 60;

pub(crate) fn bent(host: &mut Host, row: usize, map_from_robot: Pose2) -> Result<()> {
    let rows = host.log.rows.get(..=row).ok_or_else(|| {
        Error::usage("row").value(row).allowed(format!("0 up to {}, the last of the log", host.log.rows.len()))
    })?;
    let way = &rows[rows.len().saturating_sub(LEAD)..];
    let mut numbers = vec![host.robot.whiskers.len() as f64];
    for mounted in &host.robot.whiskers {
        let mount = mounted.robot_from_whisker;
        let map_from_whisker = map_from_robot.compose(mount);
        let channel = host.log.channel(&mounted.name, Quantity::Moment);
        let read = channel.and_then(|channel| way.last()?.readings.get(channel).copied());
        let noise = mounted.noise;
        let touches = read.filter(|m| m.abs() * (1.0 - noise.moment_relative) > noise.moment_absolute);
        let whisker = BentWhisker::new(host.map()?, &mounted.beam).ok();
        let found = whisker.map(|mut whisker| {
            let held = followed(&mut whisker, way, map_from_robot, mount);
            let reading = touches.map_or_else(Vec::new, |moment| whisker.by_moment(moment, POINTS));
            (held, reading)
        });
        let nowhere = Vec2::new(f64::NAN, f64::NAN);
        let rest = || vec![Vec2::ZERO, Vec2::new(mounted.beam.length, 0.0)];
        let (from, contact, moment, shape) = match found {
            Some((Some(held), _)) if held.shape.len() > 2 => {
                let contact = held.contact.map_or(nowhere, |at| map_from_whisker.transform_point(at));
                (2.0, contact, held.moment.unwrap_or(f64::NAN), held.shape)
            }
            Some((_, by_reading)) if !by_reading.is_empty() => (1.0, nowhere, f64::NAN, by_reading),
            _ => (0.0, nowhere, 0.0, rest()),
        };
        numbers.extend([from, contact.x, contact.y, moment, shape.len() as f64]);
        numbers.extend(shape.into_iter().map(|p| map_from_whisker.transform_point(p)).flat_map(|p| [p.x, p.y]));
    }
    host.numbers = numbers;
    Ok(())
}

/// The whisker at the last row, followed along the odometry.
fn followed(whisker: &mut BentWhisker<'_>, way: &[LogRow], map_from_robot: Pose2, mount: Pose2) -> Option<Bending> {
    let now = way.last()?.odom_from_robot;
    let base = |row: &LogRow| map_from_robot.compose(now.between(row.odom_from_robot)).compose(mount);
    way.iter().map(|row| whisker.at(base(row), POINTS)).last()
}
