//! Drives around the corners of right-angled rooms, with posts of acute corners and thin walls in some, by the simulator with any
//! number of contacts, with declared errors of all kinds and noise by several laws.

use crate::random_sweep::random::Random;
use crate::random_sweep::reading;
use core::f64::consts::PI;
use vibrissa::flow::pose::{Event, StampedPose};
use vibrissa::flow::sensor_log::{Channel, LogRow, Quantity, SensorLog};
use vibrissa::plane::{Curve, Pose2, Vec2};
use vibrissa::sim::{Pace, SimulateOptions, Sweep, SweepNoise, path_through, simulate};
use vibrissa::world::{Boundary, Map, MomentNoise, MountedWhisker, Odometry, Robot, Role};

/// A drive with what was told of it.
pub(crate) struct Drive {
    pub(crate) map: Map,
    pub(crate) robot: Robot,
    pub(crate) log: SensorLog,
    /// The robot at the first and at the last row, in the metres of the map as it is told.
    pub(crate) first: Pose2,
    pub(crate) truth: Pose2,
    /// Rows in which the whisker touches in two places or more.
    pub(crate) doubled: usize,
    pub(crate) law: &'static str,
    /// What the simulator did: the robot as it is, its way, the moments without noise, and what happened.
    pub(crate) simulated: Simulated,
}

/// The simulator's side of a drive, on the map without an error of scale.
pub(crate) struct Simulated {
    pub(crate) map: Map,
    pub(crate) robot: Robot,
    pub(crate) path: Vec<StampedPose>,
    pub(crate) moments: Vec<f64>,
    pub(crate) events: Vec<Event>,
    /// How many contacts each row has.
    pub(crate) touches: Vec<usize>,
}

/// The laws of the readings' errors within their bounds.
pub(crate) const LAWS: [&str; 7] = ["constant", "two-point", "AR(1)", "sine", "step", "hysteresis", "even"];
/// Shortest log that is used.
const FEWEST_ROWS: usize = 60;

/// The drive of a seed with so many whiskers, if there is one; with errors of every kind, or of readings and odometry only. What is drawn for the
/// first whisker does not depend on how many there are.
pub(crate) fn drive(seed: u64, nuisances: bool, whiskers: usize) -> Option<Drive> {
    let mut others = Random(seed.wrapping_mul(0xe703_7ed1_a0b4_28db));
    let mut draw = Random(seed.wrapping_mul(0xa076_1d64_78bd_642f));
    let mut outlines = room(&mut draw);
    furnish(&mut outlines, &mut Random(seed.wrapping_mul(0xd6e8_feb8_6659_fd93)));
    let map = map_of(&outlines, 1.0)?;
    let mut robot = true_robot(&mut draw);
    for number in 1..whiskers {
        let mut whisker = true_robot(&mut others).whiskers.remove(0);
        whisker.name = format!("w{number}");
        // Anywhere around the robot.
        let side = Pose2::new(0.0, 0.0, others.signed(PI));
        whisker.robot_from_whisker = side.compose(whisker.robot_from_whisker);
        robot.whiskers.push(whisker);
    }
    let way = waypoints(&map, &robot, &mut draw)?;
    let pace = Pace { speed: 0.2, turn_rate: 1.5, rate: draw.between(60.0, 250.0) };
    let mut path = path_through(&way, &pace).ok()?;
    let sweep = swept(&map, &robot, &mut path)?;
    let errors = Errors::draw((&mut draw, &mut others), &robot, nuisances);
    let (log, law) = log(&sweep, &path, &errors, &robot, (&mut draw, &mut others))?;
    let map_scale = errors.map;
    let told = |pose: Pose2| Pose2::new(pose.x * map_scale, pose.y * map_scale, pose.theta);
    let rows = errors.rows(path.len())?;
    let as_it_is = robot;
    let mut robot = errors.told;
    if errors.delay_rows > 0.0 {
        robot.odometry.delay = delay_bound(&log, errors.delay_rows);
    }
    let mut touches = vec![0; path.len()];
    sweep.contacts.iter().filter(|touch| touch.whisker == 0).for_each(|touch| touches[touch.row] += 1);
    Some(Drive {
        map: map_of(&outlines, map_scale)?,
        robot,
        log,
        first: told(path[rows.start].map_from_robot),
        truth: told(path[rows.end - 1].map_from_robot),
        doubled: touches.iter().filter(|&&count| count > 1).count(),
        law,
        simulated: Simulated {
            map,
            robot: as_it_is,
            moments: sweep.exact_moments.iter().map(|row| row[0]).collect(),
            path,
            events: sweep.events,
            touches,
        },
    })
}

/// Outlines of a room and of what stands in it, turned by some angle: the room first.
pub(crate) fn room(draw: &mut Random) -> Vec<Vec<Vec2>> {
    let (w, h) = (draw.between(0.2, 0.7), draw.between(0.2, 0.6));
    let mut outline = vec![Vec2::new(0.0, 0.0), Vec2::new(w, 0.0), Vec2::new(w, h), Vec2::new(0.0, h)];
    // A corner cut off, and a bay or a block in a wall.
    if draw.unit() < 0.6 {
        let (a, b) = (draw.between(0.1, 0.6) * w, draw.between(0.1, 0.6) * h);
        outline.splice(2..3, [Vec2::new(w, h - b), Vec2::new(w - a, h - b), Vec2::new(w - a, h)]);
    }
    if draw.unit() < 0.6 {
        let (from, wide) = (draw.between(0.1, 0.6) * w, draw.between(0.03, 0.15));
        let deep = draw.sign() * draw.between(0.015, 0.09);
        let to = (from + wide).min(0.95 * w);
        let bay = [(from, 0.0), (from, -deep), (to, -deep), (to, 0.0)].map(|(x, y)| Vec2::new(x, y));
        outline.splice(1..1, bay);
    }
    let mut all = vec![outline];
    if draw.unit() < 0.5 {
        let (x, y) = (draw.between(0.2, 0.7) * w, draw.between(0.3, 0.6) * h);
        let (a, b) = (draw.between(0.01, 0.1), draw.between(0.01, 0.1));
        all.push([(x, y), (x + a, y), (x + a, y + b), (x, y + b)].map(|(x, y)| Vec2::new(x, y)).to_vec());
    }
    let turn = draw.signed(PI);
    all.iter().map(|outline| outline.iter().map(|p| p.rotated(turn)).collect()).collect()
}

/// Adds a post with acute corners and a thin wall to some rooms, where there is space.
fn furnish(outlines: &mut Vec<Vec<Vec2>>, draw: &mut Random) {
    for corners in [3, 2] {
        if draw.unit() < 0.5 {
            let found = (0..30).find_map(|_| {
                let map = map_of(outlines, 1.0)?;
                let (bounds, turn) = (map.bounds(), draw.signed(PI));
                let size = bounds.size();
                let at = bounds.min + Vec2::new(draw.unit() * size.x, draw.unit() * size.y);
                let (long, wide) = (draw.between(0.04, 0.12), draw.between(0.15, 0.6));
                let thing =
                    [Vec2::ZERO, Vec2::new(long, 0.0), Vec2::from_angle(wide) * (long * draw.between(0.5, 1.2))];
                let thing: Vec<Vec2> = thing[..corners].iter().map(|p| at + p.rotated(turn)).collect();
                let ends = |k: usize| [thing[k], thing[(k + 1) % corners]];
                let stands = (0..corners).all(|k| map.is_free(thing[k]) && !map.crosses(ends(k)[0], ends(k)[1]));
                stands.then_some(thing)
            });
            outlines.extend(found);
        }
    }
}

/// The map of a room's outlines, the room first; two corners are a thin wall.
pub(crate) fn map_of(outlines: &[Vec<Vec2>], scale: f64) -> Option<Map> {
    let boundary = |(index, outline): (usize, &Vec<Vec2>)| {
        let role = match (index, outline.len()) {
            (0, _) => Role::Arena,
            (_, 2) => Role::Wall,
            _ => Role::Obstacle,
        };
        let outline: Vec<Vec2> = outline.iter().map(|&p| p * scale).collect();
        Boundary::new(role, Curve::polyline(&outline, role != Role::Wall)?, None).ok()
    };
    Map::new(outlines.iter().enumerate().map(boundary).collect::<Option<_>>()?).ok()
}

fn true_robot(draw: &mut Random) -> Robot {
    let mut whisker = MountedWhisker::default();
    whisker.beam.length = draw.between(0.05, 0.1);
    whisker.beam.flexural_rigidity = 10f64.powf(draw.between(-4.0, -3.0));
    if draw.unit() < 0.3 {
        whisker.beam.base_stiffness = whisker.beam.flexural_rigidity / whisker.beam.length * draw.between(1.0, 30.0);
    }
    whisker.robot_from_whisker = Pose2::new(draw.between(0.0, 0.03), draw.signed(0.03), draw.signed(1.8));
    whisker.noise =
        MomentNoise { moment_relative: draw.between(0.005, 0.06), moment_absolute: draw.between(1e-6, 3e-5) };
    let mut odometry = Odometry::default();
    if draw.unit() < 0.4 {
        odometry.translation_relative = draw.between(0.0, 0.02);
        odometry.rotation_relative = draw.between(0.0, 0.02);
    }
    Robot { whiskers: vec![whisker], odometry, ..Robot::default() }
}

/// A drive ahead until something is near, a turn on the spot, and so on.
fn waypoints(map: &Map, robot: &Robot, draw: &mut Random) -> Option<Vec<Pose2>> {
    let bounds = map.bounds();
    let keeps_off = draw.between(0.1, 0.7) * robot.whiskers[0].beam.length;
    let is_clear = |pose: &Pose2, off: f64| {
        let is_off = |whisker: &MountedWhisker| {
            let base = pose.compose(whisker.robot_from_whisker).position();
            map.is_free(base) && map.nearest(base).is_some_and(|near| near.distance > off)
        };
        // No robot has its origin in a wall.
        map.is_free(pose.position()) && robot.whiskers.iter().all(is_off)
    };
    let is_free = |pose: &Pose2| {
        robot.whiskers.iter().all(|whisker| {
            let base = pose.compose(whisker.robot_from_whisker);
            (0..=20).all(|k| {
                let p = base.transform_point(Vec2::new(whisker.beam.length * 1.02 * f64::from(k) / 20.0, 0.0));
                map.is_free(p) && map.nearest(p).is_some_and(|near| near.distance > 1e-3)
            })
        })
    };
    let place = |draw: &mut Random| {
        let size = bounds.size();
        let at = bounds.min + Vec2::new(draw.unit() * size.x, draw.unit() * size.y);
        Pose2::new(at.x, at.y, draw.signed(PI))
    };
    let mut pose = (0..200).map(|_| place(draw)).find(|pose| is_free(pose) && is_clear(pose, keeps_off))?;
    let (mut way, mut left) = (vec![pose], draw.between(0.5, 2.0));
    for _ in 0..40 {
        let longest = draw.between(0.02, 0.4).min(left);
        let step = 2e-3;
        let ahead = |s: f64| pose.compose(Pose2::new(s, 0.0, 0.0));
        let count =
            (1..=(longest / step) as usize).take_while(|&k| is_clear(&ahead(step * k as f64), keeps_off)).count();
        if count > 0 {
            pose = ahead(step * count as f64);
            way.push(pose);
            left -= step * count as f64;
        }
        if left < 0.01 {
            break;
        }
        let turn = draw.sign() * draw.between(0.2, 2.4);
        let turned = |share: f64| pose.compose(Pose2::new(0.0, 0.0, turn * share));
        let share = (1..=50).take_while(|&k| is_clear(&turned(f64::from(k) / 50.0), 3e-3)).count() as f64 / 50.0;
        pose = turned(share);
        way.push(pose);
    }
    (way.len() > 2).then_some(way)
}

/// The sweep as far as the simulator is sure of it; the path is cut there.
fn swept(map: &Map, robot: &Robot, path: &mut Vec<StampedPose>) -> Option<Sweep> {
    let sweep = simulate(map, robot, path, &SweepNoise::none(), &SimulateOptions::default()).ok()?;
    let end = sweep.events.iter().find(|event| matches!(event.kind, "unsolved" | "lost"));
    let end = end.map_or(f64::INFINITY, |event| event.t - 1e-9);
    let rows = path.iter().take_while(|pose| pose.t < end).count().saturating_sub(usize::from(end.is_finite()));
    path.truncate(rows);
    let mut sweep = sweep;
    sweep.contacts.retain(|touch| touch.row < rows);
    (rows >= FEWEST_ROWS && sweep.contacts.len() > 10).then_some(sweep)
}

/// What is wrong with what is told, within the bounds that are told, too.
struct Errors {
    told: Robot,
    /// Told over true metres of the map.
    map: f64,
    /// Of each whisker.
    readings: Vec<ReadingErrors>,
    /// Rows by which readings are early, and the bound on them.
    delay: i64,
    delay_rows: f64,
}

/// What is wrong with the readings of a whisker.
#[derive(Clone, Copy)]
struct ReadingErrors {
    gain: f64,
    zero: f64,
    drift: f64,
}

/// A bound and what is within it: some kinds only; some at the edge of their bounds.
fn kind(draw: &mut Random, most: f64) -> (f64, f64) {
    let bound = if draw.unit() < 0.4 { draw.between(0.0, most) } else { 0.0 };
    (bound, bound * if draw.unit() < 0.5 { draw.sign() } else { draw.signed(1.0) } * (1.0 - 1e-9))
}

impl Errors {
    fn draw((draw, others): (&mut Random, &mut Random), robot: &Robot, nuisances: bool) -> Self {
        let readings = vec![ReadingErrors { gain: 1.0, zero: 0.0, drift: 0.0 }; robot.whiskers.len()];
        let mut all = Self { told: robot.clone(), map: 1.0, readings, delay: 0, delay_rows: 0.0 };
        if !nuisances {
            return all;
        }
        let scale = kind(draw, 0.02);
        all.map = 1.0 / (1.0 + scale.1);
        all.told.map_scale = scale.0;
        for index in 0..robot.whiskers.len() {
            all.draw_of_whisker(index, if index == 0 { draw } else { others });
        }
        let delay = kind(draw, 4.0);
        (all.delay, all.delay_rows) = (delay.1 as i64, delay.0);
        all
    }

    fn draw_of_whisker(&mut self, index: usize, draw: &mut Random) {
        let mut kind = |most: f64| kind(draw, most);
        let (zero, drift, gain) = (kind(5e-5), kind(1e-5), kind(0.05));
        let (length, rigidity, x, y, theta) = (kind(0.02), kind(0.05), kind(2e-3), kind(2e-3), kind(0.03));
        let whisker = &mut self.told.whiskers[index];
        self.readings[index] = ReadingErrors { gain: 1.0 + gain.1, zero: zero.1, drift: drift.1 };
        whisker.beam.length /= 1.0 + length.1;
        whisker.beam.flexural_rigidity /= 1.0 + rigidity.1;
        let mount = whisker.robot_from_whisker;
        whisker.robot_from_whisker = Pose2::new(mount.x - x.1, mount.y - y.1, mount.theta - theta.1);
        whisker.errors.length = length.0 * whisker.beam.length;
        whisker.errors.rigidity = rigidity.0;
        whisker.errors.mount = [x.0, y.0, theta.0];
        (whisker.errors.zero, whisker.errors.zero_drift, whisker.errors.gain) = (zero.0, drift.0, gain.0);
    }

    /// The rows of the path that have a reading.
    fn rows(&self, count: usize) -> Option<std::ops::Range<usize>> {
        let early = self.delay.unsigned_abs() as usize;
        (count > 2 * early + FEWEST_ROWS).then_some(early..count - early)
    }
}

/// Noise between the edges of its bound, -1 and 1, for each row, and the law's name.
fn noise(count: usize, moment: impl Fn(usize) -> f64, draw: &mut Random) -> (Vec<f64>, &'static str) {
    let (sign, size) = (draw.sign(), if draw.unit() < 0.5 { 1.0 } else { draw.unit() });
    let (period, phase, keeps) = (draw.between(0.1, 1.0) * count as f64, draw.signed(PI), draw.between(0.8, 0.999));
    let mut last = draw.signed(1.0);
    let law = (draw.unit() * LAWS.len() as f64) as usize;
    let one = |k: usize| {
        let share = match law {
            0 => sign,
            1 => draw.sign(),
            2 => {
                last = (keeps * last + (1.0 - keeps * keeps).sqrt() * 1.7 * draw.signed(1.0)).clamp(-1.0, 1.0);
                last
            }
            3 => (2.0 * PI * k as f64 / period + phase).sin(),
            4 => {
                if 2 * k < count {
                    sign
                } else {
                    -sign
                }
            }
            5 => {
                if moment(k + 1).abs() > moment(k).abs() {
                    sign
                } else {
                    -sign
                }
            }
            _ => draw.signed(1.0),
        };
        size * share
    };
    ((0..count).map(one).collect(), LAWS[law])
}

/// The log of a sweep.
fn log(
    sweep: &Sweep,
    path: &[StampedPose],
    errors: &Errors,
    robot: &Robot,
    (draw, others): (&mut Random, &mut Random),
) -> Option<(SensorLog, &'static str)> {
    let rows = errors.rows(path.len())?;
    let moment = |whisker: usize| move |k: usize| sweep.exact_moments[k.min(path.len() - 1)][whisker];
    let (first, law) = noise(path.len(), moment(0), draw);
    let mut shares = vec![first];
    shares.extend((1..robot.whiskers.len()).map(|whisker| noise(path.len(), moment(whisker), others).0));
    let mut told = LogRow {
        t: 0.0,
        odom_from_robot: Pose2::new(draw.signed(3.0), 0.0, draw.signed(PI)),
        readings: vec![],
        heading: None,
        line: 0,
    };
    let (hard, along, turning) = (draw.unit() < 0.5, draw.sign(), draw.sign());
    let begin = path[rows.start].t;
    let mut log = SensorLog {
        channels: robot
            .whiskers
            .iter()
            .map(|one| Channel { whisker: one.name.clone(), quantity: Quantity::Moment })
            .collect(),
        ..SensorLog::default()
    };
    for k in rows.clone() {
        if k > rows.start {
            let step = path[k - 1].map_from_robot.between(path[k].map_from_robot);
            let odometry = &robot.odometry;
            let size = odometry.translation_relative * if hard { along } else { draw.signed(1.0) };
            let shift = if hard {
                step.position() * size
            } else {
                Vec2::from_angle(draw.signed(PI)) * (size * step.position().norm())
            };
            let turn = step.theta * (1.0 + odometry.rotation_relative * if hard { turning } else { draw.signed(1.0) });
            told.odom_from_robot = told.odom_from_robot.compose(Pose2::new(step.x + shift.x, step.y + shift.y, turn));
        }
        let read = (k as i64 + errors.delay) as usize;
        let elapsed = path[k].t - begin;
        let told_of = |(index, whisker): (usize, &MountedWhisker)| {
            let ReadingErrors { gain, zero, drift } = errors.readings[index];
            let clean = gain * moment(index)(read) + zero + drift * elapsed;
            reading(clean, &whisker.noise, shares[index][k])
        };
        told.readings = robot.whiskers.iter().enumerate().map(told_of).collect();
        told.t = path[k].t;
        log.rows.push(told.clone());
    }
    Some((log, law))
}

/// The delay's bound that covers so many rows of a drive (s).
fn delay_bound(log: &SensorLog, rows: f64) -> f64 {
    match log.rows.as_slice() {
        [first, .., last] => rows * (last.t - first.t) / (log.rows.len() - 1) as f64,
        _ => 0.0,
    }
}
