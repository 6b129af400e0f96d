//! Congruent places after rows have been marginalised, by replaying a thinned log.
//!
//! What the rows that were marginalised say of a place can only be told near where they were linearised. Of a place elsewhere
//! that feels the same as the best one they say the same. Whether it does is asked of the whole way: an even share of all rows
//! is kept, however long the log, and run at both.

use super::super::congruent_places::contacts;
use super::super::hypothesis::{CostLimits, GaussianHypothesis, difference};
use super::super::log_window::LogWindow;
use super::super::sensor::LikelihoodOptions;
use super::pruning::congruent_poses;
use super::{BankContext, DAMPING, HypothesisBank};
use crate::flow::thinned::Thinned;
use crate::plane::Pose2;

/// So many rows of the way are kept at least, where there are as many.
const KEPT: usize = 256;
/// One of so many rows that have not been marginalised is asked, too.
const SPARSE: usize = 4;
/// Rows further apart than this in the mean (m) are too far apart to follow a contact.
const APART: f64 = 6e-3;
/// The best place must cost no more than this for each row of the way, and the other no more than this above it (nats).
const POOR: f64 = 2.0;
const MORE: f64 = 8.0;
/// What is no further than this from a hypothesis that costs no more than that is known (m, rad).
const KNOWN: [f64; 2] = [3e-3, 0.03];

/// An even share of the rows that have been marginalised, from a first row on in which all whiskers were free.
#[derive(Default)]
pub(super) struct ThinnedLog {
    /// As the odometry says, since it may be corrected later.
    rows: Thinned<(Pose2, Vec<f64>), KEPT>,
    way: f64,
    last: Option<Pose2>,
    /// How often rows have been taken.
    times: u32,
}

impl ThinnedLog {
    /// Takes the rows of a history from one to before another.
    pub(super) fn take(&mut self, history: &LogWindow, rows: core::ops::Range<usize>) {
        self.times += 1;
        for row in rows {
            let pose = history.pose(row);
            self.way += self.last.map_or(0.0, |last| last.position().distance(pose.position()));
            self.last = Some(pose);
            self.rows.push((history.raw(row), history.readings(row).to_vec()));
        }
    }

    /// The way as one history, with which of its rows is the first of `history`; none when its rows are too far apart.
    fn whole(&self, context: &BankContext<'_>, history: &LogWindow) -> Option<(LogWindow, usize)> {
        let mut whole = LogWindow::new(context.sensors);
        let raw: Vec<Pose2> = self.rows.iter().map(|(pose, _)| *pose).collect();
        let path = history.earlier(&raw);
        path.iter().zip(self.rows.iter()).for_each(|(pose, (_, readings))| whole.push(*pose, readings));
        let first = whole.len();
        if first == 0 || self.way > APART * first as f64 {
            return None;
        }
        (0..history.len()).step_by(SPARSE).for_each(|row| whole.push(history.pose(row), history.readings(row)));
        Some((whole, first))
    }
}

impl HypothesisBank {
    /// Whether it is time to look for congruent places again: ever more rarely, since each time takes some milliseconds.
    pub(in super::super) fn may_search_congruent(&self) -> bool {
        self.thinned_log.as_ref().is_some_and(|trail| trail.times.is_power_of_two())
    }

    /// Hypotheses at other corners where the whole way feels as at the best one, and which cost no more than what is not yet
    /// dropped; none as long as nothing has been marginalised.
    pub(in super::super) fn congruent(
        &self,
        context: &BankContext<'_>,
        history: &LogWindow,
    ) -> Vec<GaussianHypothesis> {
        let Some(trail) = self.thinned_log.as_ref().filter(|_| self.marginalised) else { return Vec::new() };
        let alive = || self.hypotheses.iter().filter(|h| !h.is_pending);
        let Some(best) = alive().min_by(|a, b| a.predicted.0.total_cmp(&b.predicted.0)) else { return Vec::new() };
        let model = context.model(history, self.pivot, LikelihoodOptions::DECLARED, self.shared);
        let touched = contacts(best, &model, &self.used);
        let Some(&contact) = touched.get(touched.len() / 2) else { return Vec::new() };
        let (least, more) = (self.least(), self.prune_threshold(history));
        let is_new = |frame: &Pose2| {
            let stands = |h: &GaussianHypothesis| {
                let near = |at: Pose2| {
                    let [x, y, turn] = difference(*frame, at, self.pivot);
                    x.hypot(y) < KNOWN[0] && turn.abs() < KNOWN[1]
                };
                near(h.map_from_odom) || (self.by_symmetry && context.symmetries.images(h.map_from_odom).any(near))
            };
            !alive().filter(|h| h.predicted.0 <= least + MORE).any(stands)
                && context.satisfies_prior(history, *frame)
                && context.origin_is_free(history, *frame, 0)
        };
        let frames: Vec<Pose2> = congruent_poses(context, contact, best.map_from_odom).filter(is_new).collect();
        if frames.is_empty() {
            return Vec::new();
        }
        let Some((whole, first)) = trail.whole(context, history) else { return Vec::new() };
        let way = context.model(&whole, self.pivot, LikelihoodOptions::DECLARED, self.shared);
        let rows: Vec<usize> = (0..whole.len()).collect();
        let reference_costs = best.free_at(best.map_from_odom).costs(&way, &rows);
        if reference_costs.last().is_none_or(|&cost| cost > POOR * rows.len() as f64) {
            return Vec::new();
        }
        let mut found: Vec<GaussianHypothesis> = Vec::new();
        for frame in frames {
            let mut there = best.free_at(frame);
            there.relinearise(&way, frame, core::iter::empty());
            let mut start = None;
            let feels = rows.iter().zip(&reference_costs).all(|(&row, reference_costs)| {
                there.add_row(&way, row);
                if row == first {
                    start = Some(there.states.clone());
                }
                there.cost(self.shared) <= reference_costs + MORE
            });
            let Some(start) = start.filter(|_| feels) else { continue };
            let mut h = best.transformed_to(frame, start, self.pivot);
            if h.relinearise_below(
                &model,
                frame,
                &self.used,
                CostLimits { reference_costs: &self.reference_costs, more },
            ) {
                h.update_prediction(DAMPING, self.shared);
                if h.predicted.0 <= least + more {
                    found.push(h);
                }
            }
        }
        found
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

    use crate::beam::TipModel;
    use crate::config::ProbabilisticOptions;
    use crate::flow::state_set::probabilistic::{PosteriorPlace, ProbabilisticSet, SensedQuantity, predicted_moments};
    use crate::plane::{Curve, Pose2, Vec2};
    use crate::world::{Boundary, Map, Robot, Role};
    use core::f64::consts::{FRAC_PI_2, PI};

    /// A room of 0.7 by 0.5 m with posts.
    fn room(posts: &[(f64, f64)]) -> Map {
        let corners = [(-0.35, -0.25), (0.35, -0.25), (0.35, 0.25), (-0.35, 0.25)].map(|(x, y)| Vec2::new(x, y));
        let walls = Boundary::new(Role::Arena, Curve::polyline(&corners, true).unwrap(), None).unwrap();
        let post =
            |&(x, y)| Boundary::new(Role::Obstacle, Curve::circle(Vec2::new(x, y), 0.006).unwrap(), None).unwrap();
        Map::new(core::iter::once(walls).chain(posts.iter().map(post)).collect()).unwrap()
    }

    /// A robot that trails its whisker along the lower wall into the corner on the right and up from there.
    fn path() -> Vec<Pose2> {
        let lean = 0.7_f64;
        let off = |press: f64| 0.075 * lean.cos() - press;
        let low = |x: f64, press: f64| (x, -0.25 + off(press), -FRAC_PI_2 - lean);
        let right = |y: f64, press: f64| (0.35 - off(press), y, -lean);
        let way = [
            low(0.05, -0.005),
            low(0.08, 0.006),
            low(0.2, 0.012),
            low(0.29, 0.008),
            right(-0.2, 0.01),
            right(0.0, 0.012),
        ];
        let mut path = Vec::new();
        for pair in way.windows(2) {
            let ((x, y, theta), (u, v, turned)) = (pair[0], pair[1]);
            let steps = ((u - x).hypot(v - y).max(0.03 * (turned - theta)) / 5e-4).ceil();
            path.extend((0..steps as usize).map(|k| {
                let share = k as f64 / steps;
                Pose2::new(x + share * (u - x), y + share * (v - y), theta + share * (turned - theta))
            }));
        }
        path
    }

    /// What is reported when only one hypothesis is left before the end, after rows have been marginalised.
    fn told(map: &Map) -> (Vec<PosteriorPlace>, Pose2) {
        let (robot, path) = (Robot::default(), path());
        let tip = TipModel::new(&robot.whiskers[0].beam).unwrap();
        let options = ProbabilisticOptions { window: 250, ..ProbabilisticOptions::default() };
        let mut set =
            ProbabilisticSet::new(map, &robot, core::slice::from_ref(&tip), &[(0, SensedQuantity::Moment)], options);
        for (pose, felt) in path.iter().zip(predicted_moments(map, &tip, &path)) {
            set.step(path[0].between(*pose), &[felt.moment], None);
        }
        let truth = path[0];
        let bank = set.bank().unwrap();
        assert!(bank.marginalised);
        bank.hypotheses.retain(|h| h.map_from_odom.position().distance(truth.position()) < 2e-3);
        assert!(!bank.hypotheses.is_empty());
        let last = path[0].between(path[path.len() - 1]);
        (set.finish().0, truth.compose(last))
    }

    fn turned(pose: Pose2, corner: (f64, f64), from: (f64, f64), angle: f64) -> Pose2 {
        let arm = pose.position() - Vec2::new(from.0, from.1);
        let place = Vec2::new(corner.0, corner.1) + arm.rotated(angle);
        Pose2::new(place.x, place.y, pose.theta + angle)
    }

    #[test]
    fn what_was_lost_is_found_at_corners_where_the_whole_way_feels_the_same() {
        let corner = (0.35, -0.25);
        let images = |truth: Pose2| {
            [((0.35, 0.25), FRAC_PI_2), ((-0.35, 0.25), PI), ((-0.35, -0.25), -FRAC_PI_2)]
                .map(|(to, angle)| turned(truth, to, corner, angle))
        };
        let is_told = |places: &[PosteriorPlace], pose: Pose2| {
            places
                .iter()
                .any(|place| place.members.iter().any(|(at, _)| at.position().distance(pose.position()) < 1e-3))
        };
        let (places, truth) = told(&room(&[(0.03, 0.02)]));
        assert!(is_told(&places, truth), "{places:?}");
        for image in images(truth) {
            assert!(is_told(&places, image), "{image:?} of {places:?}");
        }
        // A post on the way to the corner on the upper left, which rows that are marginalised did not feel at the true one.
        let (places, truth) = told(&room(&[(0.03, 0.02), (-0.18, 0.236)]));
        let [upper_right, upper_left, lower_left] = images(truth);
        for pose in [truth, upper_right, lower_left] {
            assert!(is_told(&places, pose), "{pose:?} of {places:?}");
        }
        assert!(!is_told(&places, upper_left), "{places:?}");
    }
}
