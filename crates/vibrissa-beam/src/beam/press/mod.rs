//! Every way in which one wall can bend a whisker, tabulated once, with bounds on what lies between the nodes.
//!
//! A wall of normal direction `psi` (whisker frame) that is pressed against a uniform whisker first holds its tip, then
//! its side. With `u` the slope at the contact, tip contacts are the pairs `(psi, u)` with
//! `max(0, 2 (psi - pi)) <= u <= psi - pi/2`: at the upper end the force is normal to the whisker, at the lower end the
//! whisker is straight, or its base moment vanishes. Beyond the upper end the contact moves along the side, where
//! `u = psi - pi/2` and the moment names the arc length. So `(psi, share of the range of u)` is one smooth sheet of tip
//! contacts without folds, and `psi` alone names all side contacts up to scale. With friction the force leaves the
//! normal by up to the friction angle, which widens both.
//!
//! A tip that is held, in a corner or by friction, and pressed along the whisker bends it into an S. The loaded whisker is
//! a pendulum in time; then the base lies in its second half swing, and again each pair `(psi, u)` of the same range
//! names one shape: a second sheet, whose moments have the other sign. It goes on where the first sheet ends with a
//! moment of zero. Shapes with two inflections between base and contact are unstable, even with a held tip; those with
//! one are stable only where friction or a concave boundary holds the contact.
//!
//! All this is of uniform whiskers; [`RodPressTable`] is the table of any other, [`LeaningPressTable`] of uniform ones that lean against upright
//! walls.
//!
//! All is dimensionless: lengths over the whisker's, moments times length over flexural rigidity (at the base). The slope at the
//! contact is towards +y; the other side is the mirror image.

mod builder;
mod forest;
mod leaning;
mod patch;
mod rod;
mod sheet;
mod side;
mod slice;

pub use builder::PressTableBuilder;
pub use leaning::LeaningPressTable;
pub use rod::{RodContacts, RodPressTable};
pub use slice::{PressEntry, PressSlice, Span};

use crate::plane::Vec2;
use alloc::boxed::Box;
use alloc::vec::Vec;
use sheet::{PressBend, PressSheet};
use side::Sides;

/// The deviation measured between the nodes is multiplied by this to bound it: twice what a smooth sheet needs.
const SAFETY: f64 = 3.0;
/// What rounding may add to a bound.
const ROUNDING: f64 = 1e-9;

/// A tip contact: moment and tip.
#[derive(Clone, Copy, Debug)]
struct PressNode {
    moment: f64,
    tip: Vec2,
}

/// How far a sheet leaves its bilinear interpolation within one cell.
#[derive(Clone, Copy, Debug)]
struct SheetError {
    moment: f64,
    tip: f64,
}

/// One whisker's contacts with walls of every direction.
#[derive(Clone, Debug)]
pub struct PressTable {
    /// Friction angle (rad).
    slack: f64,
    /// Largest slope (rad).
    steepest: f64,
    /// Columns of the table: directions (rad).
    directions: Vec<f64>,
    /// The direction in the middle of each column, as a vector.
    middles: Vec<Vec2>,
    /// Tip contacts without an inflection, and with one.
    plain: PressSheet,
    inflected: PressSheet,
    /// Side contacts likewise; with an inflection only friction can hold a side.
    sides: Sides,
    inflected_sides: Option<Sides>,
}

impl PressTable {
    /// The table with `columns` directions for each quarter turn and `rows` steps of bending, for walls with this
    /// friction angle (rad, below 1) and contacts with slopes up to `steepest` (rad, up to pi).
    #[must_use]
    pub fn new(columns: usize, rows: usize, friction_angle: f64, steepest: f64) -> Self {
        PressTableBuilder::new(columns, rows, friction_angle, steepest).finish()
    }

    fn of([plain, inflected]: [PressSheet; 2], directions: Vec<f64>, (slack, steepest): (f64, f64)) -> Self {
        let sides = |bend| Sides::new(&directions, bend, slack);
        Self {
            slack,
            steepest,
            plain,
            inflected,
            sides: sides(PressBend::Plain),
            inflected_sides: (slack > 0.0).then(|| sides(PressBend::Inflected)),
            middles: directions.windows(2).map(|d| Vec2::from_angle(0.5 * (d[0] + d[1]))).collect(),
            directions,
        }
    }

    /// The same whisker by half as many columns and rows, without computing it anew; itself if their number is odd.
    #[must_use]
    pub fn coarser(&self) -> Self {
        let columns = self.directions.len() - 1;
        if columns % 2 == 1 || self.plain.rows % 2 == 1 {
            return self.clone();
        }
        let directions = self.directions.iter().step_by(2).copied().collect();
        Self::of([self.plain.coarser(), self.inflected.coarser()], directions, (self.slack, self.steepest))
    }

    /// The friction angle (rad).
    #[must_use]
    pub fn friction_angle(&self) -> f64 {
        self.slack
    }
}

/// The table of a whisker that is uniform, leaning, or any other.
#[derive(Clone, Debug)]
pub enum ContactTable {
    /// By the closed form.
    Uniform(Box<PressTable>),
    /// By the closed form in the plane in which a wall bends a whisker that leans.
    Leaning(Box<LeaningPressTable>),
    /// By marches.
    Rod(RodPressTable),
}

impl From<PressTable> for ContactTable {
    fn from(table: PressTable) -> Self {
        Self::Uniform(Box::new(table))
    }
}

impl From<LeaningPressTable> for ContactTable {
    fn from(table: LeaningPressTable) -> Self {
        Self::Leaning(Box::new(table))
    }
}

impl ContactTable {
    /// The friction angle (rad).
    #[must_use]
    pub fn friction_angle(&self) -> f64 {
        match self {
            Self::Uniform(table) => table.friction_angle(),
            Self::Leaning(_) => 0.0,
            Self::Rod(table) => table.friction_angle(),
        }
    }

    /// The contacts that push to the left (`side` 1), or the mirror image of those that push to the right (-1), and cause a
    /// dimensionless moment between `lo` and `hi`, as that image has it.
    #[must_use]
    pub fn slice(&self, side: f64, lo: f64, hi: f64) -> PressSlice {
        match self {
            Self::Uniform(table) => table.slice(lo, hi),
            Self::Leaning(table) => table.slice(side, lo, hi),
            Self::Rod(table) => table.slice(side, lo, hi),
        }
    }
}
