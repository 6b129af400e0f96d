//! Maps that nobody should draw: every row gets a finite answer in bounded time.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on must fail")]

#[path = "data/random.rs"]
mod random;

use core::f64::consts::FRAC_PI_2 as UP;
use random::Random;
use vibrissa::plane::{Curve, Pose2, Vec2};
use vibrissa::sim::{Pace, SimulateOptions, SweepNoise, path_through, simulate};
use vibrissa::world::{Boundary, Map, MountedWhisker, Robot, Role};

fn wall(points: &[Vec2]) -> Option<Boundary> {
    Boundary::new(Role::Wall, Curve::polyline(points, false)?, None).ok()
}

fn run(map: &Map, ends: [Pose2; 2], friction: f64) -> Option<Vec<&'static str>> {
    let path = path_through(&ends, &Pace { speed: 0.15, turn_rate: 1.0, rate: 40.0 }).unwrap();
    let robot = Robot { whiskers: vec![MountedWhisker { friction, ..MountedWhisker::default() }], ..Robot::default() };
    let options = SimulateOptions { links: 40, shape_points: 5, ..SimulateOptions::default() };
    let sweep = match simulate(map, &robot, &path, &SweepNoise::none(), &options) {
        Ok(sweep) => sweep,
        Err(error) => {
            assert!(error.to_string().contains("does not start in free space"), "{error}");
            return None;
        }
    };
    assert_eq!(sweep.exact_moments.len(), path.len());
    assert_eq!(sweep.shapes.len(), path.len());
    assert!(sweep.exact_moments.iter().all(|m| m[0].is_finite()));
    for touch in &sweep.contacts {
        assert!(touch.force.is_finite() && touch.position.is_finite() && touch.energy.is_finite(), "{touch:?}");
        assert!(map.nearest(touch.position).unwrap().distance < 1e-6, "{touch:?}");
    }
    assert!(sweep.shapes.iter().all(|shape| shape.points.iter().all(|p| p.is_finite())));
    Some(sweep.events.iter().map(|event| event.kind).collect())
}

#[test]
fn tangles_of_walls_are_survived() {
    let mut random = Random(3);
    let (mut ran, mut kinds) = (0, Vec::new());
    for round in 0..60 {
        let mut boundaries = Vec::new();
        for _ in 0..1 + round % 4 {
            let start = Vec2::new(random.signed(0.06), random.between(0.02, 0.1));
            let mut points = vec![start];
            for _ in 0..1 + round % 6 {
                let size = if random.unit() < 0.2 { 1e-7 } else { 0.02 };
                let last = points[points.len() - 1];
                // Now and then straight back along itself.
                let back = points.len() > 1 && random.unit() < 0.2;
                points.push(if back {
                    points[points.len() - 2]
                } else {
                    last + Vec2::new(random.signed(size), random.signed(size))
                });
            }
            boundaries.extend(wall(&points));
        }
        let Ok(map) = Map::new(boundaries) else { continue };
        let heading = 1.57 + random.signed(1.0);
        let ends = [
            Pose2::new(-0.1, random.signed(0.02), heading),
            Pose2::new(0.1, random.signed(0.02), heading + random.signed(0.5)),
        ];
        let friction = if round % 3 == 0 { random.between(0.0, 1.0) } else { 0.0 };
        if let Some(happened) = run(&map, ends, friction) {
            ran += 1;
            kinds.extend(happened);
        }
    }
    kinds.sort_unstable();
    let counts: Vec<_> = kinds.chunk_by(|a, b| a == b).map(|same| (same[0], same.len())).collect();
    println!("{ran} ran; {counts:?}");
    assert!(ran > 40, "{ran}");
}

#[test]
fn spikes_slots_and_head_on_runs_are_survived() {
    let p = |x: f64, y: f64| Vec2::new(x, y);
    let spike = vec![wall(&[p(-0.1, 0.07), p(-1e-6, 0.07), p(0.0, 0.02), p(1e-6, 0.07), p(0.1, 0.07)]).unwrap()];
    // Two walls a hundredth of a millimetre apart.
    let thin =
        vec![wall(&[p(-0.02, 0.05), p(0.02, 0.05)]).unwrap(), wall(&[p(-0.02, 0.05001), p(0.02, 0.05001)]).unwrap()];
    let slot =
        vec![wall(&[p(-0.001, 0.03), p(-0.001, 0.09)]).unwrap(), wall(&[p(0.001, 0.03), p(0.001, 0.09)]).unwrap()];
    let pocket = vec![wall(&[p(-0.02, 0.03), p(-0.02, 0.08), p(0.02, 0.08), p(0.02, 0.03)]).unwrap()];
    for boundaries in [spike, thin, slot, pocket] {
        let map = Map::new(boundaries).unwrap();
        for ends in [
            [Pose2::new(-0.05, 0.0, 1.3), Pose2::new(0.05, 0.0, 1.3)],
            [Pose2::new(0.0, -0.06, UP + 1e-6), Pose2::new(0.0, 0.06, UP + 1e-6)],
            [Pose2::new(0.0, -0.06, UP), Pose2::new(0.0, 0.0, UP)],
            [Pose2::new(0.0, 0.0, -1.5), Pose2::new(0.0, 0.01, 1.5)],
        ] {
            if let Some(happened) = run(&map, ends, 0.0) {
                println!("{happened:?}");
            }
        }
    }
}

#[test]
fn a_whisker_pushed_head_on_buckles_to_one_side() {
    let map = Map::new(vec![wall(&[Vec2::new(-0.3, 0.08), Vec2::new(0.3, 0.08)]).unwrap()]).unwrap();
    let path = path_through(
        &[Pose2::new(0.0, 0.0, UP), Pose2::new(0.0, 0.02, UP)],
        &Pace { speed: 0.15, turn_rate: 1.0, rate: 100.0 },
    )
    .unwrap();
    let sweep = simulate(&map, &Robot::default(), &path, &SweepNoise::none(), &SimulateOptions::default()).unwrap();
    let moment = sweep.exact_moments[path.len() - 1][0];
    println!("{moment}, {:?}", sweep.events);
    assert!(moment.abs() > 1e-3 && moment.abs() < 0.02, "{moment}, {:?}", sweep.events);
}
