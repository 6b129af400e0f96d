//! One whisker over time: onset, sliding, corners, lift-off, snap.

use super::TipTouch;
use super::equilibrium::{OnPiece, Stance, TipLoadState};
use super::foothold::{Foothold, Joint};
use super::touch::{FreeWay, between, first_touch, side_touch};
use crate::flow::pose::{Event, StampedPose};
use crate::plane::{Pose2, Vec2, wrap_angle};
use crate::world::{Map, MountedWhisker};
use crate::{Error, Result};
use core::f64::consts::FRAC_PI_2;

/// The smallest share of a row's motion that is tried before the branch is said to end.
const LEAST_SHARE: f64 = 1.0 / 65536.0;
/// Largest travel of the tip along the boundary in one step of the continuation, over the whisker's length.
const LARGEST_SLIDE: f64 = 0.03;
/// Largest turn of the tip in one step of the continuation (rad).
const LARGEST_TURN: f64 = 0.2;
/// Pieces of a boundary that one step may pass.
const MOST_PIECES: usize = 200;
/// Changes between free and touching, grazes among them, that one row may see.
const MOST_CHANGES: usize = 100;
/// How far beyond its ends a piece still counts (share of the piece).
const END_SLACK: f64 = 1e-9;

/// What holds the tip.
#[derive(Clone, Copy, Debug)]
enum Hold {
    Piece(Foothold),
    Corner(Joint),
}

/// A whisker in contact.
#[derive(Clone, Copy, Debug)]
struct Contact {
    load: TipLoadState,
    hold: Hold,
    tip: Vec2,
    slope: f64,
}

/// What a step of the continuation found.
enum Next {
    Touching(Contact),
    /// The boundary would have to pull, or the tip slid off the end of a wall.
    LiftOff(&'static str),
    None,
}

/// One whisker on its way.
pub(super) struct Follower<'a> {
    map: &'a Map,
    whisker: &'a MountedWhisker,
    t: f64,
    map_from_whisker: Pose2,
    contact: Option<Contact>,
}

impl<'a> Follower<'a> {
    /// The whisker at its first pose, where it must be free.
    pub(super) fn start(map: &'a Map, whisker: &'a MountedWhisker, at: StampedPose) -> Result<Self> {
        let map_from_whisker = at.map_from_robot.compose(whisker.robot_from_whisker);
        let follower = Self { map, whisker, t: at.t, map_from_whisker, contact: None };
        let (base, tip) = (map_from_whisker.position(), follower.straight_tip(map_from_whisker));
        if map.crosses(base, tip) || !map.is_free(base) || !map.is_free(tip) {
            return Err(Error::usage(format!("the whisker {} does not start in free space", whisker.name))
                .value(format!("base {}, tip {}", show(base), show(tip)))
                .remedy("start the path where the straight whisker touches nothing"));
        }
        Ok(follower)
    }

    fn straight_tip(&self, map_from_whisker: Pose2) -> Vec2 {
        map_from_whisker.transform_point(Vec2::new(self.whisker.beam.length, 0.0))
    }

    fn stance(&self, map_from_whisker: Pose2) -> Stance<'a> {
        Stance { map: self.map, beam: &self.whisker.beam, map_from_whisker }
    }

    /// Moves on to the next pose.
    pub(super) fn advance(&mut self, to: StampedPose, events: &mut Vec<Event>) -> Result<()> {
        let (from, start) = (self.map_from_whisker, self.t);
        let target = to.map_from_robot.compose(self.whisker.robot_from_whisker);
        let mut share = 0.0;
        let mut changes = 0;
        while share < 1.0 {
            self.t = start + share * (to.t - start);
            let event = if self.contact.is_some() {
                self.slide(from, target, &mut share)
            } else {
                self.wander(from, target, &mut share)?
            };
            if let Some((kind, what)) = event {
                let t = start + share * (to.t - start);
                events.push(Event { t, kind, detail: format!("{} {what}", self.whisker.name) });
            }
            changes += 1;
            if changes > MOST_CHANGES {
                return Err(self.fault("keeps touching and leaving within one row", self.tip()));
            }
        }
        (self.map_from_whisker, self.t) = (target, to.t);
        self.check_side()
    }

    /// The free whisker until it touches or the row ends.
    fn wander(&mut self, from: Pose2, to: Pose2, share: &mut f64) -> Result<Option<(&'static str, &'static str)>> {
        let here = between(from, to, *share);
        let there = |part: f64, share: f64| if part >= 1.0 { 1.0 } else { share + part * (1.0 - share) };
        match first_touch(self.map, self.whisker.beam.length, here, to) {
            FreeWay::Clear => *share = 1.0,
            FreeWay::Side(part) => {
                let pose = between(from, to, there(part, *share));
                return Err(self.fault("touches with its side", self.straight_tip(pose)));
            }
            FreeWay::Tip(part, foothold) => {
                *share = there(part, *share);
                let stance = self.stance(between(from, to, *share));
                let load = stance.untouched(&foothold);
                let tip = foothold.ground(self.map).position;
                self.contact = Some(Contact { load, hold: Hold::Piece(foothold), tip, slope: 0.0 });
                return Ok(self.press(from, to, share)?.then_some(("onset", "touches with its tip")));
            }
        }
        Ok(None)
    }

    /// The first step in contact: whether the tip stays on the boundary. If not, it goes on free a little further.
    fn press(&mut self, from: Pose2, to: Pose2, share: &mut f64) -> Result<bool> {
        let Some(contact) = self.contact.take() else { return Ok(false) };
        let mut step = 1.0 - *share;
        while step > LEAST_SHARE * (1.0 - *share) {
            match self.next(&contact, between(from, to, *share + step)) {
                Next::Touching(next) => {
                    *share = if step >= 1.0 - *share { 1.0 } else { *share + step };
                    self.contact = Some(next);
                    return Ok(true);
                }
                // It grazes: within the tolerance of the look-up it has not touched yet, or has left again.
                Next::LiftOff(_) => {
                    *share += step;
                    return Ok(false);
                }
                Next::None => step *= 0.5,
            }
        }
        if *share >= 1.0 {
            // The touch came with the very end of the row: the next row presses on.
            return Ok(false);
        }
        Err(self.fault("meets a boundary head-on and finds no equilibrium", contact.tip))
    }

    /// The touching whisker until it is free or the row ends.
    fn slide(&mut self, from: Pose2, to: Pose2, share: &mut f64) -> Option<(&'static str, &'static str)> {
        let mut contact = self.contact?;
        let mut step = 1.0 - *share;
        while *share < 1.0 {
            let target = if *share + step >= 1.0 { 1.0 } else { *share + step };
            match self.next(&contact, between(from, to, target)) {
                Next::Touching(next) => {
                    contact = next;
                    *share = target;
                    step *= 2.0;
                }
                Next::LiftOff(what) => {
                    *share = target;
                    self.contact = None;
                    return Some(("lift_off", what));
                }
                Next::None => {
                    step *= 0.5;
                    if step < LEAST_SHARE {
                        self.contact = None;
                        return Some(("snap", "loses its equilibrium and snaps free"));
                    }
                }
            }
        }
        self.contact = Some(contact);
        None
    }

    /// The equilibrium after a small motion to `map_from_whisker`, near enough to the one before to be its continuation.
    fn next(&self, contact: &Contact, map_from_whisker: Pose2) -> Next {
        let stance = self.stance(map_from_whisker);
        let next = match contact.hold {
            Hold::Piece(foothold) => self.along(&stance, contact.load, foothold),
            Hold::Corner(joint) => self.caught(&stance, contact.load, &joint),
        };
        match next {
            Next::Touching(next)
                if next.tip.distance(contact.tip) > LARGEST_SLIDE * self.whisker.beam.length
                    || (next.slope - contact.slope).abs() > LARGEST_TURN =>
            {
                Next::None
            }
            other => other,
        }
    }

    /// From piece to piece until one holds the tip.
    fn along(&self, stance: &Stance<'_>, load: TipLoadState, start: Foothold) -> Next {
        let mut foothold = start;
        let mut came: Option<bool> = None;
        for _ in 0..MOST_PIECES {
            let found = match stance.on_piece(load, foothold) {
                OnPiece::Found { stable: true, load, foothold } => (Some(load), foothold),
                OnPiece::Found { stable: false, .. } | OnPiece::Failed => return Next::None,
                OnPiece::Lost(foothold) => (None, foothold),
            };
            let (solution, at) = (found.0, found.1.at);
            if (-END_SLACK..=1.0 + END_SLACK).contains(&at) {
                return solution.map_or(Next::None, |load| self.settle(stance, load, Hold::Piece(found.1)));
            }
            let forward = at > 0.5;
            let Some(joint) = foothold.joint(self.map, forward) else {
                return Next::LiftOff("slides off the end of a wall");
            };
            if came.is_some_and(|came| came != forward) {
                return Next::None;
            }
            // Coming from one side, the corner is met before the other side. A weak force all but cannot be caught:
            // its direction turns at once, and the corner may find no solution at all.
            if joint.is_concave()
                && let Some((held, lean)) = stance.in_corner(load, &joint)
            {
                match lean {
                    0.0..=1.0 => return self.settle(stance, held, Hold::Corner(joint)),
                    _ if (lean > 1.0) != forward => return Next::None,
                    _ => {}
                }
            }
            came = Some(forward);
            foothold = if forward { joint.after } else { joint.before };
        }
        Next::None
    }

    /// In the corner, or out of it along one of its sides.
    fn caught(&self, stance: &Stance<'_>, load: TipLoadState, joint: &Joint) -> Next {
        match stance.in_corner(load, joint) {
            Some((_, lean)) if lean < 0.0 => self.along(stance, load, joint.before),
            Some((_, lean)) if lean > 1.0 => self.along(stance, load, joint.after),
            Some((held, _)) => self.settle(stance, held, Hold::Corner(*joint)),
            None => Next::None,
        }
    }

    fn settle(&self, stance: &Stance<'_>, load: TipLoadState, hold: Hold) -> Next {
        if load.q < 0.0 {
            return Next::LiftOff("leaves the boundary");
        }
        match stance.bend(load) {
            Some(bend) => {
                let tip = stance.map_from_whisker.transform_point(bend.contact);
                Next::Touching(Contact { load, hold, tip, slope: bend.phi_a })
            }
            None => Next::None,
        }
    }

    /// Refuses contact with the whisker's side at the present pose.
    fn check_side(&self) -> Result<()> {
        let Some(contact) = self.contact else { return Ok(()) };
        let stance = self.stance(self.map_from_whisker);
        let Some(bend) = stance.bend(contact.load) else { return Ok(()) };
        let normal = match contact.hold {
            Hold::Piece(foothold) => foothold.ground(self.map).normal,
            Hold::Corner(joint) => joint.normal + 0.5 * joint.turn,
        };
        match side_touch(&stance, &bend, normal) {
            Some(place) => Err(self.fault("touches with its side", place)),
            None => Ok(()),
        }
    }

    fn fault(&self, what: &str, place: Vec2) -> Error {
        Error::usage(format!("the whisker {} {what} at t = {:.6} s", self.whisker.name, self.t))
            .value(format!("near {}", show(place)))
            .remedy("this simulator handles tip contact only; choose another path")
    }

    fn tip(&self) -> Vec2 {
        self.contact.map_or_else(|| self.straight_tip(self.map_from_whisker), |contact| contact.tip)
    }

    /// The moment at the base now (N m).
    pub(super) fn moment(&self) -> f64 {
        let stance = self.stance(self.map_from_whisker);
        self.contact.and_then(|contact| stance.bend(contact.load)).map_or(0.0, |bend| bend.moment)
    }

    /// The contact now.
    pub(super) fn touch(&self, row: usize, whisker: usize) -> Option<TipTouch> {
        let contact = self.contact?;
        let bend = self.stance(self.map_from_whisker).bend(contact.load)?;
        let direction = wrap_angle(self.map_from_whisker.theta + bend.phi_a + bend.beta + FRAC_PI_2);
        let force = bend.force * Vec2::from_angle(direction);
        Some(TipTouch { t: self.t, row, whisker, position: contact.tip, force, energy: bend.energy() })
    }
}

fn show(p: Vec2) -> String {
    format!("({:.6}, {:.6}) m", p.x, p.y)
}
