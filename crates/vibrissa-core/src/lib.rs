//! The localization core of vibrissa: from moments and odometry to robot states on a planar map. It knows no files.
//!
//! | step | from | to | where |
//! | --- | --- | --- | --- |
//! | sensor log | rows of a robot | odometry and readings | [`flow::sensor_log`] |
//! | moment | readings | smoothed moments over a short history | [`flow::moment`] |
//! | contact set | a moment | contacts in the whisker frame, every branch | [`flow::contact_set`] |
//! | preimage | contact sets, a map | robot states that explain the reading | [`flow::preimage`] |
//! | state set | preimages, motion | states that explain all readings so far | [`flow::state_set`] |
//! | pose | a state set | a verdict, places, an estimate and its extent | [`flow::pose`] |
//!
//! The crate `vibrissa` adds readers, simulator and figures, and re-exports all of this; take this one alone for a browser
//! or a robot that gets its map by other means. SI everywhere, frames as in REP 103.

pub mod config;
pub mod contact;
pub mod control;
mod coroutine;
pub mod flow;
pub mod localizer;
mod stop;
mod work_budget;
pub mod world;

pub use localizer::Localizer;
pub use stop::Stop;
pub use vibrissa_beam::{Error, Result, beam, error, linear_algebra, math, plane, sensing, sets};
pub use work_budget::WorkBudget;
