//! What a robot would record: a quasi-static sweep of whiskers whose tips touch a map.
//!
//! Slow motion, no friction: the force on a tip is normal to the boundary, and the whisker is in equilibrium at every
//! instant. Each room of this folder knows one thing:
//!
//! | file | what it knows |
//! | --- | --- |
//! | `foothold` | where on a boundary the tip stands, and what comes next along it |
//! | `equilibrium` | the whisker whose tip stands there |
//! | `touch` | when a free whisker first meets a boundary; whether a bent one touches with its side |
//! | `follow` | one whisker over time: onset, sliding, corners, lift-off, snap |
//! | `noise` | readings and odometry from exact ones |
//! | `path` | poses from waypoints |
//! | `files` | logs and touches as text |

pub mod discrete;
mod equilibrium;
mod files;
mod follow;
mod foothold;
mod noise;
mod path;
mod touch;

pub use files::{contacts_csv, log_csv};
pub use noise::SweepNoise;
pub use path::{Pace, path_through};

use crate::flow::pose::{Event, StampedPose};
use crate::flow::sensor_log::{Channel, LogRow, Quantity, SensorLog};
use crate::plane::Vec2;
use crate::world::{Map, Robot};
use crate::{Error, Result};
use follow::Follower;

/// One whisker in contact at one row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TipTouch {
    /// When (s).
    pub t: f64,
    /// Index of the row.
    pub row: usize,
    /// Index of the whisker.
    pub whisker: usize,
    /// The tip, map frame (m).
    pub position: Vec2,
    /// The force on the tip, map frame (N).
    pub force: Vec2,
    /// The elastic energy of the whisker (J).
    pub energy: f64,
}

/// A simulated sweep: what the robot records, and the truth behind it.
#[derive(Clone, Debug, PartialEq)]
pub struct Sweep {
    /// Odometry from the first pose on, and readings, both with noise.
    pub log: SensorLog,
    /// The robot in the map frame, one pose for each row.
    pub truth: Vec<StampedPose>,
    /// Every touch, in row order.
    pub contacts: Vec<TipTouch>,
    /// The moments without noise (N m): for each row one for each whisker.
    pub exact_moments: Vec<Vec<f64>>,
    /// Onsets, lift-offs and snaps, in time order.
    pub events: Vec<Event>,
}

/// Sweeps `robot` along `path` (map frame, increasing time) on `map` and records what it feels.
///
/// The whiskers' tips touch the boundary without friction, in equilibrium at every instant; the branch of solutions is
/// followed by continuation, and where it ends the whisker snaps free. In corners the tip is caught as long as the
/// force points between the two normals. A fixed seed gives a fixed answer. Moments are exact to about 1e-10 relative.
///
/// # Errors
///
/// Robots that are not covered (tapered, curved, elastic base, friction), an empty path, a start in contact, and
/// contact with the side of a whisker: the message says which whisker, when and where.
pub fn simulate_tip_sweep(map: &Map, robot: &Robot, path: &[StampedPose], noise: &SweepNoise) -> Result<Sweep> {
    noise.check()?;
    path::check(path)?;
    let mut sweep = Sweep {
        log: SensorLog { channels: channels(robot), ..SensorLog::default() },
        truth: path.to_vec(),
        contacts: Vec::new(),
        exact_moments: vec![Vec::with_capacity(robot.whiskers.len()); path.len()],
        events: Vec::new(),
    };
    for (index, whisker) in robot.whiskers.iter().enumerate() {
        whisker.beam.require_uniform()?;
        if whisker.friction > 0.0 {
            return Err(Error::data(format!("the whisker {} has friction", whisker.name))
                .value(whisker.friction)
                .allowed("0: this simulator knows frictionless contact only"));
        }
        let mut follower = Follower::start(map, whisker, path[0])?;
        for (row, pose) in path.iter().enumerate() {
            follower.advance(*pose, &mut sweep.events)?;
            sweep.exact_moments[row].push(follower.moment());
            sweep.contacts.extend(follower.touch(row, index));
        }
    }
    sweep.contacts.sort_by_key(|touch| (touch.row, touch.whisker));
    sweep.events.sort_by(|a, b| a.t.total_cmp(&b.t));
    sweep.log.rows = record(robot, &sweep, noise);
    Ok(sweep)
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
