//! Where the robot can have been: within the region of the first pose, in free space, and where absolute headings point.

use super::log_window::LogWindow;
use super::smoother::Scene;
use crate::plane::{Pose2, wrap_angle};

/// Rows at which a mode's whisker bases and origin are asked, at most.
const ASKED: usize = 12;

/// What frames of the odometry are allowed.
pub(super) struct Admission<'a> {
    scene: &'a Scene<'a>,
    window: &'a LogWindow,
}

impl<'a> Admission<'a> {
    pub(super) fn new(scene: &'a Scene<'a>, window: &'a LogWindow) -> Self {
        Self { scene, window }
    }

    /// Whether the first pose is in the region where it is known to be, and points where headings say, give or take a cell and what the
    /// odometry may have drifted since.
    pub(super) fn satisfies_prior(&self, frame: Pose2) -> bool {
        let options = &self.scene.options;
        let drift = self.scene.drift(self.window);
        let (place, turn) = (options.seed_spacing + drift[0], options.seed_turn + drift[1]);
        let within = |[[a, b], [c, d], [e, f]]: [[f64; 2]; 3]| {
            let off = wrap_angle(frame.theta - 0.5 * (e + f)).abs();
            (a - place..=b + place).contains(&frame.x)
                && (c - place..=d + place).contains(&frame.y)
                && off <= 0.5 * (f - e) + turn
        };
        let points = |heading: f64| wrap_angle(frame.theta - heading).abs() <= 1.5 * options.heading_error + turn;
        options.prior.is_none_or(within) && self.window.heading().is_none_or(points)
    }

    /// Whether the robot's origin stands in free space at a row, give or take a step of the search.
    pub(super) fn origin_is_free(&self, frame: Pose2, row: usize) -> bool {
        if self.scene.sensors.iter().all(|f| f.robot_from_whisker.position().norm_squared() == 0.0) {
            return true;
        }
        self.stands(frame.transform_point(self.window.pose(row).position()))
    }

    fn stands(&self, place: crate::plane::Vec2) -> bool {
        self.scene.map.is_free(place) || self.scene.map.nearest_within(place, self.scene.options.seed_spacing).is_some()
    }

    /// Whether the robot may have gone the window's way.
    pub(super) fn is_allowed(&self, frame: Pose2) -> bool {
        let rows = self.window.len();
        let bases_stand = |row: usize| {
            let robot = frame.compose(self.window.pose(row));
            self.scene.sensors.iter().all(|s| self.stands(robot.transform_point(s.robot_from_whisker.position())))
        };
        self.satisfies_prior(frame)
            && (0..rows)
                .rev()
                .step_by(rows.div_ceil(ASKED).max(1))
                .all(|row| self.origin_is_free(frame, row) && bases_stand(row))
    }
}
