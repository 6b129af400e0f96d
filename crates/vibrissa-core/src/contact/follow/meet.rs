//! What a free whisker meets.

use super::{Contact, ForwardModel, Next, Prediction, WhiskerState};
use crate::contact::{Hold, Push, Stance, Support};
use crate::plane::{Pose2, Vec2, wrap_angle};
use core::f64::consts::FRAC_PI_2;

/// Halvings that find where a free whisker began to touch.
const MEET_HALVINGS: usize = 12;
/// Over how large a gap a whisker is glued, over its length.
const GLUE: f64 = 0.02;
/// How far from where a straight whisker crosses a boundary the corner is that it lies on, over its length.
const CORNER: f64 = 0.1;

impl ForwardModel<'_> {
    /// The tip just touching at a place of a piece, before any force.
    pub(crate) fn untouched(&self, piece: u32, at: f64, heading: f64) -> Contact {
        let spot = self.boundaries.spot((piece, at));
        let beta = wrap_angle(spot.normal - heading - FRAC_PI_2);
        Contact {
            q: 0.0,
            beta,
            s: 1.0,
            hold: Hold::Tip(Support::Piece(piece, at)),
            place: spot.position,
            slope: 0.0,
            clear: 0.0,
        }
    }

    /// The tip loaded at a place of a piece, as another computation found it.
    pub(crate) fn loaded(&self, piece: u32, at: f64, q: f64, beta: f64, slope: f64) -> Contact {
        let place = self.boundaries.spot((piece, at)).position;
        let hold = Hold::Tip(Support::Piece(piece, at));
        self.on_its_root(Contact { q, beta, s: 1.0, hold, place, slope, clear: 0.0 })
    }

    /// The free whisker at `to`: a tip contact if it crosses a boundary near its tip, an unknown one elsewhere. Its tip may also have gone over a
    /// corner on the way: then the whisker is caught there, and bent, where a straight one would be past it.
    pub(super) fn meet(&self, from: Pose2, to: Pose2) -> Option<(WhiskerState, Prediction)> {
        let tip = |pose: Pose2| pose.transform_point(Vec2::new(self.length, 0.0));
        let end = tip(to);
        let crosses = |pose: Pose2| self.map.crosses(pose.position(), tip(pose));
        let is_past = !crosses(to);
        if is_past && (!self.map.crosses(tip(from), end) || crosses(from)) {
            return None;
        }
        if !is_past
            && crosses(from)
            // It has been in contact for longer, and how is not known.
            && let Some((touch, predicted)) = self.settled_at(to)
        {
            return Some((WhiskerState::Touching(touch), predicted));
        }
        let travel = tip(from).distance(end).max(from.position().distance(to.position()));
        let turn = wrap_angle(to.theta - from.theta);
        let at_share = |share: f64| {
            let place = from.position() + (to.position() - from.position()) * share;
            Pose2 { x: place.x, y: place.y, theta: from.theta + share * turn }
        };
        let (mut free, mut touching) = (0.0, 1.0);
        for _ in 0..MEET_HALVINGS {
            let middle = 0.5 * (free + touching);
            let pose = at_share(middle);
            let touches = if is_past { self.map.crosses(tip(from), tip(pose)) } else { crosses(pose) };
            if touches { touching = middle } else { free = middle }
        }
        let pose = at_share(touching);
        let reach = 0.1 * travel + 0.02 * self.length;
        let onset = self.boundaries.nearest(self.map, tip(pose), pose.position(), reach);
        let slid = onset.and_then(|(piece, at, _)| self.slide(self.untouched(piece, at, pose.theta), pose, to));
        // A tip that would have to be pulled is only near a boundary, and the side has met another.
        let pressed = slid.filter(|(touch, _)| touch.q >= 0.0);
        let met = pressed.or_else(|| self.slide(self.brushed(pose)?, pose, to));
        if is_past {
            return met
                .filter(|(touch, _)| touch.q > 0.0)
                .map(|(touch, predicted)| (WhiskerState::Touching(touch), predicted));
        }
        // Met head-on it buckles to the side on which it leans then.
        let met = met.or(slid).or_else(|| self.settled_at(to));
        Some(met.map_or((WhiskerState::Unknown, Prediction::default()), |(touch, predicted)| {
            (WhiskerState::Touching(touch), predicted)
        }))
    }

    /// What the straight whisker touches with its side while its tip is only near a boundary.
    pub(super) fn beside(&self, stance: &Stance) -> Option<Next> {
        let (base, heading) = (stance.base(), stance.heading(0.0));
        let pose = Pose2 { x: base.x, y: base.y, theta: heading };
        if !self.map.crosses(base, pose.transform_point(Vec2::new(self.length, 0.0))) {
            return None;
        }
        let next = self.on_side(stance, self.brushed(pose)?);
        matches!(&next, Next::Touching(touch, _) if touch.q > 0.0).then_some(next)
    }

    /// The straight whisker just touching with its side, where it first crosses a boundary.
    fn brushed(&self, map_from_whisker: Pose2) -> Option<Contact> {
        let base = map_from_whisker.position();
        let along = Vec2::from_angle(map_from_whisker.theta) * self.length;
        let (mut clear, mut crossing) = (0.0, 1.0);
        for _ in 0..MEET_HALVINGS {
            let middle = 0.5 * (clear + crossing);
            if self.map.crosses(base, base + along * middle) { crossing = middle } else { clear = middle }
        }
        let place = base + along * crossing;
        let (piece, at, _) = self.boundaries.nearest(self.map, place, base, GLUE * self.length)?;
        let corners = [false, true].into_iter().filter_map(|forward| self.boundaries.corner_of(piece, forward));
        let near = corners
            .filter(|(_, corner)| corner.is_convex() && corner.position.distance(place) < CORNER * self.length)
            .min_by(|a, b| a.1.position.distance(place).total_cmp(&b.1.position.distance(place)));
        let (on, place, normal) = match near {
            Some((id, corner)) => (Support::Corner(id), corner.position, corner.outward()),
            None => {
                let spot = self.boundaries.spot((piece, at));
                (Support::Piece(piece, at), spot.position, spot.normal)
            }
        };
        let push = Push::of(normal - map_from_whisker.theta - FRAC_PI_2);
        let (beta, hold) = (push.tilt(), Hold::Side(on, push));
        Some(Contact { q: 0.0, beta, s: crossing, hold, place, slope: 0.0, clear: 0.0 })
    }

    /// The free whisker at `to` glued to the boundary that its tip almost reaches.
    pub(super) fn glue(&self, to: Pose2) -> Option<(WhiskerState, Prediction)> {
        let tip = to.transform_point(Vec2::new(self.length, 0.0));
        let (piece, at, _) = self.boundaries.nearest(self.map, tip, to.position(), GLUE * self.length)?;
        match self.next(&self.untouched(piece, at, to.theta), to) {
            Next::Touching(touch, predicted) => Some((WhiskerState::Touching(touch), predicted)),
            _ => None,
        }
    }
}
