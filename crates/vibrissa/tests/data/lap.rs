//! Laps of a robot along the walls of random rooms, and what its whiskers read.

use super::random::Random;
use core::f64::consts::{FRAC_PI_2, PI, TAU};
use vibrissa::flow::pose::StampedPose;
use vibrissa::flow::sensor_log::{Channel, LogRow, Quantity, SensorLog};
use vibrissa::plane::{Curve, Pose2, Vec2, wrap_angle};
use vibrissa::sim::{Pace, SimulateOptions, Solver, SweepNoise, path_through, simulate};
use vibrissa::world::{Boundary, Map, MomentNoise, MountedWhisker, Robot, Role};

/// A room by its corners, counter-clockwise.
#[derive(Clone, Debug)]
pub(crate) struct Room {
    pub(crate) corners: Vec<Vec2>,
    pub(crate) map: Map,
}

/// What kind of room.
#[allow(dead_code, reason = "each program takes what it needs")]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// A rectangle.
    Rectangle,
    /// A rectangle without one of its corners.
    LShape,
    /// Five to seven walls at any angle.
    Polygon,
}

/// A room of a total wall length from `least` to `most` (m).
pub(crate) fn room(draw: &mut Random, kind: Kind, (least, most): (f64, f64)) -> Option<Room> {
    let at = Vec2::new;
    let aspect = draw.between(0.55, 1.0);
    let shape: Vec<Vec2> = match kind {
        Kind::Rectangle => vec![at(0.0, 0.0), at(1.0, 0.0), at(1.0, aspect), at(0.0, aspect)],
        Kind::LShape => {
            let (x, y) = (draw.between(0.45, 0.65), draw.between(0.4, 0.6) * aspect);
            vec![at(0.0, 0.0), at(1.0, 0.0), at(1.0, y), at(x, y), at(x, aspect), at(0.0, aspect)]
        }
        Kind::Polygon => {
            let count = draw.between(5.0, 8.0) as usize;
            let turn = TAU / count as f64;
            (0..count)
                .map(|k| Vec2::from_angle((k as f64 + draw.signed(0.2)) * turn) * draw.between(0.42, 0.58))
                .collect()
        }
    };
    let round: f64 = (0..shape.len()).map(|k| shape[k].distance(shape[(k + 1) % shape.len()])).sum();
    let size = draw.between(least, most) / round;
    let (turn, shift) = (draw.signed(PI), at(draw.signed(1.0), draw.signed(1.0)));
    let corners: Vec<Vec2> = shape.iter().map(|p| (*p * size).rotated(turn) + shift).collect();
    let map = Map::new(vec![Boundary::new(Role::Arena, Curve::polyline(&corners, true)?, None).ok()?]).ok()?;
    Some(Room { corners, map })
}

/// A robot with one whisker that trails on its right, and what is declared of it.
pub(crate) fn robot(draw: &mut Random) -> Robot {
    let mut whisker = MountedWhisker::default();
    whisker.robot_from_whisker = Pose2::new(draw.signed(5e-3), draw.signed(5e-3), -draw.between(2.1, 2.35));
    whisker.noise = MomentNoise { moment_relative: 0.05, moment_absolute: 2e-5 };
    Robot { whiskers: vec![whisker], ..Robot::default() }
}

/// The robot's way along the walls, counter-clockwise, for this length of wall (m) from a share of the first wall on.
pub(crate) fn way(room: &Room, draw: &mut Random, share: f64, length: f64) -> Option<Vec<StampedPose>> {
    let standoff = draw.between(0.040, 0.048);
    let count = room.corners.len();
    let corner = |k: usize| room.corners[k % count];
    let heading = |k: usize| (corner(k + 1) - corner(k)).angle();
    let inward = |k: usize| Vec2::from_angle(heading(k)).perp();
    // Where the lines beside two walls meet.
    let turning = |k: usize| -> Vec2 {
        let (a, b) = (Vec2::from_angle(heading(k)), Vec2::from_angle(heading(k + 1)));
        let (p, q) = (corner(k + 1) + inward(k) * standoff, corner(k + 1) + inward(k + 1) * standoff);
        p + a * ((q - p).cross(b) / a.cross(b))
    };
    let first = corner(0) + (corner(1) - corner(0)) * share + inward(0) * standoff;
    let (mut way, mut left, mut at, mut k) = (Vec::new(), length, first, 0);
    // From clear of the wall to beside it.
    let place = |p: Vec2, heading: f64| Pose2::new(p.x, p.y, heading);
    way.push(place(at + inward(0) * 0.04 - Vec2::from_angle(heading(0)) * 0.02, heading(0)));
    way.push(place(at, heading(0)));
    let mut turned = heading(0);
    while left > 0.0 {
        let goal = turning(k);
        let stretch = at.distance(goal);
        let along = (goal - at) * (1.0 / stretch);
        // The standoff wavers by a few millimetres.
        let steps = (stretch / 0.05).ceil().max(1.0);
        for step in 1..=steps as usize {
            let way_here = stretch * step as f64 / steps;
            if way_here > left {
                break;
            }
            let off = if (step as f64) < steps { draw.signed(2e-3) } else { 0.0 };
            way.push(place(at + along * way_here + inward(k) * off, turned));
        }
        left -= stretch;
        let turn = wrap_angle(heading(k + 1) - heading(k));
        if left <= 0.0 {
            break;
        }
        turned += turn;
        way.push(place(goal, turned));
        (at, k) = (goal, k + 1);
    }
    let last = way.last()?;
    let back = Vec2::from_angle(last.theta + FRAC_PI_2) * 0.04;
    way.push(Pose2::new(last.x + back.x, last.y + back.y, last.theta));
    let pace = Pace { speed: 0.1, turn_rate: 0.7, rate: draw.between(90.0, 150.0) };
    path_through(&way, &pace).ok()
}

/// The law of the readings' errors within their bound.
#[allow(dead_code, reason = "each program takes what it needs")]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Law {
    /// Evenly between the bounds.
    Even,
    /// At either end of the bound.
    Edge,
    /// A third of the bound, Gaussian, cut at the bound.
    Normal,
    /// Alike over a while: half of the bound wanders, half is even.
    Correlated,
}

/// How the odometry is wrong.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct OdometryError {
    /// Share by which ways are told too long.
    pub(crate) scale: f64,
    /// Drift of the heading (rad/m).
    pub(crate) drift: f64,
    /// Bound of the independent error of each step, relative to it.
    pub(crate) noise: f64,
}

/// A recorded lap: the log, and where the robot was.
pub(crate) struct Lap {
    pub(crate) log: SensorLog,
    #[allow(dead_code, reason = "each program takes what it needs")]
    pub(crate) truth: Vec<StampedPose>,
    /// Share of the rows in contact.
    #[allow(dead_code, reason = "each program takes what it needs")]
    pub(crate) touching: f64,
}

/// Records a way; none where the simulator does not follow it to the end.
pub(crate) fn record(
    map: &Map,
    robot: &Robot,
    path: &[StampedPose],
    law: Law,
    odometry: OdometryError,
    draw: &mut Random,
) -> Option<Lap> {
    let options = SimulateOptions { solver: Solver::default(), links: 24, ..SimulateOptions::default() };
    let sweep = simulate(map, robot, path, &SweepNoise::none(), &options).ok()?;
    if sweep.exact_moments.len() < path.len() {
        return None;
    }
    let noise = robot.whiskers[0].noise;
    let mut odom = Pose2::IDENTITY;
    let mut wander = draw.signed(1.0);
    let mut rows = Vec::with_capacity(path.len());
    for (k, pose) in path.iter().enumerate() {
        if k > 0 {
            let step = path[k - 1].map_from_robot.between(pose.map_from_robot);
            let way = step.position().norm();
            let grown = 1.0 + odometry.scale + draw.signed(odometry.noise);
            let turn = step.theta * (1.0 + draw.signed(odometry.noise)) + odometry.drift * way;
            odom = odom.compose(Pose2::new(step.x * grown, step.y * grown, turn));
        }
        wander = (0.98 * wander + draw.signed(0.35)).clamp(-1.0, 1.0);
        let share = match law {
            Law::Even => draw.signed(1.0),
            Law::Edge => draw.sign(),
            Law::Normal => ((0..12).map(|_| draw.unit()).sum::<f64>() - 6.0).clamp(-3.0, 3.0) / 3.0,
            Law::Correlated => 0.5 * (wander + draw.signed(1.0)),
        };
        let z = reading(sweep.exact_moments[k][0], &noise, share);
        rows.push(LogRow { t: pose.t, odom_from_robot: odom, readings: vec![z], heading: None, line: 0 });
    }
    let channels = vec![Channel { whisker: String::new(), quantity: Quantity::Moment }];
    let rows_in_contact = sweep.exact_moments.iter().filter(|moments| moments[0] != 0.0).count();
    Some(Lap {
        log: SensorLog { channels, rows, ..SensorLog::default() },
        truth: path.to_vec(),
        touching: rows_in_contact as f64 / path.len() as f64,
    })
}

/// A reading of the moment `h` within its bound `|h - z| <= r |z| + a`, at this share of the way from its middle to an end.
fn reading(h: f64, noise: &MomentNoise, share: f64) -> f64 {
    let (size, r, a) = (h.abs(), noise.moment_relative, noise.moment_absolute);
    let high = (size + a) / (1.0 - r);
    let low = if size >= a { (size - a) / (1.0 + r) } else { (size - a) / (1.0 - r) };
    let share = 0.5 * (1.0 + share * (1.0 - 1e-12));
    (low + share * (high - low)) * if h < 0.0 { -1.0 } else { 1.0 }
}
