//! The third door: where the tip can be, given one moment.
//!
//! A moment does not give a contact point, it gives a set. With the contact at the tip of the whisker that set is a
//! curve, and the direction of the contact force runs along it: a force normal to the boundary at a known slope names
//! one point of the curve \[routray, section "Contact Point Estimation via Bending Moment"; departures in
//! `docs/departures.md`\].

use crate::beam::{TipEquilibrium, TipModel, TipReading};
use crate::config::TipLoad;
use crate::plane::{Vec2, wrap_angle};
use crate::sets::Interval;
use core::f64::consts::{FRAC_PI_2, TAU};

/// One way in which the tip can touch: whisker frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TipContact {
    /// Direction of the contact force (rad), not wrapped.
    pub direction: f64,
    /// Slope of the whisker at the tip (rad); the paper's `phi_a`.
    pub slope: f64,
    /// The tip (m); the paper's `(x(s_a), y(s_a))` with `s_a = L`.
    pub position: Vec2,
    /// The contact force (N), negative when it pushes towards -y.
    pub force: f64,
}

impl TipContact {
    /// Tilt of the force from the whisker's normal at the tip (rad), as the beam functions take it.
    #[must_use]
    pub fn tilt(&self) -> f64 {
        let normal = self.slope + FRAC_PI_2.copysign(self.force);
        wrap_angle(self.direction - normal)
    }
}

/// The tip contacts that cause one moment, on one branch: a curve along which the force's direction grows.
#[derive(Clone, Debug, PartialEq)]
pub struct TipContactSet {
    contacts: Vec<TipContact>,
    /// For each of as many equal parts of the directions the first contact past its beginning.
    parts: Vec<u16>,
}

impl TipContactSet {
    /// Every branch of the tip contacts that cause a reading, the least bent first.
    ///
    /// Empty when no tip load causes such a reading, and for a reading of zero.
    #[must_use]
    pub fn branches(tip: &TipModel, reading: TipReading, load: TipLoad) -> Vec<Self> {
        let (reading, side) = reading.mirrored();
        let curves = tip.curve(reading).into_iter().map(|piece| Self::from_curve(tip, side, &piece));
        match load {
            TipLoad::BoundaryNormal => curves.filter(|set| set.contacts.len() > 1).collect(),
            TipLoad::WhiskerNormal => {
                let mut sets: Vec<Self> = curves.flat_map(Self::whisker_normal).collect();
                sets.sort_by(|a, b| a.bending().total_cmp(&b.bending()));
                sets
            }
        }
    }

    pub(super) fn new(contacts: Vec<TipContact>) -> Self {
        let parts = match (contacts.first(), contacts.last()) {
            (Some(a), Some(b)) if b.direction > a.direction => {
                let part = (b.direction - a.direction) / contacts.len() as f64;
                let first = |k: usize| contacts.partition_point(|c| c.direction < a.direction + k as f64 * part);
                (0..contacts.len()).map(|k| first(k) as u16).collect()
            }
            _ => Vec::new(),
        };
        Self { contacts, parts }
    }

    fn from_curve(tip: &TipModel, side: f64, piece: &[TipEquilibrium]) -> Self {
        let length = tip.whisker().length;
        let contact = |e: &TipEquilibrium| TipContact {
            direction: side * e.direction,
            slope: side * e.slope,
            position: Vec2::new(e.x, side * e.y) * length,
            force: side * tip.rigidity() * (e.t / length).powi(2),
        };
        let mut contacts: Vec<_> = piece.iter().map(contact).collect();
        if side < 0.0 {
            contacts.reverse();
        }
        Self::new(contacts)
    }

    /// The contacts of the curve whose force is normal to the whisker, each a set of its own.
    fn whisker_normal(self) -> Vec<Self> {
        let normal = |pair: &[TipContact]| {
            let (a, b) = (pair[0].tilt(), pair[1].tilt());
            let crosses = (a <= 0.0) != (b <= 0.0);
            crosses.then(|| Self::new(vec![blend(&pair[0], &pair[1], a / (a - b))]))
        };
        self.contacts.windows(2).filter_map(normal).collect()
    }

    /// How strongly the whisker is bent at the first contact: the size of its slope (rad).
    fn bending(&self) -> f64 {
        self.contacts.first().map_or(0.0, |c| c.slope.abs())
    }

    /// Whether the set is one point, whatever the direction of the force.
    #[must_use]
    pub fn is_point(&self) -> bool {
        self.contacts.len() == 1
    }

    /// The directions that the force can have (rad), whisker frame, not wrapped.
    #[must_use]
    pub fn directions(&self) -> Interval {
        match (self.contacts.first(), self.contacts.last()) {
            (Some(a), Some(b)) if !self.is_point() => Interval::new(a.direction, b.direction),
            (Some(a), _) => Interval::new(a.direction - FRAC_PI_2, a.direction + FRAC_PI_2),
            _ => Interval::EMPTY,
        }
    }

    /// The contact whose force acts in `direction` (rad, whisker frame, any turn of the circle).
    ///
    /// None when no contact of this branch has that direction. Linear between nodes: the position errs by at most
    /// 2e-4 of the whisker's length. A set of one point answers with that point for every direction that can push on it.
    #[must_use]
    pub fn at_direction(&self, direction: f64) -> Option<TipContact> {
        let direction = self.unrolled(direction);
        if !self.directions().contains(direction) {
            return None;
        }
        Some(self.interpolate(direction))
    }

    /// The contact at a direction on this branch's own turn of the circle; the nearest end beyond the branch.
    pub(super) fn interpolate(&self, direction: f64) -> TipContact {
        if self.is_point() {
            return self.contacts[0];
        }
        let after = self.first_from(direction).clamp(1, self.contacts.len() - 1);
        let (a, b) = (&self.contacts[after - 1], &self.contacts[after]);
        let share = (direction - a.direction) / (b.direction - a.direction);
        blend(a, b, share.clamp(0.0, 1.0))
    }

    /// The index of the first contact whose direction is not below this one.
    fn first_from(&self, direction: f64) -> usize {
        let (count, range) = (self.parts.len(), self.directions());
        if count == 0 || !range.contains(direction) {
            return self.contacts.partition_point(|c| c.direction < direction);
        }
        let part = (direction - range.lo()) * (count as f64 / range.width());
        let mut index = usize::from(self.parts[(part as usize).min(count - 1)]);
        // Rounding may put the direction into the part after its own.
        while index > 0 && self.contacts[index - 1].direction >= direction {
            index -= 1;
        }
        while index < self.contacts.len() && self.contacts[index].direction < direction {
            index += 1;
        }
        index
    }

    /// The contact nearest to `point` (m, whisker frame) among those whose force acts between `from` and `from + turn`
    /// (rad, whisker frame, any turn of the circle; `turn` not negative).
    ///
    /// None when no contact of this branch has such a direction, and for a set of one point.
    #[must_use]
    pub fn nearest(&self, point: Vec2, from: f64, turn: f64) -> Option<TipContact> {
        if self.is_point() {
            return None;
        }
        let (middle, range) = (self.unrolled(from + 0.5 * turn), self.directions());
        // The directions may span more than half a turn, so that the cone meets them on more than one turn.
        let squared = |c: &TipContact| (c.position - point).norm_squared();
        [middle - TAU, middle, middle + TAU]
            .into_iter()
            .map(|m| range.intersection(Interval::new(m - 0.5 * turn, m + 0.5 * turn)))
            .filter_map(|cone| self.nearest_in(point, cone))
            .min_by(|a, b| squared(a).total_cmp(&squared(b)))
    }

    /// The contact nearest to `point` among those with directions in `cone`, which lies in the range of directions.
    fn nearest_in(&self, point: Vec2, cone: Interval) -> Option<TipContact> {
        if cone.is_empty() {
            return None;
        }
        let ends = [self.interpolate(cone.lo()), self.interpolate(cone.hi())];
        let inner = self.contacts.iter().filter(|c| cone.contains(c.direction)).copied();
        let chain: Vec<TipContact> = core::iter::once(ends[0]).chain(inner).chain([ends[1]]).collect();
        let on_link = |pair: &[TipContact]| {
            let along = pair[1].position - pair[0].position;
            let square = along.norm_squared();
            let share = if square > 0.0 { (point - pair[0].position).dot(along) / square } else { 0.0 };
            blend(&pair[0], &pair[1], share.clamp(0.0, 1.0))
        };
        let squared = |c: &TipContact| (c.position - point).norm_squared();
        chain.windows(2).map(on_link).min_by(|a, b| squared(a).total_cmp(&squared(b)))
    }

    /// The angle brought to the turn of the circle nearest to this branch's directions.
    fn unrolled(&self, direction: f64) -> f64 {
        let range = self.directions();
        let middle = 0.5 * (range.lo() + range.hi());
        middle + wrap_angle(direction - middle)
    }

    /// The nodes of the curve, in order of growing direction.
    #[must_use]
    pub fn contacts(&self) -> &[TipContact] {
        &self.contacts
    }
}

pub(super) fn blend(a: &TipContact, b: &TipContact, share: f64) -> TipContact {
    let mix = |p: f64, q: f64| p + share * (q - p);
    TipContact {
        direction: mix(a.direction, b.direction),
        slope: mix(a.slope, b.slope),
        position: a.position + (b.position - a.position) * share,
        force: mix(a.force, b.force),
    }
}
