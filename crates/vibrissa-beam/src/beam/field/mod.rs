//! A whisker as a table: everything that a contact force does to it, over two numbers.
//!
//! With the tip in contact, an equilibrium is named by two numbers, the tilt of the force from the whisker's normal at the
//! tip and the force: the shape follows by one march from the tip to the base, without a search. All else (slope, tip,
//! base moment, energy, direction of the force) is smooth over this chart, and every branch is a region of it.
//! [`TipField`] tabulates it once for a whisker, with a bound on the error, and answers in nanoseconds.

mod axis;
mod bicubic;
mod bytes;
mod cells;
mod chart;
mod enclosure;
mod ends;
mod errors;
mod image;
mod index;
mod panels;
mod search;
mod sheet;
mod sheet_build;
mod side;
mod state;
mod table;
mod tip;
mod unit;

pub use enclosure::TipBox;
pub use sheet::{BLOCK, ContactSheet, Read, SheetCell, SheetContact};
pub use side::{SideField, SideState};
pub use state::{FieldErrors, PositionRates, Quantities, ReadingRates, TipState};
pub use tip::TipField;
