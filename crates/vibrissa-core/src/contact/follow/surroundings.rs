//! Whether the rest of the whisker is clear of the boundaries.
//!
//! The contact holds one place; a bump may rise under another. How far the whisker is clear of everything is kept, so
//! that it is not looked at again before it can have moved as far. Where a bump is near, both contacts are solved for,
//! and the sign of the force tells whether it touches.

use super::{Contact, ForwardModel, span};
use crate::contact::{Hold, Stance, Support};
use crate::math;
use crate::plane::Vec2;
use core::f64::consts::FRAC_PI_2;

/// Pieces into which the whisker is cut up to its contact, and the share that is looked at for clearance: nearer to the
/// contact its boundary is near anyway.
const CUTS: usize = 12;
const LOOKED: usize = 9;
/// Distances are looked for up to this (whisker lengths).
const FARTHEST: f64 = 0.27;
/// A bump nearer than this (whisker lengths) is tried.
const BUMP: f64 = 2e-3;
/// However near something is, the whisker is not looked at again before it may have moved so far (whisker
/// lengths).
const LEAST_CLEAR: f64 = 0.0133;
/// How far behind a tip that points out of the boundary the side is looked for (share of the length).
const BEHIND: f64 = 0.04;
/// How far from its contact, of what is beyond, a whisker is seen from to be on the free side there.
const BESIDE: f64 = 0.05;
/// A straight end beyond the contact shorter than this (share of the length) is not looked at.
const SHORT: f64 = 0.004;

/// What the whisker runs into besides its contact.
pub(super) enum Surroundings {
    /// Nothing within this (m).
    Clear(f64),
    /// Something before its contact: at this share of its length, near this place of a piece.
    Before(f64, (u32, f64)),
    /// Something beyond its contact: what would hold the tip, or a corner under the straight end at this arc length (over the length).
    Beyond((Support, Option<f64>)),
}

/// How far a place is on the free side of the nearest boundary.
struct Gap {
    distance: f64,
    at: (u32, f64),
}

/// Where along the places of a whisker it is on or behind a boundary, and near which place of it.
type Bump = (f64, (u32, f64));

impl ForwardModel<'_> {
    /// What a whisker that stands so runs into.
    pub(super) fn surroundings(&self, stance: &Stance, touch: &Contact) -> Surroundings {
        let Some(chart) = self.mechanics.held_chart(touch.q, touch.beta) else { return Surroundings::Clear(0.0) };
        let per = 1.0 / touch.s;
        let force = Vec2::from_angle(touch.slope + touch.beta + FRAC_PI_2) * (touch.q * per * per);
        let mut outline = [Vec2::ZERO; CUTS];
        span::outline(chart.moment * per, force, touch.s, &mut outline);
        let (mut clear, bump) = self.bump(stance, &outline[..CUTS - 1], touch.hold);
        if let Some((k, at)) = bump {
            return Surroundings::Before((k + 1.0) / CUTS as f64 * touch.s, at);
        }
        if let Hold::Tip(Support::Piece(piece, at)) = touch.hold {
            // A tip that points out of the boundary has come through it from behind.
            let heading = stance.heading(touch.slope);
            if math::cos(heading - self.boundaries.spot((piece, at)).normal) > 0.0
                && let Some(gap) =
                    self.gap(touch.place - Vec2::from_angle(heading) * (BEHIND * self.length), stance.base())
            {
                return Surroundings::Before(1.0 - BEHIND, gap.at);
            }
        }
        if let Hold::Tip(Support::Corner(id)) = touch.hold
            && let Some(corner) = self.boundaries.corner(id)
        {
            // A tip in a corner may have come from behind either of its sides.
            let heading = stance.heading(touch.slope);
            for (normal, (piece, end)) in [(corner.normal, corner.before), (corner.normal + corner.turn, corner.after)]
            {
                if math::cos(heading - normal) > 0.0 {
                    let step = BEHIND * self.length / self.boundaries.piece(piece).length();
                    let at = if end > 0.5 { end - step } else { end + step };
                    return Surroundings::Before(1.0 - BEHIND, (piece, at.clamp(0.0, 1.0)));
                }
            }
            // A held tip turns fast.
            clear = 0.0;
        }
        let free = 1.0 - touch.s;
        if matches!(touch.hold, Hold::Side(..)) && free > SHORT {
            let beyond = Vec2::from_angle(stance.heading(touch.slope)) * (free * self.length);
            let line = match touch.hold {
                Hold::Side(Support::Piece(piece, at), _) if self.boundaries.spot((piece, at)).turning.abs() <= 0.0 => {
                    Some((piece, at))
                }
                _ => None,
            };
            if let Some((piece, at)) = line {
                let along = self.boundaries.piece(piece).length();
                let forward = beyond.dot(self.boundaries.spot((piece, at)).velocity) > 0.0;
                let left = (if forward { 1.0 - at } else { at }) * along - beyond.norm();
                match self.boundaries.corner_of(piece, forward).filter(|(_, corner)| corner.is_concave()) {
                    Some((_, corner)) if left < 0.0 => {
                        return Surroundings::Beyond((corner.across(piece, forward).into(), None));
                    }
                    Some(_) => clear = clear.min(left),
                    None => {}
                }
            }
            match self.corner_beyond(touch, beyond) {
                Some((share, off, id)) if off < BUMP * self.length => {
                    return Surroundings::Beyond((Support::Corner(id), Some(touch.s + share * free)));
                }
                Some((_, off, _)) => clear = clear.min(off),
                None => {}
            }
            // From beside the contact, which may be the end of a wall.
            match self.gap(touch.place + beyond, touch.place + beyond * BESIDE) {
                // Beyond the line that it lies on it does not come.
                Some(gap) if line.is_some_and(|(piece, _)| piece == gap.at.0) => {}
                Some(gap) if gap.distance < 0.0 => {
                    let (piece, at) = gap.at;
                    return Surroundings::Beyond((Support::Piece(piece, at.clamp(0.0, 1.0)), None));
                }
                Some(gap) => clear = clear.min(gap.distance),
                None => {}
            }
        }
        Surroundings::Clear(clear.max(LEAST_CLEAR * self.length))
    }

    /// The convex corner that the straight end is nearest to, or furthest behind, which goes so far beyond the contact: the share of it, how
    /// far it is clear (m), and the corner.
    fn corner_beyond(&self, touch: &Contact, beyond: Vec2) -> Option<(f64, f64, u32)> {
        let count = (beyond.norm() * CUTS as f64 / self.length).ceil().max(1.0);
        let place = |k: f64| touch.place + beyond * (k / count);
        let mut free = touch.place + beyond * BESIDE;
        let mut last = self.gap(free, free).map(|gap| (free, gap));
        let mut nearest: Option<(f64, f64, u32)> = None;
        for k in 1..=count as usize {
            let here = place(k as f64);
            let gap = self.gap(here, free);
            if gap.as_ref().is_none_or(|gap| gap.distance >= 0.0) {
                free = here;
            }
            let now = gap.map(|gap| (here, gap));
            if let (Some((a, before)), Some((b, after))) = (&last, &now)
                && let Some((t, off, (piece, end))) = self.corner_between((*a, before), (*b, after), touch.hold)
                && nearest.is_none_or(|(_, least, _)| off < least)
                && let Some((id, _)) = self.boundaries.corner_of(piece, end > 0.5)
            {
                nearest = Some(((k as f64 - 1.0 + t) / count, off, id));
            }
            last = now;
        }
        nearest
    }

    /// How far these places of the whisker are clear, and where one is on or behind a boundary.
    fn bump(&self, stance: &Stance, outline: &[Vec2], hold: Hold) -> (f64, Option<Bump>) {
        let (farthest, bump) = (FARTHEST * self.length, BUMP * self.length);
        let mut clear = farthest;
        let mut least: Option<(usize, Gap)> = None;
        let mut before = f64::INFINITY;
        let (mut last_place, mut free) = (stance.base(), stance.base());
        for (k, &at) in outline.iter().enumerate() {
            let place = stance.placed(at);
            // What comes through a boundary is no further from it than the next of these places.
            let least_gap = self.boundaries.clearance.at(place);
            let (gap, distance) = if least_gap * CUTS as f64 > self.length {
                (None, least_gap.min(farthest))
            } else {
                let gap = self.gap(place, free);
                let distance = gap.as_ref().map_or(farthest, |gap| gap.distance);
                (gap, distance)
            };
            if k < LOOKED {
                clear = clear.min(distance);
            }
            if distance >= 0.0 {
                free = place;
            }
            if let Some((t, off, at)) = least
                .as_ref()
                .zip(gap.as_ref())
                .and_then(|(last, now)| self.corner_between((last_place, &last.1), (place, now), hold))
            {
                if off < bump {
                    return (clear, Some((k as f64 - 1.0 + t, at)));
                }
                clear = clear.min(off);
            }
            last_place = place;
            // A place nearer than its neighbours, or on the wrong side.
            let rises =
                least.as_ref().is_some_and(|(j, l)| *j + 1 == k && l.distance < before && distance > l.distance);
            if let Some((j, gap)) = least.as_ref().filter(|(_, l)| rises && l.distance < bump) {
                return (clear, Some((*j as f64, gap.at)));
            }
            if let Some(last) = &least {
                before = last.1.distance;
            }
            least = gap.map(|gap| (k, gap));
            if least.is_none() {
                before = farthest;
            }
        }
        (clear, least.filter(|(_, l)| l.distance < 0.0).map(|(j, gap)| (j as f64, gap.at)))
    }

    /// The convex corner between two neighbouring places of the whisker that it is nearest to, or furthest behind: where between them, how
    /// far it is clear of it (m), and the end of a piece there. A corner may reach far between places that are clear themselves.
    fn corner_between(
        &self,
        (a, before): (Vec2, &Gap),
        (b, after): (Vec2, &Gap),
        hold: Hold,
    ) -> Option<(f64, f64, (u32, f64))> {
        let along = b - a;
        let length = along.norm();
        let ends = [before, after].into_iter().flat_map(|gap| [(gap.at.0, false), (gap.at.0, true)]);
        let clear = |(piece, forward): (u32, bool)| {
            let (id, corner) = self.boundaries.corner_of(piece, forward).filter(|(_, corner)| corner.is_convex())?;
            // What holds the whisker passes over its own corners by itself.
            let holds = match hold {
                Hold::Tip(Support::Piece(on, _)) | Hold::Side(Support::Piece(on, _), _) => {
                    on == corner.before.0 || on == corner.after.0
                }
                Hold::Tip(Support::Corner(on)) | Hold::Side(Support::Corner(on), _) => on == id,
                Hold::Both(_) => false,
            };
            if holds {
                return None;
            }
            let share = (corner.position - a).dot(along) / (length * length);
            let off = a + along * share - corner.position;
            let outward = Vec2::from_angle(corner.outward());
            let distance = off.norm().copysign(off.dot(outward));
            (0.0..=1.0).contains(&share).then_some((share, distance, (piece, f64::from(u8::from(forward)))))
        };
        let (behind, clear): (Vec<_>, Vec<_>) = ends.filter_map(clear).partition(|one| one.1 < 0.0);
        // The far corners of a thing that the whisker passes by face away from it, too.
        let behind = behind
            .into_iter()
            .max_by(|a, b| a.1.total_cmp(&b.1))
            .filter(|one| one.1 > -length && self.map.crosses(a, b));
        behind.or_else(|| clear.into_iter().min_by(|a, b| a.1.total_cmp(&b.1)))
    }

    /// The boundary nearest to a place, which is behind it where a thin wall lies between it and what is known to be `free`.
    fn gap(&self, place: Vec2, free: Vec2) -> Option<Gap> {
        let near = |from: Vec2| self.boundaries.nearest(self.map, place, from, FARTHEST * self.length);
        let (piece, at, distance) = near(free)?;
        if !self.boundaries.is_behind((piece, at), place) {
            return Some(Gap { distance, at: (piece, at) });
        }
        // Around the end of a wall its other side is free, too.
        if self.boundaries.other_side(piece).is_some() && !self.map.crosses(free, place) {
            return near(place).map(|(piece, at, distance)| Gap { distance, at: (piece, at) });
        }
        Some(Gap { distance: -distance, at: (piece, at) })
    }
}
