//! The path by the calibrated odometry \[censi2013simultaneous\], in the map as it is drawn, and how it depends on the calibration.

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

impl PathPoint {
    /// The point where the map is drawn in so many metres for each metre of the world, about the place that stays.
    pub(super) fn drawn(self, per: f64, about: Vec2) -> Self {
        let place = about + (self.pose.position() - about) * per;
        let sway = |Sway { place, turn }: Sway| Sway { place: place * per, turn };
        Self { pose: Pose2::new(place.x, place.y, self.pose.theta), by_calibration: self.by_calibration.map(sway) }
    }
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
            walk.take(window.increment(between));
        }
        at = at.max(row);
    };
    let mut anchored = None;
    for &row in rows {
        if anchored.is_none() && anchor <= row {
            go_to(&mut walk, anchor);
            anchored = Some(walk.point());
        }
        go_to(&mut walk, row);
        out.push(walk.point());
    }
    let there = anchored.unwrap_or_else(|| {
        go_to(&mut walk, anchor);
        walk.point()
    });
    let motion = window.pose(anchor).compose(there.pose.inverse());
    let Vec2 { x: cos, y: sin } = Vec2::from_angle(motion.theta);
    let turned = |v: Vec2| Vec2::new(cos * v.x - sin * v.y, sin * v.x + cos * v.y);
    for point in out {
        let arm = (point.pose.position() - there.pose.position()).perp();
        for (sway, fixed) in point.by_calibration.iter_mut().zip(there.by_calibration) {
            let place = sway.place - fixed.place - arm * fixed.turn;
            *sway = Sway { place: turned(place), turn: sway.turn - fixed.turn };
        }
        let place = motion.position() + turned(point.pose.position());
        point.pose = Pose2::new(place.x, place.y, motion.theta + point.pose.theta);
    }
}

/// One step of the odometry, corrected by these calibration parameters: so much longer, aside (rad) and turned so much further.
pub(crate) fn calibrated(step: Pose2, [long, aside, turn]: OdometryCalibration) -> Pose2 {
    let place = (step.position() * (1.0 + long)).rotated(aside);
    Pose2 { x: place.x, y: place.y, theta: (1.0 + turn) * step.theta }
}

/// A walk along the path.
struct Walk {
    start: Vec2,
    /// What a step's way is multiplied by, as a complex number, and its turn.
    way: Vec2,
    turn: f64,
    here: Pose2,
    /// How the place and the heading depend on the turning parameter.
    by_turn: Sway,
}

impl Walk {
    fn new(start: Pose2, [long, aside, turn]: OdometryCalibration) -> Self {
        let way = Vec2::from_angle(aside) * (1.0 + long);
        Self { start: start.position(), way, turn: 1.0 + turn, here: start, by_turn: Sway::default() }
    }

    /// Takes one increment of the odometry.
    fn take(&mut self, increment: Pose2) {
        let turn = self.turn * increment.theta;
        let Vec2 { x: cos, y: sin } = Vec2::from_angle(self.here.theta);
        let rotation = Vec2::new(self.way.x * cos - self.way.y * sin, self.way.x * sin + self.way.y * cos);
        let way = Vec2::new(
            rotation.x * increment.x - rotation.y * increment.y,
            rotation.y * increment.x + rotation.x * increment.y,
        );
        // What has been turned too far so far swings the step around.
        self.by_turn.place += way.perp() * self.by_turn.turn;
        self.by_turn.turn += turn;
        let place = self.here.position() + way;
        self.here = Pose2::new(place.x, place.y, self.here.theta + turn);
    }

    fn point(&self) -> PathPoint {
        let way = self.here.position() - self.start;
        let longer = Sway { place: way, turn: 0.0 };
        PathPoint { pose: self.here, by_calibration: [longer, Sway { place: way.perp(), turn: 0.0 }, self.by_turn] }
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
