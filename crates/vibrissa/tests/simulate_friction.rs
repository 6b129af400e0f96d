//! Coulomb friction: its limits, its cone, and a stuck tip against the mode that only knows where the tip is.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on must fail")]

use core::f64::consts::TAU;
use vibrissa::beam::{Whisker, elastica, tip_mode};
use vibrissa::flow::pose::StampedPose;
use vibrissa::plane::{Curve, Pose2, Vec2};
use vibrissa::sim::{Grip, Pace, Part, SimulateOptions, Sweep, SweepNoise, path_through, simulate};
use vibrissa::world::{Boundary, Map, MountedWhisker, Robot, Role};

fn wall() -> Map {
    let curve = Curve::polyline(&[Vec2::new(-0.3, 0.07), Vec2::new(0.3, 0.07)], false).unwrap();
    Map::new(vec![Boundary::new(Role::Wall, curve, None).unwrap()]).unwrap()
}

fn post() -> Map {
    let corner = |i: usize| Vec2::new(0.0, 0.045) + Vec2::from_angle(0.2 + i as f64 * TAU / 6.0) * 0.008;
    let curve = Curve::polyline(&(0..6).map(corner).collect::<Vec<_>>(), true).unwrap();
    Map::new(vec![Boundary::new(Role::Obstacle, curve, None).unwrap()]).unwrap()
}

fn disc() -> Map {
    let curve = Curve::circle(Vec2::new(0.0, 0.06), 0.02).unwrap();
    Map::new(vec![Boundary::new(Role::Obstacle, curve, None).unwrap()]).unwrap()
}

fn path(waypoints: &[[f64; 3]], rate: f64) -> Vec<StampedPose> {
    let poses: Vec<Pose2> = waypoints.iter().map(|w| Pose2::new(w[0], w[1], w[2])).collect();
    path_through(&poses, &Pace { speed: 0.15, turn_rate: 1.0, rate }).unwrap()
}

fn run(map: &Map, friction: f64, path: &[StampedPose]) -> Sweep {
    let robot = Robot { whiskers: vec![MountedWhisker { friction, ..MountedWhisker::default() }], ..Robot::default() };
    simulate(map, &robot, path, &SweepNoise::none(), &SimulateOptions::default()).unwrap()
}

const ALONG: [[f64; 3]; 3] = [[0.0, -0.01, 1.9], [0.005, 0.01, 1.9], [0.06, 0.01, 1.9]];
const ACROSS: [[f64; 3]; 2] = [[-0.05, 0.0, 1.5], [0.0, 0.004, 1.45]];

#[test]
fn without_friction_nothing_changes() {
    for (map, legs) in [(wall(), &ALONG[..]), (post(), &ACROSS[..]), (disc(), &ACROSS[..])] {
        let path = path(legs, 300.0);
        let none = run(&map, 0.0, &path);
        let mut last = f64::INFINITY;
        for friction in [1e-3, 1e-5, 1e-7] {
            let little = run(&map, friction, &path);
            let off = none.exact_moments.iter().zip(&little.exact_moments).map(|(a, b)| (a[0] - b[0]).abs());
            let off = off.fold(0.0, f64::max);
            println!("{friction}: {off:e} N m");
            assert!(off < 0.05 * friction + 1e-11 && off <= last, "{friction}: {off}");
            last = off;
        }
    }
}

#[test]
fn the_force_stays_in_the_cone_and_opposes_sliding() {
    for (map, legs) in [(wall(), &ALONG[..]), (post(), &ACROSS[..]), (disc(), &ACROSS[..])] {
        let path = path(legs, 300.0);
        for friction in [0.1_f64, 0.3, 0.6] {
            let sweep = run(&map, friction, &path);
            assert!(sweep.contacts.len() > 20, "{} contacts, {:?}", sweep.contacts.len(), sweep.events);
            let (mut sticks, mut slips) = (0, 0);
            for pair in sweep.contacts.windows(2) {
                let (before, now) = (&pair[0], &pair[1]);
                let off = now.normal.cross(now.force).atan2(now.normal.dot(now.force));
                assert!(off.abs() <= friction.atan() + 1e-9, "{friction}: {off} rad, {now:?}");
                let jumped = sweep.events.iter().any(|e| e.t > before.t && e.t <= now.t);
                if now.row != before.row + 1 || now.part != before.part || jumped {
                    continue;
                }
                match now.grip {
                    Grip::Sticks => sticks += 1,
                    Grip::Slips => {
                        slips += 1;
                        assert!((off.abs() - friction.atan()).abs() < 1e-9, "{friction}: {off} rad, {now:?}");
                        // How the whisker's material moves over the ground.
                        let along = now.normal.perp() * now.normal.perp().dot(now.position - before.position);
                        if now.part == Part::Tip && along.norm() > 1e-9 {
                            assert!(along.dot(now.force) <= 0.0, "{friction}: {now:?} after {before:?}");
                        }
                    }
                    Grip::Frictionless => panic!("friction {friction} and yet {now:?}; {:?}", sweep.events),
                }
            }
            println!(
                "{friction}: {sticks} stuck, {slips} slipping; {:?}",
                sweep.events.iter().map(|e| e.kind).collect::<Vec<_>>()
            );
            assert!(sticks + slips > 20);
        }
    }
}

#[test]
fn a_stuck_tip_is_tip_mode() {
    // Aslant to the wall and with friction the tip stays where it first touched.
    // The base goes where the tip can stay under a force that is a tenth of a radian off the whisker's normal.
    let heading = core::f64::consts::FRAC_PI_4;
    let place = Vec2::new(0.0, 0.07);
    let beam = Whisker::default();
    let pose = |t: f64, p: Vec2| {
        let base = place - p.rotated(heading);
        StampedPose { t, map_from_robot: Pose2::new(base.x, base.y, heading) }
    };
    let mut path = vec![pose(0.0, Vec2::new(beam.length - 1e-4, 1e-3))];
    for k in 0..20 {
        let force = -0.004 * f64::from(k);
        let bend = elastica::bend(beam.flexural_rigidity, force, beam.length, 0.1).unwrap();
        path.push(pose(0.01 * f64::from(k + 1), bend.contact));
    }
    let sweep = run(&wall(), 1.5, &path);
    let stuck: Vec<_> = sweep.contacts.iter().filter(|c| c.grip == Grip::Sticks).collect();
    println!("{} contacts, {} stuck; {:?}", sweep.contacts.len(), stuck.len(), sweep.events);
    assert!(stuck.len() > 2, "{:?}", sweep.events);
    let whisker = Whisker::default();
    for touch in stuck.iter().filter(|touch| touch.force.norm() > 1e-3) {
        assert!(touch.position.distance(stuck[0].position) < 1e-9, "it stays");
        let pose = path[touch.row].map_from_robot;
        let bends = tip_mode(&whisker, pose.inverse_transform_point(touch.position)).unwrap();
        let moment = sweep.exact_moments[touch.row][0];
        let near = bends.iter().any(|bend| {
            (bend.moment - moment).abs() < 1e-7 * moment.abs()
                && bend.force_vector().distance(touch.force.rotated(-pose.theta)) < 1e-6 * touch.force.norm()
        });
        assert!(near, "row {}: {moment}, {:?}", touch.row, bends.iter().map(|b| b.moment).collect::<Vec<_>>());
    }
}

#[test]
fn friction_makes_a_wall_and_back_differ() {
    // Dragging to and fro: without friction the same places feel the same, with friction they do not.
    let there_and_back = [[0.0, -0.01, 1.9], [0.005, 0.008, 1.9], [0.045, 0.008, 1.9], [0.005, 0.008, 1.9]];
    let path = path(&there_and_back, 300.0);
    let last = path.len() - 1;
    let loop_gap = |friction: f64| {
        let sweep = run(&wall(), friction, &path);
        (1..60)
            .map(|k| (sweep.exact_moments[last - k][0] - sweep.exact_moments[last - 160 + k][0]).abs())
            .fold(0.0, f64::max)
    };
    let (none, some) = (loop_gap(0.0), loop_gap(0.3));
    println!("{none:e} without, {some:e} with friction");
    assert!(none < 1e-9 && some > 1e-4, "{none:e}, {some:e}");
}
