//! Trajectories as text: TUM lines `timestamp tx ty tz qx qy qz qw`.

use crate::config::budgets::TRAJECTORY_BYTES;
use crate::config::limits::MOST_LOG_ROWS;
use crate::flow::pose::{StampedPose, Stretch};
use crate::math;
use crate::plane::Pose2;
use crate::text::{beyond, read_text, short};
use crate::{Error, Result};
use std::fmt::Write;
use std::path::Path;

/// How far a quaternion's length may be from 1 before the columns are taken for something else.
const QUATERNION_SLACK: f64 = 1e-2;

/// Reads a trajectory from a file of lines `timestamp tx ty tz qx qy qz qw` (s, m, unit quaternion).
///
/// Lines that are empty or start with `#` are skipped. The plane is z = 0: `tz` and any tilt are ignored.
///
/// # Errors
///
/// A data error with file and line: the file cannot be read, a line has not eight finite numbers, the clock does not
/// increase, the quaternion has not length 1, or no pose is there at all.
pub fn read_tum(path: impl AsRef<Path>) -> Result<Vec<StampedPose>> {
    let path = path.as_ref();
    let text = read_text(path, "trajectory", TRAJECTORY_BYTES)?;
    parse_tum(&text).map_err(|error| error.in_file(path))
}

/// The trajectory in a text of lines `timestamp tx ty tz qx qy qz qw`; see [`read_tum`].
///
/// # Errors
///
/// As [`read_tum`], without the file's name.
pub fn parse_tum(text: &str) -> Result<Vec<StampedPose>> {
    let mut poses: Vec<StampedPose> = Vec::new();
    for (index, line) in text.trim_start_matches('\u{feff}').lines().enumerate() {
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let pose = parse_line(line).map_err(|error| error.at_line(index + 1))?;
        if let Some(previous) = poses.last().filter(|previous| previous.t >= pose.t) {
            return Err(Error::data("the clock does not increase")
                .at_line(index + 1)
                .value(pose.t)
                .allowed(format!("above {}", previous.t))
                .remedy("sort the lines by time and drop repeated ones"));
        }
        if poses.len() >= MOST_LOG_ROWS {
            let remedy = "cut it into parts, or keep every tenth pose";
            return Err(beyond("the trajectory has too many poses", poses.len() + 1, MOST_LOG_ROWS, remedy));
        }
        poses.push(pose);
    }
    if poses.is_empty() {
        return Err(Error::data("the trajectory holds no pose")
            .at_line(1)
            .remedy("each line reads `timestamp tx ty tz qx qy qz qw`"));
    }
    Ok(poses)
}

fn parse_line(line: &str) -> Result<StampedPose> {
    let remedy = "each line reads `timestamp tx ty tz qx qy qz qw`, separated by spaces";
    let mut values = [0.0; 8];
    // One more than there may be tells that there are too many.
    let fields: Vec<&str> = line.split_whitespace().take(values.len() + 1).collect();
    if fields.len() != values.len() {
        return Err(Error::data("wrong number of columns")
            .value(if fields.len() > 8 { "more than 8".to_owned() } else { fields.len().to_string() })
            .allowed("8")
            .remedy(remedy));
    }
    for (value, field) in values.iter_mut().zip(fields) {
        *value =
            field.parse::<f64>().ok().filter(|number| number.is_finite()).ok_or_else(|| {
                Error::data("not a number").value(short(field)).allowed("a finite number").remedy(remedy)
            })?;
    }
    let [t, x, y, _, qx, qy, qz, qw] = values;
    let length = (qx * qx + qy * qy + qz * qz + qw * qw).sqrt();
    if (length - 1.0).abs() > QUATERNION_SLACK {
        return Err(Error::data("the quaternion has the wrong length")
            .value(length)
            .allowed("1")
            .remedy("the last four columns are qx qy qz qw, in this order"));
    }
    let heading = math::atan2(2.0 * (qw * qz + qx * qy), qw * qw + qx * qx - qy * qy - qz * qz);
    Ok(StampedPose { t, map_from_robot: Pose2::new(x, y, heading) })
}

/// As [`format_tum`], with a comment line `# unsure from T to T` (s) at its head for each stretch in which the trajectory is not
/// sure: readers skip it.
#[must_use]
pub fn format_tum_with_doubts(poses: &[StampedPose], unsure: &[Stretch]) -> String {
    let doubts: String = unsure.iter().map(|s| format!("# unsure from {:.6} to {:.6}\n", s.from, s.to)).collect();
    doubts + &format_tum(poses)
}

/// The trajectory as lines `timestamp tx ty tz qx qy qz qw`: microseconds, nanometres, quaternion to 1e-9.
///
/// Poses that are not finite are left out.
#[must_use]
pub fn format_tum(poses: &[StampedPose]) -> String {
    let mut text = String::new();
    for StampedPose { t, map_from_robot: pose } in poses {
        if !(t.is_finite() && pose.position().is_finite() && pose.theta.is_finite()) {
            continue;
        }
        let (qz, qw) = math::sin_cos(0.5 * pose.theta);
        // Writing into a string cannot fail.
        let _ = writeln!(text, "{t:.6} {:.9} {:.9} 0 0 0 {qz:.9} {qw:.9}", pose.x, pose.y);
    }
    text
}
