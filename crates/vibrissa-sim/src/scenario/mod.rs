//! Scenarios: a map, a robot, a way and the errors of its senses, in one file; and the sweep that comes of them.
//!
//! | file | what it knows |
//! | --- | --- |
//! | `reader` | the scenario file as a whole |
//! | `world_section` | its map, robot and outline |
//! | `path_section` | its way |
//! | `noise_section` | the noise of its readings and odometry |
//! | `errors_section` | how robot, map and readings are other than declared |
//! | `sensing_section` | its magnetometer and other sensors, and what is logged |
//! | `points` | points and lists of points in the file |
//! | `route` | poses over time from legs |
//! | `check` | whether the way is free |

mod check;
mod errors_section;
mod noise_section;
mod path_section;
mod points;
mod reader;
mod route;
mod sensing_section;
mod world_section;

use crate::flow::pose::StampedPose;
use crate::plane::Vec2;
use crate::simulate::recorder::{Recorder, Recording, SerialLayout, serial_text};
use crate::simulate::{SimulateOptions, Sweep, SweepNoise, simulate_until};
use crate::world::{Map, Robot};
use crate::{Error, Result, Stop};
use std::path::PathBuf;

/// Everything that a simulated sweep needs, as read from a scenario file.
#[derive(Clone, Debug)]
pub struct Scenario {
    /// What it is for, in a line; the file's name where it does not say.
    pub title: String,
    /// The map.
    pub map: Map,
    /// The map's file; none when it is written in the scenario.
    pub map_file: Option<PathBuf>,
    /// The robot with its whiskers, as it is declared.
    pub robot: Robot,
    /// The robot's outline in its own frame (m), counter-clockwise or clockwise; empty when it has none.
    pub outline: Vec<Vec2>,
    /// The robot's true way, map frame.
    pub path: Vec<StampedPose>,
    /// How it is recorded; the seed of everything random is in its noise.
    pub recorder: Recorder,
    /// Who speaks on a serial line, if anybody.
    pub serial: Option<SerialLayout>,
    /// The file, for messages.
    source: PathBuf,
    /// From which time on the way follows which line of the file.
    legs: Vec<LegStart>,
}

/// When a leg starts, and where it is written.
#[derive(Clone, Copy, Debug)]
struct LegStart {
    t: f64,
    line: usize,
}

/// What comes of a scenario.
#[derive(Clone, Debug)]
pub struct Simulation {
    /// The robot as it is: the declared one with the scenario's errors.
    pub robot: Robot,
    /// The sweep without any error: truth, contacts, exact moments, events.
    pub sweep: Sweep,
    /// What is recorded of it.
    pub recording: Recording,
    /// The serial line's text, where the scenario asks for it.
    pub serial: Option<String>,
    /// What looks wrong but could be simulated, for people.
    pub warnings: Vec<String>,
}

impl Scenario {
    /// Simulates the scenario; the same seed gives the same bytes.
    ///
    /// # Errors
    ///
    /// What the simulator cannot follow: the message says which whisker, when and where, and names the file.
    pub fn simulate(&self) -> Result<Simulation> {
        self.simulate_watched(&mut |_| {})
    }

    /// As [`Scenario::simulate`]; `observer` is called with the number of poses done, of which there are as many for each
    /// whisker as the path has.
    ///
    /// # Errors
    ///
    /// As [`Scenario::simulate`].
    pub fn simulate_watched(&self, observer: &mut dyn FnMut(usize)) -> Result<Simulation> {
        self.simulate_until(&Stop::default(), observer)
    }

    /// As [`Scenario::simulate_watched`], until `stop` is asked for: the sweep then ends with the last pose that was come to.
    ///
    /// # Errors
    ///
    /// As [`Scenario::simulate`], and a stop before the first pose.
    pub fn simulate_until(&self, stop: &Stop, observer: &mut dyn FnMut(usize)) -> Result<Simulation> {
        let sweep = self.sweep_until(stop, observer)?;
        if sweep.truth.is_empty() {
            return Err(Error::data("the simulation was stopped before its first pose"));
        }
        self.recorded(sweep)
    }

    /// The first half of [`Scenario::simulate_until`]: the exact sweep of the robot as it is, of no pose where it was stopped before the first.
    ///
    /// # Errors
    ///
    /// As [`Scenario::simulate`].
    pub fn sweep_until(&self, stop: &Stop, observer: &mut dyn FnMut(usize)) -> Result<Sweep> {
        let exact = SweepNoise { seed: self.seed(), ..SweepNoise::none() };
        let options = SimulateOptions::default();
        let in_file = |error: Error| error.into_data().in_file(&self.source);
        let truth = &self.recorder.truth;
        let robot = truth.true_robot(&self.robot).map_err(in_file)?;
        let (world, path) = (truth.world(&self.map).map_err(in_file)?, truth.path_in_world(&self.path));
        let swept = simulate_until(&world, &robot, &path, &exact, &options, stop, observer);
        let again = |path: &[StampedPose]| simulate_until(&world, &robot, path, &exact, &options, stop, &mut |_| {});
        swept.map_err(|error| {
            let line = self.leg_at_fault(&path, &again);
            // Where it was stopped meanwhile the leg is not known.
            if stop.is_asked() { in_file(error) } else { in_file(error).at_line(line) }
        })
    }

    /// The second half: what is recorded of an exact sweep, in which there is a pose.
    ///
    /// # Errors
    ///
    /// As [`Scenario::simulate`].
    pub fn recorded(&self, mut sweep: Sweep) -> Result<Simulation> {
        let in_file = |error: Error| error.into_data().in_file(&self.source);
        let truth = &self.recorder.truth;
        let robot = truth.true_robot(&self.robot).map_err(in_file)?;
        let recording = self.recorder.record(&robot, &sweep).map_err(in_file)?;
        truth.put_on_declared_map(&mut sweep);
        let serial = self.serial.map(|layout| serial_text(&recording, layout)).transpose().map_err(in_file)?;
        let mut warnings = self.map.warnings.clone();
        warnings.extend(recording.log.warnings.iter().cloned());
        if sweep.contacts.is_empty() {
            warnings.push("no whisker touches anything along this path".into());
        }
        Ok(Simulation { robot, sweep, recording, serial, warnings })
    }

    /// The line of the leg on which the sweep first fails: the legs before it can be followed.
    fn leg_at_fault(&self, path: &[StampedPose], sweep: &dyn Fn(&[StampedPose]) -> Result<Sweep>) -> usize {
        let until = |t: f64| &path[..path.partition_point(|pose| pose.t <= t)];
        let followed = |pair: &[LegStart]| sweep(until(pair[1].t)).is_ok();
        let pairs: Vec<&[LegStart]> = self.legs.windows(2).collect();
        let leg = pairs.partition_point(|pair| followed(pair));
        self.legs.get(leg).map_or(1, |leg| leg.line)
    }

    /// The seed of everything random.
    #[must_use]
    pub fn seed(&self) -> u64 {
        self.recorder.noise.seed
    }

    /// The same scenario with another seed.
    #[must_use]
    pub fn with_seed(mut self, seed: u64) -> Self {
        self.recorder.noise.seed = seed;
        self
    }
}
