//! Whiskers as the map bends them, against the simulator: another iteration, and marched or measured shapes.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on must fail")]

use vibrissa::beam::Whisker;
use vibrissa::contact::BentWhisker;
use vibrissa::plane::{Curve, Pose2, Vec2};
use vibrissa::sim::{Pace, SimulateOptions, SweepNoise, path_through, shapes, simulate, simulate_tip_sweep};
use vibrissa::tasks::demo;
use vibrissa::world::{Boundary, Map, MountedWhisker, Robot, Role};

const POINTS: usize = 25;

/// How far a point is from a chain of lines.
fn off(point: Vec2, chain: &[Vec2]) -> f64 {
    let nearest = |pair: &[Vec2]| {
        let along = pair[1] - pair[0];
        let share = ((point - pair[0]).dot(along) / along.norm_squared()).clamp(0.0, 1.0);
        point.distance(pair[0] + along * share)
    };
    chain.windows(2).map(nearest).fold(f64::INFINITY, f64::min)
}

#[test]
fn moments_and_shapes_are_those_of_the_simulator() {
    let map = demo::arena().unwrap();
    let path = demo::path().unwrap();
    for beam in [Whisker::default(), Whisker { tip_ratio: 0.5, ..Whisker::default() }] {
        let robot = Robot { whiskers: vec![MountedWhisker { beam, ..MountedWhisker::default() }], ..Robot::default() };
        let sweep = simulate(&map, &robot, &path, &SweepNoise::none(), &SimulateOptions::default()).unwrap();
        // A view is drawn twenty times a second: each 15th row.
        let drawn = shapes(&robot, &sweep, 15);
        let mut followed = BentWhisker::new(&map, &beam).unwrap();
        let (mut bent, mut worst_moment, mut worst_shape) = (0, 0.0_f64, 0.0_f64);
        for shape in &drawn {
            let map_from_whisker = sweep.truth[shape.row].map_from_robot;
            let bending = followed.at(map_from_whisker, POINTS);
            let moment = sweep.log.rows[shape.row].readings[0];
            worst_moment = worst_moment.max((bending.moment.unwrap() - moment).abs());
            if moment.abs() < 1e-5 {
                continue;
            }
            bent += 1;
            assert_eq!(bending.shape.len(), POINTS);
            for point in &bending.shape {
                worst_shape = worst_shape.max(off(map_from_whisker.transform_point(*point), &shape.points));
            }
            let contact = map_from_whisker.transform_point(bending.contact.unwrap());
            assert!(off(contact, &shape.points) < 1e-4);
            // Put down at this pose out of nothing it comes to the same rest, or to another one on a boundary.
            let fresh = BentWhisker::new(&map, &beam).unwrap().at(map_from_whisker, POINTS);
            if let Some(contact) = fresh.contact {
                assert!(map.foot(map_from_whisker.transform_point(contact), 1e-4).is_some());
            }
        }
        assert!(bent > 10, "{bent}");
        assert!(worst_moment < 2e-5 && worst_shape < 1e-4, "{worst_moment} N m, {worst_shape} m");
    }
}

#[test]
fn a_moment_alone_gives_a_shape_with_that_moment() {
    let map = demo::arena().unwrap();
    let beam = Whisker::default();
    let whisker = BentWhisker::new(&map, &beam).unwrap();
    assert_eq!(whisker.by_moment(0.0, POINTS), [Vec2::ZERO, Vec2::new(beam.length, 0.0)]);
    for moment in [1e-3, -2e-3, 3e-3] {
        let shape = whisker.by_moment(moment, 401);
        // The curvature at the base is the moment over the rigidity.
        let turn = (shape[2] - shape[1]).angle() - (shape[1] - shape[0]).angle();
        let curvature = turn / shape[1].distance(shape[0]);
        let want = moment / beam.flexural_rigidity;
        assert!((curvature - want).abs() < 0.01 * want.abs(), "{moment}: {curvature} for {want}");
        let length: f64 = shape.windows(2).map(|pair| pair[0].distance(pair[1])).sum();
        assert!((length - beam.length).abs() < 1e-5);
    }
    // Beyond what a tip can cause: still a shape.
    assert_eq!(whisker.by_moment(1.0, POINTS).len(), POINTS);
}

#[test]
fn a_tip_held_in_a_corner_has_a_shape_beyond_the_first_mode_too() {
    let robot = Robot::default();
    let corners = [(0.0, 0.0), (0.4, 0.0), (0.4, 0.4), (0.0, 0.4)].map(|(x, y)| Vec2::new(x, y));
    let outline = Curve::polyline(&corners, true).unwrap();
    let map = Map::new(vec![Boundary::new(Role::Arena, outline, None).unwrap()]).unwrap();
    let mut turned = 0;
    for heading in [-2.15, -2.1, -2.05] {
        // The tip slides along the floor into the corner, and the base goes on.
        let way = [(0.09, 0.075), (0.08, 0.0583), (0.036, 0.0583)].map(|(x, y)| Pose2::new(x, y, heading));
        let path = path_through(&way, &Pace { speed: 0.1, turn_rate: 1.0, rate: 300.0 }).unwrap();
        let sweep = simulate_tip_sweep(&map, &robot, &path, &SweepNoise::none()).unwrap();
        let whisker = &robot.whiskers[0];
        let mut followed = BentWhisker::new(&map, &whisker.beam).unwrap();
        let (mut least, mut most) = (0.0_f64, 0.0_f64);
        for (row, pose) in sweep.truth.iter().enumerate() {
            let map_from_whisker = pose.map_from_robot.compose(whisker.robot_from_whisker);
            let bending = followed.at(map_from_whisker, POINTS);
            let (moment, exact) = (bending.moment.unwrap(), sweep.exact_moments[row][0]);
            assert!((moment - exact).abs() < 1e-5, "row {row}: {moment} for {exact} N m");
            (least, most) = (least.min(exact), most.max(exact));
            let Some(contact) = bending.contact else { continue };
            assert_eq!(bending.shape.len(), POINTS, "row {row}");
            let tip = bending.shape[POINTS - 1];
            assert!(tip.distance(contact) < 1e-4, "row {row}: {:.3} mm", 1e3 * tip.distance(contact));
        }
        turned += usize::from(least < -1e-3 && most > 1e-3);
    }
    assert_eq!(turned, 3, "the moment changes its sign in the corner");
}
