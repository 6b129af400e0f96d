//! Whiskers that lean out of the horizontal on upright walls, against rods marched in space: contacts, readings, places.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must fail")]

#[path = "data/random.rs"]
mod random;
#[path = "data/space.rs"]
mod space;

use core::f64::consts::{FRAC_PI_2, PI, TAU};
use random::Random;
use space::{Vec3, cross, dot, plus};
use vibrissa::beam::{TipModel, TipReading, Whisker};
use vibrissa::config::{PossibilisticOptions, Region, TipLoad};
use vibrissa::flow::contact_set::TipContactSet;
use vibrissa::flow::pose::Localization;
use vibrissa::flow::sensor_log::{Channel, LogRow, Quantity, SensorLog};
use vibrissa::plane::{Curve, Pose2, Vec2};
use vibrissa::world::{Boundary, Lean, Map, MomentNoise, MountedWhisker, Robot, Role};
use vibrissa::{Method, tasks};

/// Where a rod ends that leaves `base` along `axis`, under a force at `held`: Kirchhoff's rod without twist, by the classical Runge-Kutta
/// method.
fn marched(whisker: &Whisker, steps: usize, (base, axis): (Vec3, Vec3), held: Vec3, force: Vec3) -> Vec3 {
    let h = whisker.length / steps as f64;
    let rate =
        |(r, t): (Vec3, Vec3)| (t, cross(cross(plus(held, r, -1.0), force), t).map(|v| v / whisker.flexural_rigidity));
    let add = |a: (Vec3, Vec3), b: (Vec3, Vec3), by: f64| (plus(a.0, b.0, by), plus(a.1, b.1, by));
    let mut state = (base, axis);
    for _ in 0..steps {
        let a = rate(state);
        let b = rate(add(state, a, 0.5 * h));
        let c = rate(add(state, b, 0.5 * h));
        let d = rate(add(state, c, h));
        for (slope, weight) in [(a, 1.0), (b, 2.0), (c, 2.0), (d, 1.0)] {
            state = add(state, slope, weight * h / 6.0);
        }
    }
    state.0
}

/// The axis of a whisker with this heading, and the axis about which its sensor reads moments.
fn frame(lean: Lean, heading: f64) -> (Vec3, Vec3) {
    let ((sin_e, cos_e), (sin_h, cos_h)) = (lean.elevation.sin_cos(), heading.sin_cos());
    let axis = [cos_e * cos_h, cos_e * sin_h, sin_e];
    let level = [-sin_h, cos_h, 0.0];
    let left = plus(level.map(|v| v * lean.roll.cos()), cross(axis, level), lean.roll.sin());
    (axis, cross(axis, left))
}

#[test]
fn a_level_whisker_has_the_planar_contacts() {
    let tip = TipModel::new(&Whisker::default()).unwrap();
    let mut tried = 0;
    for moment in [2e-4, 2e-3, 6e-3, -1e-3, -8e-3] {
        let planar = TipContactSet::branches(&tip, TipReading::Moment(moment), TipLoad::BoundaryNormal);
        for contact in Lean::default().tip_contacts(&Whisker::default(), moment).iter().flat_map(|set| set.contacts()) {
            let same = planar.iter().filter_map(|set| set.at_direction(contact.direction));
            let off = same.map(|c| c.position.distance(contact.position)).fold(f64::INFINITY, f64::min);
            // The planar sets are chains of chords; beyond their ends no wall pushes.
            if off.is_finite() {
                assert!(off < 3e-5, "{moment} {}: {off}", contact.direction);
                tried += 1;
            }
        }
        assert!(Lean::default().tip_contacts(&Whisker::default(), 0.0).is_empty());
    }
    assert!(tried > 300, "{tried}");
}

#[test]
fn contacts_of_leaning_whiskers_are_equilibria_in_space() {
    let (whisker, mut random) = (Whisker::default(), Random(12));
    let (mut tried, mut worst) = (0, [0.0_f64; 2]);
    for round in 0..60 {
        // Random ones, and as steep and as turned as a file may say.
        let lean = match round {
            0 => Lean { elevation: 80.0 / 360.0 * TAU, roll: 0.0 },
            1 => Lean { elevation: -80.0 / 360.0 * TAU, roll: 3.0 },
            2 => Lean { elevation: 0.0, roll: FRAC_PI_2 - 0.01 },
            3 => Lean { elevation: 1e-9, roll: 0.0 },
            _ => Lean { elevation: random.signed(1.2), roll: random.signed(PI) },
        };
        let reading = random.signed(1.0).signum() * 10f64.powf(random.between(-5.0, -2.1));
        let (axis, about) = frame(lean, 0.0);
        for set in lean.tip_contacts(&whisker, reading) {
            assert!(set.contacts().windows(2).all(|pair| pair[1].direction > pair[0].direction));
            for contact in set.contacts().iter().step_by(9) {
                let (sin, cos) = contact.direction.sin_cos();
                let force = [contact.force * cos, contact.force * sin, 0.0];
                let at = |z: f64| [contact.position.x, contact.position.y, z];
                // The height of the tip is not told: it is that of the plane of axis and force, if the plane is right.
                let across = plus([cos, sin, 0.0], axis, -dot([cos, sin, 0.0], axis));
                let determinant = axis[0] * across[1] - axis[1] * across[0];
                if determinant.abs() < 1e-6 {
                    continue;
                }
                let Vec2 { x, y } = contact.position;
                let (along, out) =
                    ((x * across[1] - y * across[0]) / determinant, (y * axis[0] - x * axis[1]) / determinant);
                let high = along * axis[2] + out * across[2];
                let found = marched(&whisker, 1500, ([0.0; 3], axis), at(high), force);
                let gap = plus(found, at(high), -1.0).iter().map(|v| v * v).sum::<f64>().sqrt();
                let read = dot(cross(at(high), force), about);
                worst = [worst[0].max(gap), worst[1].max((read / reading - 1.0).abs())];
                assert!(
                    gap < 1e-6 && (read / reading - 1.0).abs() < 1e-6,
                    "{lean:?} {reading}: {gap} {read} {contact:?}"
                );
                tried += 1;
            }
            // Drawn, the whisker begins at its base and ends at the contact.
            let middle = &set.contacts()[set.contacts().len() / 2];
            let shape = lean.shape(&whisker, middle, &[0.0, 0.5, 1.0]);
            assert!(shape.len() == 3 && shape[0].norm() < 1e-12 && shape[2].distance(middle.position) < 1e-6);
        }
    }
    println!("{tried} contacts, {:.1e} m from equilibrium, readings within {:.1e}", worst[0], worst[1]);
    assert!(tried > 400, "{tried}");
}

/// A room whose wall bends everywhere, each part in its own way; its point and its inward normal by the angle.
fn wall(angle: f64) -> (Vec2, Vec2) {
    let radius = |a: f64| 0.16 + 0.03 * (2.0 * a).cos() + 0.015 * (3.0 * a + 0.7).cos();
    let rate = |a: f64| -0.06 * (2.0 * a).sin() - 0.045 * (3.0 * a + 0.7).sin();
    let (sin, cos) = angle.sin_cos();
    let tangent = Vec2::new(rate(angle) * cos - radius(angle) * sin, rate(angle) * sin + radius(angle) * cos);
    (Vec2::new(cos, sin) * radius(angle), Vec2::new(-tangent.y, tangent.x) * (1.0 / tangent.norm()))
}

fn room() -> Map {
    let corners: Vec<Vec2> = (0..1440).map(|k| wall(TAU * f64::from(k) / 1440.0).0).collect();
    Map::new(vec![Boundary::new(Role::Arena, Curve::polyline(&corners, true).unwrap(), None).unwrap()]).unwrap()
}

/// A whisker that trails along the wall: where the robot is, and what its sensor reads, by rods marched in space.
fn sweep(mounted: &MountedWhisker) -> Vec<(Pose2, f64)> {
    let whisker = &mounted.beam;
    // Force, angle of the touched point, height of the tip.
    let mut unknowns: Option<[f64; 3]> = None;
    let mut rows = Vec::new();
    for k in 0..420 {
        let angle = 0.2 + 3.6 * f64::from(k) / 420.0;
        let (point, normal) = wall(angle);
        let reach = whisker.length * mounted.lean.elevation.cos() * mounted.robot_from_whisker.theta.sin().abs();
        let away = reach + 2e-3 - 0.014 * (f64::from(k) / 60.0).min(1.0);
        let pose = Pose2::new(point.x + away * normal.x, point.y + away * normal.y, normal.angle() - FRAC_PI_2);
        let base = pose.compose(mounted.robot_from_whisker);
        let (axis, about) = frame(mounted.lean, base.theta);
        let start = ([base.x, base.y, 0.0], axis);
        let straight = Vec2::new(base.x + whisker.length * axis[0], base.y + whisker.length * axis[1]);
        // A tip that is still in the room touches nothing.
        if straight.norm() < wall(straight.angle()).0.norm() {
            rows.push((pose, 0.0));
            continue;
        }
        let held = |u: Vec3| {
            let (at, n) = wall(u[1]);
            ([at.x, at.y, u[2]], [u[0] * n.x, u[0] * n.y, 0.0])
        };
        let gap = |u: Vec3| {
            let (at, force) = held(u);
            plus(marched(whisker, 120, start, at, force), at, -1.0)
        };
        let mut u = unknowns.unwrap_or([0.0, straight.angle(), whisker.length * axis[2]]);
        for _ in 0..30 {
            let g = gap(u);
            if dot(g, g) < 1e-22 {
                break;
            }
            let column = |j: usize| {
                let h = [1e-6, 1e-7, 1e-8][j];
                let mut moved = u;
                moved[j] += h;
                plus(gap(moved), g, -1.0).map(|v| v / h)
            };
            let c = [column(0), column(1), column(2)];
            let determinant = dot(c[0], cross(c[1], c[2]));
            let step = [cross(c[1], c[2]), cross(c[2], c[0]), cross(c[0], c[1])].map(|v| -dot(g, v) / determinant);
            u = plus(u, step, 1.0);
        }
        let g = gap(u);
        assert!(dot(g, g) < 1e-16 && u[0] > 0.0, "row {k}: {u:?} {g:?}");
        unknowns = Some(u);
        let (at, force) = held(u);
        rows.push((pose, dot(cross(plus(at, start.0, -1.0), force), about)));
    }
    rows
}

fn log_of(rows: &[(Pose2, f64)]) -> SensorLog {
    let start = rows[0].0;
    let row = |(k, (pose, moment)): (usize, &(Pose2, f64))| LogRow {
        t: 0.01 * k as f64,
        odom_from_robot: start.between(*pose),
        readings: vec![*moment],
        heading: None,
        line: k + 2,
    };
    SensorLog {
        channels: vec![Channel { whisker: String::new(), quantity: Quantity::Moment }],
        rows: rows.iter().enumerate().map(row).collect(),
        ..SensorLog::default()
    }
}

fn mounted(elevation: f64, roll: f64) -> MountedWhisker {
    MountedWhisker {
        robot_from_whisker: Pose2::new(0.01, -0.005, -128.0 / 360.0 * TAU),
        lean: Lean { elevation, roll },
        ..MountedWhisker::default()
    }
}

/// How far the deterministic method is off at the end, in place (m) and heading (rad); none where it finds nothing.
fn off(log: &SensorLog, whisker: MountedWhisker, truth: Pose2) -> Option<[f64; 2]> {
    let robot = Robot { whiskers: vec![whisker], ..Robot::default() };
    let method = Method::named("deterministic").unwrap();
    let found = tasks::localize(log, &room(), &robot, &method, &mut |_| {}).unwrap();
    let at = found.estimate?;
    Some([at.position().distance(truth.position()), vibrissa::plane::wrap_angle(at.theta - truth.theta).abs()])
}

#[test]
fn a_robot_with_a_leaning_whisker_is_localized() {
    for (elevation, roll) in [(0.0, 0.0), (0.35, 0.0), (-0.5, 0.2), (0.8, -0.3)] {
        let rows = sweep(&mounted(elevation, roll));
        let (log, truth) = (log_of(&rows), rows.last().unwrap().0);
        let found = off(&log, mounted(elevation, roll), truth);
        let level = off(&log, mounted(0.0, 0.0), truth);
        println!("elevation {elevation}, roll {roll}: off by {found:?}; taken for level {level:?}");
        let [place, heading] = found.expect("it is found");
        assert!(place < 4e-3 && heading < 0.05, "{elevation} {roll}: {place} {heading}");
        if elevation != 0.0 {
            assert!(level.is_none_or(|level| level[0] > 2.0 * place), "{level:?} {place}");
        }
    }
}

#[test]
fn errors_within_the_declared_bound_leave_the_place() {
    let mut random = Random(4);
    let whisker = mounted(0.5, 0.15);
    let mut rows = sweep(&whisker);
    let noise = whisker.noise;
    for (_, moment) in &mut rows {
        let error = random.signed(0.6);
        *moment = (*moment + error * noise.moment_absolute) / (1.0 - error * moment.signum() * noise.moment_relative);
    }
    let [place, heading] = off(&log_of(&rows), whisker, rows.last().unwrap().0).expect("it is found");
    println!("with noise: {place} m, {heading} rad");
    assert!(place < 5e-3 && heading < 0.1, "{place} {heading}");
}

/// How the possibilistic method answers, within a region where one is told.
fn enclosed(log: &SensorLog, whisker: MountedWhisker, prior: Option<Region>) -> vibrissa::Result<Localization> {
    let robot = Robot { whiskers: vec![whisker], ..Robot::default() };
    let options = PossibilisticOptions { prior, last_work: 5_000_000, ..PossibilisticOptions::default() };
    tasks::localize(log, &room(), &robot, &Method::Possibilistic(options), &mut |_| {})
}

/// Whether a box of the set holds the truth, and whether one is left at all.
fn holds(found: &Localization, truth: Pose2) -> bool {
    found.states.iter().any(|b| {
        let middle = 0.5 * (b.theta.lo() + b.theta.hi());
        let theta = middle + vibrissa::plane::wrap_angle(truth.theta - middle);
        b.x.contains(truth.x) && b.y.contains(truth.y) && b.theta.contains(theta)
    })
}

/// Each reading off by up to its declared bound, some by all of it.
fn with_errors(rows: &[(Pose2, f64)], noise: MomentNoise, random: &mut Random) -> Vec<(Pose2, f64)> {
    let one = |(pose, moment): &(Pose2, f64)| {
        let drawn = random.signed(1.3).clamp(-0.999, 0.999);
        (*pose, (moment + drawn * noise.moment_absolute) / (1.0 - drawn * moment.signum() * noise.moment_relative))
    };
    rows.iter().map(one).collect()
}

#[test]
fn the_guaranteed_set_of_a_leaning_whisker_holds_the_truth() {
    let mut random = Random(9);
    // From nothing, and from a place that is known to centimetres where a whisker leans so that small readings tell little.
    for (elevation, roll, known) in [(0.8, -0.3, false), (0.35, 0.0, true)] {
        let whisker = mounted(elevation, roll);
        let all = with_errors(&sweep(&whisker), whisker.noise, &mut random);
        let rows: Vec<(Pose2, f64)> = all.into_iter().step_by(3).collect();
        let prior = known.then(|| {
            let Pose2 { x, y, theta } = rows[0].0;
            [[x - 0.03, x + 0.02], [y - 0.02, y + 0.03], [theta - 0.4, theta + 0.3]]
        });
        let (log, truth) = (log_of(&rows), rows[rows.len() - 1].0);
        let found = enclosed(&log, whisker, prior).unwrap();
        assert!(holds(&found, truth), "{elevation} {roll}: {} {:?}", found.status, found.events);
        let place = found.hypotheses.iter().find(|h| h.pose.position().distance(truth.position()) < 0.03);
        let size = place.map(|place| place.extent.x.width().max(place.extent.y.width()));
        println!("elevation {elevation}, roll {roll}: {} place(s), {size:?} m", found.hypotheses.len());
        assert!(size.is_some_and(|size| size < 0.02), "{elevation} {roll}: {size:?}");
    }
}

#[test]
fn what_is_planar_refuses_whiskers_that_lean() {
    let robot = Robot { whiskers: vec![mounted(0.3, 0.0)], ..Robot::default() };
    let log = log_of(&[(Pose2::IDENTITY, 0.0), (Pose2::new(1e-3, 0.0, 0.0), 2e-3)]);
    let method = Method::named("probabilistic").unwrap();
    let told = tasks::localize(&log, &room(), &robot, &method, &mut |_| {}).unwrap_err().to_string();
    assert!(
        told.contains("leans") && told.contains("elevation 17.189 deg") && told.contains("deterministic"),
        "{told}"
    );
    let rubbing = MountedWhisker { friction: 0.2, ..mounted(0.3, 0.0) };
    let told = enclosed(&log, rubbing, None).unwrap_err().to_string();
    assert!(told.contains("friction pulls it along") && told.contains("0.2"), "{told}");
    let told = tasks::contact::contacts(&log, &robot, &vibrissa::config::ContactOptions::default()).unwrap_err();
    assert!(told.to_string().contains("leans"), "{told}");
    let tapered = MountedWhisker { beam: Whisker { tip_ratio: 0.5, ..Whisker::default() }, ..mounted(0.3, 0.0) };
    let robot = Robot { whiskers: vec![tapered], ..Robot::default() };
    for method in ["deterministic", "possibilistic"] {
        let method = Method::named(method).unwrap();
        let told = tasks::localize(&log, &room(), &robot, &method, &mut |_| {}).unwrap_err().to_string();
        assert!(told.contains("no uniform wire"), "{told}");
    }
}

#[test]
fn files_say_how_whiskers_lean() {
    let read = |text: &str| vibrissa::io::robot::from_toml(text, "robot.toml");
    let near = |a: f64, b: f64| (a - b).abs() < 1e-12;
    let degrees = |d: f64| d / 360.0 * TAU;
    let one =
        read("[[whisker]]\nelevation = \"20 deg\"\nroll = 0.1\nmount_height = \"50 mm\"\nmount = [0.1, 0, \"90 deg\"]")
            .unwrap();
    let whisker = &one.whiskers[0];
    assert!(near(whisker.lean.elevation, degrees(20.0)) && near(whisker.lean.roll, 0.1));
    assert_eq!(read(&vibrissa::io::robot::to_toml(&one)).unwrap(), one);
    // Nose down by 10 deg: a whisker ahead points down, one to the left is turned about itself.
    let text = "[body]\nheight = \"0.2 m\"\npitch = \"10 deg\"\n[[whisker]]\nname = \"a\"\nmount = [0.1, 0, 0]\nmount_height = 0.05\n\
                [[whisker]]\nname = \"b\"\nmount = [0, 0.1, \"90 deg\"]\n";
    let robot = read(text).unwrap();
    let [a, b] = [&robot.whiskers[0], &robot.whiskers[1]];
    assert!(near(a.lean.elevation, degrees(-10.0)) && near(a.lean.roll, 0.0) && near(a.robot_from_whisker.theta, 0.0));
    let (sin, cos) = degrees(10.0).sin_cos();
    assert!(near(a.robot_from_whisker.x, 0.1 * cos + 0.05 * sin) && near(a.robot_from_whisker.y, 0.0));
    assert!(
        near(b.lean.elevation, 0.0)
            && near(b.lean.roll.abs(), degrees(10.0))
            && near(b.robot_from_whisker.theta, FRAC_PI_2)
    );
    assert_eq!(read(&vibrissa::io::robot::to_toml(&robot)).unwrap().whiskers[0].name, "a");
    // An elevation that undoes the pitch.
    let undone = read("[body]\npitch = \"10 deg\"\n[[whisker]]\nelevation = \"10 deg\"").unwrap();
    assert!(near(undone.whiskers[0].lean.elevation, 0.0));
    // Without angles nothing changes, whatever the heights.
    let level = read("[body]\nheight = 0.3\n[[whisker]]\nmount_height = 0.1\nmount = [0.03, 0.02, -1.7]").unwrap();
    assert!(level.require_level("this").is_ok(), "{:?}", level.whiskers[0].lean);
    assert_eq!(level.whiskers[0].robot_from_whisker, Pose2::new(0.03, 0.02, -1.7));
    for (text, line, words) in [
        ("[[whisker]]\nelevation = 20", 2, "-80 deg to 80 deg"),
        ("[[whisker]]\nelevation = \"20 mm\"", 2, "not the unit of an angle"),
        ("[[whisker]]\nmount_height = \"5 deg\"", 2, "not the unit of a length"),
        ("[body]\nyaw = 1", 2, "height, pitch, roll"),
        ("[body]\npitch = \"45 deg\"\n[[whisker]]\nelevation = \"-45 deg\"", 3, "too steeply"),
        ("[body]\nheight = \"20 mm\"\n[[whisker]]\nelevation = \"-45 deg\"", 3, "below the floor"),
    ] {
        let error = read(text).unwrap_err();
        assert!(error.to_string().contains(words) && error.line() == Some(line), "{text}: {error}");
    }
}
