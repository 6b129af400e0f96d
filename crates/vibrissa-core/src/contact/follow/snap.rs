//! Where a whisker comes to rest that has lost its equilibrium.
//!
//! Off a corner that held the tip, or past a fold of the branch that it followed, a whisker snaps. It is light and
//! damped: what it costs to bend it until the tip is at a place only falls on the way. A tip on a boundary slides to
//! where the boundary does not push it along any more; one that would have to be pulled there flies towards where the
//! unloaded whisker has it, up to the next boundary. The rest of the whisker is looked at where it has come to rest.

use super::both_snap::BothSlid;
use super::surroundings::Surroundings;
use super::tip::Placed;
use super::{Contact, ForwardModel, Next, Prediction};
use crate::contact::{Hold, Stance, Support, TwoContacts};
use crate::math;
use crate::plane::{Pose2, Vec2, wrap_angle};
use core::f64::consts::{FRAC_PI_2, PI};

/// Below this force a whisker has nothing to snap with.
const WEAK: f64 = 0.02;
/// How far a tip slides from one look to the next (whisker lengths), and how often it is looked at.
pub(super) const STRIDE: f64 = 0.02;
pub(super) const MOST_STRIDES: usize = 150;
/// From this slant of the force on (share of it along the boundary) an equilibrium is looked for, within so many
/// strides.
const UPRIGHT: f64 = 0.5;
const NEAR: f64 = 3.0;
/// A stride after which nothing holds the tip is halved so often.
pub(super) const MOST_HALVED: u32 = 5;
/// Looks at a whisker that unbends, and halvings that find where it meets a boundary.
const FLIGHT: usize = 24;
const HALVINGS: usize = 10;
/// How far beside the boundary what meets it is, at most (whisker lengths).
const REACH: f64 = 0.05;
/// How deep in a boundary the tip of the unloaded whisker may be for what rests there to be found (whisker lengths).
const DEEPEST: f64 = 0.4;
/// A tip that a force across it has pushed to a small polar angle is nearer to the base than a straight one by this
/// share of its square.
const BENT: f64 = 0.09;
/// A concave corner that turns by more than this (rad) is no facet of a smooth hollow.
const HOLDS: f64 = 0.35;
/// Flights before it is given up.
const MOST_FLIGHTS: usize = 3;

/// The force at the tip that holds the whisker for a moment.
#[derive(Clone, Copy)]
pub(super) struct TipForce {
    pub(super) q: f64,
    pub(super) beta: f64,
}

/// How a slide of the tip ends.
enum Slid {
    Rests(Contact, Prediction),
    /// Off the boundary, under this force.
    Off(TipForce),
    Lost,
}

/// What a slide comes to at a corner.
enum Turned {
    /// The place across it.
    Onto((u32, f64)),
    Ends(Slid),
}

impl ForwardModel<'_> {
    /// Where the whisker comes to rest that was held so and is now at `map_from_whisker`; none where it is free then,
    /// or meets a boundary with its side.
    pub(super) fn snapped(&self, touch: &Contact, map_from_whisker: Pose2) -> Option<(Contact, Prediction)> {
        if touch.q < WEAK && !matches!(touch.hold, Hold::Both(_)) {
            return None;
        }
        let stance = Stance::new(map_from_whisker, self.length);
        let of_touch = TipForce { q: touch.q, beta: touch.beta };
        let (mut tip_force, mut at) = match touch.hold {
            Hold::Tip(on) => self.set_out(&stance, of_touch, on),
            Hold::Side(..) => {
                let at = self.fallen(&stance, touch)?;
                (self.across_at(&stance, at), Some(at))
            }
            Hold::Both(both) => match self.both_slid(&stance, &both, None) {
                Some(BothSlid::Rests(touch, predicted)) => return Some((touch, predicted)),
                Some(BothSlid::TipAlone(left, at)) => (left, Some(at)),
                None => match self.on_either(&stance, &both) {
                    Next::Touching(touch, predicted) => return self.rested(&stance, touch, predicted),
                    _ if both.lies_at.is_some() => return None,
                    _ => self.set_out(&stance, self.tip_force_of(&both), both.outer),
                },
            },
        };
        for _ in 0..MOST_FLIGHTS {
            if let Some((piece, there)) = at {
                match self.slid(&stance, tip_force, piece, there.clamp(0.0, 1.0)) {
                    Slid::Rests(touch, predicted) => return self.rested(&stance, touch, predicted),
                    Slid::Off(left) => tip_force = left,
                    Slid::Lost => return None,
                }
            }
            (tip_force, at) = self.flown(&stance, tip_force).map(|(tip_force, at)| (tip_force, Some(at)))?;
        }
        None
    }

    /// Under which force and from where a tip sets out that has lost what it rested on.
    fn set_out(&self, stance: &Stance, mut tip_force: TipForce, on: Support) -> (TipForce, Option<(u32, f64)>) {
        let at = match on {
            Support::Piece(piece, at) => Some((piece, at)),
            Support::Corner(id) => self.out_of_corner(stance, &mut tip_force, id),
        };
        (tip_force, at)
    }

    /// The force at the tip of two contacts.
    fn tip_force_of(&self, both: &TwoContacts) -> TipForce {
        let shape = self.shape_of(both);
        let beta = wrap_angle(shape.force.angle() - shape.outer.slope - FRAC_PI_2);
        TipForce { q: shape.force.norm(), beta }
    }

    /// Where the whisker rests that may have come to `map_from_whisker` in any way: with its tip on the boundary
    /// nearest to where the unloaded one has it, on the way on which that one leans.
    pub(super) fn settled_at(&self, map_from_whisker: Pose2) -> Option<(Contact, Prediction)> {
        let stance = Stance::new(map_from_whisker, self.length);
        let nearest =
            |place: Vec2, reach: f64| self.boundaries.nearest(self.map, place, stance.base(), reach * self.length);
        let (piece, at, _) = nearest(stance.placed(Vec2::new(1.0, 0.0)), DEEPEST)?;
        let (piece, at) = self.bent_along(&stance, piece, at.clamp(0.0, 1.0))?;
        let lever = stance.seen(self.boundaries.spot((piece, at.clamp(0.0, 1.0))).position).y;
        let (touch, predicted) = self.rests_near(&stance, None, 1.5 * lever, piece, at.clamp(0.0, 1.0))?;
        self.rested(&stance, touch, predicted)
    }

    /// The place of the boundary that the tip of a whisker bent by a force across it reaches from this one on, on the way on which the
    /// unloaded whisker leans; none where a corner on the way would hold it.
    fn bent_along(&self, stance: &Stance, mut piece: u32, mut at: f64) -> Option<(u32, f64)> {
        let heading = Vec2::from_angle(stance.theta());
        // By how much a place is farther from the base than a force across the whisker has the tip, by the angle at which it is seen.
        let beyond = |piece: u32, at: f64| {
            let arm = self.boundaries.spot((piece, at)).position - stance.base();
            let polar = math::atan2(heading.cross(arm), heading.dot(arm));
            arm.norm() - (1.0 - BENT * polar * polar) * self.length
        };
        let forward = self.boundaries.spot((piece, at)).velocity.dot(heading) >= 0.0;
        for _ in 0..MOST_STRIDES {
            if beyond(piece, at) >= 0.0 {
                break;
            }
            let stride = STRIDE * self.length / self.boundaries.spot((piece, at)).velocity.norm();
            let next = at + if forward { stride } else { -stride };
            if (0.0..=1.0).contains(&next) {
                at = next;
                continue;
            }
            let end = if forward { 1.0 } else { 0.0 };
            let corner = self.boundaries.corner_of(piece, forward).filter(|(_, corner)| !corner.is_end());
            match corner {
                Some((_, corner)) if beyond(piece, end) < 0.0 => {
                    if corner.is_concave() && corner.turn.abs() > HOLDS {
                        return None;
                    }
                    (piece, at) = if forward { corner.after } else { corner.before };
                }
                _ => {
                    at = end;
                    break;
                }
            }
        }
        Some((piece, at))
    }

    /// The tip at rest, with the side where that has come to a boundary, too.
    fn rested(&self, stance: &Stance, touch: Contact, predicted: Prediction) -> Option<(Contact, Prediction)> {
        match self.cleared(stance, Contact { clear: 0.0, ..touch }, predicted) {
            Next::Touching(touch, predicted) => Some((touch, predicted)),
            _ => None,
        }
    }

    /// The piece along which a tip leaves a concave corner; none where nothing presses it into the corner.
    fn out_of_corner(&self, stance: &Stance, tip_force: &mut TipForce, id: u32) -> Option<(u32, f64)> {
        let corner = self.boundaries.corner(id)?;
        let placed = self.placed_at(tip_force.q, tip_force.beta, stance.seen(corner.position))?;
        *tip_force = TipForce { q: placed.q, beta: placed.beta };
        let force = force_on(stance, &placed);
        let pressed = |normal: f64| force.dot(Vec2::from_angle(normal)) > 0.0;
        let lean = corner.lean(force.angle());
        if lean < 0.5 && pressed(corner.normal) {
            Some(corner.before)
        } else if pressed(corner.normal + corner.turn) {
            Some(corner.after)
        } else {
            None
        }
    }

    /// The tip slides along the boundary, from this place of a piece on.
    fn slid(&self, stance: &Stance, mut tip_force: TipForce, mut piece: u32, mut at: f64) -> Slid {
        let (mut last, mut stride, mut halved) = (None, STRIDE * self.length, 0);
        let mut before = (piece, at);
        for _ in 0..MOST_STRIDES {
            let spot = self.boundaries.spot((piece, at));
            let Some(placed) = self.placed_at(tip_force.q, tip_force.beta, stance.seen(spot.position)) else {
                if halved == MOST_HALVED || before.0 != piece || last.is_none() {
                    let slope = self.mechanics.chart(tip_force.q, tip_force.beta).map_or(0.0, |chart| chart.slope);
                    let rests =
                        if last.is_none() { self.rests_near(stance, Some(tip_force), slope, piece, at) } else { None };
                    return rests.map_or(Slid::Off(tip_force), |(touch, predicted)| Slid::Rests(touch, predicted));
                }
                (at, stride, halved) = (0.5 * (at + before.1), 0.5 * stride, halved + 1);
                continue;
            };
            tip_force = TipForce { q: placed.q, beta: placed.beta };
            let force = force_on(stance, &placed);
            if force.dot(Vec2::from_angle(spot.normal)) <= 0.0 {
                return Slid::Off(tip_force);
            }
            if let Some(both) = self.run_into(stance, &placed, (piece, at)) {
                match self.both_slid(stance, &both, last) {
                    Some(BothSlid::Rests(touch, predicted)) => return Slid::Rests(touch, predicted),
                    Some(BothSlid::TipAlone(left, on)) if last.is_none() => {
                        tip_force = left;
                        (piece, at) = on;
                        continue;
                    }
                    _ => {}
                }
            }
            let speed = spot.velocity.norm();
            // The whisker pushes its tip against the force that holds it.
            let along = -force.dot(spot.velocity) / (speed * force.norm());
            let turned = last.is_some_and(|last: f64| along * last < 0.0);
            if along.abs() < UPRIGHT || turned || last.is_none() {
                match self.rests_near(stance, Some(tip_force), placed.slope(), piece, at) {
                    Some((touch, predicted)) => return Slid::Rests(touch, predicted),
                    None if turned => return Slid::Lost,
                    None => {}
                }
            }
            last = Some(along);
            before = (piece, at);
            at += stride / speed * along.signum();
            if (0.0..=1.0).contains(&at) {
                continue;
            }
            match self.turned_corner(stance, tip_force, placed.slope(), piece, at > 0.5) {
                Turned::Onto(over) => (piece, at) = over,
                Turned::Ends(end) => return end,
            }
        }
        Slid::Lost
    }

    /// The two contacts of a whisker whose side has come to a boundary while its tip slides here.
    fn run_into(&self, stance: &Stance, placed: &Placed, (piece, at): (u32, f64)) -> Option<TwoContacts> {
        if !self.follows_two() {
            return None;
        }
        let place = self.boundaries.spot((piece, at)).position;
        let hold = Hold::Tip(Support::Piece(piece, at));
        let touch = Contact { q: placed.q, beta: placed.beta, s: 1.0, hold, place, slope: placed.slope(), clear: 0.0 };
        match self.surroundings(stance, &touch) {
            Surroundings::Before(share, side) => self.with_inner(&touch, share, side),
            Surroundings::Clear(_) | Surroundings::Beyond(_) => None,
        }
    }

    /// The place across the corner at an end of a piece, or how the slide ends there.
    fn turned_corner(&self, stance: &Stance, tip_force: TipForce, slope: f64, piece: u32, forward: bool) -> Turned {
        let corner = self.boundaries.corner_of(piece, forward).filter(|(_, corner)| !corner.is_end());
        let Some((id, corner)) = corner else { return Turned::Ends(Slid::Off(tip_force)) };
        if corner.is_concave() {
            let (TipForce { q, beta }, hold) = (tip_force, Hold::Tip(Support::Corner(id)));
            let from = Contact { q, beta, s: 1.0, hold, place: corner.position, slope, clear: 0.0 };
            let caught = [from, Contact { q: 0.0, ..from }];
            if let Some((touch, predicted)) = caught.iter().find_map(|from| self.caught_in(stance, from, id)) {
                return Turned::Ends(Slid::Rests(touch, predicted));
            }
        }
        Turned::Onto(if forward { corner.after } else { corner.before })
    }

    /// An equilibrium near a place of a piece, the whisker's slope about this: from this force on, and from one along
    /// the normal there.
    pub(super) fn rests_near(
        &self,
        stance: &Stance,
        tip_force: Option<TipForce>,
        slope: f64,
        piece: u32,
        at: f64,
    ) -> Option<(Contact, Prediction)> {
        let spot = self.boundaries.spot((piece, at));
        let upright = wrap_angle(spot.normal - stance.theta() - slope - FRAC_PI_2);
        let lever = stance.seen(spot.position).y;
        let known = tip_force.into_iter().flat_map(|tip_force| [(tip_force.q, tip_force.beta), (tip_force.q, upright)]);
        let weak = (3.0 * lever / math::cos(upright), upright);
        known.chain([weak]).filter(|load| load.0 > 0.0).find_map(|(q, beta)| {
            let hold = Hold::Tip(Support::Piece(piece, at));
            let from = Contact { q, beta, s: 1.0, hold, place: spot.position, slope, clear: 0.0 };
            match self.along(stance, &from, piece, at, false) {
                Next::Touching(touch, predicted)
                    if touch.q > 0.0 && touch.place.distance(spot.position) <= NEAR * STRIDE * self.length =>
                {
                    Some((touch, predicted))
                }
                _ => None,
            }
        })
    }

    /// The whisker unbends until its tip meets a boundary: the force then, and where.
    fn flown(&self, stance: &Stance, tip_force: TipForce) -> Option<(TipForce, (u32, f64))> {
        let left = |share: f64| {
            let chart = self.mechanics.chart(share * tip_force.q, tip_force.beta)?;
            Some(stance.placed(chart.position))
        };
        let (share, at) = self.met_in_flight(&left)?;
        Some((TipForce { q: share * tip_force.q, ..tip_force }, at))
    }

    /// Where the tip of a whisker meets a boundary that comes off what its side lies on.
    fn fallen(&self, stance: &Stance, touch: &Contact) -> Option<(u32, f64)> {
        let left = |share: f64| {
            let chart = self.mechanics.chart(share * touch.q, touch.beta)?;
            Some(stance.placed(chart.position * touch.s + Vec2::from_angle(chart.slope) * (1.0 - touch.s)))
        };
        self.met_in_flight(&left).map(|(_, at)| at)
    }

    /// A force across the whisker that has its tip about at a place.
    pub(super) fn across_at(&self, stance: &Stance, (piece, at): (u32, f64)) -> TipForce {
        let lever = stance.seen(self.boundaries.spot((piece, at.clamp(0.0, 1.0))).position).y;
        TipForce { q: 3.0 * lever.abs(), beta: if lever < 0.0 { PI } else { 0.0 } }
    }

    /// Where a tip meets a boundary whose whisker unbends, and at which share of its force; by the tip's place at each share.
    fn met_in_flight(&self, left: &dyn Fn(f64) -> Option<Vec2>) -> Option<(f64, (u32, f64))> {
        let share = |step: f64| 1.0 - step / FLIGHT as f64;
        // Where it sets out it may still touch what it leaves.
        let mut before = (share(0.2), left(share(0.2))?);
        for step in 1..=FLIGHT {
            let next = (share(step as f64), left(share(step as f64))?);
            if self.map.crosses(before.1, next.1) {
                let (mut free, mut beyond) = (before, next.0);
                for _ in 0..HALVINGS {
                    let middle = 0.5 * (free.0 + beyond);
                    let place = left(middle)?;
                    if self.map.crosses(free.1, place) { beyond = middle } else { free = (middle, place) }
                }
                let (piece, at, _) = self.boundaries.nearest(self.map, left(beyond)?, free.1, REACH * self.length)?;
                return Some((beyond, (piece, at)));
            }
            before = next;
        }
        None
    }
}

/// The force on a tip that is held, map frame, dimensionless.
fn force_on(stance: &Stance, placed: &Placed) -> Vec2 {
    Vec2::from_angle(stance.direction(placed.slope(), placed.beta)) * placed.q
}
