//! Force and slope as readings: alone, beside the moment, and from a whisker that is bent from the first row on.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

#[path = "data/random.rs"]
mod random;

use random::Random;
use vibrissa::beam::{Bend, Whisker, elastica};
use vibrissa::config::ProbabilisticOptions;
use vibrissa::flow::pose::{Localization, Status};
use vibrissa::flow::sensor_log::{Channel, Quantity, SensorLog};
use vibrissa::plane::{Pose2, Vec2, wrap_angle};
use vibrissa::sim::{SweepNoise, simulate_tip_sweep};
use vibrissa::tasks::demo;
use vibrissa::world::{Map, ReadingNoise, Robot};
use vibrissa::{Method, localize};

/// The demo's sweep with these quantities in the log, each reading anywhere within its bound; and where the robot ends.
fn sweep(quantities: &[Quantity], seed: u64) -> (Map, Robot, SensorLog, Pose2) {
    let (map, robot) = (demo::arena().unwrap(), Robot::default());
    let sweep = simulate_tip_sweep(&map, &robot, &demo::path().unwrap(), &SweepNoise::none()).unwrap();
    let whisker = &robot.whiskers[0];
    let mut draw = Random(seed);
    let mut within = |h: f64, noise: ReadingNoise| {
        // z with |h - z| <= r |z| + a, for the signs of all three.
        let share = draw.between(-1.0, 1.0);
        (h + share * noise.absolute) / (1.0 - share * noise.relative * h.signum())
    };
    let mut log = sweep.log.clone();
    log.channels = quantities.iter().map(|&quantity| Channel { whisker: String::new(), quantity }).collect();
    for row in &mut log.rows {
        row.readings.clear();
    }
    let moment_noise =
        ReadingNoise { relative: whisker.noise.moment_relative, absolute: whisker.noise.moment_absolute };
    for index in 0..log.rows.len() {
        let touch = sweep.contacts.iter().find(|touch| touch.row == index);
        let base = sweep.truth[index].map_from_robot.compose(whisker.robot_from_whisker);
        let bend = touch.map(|touch| {
            let seen = base.inverse();
            bent(&whisker.beam, seen.transform_point(touch.position), touch.force.rotated(seen.theta))
        });
        for quantity in quantities {
            let reading = match (quantity, &bend) {
                (Quantity::Moment, bend) => within(bend.as_ref().map_or(0.0, |b| b.moment), moment_noise),
                (Quantity::Force, bend) => {
                    within(bend.as_ref().map_or(0.0, |b| b.force.abs().copysign(b.moment)), whisker.force_noise)
                }
                (_, bend) => within(bend.as_ref().map_or(0.0, |b| b.phi_a), whisker.slope_noise),
            };
            log.rows[index].readings.push(reading);
        }
    }
    let truth = sweep.truth.last().unwrap().map_from_robot;
    (map, robot, log, truth)
}

/// The whisker with its tip there under this force (whisker frame): the slope is searched for, by another road than the
/// localizer's.
fn bent(beam: &Whisker, tip: Vec2, force: Vec2) -> Bend {
    let with = |slope: f64| {
        let tilt = wrap_angle(force.angle() - slope - core::f64::consts::FRAC_PI_2);
        elastica::bend(beam.flexural_rigidity, force.norm(), beam.length, tilt)
    };
    let far = |slope: f64| with(slope).map_or(1.0, |b| b.contact.distance(tip) + 0.02 * (b.phi_a - slope).abs());
    let nearest = |middle: f64, (step, count): (f64, i32)| {
        let tried = (-count..=count).map(|k| middle + step * f64::from(k));
        tried.min_by(|a, b| far(*a).total_cmp(&far(*b))).unwrap()
    };
    let slope = [(4e-3, 600), (2e-4, 40), (1e-5, 40), (5e-7, 40)].into_iter().fold(0.0, nearest);
    let bend = with(slope).unwrap();
    assert!(bend.contact.distance(tip) < 1e-6, "{tip:?} {force:?}");
    bend
}

fn run(map: &Map, robot: &Robot, log: &SensorLog) -> Localization {
    let options = Method::Probabilistic(ProbabilisticOptions::exact());
    localize(log, map, robot, &options, &mut |_| {}).unwrap()
}

/// Distance (m) and turn (rad) from the truth.
fn off(answer: &Localization, truth: Pose2) -> (f64, f64) {
    let found = answer.estimate.unwrap();
    (found.position().distance(truth.position()), wrap_angle(found.theta - truth.theta).abs())
}

#[test]
fn each_sense_alone_finds_the_place() {
    for quantity in [Quantity::Moment, Quantity::Force, Quantity::Slope] {
        let (map, robot, log, truth) = sweep(&[quantity], 5);
        let answer = run(&map, &robot, &log);
        let (distance, turn) = off(&answer, truth);
        println!("{quantity:?}: {:?}, {:.3} mm, {:.3} deg", answer.status, 1e3 * distance, turn.to_degrees());
        assert_eq!(answer.status, Status::Localized, "{quantity:?}");
        assert!(distance < 0.6e-3 && turn < 0.005, "{quantity:?}: {distance} m, {turn} rad");
    }
}

#[test]
fn more_senses_are_sharper() {
    let size = |quantities: &[Quantity]| {
        let (map, robot, log, truth) = sweep(quantities, 6);
        let answer = run(&map, &robot, &log);
        let (distance, _) = off(&answer, truth);
        assert!(answer.status == Status::Localized && distance < 0.4e-3, "{quantities:?}: {distance} m");
        answer.hypotheses[0].bound().unwrap().0
    };
    let alone = size(&[Quantity::Moment]);
    let all = size(&[Quantity::Moment, Quantity::Force, Quantity::Slope]);
    println!("moment alone {:.3} mm, with force and slope {:.3} mm", 1e3 * alone, 1e3 * all);
    assert!(all < 0.85 * alone, "{all} {alone}");
}

#[test]
fn a_whisker_that_is_bent_from_the_first_row_on_is_found() {
    for quantity in [Quantity::Force, Quantity::Slope] {
        let (map, robot, mut log, truth) = sweep(&[quantity], 7);
        let touching = log.rows.iter().position(|row| row.readings[0].abs() > 0.05).unwrap();
        log.rows.drain(..touching + 5);
        let answer = run(&map, &robot, &log);
        let near = answer.hypotheses.iter().map(|h| h.pose.position().distance(truth.position())).fold(1.0, f64::min);
        println!("{quantity:?}: {:?}, {:.3} mm", answer.status, 1e3 * near);
        assert!(matches!(answer.status, Status::Localized | Status::Ambiguous) && near < 1e-3, "{quantity:?}: {near}");
    }
}

#[test]
fn a_wrong_scale_of_the_force_is_found_out() {
    let (map, robot, mut log, truth) = sweep(&[Quantity::Force], 8);
    log.rows.iter_mut().for_each(|row| row.readings[0] *= 2.0);
    let answer = run(&map, &robot, &log);
    let right = answer.estimate.is_some_and(|found| found.position().distance(truth.position()) < 1e-3);
    assert!(answer.status != Status::Localized || right, "{:?}", answer.estimate);
}
