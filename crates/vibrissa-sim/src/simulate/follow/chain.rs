//! The discrete rod in charge: how it takes over, goes on, and hands back.

use super::super::Solver;
use super::super::discrete::{DiscreteRod, REACH, Relaxed};
use super::uncross::uncrossed;
use super::{Body, Follower, Happened, Leg, show};
use crate::config::budgets::MOST_UNREST;
use crate::contact::quasi_static::{Equilibrium, Outcome, PointLoad, Step, WALL_END, meets, side_hold};
use crate::contact::{Hold, Push, Support};
use crate::plane::{Pose2, Vec2, wrap_angle};
use crate::{Error, Result};
use core::f64::consts::{FRAC_PI_2, PI};

/// Share of a row in which a whisker that has lost its equilibrium finds another.
const SNAP_SHARE: f64 = 1e-3;
/// Distance at which a discrete rod starts beside what it touches, over L.
const APART: f64 = 3.0 * REACH;
/// How far one contact may differ from the discrete rod that it replaces: place and slope (over L, rad), and moment relative.
const ALIKE: (f64, f64) = (0.03, 0.03);
/// How far nodes are moved where the rod would begin across a boundary, over the length of a link.
const UNCROSSING: f64 = 0.25;
/// How often a discrete rod that is still moving is given more time.
const MORE_TIME: usize = 3;
/// The discrete rod stays for up to two to this power steps when it keeps taking over.
const LONGEST_STAY: u32 = 6;

impl Follower<'_> {
    /// The discrete rod without load at this pose, a little away from what it touches; none where it cannot be laid clear.
    pub(super) fn unloaded(&self, pose: Pose2) -> Result<Option<DiscreteRod>> {
        let mut rod = DiscreteRod::new(&self.whisker.beam, self.options.links, pose)?;
        let apart = APART * self.loaded.beam.length;
        let nodes = rod.nodes().to_vec();
        for times in [0.0, 1.0, 10.0, 100.0, 1000.0] {
            // The free side is where the base is; a boundary beside the whisker may be on either.
            for turn in [PI, FRAC_PI_2, -FRAC_PI_2] {
                rod.pose(pose, pushed_off(nodes.clone(), Vec2::from_angle(pose.theta + turn) * (times * apart)));
                if rod.is_clear(self.map) && rod.clearance(self.map, apart) >= 0.3 * apart {
                    return Ok(Some(rod));
                }
            }
        }
        Ok(self.uncrossed(rod, pose, nodes))
    }

    /// The discrete rod in the shape of a contact; none where it cannot be laid clear of all boundaries.
    pub(super) fn chain(&self, contact: &Equilibrium, pose: Pose2) -> Result<Option<DiscreteRod>> {
        let mut rod = DiscreteRod::new(&self.whisker.beam, self.options.links, pose)?;
        let Some(bend) = self.loaded.bend(contact.load) else {
            let nodes = rod.nodes().to_vec();
            return Ok(self.uncrossed(rod, pose, nodes));
        };
        let shape = bend.shape(self.loaded.beam.length, rod.nodes().len());
        let nodes: Vec<Vec2> = shape.into_iter().map(|p| pose.transform_point(p)).collect();
        let away = Vec2::from_angle(self.on(pose).direction(contact.load, &contact.state));
        let pushed = |times: f64| pushed_off(nodes.clone(), away * (times * APART * self.loaded.beam.length));
        for times in [1.0, 0.3, 3.0, 10.0, 30.0] {
            rod.pose(pose, pushed(times));
            if rod.is_clear(self.map) {
                return Ok(Some(rod));
            }
        }
        Ok(self.uncrossed(rod, pose, pushed(1.0)))
    }

    /// The rod with these nodes, each moved to the right side of what it crosses; none where that takes too far a move.
    fn uncrossed(&self, mut rod: DiscreteRod, pose: Pose2, nodes: Vec<Vec2>) -> Option<DiscreteRod> {
        let length = self.loaded.beam.length;
        let most = UNCROSSING * length / self.options.links as f64;
        rod.pose(pose, uncrossed(self.map, nodes, APART * length, most)?);
        Some(rod)
    }

    /// Lets a discrete rod find the next equilibrium, and one contact that says the same if there is one.
    pub(super) fn relax(&mut self, rod: Option<DiscreteRod>, leg: &mut Leg, why: &str) -> Result<Happened> {
        let Some(mut rod) = rod else {
            self.body = Body::Lost(self.moment());
            let place = show(leg.at(leg.share).position());
            return Ok(Some((
                "lost",
                format!("{why}, and cannot be laid clear of all boundaries with its base at {place}"),
            )));
        };
        let was_free = matches!(self.body, Body::Free);
        self.earlier = None;
        let mut part = SNAP_SHARE;
        let simple;
        // Near a fold the rod holds on a little longer than the exact whisker: it is moved on until it lets go.
        loop {
            leg.share = leg.reached(part);
            let pose = leg.at(leg.share);
            let how = self.patiently(&mut rod, pose)?;
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
    pub(super) fn drag(&mut self, leg: &mut Leg) -> Result<Happened> {
        let Body::Chain(mut rod) = core::mem::replace(&mut self.body, Body::Free) else { return Ok(None) };
        let target = leg.reached(leg.most.min(1.0 - leg.share));
        let pose = leg.at(target);
        leg.share = target;
        let how = self.patiently(&mut rod, pose);
        let moment = rod.moment();
        self.body = Body::Chain(rod);
        let how = how?;
        if how == Relaxed::Blocked {
            self.body = Body::Lost(moment);
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

    /// Lets the rod find its equilibrium at this pose, with more time where it is still moving.
    fn patiently(&mut self, rod: &mut DiscreteRod, pose: Pose2) -> Result<Relaxed> {
        let mut how = Relaxed::Unfinished;
        for _ in 0..=MORE_TIME {
            how = rod.advance_until(self.map, pose, self.stop);
            if how != Relaxed::Unfinished || self.stop.is_asked() {
                break;
            }
        }
        let steps = rod.take_steps();
        self.unrest = if how == Relaxed::Unfinished { self.unrest + steps * self.options.links as u64 } else { 0 };
        if self.unrest > MOST_UNREST && !self.stop.is_asked() {
            return Err(self.restless(rod, pose));
        }
        Ok(how)
    }

    /// What is said of a rod that takes too long to come to rest.
    fn restless(&self, rod: &DiscreteRod, pose: Pose2) -> Error {
        let places: Vec<String> = rod.presses().iter().map(|press| show(press.position)).collect();
        let places = if places.is_empty() { "nothing".into() } else { places.join(" and ") };
        let robot = pose.compose(self.whisker.robot_from_whisker.inverse());
        Error::data(format!(
            "the whisker {} does not come to rest at sample {} of the path",
            self.whisker.name, self.sample
        ))
        .value(format!(
            "robot at {}, heading {:.3} deg, the whisker's base at {}; it touches {places}",
            show(robot.position()),
            robot.theta.to_degrees(),
            show(pose.position()),
        ))
        .allowed(format!("{MOST_UNREST} moves of nodes from one rest to the next"))
        .remedy(format!(
            "end the path before this sample, keep the base off what it touches there, or use fewer links than {}",
            self.options.links
        ))
    }

    /// What says the same as the rod with less: no contact or one; none when there is no such thing.
    fn simplified(&self, rod: &DiscreteRod, pose: Pose2) -> Option<Body> {
        let presses = rod.presses();
        let length = self.loaded.beam.length;
        let [press] = presses.as_slice() else {
            let tip = pose.transform_point(self.loaded.rest[self.loaded.rest.len() - 1]);
            let same = rod.nodes().last().is_some_and(|node| node.distance(tip) < ALIKE.0 * length);
            let free = presses.is_empty() && same && meets(self.map, &self.loaded.rest, pose).is_none();
            return free.then_some(Body::Free);
        };
        let node = ((press.s_a / length * self.options.links as f64) as usize).min(self.options.links - 1);
        let heading = (rod.nodes()[node + 1] - rod.nodes()[node]).angle();
        let beta = wrap_angle(press.force.angle() - heading - FRAC_PI_2);
        let (piece, at) = self.boundaries.nearest_facing(self.map, press.position, press.force, ALIKE.0 * length)?;
        let load = PointLoad { q: press.force.norm() / self.loaded.unit(), s: press.s_a / length, beta };
        let (id, corner) = self.boundaries.corner_of(piece, at > 0.5)?;
        let near_corner = corner.position.distance(press.position) < 1e-4 * length;
        let at_tip = press.s_a > length * (1.0 - 0.5 / self.options.links as f64);
        let push = Push::of(beta);
        let mut holds = Vec::new();
        if at_tip {
            if near_corner && corner.is_concave() {
                holds.push(Hold::Tip(Support::Corner(id)));
            }
            holds.push(Hold::Tip(Support::Piece(piece, at)));
        }
        holds.extend(side_hold(&self.on(pose), (piece, at), push, heading));
        if near_corner && !corner.is_concave() && !corner.is_smooth() {
            holds.push(Hold::Side(Support::Corner(id), push));
        }
        holds.push(Hold::Side(Support::Piece(piece, at), push));
        let step = Step { cone: 0.0, ..self.step(pose) };
        holds.into_iter().find_map(|hold| {
            let s = if matches!(hold, Hold::Tip(_)) { 1.0 } else { load.s };
            let Outcome::Touching(contact) = step.run(hold, PointLoad { s, ..load }, 0.0) else { return None };
            let moment = contact.state.m * self.loaded.unit() * length;
            let alike = contact.place.distance(press.position) < ALIKE.0 * length
                && (contact.load.s - load.s).abs() < ALIKE.0
                && (moment - rod.moment()).abs() < ALIKE.1 * rod.moment().abs() + 1e-3 * self.loaded.unit() * length;
            (alike && !self.is_blocked(&contact, pose)).then_some(Body::Held(contact))
        })
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

#[cfg(test)]
mod tests {
    use super::super::Scene;
    use super::*;
    use crate::Stop;
    use crate::contact::Boundaries;
    use crate::contact::quasi_static::LoadedWhisker;
    use crate::flow::pose::StampedPose;
    use crate::plane::Curve;
    use crate::simulate::SimulateOptions;
    use crate::world::{Boundary, Map, MountedWhisker, Role};

    #[test]
    fn a_rod_that_never_rests_ends_in_an_error_that_says_where() {
        let wall = Curve::polyline(&[Vec2::new(50.0, 50.0), Vec2::new(51.0, 50.0)], false).unwrap();
        let map = Map::new(vec![Boundary::new(Role::Wall, wall, None).unwrap()]).unwrap();
        let (boundaries, whisker, stop) = (Boundaries::new(&map), MountedWhisker::default(), Stop::default());
        let (loaded, options) = (LoadedWhisker::new(&whisker.beam).unwrap(), SimulateOptions::default());
        let scene = Scene {
            map: &map,
            boundaries: &boundaries,
            whisker: &whisker,
            loaded: &loaded,
            options: &options,
            stop: &stop,
        };
        let start = StampedPose { t: 0.0, map_from_robot: Pose2::IDENTITY };
        let mut follower = Follower::start(scene, start).unwrap();
        let mut rod = follower.unloaded(Pose2::IDENTITY).unwrap().unwrap();
        // Farther than all its steps reach.
        let far = Pose2::new(30.0, 0.0, 0.5);
        assert_eq!(follower.patiently(&mut rod, far).unwrap(), Relaxed::Unfinished);
        let once = follower.unrest;
        assert!(once > 10_000 && once < MOST_UNREST / 50, "{once}");
        // A rest makes good for all.
        let near = Pose2::new(rod.nodes()[0].x, rod.nodes()[0].y, 0.5);
        assert_eq!(follower.patiently(&mut rod, near).unwrap(), Relaxed::Converged);
        assert_eq!(follower.unrest, 0);
        follower.unrest = MOST_UNREST - once / 2;
        let error = follower.patiently(&mut rod, far).unwrap_err().to_string();
        for part in [
            "does not come to rest at sample 0 of the path",
            "robot at (",
            "heading 28.648 deg",
            "it touches nothing",
            "end the path",
        ] {
            assert!(error.contains(part), "{error}");
        }
        // Asked to stop it moves no more, and that is no error.
        stop.ask();
        let nodes = rod.nodes().to_vec();
        assert_eq!(follower.patiently(&mut rod, far).unwrap(), Relaxed::Unfinished);
        assert_eq!(rod.nodes(), nodes);
    }
}
