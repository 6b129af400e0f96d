//! vibrissa: where a robot is, by touch.
//!
//! A whisker is a thin beam on a base that measures one number, the bending moment. From that number, the robot's motion
//! and a map of the plane, this crate finds every robot state that explains what was felt, step by step as in *Mobile
//! Robot Localization Using a Novel Whisker-Like Sensor* \[routray\]:
//!
//! | door | from | to | where |
//! | --- | --- | --- | --- |
//! | sensor log | a file | rows of odometry and readings | [`read_log`], [`flow::sensor_log`] |
//! | moment | readings | smoothed moments over a short history | [`flow::moment`] |
//! | contact set | a moment | tip contacts in the whisker frame, every branch | [`flow::contact_set`] |
//! | preimage | contact sets, a map | robot states that explain the reading | [`flow::preimage`] |
//! | state set | preimages, motion | states that explain all readings so far | [`flow::state_set`] |
//! | pose | a state set | a verdict, places, an estimate and its extent | [`flow::pose`] |
//!
//! [`localize`] is the one-call door for whole logs, [`Localizer`] the same row by row. One dependency is enough: this
//! crate re-exports the others.
//!
//! | crate | here | what |
//! | --- | --- | --- |
//! | `vibrissa-beam` | [`beam`], [`plane`], [`sets`], [`sensing`] | whisker mechanics, without an operating system |
//! | `vibrissa-core` | [`world`], [`contact`], [`flow`], [`localizer`], [`config`] | localization, without files |
//! | `vibrissa-io` | [`io`] | readers and writers of files |
//! | `vibrissa-sim` | [`sim`] | the simulator |
//! | `vibrissa-figure` | [`figure`] | SVG figures |
//!
//! SI everywhere: m, rad, s, N, N m. Frames are right-handed, x forward, y left, angles counter-clockwise (REP 103);
//! `world_from_robot` takes robot coordinates to world coordinates. The undeflected whisker points along +x of its own
//! frame, and a push towards +y is a positive moment. Nothing here reads a clock, prints, or depends on threads.
//!
//! ```
//! use vibrissa::{Method, Robot, Status, localize, tasks::demo};
//!
//! let (arena, sweep) = (demo::arena()?, demo::sweep(1)?);
//! let answer = localize(&sweep.log, &arena, &Robot::default(), &Method::default(), &mut |_| {})?;
//! let truth = sweep.truth.last().map(|t| t.map_from_robot.position());
//!
//! assert_eq!(answer.status, Status::Localized);
//! let error = answer.estimate.zip(truth).map(|(found, truth)| found.position().distance(truth));
//! assert!(error.is_some_and(|metres| metres < 1e-3));
//! # Ok::<(), vibrissa::Error>(())
//! ```
//!
//! Row by row, for a robot that is running:
//!
//! ```
//! use vibrissa::{Localizer, Method, Robot, tasks::demo};
//!
//! let (map, robot, sweep) = (demo::arena()?, Robot::default(), demo::sweep(1)?);
//! let mut localizer = Localizer::new(&map, &robot, &sweep.log.channels, &Method::default())?;
//! for row in &sweep.log.rows {
//!     localizer.step(row)?;
//! }
//! let truth = sweep.truth.last().map(|t| t.map_from_robot.position());
//! let now = localizer.estimate().pose().zip(truth).map(|(found, truth)| found.position().distance(truth));
//! assert!(now.is_some_and(|metres| metres < 3e-3));
//! # Ok::<(), vibrissa::Error>(())
//! ```

#[cfg(doctest)]
mod book;
mod least_squares;
pub mod tasks;

pub use tasks::{localize, localize_while};
pub use vibrissa_core::flow::pose::{Localization, Status};
pub use vibrissa_core::flow::sensor_log::SensorLog;
pub use vibrissa_core::localizer::{Estimator, Localizer, Method};
pub use vibrissa_core::world::{Map, Robot};
pub use vibrissa_core::{
    Error, Result, Stop, WorkBudget, beam, config, contact, control, error, flow, linear_algebra, localizer, plane,
    sensing, sets, world,
};
pub use vibrissa_figure as figure;
pub use vibrissa_io as io;
pub use vibrissa_io::{read_calibration, read_log, read_map, read_robot};
pub use vibrissa_sim as sim;
pub use vibrissa_sim::{Scenario, Sweep, simulate};
