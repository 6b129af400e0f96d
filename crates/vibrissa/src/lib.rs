//! vibrissa: where a robot is, by touch.
//!
//! A whisker is a thin beam on a base that measures one number, the bending moment. From that number, the robot's motion
//! and a map of the plane, this crate finds every robot state that explains what was felt, step by step as in *Mobile
//! Robot Localization Using a Novel Whisker-Like Sensor* \[routray\]:
//!
//! | door | from | to | where |
//! | --- | --- | --- | --- |
//! | sensor log | a file | rows of odometry and readings | [`flow::sensor_log`] |
//! | moment | readings | smoothed moments over a short history | [`flow::moment`] |
//! | contact set | a moment | tip contacts in the whisker frame, every branch | [`flow::contact_set`] |
//! | preimage | contact sets, a map | robot states that explain the reading | [`flow::preimage`] |
//! | state set | preimages, motion | states that explain all readings so far | [`flow::state_set`] |
//! | pose | a state set | a verdict, places, an estimate and its extent | [`flow::pose`] |
//!
//! [`localize`] is the one-call door for whole logs, [`Localizer`] the same row by row. [`beam`] stands on its own for
//! whisker mechanics, [`tasks::simulate`](mod@tasks::simulate) makes sweeps to try things on.
//!
//! SI everywhere: m, rad, s, N, N m. Frames are right-handed, x forward, y left, angles counter-clockwise (REP 103);
//! `world_from_robot` takes robot coordinates to world coordinates. The undeflected whisker points along +x of its own
//! frame, and a push towards +y is a positive moment. Nothing here reads a clock, prints, or depends on threads.
//!
//! ```
//! use vibrissa::flow::pose::Status;
//! use vibrissa::world::Robot;
//! use vibrissa::{LocalizeOptions, localize, tasks::demo};
//!
//! let (arena, sweep) = (demo::arena()?, demo::sweep(1)?);
//! let answer = localize(&sweep.log, &arena, &Robot::default(), &LocalizeOptions::default(), &mut |_| {})?;
//! let truth = sweep.truth.last().map(|t| t.map_from_robot.position());
//!
//! assert_eq!(answer.status, Status::Localized);
//! let error = answer.estimate.zip(truth).map(|(found, truth)| found.position().distance(truth));
//! assert!(error.is_some_and(|metres| metres < 1e-3));
//! # Ok::<(), vibrissa::Error>(())
//! ```

pub mod beam;
#[cfg(doctest)]
mod book;
pub mod config;
pub mod error;
pub mod figure;
pub mod flow;
mod least_squares;
mod linear_algebra;
pub mod localizer;
pub mod plane;
pub mod sets;
pub mod tasks;
pub mod world;

pub use error::{Error, Result};
pub use localizer::{Localizer, PossibilisticLocalizer};
pub use tasks::{LocalizeOptions, localize, localize_while};
