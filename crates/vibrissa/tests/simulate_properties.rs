//! What must hold of every simulated contact, checked without the closed form: the shape by a march along the whisker,
//! the boundary by its own geometry, the motion by symmetry.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on must fail")]

#[path = "data/random.rs"]
mod random;

use random::Random;
use vibrissa::flow::pose::StampedPose;
use vibrissa::plane::{Curve, Pose2, Vec2};
use vibrissa::sim::{Pace, path_through};
use vibrissa::sim::{Sweep, SweepNoise, simulate_tip_sweep};
use vibrissa::world::{Boundary, Map, Robot, Role};

const PACE: Pace = Pace { speed: 0.15, turn_rate: 1.0, rate: 300.0 };

fn boundary(role: Role, curve: Option<Curve>) -> Boundary {
    Boundary::new(role, curve.unwrap(), None).unwrap()
}

/// A disc of 40 mm radius above a straight wall that lies to its left.
fn disc_and_wall() -> Vec<Boundary> {
    vec![
        boundary(Role::Obstacle, Curve::circle(Vec2::new(0.05, 0.1), 0.04)),
        boundary(Role::Wall, Curve::polyline(&[Vec2::new(-0.3, 0.07), Vec2::new(-0.05, 0.08)], false)),
    ]
}

/// Past the wall from the left, free, then past the disc; 2 degrees of turn on the way.
fn waypoints() -> Vec<Pose2> {
    [[-0.11, -0.005, 2.1], [-0.09, 0.022, 2.1], [-0.005, 0.024, 2.13], [0.03, 0.0, 2.1], [0.1, 0.002, 2.1]]
        .map(|[x, y, theta]| Pose2::new(x, y, theta))
        .to_vec()
}

fn moved(boundaries: &[Boundary], place: impl Fn(Vec2) -> Vec2) -> Map {
    let one = |b: &Boundary| {
        let segments = b.curve().segments().iter().map(|s| match *s {
            vibrissa::plane::Segment::Line(p) => vibrissa::plane::Segment::Line(p.map(&place)),
            vibrissa::plane::Segment::Quadratic(p) => vibrissa::plane::Segment::Quadratic(p.map(&place)),
            vibrissa::plane::Segment::Cubic(p) => vibrissa::plane::Segment::Cubic(p.map(&place)),
        });
        boundary(b.role(), Curve::from_segments(segments.collect(), b.curve().is_closed()))
    };
    Map::new(boundaries.iter().map(one).collect()).unwrap()
}

fn sweep(map: &Map, path: &[StampedPose]) -> Sweep {
    simulate_tip_sweep(map, &Robot::default(), path, &SweepNoise::none()).unwrap()
}

fn reference() -> (Map, Vec<StampedPose>, Sweep) {
    let map = Map::new(disc_and_wall()).unwrap();
    let path = path_through(&waypoints(), &PACE).unwrap();
    let sweep = sweep(&map, &path);
    assert!(sweep.contacts.len() > 150, "the path must touch: {}", sweep.contacts.len());
    let happened: Vec<&str> = sweep.events.iter().map(|e| e.kind).collect();
    assert_eq!(happened, ["onset", "lift_off", "onset"], "{:?}", sweep.events);
    (map, path, sweep)
}

/// The tip of a clamped whisker that feels this tip force (whisker frame) with its tip supposed at `tip`.
fn marched_tip(length: f64, rigidity: f64, force: Vec2, tip: Vec2) -> Vec2 {
    let steps = 400;
    let h = length / f64::from(steps);
    let rate = |state: [f64; 3]| {
        let arm = tip - Vec2::new(state[0], state[1]);
        [state[2].cos(), state[2].sin(), arm.cross(force) / rigidity]
    };
    let add = |a: [f64; 3], b: [f64; 3], h: f64| [a[0] + h * b[0], a[1] + h * b[1], a[2] + h * b[2]];
    let mut state = [0.0; 3];
    for _ in 0..steps {
        let k1 = rate(state);
        let k2 = rate(add(state, k1, 0.5 * h));
        let k3 = rate(add(state, k2, 0.5 * h));
        let k4 = rate(add(state, k3, h));
        state = add(add(add(add(state, k1, h / 6.0), k2, h / 3.0), k3, h / 3.0), k4, h / 6.0);
    }
    Vec2::new(state[0], state[1])
}

#[test]
fn every_contact_is_an_equilibrium_on_the_boundary() {
    let (map, path, sweep) = reference();
    let beam = Robot::default().whiskers[0].beam;
    for touch in &sweep.contacts {
        let pose = path[touch.row].map_from_robot;
        let ground = map.nearest(touch.position).unwrap();
        assert!(ground.distance < 1e-10, "the tip is {} m off the boundary", ground.distance);
        let normal = Vec2::from_angle(ground.tangent).perp();
        let aslant = touch.force.cross(normal) / touch.force.norm();
        assert!(aslant.abs() < 1e-9, "row {}: the force is {aslant} rad off the normal", touch.row);
        assert!(touch.force.dot(pose.position() - touch.position) > 0.0, "the wall pushes the whisker away");
        let moment = (touch.position - pose.position()).cross(touch.force);
        assert!((moment - sweep.exact_moments[touch.row][0]).abs() < 1e-12, "moments balance");
        let tip = pose.inverse_transform_point(touch.position);
        let marched = marched_tip(beam.length, beam.flexural_rigidity, touch.force.rotated(-pose.theta), tip);
        assert!(marched.distance(tip) < 1e-9, "row {}: the march ends {} m off", touch.row, marched.distance(tip));
    }
}

#[test]
fn energy_is_the_work_done_on_the_tip() {
    let (map, ..) = reference();
    let path = path_through(&waypoints(), &Pace { rate: 6000.0, ..PACE }).unwrap();
    let sweep = sweep(&map, &path);
    let seen = |touch: &vibrissa::sim::Touch| {
        let pose = path[touch.row].map_from_robot;
        (pose.inverse_transform_point(touch.position), touch.force.rotated(-pose.theta))
    };
    let (mut work, mut start, mut compared) = (0.0, None, 0);
    for pair in sweep.contacts.windows(2) {
        let ((p, f), (q, g)) = (seen(&pair[0]), seen(&pair[1]));
        if pair[1].row != pair[0].row + 1 {
            (work, start) = (0.0, None);
            continue;
        }
        let begin = *start.get_or_insert(pair[0].energy);
        work += 0.5 * (f + g).dot(q - p);
        let stored = pair[1].energy - begin;
        assert!((stored - work).abs() < 1e-3 * pair[1].energy + 1e-11, "row {}: {stored} J, {work} J", pair[1].row);
        compared += 1;
    }
    assert!(compared > 2000);
}

#[test]
fn a_mirrored_world_gives_mirrored_moments() {
    let (_, _, straight) = reference();
    let mirror = |p: Vec2| Vec2::new(p.x, -p.y);
    let map = moved(&disc_and_wall(), mirror);
    let other: Vec<Pose2> = waypoints().iter().map(|w| Pose2::new(w.x, -w.y, -w.theta)).collect();
    let mirrored = sweep(&map, &path_through(&other, &PACE).unwrap());
    for (a, b) in straight.exact_moments.iter().zip(&mirrored.exact_moments) {
        assert!((a[0] + b[0]).abs() < 1e-11, "{} and {}", a[0], b[0]);
    }
}

#[test]
fn moving_world_and_robot_together_changes_nothing() {
    let (_, path, still) = reference();
    let mut random = Random(7);
    for _ in 0..4 {
        let motion = Pose2::new(random.signed(3.0), random.signed(3.0), random.signed(3.1));
        let map = moved(&disc_and_wall(), |p| motion.transform_point(p));
        let carried: Vec<StampedPose> =
            path.iter().map(|p| StampedPose { map_from_robot: motion.compose(p.map_from_robot), ..*p }).collect();
        let there = sweep(&map, &carried);
        for (a, b) in still.exact_moments.iter().zip(&there.exact_moments) {
            assert!((a[0] - b[0]).abs() < 1e-10, "{} and {}", a[0], b[0]);
        }
    }
}

#[test]
fn the_answer_does_not_depend_on_the_rows() {
    let (map, _, coarse) = reference();
    let fine = sweep(&map, &path_through(&waypoints(), &Pace { rate: 1500.0, ..PACE }).unwrap());
    for (row, moments) in coarse.exact_moments.iter().enumerate() {
        let same = fine.exact_moments[5 * row][0];
        assert!((moments[0] - same).abs() < 1e-11, "row {row}: {} and {same}", moments[0]);
    }
}

#[test]
fn random_discs_are_followed_or_refused_with_a_place() {
    let mut random = Random(11);
    let (mut followed, mut refused) = (0, 0);
    for _ in 0..60 {
        let disc = Curve::circle(Vec2::new(random.signed(0.02), 0.1), 0.02 + 0.03 * random.unit());
        let map = Map::new(vec![boundary(Role::Obstacle, disc)]).unwrap();
        let heading = 1.57 + random.signed(1.2);
        let y = -0.03 + 0.06 * random.unit();
        let ends = [Pose2::new(-0.15, y, heading), Pose2::new(0.15, y, heading + random.signed(0.4))];
        let path = path_through(&ends, &PACE).unwrap();
        match simulate_tip_sweep(&map, &Robot::default(), &path, &SweepNoise::none()) {
            Ok(sweep) => {
                followed += 1;
                for touch in &sweep.contacts {
                    // The discrete rod keeps its distance, and sees the disc as a polygon.
                    assert!(map.nearest(touch.position).unwrap().distance < 2e-6);
                }
                assert!(sweep.exact_moments.iter().all(|m| m[0].is_finite()));
            }
            Err(error) => {
                refused += 1;
                let text = error.to_string();
                assert!(text.contains("near (") && text.contains("another path"), "{text}");
            }
        }
    }
    println!("{followed} followed, {refused} refused");
    assert!(followed > 20, "{followed} followed, {refused} refused");
}
