//! What an inertial measurement unit in a recording tells: headings of the robot, and how it turns between two rows.

use super::ImuTopics;
use crate::config::limits::ODOMETRY_GAP;
use crate::flow::sensor_log::LogRow;
use crate::plane::{Pose2, wrap_angle};
use crate::ros::{Header, ImuReading, Stamp};
use crate::text::{counted, listed};
use crate::{Error, Result};
use std::collections::BTreeMap;

/// The messages of one topic.
#[derive(Clone, Debug, Default)]
pub(super) struct ImuTrack {
    headings: Vec<(f64, f64)>,
    /// Times (s) and angular velocities (rad/s); then turns since the first of them (rad).
    rates: Vec<(f64, f64)>,
    turns: Vec<f64>,
}

impl ImuTrack {
    pub(super) fn push(&mut self, header: Header, logged: u64, reading: ImuReading) {
        let unstamped = header.stamp == Stamp::default() && logged > 0;
        let t = if unstamped { logged as f64 * 1e-9 } else { header.stamp.seconds() };
        let kept = |value: Option<f64>| value.filter(|value| value.is_finite()).map(|value| (t, value));
        self.headings.extend(kept(reading.heading));
        self.rates.extend(kept(reading.yaw_rate));
    }

    fn sort(&mut self) {
        for column in [&mut self.headings, &mut self.rates] {
            column.sort_by(|a, b| a.0.total_cmp(&b.0));
            column.dedup_by(|later, earlier| later.0 <= earlier.0);
        }
        let mut turn = 0.0;
        self.turns = vec![turn];
        for pair in self.rates.windows(2) {
            turn += 0.5 * (pair[0].1 + pair[1].1) * (pair[1].0 - pair[0].0);
            self.turns.push(turn);
        }
    }

    /// The heading at a time (rad); none outside the messages and in gaps of them.
    fn heading(&self, t: f64) -> Option<f64> {
        let (before, after) = neighbours(&self.headings, t)?;
        let ((t0, a), (t1, b)) = (self.headings[before], self.headings[after]);
        let share = if t1 > t0 { (t - t0) / (t1 - t0) } else { 0.0 };
        Some(wrap_angle(a + share * wrap_angle(b - a)))
    }

    /// How far the robot has turned by then (rad); none outside the messages and in gaps of them.
    fn turn(&self, t: f64) -> Option<f64> {
        let (before, after) = neighbours(&self.rates, t)?;
        let ((t0, a), (t1, b)) = (self.rates[before], self.rates[after]);
        let passed = t - t0;
        let slope = if t1 > t0 { (b - a) / (t1 - t0) } else { 0.0 };
        Some(self.turns[before] + passed * (a + 0.5 * slope * passed))
    }
}

/// The indices of the neighbours of a time; none outside the track and in gaps of it.
fn neighbours(track: &[(f64, f64)], t: f64) -> Option<(usize, usize)> {
    let after = track.partition_point(|row| row.0 < t);
    let next = track.get(after)?;
    if next.0 <= t {
        return Some((after, after));
    }
    let before = after.checked_sub(1)?;
    (next.0 - track[before].0 <= ODOMETRY_GAP).then_some((before, after))
}

/// Puts what the named topics tell into the rows; warnings are for people.
pub(super) fn apply(
    rows: &mut [LogRow],
    tracks: &mut BTreeMap<String, ImuTrack>,
    topics: &ImuTopics,
    warnings: &mut Vec<String>,
) -> Result<()> {
    tracks.values_mut().for_each(ImuTrack::sort);
    let names: Vec<String> = tracks.keys().cloned().collect();
    let named = |topic: &Option<String>, what: &str, measured: &dyn Fn(&ImuTrack) -> bool| {
        let Some(topic) = topic else { return Ok(None) };
        let track = tracks.get(topic).filter(|track| measured(track));
        track.map(Some).ok_or_else(|| {
            Error::data(format!("the recording has no {what} on the topic {topic}"))
                .value(if names.is_empty() { "no topic of sensor_msgs/msg/Imu".to_owned() } else { listed(&names) })
                .allowed("a topic of sensor_msgs/msg/Imu that measures it")
        })
    };
    if let Some(track) = named(&topics.headings, "headings", &|track| !track.headings.is_empty())? {
        rows.iter_mut().for_each(|row| row.heading = track.heading(row.t));
        let without = rows.iter().filter(|row| row.heading.is_none()).count();
        if without > 0 {
            warnings.push(format!(
                "{} without a heading: no message of the unit at their time",
                counted(without, "row", "rows")
            ));
        }
    }
    if let Some(track) = named(&topics.yaw_rates, "angular velocities", &|track| !track.rates.is_empty())? {
        let by_odometry = turned(rows, track);
        if by_odometry > 0 {
            warnings.push(format!(
                "{} by odometry: no message of the unit at their time",
                counted(by_odometry, "row turns", "rows turn")
            ));
        }
    }
    if topics.is_empty() && !names.is_empty() {
        warnings.push(format!(
            "not used: {}; --yaw-rates TOPIC takes how it turns, --headings TOPIC its headings, if they are the map's",
            listed(&names)
        ));
    }
    Ok(())
}

/// The same way with turns by the unit; how many rows have none and turn by odometry.
fn turned(rows: &mut [LogRow], track: &ImuTrack) -> usize {
    let Some(first) = rows.first() else { return 0 };
    let (mut before, mut told) = (first.odom_from_robot, track.turn(first.t));
    let (mut place, mut by_odometry) = (before, 0);
    for row in rows.iter_mut().skip(1) {
        let mut step = before.between(row.odom_from_robot).log();
        before = row.odom_from_robot;
        let now = track.turn(row.t);
        match told.zip(now) {
            Some((then, now)) => step.theta = now - then,
            None => by_odometry += 1,
        }
        told = now;
        place = place.compose(Pose2::exp(step));
        row.odom_from_robot = place;
    }
    by_odometry
}
