//! One whisker over time: free, in one contact, or as a discrete rod where one contact does not say it all.

mod chain;
mod uncross;
mod view;

use super::discrete::DiscreteRod;
use super::{SimulateOptions, Solver};
use crate::contact::quasi_static::{
    Equilibrium, LoadedWhisker, Outcome, Step, WhiskerOnMap, between, blocked, first_touch, meets, onset,
};
use crate::contact::{Boundaries, Push};
use crate::flow::pose::{Event, StampedPose};
use crate::plane::{Pose2, Vec2, wrap_angle};
use crate::world::{Map, MountedWhisker};
use crate::{Error, Result, Stop};

/// The smallest share of a row's motion that is tried before the branch is said to end.
const LEAST_SHARE: f64 = 1.0 / 65536.0;
/// Changes between free and touching, grazes among them, that one row may see.
const MOST_CHANGES: usize = 100;
/// Longest way of the base (over L) and largest turn (rad) in one step.
const LARGEST_STEP: (f64, f64) = (0.05, 0.05);

/// What the whisker does.
#[derive(Debug)]
enum Body {
    Free,
    Held(Equilibrium),
    Chain(Box<DiscreteRod>),
    /// The base has run into a boundary; the last moment (N m) stays.
    Lost(f64),
}

/// What happened: kind and detail.
type Happened = Option<(&'static str, String)>;

/// What one whisker moves on, and how.
#[derive(Clone, Copy)]
pub(super) struct Scene<'a> {
    pub(super) map: &'a Map,
    pub(super) boundaries: &'a Boundaries,
    pub(super) whisker: &'a MountedWhisker,
    pub(super) loaded: &'a LoadedWhisker,
    pub(super) options: &'a SimulateOptions,
    pub(super) stop: &'a Stop,
}

/// One whisker on its way.
pub(super) struct Follower<'a> {
    map: &'a Map,
    boundaries: &'a Boundaries,
    whisker: &'a MountedWhisker,
    loaded: &'a LoadedWhisker,
    options: &'a SimulateOptions,
    stop: &'a Stop,
    /// Which sample of the path it goes to, from 1 on.
    sample: usize,
    t: f64,
    map_from_whisker: Pose2,
    body: Body,
    unsolved: bool,
    /// Moves of nodes since the discrete rod last rested.
    unrest: u64,
    /// The contact one step earlier, and how large that step was.
    earlier: Option<(Equilibrium, f64)>,
    /// How often the discrete rod has taken over since the whisker was free, and steps for which it now stays.
    takeovers: u32,
    patience: u32,
}

impl<'a> Follower<'a> {
    /// The whisker at its first pose, where it must be free.
    pub(super) fn start(scene: Scene<'a>, at: StampedPose) -> Result<Self> {
        let Scene { map, boundaries, whisker, loaded, options, stop } = scene;
        let map_from_whisker = at.map_from_robot.compose(whisker.robot_from_whisker);
        let tip = map_from_whisker.transform_point(loaded.rest[loaded.rest.len() - 1]);
        let base = map_from_whisker.position();
        let refused = |why: String| {
            Err(Error::usage(format!("the whisker {} does not start in free space", whisker.name))
                .value(why)
                .remedy("start the path where the unloaded whisker touches nothing"))
        };
        if let Some(place) = meets(map, &loaded.rest, map_from_whisker) {
            return refused(format!("it meets a boundary at {}; base {}, tip {}", show(place), show(base), show(tip)));
        }
        for (name, point) in [("base", base), ("tip", tip)] {
            if !map.is_free(point) {
                return refused(format!("its {name} {} is inside something solid", show(point)));
            }
        }
        let body = match options.solver {
            Solver::Auto => Body::Free,
            Solver::DiscreteRod => {
                Body::Chain(Box::new(DiscreteRod::new(&whisker.beam, options.links, map_from_whisker)?))
            }
        };
        Ok(Self {
            map,
            boundaries,
            whisker,
            loaded,
            options,
            stop,
            sample: 0,
            t: at.t,
            map_from_whisker,
            body,
            unsolved: false,
            unrest: 0,
            earlier: None,
            takeovers: 0,
            patience: 0,
        })
    }

    fn on(&self, map_from_whisker: Pose2) -> WhiskerOnMap<'a> {
        WhiskerOnMap::new(self.map, self.boundaries, self.loaded, map_from_whisker)
    }

    fn step(&self, map_from_whisker: Pose2) -> Step<'a> {
        Step { on: self.on(map_from_whisker), cone: self.whisker.friction.atan() }
    }

    /// Moves on to the next pose; somewhere on the way where it is asked to stop.
    pub(super) fn advance(&mut self, to: StampedPose, events: &mut Vec<Event>) -> Result<()> {
        self.sample += 1;
        let (from, start) = (self.map_from_whisker, self.t);
        let target = to.map_from_robot.compose(self.whisker.robot_from_whisker);
        let way = from.position().distance(target.position()) / (LARGEST_STEP.0 * self.loaded.beam.length);
        let most = 1.0 / way.max(wrap_angle(target.theta - from.theta).abs() / LARGEST_STEP.1).max(1.0);
        let mut leg = Leg { from, to: target, share: 0.0, most };
        let mut changes = 0;
        while leg.share < 1.0 && !self.stop.is_asked() {
            let happened = match self.body {
                Body::Free => self.wander(&mut leg)?,
                Body::Held(contact) => self.slide(contact, &mut leg)?,
                Body::Chain(_) => self.drag(&mut leg)?,
                Body::Lost(_) => self.wait(&mut leg),
            };
            if let Some((kind, what)) = happened {
                let t = start + leg.share * (to.t - start);
                events.push(Event { t, kind, detail: format!("{} {what}", self.whisker.name) });
                changes += 1;
            }
            changes += 1;
            if changes > MOST_CHANGES + (1.0 / most) as usize {
                // Something chatters within one row; the next row starts from here.
                leg.share = 1.0;
                self.unsolved(events, to.t, "keeps touching and leaving within one row");
            }
        }
        (self.map_from_whisker, self.t) = (target, to.t);
        Ok(())
    }

    fn unsolved(&mut self, events: &mut Vec<Event>, t: f64, what: &str) {
        events.push(Event { t, kind: "unsolved", detail: format!("{} {what}", self.whisker.name) });
    }

    /// The free whisker until it touches or the row ends.
    fn wander(&mut self, leg: &mut Leg) -> Result<Happened> {
        let here = leg.at(leg.share);
        self.takeovers = 0;
        let Some(touching) = first_touch(self.map, &self.loaded.rest, here, leg.to) else {
            leg.share = 1.0;
            return Ok(None);
        };
        leg.share = leg.within(touching);
        let pose = leg.at(leg.share);
        let Some(contact) = onset(&self.on(pose)) else {
            return self.relax(self.unloaded(here)?, leg, "touches");
        };
        let what = if contact.load.s >= 1.0 { "touches with its tip" } else { "touches with its side" };
        let step = leg.most.min(1.0 - leg.share);
        if step <= 0.0 {
            // The touch came with the very end of the row: the next row presses on.
            return Ok(None);
        }
        let mut part = step;
        while part > LEAST_SHARE * step {
            match self.step(leg.at(leg.share + part)).next(&contact) {
                Outcome::Touching(next) if !self.is_blocked(&next, leg.at(leg.share + part)) => {
                    leg.share = leg.reached(part);
                    self.body = Body::Held(next);
                    return Ok(Some(("onset", what.into())));
                }
                // It grazes: within the tolerance of the look-up it has not touched yet, or has left again.
                Outcome::LiftOff => {
                    leg.share = leg.reached(part);
                    return Ok(None);
                }
                Outcome::Touching(_) | Outcome::Ends(_) => part *= 0.5,
            }
        }
        let rod = self.unloaded(here)?;
        self.relax(rod, leg, "touches")
    }

    /// The touching whisker until something happens or the row ends.
    fn slide(&mut self, mut contact: Equilibrium, leg: &mut Leg) -> Result<Happened> {
        let mut step = leg.most.min(1.0 - leg.share);
        while leg.share < 1.0 {
            let target = leg.reached(step);
            let (before, last) = self.earlier.as_ref().map_or((None, 1.0), |(before, last)| (Some(before), *last));
            let why = match self.step(leg.at(target)).next_after(before, &contact, step / last) {
                Outcome::Touching(next) if !self.is_blocked(&next, leg.at(target)) => {
                    self.earlier = Some((contact, step));
                    contact = next;
                    leg.share = target;
                    step = (2.0 * step).min(leg.most);
                    continue;
                }
                Outcome::Touching(_) => "touches a second time",
                Outcome::LiftOff => {
                    leg.share = target;
                    self.body = Body::Free;
                    return Ok(Some(("lift_off", "leaves the boundary".into())));
                }
                Outcome::Ends(why) => why,
            };
            step *= 0.5;
            if step < LEAST_SHARE {
                let rod = self.chain(&contact, leg.at(leg.share))?;
                return self.relax(rod, leg, why);
            }
        }
        let before = match self.body {
            Body::Held(before) => before.load.s >= 1.0,
            _ => contact.load.s >= 1.0,
        };
        self.body = Body::Held(contact);
        let now = contact.load.s >= 1.0;
        Ok(match (before, now) {
            (true, false) => Some(("side_contact", "goes over from its tip to its side".into())),
            (false, true) => Some(("tip_contact", "goes over from its side to its tip".into())),
            _ => None,
        })
    }

    /// Whether the bent whisker meets a boundary elsewhere.
    fn is_blocked(&self, contact: &Equilibrium, pose: Pose2) -> bool {
        let Some(bend) = self.loaded.bend(contact.load) else { return true };
        blocked(&self.on(pose), &bend, Push::of(contact.load.beta)).is_some()
    }

    /// A whisker that was lost until it is clear of everything again.
    fn wait(&mut self, leg: &mut Leg) -> Happened {
        leg.share = leg.reached(1.0 - leg.share);
        let pose = leg.to;
        let clear = meets(self.map, &self.loaded.rest, pose).is_none() && self.map.is_free(pose.position());
        if !clear {
            return None;
        }
        self.body = Body::Free;
        Some(("found", "is free again".into()))
    }
}

/// The way of a whisker from one row to the next.
struct Leg {
    from: Pose2,
    to: Pose2,
    /// How much of it is done.
    share: f64,
    /// The most that one step takes.
    most: f64,
}

impl Leg {
    fn at(&self, share: f64) -> Pose2 {
        between(self.from, self.to, share)
    }

    /// The share after a step, the whole where rounding would leave a rest.
    fn reached(&self, step: f64) -> f64 {
        if step >= 1.0 - self.share { 1.0 } else { self.share + step }
    }

    /// The share at a part of the rest.
    fn within(&self, part: f64) -> f64 {
        if part >= 1.0 { 1.0 } else { self.share + part * (1.0 - self.share) }
    }
}

fn show(p: Vec2) -> String {
    format!("({:.6}, {:.6}) m", p.x, p.y)
}
