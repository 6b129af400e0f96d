//! What both kinds of recordings hold: the map, readings, poses and whiskers.

use super::picture::{dotted, painted};
use crate::config::limits::FLATTEN_TOLERANCE;
use crate::flow::pose::StampedPose;
use crate::flow::sensor_log::{Channel, Quantity, SensorLog};
use crate::plane::{Pose2, Vec2};
use crate::ros::{
    BagWriter, Header, Kind, Line, LineSet, Stamp, TopicId, encode_cloud, encode_effort, encode_field, encode_grid,
    encode_lines, encode_pose, encode_wrench,
};
use crate::world::Map;

/// The frame of all that is in the map.
pub const MAP: &str = "map";
/// Most messages of each kind that is only looked at: more than anybody sees on a screen.
pub const MOST_SHOWN: usize = 1000;

/// Colour of walls (RGB).
pub const WALL: [u8; 3] = [40, 44, 52];
/// Colour of whiskers.
pub const WHISKER: [u8; 3] = [214, 96, 20];
/// Colour of states.
pub const STATES: [u8; 3] = [32, 110, 200];
const HEIGHTS: [f64; 3] = [0.0, 0.5e-3, 1e-3];
/// Height at which states are drawn (m), over the map.
pub const STATES_HEIGHT: f64 = HEIGHTS[1];
/// Height at which whiskers are drawn (m), over the states.
pub const WHISKER_HEIGHT: f64 = HEIGHTS[2];

/// Every so many items, so that no more than `most` are left.
#[must_use]
pub fn stride(count: usize, most: usize) -> usize {
    count.div_ceil(most.max(1)).max(1)
}

/// The header of a message in the map frame at the time `t` (s).
#[must_use]
pub fn in_map(t: f64) -> Header<'static> {
    Header { stamp: Stamp::from_seconds(t), frame: MAP }
}

/// The map, said once at `t`: cells, points and lines.
pub fn add_map(bag: &mut BagWriter, map: &Map, t: f64) {
    let header = in_map(t);
    let cells = bag.topic("/map", Kind::Grid, true);
    bag.push(cells, header.stamp, encode_grid(header, &painted(map)));
    let points = bag.topic("/vibrissa/map", Kind::Cloud, true);
    bag.push(points, header.stamp, encode_cloud(header, dotted(map).into_iter().map(|p| (p, 0.0, WALL))));
}

/// The map's boundaries as lines.
#[must_use]
pub fn map_lines(map: &Map) -> LineSet {
    let line = |boundary: &crate::world::Boundary| Line {
        points: boundary.curve().flatten(20.0 * FLATTEN_TOLERANCE),
        closed: false,
    };
    let size = map.bounds().size();
    LineSet {
        name: "map",
        color: color(WALL),
        width: 2e-3 * size.x.max(size.y),
        height: 0.0,
        lines: map.boundaries().iter().map(line).collect(),
    }
}

/// A colour as `RViz` has it.
#[must_use]
pub fn color(bytes: [u8; 3]) -> [f32; 4] {
    let [r, g, b] = bytes.map(|byte| f32::from(byte) / 255.0);
    [r, g, b, 1.0]
}

/// Every reading of the log on the topics that logs are read from, and as efforts.
pub fn add_readings(bag: &mut BagWriter, log: &SensorLog) {
    for (index, channel) in log.channels.iter().enumerate() {
        let (base, frame) = topic_of(channel);
        match channel.quantity {
            Quantity::Moment => {
                let topic = bag.topic(format!("{base}/wrench"), Kind::Wrench, false);
                for row in &log.rows {
                    let header = Header { stamp: Stamp::from_seconds(row.t), frame: &frame };
                    bag.push(topic, header.stamp, encode_wrench(header, reading(&row.readings, index)));
                }
            }
            Quantity::FluxX => {
                let axes = [Quantity::FluxX, Quantity::FluxY, Quantity::FluxZ].map(|quantity| {
                    log.channels.iter().position(|c| c.quantity == quantity && c.whisker == channel.whisker)
                });
                let topic = bag.topic(format!("{base}/magnetic_field"), Kind::Field, false);
                for row in &log.rows {
                    let header = Header { stamp: Stamp::from_seconds(row.t), frame: &frame };
                    let flux = axes.map(|axis| axis.map_or(0.0, |axis| reading(&row.readings, axis)));
                    bag.push(topic, header.stamp, encode_field(header, flux));
                }
            }
            _ => {}
        }
    }
    add_efforts(bag, log);
}

/// The moments as the efforts of joints, which viewers plot: all whiskers in one message.
fn add_efforts(bag: &mut BagWriter, log: &SensorLog) {
    let moments: Vec<usize> =
        (0..log.channels.len()).filter(|&c| log.channels[c].quantity == Quantity::Moment).collect();
    if moments.is_empty() {
        return;
    }
    let names: Vec<String> = moments.iter().map(|&c| topic_of(&log.channels[c]).1).collect();
    let topic = bag.topic("/vibrissa/moment", Kind::Joints, false);
    for row in log.rows.iter().step_by(stride(log.rows.len(), 4 * MOST_SHOWN)) {
        let values: Vec<f64> = moments.iter().map(|&c| reading(&row.readings, c)).collect();
        let header = in_map(row.t);
        bag.push(topic, header.stamp, encode_effort(header, &names, &values));
    }
}

fn reading(readings: &[f64], index: usize) -> f64 {
    readings.get(index).copied().unwrap_or(0.0)
}

/// The topic under which a whisker's readings stand, and the frame of its base.
fn topic_of(channel: &Channel) -> (String, String) {
    if channel.whisker.is_empty() {
        return ("/whisker".into(), "whisker_base".into());
    }
    // Names of topics are made of letters, digits and underscores.
    let plain: String = channel.whisker.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    (format!("/whisker/{plain}"), format!("{plain}_base"))
}

/// Poses of the robot, thinned to what is looked at.
pub fn add_poses(bag: &mut BagWriter, topic: TopicId, poses: &[StampedPose]) {
    for pose in shown(poses) {
        let header = in_map(pose.t);
        bag.push(topic, header.stamp, encode_pose(header, pose.map_from_robot, None));
    }
}

/// An even share of the poses, the last one always.
pub fn shown(poses: &[StampedPose]) -> impl Iterator<Item = &StampedPose> {
    let every = stride(poses.len(), MOST_SHOWN);
    poses.iter().enumerate().filter(move |(i, _)| i % every == 0 || i + 1 == poses.len()).map(|(_, pose)| pose)
}

/// Whiskers at one time, as points and as lines.
pub fn add_whiskers(bag: &mut BagWriter, topics: [TopicId; 2], t: f64, shapes: &[Vec<Vec2>]) {
    let header = in_map(t);
    let dots = shapes.iter().flat_map(|shape| dense(shape)).map(|p| (p, WHISKER_HEIGHT, WHISKER));
    bag.push(topics[0], header.stamp, encode_cloud(header, dots));
    let lines = shapes.iter().map(|shape| Line { points: shape.clone(), closed: false }).collect();
    let set = LineSet { name: "whisker", color: color(WHISKER), width: 0.8e-3, height: WHISKER_HEIGHT, lines };
    bag.push(topics[1], header.stamp, encode_lines(header, &[set]));
}

/// Points so near to each other that they look like a line.
fn dense(points: &[Vec2]) -> Vec<Vec2> {
    const BETWEEN: usize = 6;
    let share = |k: usize| k as f64 / BETWEEN as f64;
    points.windows(2).flat_map(|w| (0..BETWEEN).map(move |k| w[0] + (w[1] - w[0]) * share(k))).collect()
}

/// A state as points: where the robot is, and a short tail of points towards where it looks.
pub fn arrow(state: &Pose2, length: f64) -> impl Iterator<Item = Vec2> {
    let (from, way) = (state.position(), Vec2::from_angle(state.theta) * length);
    (0..4).map(move |k| from + way * (f64::from(k) / 4.0))
}
