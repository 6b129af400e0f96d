//! The window's rows: odometry, readings, and the path by the calibrated odometry \[censi2013simultaneous\].

use super::calibrated_path::{OdometryCalibration, calibrated};
use super::odometry_path::OdometryPath;
use super::sensor::Sensor;
use crate::plane::{Pose2, Vec2};

/// Rows that were kept, each with one reading for each whisker (dimensionless).
#[derive(Clone, Debug, Default)]
pub(super) struct LogWindow {
    mounts: Vec<Pose2>,
    /// The robot as its odometry says, and once that is corrected.
    raw: Vec<Pose2>,
    poses: Vec<Pose2>,
    /// The calibration parameters that it is corrected by, and the way when no row will follow.
    calibration: OdometryCalibration,
    is_corrected: bool,
    whole: Option<OdometryPath>,
    /// The bases of all whiskers, odometry frame.
    bases: Vec<Pose2>,
    readings: Vec<f64>,
    /// Sum of unit vectors: the heading of the odometry frame by each absolute heading.
    compass: Vec2,
}

impl LogWindow {
    pub(super) fn new(sensors: &[Sensor]) -> Self {
        Self { mounts: sensors.iter().map(|f| f.robot_from_whisker).collect(), ..Self::default() }
    }

    pub(super) fn push(&mut self, odom_from_robot: Pose2, readings: &[f64]) {
        let pose = match (self.raw.last(), self.poses.last()) {
            (Some(&raw), Some(&last)) if self.is_corrected => {
                last.compose(calibrated(raw.between(odom_from_robot), self.calibration))
            }
            _ => odom_from_robot,
        };
        self.raw.push(odom_from_robot);
        self.poses.push(pose);
        self.bases.extend(self.mounts.iter().map(|mount| pose.compose(*mount)));
        self.readings.extend_from_slice(readings);
    }

    /// The calibration parameters that the odometry is corrected by.
    pub(super) fn calibration(&self) -> OdometryCalibration {
        self.calibration
    }

    /// Corrects the odometry by these calibration parameters; the last row stays where it is.
    pub(super) fn correct(&mut self, calibration: OdometryCalibration) {
        let Some(&last) = self.poses.last() else { return };
        (self.calibration, self.is_corrected) = (calibration, true);
        let Some((&raw, before)) = self.raw.split_last() else { return };
        self.poses = integrated_backwards(before, (raw, last), calibration);
        self.poses.push(last);
        self.whole = self.whole.map(|_| OdometryPath::along(&self.poses));
        let mounts = &self.mounts;
        self.bases = self.poses.iter().flat_map(|pose| mounts.iter().map(|mount| pose.compose(*mount))).collect();
    }

    /// Where the robot was before the first row, by what its odometry said, as far as that has been corrected.
    pub(super) fn earlier(&self, raw: &[Pose2]) -> Vec<Pose2> {
        match (self.raw.first(), self.poses.first()) {
            (Some(&first), Some(&pose)) if self.is_corrected => {
                integrated_backwards(raw, (first, pose), self.calibration)
            }
            _ => raw.to_vec(),
        }
    }

    /// No row will follow: what the odometry's calibration parameters do is reported from the last row on, which is what is asked for.
    pub(super) fn end(&mut self) {
        self.whole = Some(OdometryPath::along(&self.poses));
    }

    /// The way when no row will follow.
    pub(super) fn whole(&self) -> Option<&OdometryPath> {
        self.whole.as_ref()
    }

    /// The robot's way from the first row to the last.
    pub(super) fn way(&self) -> OdometryPath {
        OdometryPath::along(&self.poses)
    }

    /// The odometry's own frame in that of the corrected one, at the last row.
    pub(super) fn corrected_from_raw(&self) -> Pose2 {
        match (self.raw.last(), self.poses.last()) {
            (Some(raw), Some(pose)) if self.is_corrected => pose.compose(raw.inverse()),
            _ => Pose2::IDENTITY,
        }
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

    pub(super) fn pose(&self, row: usize) -> Pose2 {
        self.poses[row]
    }

    /// The same before any correction.
    pub(super) fn raw(&self, row: usize) -> Pose2 {
        self.raw[row]
    }

    pub(super) fn readings(&self, row: usize) -> &[f64] {
        &self.readings[row * self.mounts.len()..(row + 1) * self.mounts.len()]
    }

    /// The base of a whisker, `odom_from_whisker`.
    pub(super) fn base(&self, row: usize, sensor: usize) -> Pose2 {
        self.bases[row * self.mounts.len() + sensor]
    }

    /// Forgets the rows before `row`.
    pub(super) fn forget(&mut self, row: usize) {
        self.raw.drain(..row);
        self.poses.drain(..row);
        self.bases.drain(..row * self.mounts.len());
        self.readings.drain(..row * self.mounts.len());
    }

    /// Forgets one row.
    pub(super) fn drop_row(&mut self, row: usize) {
        self.raw.remove(row);
        self.poses.remove(row);
        let these = row * self.mounts.len()..(row + 1) * self.mounts.len();
        self.bases.drain(these.clone());
        self.readings.drain(these);
    }
}

/// The path that ends before this pose, each given as the odometry says and once corrected by these calibration parameters.
fn integrated_backwards(
    before: &[Pose2],
    (mut raw, mut pose): (Pose2, Pose2),
    calibration: OdometryCalibration,
) -> Vec<Pose2> {
    let mut path = before.to_vec();
    for there in path.iter_mut().rev() {
        pose = pose.compose(calibrated(there.between(raw), calibration).inverse());
        (raw, *there) = (*there, pose);
    }
    path
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

    use super::super::sensor::tests::sensor;
    use super::*;

    #[test]
    fn rows_before_the_first_are_corrected_like_those_after() {
        let poses: Vec<Pose2> =
            (0..40).map(|k| 0.004 * f64::from(k)).map(|s| Pose2::new(s, 0.3 * s.sin(), 2.0 * s)).collect();
        let mut history = LogWindow::new(&[sensor(0.05, 1e-3)]);
        poses.iter().for_each(|&pose| history.push(pose, &[0.0]));
        assert_eq!(history.earlier(&poses[..3]), poses[..3]);
        history.correct([0.01, -0.004, 0.007]);
        let whole: Vec<Pose2> = (0..40).map(|row| history.pose(row)).collect();
        assert!(whole[0].position().distance(poses[0].position()) > 1e-4 && whole[39] == poses[39]);
        history.forget(25);
        let earlier = history.earlier(&poses[..25]);
        for (ours, before) in earlier.iter().zip(&whole) {
            assert!(ours.position().distance(before.position()) < 1e-12 && (ours.theta - before.theta).abs() < 1e-12);
        }
        // Every second of them lies where it lay: a correction turns and stretches, and bends but little.
        let some: Vec<Pose2> = poses[..25].iter().step_by(2).copied().collect();
        for (ours, before) in history.earlier(&some).iter().zip(whole.iter().step_by(2)) {
            assert!(ours.position().distance(before.position()) < 2e-5, "{ours:?}, not {before:?}");
        }
    }

    #[test]
    fn a_corrected_path_is_the_one_that_was_gone() {
        let sensors = [sensor(0.05, 0.0)];
        let gone: Vec<Pose2> =
            (0..50).map(|k| f64::from(k) * 0.03).map(|s| Pose2::new(s.sin(), s, 2.0 * s.cos())).collect();
        let calibration = [0.01, -0.004, 0.008];
        // What odometry that is wrong by these calibration parameters says of it.
        let wrong = |step: Pose2| {
            let place = step.position().rotated(-calibration[1]) * (1.0 / (1.0 + calibration[0]));
            Pose2 { x: place.x, y: place.y, theta: step.theta / (1.0 + calibration[2]) }
        };
        let mut history = LogWindow::new(&sensors);
        let mut raw = gone[0];
        for (row, pose) in gone.iter().enumerate() {
            if row > 0 {
                raw = raw.compose(wrong(gone[row - 1].between(*pose)));
            }
            if row == 30 {
                assert_eq!(history.pose(29), history.raw[29]);
                history.correct(calibration);
            }
            history.push(raw, &[0.0]);
        }
        // The last row then stayed where it was, and all others stand to it as they did.
        let from = history.pose(29).compose(gone[29].inverse());
        for (row, pose) in gone.iter().enumerate() {
            let off = history.pose(row).between(from.compose(*pose));
            assert!(off.position().norm() < 1e-12 && off.theta.abs() < 1e-12, "{row}: {off:?}");
            assert!(history.base(row, 0).between(history.pose(row)).position().norm() < 1e-12);
        }
        let now = history.corrected_from_raw().compose(raw);
        assert!(now.between(history.pose(49)).position().norm() < 1e-12);
        history.forget(20);
        history.correct([0.0; 3]);
        assert!(history.pose(29).between(now).position().norm() < 1e-12);
        let (a, b) = (history.raw[0].between(history.raw[29]), history.pose(0).between(history.pose(29)));
        assert!(a.between(b).position().norm() < 1e-12);
    }
}
