//! Contact points against pegs: the beam's point mode knows what a whisker reads whose side leans on a fixed peg.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must fail")]

#[path = "data/random.rs"]
mod random;

use random::Random;
use vibrissa::beam::{Load, Whisker, force_mode, point_mode};
use vibrissa::config::ContactOptions;
use vibrissa::flow::sensor_log::{Channel, LogRow, Quantity, SensorLog};
use vibrissa::plane::{Pose2, Vec2};
use vibrissa::tasks::contact::*;
use vibrissa::world::{MomentNoise, MountedWhisker, Robot};

/// Degrees of freedom, and what a sum of squares exceeds with the chance of 2.326e-4.
const QUANTILES: [(usize, f64); 4] = [(4, 21.674645594), (10, 33.407070845), (30, 64.800276530), (100, 157.118128553)];
const NOISE: MomentNoise = MomentNoise { moment_relative: 0.05, moment_absolute: 2e-6 };

/// What the whisker reads at `base` when its side leans on `peg`; none when it does not reach.
fn reading(whisker: Whisker, base: Pose2, peg: Vec2) -> Option<ContactReading> {
    let bend = point_mode(&whisker, base.inverse_transform_point(peg), Load::Normal).unwrap().into_iter().next()?;
    Some(ContactReading { t: 0.0, whisker, odom_from_whisker: base, moment: bend.moment, noise: NOISE, count: 1 })
}

/// A peg, and bases from which the whisker leans on it on one side: translations and turns.
fn peg_and_bases(random: &mut Random, turn: bool, count: usize) -> (Vec2, Vec<Pose2>) {
    let start = Pose2::new(random.signed(1.0), random.signed(1.0), random.signed(3.0));
    let (distance, side) = (random.between(0.03, 0.062), random.sign());
    let peg = start.transform_point(Vec2::new(distance, side * 0.03 * distance));
    let along = random.signed(0.3);
    let base = |i: usize| {
        let far = 4e-3 * i as f64 / (count - 1) as f64;
        // The base moves away from the peg's side, or turns towards it.
        let step =
            if turn { Pose2::new(0.0, 0.0, -side * far / distance) } else { Pose2::new(along * far, -side * far, 0.0) };
        start.compose(step)
    };
    (peg, (0..count).map(base).collect())
}

#[test]
fn two_contact_sets_meet_at_the_peg_whatever_the_motion() {
    let mut random = Random(11);
    for case in 0..60 {
        let turn = case % 2 == 1;
        let (peg, bases) = peg_and_bases(&mut random, turn, 2);
        let [a, b] = [0, 1].map(|i| reading(Whisker::default(), bases[i], peg).unwrap());
        let found = meetings(&a, &b);
        let contact = found.iter().filter(|m| m.kind == MeetingKind::Contact);
        let nearest = contact.map(|m| m.position.distance(peg)).fold(f64::INFINITY, f64::min);
        assert!(nearest < 1e-7, "case {case}: {nearest}, {found:?}");
        let base = found.iter().any(|m| m.kind == MeetingKind::Base && m.position.distance(bases[0].position()) < 1e-9);
        assert_eq!(base, turn, "a whisker that only turns has its base in common: {found:?}");
    }
}

#[test]
fn tapered_whiskers_on_elastic_bases_meet_at_the_peg() {
    let mut random = Random(12);
    let whisker = Whisker { tip_ratio: 0.5, base_stiffness: 0.05, ..Whisker::default() };
    for case in 0..2 {
        let (peg, bases) = peg_and_bases(&mut random, case == 1, 4);
        let all: Vec<ContactReading> = bases.iter().map(|b| reading(whisker, *b, peg).unwrap()).collect();
        let start = peg + Vec2::new(1e-3, -1e-3);
        let point = fixed_point(&all, start).unwrap();
        assert!(point.position.distance(peg) < 1e-6, "case {case}: {:?} {peg:?}", point.position);
    }
}

#[test]
fn two_whiskers_at_once_meet_where_both_lean() {
    let peg = Vec2::new(0.05, 0.004);
    let bases = [Pose2::IDENTITY, Pose2::new(0.0, -4.2e-3, 0.0)];
    let all: Vec<ContactReading> = bases.iter().map(|b| reading(Whisker::default(), *b, peg).unwrap()).collect();
    let best = fixed_points(&all).into_iter().find(|p| p.position.distance(peg) < 1e-7);
    assert!(best.is_some());
}

/// The errors have the spread that the covariance says.
#[test]
fn covariances_are_honest() {
    let (mut random, mut square, mut count) = (Random(13), 0.0, 0);
    for _ in 0..150 {
        let turn = random.unit() < 0.5;
        let (peg, bases) = peg_and_bases(&mut random, turn, 80);
        let mut all: Vec<ContactReading> =
            bases.iter().map(|b| reading(Whisker::default(), *b, peg).unwrap()).collect();
        for r in &mut all {
            r.moment += random.signed(1.0) * r.bound(r.moment);
        }
        let point = fixed_point(&all, peg).unwrap();
        let outward = (peg - bases[0].position()) * (1.0 / peg.distance(bases[0].position()));
        let error = (point.position - peg).dot(outward) / point.std_along(outward);
        square += error * error;
        count += 1;
    }
    let rms = (square / f64::from(count)).sqrt();
    assert!((0.75..1.3).contains(&rms), "errors are {rms} of the standard deviations said");
}

/// Sums of squares are held against their law: the quantiles of chi squared for a chance of 2.326e-4, from its incomplete gamma
/// function (Wilson's and Hilferty's approximation is good to 2.3 % for four degrees of freedom).
#[test]
fn sums_of_squares_are_held_against_their_law() {
    for (freedom, quantile) in QUANTILES {
        let at = |share: f64| FixedPoint {
            position: Vec2::ZERO,
            covariance: [0.0; 3],
            chi2: share * quantile,
            freedom,
            s_a: [0.05; 2],
        };
        assert!(at(0.97).fits() && !at(1.03).fits(), "{freedom}");
    }
}

#[test]
fn the_true_point_is_in_every_region() {
    let mut random = Random(14);
    for case in 0..40 {
        let (peg, bases) = peg_and_bases(&mut random, case % 2 == 0, 12);
        let mut all: Vec<ContactReading> =
            bases.iter().map(|b| reading(Whisker::default(), *b, peg).unwrap()).collect();
        for r in &mut all {
            // As far off as the bound allows: |h - z| <= relative |z| + absolute.
            let h = r.moment;
            r.moment = h * (1.0 + random.sign() * 0.0475);
            assert!((h - r.moment).abs() <= r.bound(r.moment));
        }
        let region = contact_region(&all, 1e-3).unwrap();
        assert!(region.contains(peg), "case {case}");
        let r = region.distances(bases[0]);
        assert!(r.contains(peg.distance(bases[0].position())));
    }
}

#[test]
fn regions_are_refused_for_other_whiskers() {
    let whisker = Whisker { tip_ratio: 0.5, ..Whisker::default() };
    let r =
        ContactReading { t: 0.0, whisker, odom_from_whisker: Pose2::IDENTITY, moment: 1e-4, noise: NOISE, count: 1 };
    assert!(contact_region(&[r], 1e-3).is_none());
}

/// Small deflections: all three closed forms are right, and scale with the sign.
#[test]
fn the_closed_forms_of_earlier_work() {
    for side in [1.0, -1.0] {
        for turn in [false, true] {
            let peg = Vec2::new(0.05, 0.0);
            let far = 1e-5;
            let base = if turn { Pose2::new(0.0, 0.0, -side * far / 0.05) } else { Pose2::new(0.0, -side * far, 0.0) };
            let r = reading(Whisker::default(), base, peg).unwrap();
            let baseline = Baseline::since(Pose2::IDENTITY, &r);
            let own = if turn { baseline.rotation } else { baseline.translation };
            for d in [own.unwrap(), baseline.both.unwrap()] {
                assert!((d - 0.05).abs() < 1e-6, "{d} side {side} turn {turn}");
            }
        }
    }
}

fn log_of(rows: Vec<(Pose2, f64)>) -> SensorLog {
    let row = |(i, (pose, moment)): (usize, (Pose2, f64))| LogRow {
        t: i as f64 / 300.0,
        odom_from_robot: pose,
        readings: vec![moment],
        heading: None,
        line: i + 2,
    };
    SensorLog {
        channels: vec![Channel { whisker: String::new(), quantity: Quantity::Moment }],
        rows: rows.into_iter().enumerate().map(row).collect(),
        ..SensorLog::default()
    }
}

/// Past a peg and off it again: onset, side contact at the peg, the slide along the whisker, lift-off.
#[test]
fn a_log_past_a_peg() {
    let mut random = Random(15);
    let robot =
        Robot { whiskers: vec![MountedWhisker { noise: NOISE, ..MountedWhisker::default() }], ..Robot::default() };
    let peg = Vec2::new(0.05, 0.002);
    for side in [1.0, -1.0] {
        let peg = Vec2::new(peg.x, side * peg.y);
        let rows = (0..400).map(|i| {
            let base = Pose2::new(0.0, -side * 5e-5 * f64::from(i) + side * 4e-3, 0.0);
            let local = base.inverse_transform_point(peg);
            let touched = side * local.y > 0.0;
            let moment = if touched { reading(Whisker::default(), base, peg).map_or(0.0, |r| r.moment) } else { 0.0 };
            (base, moment * (1.0 + random.signed(0.045)))
        });
        let mut rows: Vec<(Pose2, f64)> = rows.collect();
        let last = rows.last().unwrap().0;
        rows.extend((0..10).map(|_| (last, 0.0)));
        let report = contacts(&log_of(rows), &robot, &ContactOptions::default()).unwrap();
        let sides: Vec<&ContactStep> = report.steps.iter().filter(|s| s.kind == ContactKind::Side).collect();
        assert!(sides.len() > 100, "{} of {}", sides.len(), report.steps.len());
        let worst = sides.iter().map(|s| s.position().unwrap().distance(peg)).fold(0.0, f64::max);
        assert!(worst < 3e-4, "{worst}");
        assert!(sides.iter().all(|s| s.bounds.is_some_and(|b| b.contains(s.contact.unwrap().norm()))));
        let kinds: Vec<&str> = report.events.iter().map(|e| e.kind).collect();
        for kind in ["contact", "slip_whisker", "lift_off"] {
            assert!(kinds.contains(&kind), "{kinds:?}");
        }
    }
}

/// The same with a tapered whisker on an elastic base, which is integrated: in seconds, not minutes.
#[test]
fn a_log_past_a_peg_with_a_tapered_whisker() {
    let beam = Whisker { tip_ratio: 0.6, base_stiffness: 0.05, ..Whisker::default() };
    let robot = Robot {
        whiskers: vec![MountedWhisker { beam, noise: NOISE, ..MountedWhisker::default() }],
        ..Robot::default()
    };
    let (peg, mut random) = (Vec2::new(0.05, -0.002), Random(16));
    let rows = (0..90).map(|i| {
        let base = Pose2::new(0.0, 1e-4 * f64::from(i) - 2.5e-3, 0.0);
        let touched = base.inverse_transform_point(peg).y < 0.0;
        let moment = if touched { reading(beam, base, peg).map_or(0.0, |r| r.moment) } else { 0.0 };
        (base, moment * (1.0 + random.signed(0.045)))
    });
    let report = contacts(&log_of(rows.collect()), &robot, &ContactOptions::default()).unwrap();
    let sides: Vec<&ContactStep> = report.steps.iter().filter(|s| s.kind == ContactKind::Side).collect();
    assert!(sides.len() >= 4, "{:?}", report.events);
    for side in sides {
        let error = side.position().unwrap().distance(peg);
        assert!(error < 1e-3, "{error}, std {:?}", side.std);
        assert!(side.bounds.is_none(), "bounds are for uniform whiskers");
    }
}

/// The tip slides along a wall across its way until the wall ends; then the side leans on a peg, without a free row between.
#[test]
fn a_peg_after_a_slide_is_felt_with_the_side() {
    let robot =
        Robot { whiskers: vec![MountedWhisker { noise: NOISE, ..MountedWhisker::default() }], ..Robot::default() };
    let mut random = Random(18);
    for side in [1.0, -1.0] {
        // The wall stands across the whisker, 70 mm off: the tip's force is along -x, and stays while the base goes on.
        let whisker = Whisker::default();
        let tip = |force: f64| force_mode(&whisker, force, whisker.length, Load::Directed(3.0)).unwrap().remove(0);
        let (mut lo, mut hi) = (1e-3, 0.3);
        for _ in 0..60 {
            let middle = 0.5 * (lo + hi);
            if tip(middle).contact.x > 0.07 { lo = middle } else { hi = middle }
        }
        let sliding = side * tip(lo).moment.abs();
        let peg = Vec2::new(0.045, -side * 0.0148);
        let rows = (0..600).map(|i| {
            let base = Pose2::new(0.0, -side * 5e-5 * f64::from(i), 0.0);
            let moment = if i < 300 { sliding } else { reading(whisker, base, peg).map_or(0.0, |r| r.moment) };
            (base, moment * (1.0 + random.signed(0.045)))
        });
        let report = contacts(&log_of(rows.collect()), &robot, &ContactOptions::default()).unwrap();
        let sides: Vec<&ContactStep> =
            report.steps.iter().filter(|s| s.kind == ContactKind::Side && s.normal.is_none()).collect();
        assert!(sides.len() > 60, "{side}: {} of {}: {:?}", sides.len(), report.steps.len(), report.events);
        for step in &sides {
            assert!(step.position().unwrap().distance(peg) < 5e-4, "{:?}", step.position());
            assert!(step.t > 0.99, "the tip slid until 1 s: {}", step.t);
        }
        let tips = report.steps.iter().filter(|s| s.kind == ContactKind::Tip).count();
        assert!(tips > 60, "{side}: {tips}: {:?}", report.events);
        assert!(report.events.iter().any(|event| event.kind == "jump"), "{:?}", report.events);
    }
}

/// One millimetre past a peg, as in the paper's table: errors that fill their bound, and the beginning of the contact, tell
/// the distance to a percent; normal errors of the same size are no worse than by least squares.
#[test]
fn a_single_millimetre_tells_the_distance() {
    let noise = MomentNoise { moment_relative: 0.05, moment_absolute: 2e-6 };
    let robot = Robot { whiskers: vec![MountedWhisker { noise, ..MountedWhisker::default() }], ..Robot::default() };
    let (mut random, mut square, mut count) = (Random(19), 0.0, 0.0);
    for uniform in [true, false] {
        let mut sum = 0.0;
        for case in 0..25 {
            let (distance, side) = (0.035 + 0.035 * f64::from(case) / 25.0, random.sign());
            let rows = (-30..=60).map(|i| {
                let base = Pose2::new(0.0, -side * f64::from(i) * 1e-3 / 60.0, 0.0);
                let exact = if i > 0 {
                    reading(Whisker::default(), base, Vec2::new(distance, 0.0)).unwrap().moment
                } else {
                    0.0
                };
                let error = if uniform {
                    random.signed(1.0)
                } else {
                    // Twelve uniform ones make one that is all but normal, here with the variance of the uniform one.
                    (0..12).map(|_| random.signed(1.0)).sum::<f64>() / 12f64.sqrt()
                };
                (base, exact + error * (0.05 * exact.abs() + 1.9e-6))
            });
            let report = contacts(&log_of(rows.collect()), &robot, &ContactOptions::default()).unwrap();
            let step = report.steps.iter().rev().find(|s| s.kind == ContactKind::Side).unwrap();
            let error = step.position().unwrap().x / distance - 1.0;
            sum += error.abs() / 25.0;
            if uniform {
                square += (error * distance / step.std.unwrap()).powi(2);
                count += 1.0;
            }
        }
        assert!(sum < if uniform { 2e-3 } else { 4e-3 }, "mean error {sum}, uniform {uniform}");
    }
    let rms = f64::sqrt(square / count);
    assert!((0.4..1.4).contains(&rms), "errors are {rms} of the standard deviations told");
}

/// Places rounded to 10 µm: a base that moves evenly tells its places better than its rows do, one that does not is left as it is.
#[test]
fn an_even_motion_outdoes_the_rounding_of_its_places() {
    let noise = MomentNoise { moment_relative: 0.05, moment_absolute: 2e-6 };
    let robot = Robot { whiskers: vec![MountedWhisker { noise, ..MountedWhisker::default() }], ..Robot::default() };
    let as_they_are = ContactOptions { odometry_resolution: 0.0, ..ContactOptions::default() };
    let mut random = Random(23);
    let mut sums = [0.0; 2];
    for case in 0..25 {
        let (distance, side) = (0.035 + 0.035 * f64::from(case) / 25.0, random.sign());
        let mut rows = |way: &dyn Fn(f64) -> f64| -> Vec<(Pose2, f64)> {
            let row = |i: i32| {
                let y = -side * way(f64::from(i) / 60.0);
                let peg = Vec2::new(distance, 0.0);
                let felt = |base| reading(Whisker::default(), base, peg).map_or(0.0, |r| r.moment);
                let exact = if i > 0 { felt(Pose2::new(0.0, y, 0.0)) } else { 0.0 };
                let told = Pose2::new(0.0, (y / 1e-5).round() * 1e-5, 0.0);
                (told, exact + random.signed(1.0) * (0.05 * exact.abs() + 1.9e-6))
            };
            (-30..=60).map(row).collect()
        };
        let even = log_of(rows(&|u| 1e-3 * u));
        for (sum, options) in sums.iter_mut().zip([ContactOptions::default(), as_they_are]) {
            let report = contacts(&even, &robot, &options).unwrap();
            let step = report.steps.iter().rev().find(|s| s.kind == ContactKind::Side).unwrap();
            *sum += (step.position().unwrap().x / distance - 1.0).abs() / 25.0;
        }
        let uneven = log_of(rows(&|u| 1e-3 * u * (0.6 + 0.4 * u.abs())));
        let [a, b] = [ContactOptions::default(), as_they_are].map(|o| contacts(&uneven, &robot, &o).unwrap());
        assert_eq!(a, b, "a motion that is not even is none that was rounded");
    }
    assert!(sums[0] < 0.8 * sums[1] && sums[0] < 2e-3, "{sums:?}");
}

/// A base that turns past a peg: the same point, and Kaneko's closed form beside it.
#[test]
fn a_log_of_a_turn_past_a_peg() {
    let robot =
        Robot { whiskers: vec![MountedWhisker { noise: NOISE, ..MountedWhisker::default() }], ..Robot::default() };
    let mut random = Random(17);
    for side in [1.0, -1.0] {
        let peg = Vec2::new(0.045, side * 1e-3);
        let rows = (0..300).map(|i| {
            let base = Pose2::new(0.0, 0.0, side * (1e-3 * f64::from(i) - 0.02));
            let touched = side * base.inverse_transform_point(peg).y < 0.0;
            let moment = if touched { reading(Whisker::default(), base, peg).map_or(0.0, |r| r.moment) } else { 0.0 };
            (base, moment * (1.0 + random.signed(0.045)))
        });
        let report = contacts(&log_of(rows.collect()), &robot, &ContactOptions::default()).unwrap();
        let sides: Vec<&ContactStep> = report.steps.iter().filter(|s| s.kind == ContactKind::Side).collect();
        assert!(sides.len() > 50, "{:?}", report.events);
        for step in &sides {
            assert!(step.position().unwrap().distance(peg) < 4e-4, "{:?} {:?}", step.position(), step.std);
            assert!(step.baseline.translation.is_none());
        }
        let last = sides.last().unwrap().baseline.rotation.unwrap();
        assert!((last - 0.045).abs() < 6e-3, "{last}");
    }
}

#[test]
fn a_log_without_moments_or_with_wild_options_is_refused() {
    let mut log = log_of(vec![(Pose2::IDENTITY, 0.0)]);
    let bad = ContactOptions { spacing: f64::NAN, ..ContactOptions::default() };
    assert!(contacts(&log, &Robot::default(), &bad).unwrap_err().is_usage());
    log.channels[0].quantity = Quantity::Slope;
    let error = contacts(&log, &Robot::default(), &ContactOptions::default()).unwrap_err();
    assert!(error.is_data() && error.to_string().contains("moment"), "{error}");
}

/// The simulator's readings are even in what the bound allows, not about the moment: deviations that leave that out would be told
/// many times too small once there are many readings.
#[test]
fn deviations_hold_on_the_simulator_s_readings() {
    let peg = Vec2::new(0.055, 0.0);
    let post = vibrissa::plane::Curve::circle(peg, 2e-5).unwrap();
    let role = vibrissa::world::Role::Obstacle;
    let map = vibrissa::world::Map::new(vec![vibrissa::world::Boundary::new(role, post, None).unwrap()]).unwrap();
    let robot =
        Robot { whiskers: vec![MountedWhisker { noise: NOISE, ..MountedWhisker::default() }], ..Robot::default() };
    let way = [Pose2::new(0.0, 5e-4, 0.0), Pose2::new(0.0, -6e-3, 0.0)];
    let pace = vibrissa::sim::Pace { speed: 5e-3, turn_rate: 1.0, rate: 300.0 };
    let path = vibrissa::sim::path_through(&way, &pace).unwrap();
    let seeds = 12;
    let mut square = 0.0;
    for seed in 0..seeds {
        let noise = vibrissa::sim::SweepNoise::seeded(seed);
        let sweep = vibrissa::sim::simulate_tip_sweep(&map, &robot, &path, &noise).unwrap();
        let report = contacts(&sweep.log, &robot, &ContactOptions::default()).unwrap();
        let step = report.steps.iter().rev().find(|step| step.kind == ContactKind::Side).unwrap();
        // The base starts at y = 0.5 mm of the map, at the origin of the odometry.
        let off = step.position().unwrap().distance(peg - way[0].position());
        println!("seed {seed}: {:.1} um off, told {:.1} um", 1e6 * off, 1e6 * step.std.unwrap());
        square += (off / step.std.unwrap()).powi(2) / seeds as f64;
    }
    assert!(square.sqrt() < 1.6, "deviations are told {} times too small", square.sqrt());
}
