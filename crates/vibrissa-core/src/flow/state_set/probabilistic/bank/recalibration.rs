//! Recalibration of the odometry while the robot goes on \[censi2013simultaneous\].
//!
//! How far the odometry is wrong is estimated along with every place, to first order. Over a metre of the way a share of 1 % is 10 mm,
//! by which a whisker's contact is another: so the path itself is corrected now and then by what the best hypothesis says, the robot
//! staying where it is.

use super::super::calibrated_path::{CALIBRATION_SIZE, within};
use super::super::log_window::LogWindow;
use super::{BankContext, DAMPING, HypothesisBank, trust_region_step};

/// With more hypotheses than this they are not relinearised, but told around the new path to first order.
const FEW: usize = 64;
/// Corrections that move one end of the way against the other by less than this (m, rad) are not made; with many hypotheses this many times
/// as much.
const LEAST: [f64; 2] = [5e-5, 5e-4];
const MANY: f64 = 8.0;
/// The parts of a correction that are tried, and by how much each may make things worse (nats).
const STEP_FRACTIONS: [f64; 2] = [1.0, 0.3];
const WORSE: f64 = 0.5;

impl HypothesisBank {
    /// Corrects the odometry by what the best hypothesis says about it; whether that was worth it.
    pub(in super::super) fn recalibrate_odometry(
        &mut self,
        context: &BankContext<'_>,
        history: &mut LogWindow,
    ) -> bool {
        if !self.shared.has_odometry() {
            return false;
        }
        let known = self.hypotheses.iter().filter(|h| !h.is_pending);
        let Some(best) = known.min_by(|a, b| a.cost(self.shared).total_cmp(&b.cost(self.shared))) else { return false };
        let Some(response) = best.belief.calibration(self.shared) else { return false };
        let off = response.given(trust_region_step(best.calibrated_step(DAMPING, self.shared).1));
        let (at, now) = (best.belief.at(), history.calibration());
        let to = within([0, 1, 2].map(|way| at[way] + off[way]), &context.robot.odometry);
        let way = history.way();
        let [place, turn] = way.moves([0, 1, 2].map(|way| to[way] - now[way]));
        let few = self.hypotheses.len() <= FEW;
        let times = if few { 1.0 } else { MANY };
        if place < times * LEAST[0] && turn < times * LEAST[1] {
            return false;
        }
        let ends = [history.pose(0), history.pose(history.len() - 1)];
        let (before, kept) = (best.cost(self.shared), self.hypotheses.clone());
        for share in STEP_FRACTIONS {
            let calibration = [0, 1, 2].map(|way| now[way] + share * (to[way] - now[way]));
            history.correct(calibration);
            for h in &mut self.hypotheses {
                h.correct(&way, ends, self.pivot, calibration);
                h.update_prediction(DAMPING, self.shared);
            }
            if few {
                self.relinearise_all(context, history, 0..self.hypotheses.len());
                let after = self.hypotheses.iter().map(|h| h.cost(self.shared)).fold(f64::INFINITY, f64::min);
                if after > before + WORSE {
                    self.hypotheses.clone_from(&kept);
                    continue;
                }
                self.update_reference_costs(context, history);
            }
            self.dropped.all().for_each(|h| {
                h.correct(&way, ends, self.pivot, calibration);
                h.update_prediction(DAMPING, self.shared);
            });
            return true;
        }
        history.correct(now);
        false
    }

    /// Goes back to the path as the odometry has it: it may have been corrected by what a wrong place says.
    pub(super) fn reset_calibration(&mut self, context: &BankContext<'_>, history: &mut LogWindow) {
        if !self.shared.has_odometry() {
            return;
        }
        let (calibration, way) = ([0.0; CALIBRATION_SIZE], history.way());
        let ends = [history.pose(0), history.pose(history.len() - 1)];
        history.correct(calibration);
        for h in self.hypotheses.iter_mut().chain(self.dropped.all()) {
            h.correct(&way, ends, self.pivot, calibration);
            h.update_prediction(DAMPING, self.shared);
        }
        if self.hypotheses.len() <= FEW {
            self.relinearise_all(context, history, 0..self.hypotheses.len());
        }
        self.update_reference_costs(context, history);
    }
}
