//! What a robot would record: a quasi-static sweep of whiskers that touch a map.
//!
//! Slow motion: every whisker is in equilibrium at every instant. Each room of this folder knows one thing:
//!
//! | file | what it knows |
//! | --- | --- |
//! | [`crate::contact::quasi_static`] | one contact: tip, corner, side; which follows which, stick and slip |
//! | `discrete/` | any number of contacts: a chain of links whose energy is minimised |
//! | `follow/` | one whisker over time: onset, contact, snap, lift-off; which solver is in charge |
//! | `report` | what a contact is, for the caller |
//! | `noise` | readings and odometry from exact ones |
//! | `drive` | a robot that is steered, pose by pose |
//! | `recorder` | logs of moments, flux or counts with everything that disturbs them |
//! | `path` | poses from waypoints |
//! | `shapes` | the whiskers' shapes, for drawing |
//! | `files` | logs and touches as text |

pub mod discrete;
mod drive;
mod files;
mod follow;
mod noise;
mod path;
pub mod recorder;
mod report;
mod shapes;

pub use drive::{Drive, Stage};
pub use files::contacts_csv;
pub use noise::SweepNoise;
pub use path::{Pace, path_through};
pub(super) use path::{leg_time, sampled};
pub use shapes::{SweptShape, shapes};

use crate::contact::Boundaries;
use crate::contact::quasi_static::LoadedWhisker;
use crate::flow::pose::{Event, StampedPose};
use crate::flow::sensor_log::{Channel, LogRow, Quantity, SensorLog};
use crate::plane::Vec2;
use crate::world::{Map, MountedWhisker, Robot};
use crate::{Error, Result, Stop};
use follow::Follower;
pub use report::{Grip, Part, Touch};

/// The links of the discrete rod unless said otherwise: its moments are then right to 6e-5 of themselves.
const LINKS: usize = 90;

/// Which solver finds the equilibria.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Solver {
    /// One contact by the elastica, exact and fast; the discrete rod where one contact does not say it all.
    #[default]
    Auto,
    /// The discrete rod throughout: slow, without friction, independent of all formulas.
    DiscreteRod,
}

/// How a sweep is simulated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SimulateOptions {
    /// Which solver finds the equilibria.
    pub solver: Solver,
    /// Links of the discrete rod, 4 to 2000.
    pub links: usize,
    /// Points of each whisker's shape that are kept for every row; 0 keeps none.
    pub shape_points: usize,
}

impl Default for SimulateOptions {
    fn default() -> Self {
        Self { solver: Solver::default(), links: LINKS, shape_points: 0 }
    }
}

/// The shape of a whisker at one row.
#[derive(Clone, Debug, PartialEq)]
pub struct Shape {
    /// Index of the row.
    pub row: usize,
    /// Index of the whisker.
    pub whisker: usize,
    /// Points from base to tip, map frame (m); a free straight whisker has two, a discrete rod its nodes.
    pub points: Vec<Vec2>,
}

/// A simulated sweep: what the robot records, and the truth behind it.
#[derive(Clone, Debug, PartialEq)]
pub struct Sweep {
    /// Odometry from the first pose on, and readings, both with noise.
    pub log: SensorLog,
    /// The robot in the map frame, one pose for each row.
    pub truth: Vec<StampedPose>,
    /// Every touch, in order of rows, whiskers and from base to tip.
    pub contacts: Vec<Touch>,
    /// The moments without noise (N m): for each row one for each whisker.
    pub exact_moments: Vec<Vec<f64>>,
    /// What happened to the whiskers, in time order; see [`simulate`].
    pub events: Vec<Event>,
    /// The whiskers' shapes, in order of rows and whiskers; empty unless asked for.
    pub shapes: Vec<Shape>,
}

/// Sweeps `robot` along `path` (map frame, increasing time) on `map` and records what it feels.
///
/// Every whisker is in equilibrium at every instant, at its tip, its side or both; the branch of solutions is followed by
/// continuation. A fixed seed gives a fixed answer. Moments of one contact are exact to about 1e-10 relative for uniform
/// whiskers and 1e-8 for others, those of several contacts to about 1e-4 (by the discrete rod).
///
/// | event | means |
/// | --- | --- |
/// | `onset` | a free whisker touches |
/// | `lift_off` | a whisker is free again, without a jump or off the end of a wall |
/// | `side_contact`, `tip_contact` | the contact went over from tip to side, or back |
/// | `snap` | the equilibrium vanished; the detail says where the whisker came to rest |
/// | `discrete_rod` | one contact of the first mode is not enough: the discrete rod goes on; the detail says where it touches |
/// | `single_contact` | it is enough again |
/// | `unsolved` | the discrete rod was still moving after the most steps; the best shape reached is used |
/// | `lost`, `found` | a boundary stopped the base, or no shape clear of all boundaries was found; the whisker is clear again. In between the last moment stays |
///
/// Friction is Coulomb's, with the whisker's bound as its coefficient. It acts on single contacts only.
///
/// # Errors
///
/// Whiskers that make no sense, an empty path, options out of range, a start in contact, and a discrete rod that takes more than
/// [`MOST_UNREST`](vibrissa_core::config::budgets::MOST_UNREST) to come to rest: the message says which whisker and where.
pub fn simulate(
    map: &Map,
    robot: &Robot,
    path: &[StampedPose],
    noise: &SweepNoise,
    options: &SimulateOptions,
) -> Result<Sweep> {
    simulate_watched(map, robot, path, noise, options, &mut |_| {})
}

/// As [`simulate`]; `observer` is called with the number of poses done, of which there are as many for each whisker as the
/// path has.
///
/// # Errors
///
/// As [`simulate`].
pub fn simulate_watched(
    map: &Map,
    robot: &Robot,
    path: &[StampedPose],
    noise: &SweepNoise,
    options: &SimulateOptions,
    observer: &mut dyn FnMut(usize),
) -> Result<Sweep> {
    simulate_until(map, robot, path, noise, options, &Stop::default(), observer)
}

/// As [`simulate_watched`], until `stop` is asked for: the sweep then ends with the last pose that all whiskers have come to.
///
/// # Errors
///
/// As [`simulate`].
pub fn simulate_until(
    map: &Map,
    robot: &Robot,
    path: &[StampedPose],
    noise: &SweepNoise,
    options: &SimulateOptions,
    stop: &Stop,
    observer: &mut dyn FnMut(usize),
) -> Result<Sweep> {
    noise.check()?;
    path::check(path)?;
    let mut sweep = Sweep {
        log: SensorLog { channels: channels(robot), ..SensorLog::default() },
        truth: path.to_vec(),
        contacts: Vec::new(),
        exact_moments: vec![Vec::with_capacity(robot.whiskers.len()); path.len()],
        events: Vec::new(),
        shapes: Vec::new(),
    };
    let boundaries = Boundaries::new(map);
    let loaded = robot.whiskers.iter().map(loaded).collect::<Result<Vec<_>>>()?;
    let scene = |(whisker, loaded)| follow::Scene { map, boundaries: &boundaries, whisker, loaded, options, stop };
    let scenes = robot.whiskers.iter().zip(&loaded).map(scene);
    let mut followers = scenes.map(|scene| Follower::start(scene, path[0])).collect::<Result<Vec<_>>>()?;
    'path: for (row, pose) in path.iter().enumerate() {
        let events = sweep.events.len();
        for (index, follower) in followers.iter_mut().enumerate() {
            if !stop.is_asked() {
                follower.advance(*pose, &mut sweep.events)?;
            }
            if stop.is_asked() {
                sweep.end_before(row, events);
                break 'path;
            }
            sweep.exact_moments[row].push(follower.moment());
            sweep.contacts.extend(follower.touches(row, index));
            if options.shape_points > 0 {
                sweep.shapes.push(Shape { row, whisker: index, points: follower.shape(options.shape_points.max(2)) });
            }
            observer(row * robot.whiskers.len() + index + 1);
        }
    }
    sweep.contacts.sort_by_key(|touch| (touch.row, touch.whisker));
    sweep.shapes.sort_by_key(|shape| (shape.row, shape.whisker));
    sweep.events.sort_by(|a, b| a.t.total_cmp(&b.t));
    sweep.log.rows = record(robot, &sweep, noise);
    Ok(sweep)
}

impl Sweep {
    /// Forgets this row, which not all whiskers have come to, and the events after the first so many.
    fn end_before(&mut self, row: usize, events: usize) {
        self.truth.truncate(row);
        self.exact_moments.truncate(row);
        self.contacts.retain(|touch| touch.row < row);
        self.shapes.retain(|shape| shape.row < row);
        self.events.truncate(events);
    }
}

/// A whisker ready to be bent.
fn loaded(whisker: &MountedWhisker) -> Result<LoadedWhisker> {
    if !(whisker.friction >= 0.0 && whisker.friction.is_finite()) {
        return Err(Error::data(format!("the friction of the whisker {}", whisker.name))
            .value(whisker.friction)
            .allowed("0 or more"));
    }
    LoadedWhisker::new(&whisker.beam)
}

/// [`simulate`] with the default options.
///
/// # Errors
///
/// As [`simulate`].
pub fn simulate_tip_sweep(map: &Map, robot: &Robot, path: &[StampedPose], noise: &SweepNoise) -> Result<Sweep> {
    simulate(map, robot, path, noise, &SimulateOptions::default())
}

fn channels(robot: &Robot) -> Vec<Channel> {
    let alone = robot.whiskers.len() == 1;
    let name = |name: &String| if alone { String::new() } else { name.clone() };
    robot.whiskers.iter().map(|w| Channel { whisker: name(&w.name), quantity: Quantity::Moment }).collect()
}

/// The rows of the log: odometry from the origin on, and readings.
fn record(robot: &Robot, sweep: &Sweep, noise: &SweepNoise) -> Vec<LogRow> {
    let mut dice = noise.dice();
    let odometry = dice.odometry(sweep.truth.iter().map(|pose| pose.map_from_robot));
    let row = |((pose, odom_from_robot), exact): ((&StampedPose, _), &Vec<f64>)| LogRow {
        t: pose.t,
        odom_from_robot,
        readings: exact.iter().zip(&robot.whiskers).map(|(&h, w)| dice.reading(h, &w.noise)).collect(),
        heading: None,
        line: 0,
    };
    sweep.truth.iter().zip(odometry).zip(&sweep.exact_moments).map(row).collect()
}
