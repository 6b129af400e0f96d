//! Preimages of tip contact against simulated sweeps, which share nothing with them but the beam.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

use core::f64::consts::FRAC_PI_2;
use vibrissa::beam::{Load, Whisker};
use vibrissa::flow::contact_set::{
    ContactCell, ContactModel, ContactRegion, MomentRegime, Parts, Reading, Resolution, VirtualSensor,
};
use vibrissa::flow::pose::StampedPose;
use vibrissa::flow::preimage::{PreimageOptions, reading_preimage};
use vibrissa::plane::{Curve, Pose2, Vec2, wrap_angle};
use vibrissa::sets::Interval;
use vibrissa::sim::{Pace, Part, Sweep, SweepNoise, Touch, path_through, simulate_tip_sweep};
use vibrissa::tasks::demo;
use vibrissa::world::{Boundary, Map, Robot, Role};

const MOMENT: VirtualSensor = VirtualSensor::Moment(MomentRegime::LargeAngle);

fn robot(beam: Whisker, mount: Pose2) -> Robot {
    let mut robot = Robot::default();
    robot.whiskers[0].beam = beam;
    robot.whiskers[0].robot_from_whisker = mount;
    robot
}

fn swept(map: &Map, robot: &Robot, waypoints: &[Pose2]) -> Sweep {
    let pace = Pace { speed: 0.15, turn_rate: 1.0, rate: 60.0 };
    let path: Vec<StampedPose> = path_through(waypoints, &pace).unwrap();
    simulate_tip_sweep(map, robot, &path, &SweepNoise::none()).unwrap()
}

fn polygon(points: &[(f64, f64)]) -> Curve {
    let points: Vec<Vec2> = points.iter().map(|p| Vec2::new(p.0, p.1)).collect();
    Curve::polyline(&points, true).unwrap()
}

/// A room with a block and a round pillar: corners of both kinds, straight and round walls.
fn room() -> Map {
    let of = |role, curve| Boundary::new(role, curve, None).unwrap();
    Map::new(vec![
        of(Role::Arena, polygon(&[(0.0, 0.0), (0.4, 0.0), (0.4, 0.3), (0.0, 0.3)])),
        of(Role::Obstacle, polygon(&[(0.15, 0.0), (0.2, 0.0), (0.2, 0.03), (0.15, 0.03)])),
        of(Role::Obstacle, Curve::circle(Vec2::new(0.3, 0.15), 0.025).unwrap()),
    ])
    .unwrap()
}

/// Sweeps whose whisker trails along the floor over the block, and past the pillar.
fn sweeps(robot: &Robot) -> Vec<(Map, Sweep)> {
    let mount = robot.whiskers[0].robot_from_whisker.inverse();
    let base = |x: f64, y: f64, theta: f64| Pose2::new(x, y, theta).compose(mount);
    let along = [base(0.05, 0.09, -1.9), base(0.05, 0.055, -1.9), base(0.26, 0.055, -1.9)];
    let past = [base(0.24, 0.2, -0.3), base(0.25, 0.178, -0.3), base(0.225, 0.178, -0.3)];
    let head_on = [base(0.1, 0.2, 1.3), base(0.1, 0.235, 1.3), base(0.16, 0.24, 1.5)];
    [&along[..], &past, &head_on].into_iter().map(|way| (room(), swept(&room(), robot, way))).collect()
}

/// The rows with one contact: the touch, the robot, the moment.
fn single(sweep: &Sweep) -> Vec<(Touch, Pose2, f64)> {
    let alone = |t: &&Touch| sweep.contacts.iter().filter(|other| other.row == t.row).count() == 1;
    sweep
        .contacts
        .iter()
        .filter(alone)
        .map(|t| (*t, sweep.truth[t.row].map_from_robot, sweep.exact_moments[t.row][0]))
        .collect()
}

/// The reading of a sensor at a touch.
fn reading(sensor: VirtualSensor, touch: &Touch, moment: f64) -> f64 {
    match sensor {
        VirtualSensor::Load => touch.force.norm().copysign(moment),
        VirtualSensor::Strip => touch.s_a,
        _ => moment,
    }
}

#[test]
fn the_true_contact_is_in_the_region_of_its_reading() {
    let (mut tips, mut sides) = (0, 0);
    for beam in [Whisker::default(), Whisker { tip_ratio: 0.5, curvature: 3.0, ..Whisker::default() }] {
        let robot = robot(beam, Pose2::IDENTITY);
        let model = ContactModel::new(&beam, Load::Normal).unwrap();
        // Rods take microseconds a shape.
        let step = if beam.is_uniform() { 1 } else { 60 };
        for (_, sweep) in sweeps(&robot) {
            for (touch, state, moment) in single(&sweep).into_iter().step_by(step) {
                let place = state.inverse().transform_point(touch.position);
                let sign = 1.0_f64.copysign(moment);
                // The wall's direction if the force is positive, the opposite if negative.
                let wall = (touch.force * sign).rotated(-state.theta - FRAC_PI_2).angle();
                for sensor in [MOMENT, VirtualSensor::Load] {
                    let exact = [Reading::exact(sensor, reading(sensor, &touch, moment))];
                    let fine = Resolution::even(1e-3, 0.02);
                    let region = ContactRegion::of_parts(&model, &exact, Parts::All, &fine).unwrap();
                    let holds = |tip: bool| {
                        region.cells.iter().any(|cell| {
                            let middle = 0.5 * (cell.wall.lo() + cell.wall.hi());
                            let turned = wrap_angle(wall - middle).abs() <= 0.5 * cell.wall.width() + 1e-6;
                            cell.is_tip == tip && turned && cell.cover.grown(1e-7).contains(place)
                        })
                    };
                    let tip = touch.part == Part::Tip;
                    assert!(holds(tip), "{sensor:?} {touch:?} {state:?} {moment}");
                    // Teeth: cells are small, so that hardly any other direction is explained at the place.
                    let small = |c: &ContactCell| c.radius < 2e-3 && c.wall.width() < 0.05;
                    assert!(!beam.is_uniform() || region.cells.iter().all(|c| small(c) || c.arc_length.lo() < 1e-3));
                    if tip {
                        tips += 1;
                    } else {
                        sides += 1;
                    }
                }
            }
        }
    }
    println!("{tips} tips, {sides} sides");
    assert!(tips > 150 && sides > 80, "{tips} {sides}");
}

#[test]
fn swept_states_are_in_the_preimage_of_their_moment() {
    let mount = Pose2::new(0.02, -0.01, 0.4);
    let model = ContactModel::new(&Whisker::default(), Load::Normal).unwrap();
    let options = PreimageOptions { cell: 2e-3, headings: 180, ..PreimageOptions::default() };
    let (mut tips, mut sides, mut only) = (0, 0, 0);
    for (map, sweep) in sweeps(&robot(Whisker::default(), mount)) {
        let rows = single(&sweep);
        for (touch, state, moment) in rows.iter().step_by(rows.len().div_ceil(9)) {
            let solve = |contacts| {
                let exact = [Reading::exact(MOMENT, *moment)];
                reading_preimage(&map, &model, mount, &exact, &PreimageOptions { contacts, ..options }).unwrap()
            };
            let [all, side] = [Parts::All, Parts::Side].map(solve);
            assert!(all.states.contains(*state), "{touch:?} {state:?} {moment}");
            assert!(all.states.volume() > side.states.volume());
            match touch.part {
                Part::Tip => tips += 1,
                Part::Side => sides += 1,
            }
            // What this is for: the side alone leaves swept tips out.
            only += usize::from(touch.part == Part::Tip && !side.states.contains(*state));
        }
    }
    println!("{tips} tips, {only} of them not in the side's preimage; {sides} sides");
    assert!(tips > 12 && sides > 3 && 2 * only > tips, "{tips} {sides} {only}");
}

#[test]
fn the_demos_states_are_in_the_preimages_of_bounded_readings() {
    let (arena, sweep) = (demo::arena().unwrap(), demo::sweep(1).unwrap());
    let model = ContactModel::new(&Whisker::default(), Load::Normal).unwrap();
    let options = PreimageOptions { cell: 4e-3, headings: 120, ..PreimageOptions::default() };
    let rows = single(&sweep);
    for (touch, state, moment) in rows.iter().step_by(rows.len().div_ceil(6)) {
        for sensor in [MOMENT, VirtualSensor::Load] {
            let value = reading(sensor, touch, *moment);
            let bound = Interval::new(value - 0.03 * value.abs(), value + 0.01 * value.abs());
            let found =
                reading_preimage(&arena, &model, Pose2::IDENTITY, &[Reading { sensor, value: bound }], &options);
            assert!(found.unwrap().states.contains(*state), "{sensor:?} {touch:?}");
        }
    }
}

#[test]
fn a_strip_that_ends_before_the_tip_rules_the_tip_out() {
    let model = ContactModel::new(&Whisker::default(), Load::Normal).unwrap();
    let region = |lo: f64, hi: f64| {
        let readings = [
            Reading { sensor: VirtualSensor::Strip, value: Interval::new(lo, hi) },
            Reading { sensor: MOMENT, value: Interval::new(2e-3, 2.1e-3) },
        ];
        ContactRegion::of_parts(&model, &readings, Parts::All, &Resolution::even(2e-3, 0.05)).unwrap()
    };
    assert!(region(0.06, 0.074).cells.iter().all(|cell| !cell.is_tip));
    assert!(region(0.06, 0.075).cells.iter().any(|cell| cell.is_tip));
    // Every tip contact has its force's side: the whisker lies in front of the wall.
    assert!(region(0.075, 0.075).cells.iter().filter(|c| c.is_tip).all(|c| c.contact.tilt * c.contact.force >= 0.0));
}
