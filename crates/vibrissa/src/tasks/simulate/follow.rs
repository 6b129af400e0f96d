//! One whisker over time: free, in one contact, or as a discrete rod where one contact does not say it all.

use super::contact::{Contact, Hold, Next, Step, WALL_END};
use super::discrete::{DiscreteRod, REACH, Relaxed};
use super::equilibrium::Stance;
use super::flex::{Flex, Load};
use super::foothold::Foothold;
use super::report::{Grip, Part, Touch};
use super::touch::{between, blocked, first_touch, meets, onset, side_hold};
use super::{SimulateOptions, Solver};
use crate::flow::pose::{Event, StampedPose};
use crate::plane::{Pose2, Vec2, wrap_angle};
use crate::world::{Map, MountedWhisker};
use crate::{Error, Result};
use core::f64::consts::{FRAC_PI_2, PI};

/// The smallest share of a row's motion that is tried before the branch is said to end.
const LEAST_SHARE: f64 = 1.0 / 65536.0;
/// Share of a row in which a whisker that has lost its equilibrium finds another.
const SNAP_SHARE: f64 = 1e-3;
/// Changes between free and touching, grazes among them, that one row may see.
const MOST_CHANGES: usize = 100;
/// How often a discrete rod that is still moving is given more time.
const MORE_TIME: usize = 3;
/// The discrete rod stays for up to two to this power steps when it keeps taking over.
const LONGEST_STAY: u32 = 6;
/// Longest way of the base (over L) and largest turn (rad) in one step.
const LARGEST_STEP: (f64, f64) = (0.05, 0.05);
/// Distance at which a discrete rod starts beside what it touches, over L.
const APART: f64 = 3.0 * REACH;
/// How far one contact may differ from the discrete rod that it replaces: place and slope (over L, rad), and moment relative.
const ALIKE: (f64, f64) = (0.03, 0.03);

/// What the whisker does.
#[derive(Debug)]
enum Body {
    Free,
    Held(Contact),
    Chain(Box<DiscreteRod>),
    /// The base has run into a boundary; the last moment (N m) stays.
    Lost(f64),
}

/// What happened: kind and detail.
type Happened = Option<(&'static str, String)>;

/// One whisker on its way.
pub(super) struct Follower<'a> {
    map: &'a Map,
    whisker: &'a MountedWhisker,
    flex: &'a Flex,
    options: &'a SimulateOptions,
    t: f64,
    map_from_whisker: Pose2,
    body: Body,
    unsolved: bool,
    /// The contact one step earlier, and how large that step was.
    earlier: Option<(Contact, f64)>,
    /// How often the discrete rod has taken over since the whisker was free, and steps for which it now stays.
    takeovers: u32,
    patience: u32,
}

impl<'a> Follower<'a> {
    /// The whisker at its first pose, where it must be free.
    pub(super) fn start(
        map: &'a Map,
        whisker: &'a MountedWhisker,
        flex: &'a Flex,
        options: &'a SimulateOptions,
        at: StampedPose,
    ) -> Result<Self> {
        let map_from_whisker = at.map_from_robot.compose(whisker.robot_from_whisker);
        let tip = map_from_whisker.transform_point(flex.rest[flex.rest.len() - 1]);
        let base = map_from_whisker.position();
        let refused = |why: String| {
            Err(Error::usage(format!("the whisker {} does not start in free space", whisker.name))
                .value(why)
                .remedy("start the path where the unloaded whisker touches nothing"))
        };
        if let Some(place) = meets(map, &flex.rest, map_from_whisker) {
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
            whisker,
            flex,
            options,
            t: at.t,
            map_from_whisker,
            body,
            unsolved: false,
            earlier: None,
            takeovers: 0,
            patience: 0,
        })
    }

    fn stance(&self, map_from_whisker: Pose2) -> Stance<'a> {
        Stance { map: self.map, flex: self.flex, map_from_whisker }
    }

    fn step(&self, map_from_whisker: Pose2) -> Step<'a> {
        Step { stance: self.stance(map_from_whisker), cone: self.whisker.friction.atan() }
    }

    /// Moves on to the next pose.
    pub(super) fn advance(&mut self, to: StampedPose, events: &mut Vec<Event>) -> Result<()> {
        let (from, start) = (self.map_from_whisker, self.t);
        let target = to.map_from_robot.compose(self.whisker.robot_from_whisker);
        let way = from.position().distance(target.position()) / (LARGEST_STEP.0 * self.flex.beam.length);
        let most = 1.0 / way.max(wrap_angle(target.theta - from.theta).abs() / LARGEST_STEP.1).max(1.0);
        let mut leg = Leg { from, to: target, share: 0.0, most };
        let mut changes = 0;
        while leg.share < 1.0 {
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
        let Some(touching) = first_touch(self.map, &self.flex.rest, here, leg.to) else {
            leg.share = 1.0;
            return Ok(None);
        };
        leg.share = leg.within(touching);
        let pose = leg.at(leg.share);
        let Some(contact) = onset(&self.stance(pose)) else {
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
                Next::Touching(next) if !self.is_blocked(&next, leg.at(leg.share + part)) => {
                    leg.share = leg.reached(part);
                    self.body = Body::Held(next);
                    return Ok(Some(("onset", what.into())));
                }
                // It grazes: within the tolerance of the look-up it has not touched yet, or has left again.
                Next::LiftOff => {
                    leg.share = leg.reached(part);
                    return Ok(None);
                }
                Next::Touching(_) | Next::Ends(_) => part *= 0.5,
            }
        }
        let rod = self.unloaded(here)?;
        self.relax(rod, leg, "touches")
    }

    /// The touching whisker until something happens or the row ends.
    fn slide(&mut self, mut contact: Contact, leg: &mut Leg) -> Result<Happened> {
        let mut step = leg.most.min(1.0 - leg.share);
        while leg.share < 1.0 {
            let target = leg.reached(step);
            let (before, last) = self.earlier.as_ref().map_or((None, 1.0), |(before, last)| (Some(before), *last));
            let why = match self.step(leg.at(target)).next_after(before, &contact, step / last) {
                Next::Touching(next) if !self.is_blocked(&next, leg.at(target)) => {
                    self.earlier = Some((contact, step));
                    contact = next;
                    leg.share = target;
                    step = (2.0 * step).min(leg.most);
                    continue;
                }
                Next::Touching(_) => "touches a second time",
                Next::LiftOff => {
                    leg.share = target;
                    self.body = Body::Free;
                    return Ok(Some(("lift_off", "leaves the boundary".into())));
                }
                Next::Ends(why) => why,
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
    fn is_blocked(&self, contact: &Contact, pose: Pose2) -> bool {
        let stance = self.stance(pose);
        let Some(bend) = self.flex.bend(contact.load) else { return true };
        let lay = if contact.load.beta.cos() >= 0.0 { 0.0 } else { PI };
        blocked(&stance, &bend, lay).is_some()
    }

    /// The discrete rod without load at this pose, a little away from what it touches.
    fn unloaded(&self, pose: Pose2) -> Result<DiscreteRod> {
        let mut rod = DiscreteRod::new(&self.whisker.beam, self.options.links, pose)?;
        let apart = APART * self.flex.beam.length;
        let nodes = rod.nodes().to_vec();
        for times in [0.0, 1.0, 10.0, 100.0, 1000.0] {
            // The free side is where the base is; a boundary beside the whisker may be on either.
            for turn in [PI, FRAC_PI_2, -FRAC_PI_2] {
                rod.pose(pose, pushed_off(nodes.clone(), Vec2::from_angle(pose.theta + turn) * (times * apart)));
                if rod.is_clear(self.map) && rod.clearance(self.map, apart) >= 0.3 * apart {
                    return Ok(rod);
                }
            }
        }
        Ok(rod)
    }

    /// The discrete rod in the shape of a contact.
    fn chain(&self, contact: &Contact, pose: Pose2) -> Result<DiscreteRod> {
        let mut rod = DiscreteRod::new(&self.whisker.beam, self.options.links, pose)?;
        if let Some(bend) = self.flex.bend(contact.load) {
            let shape = bend.shape(self.flex.beam.length, rod.nodes().len());
            let nodes: Vec<Vec2> = shape.into_iter().map(|p| pose.transform_point(p)).collect();
            let away = Vec2::from_angle(self.stance(pose).direction(contact.load, &contact.state));
            for times in [1.0, 0.3, 3.0, 10.0, 30.0] {
                let by = away * (times * APART * self.flex.beam.length);
                rod.pose(pose, pushed_off(nodes.clone(), by));
                if rod.is_clear(self.map) {
                    break;
                }
            }
        }
        Ok(rod)
    }

    /// Lets a discrete rod find the next equilibrium, and one contact that says the same if there is one.
    fn relax(&mut self, mut rod: DiscreteRod, leg: &mut Leg, why: &str) -> Result<Happened> {
        let was_free = matches!(self.body, Body::Free);
        self.earlier = None;
        let mut part = SNAP_SHARE;
        let simple;
        // Near a fold the rod holds on a little longer than the exact whisker: it is moved on until it lets go.
        loop {
            leg.share = leg.reached(part);
            let pose = leg.at(leg.share);
            let how = patiently(&mut rod, self.map, pose);
            self.unsolved = how == Relaxed::Unfinished;
            if how == Relaxed::Blocked {
                self.body = Body::Lost(rod.moment());
                let place = show(pose.position());
                return Ok(Some(("lost", format!("{why}, and its base is stopped by a boundary at {place}"))));
            }
            let found = self.simplified(&rod, pose);
            if found.is_some() || rod.presses().len() > 1 || leg.share >= 1.0 {
                simple = found;
                break;
            }
            part *= 4.0;
        }
        let kind = if was_free { "onset" } else { "snap" };
        let happened = match &simple {
            Some(Body::Free) if was_free => None,
            Some(Body::Free) if why == WALL_END => Some(("lift_off", why.to_owned())),
            Some(Body::Free) => Some(("snap", format!("{why} and snaps free"))),
            Some(Body::Held(contact)) => {
                let part = if contact.load.s >= 1.0 { "tip" } else { "side" };
                let there = show(contact.place);
                Some((kind, format!("{why} and comes to rest with its {part} at {there}")))
            }
            _ => {
                let places: Vec<String> = rod.presses().iter().map(|press| show(press.position)).collect();
                let places = if places.is_empty() { "nowhere for now".into() } else { places.join(" and ") };
                Some(("discrete_rod", format!("{why}; it touches at {places}{}", self.neglect())))
            }
        };
        if simple.is_none() {
            // On the verge of two descriptions the rod stays longer each time.
            self.patience = (1 << self.takeovers.min(LONGEST_STAY)) - 1;
            self.takeovers += 1;
        }
        self.body = simple.unwrap_or_else(|| Body::Chain(Box::new(rod)));
        Ok(happened)
    }

    fn neglect(&self) -> &'static str {
        if self.whisker.friction > 0.0 { "; friction is left out meanwhile" } else { "" }
    }

    /// The discrete rod for one step of its base.
    fn drag(&mut self, leg: &mut Leg) -> Result<Happened> {
        let Body::Chain(rod) = &mut self.body else { return Ok(None) };
        let target = leg.reached(leg.most.min(1.0 - leg.share));
        let pose = leg.at(target);
        leg.share = target;
        let how = patiently(rod, self.map, pose);
        if how == Relaxed::Blocked {
            self.body = Body::Lost(rod.moment());
            return Ok(Some(("lost", format!("is stopped by a boundary at its base {}", show(pose.position())))));
        }
        let fresh = how == Relaxed::Unfinished && !self.unsolved;
        self.unsolved = how == Relaxed::Unfinished;
        if fresh {
            return Ok(Some(("unsolved", "is still moving; the best shape reached goes on".into())));
        }
        if self.options.solver == Solver::DiscreteRod || self.unsolved {
            return Ok(None);
        }
        let Body::Chain(rod) = &self.body else { return Ok(None) };
        if self.patience > 0 && !rod.presses().is_empty() {
            self.patience -= 1;
            return Ok(None);
        }
        let Some(simple) = self.simplified(rod, pose) else { return Ok(None) };
        self.body = simple;
        Ok(Some(match self.body {
            Body::Free => ("lift_off", "leaves all boundaries".into()),
            _ => ("single_contact", "touches at one place again".into()),
        }))
    }

    /// What says the same as the rod with less: no contact or one; none when there is no such thing.
    fn simplified(&self, rod: &DiscreteRod, pose: Pose2) -> Option<Body> {
        let presses = rod.presses();
        let stance = self.stance(pose);
        let length = self.flex.beam.length;
        let [press] = presses.as_slice() else {
            let tip = pose.transform_point(self.flex.rest[self.flex.rest.len() - 1]);
            let same = rod.nodes().last().is_some_and(|node| node.distance(tip) < ALIKE.0 * length);
            let free = presses.is_empty() && same && meets(self.map, &self.flex.rest, pose).is_none();
            return free.then_some(Body::Free);
        };
        let node = ((press.s_a / length * self.options.links as f64) as usize).min(self.options.links - 1);
        let heading = (rod.nodes()[node + 1] - rod.nodes()[node]).angle();
        let beta = wrap_angle(press.force.angle() - heading - FRAC_PI_2);
        let (foothold, _) = Foothold::nearest(self.map, press.position, press.force, ALIKE.0 * length)?;
        let load = Load { q: press.force.norm() / self.flex.unit(), s: press.s_a / length, beta };
        let joint = foothold.joint(self.map, foothold.at > 0.5);
        let near_joint = joint.position.distance(press.position) < 1e-4 * length;
        let at_tip = press.s_a > length * (1.0 - 0.5 / self.options.links as f64);
        let lay = if beta.cos() > 0.0 { 0.0 } else { PI };
        let mut holds = Vec::new();
        if at_tip {
            if near_joint && joint.is_concave() {
                holds.push(Hold::Corner(joint));
            }
            holds.push(Hold::Tip(foothold));
        }
        holds.extend(side_hold(&stance, foothold, lay, heading));
        if near_joint && !joint.is_concave() && !joint.is_smooth() {
            holds.push(Hold::Vertex(joint, lay));
        }
        holds.push(Hold::Flank(foothold, lay));
        let step = Step { cone: 0.0, ..self.step(pose) };
        holds.into_iter().find_map(|hold| {
            let s = if matches!(hold, Hold::Tip(_) | Hold::Corner(_)) { 1.0 } else { load.s };
            let Next::Touching(contact) = step.run(hold, Load { s, ..load }, 0.0) else { return None };
            let moment = contact.state.m * self.flex.unit() * length;
            let alike = contact.place.distance(press.position) < ALIKE.0 * length
                && (contact.load.s - load.s).abs() < ALIKE.0
                && (moment - rod.moment()).abs() < ALIKE.1 * rod.moment().abs() + 1e-3 * self.flex.unit() * length;
            (alike && !self.is_blocked(&contact, pose)).then_some(Body::Held(contact))
        })
    }

    /// A whisker that was lost until it is clear of everything again.
    fn wait(&mut self, leg: &mut Leg) -> Happened {
        leg.share = leg.reached(1.0 - leg.share);
        let pose = leg.to;
        let clear = meets(self.map, &self.flex.rest, pose).is_none() && self.map.is_free(pose.position());
        if !clear {
            return None;
        }
        self.body = Body::Free;
        Some(("found", "is free again".into()))
    }

    /// The moment at the base now (N m).
    pub(super) fn moment(&self) -> f64 {
        match &self.body {
            Body::Free => 0.0,
            Body::Held(contact) => contact.state.m * self.flex.unit() * self.flex.beam.length,
            Body::Chain(rod) => rod.moment(),
            Body::Lost(moment) => *moment,
        }
    }

    /// The contacts now, from base to tip.
    pub(super) fn touches(&self, row: usize, whisker: usize) -> Vec<Touch> {
        match &self.body {
            Body::Free | Body::Lost(_) => Vec::new(),
            Body::Held(contact) => self.held_touch(contact, row, whisker).into_iter().collect(),
            Body::Chain(rod) => self.chain_touches(rod, row, whisker),
        }
    }

    fn held_touch(&self, contact: &Contact, row: usize, whisker: usize) -> Option<Touch> {
        let bend = self.flex.bend(contact.load)?;
        let stance = self.stance(self.map_from_whisker);
        let direction = stance.direction(contact.load, &contact.state);
        let (part, normal) = match contact.hold {
            Hold::Tip(foothold) => (Part::Tip, foothold.ground(self.map).normal),
            Hold::Corner(joint) => {
                let lean = joint.lean(direction).clamp(0.0, 1.0);
                (Part::Tip, joint.normal + lean * joint.turn)
            }
            Hold::Vertex(_, lay) | Hold::Flank(_, lay) => {
                (Part::Side, stance.heading(&contact.state) + lay + FRAC_PI_2)
            }
        };
        let grip = match (self.whisker.friction > 0.0, contact.stuck) {
            (false, _) => Grip::Frictionless,
            (true, true) => Grip::Sticks,
            (true, false) => Grip::Slips,
        };
        Some(Touch {
            t: self.t,
            row,
            whisker,
            position: contact.place,
            force: contact.load.q * self.flex.unit() * Vec2::from_angle(direction),
            energy: bend.energy(),
            s_a: contact.load.s * self.flex.beam.length,
            part,
            normal: Vec2::from_angle(normal),
            grip,
        })
    }

    fn chain_touches(&self, rod: &DiscreteRod, row: usize, whisker: usize) -> Vec<Touch> {
        let energy = rod.energy();
        let tip = self.flex.beam.length * (1.0 - 0.5 / self.options.links as f64);
        let touch = |press: super::discrete::Press| Touch {
            t: self.t,
            row,
            whisker,
            position: press.position,
            force: press.force,
            energy,
            s_a: press.s_a,
            part: if press.s_a > tip { Part::Tip } else { Part::Side },
            normal: press.force * (1.0 / press.force.norm()),
            grip: Grip::Frictionless,
        };
        rod.presses().into_iter().map(touch).collect()
    }

    /// `n` points of the whisker from base to tip, map frame (m).
    pub(super) fn shape(&self, n: usize) -> Vec<Vec2> {
        let length = self.flex.beam.length;
        let placed = |points: Vec<Vec2>| points.iter().map(|&p| self.map_from_whisker.transform_point(p)).collect();
        match &self.body {
            Body::Held(contact) => self.flex.bend(contact.load).map_or_else(Vec::new, |b| placed(b.shape(length, n))),
            Body::Chain(rod) => rod.nodes().to_vec(),
            Body::Free | Body::Lost(_) => placed(self.flex.rest.clone()),
        }
    }
}

/// Lets the rod find its equilibrium at this pose, with more time where it is still moving.
fn patiently(rod: &mut DiscreteRod, map: &Map, pose: Pose2) -> Relaxed {
    let mut how = rod.advance(map, pose);
    for _ in 0..MORE_TIME {
        if how == Relaxed::Unfinished {
            how = rod.advance(map, pose);
        }
    }
    how
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

/// All nodes but the first moved a little, the more the further from the base.
fn pushed_off(mut nodes: Vec<Vec2>, by: Vec2) -> Vec<Vec2> {
    let last = (nodes.len() - 1) as f64;
    for (i, node) in nodes.iter_mut().enumerate() {
        *node += by * (2.0 * i as f64 / last).min(1.0);
    }
    nodes
}

fn show(p: Vec2) -> String {
    format!("({:.6}, {:.6}) m", p.x, p.y)
}
