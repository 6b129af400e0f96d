//! A whisker as the map bends it at a pose, for drawing and for what it should feel there.

use super::state::{Contact, WhiskerState};
use super::{ElasticBase, ForwardModel, Mechanics};
use crate::Result;
use crate::beam::{TipModel, Whisker};
use crate::contact::quasi_static::{LoadedWhisker, PointLoad};
use crate::contact::{Boundaries, Hold, SensedQuantity, TwoContacts};
use crate::plane::{Pose2, Vec2, wrap_angle};
use crate::world::Map;
use core::f64::consts::{FRAC_PI_2, PI};

/// A base that moved (m) or turned (rad) by more since it was asked last is not followed: the whisker is put down anew.
const FOLLOWED: f64 = 0.02;
const FOLLOWED_TURN: f64 = 0.3;
/// Halvings by which the force of a moment is found, and the largest force (over `EI / L²`).
const HALVINGS: u32 = 60;
const LARGEST_FORCE: f64 = 20.0;
/// Steps of the march along a whisker with two contacts.
const MARCH: usize = 120;

/// What a whisker is like at a pose.
#[derive(Clone, Debug, PartialEq)]
pub struct Bending {
    /// The moment at its base (N m), 0 where it is free; none where its contact is not understood.
    pub moment: Option<f64>,
    /// Where it is held, whisker frame (m): of two contacts the tip's.
    pub contact: Option<Vec2>,
    /// Points from base to tip at equal arc lengths, whisker frame (m); two of a straight whisker that is free. Empty where the
    /// contact is not understood.
    pub shape: Vec<Vec2>,
}

/// What a whisker feels at a pose.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FeltMoment {
    /// The moment at its base (N m), 0 where it is free.
    pub moment: f64,
    /// Its derivatives by the base's x, y (N, map frame) and heading (N m/rad).
    pub gradient: [f64; 3],
}

/// Where a [`BentWhisker`] stands and what holds it, to go on from there again.
#[derive(Clone, Copy, Debug)]
pub struct Followed {
    state: WhiskerState,
    last: Option<Pose2>,
}

/// A whisker that is followed from pose to pose as `predicted_moments` follows it; at its first pose, and after a jump, it is put
/// down at rest from out of contact.
#[derive(Debug)]
pub struct BentWhisker<'a> {
    map: &'a Map,
    boundaries: Boundaries,
    tip: TipModel,
    base: Option<ElasticBase>,
    loaded: LoadedWhisker,
    state: WhiskerState,
    last: Option<Pose2>,
}

impl<'a> BentWhisker<'a> {
    /// A whisker on a map.
    ///
    /// # Errors
    ///
    /// Whiskers that are curved at rest, or make no sense.
    pub fn new(map: &'a Map, whisker: &Whisker) -> Result<Self> {
        whisker.require_straight()?;
        let tip = TipModel::new(whisker)?;
        Ok(Self {
            map,
            boundaries: Boundaries::new(map).with_clearance(map),
            base: ElasticBase::of(&tip, SensedQuantity::Moment),
            tip,
            loaded: LoadedWhisker::new(whisker)?,
            state: WhiskerState::Free,
            last: None,
        })
    }

    /// The whisker with its base at `map_from_whisker`; `points` of a bent one.
    pub fn at(&mut self, map_from_whisker: Pose2, points: usize) -> Bending {
        let moment = self.moved(map_from_whisker, None).map(|felt| felt.moment);
        match self.state {
            WhiskerState::Touching(touch) if touch.q > 0.0 => {
                let contact = Some(map_from_whisker.inverse_transform_point(touch.place));
                Bending { moment, contact, shape: self.shape(&touch, points) }
            }
            WhiskerState::Unknown => Bending { moment, contact: None, shape: Vec::new() },
            _ => Bending { moment, contact: None, shape: self.loaded.rest.clone() },
        }
    }

    /// What the whisker is followed from next.
    #[must_use]
    pub fn followed(&self) -> Followed {
        Followed { state: self.state, last: self.last }
    }

    /// Goes on from where the whisker once was.
    pub fn go_on_from(&mut self, followed: Followed) {
        (self.state, self.last) = (followed.state, followed.last);
    }

    /// Forgets where the whisker was: it is put down anew at the next pose.
    pub fn lift(&mut self) {
        (self.state, self.last) = (WhiskerState::Free, None);
    }

    /// What the whisker feels with its base at `map_from_whisker`, as the estimators predict it: an elastic base yields. None where
    /// its contact is not understood.
    pub fn felt_at(&mut self, map_from_whisker: Pose2) -> Option<FeltMoment> {
        self.moved(map_from_whisker, self.base)
    }

    fn moved(&mut self, map_from_whisker: Pose2, base: Option<ElasticBase>) -> Option<FeltMoment> {
        let is_uniform = self.tip.is_uniform() || base.is_some();
        let mechanics = if is_uniform { Mechanics::ClosedForm } else { Mechanics::Model(&self.tip) };
        let length = self.loaded.beam.length;
        let forward = ForwardModel {
            map: self.map,
            boundaries: &self.boundaries,
            length,
            mechanics,
            whole: true,
            quantity: SensedQuantity::Moment,
            base,
        };
        let near = |from: &Pose2| {
            from.position().distance(map_from_whisker.position()) <= FOLLOWED
                && wrap_angle(map_from_whisker.theta - from.theta).abs() <= FOLLOWED_TURN
        };
        let from = self.last.filter(near).unwrap_or_else(|| {
            self.state = WhiskerState::Free;
            map_from_whisker
        });
        self.last = Some(map_from_whisker);
        let felt = forward.advance(&mut self.state, from, map_from_whisker, false);
        let scale = self.tip.rigidity() / length;
        match self.state {
            WhiskerState::Touching(touch) if touch.q > 0.0 => {
                Some(FeltMoment { moment: felt.value * scale, gradient: felt.gradient.map(|g| g * scale) })
            }
            WhiskerState::Unknown => None,
            _ => Some(FeltMoment::default()),
        }
    }

    fn shape(&self, touch: &Contact, points: usize) -> Vec<Vec2> {
        match touch.hold {
            Hold::Both(both) => marched(&both, self.loaded.beam.length, points),
            Hold::Tip(_) | Hold::Side(..) => {
                // Forces over what the model calls the rigidity, and over that of the base.
                let q = touch.q / (touch.s * touch.s) * self.tip.rigidity() / self.loaded.beam.flexural_rigidity;
                self.pushed(q, touch.s, touch.beta, points)
            }
        }
    }

    fn pushed(&self, q: f64, s: f64, beta: f64, points: usize) -> Vec<Vec2> {
        let bend = self.loaded.bend(PointLoad { q, s, beta });
        bend.map_or_else(Vec::new, |bend| bend.shape(self.loaded.beam.length, points))
    }

    /// The shape that a moment (N m) alone gives, whisker frame (m), with a force normal to the whisker at its tip; that of the
    /// largest such moment for one beyond it.
    #[must_use]
    pub fn by_moment(&self, moment: f64, points: usize) -> Vec<Vec2> {
        let beta = if moment < 0.0 { PI } else { 0.0 };
        let wanted = moment.abs() * self.loaded.beam.length / self.loaded.beam.flexural_rigidity;
        let felt = |q: f64| self.loaded.at(PointLoad { q, s: 1.0, beta }).map(|state| state.m.abs());
        let (mut least, mut most) = (0.0, LARGEST_FORCE);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (least + most);
            // Where the closed form ends the force is too large.
            if felt(middle).is_some_and(|m| m < wanted) { least = middle } else { most = middle }
        }
        if least <= 0.0 { self.loaded.rest.clone() } else { self.pushed(least, 1.0, beta, points) }
    }
}

/// A uniform whisker of this length (m) under two forces: its moment is that of all forces ahead.
fn marched(both: &TwoContacts, length: f64, points: usize) -> Vec<Vec2> {
    let [moment, x, y, inner_at, push] = both.load;
    let end = both.end();
    let step = 1.0 / MARCH as f64;
    let (mut place, mut slope) = (Vec2::ZERO, 0.0_f64);
    // The moment here is that at `from`, less what the force ahead of it takes on the way.
    let (mut m, mut from, mut force, mut passed) = (moment, Vec2::ZERO, Vec2::new(x, y), 0);
    let mut path = vec![Vec2::ZERO];
    for index in 0..MARCH {
        let here = index as f64 * step;
        if passed == 0 && here >= inner_at {
            m -= (place - from).cross(force);
            (from, passed) = (place, 1);
            force = force - Vec2::from_angle(slope + FRAC_PI_2) * push;
        }
        if passed == 1 && here >= end {
            // Beyond the last contact it is straight.
            (m, force, passed) = (0.0, Vec2::ZERO, 2);
        }
        // The midpoint rule.
        let bend = |at: Vec2| m - (at - from).cross(force);
        let half = slope + 0.5 * step * bend(place);
        let middle = place + Vec2::from_angle(slope + 0.25 * step * bend(place)) * (0.5 * step);
        place += Vec2::from_angle(half) * step;
        slope += step * bend(middle);
        path.push(place);
    }
    let last = points.max(2) - 1;
    (0..=last).map(|k| path[(k * MARCH + last / 2) / last] * length).collect()
}
