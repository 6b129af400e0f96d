//! The path by the calibrated odometry \[censi2013simultaneous\], and how it depends on the calibration.

use super::log_window::LogWindow;
use crate::plane::{Pose2, Vec2};

/// By which share of its increments the odometry is too short, goes aside (rad) and turns too little: what it has to be corrected by.
pub(super) type OdometryCalibration = [f64; 3];

/// The robot at one row (odometry frame) and the derivatives of its pose by the calibration.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PathPoint {
    pub(super) pose: Pose2,
    pub(super) by_calibration: [Sway; 3],
}

/// A small motion: of the place (m) and of the heading (rad).
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sway {
    pub(super) place: Vec2,
    pub(super) turn: f64,
}

/// The path at these rows, in order; the robot at the row `anchor` stays where the odometry says.
pub(super) fn corrected_path(
    window: &LogWindow,
    rows: &[usize],
    anchor: usize,
    calibration: OdometryCalibration,
    out: &mut Vec<PathPoint>,
) {
    out.clear();
    let Some(&first) = rows.first() else { return };
    let mut at = first.min(anchor);
    let mut walk = Walk::new(window.pose(at), calibration);
    // Each increment of the odometry has its error, also between the rows that are asked for.
    let mut go_to = |walk: &mut Walk, row: usize| {
        for between in at + 1..=row {
            walk.go_to(window.pose(between));
        }
        at = at.max(row);
    };
    let mut anchored = None;
    for &row in rows {
        if anchored.is_none() && anchor <= row {
            go_to(&mut walk, anchor);
            anchored = Some(walk.here);
        }
        go_to(&mut walk, row);
        out.push(walk.here);
    }
    let there = anchored.unwrap_or_else(|| {
        go_to(&mut walk, anchor);
        walk.here
    });
    let motion = window.pose(anchor).compose(there.pose.inverse());
    for point in out {
        let arm = (point.pose.position() - there.pose.position()).perp();
        for (sway, fixed) in point.by_calibration.iter_mut().zip(there.by_calibration) {
            let place = sway.place - fixed.place - arm * fixed.turn;
            *sway = Sway { place: place.rotated(motion.theta), turn: sway.turn - fixed.turn };
        }
        point.pose = motion.compose(point.pose);
    }
}

/// One step of the odometry, corrected by these calibration parameters: so much longer, aside (rad) and turned so much further.
pub(crate) fn calibrated(step: Pose2, [long, aside, turn]: OdometryCalibration) -> Pose2 {
    let place = (step.position() * (1.0 + long)).rotated(aside);
    Pose2 { x: place.x, y: place.y, theta: (1.0 + turn) * step.theta }
}

/// A walk along the path.
struct Walk {
    calibration: OdometryCalibration,
    raw: Pose2,
    here: PathPoint,
}

impl Walk {
    fn new(start: Pose2, calibration: OdometryCalibration) -> Self {
        Self { calibration, raw: start, here: PathPoint { pose: start, ..PathPoint::default() } }
    }

    fn go_to(&mut self, raw: Pose2) {
        let step = calibrated(self.raw.between(raw), self.calibration);
        let PathPoint { pose, mut by_calibration } = self.here;
        let next = pose.compose(step);
        let way = next.position() - pose.position();
        // What has been turned too far so far swings the step around.
        by_calibration.iter_mut().for_each(|sway| sway.place += way.perp() * sway.turn);
        by_calibration[0].place += way;
        by_calibration[1].place += way.perp();
        by_calibration[2].turn += step.theta;
        self.raw = raw;
        self.here = PathPoint { pose: next, by_calibration };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn window() -> LogWindow {
        let mut window = LogWindow::new(0);
        for k in 0..60 {
            let s = f64::from(k) * 0.004;
            window.push(s, Pose2::new(s, 0.3 * (4.0 * s).sin(), 2.0 * (3.0 * s).sin()), &[]);
        }
        window
    }

    #[test]
    fn the_anchor_stays_and_derivatives_are_those_of_differences() {
        let window = window();
        let rows: Vec<usize> = (2..58).step_by(3).collect();
        for anchor in [0, 2, 20, 21, 57, 59] {
            let at = |calibration| {
                let mut path = Vec::new();
                corrected_path(&window, &rows, anchor, calibration, &mut path);
                path
            };
            let middle = [0.01, -0.02, 0.03];
            let here = at(middle);
            for way in 0..3 {
                let (mut more, mut less) = (middle, middle);
                (more[way], less[way]) = (middle[way] + 1e-5, middle[way] - 1e-5);
                for ((point, a), b) in here.iter().zip(at(more)).zip(at(less)) {
                    let by = (a.pose.position() - b.pose.position()) * (1.0 / 2e-5);
                    let turn = (a.pose.theta - b.pose.theta) / 2e-5;
                    let sway = point.by_calibration[way];
                    assert!((by - sway.place).norm() < 0.04 * by.norm() + 1e-6, "{anchor} {way}: {by:?} {sway:?}");
                    assert!((turn - sway.turn).abs() < 0.04 * turn.abs() + 1e-6);
                }
            }
            if let Some(k) = rows.iter().position(|&row| row == anchor) {
                assert!(here[k].pose.position().distance(window.pose(anchor).position()) < 1e-12);
            }
        }
    }

    #[test]
    fn the_path_does_not_depend_on_the_rows_that_are_asked_for() {
        let window = window();
        let all: Vec<usize> = (0..60).collect();
        for calibration in [[0.01, -0.02, 0.03], [-0.2, 0.1, -0.3]] {
            for anchor in [0, 23, 59] {
                let at = |rows: &[usize]| {
                    let mut path = Vec::new();
                    corrected_path(&window, rows, anchor, calibration, &mut path);
                    path
                };
                let whole = at(&all);
                for rows in [vec![0], vec![59], vec![3, 47], vec![0, 30, 58]] {
                    for (point, &row) in at(&rows).iter().zip(&rows) {
                        assert!(point.pose.position().distance(whole[row].pose.position()) < 1e-12, "{anchor} {row}");
                        assert!((point.pose.theta - whole[row].pose.theta).abs() < 1e-12);
                    }
                }
            }
        }
    }

    #[test]
    fn a_corrected_step_is_longer_aside_and_turned_further() {
        let step = calibrated(Pose2::new(0.02, 0.0, 0.1), [0.01, 0.02, -0.03]);
        assert!((step.position().norm() - 0.0202).abs() < 1e-12 && (step.position().angle() - 0.02).abs() < 1e-12);
        assert!((step.theta - 0.097).abs() < 1e-12);
    }
}
