//! Odometry by itself, as stages, bases and motion capture leave it.

use super::foreign::{Format, Recording};
use crate::flow::pose::StampedPose;
use crate::plane::Pose2;
use crate::trajectory::read_tum;
use crate::{Error, Result};
use std::path::Path;

/// The robot over time from a file: `.tum` (or `.txt`) lines, the `nav_msgs/Odometry` of a recording `.mcap`, else CSV with the columns
/// `t,x,y,theta` (s, m, rad) among others.
///
/// # Errors
///
/// A file that cannot be read or holds no odometry; a clock that does not increase.
pub fn read_odometry(path: impl AsRef<Path>) -> Result<Vec<StampedPose>> {
    let path = path.as_ref();
    match path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase().as_str() {
        "tum" | "txt" => read_tum(path),
        #[cfg(feature = "mcap")]
        "mcap" => of_recording(path),
        _ => of_csv(path),
    }
}

fn of_csv(path: &Path) -> Result<Vec<StampedPose>> {
    let recording = Recording::read(path, Format::Csv)?;
    let [x, y, theta] = [recording.require("x")?, recording.require("y")?, recording.require("theta")?];
    if recording.t.len() != recording.lines.len() {
        return Err(Error::data("the odometry has no time").in_file(path).remedy("add the column `t` (s)"));
    }
    let pose = |(i, &t): (usize, &f64)| StampedPose { t, map_from_robot: Pose2::new(x[i], y[i], theta[i]) };
    Ok(recording.t.iter().enumerate().map(pose).collect())
}

#[cfg(feature = "mcap")]
fn of_recording(path: &Path) -> Result<Vec<StampedPose>> {
    use super::bag::too_many_messages;
    use crate::config::budgets::MOST_MESSAGES;
    use crate::ros::{Kind, decode_odometry, read_bag};
    let file = crate::text::open(path, "odometry")?;
    let mut topics: Vec<String> = Vec::new();
    let mut poses: Vec<StampedPose> = Vec::new();
    read_bag(file, &path.to_string_lossy(), |topic, _, bytes| {
        if topic.kind == Some(Kind::Odometry)
            && let Some((header, map_from_robot)) = decode_odometry(bytes)
        {
            if poses.len() >= MOST_MESSAGES {
                return Err(too_many_messages());
            }
            if !topics.contains(&topic.name) {
                topics.push(topic.name.clone());
            }
            poses.push(StampedPose { t: header.stamp.seconds(), map_from_robot });
        }
        Ok(())
    })?;
    if topics.is_empty() {
        return Err(Error::data("the recording holds no odometry")
            .in_file(path)
            .allowed("a topic of nav_msgs/msg/Odometry")
            .remedy("record the robot's odometry too"));
    }
    if topics.len() > 1 {
        return Err(Error::data("the recording holds several topics of odometry")
            .in_file(path)
            .value(crate::text::listed(&topics))
            .remedy("`mcap filter` keeps one of the topics"));
    }
    poses.sort_by(|a, b| a.t.total_cmp(&b.t));
    poses.dedup_by(|later, earlier| later.t <= earlier.t);
    Ok(poses)
}
