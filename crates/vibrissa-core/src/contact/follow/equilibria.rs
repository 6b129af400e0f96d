//! Equilibria of a whisker whose history is not known: multistart over the places of its tip and the corners of its side \[marti2003multistart\].
//!
//! A whisker in front of several walls has several equilibria, and in which one it is depends on how it came there. Where a snap, a corner or a
//! wall that was met head-on leaves that open, the reading tells: of all equilibria at the pose the one that reads most nearly so is taken.

use super::snap::TipForce;
use super::surroundings::Surroundings;
use super::{Contact, ForwardModel, Next, Prediction, WhiskerState};
use crate::contact::{Hold, Push, Stance, Support};
use crate::plane::{Bounds, Pose2, Vec2};
use core::f64::consts::FRAC_PI_2;

/// Distance between the places of the boundary that the tip is tried at, and how near these are to the base at least (whisker lengths).
const APART: f64 = 0.08;
const NEAREST: f64 = 0.1;
/// So many places at most.
const MOST_PLACES: usize = 40;
/// Corners that turn by less (rad) are facets of something round.
const SHARP: f64 = 0.35;
/// Contacts nearer to each other (whisker lengths, rad) are one.
const SAME: f64 = 1e-3;
/// Forces that a tip in a corner is tried with: below and above Euler's load of a whisker that is held at its end.
const CORNER_FORCES: [f64; 3] = [1.0, 3.0, 12.0];
/// How far they point off the whisker's own direction (rad).
const OFF_AXIS: f64 = 0.25;

impl ForwardModel<'_> {
    /// The equilibrium at `map_from_whisker` that reads most nearly `reading`, free or held: `off` tells how far a reading is from it, and none is
    /// told that is as far as `most`.
    pub(crate) fn equilibrium_that_reads(
        &self,
        map_from_whisker: Pose2,
        reading: f64,
        off: &dyn Fn(f64) -> f64,
        most: f64,
    ) -> Option<(WhiskerState, Prediction)> {
        let mut found: Vec<(f64, WhiskerState, Prediction)> = Vec::new();
        let tip = map_from_whisker.transform_point(Vec2::new(self.length, 0.0));
        if !self.map.crosses(map_from_whisker.position(), tip) {
            found.push((off(0.0), WhiskerState::Free, Prediction::default()));
        }
        let (root, per) = self.base.map_or((map_from_whisker, 1.0), |base| base.clamped(map_from_whisker, reading));
        self.for_each_equilibrium(root, &mut |touch, predicted| {
            found.push((off(predicted.value * per), WhiskerState::Touching(touch), predicted));
        });
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        found.into_iter().take_while(|(far, ..)| *far < most).find_map(|(_, mut state, predicted)| {
            if self.base.is_none() || matches!(state, WhiskerState::Free) {
                return Some((state, predicted));
            }
            let predicted = self.advance(&mut state, map_from_whisker, map_from_whisker, true);
            let is_held = matches!(state, WhiskerState::Touching(touch) if touch.q > 0.0);
            (is_held && off(predicted.value) < most).then_some((state, predicted))
        })
    }

    /// Visits equilibria of the clamped whisker, some of them more than once.
    fn for_each_equilibrium(&self, pose: Pose2, visit: &mut dyn FnMut(Contact, Prediction)) {
        let stance = Stance::new(pose, self.length);
        let places = self.places_in_reach(&stance);
        let (mut corners, mut known): (Vec<u32>, Vec<Contact>) = (Vec::new(), Vec::new());
        let mut last = None;
        for &(piece, at) in &places {
            let starts = [last, Some(self.across_at(&stance, (piece, at)))];
            let found = starts.into_iter().flatten().find_map(|load| self.stands_near(&stance, load, (piece, at)));
            if let Some((load, rests)) = found {
                last = Some(load);
                if let Some((touch, predicted)) = rests
                    && !known.iter().any(|other| self.is_same(other, &touch))
                {
                    known.push(touch);
                    self.visit_whole(&stance, touch, predicted, visit);
                }
            }
            for forward in [false, true] {
                if let Some((id, corner)) = self.boundaries.corner_of(piece, forward)
                    && (corner.turn.abs() > SHARP || corner.is_end())
                    && corner.position.distance(stance.base()) < self.length
                    && !corners.contains(&id)
                {
                    corners.push(id);
                }
            }
        }
        for id in corners {
            self.at_corner(&stance, id, visit);
        }
    }

    /// The force that has the tip at a place, and an equilibrium near it if there is one.
    fn stands_near(
        &self,
        stance: &Stance,
        load: TipForce,
        (piece, at): (u32, f64),
    ) -> Option<(TipForce, Option<(Contact, Prediction)>)> {
        let place = self.boundaries.spot((piece, at)).position;
        let placed = self.placed_at(load.q, load.beta, stance.seen(place))?;
        let load = TipForce { q: placed.q, beta: placed.beta };
        Some((load, self.rests_near(stance, Some(load), placed.slope(), piece, at)))
    }

    /// Whether two contacts of the tip are the same.
    fn is_same(&self, a: &Contact, b: &Contact) -> bool {
        a.place.distance(b.place) < SAME * self.length && (a.slope - b.slope).abs() < SAME
    }

    /// Places of the boundary around that the tip may reach.
    fn places_in_reach(&self, stance: &Stance) -> Vec<(u32, f64)> {
        let (base, reach) = (stance.base(), self.length);
        let around = Vec2::new(reach, reach);
        let mut places: Vec<(Vec2, (u32, f64))> = Vec::new();
        self.map.for_each_edge_in(Bounds { min: base - around, max: base + around }, |[a, b]| {
            let count = ((b - a).norm() / (APART * self.length)).ceil().clamp(1.0, 1e3);
            for k in 0..count as usize {
                let place = a + (b - a) * ((k as f64 + 0.5) / count);
                let far = place.distance(base) / self.length;
                if !(NEAREST..1.0).contains(&far) {
                    continue;
                }
                let Some((piece, at, _)) = self.boundaries.nearest(self.map, place, base, 0.1 * APART * self.length)
                else {
                    continue;
                };
                let spot = self.boundaries.spot((piece, at)).position;
                if places.iter().all(|(other, _)| other.distance(spot) >= 0.5 * APART * self.length) {
                    places.push((spot, (piece, at)));
                }
            }
            places.len() >= MOST_PLACES
        });
        places.into_iter().map(|(_, at)| at).collect()
    }

    /// Equilibria on a corner: the tip in it, or the side on it.
    fn at_corner(&self, stance: &Stance, id: u32, visit: &mut dyn FnMut(Contact, Prediction)) {
        let Some(corner) = self.boundaries.corner(id) else { return };
        let far = corner.position.distance(stance.base()) / self.length;
        let of = |q: f64, beta: f64, s: f64, hold: Hold| Contact {
            q,
            beta,
            s,
            hold,
            place: corner.position,
            slope: 0.0,
            clear: 0.0,
        };
        if corner.is_concave() {
            let hold = Hold::Tip(Support::Corner(id));
            let starts =
                CORNER_FORCES.iter().flat_map(|&q| [OFF_AXIS - FRAC_PI_2, FRAC_PI_2 - OFF_AXIS].map(|beta| (q, beta)));
            for (q, beta) in [(0.0, 0.0)].into_iter().chain(starts) {
                if let Some((touch, predicted)) = self.caught_in(stance, &of(q, beta, 1.0, hold), id) {
                    self.visit_whole(stance, touch, predicted, visit);
                }
            }
        }
        if corner.is_convex() {
            for push in [Push::Left, Push::Right] {
                let hold = Hold::Side(Support::Corner(id), push);
                if let Next::Touching(touch, predicted) = self.on_side(stance, of(0.0, push.tilt(), far, hold)) {
                    self.visit_whole(stance, touch, predicted, visit);
                }
            }
        }
    }

    /// Visits an equilibrium with whatever else the whisker touches; none where it would go through a boundary.
    fn visit_whole(
        &self,
        stance: &Stance,
        touch: Contact,
        predicted: Prediction,
        visit: &mut dyn FnMut(Contact, Prediction),
    ) {
        if touch.q <= 0.0 {
            return;
        }
        if matches!(touch.hold, Hold::Both(_)) {
            return visit(touch, predicted);
        }
        let whole = match self.surroundings(stance, &touch) {
            Surroundings::Clear(clear) => return visit(Contact { clear, ..touch }, predicted),
            _ if !self.follows_two() => return,
            Surroundings::Before(share, at) => self.propped(stance, &touch, share, at),
            Surroundings::Beyond(rest) => self.stopped(stance, &touch, rest),
        };
        if let Next::Touching(touch, predicted) = whole
            && touch.q > 0.0
        {
            visit(touch, predicted);
        }
    }
}
