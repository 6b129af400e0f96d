//! Closures of walls that were felt and passed in the thought, and of others that only look alike.

#[path = "../../../../tests/data/random.rs"]
mod random;

use super::super::front_end::{Key, Stretch, StretchPoint};
use super::super::odometry::Leg;
use super::*;
use crate::flow::sensor_log::SensorLog;
use crate::plane::{Pose2, Vec2, wrap_angle};
use crate::world::Odometry;
use random::Random;

/// Way between key poses, contacts along it, how far the robot is from the wall, how far the wall lies from the robot's whisker's end, and
/// radius of the body (m).
const KEY: f64 = 0.1;
const STEP: f64 = 2e-3;
const STANDOFF: f64 = 0.045;
const BODY: f64 = 0.035;

/// A wall to the right of a robot's way, and whether the way comes back to where it began.
struct World {
    name: &'static str,
    wall: Vec<Vec2>,
}

fn at(x: f64, y: f64) -> Vec2 {
    Vec2::new(x, y)
}

/// Rooms that are gone round once and a half, and walls that look alike but never come back: bays beside each other, spirals, stairs.
fn world(draw: &mut Random, kind: usize) -> World {
    let (a, b) = (draw.between(0.3, 0.9), draw.between(0.3, 0.9));
    let rounds =
        |corners: &[Vec2], count: usize| -> Vec<Vec2> { (0..count).map(|k| corners[k % corners.len()]).collect() };
    match kind % 5 {
        0 => World { name: "square", wall: rounds(&[at(0.0, 0.0), at(a, 0.0), at(a, a), at(0.0, a)], 7) },
        1 => World { name: "rectangle", wall: rounds(&[at(0.0, 0.0), at(a, 0.0), at(a, b), at(0.0, b)], 7) },
        2 => {
            // Equal bays along a corridor.
            let (wide, deep) = (draw.between(0.12, 0.3), draw.between(0.1, 0.25));
            let bay = |k: usize| {
                let x = 2.0 * wide * k as f64;
                [at(x, 0.0), at(x + wide, 0.0), at(x + wide, -deep), at(x + 2.0 * wide, -deep)]
                    .into_iter()
                    .chain([at(x + 2.0 * wide, 0.0)])
            };
            World { name: "bays", wall: (0..6).flat_map(bay).collect() }
        }
        3 => {
            // A wall that winds inwards beside itself.
            let (a, inset) = (a.max(0.6), draw.between(0.1, 0.14));
            let turn = |k: usize| {
                let (i, o) = (inset * k as f64, inset * k.saturating_sub(1) as f64);
                [at(o, i), at(a - i, i), at(a - i, a - i), at(i, a - i)]
            };
            World { name: "spiral", wall: (0..2).flat_map(turn).collect() }
        }
        _ => {
            let stair = |k: usize| [at(a * k as f64, b * k as f64), at(a * (k + 1) as f64, b * k as f64)];
            World { name: "stairs", wall: (0..4).flat_map(stair).collect() }
        }
    }
}

/// What a robot beside the wall has felt and passed, by odometry that is wrong within its bounds, and where it was.
fn felt(world: &World, robot: &Robot, options: MappingOptions, draw: &mut Random) -> (FrontEnd, Vec<Pose2>) {
    let mut front = FrontEnd::new(robot, &SensorLog::default(), options);
    let (mut truth, mut odom, mut way) = (Vec::new(), Pose2::IDENTITY, 0.0);
    let scale = robot.odometry.translation_relative * draw.signed(1.0);
    let drift = options.drift * draw.signed(1.0);
    let mut last: Option<Pose2> = None;
    let mut leg = Leg::default();
    // Where a wall turns towards the robot it stops in front of the next one, and turns; so it begins and ends.
    let turns_left = |k: usize| {
        let corners = world.wall.get(k.wrapping_sub(1)..k + 2);
        corners.is_none_or(|c| (c[1] - c[0]).cross(c[2] - c[1]) > 0.0)
    };
    for (number, pair) in world.wall.windows(2).enumerate() {
        let along = (pair[1] - pair[0]) * (1.0 / pair[0].distance(pair[1]));
        let short = |is_left: bool| if is_left { (STANDOFF / STEP).ceil() as usize } else { 0 };
        let count = (pair[0].distance(pair[1]) / STEP) as usize;
        for k in short(turns_left(number))..=count.saturating_sub(short(turns_left(number + 1))) {
            let contact = pair[0] + along * (STEP * k as f64);
            let place = contact + along.perp() * STANDOFF;
            let pose = Pose2::new(place.x, place.y, along.angle());
            // The robot stops at corners and turns there; where walls turn away from it, it goes around them.
            let step = last.map_or(Pose2::IDENTITY, |last| last.between(pose));
            let moved = step.position().norm();
            let told = Pose2::new(step.x * (1.0 + scale), step.y * (1.0 + scale), step.theta + drift * moved);
            odom = odom.compose(told);
            leg.add(told);
            way += moved;
            if last.is_none() || way >= KEY {
                way = 0.0;
                let leg = core::mem::take(&mut leg);
                front.keys.push(Key { t: truth.len() as f64, odom_from_key: odom, leg, ..Key::default() });
                front.stretches.push(Stretch { key: truth.len(), points: Vec::new() });
                truth.push(pose);
            }
            last = Some(pose);
            let index = truth.len() - 1;
            let key_from_map = truth[index].inverse();
            let to_key = key_from_map.compose(pose);
            let point = StretchPoint {
                position: key_from_map.transform_point(contact),
                normal: along.perp().rotated(key_from_map.theta),
                std: 0.1e-3,
            };
            front.stretches[index].points.push(point);
            let passed = (0..=45).map(|j| to_key.transform_point(at(0.0, -1e-3 * f64::from(j))));
            let both = passed.flat_map(|p| [p, p + at(0.7e-3, 0.0).rotated(to_key.theta)]);
            both.for_each(|p| front.keys[index].passed.insert(p, options.cell));
            front.keys[index].stands.push(to_key.position());
        }
    }
    (front, truth)
}

#[test]
fn no_closure_is_proved_that_is_not_one() {
    let worlds = std::env::var("VIBRISSA_CLOSURE_WORLDS").ok().and_then(|n| n.parse().ok()).unwrap_or(5);
    let mut proved = 0;
    for seed in 0..worlds {
        let mut draw = Random(seed);
        let world = world(&mut draw, seed as usize);
        let relative = draw.between(2e-3, 0.03);
        let odometry = Odometry { translation_relative: relative, rotation_relative: 1e-3, ..Odometry::default() };
        let robot = Robot { odometry, ..Robot::default() };
        let drift = draw.between(0.0, 0.05);
        let options = MappingOptions { drift, body_radius: BODY, closure_work: 20_000, ..MappingOptions::default() };
        let (front, truth) = felt(&world, &robot, options, &mut draw);
        let (closures, ties) = closures((&front, 0), &robot, &options, None, &Stop::default());
        for tie in &ties {
            let there = truth[tie.earlier].between(truth[tie.later]);
            let PoseBounds { middle, half } = PoseBounds { middle: tie.earlier_from_later, half: tie.extent };
            let off = [there.x - middle.x, there.y - middle.y, wrap_angle(there.theta - middle.theta)];
            let holds = (0..3).all(|k| off[k].abs() <= half[k] + 1e-9);
            assert!(holds, "{} {seed}: {off:?} beyond {half:?}", world.name);
        }
        let contradictions = closures.iter().filter(|c| c.verdict == ClosureVerdict::Contradiction).count();
        assert_eq!(contradictions, 0, "{} {seed}", world.name);
        proved += ties.len();
    }
    assert!(proved > worlds as usize / 3, "{proved} proved in {worlds} worlds");
}

#[test]
fn each_closure_leads_on_along_the_pass_of_the_one_before() {
    let corners = [at(0.0, 0.0), at(0.62, 0.0), at(0.62, 0.26), at(0.42, 0.26), at(0.42, 0.45), at(0.0, 0.45)];
    let world = World { name: "rounds", wall: (0..6 * 4).map(|k| corners[k % 6]).collect() };
    let odometry = Odometry { translation_relative: 0.005, rotation_relative: 1e-3, ..Odometry::default() };
    let robot = Robot { odometry, ..Robot::default() };
    let options = MappingOptions { body_radius: BODY, drift: 0.02, ..MappingOptions::default() };
    // A heading that drifts turns the odometry of each round against that of the one before.
    let (front, _) = felt(&world, &robot, options, &mut Random(0));
    let (closures, ties) = closures((&front, 0), &robot, &options, None, &Stop::default());
    assert!(closures.len() > 20 && ties.len() * 10 >= closures.len() * 8, "{} of {}", ties.len(), closures.len());
    let way = |key: usize| front.keys[..=key].iter().skip(1).map(|key| key.leg.way).sum::<f64>();
    for pair in ties.windows(2) {
        let [gone, on] = [way(pair[1].later) - way(pair[0].later), way(pair[1].earlier) - way(pair[0].earlier)];
        assert!((gone - on).abs() <= options.submap, "{gone} m later the closure leads {on} m further");
    }
}
