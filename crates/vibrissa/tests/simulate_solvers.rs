//! The two solvers against each other, and each against its own laws.
//!
//! The elastica with one contact and the discrete rod share no formula. Their moments differ by the rod's discretisation,
//! which falls with the square of the number of links, and at single rows by a snap that one sees a row earlier.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on must fail")]

#[path = "data/random.rs"]
mod random;

use core::f64::consts::TAU;
use random::Random;
use vibrissa::beam::Whisker;
use vibrissa::flow::pose::StampedPose;
use vibrissa::plane::{Curve, Pose2, Vec2};
use vibrissa::sim::{Pace, Part, SimulateOptions, Solver, Sweep, SweepNoise, path_through, simulate};
use vibrissa::world::{Boundary, Map, MountedWhisker, Robot, Role};

fn map(role: Role, curve: Option<Curve>) -> Map {
    Map::new(vec![Boundary::new(role, curve.unwrap(), None).unwrap()]).unwrap()
}

fn polyline(points: &[Vec2], closed: bool) -> Option<Curve> {
    Curve::polyline(points, closed)
}

fn polygon(center: Vec2, radius: f64, corners: usize, turn: f64) -> Option<Curve> {
    let corner = |i: usize| center + Vec2::from_angle(turn + i as f64 * TAU / corners as f64) * radius;
    polyline(&(0..corners).map(corner).collect::<Vec<_>>(), true)
}

fn path(waypoints: &[[f64; 3]], rate: f64) -> Vec<StampedPose> {
    let poses: Vec<Pose2> = waypoints.iter().map(|w| Pose2::new(w[0], w[1], w[2])).collect();
    path_through(&poses, &Pace { speed: 0.15, turn_rate: 1.0, rate }).unwrap()
}

fn run(map: &Map, beam: Whisker, path: &[StampedPose], solver: Solver, links: usize) -> Sweep {
    let robot = Robot { whiskers: vec![MountedWhisker { beam, ..MountedWhisker::default() }], ..Robot::default() };
    let options = SimulateOptions { solver, links, shape_points: 0 };
    simulate(map, &robot, path, &SweepNoise::none(), &options).unwrap()
}

/// A map of one thing beside the path, and whether it is round.
fn random_map(random: &mut Random, kind: usize) -> (Map, bool) {
    let center = Vec2::new(random.signed(0.02), random.between(0.03, 0.08));
    let way = |random: &mut Random| Vec2::from_angle(random.signed(3.0)) * 0.03;
    match kind {
        0 => (map(Role::Obstacle, Curve::circle(center, random.between(0.005, 0.035))), true),
        1 => {
            let (corners, turn) = (random.between(3.0, 8.0) as usize, random.signed(3.0));
            (map(Role::Obstacle, polygon(center, random.between(0.005, 0.025), corners, turn)), false)
        }
        2 => {
            let d = way(random);
            (map(Role::Wall, polyline(&[center - d, center + d], false)), false)
        }
        _ => {
            let (d, e) = (way(random), way(random));
            (map(Role::Wall, polyline(&[center - d, center, center + e], false)), false)
        }
    }
}

#[test]
fn both_solvers_tell_the_same_story() {
    let mut random = Random(5);
    let (mut tips, mut sides, mut compared, mut odd) = (0, 0, 0, 0);
    for round in 0..72 {
        let (map, round_thing) = random_map(&mut random, round % 4);
        let (heading, y) = (1.57 + random.signed(1.2), random.between(-0.03, 0.0));
        let ends = [[-0.12, y, heading], [0.12, y + random.signed(0.01), heading + random.signed(0.4)]];
        let path = path(&ends, 75.0);
        let ours = run(&map, Whisker::default(), &path, Solver::Auto, 60);
        let rod = run(&map, Whisker::default(), &path, Solver::DiscreteRod, 60);
        let on_chain = ours.events.iter().any(|e| e.kind == "discrete_rod" || e.kind == "lost");
        let tip = |part: Part| ours.contacts.iter().filter(|c| c.part == part).count();
        (tips, sides) = (tips + tip(Part::Tip), sides + tip(Part::Side));
        let mut here = 0;
        for (row, (a, b)) in ours.exact_moments.iter().zip(&rod.exact_moments).enumerate() {
            let (a, b) = (a[0], b[0]);
            // A contact near the base has few links, and a round thing is a polygon to the rod.
            let near = ours.contacts.iter().find(|c| c.row == row).map_or(1.0, |c| 0.075 / c.s_a);
            let share = 4e-4 * near * near + if round_thing { 8e-3 } else { 0.0 };
            here += usize::from((a - b).abs() > 4e-6 + share * b.abs());
            compared += usize::from(b.abs() > 1e-7);
        }
        println!("{round}: {here} odd rows; {:?}", ours.events.iter().map(|e| e.kind).collect::<Vec<_>>());
        assert!(here <= if on_chain { 12 } else { 2 }, "round {round}: {here} odd rows; {:?}", ours.events);
        odd += here;
    }
    println!("{compared} rows, {tips} tips, {sides} sides, {odd} odd");
    assert!(tips > 100 && sides > 900 && odd * 50 < compared, "{tips}, {sides}, {odd} of {compared}");
}

#[test]
fn the_discrete_rod_converges_to_the_elastica() {
    // The tip on a wall, and the side on the corner of a triangle.
    let wall = map(Role::Wall, polyline(&[Vec2::new(-0.3, 0.07), Vec2::new(0.3, 0.08)], false));
    let triangle = map(Role::Obstacle, polygon(Vec2::new(0.0, 0.05), 0.01, 3, 3.2));
    let cases = [(wall, [[0.0, -0.02, 1.9], [0.0, 0.01, 1.9]]), (triangle, [[-0.02, 0.0, 1.5], [0.01, 0.0, 1.5]])];
    for (map, ends) in cases {
        let path = path(&ends, 30.0);
        let moment = |solver, links| {
            let sweep = run(&map, Whisker::default(), &path, solver, links);
            sweep.exact_moments[path.len() - 1][0]
        };
        let exact = moment(Solver::Auto, 20);
        let errors = [20, 40, 80].map(|links| (moment(Solver::DiscreteRod, links) / exact - 1.0).abs());
        println!("{exact}: {errors:?}");
        assert!(exact.abs() > 2e-3 && errors[0] < 3e-3, "{exact}, {errors:?}");
        // Four times better with twice the links, as far as the barrier's reach of 1e-6 lets it.
        assert!(errors[1] < errors[0] / 2.8 + 1e-5 && errors[2] < errors[1] / 2.8 + 1e-5, "{errors:?}");
    }
}

#[test]
fn tapered_curved_and_elastically_held_whiskers_agree() {
    let beams = [
        Whisker { tip_ratio: 0.3, ..Whisker::default() },
        Whisker { curvature: 6.0, ..Whisker::default() },
        Whisker { curvature: -8.0, tip_ratio: 0.5, ..Whisker::default() },
        Whisker { base_stiffness: 0.01, ..Whisker::default() },
    ];
    let wall = map(Role::Wall, polyline(&[Vec2::new(-0.3, 0.07), Vec2::new(0.3, 0.08)], false));
    let post = map(Role::Obstacle, polygon(Vec2::new(0.0, 0.045), 0.008, 4, 0.2));
    let mut touched = 0;
    for beam in beams {
        for (map, ends) in
            [(&wall, [[0.0, -0.02, 1.9], [0.03, 0.012, 1.9]]), (&post, [[-0.06, 0.0, 1.5], [0.02, 0.0, 1.5]])]
        {
            let path = path(&ends, 40.0);
            let ours = run(map, beam, &path, Solver::Auto, 90);
            let rod = run(map, beam, &path, Solver::DiscreteRod, 90);
            let strongest = ours.exact_moments.iter().map(|m| m[0].abs()).fold(0.0, f64::max);
            let worst = ours.exact_moments.iter().zip(&rod.exact_moments).map(|(a, b)| (a[0] - b[0]).abs());
            let worst = worst.fold(0.0, f64::max);
            println!(
                "{beam:?}: {worst:.1e} of {strongest:.1e}; {:?}",
                ours.events.iter().map(|e| e.kind).collect::<Vec<_>>()
            );
            assert!(worst < 1e-3 * strongest + 1e-6, "{beam:?}: {worst} of {strongest}; {:?}", ours.events);
            touched += usize::from(strongest > 4e-4);
        }
    }
    assert!(touched >= 6, "{touched}");
}

/// The energy that the base has put in, from the reactions of the contacts: what holds whatever touches where.
fn work_at_base(sweep: &Sweep, path: &[StampedPose], row: usize) -> f64 {
    let wrench = |row: usize| {
        let force = sweep.contacts.iter().filter(|c| c.row == row).fold(Vec2::ZERO, |sum, c| sum + c.force);
        (force, sweep.exact_moments[row][0])
    };
    let ((f, m), (g, n)) = (wrench(row - 1), wrench(row));
    let (a, b) = (path[row - 1].map_from_robot, path[row].map_from_robot);
    -0.5 * ((f + g).dot(b.position() - a.position()) + (m + n) * (b.theta - a.theta))
}

#[test]
fn forces_balance_and_energy_is_the_work_of_the_base() {
    let post = map(Role::Obstacle, polygon(Vec2::new(0.0, 0.045), 0.008, 6, 0.2));
    let disc = map(Role::Obstacle, Curve::circle(Vec2::new(0.0, 0.06), 0.02));
    for map in [post, disc] {
        let path = path(&[[-0.05, 0.0, 1.5], [0.0, 0.004, 1.45]], 3000.0);
        let sweep = run(&map, Whisker::default(), &path, Solver::Auto, 60);
        let sides = sweep.contacts.iter().filter(|c| c.part == Part::Side).count();
        assert!(sides > 200, "{sides}");
        let energy = |row: usize| sweep.contacts.iter().find(|c| c.row == row).map_or(0.0, |c| c.energy);
        let mut work = 0.0;
        for row in 1..path.len() {
            work += work_at_base(&sweep, &path, row);
            assert!((energy(row) - work).abs() < 1e-3 * work + 1e-8, "row {row}: {} J, {work} J", energy(row));
        }
        for touch in &sweep.contacts {
            let arm = touch.position - path[touch.row].map_from_robot.position();
            assert!((arm.cross(touch.force) - sweep.exact_moments[touch.row][0]).abs() < 1e-11);
            assert!((touch.normal.norm() - 1.0).abs() < 1e-12 && touch.s_a <= 0.075 && touch.s_a > 0.0);
            assert!(touch.force.cross(touch.normal).abs() <= 1e-9 * touch.force.norm(), "{touch:?}");
            assert!(map.nearest(touch.position).unwrap().distance < 1e-10);
        }
    }
}

#[test]
fn two_contacts_balance_and_converge() {
    // The whisker leans on a post while its tip runs along a wall.
    let post = Boundary::new(Role::Obstacle, polygon(Vec2::new(0.0, 0.04), 0.003, 6, 0.0).unwrap(), None).unwrap();
    let wall = polyline(&[Vec2::new(-0.3, 0.07), Vec2::new(0.3, 0.07)], false).unwrap();
    let map = Map::new(vec![post, Boundary::new(Role::Wall, wall, None).unwrap()]).unwrap();
    let path = path(&[[-0.045, -0.01, 1.3], [0.01, 0.005, 1.1]], 75.0);
    let sweeps = [60, 120].map(|links| run(&map, Whisker::default(), &path, Solver::Auto, links));
    let [coarse, fine] = &sweeps;
    assert!(fine.events.iter().any(|e| e.kind == "discrete_rod" && e.detail.contains(" and (")), "{:?}", fine.events);
    let both: Vec<usize> =
        (0..path.len()).filter(|&row| fine.contacts.iter().filter(|c| c.row == row).count() == 2).collect();
    assert!(both.len() > 10, "{} rows", both.len());
    for &row in &both {
        let base = path[row].map_from_robot.position();
        let here = fine.contacts.iter().filter(|c| c.row == row);
        let about: f64 = here.map(|c| (c.position - base).cross(c.force)).sum();
        let (moment, other) = (fine.exact_moments[row][0], coarse.exact_moments[row][0]);
        assert!((about - moment).abs() < 1e-4 * moment.abs() + 1e-7, "row {row}: {about}, {moment}");
        assert!((moment - other).abs() < 3e-3 * moment.abs() + 2e-6, "row {row}: {moment}, {other}");
    }
}

/// Moments along a way past a post and a wall, seen in a world that is moved or mirrored.
fn moments(place: impl Fn(Vec2) -> Vec2, pose: impl Fn(Pose2) -> Pose2, beam: Whisker, rate: f64) -> Vec<f64> {
    let corner = |i: usize| place(Vec2::new(0.0, 0.045) + Vec2::from_angle(0.2 + i as f64 * TAU / 6.0) * 0.008);
    let post = polyline(&(0..6).map(corner).collect::<Vec<_>>(), true);
    let wall = polyline(&[Vec2::new(0.06, 0.03), Vec2::new(0.12, 0.06)].map(place), false);
    let boundary = |role, curve: Option<Curve>| Boundary::new(role, curve.unwrap(), None).unwrap();
    let map = Map::new(vec![boundary(Role::Obstacle, post), boundary(Role::Wall, wall)]).unwrap();
    let path: Vec<StampedPose> = path(&[[-0.06, 0.0, 1.5], [0.08, 0.0, 1.3]], rate)
        .into_iter()
        .map(|p| StampedPose { map_from_robot: pose(p.map_from_robot), ..p })
        .collect();
    run(&map, beam, &path, Solver::Auto, 40).exact_moments.concat()
}

#[test]
fn side_contact_does_not_care_where_it_is_seen_from() {
    for beam in [Whisker::default(), Whisker { tip_ratio: 0.5, base_stiffness: 0.05, ..Whisker::default() }] {
        let here = moments(|p| p, |p| p, beam, 150.0);
        let touching = here.iter().filter(|m| m.abs() > 1e-4).count();
        assert!(touching > 40, "{touching}");
        let unit = here.iter().fold(0.0_f64, |a, m| a.max(m.abs()));
        let mut random = Random(9);
        for _ in 0..3 {
            let motion = Pose2::new(random.signed(2.0), random.signed(2.0), random.signed(3.1));
            let there = moments(|p| motion.transform_point(p), |p| motion.compose(p), beam, 150.0);
            let off = here.iter().zip(&there).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(off < 1e-7 * unit, "moved: {off}");
        }
        let mirror = |p: Vec2| Vec2::new(p.x, -p.y);
        let mirrored = moments(mirror, |p| Pose2::new(p.x, -p.y, -p.theta), beam, 150.0);
        let off = here.iter().zip(&mirrored).map(|(a, b)| (a + b).abs()).fold(0.0, f64::max);
        // The discrete rod leans a millionth of a radian to the left, so that it knows where to buckle.
        assert!(off < 1e-5 * unit, "mirrored: {off}");
        // Five times as many rows: the same where both are. The discrete rod may hand back a few rows earlier.
        let fine = moments(|p| p, |p| p, beam, 750.0);
        let off: Vec<f64> = here.iter().enumerate().map(|(row, m)| (m - fine[5 * row]).abs() / unit).collect();
        let by_chain = off.iter().filter(|off| **off > 1e-7).count();
        assert!(by_chain < 10 && off.iter().all(|off| *off < 5e-3), "finer rows: {by_chain}, {off:?}");
    }
}

/// A whisker that lies along a wall with its flank when its tip comes to the next one, and is drawn out of that corner and
/// over another: where it bends the discrete rod begins within a micrometre of the wall, on the right side of it.
#[test]
fn a_rod_begins_on_the_right_side_of_the_walls() {
    let outline = [
        [0.0, 0.0],
        [-0.111266, 0.076896],
        [-0.242487, 0.167584],
        [-0.392003, -0.048759],
        [-0.343520, -0.082266],
        [-0.373012, -0.124940],
        [-0.179008, -0.259017],
    ];
    let map = map(Role::Arena, polyline(&outline.map(|[x, y]| Vec2::new(x, y)), true));
    let mut whisker =
        MountedWhisker { robot_from_whisker: Pose2::new(0.013758, 0.004534, 0.292647), ..Default::default() };
    whisker.beam =
        Whisker { length: 0.068644, flexural_rigidity: 8.7945e-4, base_stiffness: 0.2327, ..Whisker::default() };
    let robot = Robot { whiskers: vec![whisker], ..Robot::default() };
    let way = [
        [-0.115123, -0.106757, -2.276999],
        [-0.198188, -0.204143, -2.276999],
        [-0.198188, -0.204143, 3.071982],
        [-0.206169, -0.203587, 3.071982],
        [-0.206169, -0.203587, 2.539086],
        [-0.328109, -0.119714, 2.539086],
        [-0.328109, -0.119714, 1.203599],
        [-0.303895, -0.056762, 1.203599],
    ];
    let poses: Vec<Pose2> = way.iter().map(|w| Pose2::new(w[0], w[1], w[2])).collect();
    let path = path_through(&poses, &Pace { speed: 0.2, turn_rate: 1.5, rate: 203.46 }).unwrap();
    let options = SimulateOptions { shape_points: 91, ..SimulateOptions::default() };
    let sweep = simulate(&map, &robot, &path, &SweepNoise::none(), &options).unwrap();
    assert!(sweep.events.iter().any(|event| event.kind == "discrete_rod"), "{:?}", sweep.events);
    let bad = sweep.events.iter().find(|event| matches!(event.kind, "unsolved" | "lost"));
    assert!(bad.is_none(), "{bad:?}");
    for shape in &sweep.shapes {
        let length: f64 = shape.points.windows(2).map(|link| link[0].distance(link[1])).sum();
        assert!((length / 0.068644 - 1.0).abs() < 1e-3, "row {}: {length} m long", shape.row);
        let inside = |p: Vec2| map.is_free(p) || map.nearest(p).is_some_and(|near| near.distance < 2e-6);
        assert!(shape.points.iter().all(|&p| inside(p)), "row {}: a part of the whisker is in a wall", shape.row);
    }
}

/// A whisker with its tip in a corner is pushed until it buckles, by rows of some millimetres: it buckles to the side to which it is bent, as by short rows.
#[test]
fn a_whisker_in_a_corner_buckles_to_the_side_to_which_it_is_bent() {
    let mut random = Random(0x0b0c_71e5);
    let length = 0.08;
    let beam = Whisker { length, flexural_rigidity: 3e-4, ..Whisker::default() };
    let scale = beam.flexural_rigidity / length;
    let room = [(-0.5, -0.5), (0.0, 0.0), (-0.5, 0.5)].map(|(x, y)| Vec2::new(x, y));
    let map = map(Role::Arena, polyline(&room, true));
    let mut strong = 0;
    for case in 0..80 {
        // The tip slides along a wall into the corner, and the base turns until the whisker is nearly straight again.
        let (side, over) = (random.sign(), random.between(1e-4, 4e-3));
        let base = Vec2::from_angle(random.signed(0.5)) * (over - length);
        let into = (-base).angle();
        let turns = [0.5, random.between(-0.1, 0.3)].map(|off| into + side * off);
        let ahead = Vec2::from_angle(into + random.signed(0.6)) * random.between(3e-3, 3.99e-3);
        let pose = |p: Vec2, theta: f64| Pose2::new(p.x, p.y, theta);
        let [away, there, turned, pressed] = [
            pose(base - Vec2::from_angle(turns[0]) * 0.06, turns[0]),
            pose(base, turns[0]),
            pose(base, turns[1]),
            pose(base + ahead, turns[1]),
        ];
        let path = |presses: usize| {
            let legs = [(away, there, 40), (there, turned, 20), (turned, pressed, presses)];
            let between = |(from, to, rows): (Pose2, Pose2, usize)| {
                (1..=rows).map(move |k| {
                    let share = k as f64 / rows as f64;
                    let place = from.position() + (to.position() - from.position()) * share;
                    Pose2::new(place.x, place.y, from.theta + share * (to.theta - from.theta))
                })
            };
            let poses = core::iter::once(away).chain(legs.into_iter().flat_map(between));
            poses.enumerate().map(|(k, map_from_robot)| StampedPose { t: k as f64, map_from_robot }).collect::<Vec<_>>()
        };
        let (fine, coarse) = (path(60), path(1));
        let run = |path| run(&map, beam, path, Solver::Auto, 90);
        let other = run(&coarse);
        // Two contacts at once are the discrete rod's.
        if other.events.iter().any(|event| event.kind == "discrete_rod") {
            continue;
        }
        let one = run(&fine);
        let end = |sweep: &Sweep| sweep.exact_moments.last().unwrap()[0] / scale;
        let (one, other) = (end(&one), end(&other));
        assert!((one - other).abs() < 1e-6, "case {case}: {one} by short rows, {other} by long ones");
        if one.abs() > 1.0 {
            strong += 1
        }
    }
    println!("{strong} of 80 cases are pressed hard");
    assert!(strong >= 20);
}
