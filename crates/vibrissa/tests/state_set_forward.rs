//! The forward model of the probabilistic method against an independent discrete rod and against differences of itself.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on must fail")]

#[path = "data/shared.rs"]
mod shared;

use shared::shared;
use std::fs;
use vibrissa::beam::{TipModel, Whisker};
use vibrissa::flow::state_set::probabilistic::predicted_moments;
use vibrissa::io::read_tum;
use vibrissa::plane::{Pose2, Vec2};
use vibrissa::sim::{SimulateOptions, Solver, SweepNoise, simulate, simulate_tip_sweep};
use vibrissa::tasks::demo;
use vibrissa::world::Robot;

const SWEEPS: [&str; 12] = [
    "bays-00",
    "bays-01",
    "bays-02",
    "obstacle-00",
    "obstacle-01",
    "obstacle-02",
    "rough0-01",
    "rough0-02",
    "rough0-03",
    "square-00",
    "square-01",
    "square-02",
];

#[test]
fn moments_agree_with_a_discrete_rod() {
    let Some(folder) = shared("sweeps") else { return };
    for name in SWEEPS {
        let map = vibrissa::read_map(folder.join(format!("{}.geojson", name.split('-').next().unwrap()))).unwrap();
        let truth = read_tum(folder.join(format!("{name}.truth.tum"))).unwrap();
        let path: Vec<Pose2> = truth.iter().map(|p| p.map_from_robot).collect();
        let begin = std::time::Instant::now();
        let ours = predicted_moments(&map, &TipModel::new(&Whisker::default()).unwrap(), &path);
        let per_row = begin.elapsed().as_secs_f64() / path.len() as f64;
        let text = fs::read_to_string(folder.join(format!("{name}.exact.csv"))).unwrap();
        let rod: Vec<f64> = text.lines().skip(1).map(|l| l.split(',').nth(1).unwrap().parse().unwrap()).collect();
        assert_eq!(rod.len(), ours.len());
        let odd = rod.iter().zip(&ours).filter(|(r, o)| (*r - o.moment).abs() > 3e-6_f64.max(2e-3 * r.abs())).count();
        println!("{name}: {odd} odd rows of {}, {:.2} us a row", rod.len(), 1e6 * per_row);
        assert!(odd <= 4, "{name}: {odd} rows differ");
    }
}

/// The same where no folder with other sweeps is: our own discrete rod, which knows nothing of the elastica, on the demo's path.
#[test]
fn moments_agree_with_our_own_discrete_rod() {
    let (map, path) = (demo::arena().unwrap(), demo::path().unwrap());
    let path: Vec<_> = path.into_iter().step_by(2).collect();
    let options = SimulateOptions { solver: Solver::DiscreteRod, ..SimulateOptions::default() };
    let rod = simulate(&map, &Robot::default(), &path, &SweepNoise::none(), &options).unwrap().exact_moments;
    let path: Vec<Pose2> = path.iter().map(|p| p.map_from_robot).collect();
    let ours = predicted_moments(&map, &TipModel::new(&Whisker::default()).unwrap(), &path);
    let touching = rod.iter().filter(|r| r[0].abs() > 1e-4).count();
    let odd = rod.iter().zip(&ours).filter(|(r, o)| (r[0] - o.moment).abs() > 3e-6_f64.max(2e-3 * r[0].abs())).count();
    println!("{odd} odd rows of {}, {touching} in contact", rod.len());
    assert!(touching > 100 && odd <= 4, "{odd} of {touching} rows differ");
}

#[test]
fn derivatives_are_those_of_the_simulator() {
    // On the demo's smooth walls, against differences of the other implementation's moments.
    let (map, path) = (demo::arena().unwrap(), demo::path().unwrap());
    let robot = Robot::default();
    let moved = |dx: f64, dy: f64, turn: f64| {
        let center = path[200].map_from_robot.position();
        let shift = |p: &vibrissa::flow::pose::StampedPose| {
            let arm = (p.map_from_robot.position() - center).rotated(turn);
            let place = center + arm + Vec2::new(dx, dy);
            let map_from_robot = Pose2::new(place.x, place.y, p.map_from_robot.theta + turn);
            vibrissa::flow::pose::StampedPose { t: p.t, map_from_robot }
        };
        let path: Vec<_> = path.iter().map(shift).collect();
        simulate_tip_sweep(&map, &robot, &path, &SweepNoise::none()).unwrap().exact_moments
    };
    let poses: Vec<Pose2> = path.iter().map(|p| p.map_from_robot).collect();
    let ours = predicted_moments(&map, &TipModel::new(&robot.whiskers[0].beam).unwrap(), &poses);
    let exact = moved(0.0, 0.0, 0.0);
    let h = 2e-6;
    let steps = [(h, 0.0, 0.0), (0.0, h, 0.0), (0.0, 0.0, 10.0 * h)];
    let center = path[200].map_from_robot.position();
    for (axis, (dx, dy, turn)) in steps.into_iter().enumerate() {
        let (more, less) = (moved(dx, dy, turn), moved(-dx, -dy, -turn));
        let size = dx + dy + turn;
        let mut worst: Vec<f64> = Vec::new();
        for (row, felt) in ours.iter().enumerate() {
            assert!((felt.moment - exact[row][0]).abs() < 1e-9 + 1e-7 * exact[row][0].abs(), "row {row}");
            if !felt.touching {
                continue;
            }
            let difference = (more[row][0] - less[row][0]) / (2.0 * size);
            let arm = (poses[row].position() - center).perp();
            let g = felt.gradient;
            let own = if axis < 2 { g[axis] } else { g[2] + g[0] * arm.x + g[1] * arm.y };
            let scale = if axis < 2 { 0.2 } else { 0.02 };
            worst.push((own - difference).abs() / (scale + difference.abs()));
        }
        worst.sort_by(f64::total_cmp);
        println!("axis {axis}: {:?} of {}", &worst[worst.len() - 5..], worst.len());
        // A handful of rows see the tip change from piece to piece.
        assert!(worst[worst.len() * 95 / 100] < 1e-3, "{:?}", &worst[worst.len() - 30..]);
    }
}
