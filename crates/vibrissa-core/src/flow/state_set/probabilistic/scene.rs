//! What all parts of the smoother share: the map, the robot with the errors that it may have, and what is sensed.

use super::log_window::LogWindow;
use super::map_symmetry::MapSymmetries;
use super::measurement::MeasurementModel;
use super::sensor::Sensor;
use super::unknowns::{Sense, Unknowns};
use crate::beam::TipTable;
use crate::config::{ProbabilisticOptions, WHISKERS_OF_WHOLE_WINDOW};
use crate::contact::Boundaries;
use crate::contact::follow::Mechanics;
use crate::coroutine::Pace;
use crate::world::{Map, Robot};

/// With more modes than this rows are kept as long as the window is: what tells modes apart is not summed up.
const FEW_MODES: usize = 8;

/// What all parts of the smoother share.
pub(super) struct Scene<'a> {
    pub(super) map: &'a Map,
    /// The robot as it is declared, and with bounds of what it does not bound.
    pub(super) declared: &'a Robot,
    pub(super) robot: Robot,
    pub(super) options: ProbabilisticOptions,
    pub(super) ground: Boundaries,
    pub(super) symmetries: MapSymmetries,
    pub(super) table: TipTable,
    pub(super) sensors: Vec<Sensor>,
    pub(super) senses: Vec<Sense>,
    pub(super) whiskers: Vec<usize>,
    pub(super) unknowns: Unknowns,
    /// What is taken off the readings of each sensor, once it is known.
    pub(super) tare: Option<Vec<f64>>,
    /// When work pauses.
    pub(super) pace: Pace,
}

impl<'a> Scene<'a> {
    /// Rows that are kept: twice as many where the odometry is declared to be wrong: a calibration that is marginalised is never linearised again.
    pub(super) fn window(&self) -> usize {
        let odometry = &self.declared.odometry;
        let is_bounded = odometry.translation_relative > 0.0 || odometry.rotation_relative > 0.0;
        self.options.window * if is_bounded { 2 } else { 1 }
    }

    /// Rows that so many modes are fitted to, the lag of the smoother \[sibley2010sliding\]: those of the window, or fewer on robots of many sensors.
    pub(super) fn lag(&self, modes: usize) -> usize {
        if modes > FEW_MODES {
            return self.window();
        }
        self.window().min(self.window() * WHISKERS_OF_WHOLE_WINDOW / self.sensors.len().max(1))
    }

    /// How far the odometry frame can have been shifted (m) and turned (rad) by errors of the odometry before the first row of a window.
    pub(super) fn drift(&self, window: &LogWindow) -> [f64; 2] {
        let ([way, turned], odometry) = (window.gone(), &self.robot.odometry);
        let turn = odometry.rotation_relative * turned;
        // A frame that turns about a place on the way shifts by no more than the way.
        [(odometry.translation_relative + turn) * way, turn]
    }

    /// How far the first pose by a mode may be beside the region for it (m) and turned (rad) although the robot was inside: by a cell, by
    /// what the odometry may have drifted, and by what mounts, lengths and the map's scale leave open. A heading that is `turn` off (rad)
    /// turns the way back to the first pose about the contact.
    pub(super) fn prior_slack(&self, window: &LogWindow, turn: f64) -> [f64; 2] {
        let way_back = window.pose(window.len() - 1).position().norm();
        let drift = self.drift(window);
        let mut mounted = [0.0_f64; 2];
        for errors in self.robot.whiskers.iter().map(|whisker| &whisker.errors) {
            let [x, y, heading] = errors.mount;
            mounted = [mounted[0].max(x.hypot(y) + errors.length), mounted[1].max(heading)];
        }
        let place = mounted[0] + (self.robot.map_scale + mounted[1] + turn) * way_back;
        [self.options.seed_spacing + drift[0] + place, self.options.seed_turn + drift[1] + mounted[1]]
    }

    /// The measurement model of a window.
    pub(super) fn model<'b>(&'b self, window: &'b LogWindow, anchor: usize) -> MeasurementModel<'b> {
        MeasurementModel {
            map: self.map,
            ground: &self.ground,
            sensors: &self.sensors,
            whiskers: &self.whiskers,
            unknowns: &self.unknowns,
            window,
            anchor,
            heading_std: self.options.heading_error / 3.0_f64.sqrt(),
            solver: Mechanics::Table(&self.table),
            noise_model: self.options.noise_model,
            whole: true,
            pace: &self.pace,
        }
    }
}
