//! The recording of a simulated sweep: a log to localize from, and the truth beside it.

use crate::Result;
use crate::flow::sensor_log::SensorLog;
use crate::io::recording::parts::{
    MOST_SHOWN, add_map, add_poses, add_readings, add_whiskers, in_map, map_lines, stride,
};
use crate::io::ros::{BagWriter, Header, Kind, Stamp, encode_lines, encode_odometry, encode_text};
use crate::plane::Vec2;
use crate::simulate::{Sweep, shapes};
use crate::world::{Map, Robot};

/// The recording (MCAP) of a simulated sweep; [`super`] lists the topics. `log` is what was recorded of the sweep.
///
/// Raw counts and absolute headings have no message of ROS and are left out.
///
/// # Errors
///
/// More whiskers than a recording has topics.
pub fn sweep_mcap(map: &Map, robot: &Robot, sweep: &Sweep, log: &SensorLog) -> Result<Vec<u8>> {
    let start = log.rows.first().map_or(0.0, |row| row.t);
    let mut bag = BagWriter::default();
    add_map(&mut bag, map, start);
    let lines = bag.topic("/vibrissa/lines", Kind::Markers, false);
    let header = in_map(start);
    bag.push(lines, header.stamp, encode_lines(header, &[map_lines(map)]));
    let odom = bag.topic("/odom", Kind::Odometry, false);
    for row in &log.rows {
        let header = Header { stamp: Stamp::from_seconds(row.t), frame: "odom" };
        bag.push(odom, header.stamp, encode_odometry(header, "base_link", row.odom_from_robot));
    }
    add_readings(&mut bag, log);
    let truth = bag.topic("/truth", Kind::Pose, false);
    add_poses(&mut bag, truth, &sweep.truth);
    let dots = bag.topic("/vibrissa/whisker", Kind::Cloud, false);
    let drawn = shapes(robot, sweep, stride(sweep.truth.len(), MOST_SHOWN));
    for here in drawn.chunk_by(|a, b| a.row == b.row) {
        let points: Vec<Vec<Vec2>> = here.iter().map(|s| s.points.iter().step_by(4).copied().collect()).collect();
        add_whiskers(&mut bag, [dots, lines], sweep.truth[here[0].row].t, &points);
    }
    let events = bag.topic("/vibrissa/event", Kind::Text, false);
    for event in &sweep.events {
        let text = format!("{}: {}", event.kind, event.detail);
        bag.push(events, Stamp::from_seconds(event.t), encode_text(&text));
    }
    bag.finish()
}
