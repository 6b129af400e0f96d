//! The recording of a localization.

use super::clock::{clock_origin, shift_poses, shifted_answer, shifted_log};
use super::parts::{
    MOST_SHOWN, STATES, STATES_HEIGHT, add_map, add_poses, add_readings, add_whiskers, arrow, in_map, map_lines, shown,
    stride,
};
use crate::Result;
use crate::flow::one_in;
use crate::flow::pose::{Localization, StampedPose};
use crate::flow::sensor_log::SensorLog;
use crate::flow::trajectory::pose_at;
use crate::plane::{Pose2, Vec2};
use crate::ros::{BagWriter, Kind, Stamp, TopicId, encode_cloud, encode_lines, encode_path, encode_pose, encode_text};
use crate::sets::StateBox;
use crate::world::Map;

/// The states that explain a log up to one of its rows.
#[derive(Clone, Debug, PartialEq)]
pub struct StampedStates {
    /// When (s).
    pub t: f64,
    /// The robot's states, map frame.
    pub states: Vec<Pose2>,
}

/// Collects states along a log, as often as they can be looked at.
#[derive(Clone, Debug)]
pub struct StatesWatch {
    every: usize,
    seen: Vec<StampedStates>,
}

/// Most times at which states are kept, and most states at each.
const MOST_TIMES: usize = 150;
const MOST_STATES: usize = 800;
/// How long a state is drawn (m).
const STATE_LENGTH: f64 = 6e-3;

impl StatesWatch {
    /// A watch for a log of so many rows.
    #[must_use]
    pub fn new(rows: usize) -> Self {
        Self { every: stride(rows, MOST_TIMES), seen: Vec::new() }
    }

    /// Takes the states at a row if it is one of those that are kept: an observer of `vibrissa::tasks::localize_watched`.
    pub fn look(&mut self, row: usize, t: f64, states: &dyn Fn() -> Vec<Pose2>) {
        if !row.is_multiple_of(self.every) {
            return;
        }
        let states = states();
        let every = stride(states.len(), MOST_STATES);
        let states: Vec<Pose2> = one_in(states, every).collect();
        // An empty set is kept once: it tells that nothing explains the log any more.
        let was_empty = self.seen.last().is_none_or(|last| last.states.is_empty());
        if !(states.is_empty() && was_empty) {
            self.seen.push(StampedStates { t, states });
        }
    }

    /// What was seen, in order of time.
    #[must_use]
    pub fn finish(self) -> Vec<StampedStates> {
        self.seen
    }
}

/// The recording (MCAP) of a localization on the log's timeline, which begins at 0 where [`clock_origin`] says so; [`super`] lists the topics.
///
/// Poses, states and shapes are thinned to what can be looked at, readings are all there. The same answer gives the same
/// bytes.
///
/// # Errors
///
/// More whiskers than a recording has topics.
pub fn localization_mcap(
    log: &SensorLog,
    map: &Map,
    answer: &Localization,
    states: &[StampedStates],
    truth: Option<&[StampedPose]>,
) -> Result<Vec<u8>> {
    if let Some(origin) = clock_origin(log) {
        let mut states = states.to_vec();
        states.iter_mut().for_each(|s| s.t -= origin);
        let mut truth = truth.map(<[StampedPose]>::to_vec);
        truth.iter_mut().for_each(|poses| shift_poses(poses, origin));
        let (log, answer) = (shifted_log(log, origin), shifted_answer(answer, origin));
        return localization_mcap(&log, map, &answer, &states, truth.as_deref());
    }
    let start = log.rows.first().map_or(0.0, |row| row.t);
    let end = log.rows.last().map_or(0.0, |row| row.t);
    let mut bag = BagWriter::default();
    add_map(&mut bag, map, start);
    let lines = bag.topic("/vibrissa/lines", Kind::Markers, false);
    let header = in_map(start);
    bag.push(lines, header.stamp, encode_lines(header, &[map_lines(map)]));
    add_states(&mut bag, answer, states, end);
    add_estimate(&mut bag, answer, end);
    let dots = bag.topic("/vibrissa/whisker", Kind::Cloud, false);
    add_shapes(&mut bag, [dots, lines], answer);
    if let Some(truth) = truth {
        let topic = bag.topic("/truth", Kind::Pose, false);
        add_poses(&mut bag, topic, truth);
    }
    add_readings(&mut bag, log);
    let events = bag.topic("/vibrissa/event", Kind::Text, false);
    for event in &answer.events {
        let text = format!("{}: {}", event.kind, event.detail);
        bag.push(events, Stamp::from_seconds(event.t), encode_text(&text));
    }
    bag.finish()
}

/// The states along the log, then those that the answer stands on.
fn add_states(bag: &mut BagWriter, answer: &Localization, states: &[StampedStates], end: f64) {
    let topic = bag.topic("/vibrissa/states", Kind::Cloud, false);
    let middle = |b: &StateBox| {
        let of = |i: crate::sets::Interval| 0.5 * (i.lo() + i.hi());
        Pose2::new(of(b.x), of(b.y), of(b.theta))
    };
    let every = stride(answer.states.len(), MOST_STATES);
    let last: Vec<Pose2> = one_in(&answer.states, every).filter(|b| !b.is_empty()).map(middle).collect();
    let before = states.iter().filter(|s| s.t < end).map(|s| (s.t, s.states.as_slice()));
    for (t, states) in before.chain([(end, last.as_slice())]) {
        let header = in_map(t);
        let dots = states.iter().flat_map(|state| arrow(state, STATE_LENGTH)).map(|p| (p, STATES_HEIGHT, STATES));
        bag.push(topic, header.stamp, encode_cloud(header, dots));
    }
}

/// The best hypothesis over time, with the covariance of its place.
fn add_estimate(bag: &mut BagWriter, answer: &Localization, end: f64) {
    let pose = bag.topic("/vibrissa/pose", Kind::PoseWithCovariance, false);
    let place = answer.hypotheses.first();
    for stamped in shown(&answer.trajectory) {
        let covariance = place.map_or([[0.0; 3]; 3], |place| {
            let at_end = place.covariance.unwrap_or_else(|| covariance_of(&place.extent));
            moved(&at_end, stamped.map_from_robot.position() - place.pose.position())
        });
        let header = in_map(stamped.t);
        bag.push(pose, header.stamp, encode_pose(header, stamped.map_from_robot, Some(&covariance)));
    }
    let robot = bag.topic("/vibrissa/robot", Kind::Pose, false);
    add_poses(bag, robot, &answer.trajectory);
    let path = bag.topic("/vibrissa/path", Kind::Path, true);
    let poses: Vec<(Stamp, Pose2)> =
        shown(&answer.trajectory).map(|p| (Stamp::from_seconds(p.t), p.map_from_robot)).collect();
    let header = in_map(end);
    bag.push(path, header.stamp, encode_path(header, &poses));
}

/// That of a state anywhere in a box.
fn covariance_of(extent: &StateBox) -> [[f64; 3]; 3] {
    let mut covariance = [[0.0; 3]; 3];
    for (k, width) in [extent.x.width(), extent.y.width(), extent.theta.width()].into_iter().enumerate() {
        covariance[k][k] = if width.is_finite() { width * width / 12.0 } else { 0.0 };
    }
    covariance
}

/// The covariance of the same robot further along its way: an error of the heading swings it around the place where the
/// covariance holds.
fn moved(covariance: &[[f64; 3]; 3], way: Vec2) -> [[f64; 3]; 3] {
    let jacobian = [[1.0, 0.0, -way.y], [0.0, 1.0, way.x], [0.0, 0.0, 1.0]];
    let times = |a: &[[f64; 3]; 3], b: &[[f64; 3]; 3]| -> [[f64; 3]; 3] {
        core::array::from_fn(|i| core::array::from_fn(|k| (0..3).map(|m| a[i][m] * b[m][k]).sum()))
    };
    let transposed: [[f64; 3]; 3] = core::array::from_fn(|i| core::array::from_fn(|k| jacobian[k][i]));
    times(&times(&jacobian, covariance), &transposed)
}

/// The whisker shapes, placed by the best hypothesis.
fn add_shapes(bag: &mut BagWriter, topics: [TopicId; 2], answer: &Localization) {
    let mut rest = answer.shapes.as_slice();
    let mut times = Vec::new();
    while let Some(first) = rest.first() {
        let (here, later) = rest.split_at(rest.iter().take_while(|shape| shape.t <= first.t).count().max(1));
        times.push(here);
        rest = later;
    }
    for here in times.iter().step_by(stride(times.len(), MOST_SHOWN)) {
        let Some(pose) = pose_at(&answer.trajectory, here[0].t) else { continue };
        let placed: Vec<Vec<Vec2>> =
            here.iter().map(|shape| shape.points.iter().map(|&p| pose.transform_point(p)).collect()).collect();
        add_whiskers(bag, topics, here[0].t, &placed);
    }
}

#[cfg(test)]
mod tests {
    use super::moved;
    use crate::plane::{Pose2, Vec2};

    #[test]
    fn a_covariance_moves_as_its_samples_do() {
        // Samples of (x, y, heading) with a known covariance: the corners of a parallelepiped.
        let axes = [[1e-3, 2e-4, 0.0], [0.0, 5e-4, 3e-4], [2e-4, 0.0, 1e-3]];
        let corners: Vec<[f64; 3]> = (0..8)
            .map(|bits| core::array::from_fn(|k| (0..3).map(|a| axes[a][k] * f64::from(2 * (bits >> a & 1) - 1)).sum()))
            .collect();
        let spread = |samples: &[[f64; 3]]| -> [[f64; 3]; 3] {
            core::array::from_fn(|i| core::array::from_fn(|k| samples.iter().map(|s| s[i] * s[k]).sum::<f64>() / 8.0))
        };
        let (place, way) = (Pose2::new(0.3, -0.2, 0.8), Vec2::new(-0.05, 0.12));
        let step = place.inverse_transform_point(place.position() + way);
        let there: Vec<[f64; 3]> = corners
            .iter()
            .map(|c| {
                let sample = Pose2::new(place.x + c[0], place.y + c[1], place.theta + c[2]);
                let off = sample.transform_point(step) - (place.position() + way);
                [off.x, off.y, c[2]]
            })
            .collect();
        let (found, want) = (moved(&spread(&corners), way), spread(&there));
        for (found, want) in found.iter().flatten().zip(want.iter().flatten()) {
            assert!((found - want).abs() < 2e-9, "{found} for {want}");
        }
    }
}
