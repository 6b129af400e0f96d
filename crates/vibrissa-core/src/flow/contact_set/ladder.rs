//! Tip contact sets of many moments from few: traced at rungs of a ladder of moments, blended in between.
//!
//! A history asks for the sets of a dozen moments that are all but equal, and the next history for a dozen more. To
//! trace one takes longer than all that is then asked of it.

use super::tip::{TipContactSet, blend};
use crate::beam::{TipModel, TipReading};
use crate::config::TipLoad;
use crate::math;
use crate::world::Lean;

/// Natural logarithm of the ratio of neighbouring rungs: the tip of the paper's whisker moves by some millimetres from one
/// to the next, on a line within a fifth of one where the set folds, elsewhere much less.
const STEP: f64 = 0.06;
/// How far the ends of a branch may move from rung to rung to be the same branch (rad).
const SAME_BRANCH: f64 = 0.2;

/// One whisker's tip contact sets by moment, remembered.
#[derive(Clone, Debug)]
pub(crate) struct Ladder {
    tip: TipModel,
    load: TipLoad,
    lean: Lean,
    /// By side and number, in order.
    rungs: Vec<((bool, i64), Vec<TipContactSet>)>,
}

impl Ladder {
    /// A ladder on which nothing has been traced yet.
    pub(crate) fn new(tip: &TipModel, load: TipLoad, lean: Lean) -> Self {
        Self { tip: tip.clone(), load, lean, rungs: Vec::new() }
    }

    /// As [`TipContactSet::branches`] of this moment (N m), within 3e-3 of the whisker's length.
    pub(crate) fn branches(&mut self, moment: f64) -> Vec<TipContactSet> {
        let place = math::ln(moment.abs()) / STEP;
        // Loads normal to the whisker are single points that come and go.
        if self.load == TipLoad::WhiskerNormal || !place.is_finite() {
            return self.traced(moment);
        }
        let (negative, below) = (moment < 0.0, place.floor());
        let [a, b] = [below, below + 1.0].map(|k| self.rung(negative, k as i64));
        let (a, b) = (&self.rungs[a].1, &self.rungs[b].1);
        if a.len() == b.len() && a.iter().zip(b).all(|(a, b)| alike(a, b)) {
            a.iter().zip(b).map(|(a, b)| between(a, b, place - below)).collect()
        } else {
            self.traced(moment)
        }
    }

    /// Traces what [`Ladder::branches`] of this moment needs and nobody has asked for so far; how many rungs that was.
    pub(crate) fn prepare(&mut self, moment: f64) -> usize {
        let place = math::ln(moment.abs()) / STEP;
        if self.load == TipLoad::WhiskerNormal || !place.is_finite() {
            return 0;
        }
        let before = self.rungs.len();
        for k in [place.floor(), place.floor() + 1.0] {
            self.rung(moment < 0.0, k as i64);
        }
        self.rungs.len() - before
    }

    fn traced(&self, moment: f64) -> Vec<TipContactSet> {
        if self.lean.is_level() {
            TipContactSet::branches(&self.tip, TipReading::Moment(moment), self.load)
        } else {
            self.lean.tip_contacts(self.tip.whisker(), moment)
        }
    }

    /// Where the rung is kept, traced if nobody has asked for it so far; it stays there until the next is added.
    fn rung(&mut self, negative: bool, number: i64) -> usize {
        let key = (negative, number);
        self.rungs.binary_search_by_key(&key, |rung| rung.0).unwrap_or_else(|at| {
            let moment = math::exp(number as f64 * STEP);
            let sets = self.traced(if negative { -moment } else { moment });
            self.rungs.insert(at, (key, sets));
            at
        })
    }
}

/// Whether two sets are the same branch of neighbouring moments.
fn alike(a: &TipContactSet, b: &TipContactSet) -> bool {
    let (from, to) = (a.directions(), b.directions());
    (from.lo() - to.lo()).abs() < SAME_BRANCH && (from.hi() - to.hi()).abs() < SAME_BRANCH
}

/// The set at this share of the way from one to the other, where their directions correspond by their share of the range.
fn between(a: &TipContactSet, b: &TipContactSet, share: f64) -> TipContactSet {
    let (from, to) = (a.directions(), b.directions());
    let stretch = to.width() / from.width();
    let node = |c| blend(c, &b.interpolate(to.lo() + (c.direction - from.lo()) * stretch), share);
    TipContactSet::new(a.contacts().iter().map(node).collect())
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]
mod tests {
    use super::*;
    use crate::beam::Whisker;
    use crate::flow::contact_set::TipContact;

    /// A step of the continuation turns the force by no more than this (rad), but all but at the largest moment.
    const END: f64 = 0.1;

    /// Against the sets traced at the very moments: on each branch both ways, along the whole curve.
    #[test]
    fn blended_sets_are_those_that_are_traced() {
        let load = TipLoad::BoundaryNormal;
        let tip = TipModel::new(&Whisker::default()).unwrap();
        let mut ladder = Ladder::new(&tip, load, Lean::default());
        let (mut blended, mut worst) = (0, 0.0_f64);
        for k in 0..120 {
            // From the least reading that is contact to more than the whisker can carry, pushed from both sides.
            let share = (f64::from(k) * 0.618_033_988_7).fract();
            let moment = math::exp(share * math::ln(2000.0_f64)) * if k % 2 == 0 { 2e-5 } else { -2e-5 };
            let (ours, exact) =
                (ladder.branches(moment), TipContactSet::branches(&tip, TipReading::Moment(moment), load));
            assert_eq!(ours.len(), exact.len(), "{moment}");
            blended += usize::from(!ours.is_empty() && ours != exact);
            for (ours, exact) in ours.iter().zip(&exact) {
                worst = worst.max(apart(ours, exact)).max(apart(exact, ours));
                let (a, b) = (ours.directions(), exact.directions());
                assert!((a.lo() - b.lo()).abs() < END && (a.hi() - b.hi()).abs() < END, "{moment}: {a:?} {b:?}");
            }
        }
        println!("{blended} blended, at worst {worst} m off");
        assert!(blended > 60 && worst < 0.2e-3, "{blended} blended, {worst} m");
        assert!(Ladder::new(&tip, TipLoad::default(), Lean::default()).branches(0.0).is_empty());
    }

    /// How far a contact of one set is at most from the one of the other with the same direction of force, or, at the
    /// ends of the range where directions fold, from the nearest.
    fn apart(a: &TipContactSet, b: &TipContactSet) -> f64 {
        let range = b.directions();
        let away = |c: &TipContact| {
            let same = b.at_direction(c.direction).map_or(f64::INFINITY, |found| found.position.distance(c.position));
            let near = b.nearest(c.position, range.lo(), range.width());
            same.min(near.map_or_else(
                || b.contacts()[0].position.distance(c.position),
                |found| found.position.distance(c.position),
            ))
        };
        // Where a set ends depends on where the steps along it came to lie.
        let inside = |c: &&TipContact| c.direction > range.lo() + END && c.direction < range.hi() - END;
        a.contacts().iter().filter(inside).map(away).fold(0.0, f64::max)
    }
}
