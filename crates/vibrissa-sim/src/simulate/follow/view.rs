//! The whisker as its caller sees it: moment, contacts, shape.

use super::super::discrete::{DiscreteRod, Press};
use super::super::report::{Grip, Part, Touch};
use super::{Body, Follower};
use crate::contact::quasi_static::Equilibrium;
use crate::contact::{Hold, Support};
use crate::plane::Vec2;

impl Follower<'_> {
    /// The moment at the base now (N m).
    pub(in super::super) fn moment(&self) -> f64 {
        match &self.body {
            Body::Free => 0.0,
            Body::Held(contact) => contact.state.m * self.loaded.unit() * self.loaded.beam.length,
            Body::Chain(rod) => rod.moment(),
            Body::Lost(moment) => *moment,
        }
    }

    /// The contacts now, from base to tip.
    pub(in super::super) fn touches(&self, row: usize, whisker: usize) -> Vec<Touch> {
        match &self.body {
            Body::Free | Body::Lost(_) => Vec::new(),
            Body::Held(contact) => self.held_touch(contact, row, whisker).into_iter().collect(),
            Body::Chain(rod) => self.chain_touches(rod, row, whisker),
        }
    }

    fn held_touch(&self, contact: &Equilibrium, row: usize, whisker: usize) -> Option<Touch> {
        let bend = self.loaded.bend(contact.load)?;
        let on = self.on(self.map_from_whisker);
        let direction = on.direction(contact.load, &contact.state);
        let (part, normal) = match contact.hold {
            Hold::Tip(Support::Piece(piece, at)) => (Part::Tip, self.boundaries.spot((piece, at)).normal),
            Hold::Tip(Support::Corner(id)) => {
                let corner = self.boundaries.corner(id)?;
                let lean = corner.lean(direction).clamp(0.0, 1.0);
                (Part::Tip, corner.normal + lean * corner.turn)
            }
            Hold::Side(_, push) => (Part::Side, on.stance.direction(contact.state.slope, push.tilt())),
            Hold::Both(_) => return None,
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
            force: contact.load.q * self.loaded.unit() * Vec2::from_angle(direction),
            energy: bend.energy(),
            s_a: contact.load.s * self.loaded.beam.length,
            part,
            normal: Vec2::from_angle(normal),
            tangent: self.map_from_whisker.theta + contact.state.slope,
            grip,
        })
    }

    fn chain_touches(&self, rod: &DiscreteRod, row: usize, whisker: usize) -> Vec<Touch> {
        let energy = rod.energy();
        let tip = self.loaded.beam.length * (1.0 - 0.5 / self.options.links as f64);
        let (nodes, links) = (rod.nodes(), self.options.links);
        let tangent = |s_a: f64| {
            let link = ((s_a / self.loaded.beam.length * links as f64) as usize).min(nodes.len().saturating_sub(2));
            nodes.get(link..link + 2).map_or(0.0, |ends| (ends[1] - ends[0]).angle())
        };
        let touch = |press: Press| Touch {
            t: self.t,
            row,
            whisker,
            position: press.position,
            force: press.force,
            energy,
            s_a: press.s_a,
            part: if press.s_a > tip { Part::Tip } else { Part::Side },
            normal: press.force * (1.0 / press.force.norm()),
            tangent: tangent(press.s_a),
            grip: Grip::Frictionless,
        };
        rod.presses().into_iter().map(touch).collect()
    }

    /// `n` points of the whisker from base to tip, map frame (m).
    pub(in super::super) fn shape(&self, n: usize) -> Vec<Vec2> {
        let length = self.loaded.beam.length;
        let placed = |points: Vec<Vec2>| points.iter().map(|&p| self.map_from_whisker.transform_point(p)).collect();
        match &self.body {
            Body::Held(contact) => self.loaded.bend(contact.load).map_or_else(Vec::new, |b| placed(b.shape(length, n))),
            Body::Chain(rod) => rod.nodes().to_vec(),
            Body::Free | Body::Lost(_) => placed(self.loaded.rest.clone()),
        }
    }
}
