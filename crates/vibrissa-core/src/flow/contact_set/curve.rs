//! The curves of contacts that explain one exact reading.

use super::family::exact_curves;
use super::{Contact, ContactModel, Reading, VirtualSensor};
use crate::Result;
use crate::plane::{Bounds, Vec2};

/// Links under one rectangle of a curve's hierarchy.
pub(super) const LINKS: usize = 8;
/// How much further than measured a curve may leave its chords: second differences see the sag itself, once.
const SAFETY: f64 = 2.0;

/// Contacts along one branch, in order, with chords that stay near the smooth curve.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactCurve {
    contacts: Vec<Contact>,
    /// The rectangle around each run of [`LINKS`] links.
    pub(super) runs: Vec<Bounds>,
}

impl ContactCurve {
    pub(super) fn new(contacts: Vec<Contact>) -> Self {
        let around = |from: usize| {
            let to = (from + LINKS).min(contacts.len().saturating_sub(1));
            contacts[from..=to].iter().fold(Bounds::EMPTY, |b, c| b.including(c.position))
        };
        let runs = (0..contacts.len().saturating_sub(1).max(1)).step_by(LINKS).map(around).collect();
        Self { contacts, runs }
    }

    /// The nodes, in order along the curve.
    #[must_use]
    pub fn contacts(&self) -> &[Contact] {
        &self.contacts
    }

    /// The nodes' places (m), whisker frame.
    #[must_use]
    pub fn points(&self) -> Vec<Vec2> {
        self.contacts.iter().map(|c| c.position).collect()
    }

    /// The length of the chain of chords (m).
    #[must_use]
    pub fn length(&self) -> f64 {
        self.contacts.windows(2).map(|w| w[0].position.distance(w[1].position)).sum()
    }

    /// How far the smooth curve can be from its chords (m), measured by second differences.
    pub(super) fn sag(&self) -> f64 {
        let bend = |w: &[Contact]| (w[0].position - 2.0 * w[1].position + w[2].position).norm_squared();
        // A curve of two nodes shows no second difference; it is as straight as it is known to be.
        SAFETY / 8.0 * self.contacts.windows(3).map(bend).fold(0.0, f64::max).sqrt()
    }
}

/// All contacts that explain one exact reading: curves in the whisker frame, every branch, within whisker and limits.
///
/// The empty set (no curves) is an answer: no such contact.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactSet {
    /// The sensor that read.
    pub sensor: VirtualSensor,
    /// What it read (SI).
    pub value: f64,
    /// The branches; each is compact and connected.
    pub curves: Vec<ContactCurve>,
    /// How far a true contact can be from the chords (m): what the chords leave out, the error of the table where there is one, and
    /// in the small-angle regime how far that model is from the elastica.
    pub tolerance: f64,
    model: ContactModel,
}

impl ContactSet {
    /// The contacts of `model` for which `sensor` reads `value`, with about `nodes` contacts on each branch (at least 8).
    ///
    /// | whisker and load | load | strip | slope | moment |
    /// | --- | --- | --- | --- | --- |
    /// | uniform, normal | by arc length | by load | a ray | by shape, both branches in one loop |
    /// | any other | by arc length | by load | traced | traced |
    ///
    /// Of the others, those whose load does not keep one direction are read from a table of their contacts. The first set of a model makes
    /// it, in a tenth of a second; copies of the model share it.
    ///
    /// Contacts nearer to the base than a thousandth of the length are left out.
    ///
    /// # Errors
    /// Usage: a value that is not finite; the small-angle regime of a whisker that has none.
    pub fn new(model: &ContactModel, sensor: VirtualSensor, value: f64, nodes: usize) -> Result<Self> {
        Reading::exact(sensor, value).check()?;
        let large = model;
        let model = match sensor {
            VirtualSensor::Moment(regime) => model.in_regime(regime, value)?,
            _ => model.clone(),
        };
        let (curves, error) = exact_curves(&model, sensor, value, nodes.max(8));
        let curves: Vec<ContactCurve> = curves.into_iter().map(ContactCurve::new).collect();
        let sag = curves.iter().map(ContactCurve::sag).fold(0.0, f64::max);
        let small = if model.is_small_angle() { small_angle_error(large, &curves) } else { 0.0 };
        Ok(Self { sensor, value, curves, tolerance: sag + small + error, model })
    }

    /// The model whose contacts these are; small-angle where that regime was chosen.
    #[must_use]
    pub fn model(&self) -> &ContactModel {
        &self.model
    }

    /// Whether no contact explains the reading.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.curves.is_empty()
    }

    /// How far `point` (m, whisker frame) is from the chords (m); infinite for the empty set.
    #[must_use]
    pub fn distance(&self, point: Vec2) -> f64 {
        let to_link = |w: &[Contact]| {
            let (a, along) = (w[0].position, w[1].position - w[0].position);
            let t = ((point - a).dot(along) / along.norm_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
            point.distance(a + along * t)
        };
        let of_curve = |curve: &ContactCurve| match curve.contacts() {
            [only] => point.distance(only.position),
            contacts => contacts.windows(2).map(to_link).fold(f64::INFINITY, f64::min),
        };
        self.curves.iter().map(of_curve).fold(f64::INFINITY, f64::min)
    }
}

/// How far the small-angle contacts are from those of the elastica with the same moment and arc length (m).
///
/// Of a moment's two shapes the less bent one counts: the small-angle regime is the assumption that it is this one.
fn small_angle_error(large: &ContactModel, curves: &[ContactCurve]) -> f64 {
    let error = |small: &Contact| {
        let mut force = small.force;
        for _ in 0..20 {
            let Some(contact) = large.contact(force, small.s_a) else { return f64::INFINITY };
            if (contact.moment - small.moment).abs() <= 1e-9 * small.moment.abs() {
                return contact.position.distance(small.position);
            }
            // The moment is force times a lever that changes slowly.
            force *= small.moment / contact.moment;
        }
        f64::INFINITY
    };
    let contacts = curves.iter().flat_map(ContactCurve::contacts);
    SAFETY * contacts.step_by(4).map(error).fold(0.0, f64::max)
}
