//! Where the robot can have been: within the region of the first pose, in free space, and where absolute headings point.

use super::log_window::LogWindow;
use super::scene::Scene;
use crate::plane::{Pose2, Vec2, wrap_angle};

/// Rows at which a mode's whisker bases and origin are asked, at most.
const ASKED: usize = 12;

/// What frames of the odometry are allowed.
pub(super) struct Admission<'a> {
    scene: &'a Scene<'a>,
    window: &'a LogWindow,
    /// How far the first pose may be beside the region for it (m), and turned (rad).
    slack: [f64; 2],
    /// The rows that are asked, the last first, each with how far the robot may be off the odometry's way there (m).
    asked: Vec<(usize, f64)>,
}

/// Whether the odometry frame may be there.
pub(super) type Admits<'a> = dyn Fn(Pose2) -> bool + Sync + 'a;

impl<'a> Admission<'a> {
    /// Of modes that have been fitted to all rows.
    pub(super) fn new(scene: &'a Scene<'a>, window: &'a LogWindow) -> Self {
        Self::with_turn(scene, window, 0.0)
    }

    /// Of cells of the search, and of modes that begin as one.
    pub(super) fn of_cells(scene: &'a Scene<'a>, window: &'a LogWindow) -> Self {
        Self::with_turn(scene, window, scene.options.seed_turn)
    }

    fn with_turn(scene: &'a Scene<'a>, window: &'a LogWindow, turn: f64) -> Self {
        let (rows, odometry) = (window.len(), &scene.robot.odometry);
        let every = rows.div_ceil(ASKED).max(1);
        let [mut way, mut turned] = [0.0; 2];
        let mut asked = Vec::new();
        for row in 0..rows {
            if row > 0 {
                let step = window.pose(row - 1).between(window.pose(row));
                way += step.position().norm();
                turned += step.theta.abs();
            }
            if (rows - 1 - row).is_multiple_of(every) {
                let relative = odometry.translation_relative + odometry.rotation_relative * turned;
                asked.push((row, scene.options.seed_spacing + (relative + scene.robot.map_scale) * way));
            }
        }
        asked.reverse();
        Self { scene, window, slack: scene.prior_slack(window, turn), asked }
    }

    /// Whether the first pose is in the region where it is known to be, and points where headings say, give or take the slack.
    pub(super) fn satisfies_prior(&self, frame: Pose2) -> bool {
        let (options, [place, turn]) = (&self.scene.options, self.slack);
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
        self.stands_free(frame, row, self.scene.options.seed_spacing)
    }

    fn stands_free(&self, frame: Pose2, row: usize, slack: f64) -> bool {
        self.scene.sensors.iter().all(|f| f.robot_from_whisker.position().norm_squared() == 0.0)
            || self.stands(frame.transform_point(self.window.pose(row).position()), slack)
    }

    fn stands(&self, place: Vec2, slack: f64) -> bool {
        self.scene.map.is_free(place) || self.scene.map.nearest_within(place, slack).is_some()
    }

    /// Whether the robot may have gone the window's way.
    pub(super) fn is_allowed(&self, frame: Pose2) -> bool {
        let bases_stand = |row: usize, slack: f64| {
            let robot = frame.compose(self.window.pose(row));
            self.scene
                .sensors
                .iter()
                .all(|s| self.stands(robot.transform_point(s.robot_from_whisker.position()), slack))
        };
        self.satisfies_prior(frame)
            && self.asked.iter().all(|&(row, slack)| self.stands_free(frame, row, slack) && bases_stand(row, slack))
    }
}
