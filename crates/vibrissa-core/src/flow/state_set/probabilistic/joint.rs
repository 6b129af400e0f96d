//! Moving a place and the odometry's shares together to their least cost, from several shares.
//!
//! Along a path that is corrected otherwise, a whisker springs elsewhere: the cost over the shares has many minima, more than one step
//! of all six unknowns sees. Every cost here is that of a path which has been corrected, none is promised by a linearisation.

use super::bank::{Bank, Field, LOOSE, cut};
use super::feeler::Judge;
use super::history::History;
use super::hypothesis::{Hypothesis, difference, moved};
use super::places::covariance;
use super::shares::{Shares, WAYS, within};
use crate::linear_algebra::Cholesky;

/// Steps from one start; a step that promises less (nats) is not taken, and of one that leads upwards these parts are tried.
const ROUNDS: usize = 8;
const SETTLED: f64 = 5e-2;
const PARTS: [f64; 3] = [1.0, 0.4, 0.1];
/// How far from the best shares is started, along each of their independent directions (standard deviations).
const STARTS: [f64; 2] = [2.5, -2.5];
/// A start that costs so much more than the best after so many steps (nats) is given up.
const HOPELESS: f64 = 60.0;
const TRIED: usize = 3;

/// A place with the path that it is judged on.
struct Joint {
    place: Hypothesis,
    history: History,
    cost: f64,
}

impl Bank {
    /// Looks for shares of the odometry at which the best place costs less, and goes over to them if there are any; whether there are.
    pub(super) fn search_odometry(&mut self, field: &Field<'_>, history: &mut History) -> bool {
        let Some(best) = self.hypotheses.first().filter(|_| self.shared.has_odometry()) else { return false };
        let now = self.joint(field, history, best, [0.0; 3], history.shares());
        let begun = now.cost;
        let mut least = self.descended(field, now, f64::INFINITY);
        for to in self.starts(field, &least) {
            let d = self.step_on_path(&least.place, to);
            let from = self.joint(field, &least.history, &least.place, d, to);
            let found = self.descended(field, from, least.cost + HOPELESS);
            if found.cost < least.cost {
                least = found;
            }
        }
        if least.cost > begun - SETTLED {
            return false;
        }
        let shares = least.history.shares();
        let moves = best.map_from_odom.between(least.place.map_from_odom);
        let followed = |h: &Hypothesis| {
            // Where its linearisation says, or where an image of the best one goes: the cheaper.
            let told = self.step_on_path(h, shares);
            let alike = difference(h.map_from_odom, h.map_from_odom.compose(moves), self.pivot);
            let [told, alike] = [told, alike].map(|d| self.joint(field, history, h, d, shares));
            if alike.cost < told.cost { alike.place } else { told.place }
        };
        let others: Vec<Hypothesis> = self.hypotheses.iter().skip(1).map(followed).collect();
        history.correct(shares);
        self.hypotheses = core::iter::once(least.place).chain(others).collect();
        self.hypotheses.iter_mut().for_each(|h| h.look(LOOSE, self.shared));
        true
    }

    /// Where else the shares may be started from.
    fn starts(&self, field: &Field<'_>, from: &Joint) -> Vec<Shares> {
        let at = from.history.shares();
        let mut starts = vec![[0.0; WAYS]];
        let spread = from.place.belief.calibration(self.shared).map(|c| c.wherever(&covariance(&from.place, self)));
        if let Some(root) = spread.and_then(|spread| Cholesky::new(&spread)).map(|factor| factor.lower()) {
            let to = |way: usize, by: f64| [0, 1, 2].map(|i: usize| at[i] + by * root[i][way]);
            starts.extend((0..WAYS).flat_map(|way| STARTS.map(|by| to(way, by))));
        }
        starts.into_iter().map(|shares| within(shares, &field.robot.odometry)).collect()
    }

    /// The step of a place on the path corrected by these shares, as its linearisation says.
    fn step_on_path(&self, h: &Hypothesis, shares: Shares) -> [f64; 3] {
        cut(h.belief.shifted([0.0; 3], shares).place_on_path(self.shared.gain).least(LOOSE).1)
    }

    /// This place moved by `d`, on the path corrected by these shares.
    fn joint(&self, field: &Field<'_>, history: &History, place: &Hypothesis, d: [f64; 3], shares: Shares) -> Joint {
        let (mut history, mut place) = (history.clone(), place.clone());
        history.correct(shares);
        let scene = field.scene(&history, self.pivot, Judge::FAIR, self.shared);
        place.run(&scene, moved(place.map_from_odom, self.pivot, d), self.used.iter().copied());
        let cost = place.cost_on_path(self.shared);
        Joint { place, history, cost }
    }

    /// Moved to the least cost around.
    fn descended(&self, field: &Field<'_>, mut from: Joint, most: f64) -> Joint {
        for round in 0..ROUNDS {
            let Some(response) = from.place.belief.calibration(self.shared) else { return from };
            let (promise, d) = from.place.free_best(LOOSE, self.shared);
            if from.cost - promise < SETTLED || round >= TRIED && from.cost > most {
                break;
            }
            let (d, at) = (cut(d), from.history.shares());
            let off = response.given(d);
            let next = PARTS.into_iter().find_map(|part| {
                let shares = [0, 1, 2].map(|way| at[way] + part * off[way]);
                let shares = within(shares, &field.robot.odometry);
                let next = self.joint(field, &from.history, &from.place, d.map(|v| part * v), shares);
                (next.cost < from.cost).then_some(next)
            });
            let Some(next) = next else { break };
            from = next;
        }
        from
    }
}
