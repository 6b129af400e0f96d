//! Random sweeps with bounded errors, and whether an answer holds the truth.

#[path = "random.rs"]
pub(crate) mod random;

use core::f64::consts::{FRAC_PI_2, PI, TAU};
use random::Random;
use vibrissa::beam::{Stretch, Whisker};
use vibrissa::flow::pose::{Localization, StampedPose, Status};
use vibrissa::flow::sensor_log::{Channel, LogRow, Quantity, SensorLog};
use vibrissa::plane::{Curve, Pose2, Vec2, wrap_angle};
use vibrissa::sim::{Pace, Part, SimulateOptions, Sweep, SweepNoise, Touch, path_through, simulate};
use vibrissa::world::{Boundary, Map, MomentNoise, MountedWhisker, Odometry, Robot, Role, WhiskerErrors};

/// Slope from which on a whisker counts as curled (rad).
const CURLED: f64 = 2.0;

/// One trial.
pub(crate) struct Trial {
    pub(crate) map: Map,
    pub(crate) robot: Robot,
    pub(crate) log: SensorLog,
    pub(crate) truth: Pose2,
    /// Rows in which a side touches, rows in which something bends the whisker to the left and to the right, rows in which it
    /// has an inflection, and rows in which its slope at the contact is beyond [`CURLED`].
    #[allow(dead_code, reason = "counted by the soundness program")]
    pub(crate) kinds: [usize; 5],
    /// The robot along the log, and every touch.
    #[allow(dead_code, reason = "shown by the example")]
    pub(crate) path: Vec<Pose2>,
    #[allow(dead_code, reason = "shown by the example")]
    pub(crate) touches: Vec<Touch>,
}

/// An arena with a wavy or polygonal outline and an obstacle or two.
fn random_map(draw: &mut Random) -> Option<Map> {
    let corners = draw.between(4.0, 9.0) as usize;
    let smooth = draw.unit() < 0.5;
    let points = if smooth { 240 } else { corners };
    let (a, b, c) = (draw.signed(PI), draw.signed(0.12), draw.signed(0.05));
    let radius = draw.between(0.2, 0.4);
    let outline: Vec<Vec2> = (0..points)
        .map(|k| {
            let angle = TAU * k as f64 / points as f64;
            let wave = if smooth { b * (2.0 * angle + a).sin() + c * (5.0 * angle).sin() } else { draw.signed(0.3) };
            Vec2::from_angle(angle) * (radius * (1.0 + wave))
        })
        .collect();
    let mut boundaries = vec![Boundary::new(Role::Arena, Curve::polyline(&outline, true)?, None).ok()?];
    let center = Vec2::new(draw.signed(0.05), draw.signed(0.05));
    let obstacle = match draw.between(0.0, 3.0) as u32 {
        0 => Curve::circle(center, draw.between(0.02, 0.06)),
        1 => {
            let turn = draw.signed(PI);
            let square = [(-0.04, -0.02), (0.05, -0.03), (0.03, 0.04), (-0.03, 0.03)];
            let corners: Vec<Vec2> = square.iter().map(|&(x, y)| center + Vec2::new(x, y).rotated(turn)).collect();
            Curve::polyline(&corners, true)
        }
        _ => None,
    };
    if let Some(curve) = obstacle {
        boundaries.push(Boundary::new(Role::Obstacle, curve, None).ok()?);
    }
    // Posts thinner than a whisker is long, which its side slides along, and a thin wall with two ends.
    for _ in 0..draw.between(0.0, 4.0) as u32 {
        let center = Vec2::from_angle(draw.signed(PI)) * (0.65 * radius * draw.unit());
        let post = Boundary::new(Role::Obstacle, Curve::circle(center, draw.between(0.002, 0.012))?, None).ok()?;
        boundaries.push(post);
    }
    if draw.unit() < 0.25 {
        let start = Vec2::from_angle(draw.signed(PI)) * (0.4 * radius);
        let wall = [start, start + Vec2::from_angle(draw.signed(PI)) * draw.between(0.02, 0.1)];
        boundaries.push(Boundary::new(Role::Wall, Curve::polyline(&wall, false)?, None).ok()?);
    }
    Map::new(boundaries).ok()
}

fn random_robot(draw: &mut Random) -> Robot {
    let mut whisker = MountedWhisker::default();
    whisker.beam.length = draw.between(0.05, 0.1);
    whisker.beam.flexural_rigidity = 10f64.powf(draw.between(-4.0, -3.0));
    if draw.unit() < 0.5 {
        whisker.robot_from_whisker = Pose2::new(draw.signed(0.03), draw.signed(0.03), draw.signed(PI));
    }
    whisker.noise =
        MomentNoise { moment_relative: draw.between(0.005, 0.08), moment_absolute: draw.between(1e-6, 4e-5) };
    if draw.unit() < 0.35 {
        whisker.friction = draw.between(0.0, 0.6);
    }
    let odometry = if draw.unit() < 0.5 {
        Odometry {
            translation_relative: draw.between(0.0, 0.03),
            rotation_relative: draw.between(0.0, 0.03),
            ..Odometry::default()
        }
    } else {
        Odometry::default()
    };
    Robot { whiskers: vec![whisker], odometry, ..Robot::default() }
}

/// Makes a whisker tapered, curved at rest or of several wires, on a clamped or an elastic base.
fn any_whisker(whisker: &mut MountedWhisker, draw: &mut Random) {
    let beam = &mut whisker.beam;
    let (length, rigidity) = (beam.length, beam.flexural_rigidity);
    let taper = |draw: &mut Random| 10f64.powf(draw.between(-1.3, 0.0));
    match draw.between(0.0, 4.0) as u32 {
        0 => beam.tip_ratio = taper(draw),
        1 => {
            let most = if draw.unit() < 0.3 { 3.0 } else { 1.0 };
            beam.curvature = draw.signed(most) / length;
        }
        2 => {
            beam.tip_ratio = taper(draw);
            beam.curvature = draw.signed(1.5) / length;
            beam.curvature_rise[0] = draw.signed(2.0) / (length * length);
        }
        _ => {
            let count = draw.between(2.0, 4.0) as usize;
            let shares: Vec<f64> = (0..count).map(|_| draw.between(0.3, 1.0)).collect();
            let whole: f64 = shares.iter().sum();
            let stretch = |(k, share): (usize, &f64)| Stretch {
                length: length * share / whole,
                flexural_rigidity: if k == 0 { rigidity } else { rigidity * 10f64.powf(draw.between(-1.5, 0.5)) },
                tip_ratio: if draw.unit() < 0.5 { 1.0 } else { draw.between(0.4, 1.2) },
                diameter: None,
            };
            let list: Vec<Stretch> = shares.iter().enumerate().map(stretch).collect();
            if let Ok(wires) = Whisker::of_stretches(&list) {
                *beam = wires;
            }
        }
    }
    if draw.unit() < 0.25 {
        beam.base_stiffness = beam.flexural_rigidity / beam.length * 10f64.powf(draw.between(0.3, 1.5));
    }
    // What a soft tip tells is small.
    let soft = beam.rigidity_at(0.7 * beam.length) / beam.flexural_rigidity;
    whisker.noise.moment_absolute *= soft.clamp(0.05, 1.0);
}

/// A whisker within declared errors of another, which declares them from now on.
fn within_errors(told: &mut MountedWhisker, draw: &mut Random) -> MountedWhisker {
    let mut actual = told.clone();
    if draw.unit() < 0.5 {
        return actual;
    }
    let (length, rigidity) = (draw.between(0.0, 0.03), draw.between(0.0, 0.05));
    told.errors = WhiskerErrors { length: length * told.beam.length, rigidity, ..WhiskerErrors::default() };
    let (longer, stiffer) = (1.0 + draw.signed(length), 1.0 + draw.signed(rigidity));
    let beam = &mut actual.beam;
    beam.flexural_rigidity *= stiffer;
    beam.length *= longer;
    let list: Vec<Stretch> = beam
        .stretches
        .as_slice()
        .iter()
        .map(|wire| Stretch {
            length: wire.length * longer,
            flexural_rigidity: wire.flexural_rigidity * stiffer,
            ..*wire
        })
        .collect();
    if let Ok(wires) = Whisker::of_stretches(&list) {
        *beam = Whisker {
            curvature: beam.curvature,
            curvature_rise: beam.curvature_rise,
            base_stiffness: beam.base_stiffness,
            ..wires
        };
    }
    actual
}

/// The robot's waypoints for a sweep of its whisker along a random stretch of boundary.
fn waypoints(map: &Map, robot: &Robot, draw: &mut Random) -> Option<Vec<Pose2>> {
    let samples = map.samples(1e-3);
    let start = samples[(draw.unit() * samples.len() as f64) as usize];
    let (along, inward) = (Vec2::from_angle(start.tangent), Vec2::from_angle(start.tangent + FRAC_PI_2));
    let forward = draw.sign();
    // Trailing whiskers slide well; some are pushed.
    let least = if draw.unit() < 0.2 { -0.5 } else { 0.3 };
    let lean = draw.between(least, 1.2);
    let heading = (-inward).angle() - forward * lean;
    let length = robot.whiskers[0].beam.length;
    let reach = length * lean.cos();
    let way = draw.between(0.03, 0.12);
    let whisker_from_robot = robot.whiskers[0].robot_from_whisker.inverse();
    let place = |s: f64, off: f64, turn: f64| {
        let p = start.position + along * (forward * s) + inward * off;
        Pose2::new(p.x, p.y, heading + turn).compose(whisker_from_robot)
    };
    // Some are pressed until they lie along the boundary and curl back over their base.
    let curls = draw.unit() < 0.2;
    let mut press = || if curls { reach * draw.between(0.05, 0.7) } else { reach - length * draw.between(0.02, 0.3) };
    let (b, c, d) = (press(), press(), press());
    let (mut t1, mut t2) = (draw.signed(0.2), draw.signed(0.2));
    if curls {
        t2 = forward * (lean + draw.between(0.2, 1.5));
        t1 = t2 * draw.between(0.2, 0.8);
    }
    Some(vec![
        place(0.0, reach + 0.004, 0.0),
        place(draw.between(0.003, 0.02), b, 0.0),
        place(0.5 * way, c, t1),
        place(way, d, t2),
    ])
}

/// A reading of the moment `h` within its bound: at the edge or anywhere between.
pub(crate) fn reading(h: f64, noise: &MomentNoise, share: f64) -> f64 {
    // |h - z| <= r |z| + a, for z of the sign of h where there is one.
    let (size, r, a) = (h.abs(), noise.moment_relative, noise.moment_absolute);
    let high = (size + a) / (1.0 - r);
    let low = if size >= a { (size - a) / (1.0 + r) } else { (size - a) / (1.0 - r) };
    // Not beyond the edge by rounding.
    let share = 0.5 * (1.0 + share * (1.0 - 1e-12));
    (low + share * (high - low)) * if h < 0.0 { -1.0 } else { 1.0 }
}

/// The sweep as far as the simulator goes and single contacts explain it; the path is cut there.
fn covered(map: &Map, robot: &Robot, path: &mut Vec<StampedPose>) -> Option<Sweep> {
    let is_uniform = robot.whiskers[0].beam.is_uniform();
    while path.len() > 30 {
        let Ok(mut sweep) = simulate(map, robot, path, &SweepNoise::none(), &SimulateOptions::default()) else {
            path.truncate(path.len() * 3 / 4);
            continue;
        };
        let beyond = |kind: &str| matches!(kind, "discrete_rod" | "unsolved" | "lost");
        let event = sweep.events.iter().find(|event| beyond(event.kind)).map_or(f64::INFINITY, |event| event.t - 1e-9);
        let before = path.iter().take_while(|pose| pose.t < event).count();
        let rows = if before < path.len() { before.saturating_sub(1) } else { before };
        let first = sweep
            .contacts
            .iter()
            .find(|touch| is_uniform && !is_covered(touch, robot, path))
            .map_or(rows, |touch| touch.row);
        let rows = rows.min(first);
        path.truncate(rows);
        sweep.exact_moments.truncate(rows);
        sweep.contacts.retain(|touch| touch.row < rows);
        return (path.len() > 30).then_some(sweep);
    }
    None
}

/// Whether the whisker has at most one inflection between base and contact, and a slope at the contact below the method's
/// largest. Curvature and slope along it are speed and angle of a pendulum that starts from rest at the contact: its
/// energy tells the angle there, and it comes to rest again, where the curvature changes sign, after half a period.
fn is_covered(touch: &Touch, robot: &Robot, path: &[StampedPose]) -> bool {
    let Swing { half_swings, slope } = swing(touch, robot, path);
    half_swings < 2.0 && slope < PI
}

/// The whisker as a pendulum.
struct Swing {
    /// How many half periods lie between base and contact.
    half_swings: f64,
    /// The slope at the contact (rad).
    slope: f64,
}

fn swing(touch: &Touch, robot: &Robot, path: &[StampedPose]) -> Swing {
    let whisker = &robot.whiskers[touch.whisker];
    let base = path[touch.row].map_from_robot.compose(whisker.robot_from_whisker);
    let moment = (touch.position - base.position()).cross(touch.force);
    let direction = wrap_angle(touch.force.angle() - base.theta);
    let (stiffness, force) = (whisker.beam.flexural_rigidity, touch.force.norm());
    let rest = (direction.cos() + moment * moment / (2.0 * stiffness * force)).clamp(-1.0, 1.0).acos();
    let time = touch.s_a * (force / stiffness).sqrt();
    let half_swings = time / half_period(rest);
    // Past an inflection the moment has the other sign than the slope; the pendulum balances at half a turn.
    let side = if half_swings > 1.0 { -moment.signum() } else { moment.signum() };
    let slope = (side * direction).rem_euclid(TAU) - rest;
    Swing { half_swings, slope }
}

/// From rest to rest, at the angle `rest` (rad) from where the pendulum would balance: by the arithmetic-geometric mean.
fn half_period(rest: f64) -> f64 {
    let (mut a, mut b) = (1.0, (0.5 * rest).sin());
    for _ in 0..40 {
        (a, b) = (0.5 * (a + b), f64::sqrt(a * b));
    }
    PI / a
}

/// The trial of a seed with a uniform whisker, if there is one.
#[allow(dead_code, reason = "the soundness program asks for any whisker, too")]
pub(crate) fn random_sweep(seed: u64) -> Option<Trial> {
    random_sweep_of(seed, false)
}

/// The trial of a seed with a uniform whisker or with one of any other kind, if there is one.
pub(crate) fn random_sweep_of(seed: u64, any: bool) -> Option<Trial> {
    let mut draw = Random(seed.wrapping_mul(0x9e37_79b9_97f4_a7c1));
    let map = random_map(&mut draw)?;
    let mut robot = random_robot(&mut draw);
    let mut actual = robot.clone();
    if any {
        let mut draw = Random(seed.wrapping_mul(0xbf58_476d_1ce4_e5b9));
        any_whisker(&mut robot.whiskers[0], &mut draw);
        actual.whiskers[0] = within_errors(&mut robot.whiskers[0], &mut draw);
    }
    let way = waypoints(&map, &robot, &mut draw)?;
    let base = |p: &Pose2| p.compose(robot.whiskers[0].robot_from_whisker).position();
    if way.iter().any(|p| !map.is_free(base(p))) {
        return None;
    }
    let pace = Pace { speed: 0.3, turn_rate: 1.0, rate: draw.between(100.0, 400.0) };
    let mut path = path_through(&way, &pace).ok()?;
    let sweep = covered(&map, &actual, &mut path)?;
    if sweep.contacts.len() < 10 {
        return None;
    }
    let (hard, bias) = (draw.unit() < 0.5, draw.sign());
    let steady = draw.unit() < 0.3;
    let (stretch, turn) = (draw.signed(1.0).signum(), draw.signed(1.0).signum());
    let origin = Pose2::new(draw.signed(3.0), draw.signed(3.0), draw.signed(PI));
    let (mut odom, mut rows): (Pose2, Vec<LogRow>) = (origin, Vec::new());
    for (k, pose) in path.iter().enumerate() {
        if k > 0 {
            let step = path[k - 1].map_from_robot.between(pose.map_from_robot);
            let (mut s, mut r) = if hard { (stretch, turn) } else { (draw.signed(1.0), draw.signed(1.0)) };
            (s, r) = (s * robot.odometry.translation_relative, r * robot.odometry.rotation_relative);
            // An error in any direction.
            let off = Vec2::from_angle(draw.signed(PI)) * (step.position().norm() * s.abs());
            let shift = if hard { step.position() * s } else { off };
            let felt = Pose2::new(step.x + shift.x, step.y + shift.y, step.theta * (1.0 + r));
            odom = odom.compose(felt);
        }
        let share = match (hard, steady) {
            (true, true) => bias,
            (true, false) => draw.sign(),
            _ => draw.signed(1.0),
        };
        let z = reading(sweep.exact_moments[k][0], &robot.whiskers[0].noise, share);
        rows.push(LogRow { t: pose.t, odom_from_robot: odom, readings: vec![z], heading: None, line: 0 });
    }
    let channels = vec![Channel { whisker: String::new(), quantity: Quantity::Moment }];
    let truth = path[path.len() - 1].map_from_robot;
    let count = |keep: &dyn Fn(usize) -> bool| (0..path.len()).filter(|&k| keep(k)).count();
    let side: std::collections::BTreeSet<usize> =
        sweep.contacts.iter().filter(|touch| touch.part == Part::Side).map(|touch| touch.row).collect();
    let moment = |k: usize| sweep.exact_moments[k][0];
    // Of others than uniform whiskers no pendulum tells them.
    let told = if any { &[][..] } else { &sweep.contacts[..] };
    let swings: Vec<Swing> = told.iter().map(|touch| swing(touch, &robot, &path)).collect();
    let inflected = swings.iter().filter(|swing| swing.half_swings > 1.0).count();
    let curled = swings.iter().filter(|swing| swing.slope > CURLED).count();
    let kinds = [side.len(), count(&|k| moment(k) > 0.0), count(&|k| moment(k) < 0.0), inflected, curled];
    Some(Trial {
        kinds,
        path: path.iter().map(|pose| pose.map_from_robot).collect(),
        touches: sweep.contacts,
        map,
        robot,
        log: SensorLog { channels, rows, ..SensorLog::default() },
        truth,
    })
}

/// Whether the answer's set holds the truth at the last row.
pub(crate) fn contains(answer: &Localization, truth: Pose2) -> bool {
    if answer.status == Status::Inconsistent {
        return false;
    }
    answer.states.iter().any(|b| {
        let middle = 0.5 * (b.theta.lo() + b.theta.hi());
        b.x.contains(truth.x) && b.y.contains(truth.y) && b.theta.contains(middle + wrap_angle(truth.theta - middle))
    }) || (answer.states.is_empty() && answer.hypotheses.is_empty() && answer.status == Status::NoContact)
}
