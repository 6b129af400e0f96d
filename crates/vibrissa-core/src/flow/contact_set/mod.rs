//! The third door: which contacts explain a reading.
//!
//! A reading does not give a contact point, it gives a set. One contact of a whisker is two numbers, the force and the arc
//! length at which it acts; a virtual sensor reads one function of these two, so that an exact reading leaves curves and
//! a reading with a bound on its error leaves regions \[routray, section "Virtual Whisker Sensor Models and Preimages"\].
//!
//! | type | is | exact to |
//! | --- | --- | --- |
//! | [`ContactSet`] | the curves of one exact reading, every branch | its `tolerance`, some micrometres |
//! | [`ContactRegion`] | all contacts that explain any number of readings with bounds | covers them, to its resolution |
//! | [`intersect`] | where two sets of curves meet, in any frame | crossings to rounding |
//! | [`tip`] | contacts at the tip against a smooth wall, one moment | 2e-4 of the length |
//!
//! `docs/contact-sets.md` tells how they are computed and what they guarantee.

mod contact;
mod curve;
mod family;
mod intersection;
mod ladder;
mod leaning;
mod level;
mod model;
mod paving;
mod region;
mod runs;
mod small_beam;
pub mod tip;
mod trace;
mod virtual_sensor;

pub use contact::{Contact, Limits, Parts};
pub use curve::{ContactCurve, ContactSet};
pub use intersection::{Meeting, PlacedSet, intersect, intersect_all};
pub(crate) use ladder::Ladder;
pub use model::ContactModel;
pub use region::{ContactCell, ContactRegion, Resolution};
pub use tip::{TipContact, TipContactSet};
pub use virtual_sensor::{MomentRegime, Reading, VirtualSensor};
