//! Where a whisker comes to rest that has lost its equilibrium.
//!
//! Off a corner that held the tip, or past a fold of the branch that it followed, a whisker snaps. It is light and damped:
//! what it costs to bend it until the tip is at a place only falls on the way. A tip on a boundary slides to where the
//! boundary does not push it along any more; one that would have to be pulled there flies towards where the unloaded
//! whisker has it, up to the next boundary. The rest of the whisker is looked at where it has come to rest.

use super::both::Rest;
use super::tip::Placed;
use super::{Felt, Forward, Hold, Next, Stance, Touch};
use crate::plane::{Pose2, Vec2, wrap_angle};
use core::f64::consts::FRAC_PI_2;

/// Below this force a whisker has nothing to snap with.
const WEAK: f64 = 0.02;
/// How far a tip slides from one look to the next (whisker lengths), and how often it is looked at.
const STRIDE: f64 = 0.02;
const MOST_STRIDES: usize = 150;
/// From this slant of the force on (share of it along the boundary) an equilibrium is looked for, within so many strides.
const UPRIGHT: f64 = 0.5;
const NEAR: f64 = 3.0;
/// A stride after which nothing holds the tip is halved so often.
const MOST_HALVED: u32 = 5;
/// Looks at a whisker that unbends, and halvings that find where it meets a boundary.
const FLIGHT: usize = 24;
const HALVINGS: usize = 10;
/// How far beside the boundary what meets it is, at most (whisker lengths).
const REACH: f64 = 0.05;
/// How deep in a boundary the tip of the unloaded whisker may be for what rests there to be found (whisker lengths).
const DEEPEST: f64 = 0.4;
/// A tip that a force across it has pushed to a small polar angle is nearer to the base than a straight one by this share of
/// its square; rounds that find such a place on a boundary.
const BENT: f64 = 0.09;
const BENT_ROUNDS: usize = 4;
/// Flights before it is given up.
const MOST_FLIGHTS: usize = 3;

/// The force at the tip that holds the whisker for a moment.
#[derive(Clone, Copy)]
struct Grip {
    q: f64,
    beta: f64,
}

/// How a slide of the tip ends.
enum Slid {
    Rests(Touch, Felt),
    /// Off the boundary, under this force.
    Off(Grip),
    Lost,
}

impl Forward<'_> {
    /// Where the whisker comes to rest that was held so and is now at `map_from_whisker`; none where it is free then, or
    /// meets a boundary with its side.
    pub(super) fn spring(&self, touch: &Touch, map_from_whisker: Pose2) -> Option<(Touch, Felt)> {
        if touch.q < WEAK {
            return None;
        }
        let stance = Stance::new(map_from_whisker, self.length);
        let mut grip = Grip { q: touch.q, beta: touch.beta };
        let mut at = match touch.hold {
            Hold::Piece(piece, at) => Some((piece, at)),
            Hold::Corner(id) => self.out_of_corner(&stance, &mut grip, id),
            Hold::Both(both) => {
                grip = Grip { q: touch.q, beta: 0.0 };
                match both.tip {
                    Rest::Piece(piece, at) => Some((piece, at)),
                    Rest::Corner(id) => self.out_of_corner(&stance, &mut grip, id),
                }
            }
            Hold::Vertex(_) | Hold::Flank(..) => {
                grip.q /= touch.s * touch.s;
                None
            }
        };
        for _ in 0..MOST_FLIGHTS {
            if let Some((piece, there)) = at {
                match self.slid(&stance, grip, piece, there.clamp(0.0, 1.0)) {
                    Slid::Rests(touch, felt) => return self.rested(&stance, touch, felt),
                    Slid::Off(left) => grip = left,
                    Slid::Lost => return None,
                }
            }
            (grip, at) = self.flown(&stance, grip).map(|(grip, at)| (grip, Some(at)))?;
        }
        None
    }

    /// Where the whisker rests that may have come to `map_from_whisker` in any way: with its tip on the boundary nearest to
    /// where the unloaded one has it, on the way on which that one leans.
    pub(super) fn settled_at(&self, map_from_whisker: Pose2) -> Option<(Touch, Felt)> {
        let stance = Stance::new(map_from_whisker, self.length);
        let nearest = |place: Vec2, reach: f64| self.ground.nearest(self.map, place, stance.base, reach * self.length);
        let (piece, at, _) = nearest(stance.placed(Vec2::new(1.0, 0.0)), DEEPEST)?;
        let foot = self.ground.pieces[piece as usize].spot(at.clamp(0.0, 1.0));
        // How near to its base a force across it has the tip, by the angle at which it is seen from there.
        let arm = foot.position - stance.base;
        let heading = Vec2::from_angle(stance.theta);
        let along = foot.velocity * (1.0 / foot.velocity.norm());
        let along = along * along.dot(heading).signum();
        let (half, mut way) = (arm.dot(along), 0.0);
        for _ in 0..BENT_ROUNDS {
            let seen = arm + along * way;
            let polar = heading.cross(seen).atan2(heading.dot(seen));
            let chord = (1.0 - BENT * polar * polar) * self.length;
            let rest = arm.norm_squared() - chord * chord;
            way = if rest < half * half { (half * half - rest).sqrt() - half } else { 0.0 };
        }
        let (piece, at, _) = nearest(foot.position + along * way, REACH)?;
        let lever = stance.seen(self.ground.pieces[piece as usize].spot(at.clamp(0.0, 1.0)).position - stance.base).y;
        let (touch, felt) = self.rests_near(&stance, None, 1.5 * lever, piece, at.clamp(0.0, 1.0))?;
        self.rested(&stance, touch, felt)
    }

    /// The tip at rest, with the side where that has come to a boundary, too.
    fn rested(&self, stance: &Stance, touch: Touch, felt: Felt) -> Option<(Touch, Felt)> {
        match self.cleared(stance, Touch { clear: 0.0, ..touch }, felt) {
            Next::Touching(touch, felt) => Some((touch, felt)),
            _ => None,
        }
    }

    /// The piece along which a tip leaves a concave corner; none where nothing presses it into the corner.
    fn out_of_corner(&self, stance: &Stance, grip: &mut Grip, id: u32) -> Option<(u32, f64)> {
        let corner = self.ground.corner(id)?;
        let placed = self.placed_at(grip.q, grip.beta, stance.seen(corner.position - stance.base))?;
        *grip = Grip { q: placed.q, beta: placed.beta };
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
    fn slid(&self, stance: &Stance, mut grip: Grip, mut piece: u32, mut at: f64) -> Slid {
        let (mut last, mut stride, mut halved) = (None, STRIDE * self.length, 0);
        let mut before = (piece, at);
        for _ in 0..MOST_STRIDES {
            let ground = &self.ground.pieces[piece as usize];
            let spot = ground.spot(at);
            let Some(placed) = self.placed_at(grip.q, grip.beta, stance.seen(spot.position - stance.base)) else {
                if halved == MOST_HALVED || before.0 != piece || last.is_none() {
                    let slope = self.solver.chart(grip.q, grip.beta).map_or(0.0, |chart| chart.slope);
                    let rests =
                        if last.is_none() { self.rests_near(stance, Some(grip), slope, piece, at) } else { None };
                    return rests.map_or(Slid::Off(grip), |(touch, felt)| Slid::Rests(touch, felt));
                }
                (at, stride, halved) = (0.5 * (at + before.1), 0.5 * stride, halved + 1);
                continue;
            };
            grip = Grip { q: placed.q, beta: placed.beta };
            let force = force_on(stance, &placed);
            if force.dot(Vec2::from_angle(spot.normal)) <= 0.0 {
                return Slid::Off(grip);
            }
            let speed = spot.velocity.norm();
            // The whisker pushes its tip against the force that holds it.
            let along = -force.dot(spot.velocity) / (speed * force.norm());
            let turned = last.is_some_and(|last: f64| along * last < 0.0);
            if along.abs() < UPRIGHT || turned || last.is_none() {
                match self.rests_near(stance, Some(grip), placed.slope(), piece, at) {
                    Some((touch, felt)) => return Slid::Rests(touch, felt),
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
            let forward = at > 0.5;
            let Some((id, corner)) = self.ground.corner_of(piece, forward).filter(|(_, corner)| !corner.is_end())
            else {
                return Slid::Off(grip);
            };
            if corner.is_concave() {
                let Grip { q, beta } = grip;
                let place = corner.position;
                let from = Touch { q, beta, s: 1.0, hold: Hold::Corner(id), place, slope: placed.slope(), clear: 0.0 };
                let caught = [from, Touch { q: 0.0, ..from }];
                if let Some((touch, felt)) = caught.iter().find_map(|from| self.caught_in(stance, from, id)) {
                    return Slid::Rests(touch, felt);
                }
            }
            (piece, at) = if forward { corner.after } else { corner.before };
        }
        Slid::Lost
    }

    /// An equilibrium near a place of a piece, the whisker's slope about this: from this force on, and from one along the normal
    /// there.
    fn rests_near(
        &self,
        stance: &Stance,
        grip: Option<Grip>,
        slope: f64,
        piece: u32,
        at: f64,
    ) -> Option<(Touch, Felt)> {
        let spot = self.ground.pieces[piece as usize].spot(at);
        let upright = wrap_angle(spot.normal - stance.theta - slope - FRAC_PI_2);
        let lever = stance.seen(spot.position - stance.base).y;
        let known = grip.into_iter().flat_map(|grip| [(grip.q, grip.beta), (grip.q, upright)]);
        let weak = (3.0 * lever / upright.cos(), upright);
        known.chain([weak]).filter(|load| load.0 > 0.0).find_map(|(q, beta)| {
            let hold = Hold::Piece(piece, at);
            let from = Touch { q, beta, s: 1.0, hold, place: spot.position, slope, clear: 0.0 };
            match self.along(stance, &from, piece, at, false) {
                Next::Touching(touch, felt)
                    if touch.q > 0.0 && touch.place.distance(spot.position) <= NEAR * STRIDE * self.length =>
                {
                    Some((touch, felt))
                }
                _ => None,
            }
        })
    }

    /// The whisker unbends until its tip meets a boundary: the force then, and where.
    fn flown(&self, stance: &Stance, grip: Grip) -> Option<(Grip, (u32, f64))> {
        let left = |share: f64| {
            let chart = self.solver.chart(share * grip.q, grip.beta)?;
            Some(stance.placed(chart.position))
        };
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
                let (piece, at, _) = self.ground.nearest(self.map, left(beyond)?, free.1, REACH * self.length)?;
                return Some((Grip { q: beyond * grip.q, ..grip }, (piece, at)));
            }
            before = next;
        }
        None
    }
}

/// The force on a tip that is held, map frame, dimensionless.
fn force_on(stance: &Stance, placed: &Placed) -> Vec2 {
    Vec2::from_angle(stance.theta + placed.slope() + placed.beta + FRAC_PI_2) * placed.q
}
