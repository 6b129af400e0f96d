//! The rows that are kept to be fitted again: times, odometry and readings.

use super::odometry_drift::{DriftSums, OnWalk};
use crate::plane::{Pose2, Vec2};

/// Rows with one reading for each sensor (dimensionless).
#[derive(Clone, Debug, Default)]
pub(super) struct LogWindow {
    sensors: usize,
    times: Vec<f64>,
    /// The robot in the odometry frame.
    poses: Vec<Pose2>,
    /// The motion to each row from the one before, in the robot's frame there.
    increments: Vec<Pose2>,
    readings: Vec<f64>,
    /// Whether each is that of a whisker in contact.
    contacts: Vec<bool>,
    /// Whether each is left out.
    set_aside: Vec<bool>,
    /// When the log began (s).
    began: Option<f64>,
    /// How far the robot had gone (m) and turned (rad) when the first row came.
    gone: [f64; 2],
    /// Bounds on the errors of increments, relative to them: of their places and of their turns; and sums over all up to each row.
    drift: [f64; 2],
    drifts: Vec<DriftSums>,
    /// Sum of unit vectors: the heading of the odometry frame by each absolute heading.
    compass: Vec2,
}

impl LogWindow {
    pub(super) fn new(sensors: usize) -> Self {
        Self { sensors, ..Self::default() }
    }

    /// The same where increments have errors of their own within these bounds, relative to them: of their places and of their turns.
    pub(super) fn with_drift(self, drift: [f64; 2]) -> Self {
        Self { drift, ..self }
    }

    /// Whether increments have errors of their own.
    pub(super) fn drifts(&self) -> bool {
        self.drift.iter().any(|&bound| bound > 0.0)
    }

    /// Where a row is on the odometry's random walk, where another one is held.
    pub(super) fn on_walk(&self, row: usize, held: usize) -> OnWalk {
        OnWalk::new(self.poses[row].position(), self.drifts[row], self.drifts[held], row >= held)
    }

    /// The sums up to a row, from those before.
    fn drift_at(&self, row: usize) -> DriftSums {
        let before = row.checked_sub(1).map_or_else(DriftSums::default, |before| self.drifts[before]);
        before.with(self.increments[row], self.poses[row], self.drift)
    }

    pub(super) fn push(&mut self, t: f64, odom_from_robot: Pose2, readings: &[f64]) {
        self.began.get_or_insert(t);
        self.times.push(t);
        self.increments.push(self.poses.last().map_or_else(Pose2::default, |last| last.between(odom_from_robot)));
        self.poses.push(odom_from_robot);
        self.drifts.push(self.drift_at(self.poses.len() - 1));
        self.readings.extend_from_slice(readings);
        self.contacts.resize(self.readings.len(), false);
        self.set_aside.resize(self.readings.len(), false);
    }

    /// Leaves a reading out.
    pub(super) fn set_aside(&mut self, row: usize, sensor: usize) {
        self.set_aside[row * self.sensors + sensor] = true;
    }

    /// Takes it in again.
    pub(super) fn take(&mut self, row: usize, sensor: usize) {
        self.set_aside[row * self.sensors + sensor] = false;
    }

    /// Leaves none out.
    pub(super) fn take_all(&mut self) {
        self.set_aside.fill(false);
    }

    /// Whether a reading is left out.
    pub(super) fn is_aside(&self, row: usize, sensor: usize) -> bool {
        self.set_aside[row * self.sensors + sensor]
    }

    /// Says of each sensor whether its whisker is in contact at a row.
    pub(super) fn tell_contacts(&mut self, row: usize, contacts: impl Iterator<Item = bool>) {
        self.contacts[row * self.sensors..]
            .iter_mut()
            .zip(contacts)
            .take(self.sensors)
            .for_each(|(to, told)| *to = told);
    }

    /// For each sensor whether its whisker is in contact.
    pub(super) fn contacts(&self, row: usize) -> &[bool] {
        &self.contacts[row * self.sensors..(row + 1) * self.sensors]
    }

    /// Takes these off all readings, one for each sensor.
    pub(super) fn subtract(&mut self, offsets: &[f64]) {
        self.readings.iter_mut().zip(offsets.iter().cycle()).for_each(|(reading, offset)| *reading -= offset);
    }

    /// Takes in the absolute heading of the last row (map frame).
    pub(super) fn point(&mut self, map_heading: f64) {
        if let Some(last) = self.poses.last() {
            self.compass += Vec2::from_angle(map_heading - last.theta);
        }
    }

    /// The heading of the odometry frame in the map by all absolute headings so far.
    pub(super) fn heading(&self) -> Option<f64> {
        (self.compass.norm_squared() > 0.0).then(|| self.compass.angle())
    }

    pub(super) fn len(&self) -> usize {
        self.poses.len()
    }

    pub(super) fn time(&self, row: usize) -> f64 {
        self.times[row]
    }

    /// The time of a row since the log began (s).
    pub(super) fn since_start(&self, row: usize) -> f64 {
        self.times[row] - self.began.unwrap_or_default()
    }

    pub(super) fn pose(&self, row: usize) -> Pose2 {
        self.poses[row]
    }

    /// The motion of the robot to a row from the one before.
    pub(super) fn increment(&self, row: usize) -> Pose2 {
        self.increments[row]
    }

    pub(super) fn last_pose(&self) -> Pose2 {
        self.poses.last().copied().unwrap_or_default()
    }

    pub(super) fn readings(&self, row: usize) -> &[f64] {
        &self.readings[row * self.sensors..(row + 1) * self.sensors]
    }

    /// How far the robot goes from one row to another, or what turns by as much on an arm of this length (m).
    pub(super) fn way(&self, from: usize, to: usize, lever: f64) -> f64 {
        let step = |step: &Pose2| step.position().norm().max(step.theta.abs() * lever);
        self.increments[from..=to].iter().skip(1).map(step).sum()
    }

    /// The robot's velocity at a row, its own frame (m/s, rad/s), from the rows around.
    pub(super) fn velocity(&self, row: usize) -> Pose2 {
        let (before, after) = (row.saturating_sub(1), (row + 1).min(self.len() - 1));
        let step = self.poses[before].between(self.poses[after]);
        let dt = self.times[after] - self.times[before];
        let per = if dt > 0.0 { 1.0 / dt } else { 0.0 };
        Pose2 { x: step.x * per, y: step.y * per, theta: step.theta * per }
    }

    /// How far the robot had gone (m) and turned (rad) before the first row that is kept.
    pub(super) fn gone(&self) -> [f64; 2] {
        self.gone
    }

    /// Forgets the rows before `row`.
    pub(super) fn forget(&mut self, row: usize) {
        for step in self.increments[..self.poses.len().min(row + 1)].iter().skip(1) {
            self.gone[0] += step.position().norm();
            self.gone[1] += step.theta.abs();
        }
        self.times.drain(..row);
        self.poses.drain(..row);
        self.drifts.drain(..row);
        self.increments.drain(..row);
        self.readings.drain(..row * self.sensors);
        self.contacts.drain(..row * self.sensors);
        self.set_aside.drain(..row * self.sensors);
    }

    /// Forgets one row.
    pub(super) fn drop_row(&mut self, row: usize) {
        self.times.remove(row);
        self.poses.remove(row);
        self.drifts.truncate(row);
        self.increments.remove(row);
        if let (Some(before), true) = (row.checked_sub(1), row < self.poses.len()) {
            self.increments[row] = self.poses[before].between(self.poses[row]);
        }
        (row..self.poses.len()).for_each(|row| self.drifts.push(self.drift_at(row)));
        self.readings.drain(row * self.sensors..(row + 1) * self.sensors);
        self.contacts.drain(row * self.sensors..(row + 1) * self.sensors);
        self.set_aside.drain(row * self.sensors..(row + 1) * self.sensors);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_over_increments_are_those_of_the_rows_that_are_kept() {
        let pose = |k: usize| Pose2::new(0.01 * k as f64, 0.02 * (0.7 * k as f64).sin(), 0.5 * (0.4 * k as f64).cos());
        let mut window = LogWindow::new(0).with_drift([0.03, 0.02]);
        (0..12).for_each(|k| window.push(k as f64, pose(k), &[]));
        [10, 4].into_iter().for_each(|row| window.drop_row(row));
        let mut same = LogWindow::new(0).with_drift([0.03, 0.02]);
        (0..12).filter(|k| ![10, 4].contains(k)).for_each(|k| same.push(k as f64, pose(k), &[]));
        let near = |a: &LogWindow, b: &LogWindow, ahead: usize| {
            for (row, held) in [(0, 5), (5, 0), (3, 3), (2, 6)] {
                let told = a.on_walk(row, held).covariance();
                let wanted = b.on_walk(row + ahead, held + ahead).covariance();
                (0..3).for_each(|i| (0..3).for_each(|j| assert!((told[i][j] - wanted[i][j]).abs() < 1e-15)));
            }
        };
        near(&window, &same, 0);
        window.forget(3);
        window.push(12.0, pose(12), &[]);
        same.push(12.0, pose(12), &[]);
        near(&window, &same, 3);
        assert!(window.drifts() && !LogWindow::new(0).drifts());
    }
}
