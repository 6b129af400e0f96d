//! Multistart over the odometry calibration: pose and calibration together to their least cost, from several starts
//! \[rinnooykan1987stochastic, censi2013simultaneous\].
//!
//! Along a path that is corrected otherwise, a whisker springs elsewhere: the cost over the calibration parameters has many minima, more than one step
//! of all six unknowns sees. Every cost here is that of a path which has been corrected, none is promised by a linearisation.

use super::bank::{BankContext, DAMPING, HypothesisBank, trust_region_step};
use super::calibrated_path::{CALIBRATION_SIZE, OdometryCalibration, within};
use super::hypothesis::{GaussianHypothesis, difference, moved};
use super::log_window::LogWindow;
use super::places::covariance;
use super::sensor::LikelihoodOptions;
use crate::linear_algebra::Cholesky;

/// Steps from one start; a step that predicts less (nats) is not taken, and of one that leads upwards these parts are tried.
const ROUNDS: usize = 8;
const SETTLED: f64 = 5e-2;
const PARTS: [f64; 3] = [1.0, 0.4, 0.1];
/// How far from the best shares is started, along each of their independent directions (standard deviations).
const STARTS: [f64; 2] = [2.5, -2.5];
/// A start that costs so much more than the best after so many steps (nats) is given up.
const HOPELESS: f64 = 60.0;
const TRIED: usize = 3;

/// A place with the path that it is judged on.
struct JointEstimate {
    place: GaussianHypothesis,
    history: LogWindow,
    cost: f64,
}

impl HypothesisBank {
    /// Looks for calibration parameters of the odometry at which the best place costs less, and goes over to them if there are any; whether there are.
    pub(super) fn search_calibration(&mut self, context: &BankContext<'_>, history: &mut LogWindow) -> bool {
        let Some(best) = self.hypotheses.first().filter(|_| self.shared.has_odometry()) else { return false };
        let now = self.joint_estimate(context, history, best, [0.0; 3], history.calibration());
        let begun = now.cost;
        let mut least = self.minimised(context, now, f64::INFINITY);
        for to in self.starts(context, &least) {
            let d = self.step_on_path(&least.place, to);
            let from = self.joint_estimate(context, &least.history, &least.place, d, to);
            let found = self.minimised(context, from, least.cost + HOPELESS);
            if found.cost < least.cost {
                least = found;
            }
        }
        if least.cost > begun - SETTLED {
            return false;
        }
        let calibration = least.history.calibration();
        let moves = best.map_from_odom.between(least.place.map_from_odom);
        let followed = |h: &GaussianHypothesis| {
            // Where its linearisation says, or where an image of the best one goes: the cheaper.
            let told = self.step_on_path(h, calibration);
            let alike = difference(h.map_from_odom, h.map_from_odom.compose(moves), self.pivot);
            let [told, alike] = [told, alike].map(|d| self.joint_estimate(context, history, h, d, calibration));
            if alike.cost < told.cost { alike.place } else { told.place }
        };
        let others: Vec<GaussianHypothesis> = self.hypotheses.iter().skip(1).map(followed).collect();
        history.correct(calibration);
        self.hypotheses = core::iter::once(least.place).chain(others).collect();
        self.hypotheses.iter_mut().for_each(|h| h.update_prediction(DAMPING, self.shared));
        true
    }

    /// Where else the calibration parameters may be started from.
    fn starts(&self, context: &BankContext<'_>, from: &JointEstimate) -> Vec<OdometryCalibration> {
        let at = from.history.calibration();
        let mut starts = vec![[0.0; CALIBRATION_SIZE]];
        let spread = from.place.belief.calibration(self.shared).map(|c| c.wherever(&covariance(&from.place, self)));
        if let Some(root) = spread.and_then(|spread| Cholesky::new(&spread)).map(|factor| factor.lower()) {
            let to = |way: usize, by: f64| [0, 1, 2].map(|i: usize| at[i] + by * root[i][way]);
            starts.extend((0..CALIBRATION_SIZE).flat_map(|way| STARTS.map(|by| to(way, by))));
        }
        starts.into_iter().map(|calibration| within(calibration, &context.robot.odometry)).collect()
    }

    /// The step of a place on the path corrected by these calibration parameters, as its linearisation says.
    fn step_on_path(&self, h: &GaussianHypothesis, calibration: OdometryCalibration) -> [f64; 3] {
        trust_region_step(h.belief.shifted([0.0; 3], calibration).place_on_path(self.shared.gain).least(DAMPING).1)
    }

    /// This place moved by `d`, on the path corrected by these calibration parameters.
    fn joint_estimate(
        &self,
        context: &BankContext<'_>,
        history: &LogWindow,
        place: &GaussianHypothesis,
        d: [f64; 3],
        calibration: OdometryCalibration,
    ) -> JointEstimate {
        let (mut history, mut place) = (history.clone(), place.clone());
        history.correct(calibration);
        let model = context.model(&history, self.pivot, LikelihoodOptions::DECLARED, self.shared);
        place.relinearise(&model, moved(place.map_from_odom, self.pivot, d), self.used.iter().copied());
        let cost = place.cost_on_path(self.shared);
        JointEstimate { place, history, cost }
    }

    /// Moved to the least cost around.
    fn minimised(&self, context: &BankContext<'_>, mut from: JointEstimate, most: f64) -> JointEstimate {
        for round in 0..ROUNDS {
            let Some(response) = from.place.belief.calibration(self.shared) else { return from };
            let (predicted, d) = from.place.calibrated_step(DAMPING, self.shared);
            if from.cost - predicted < SETTLED || round >= TRIED && from.cost > most {
                break;
            }
            let (d, at) = (trust_region_step(d), from.history.calibration());
            let off = response.given(d);
            let next = PARTS.into_iter().find_map(|part| {
                let calibration = [0, 1, 2].map(|way| at[way] + part * off[way]);
                let calibration = within(calibration, &context.robot.odometry);
                let next = self.joint_estimate(context, &from.history, &from.place, d.map(|v| part * v), calibration);
                (next.cost < from.cost).then_some(next)
            });
            let Some(next) = next else { break };
            from = next;
        }
        from
    }
}
