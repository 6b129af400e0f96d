//! How long a simulated row takes. The baseline is the discrete rod, in the same run.
//!
//! `cargo bench -p vibrissa-time --bench simulate`; throughput is rows a second.

#![allow(missing_docs, clippy::unwrap_used, reason = "the macros of the harness make functions")]

use core::f64::consts::TAU;
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use std::hint::black_box;
use vibrissa::flow::pose::StampedPose;
use vibrissa::plane::{Curve, Pose2, Vec2};
use vibrissa::sim::{Pace, SimulateOptions, Solver, SweepNoise, path_through, simulate};
use vibrissa::world::{Boundary, Map, MountedWhisker, Robot, Role};

/// A wavy wall of so many edges of about a millimetre, above the x axis, within an arena; the same near the path whatever
/// the number.
fn wavy(edges: usize) -> Map {
    let half = 0.0005 * edges as f64;
    let wave = |i: usize| {
        let x = -half + 0.001 * i as f64;
        Vec2::new(x, 0.07 + 0.002 * (x * TAU / 0.1).sin())
    };
    let points: Vec<Vec2> = (0..=edges).map(wave).collect();
    wall(&points)
}

fn wall(points: &[Vec2]) -> Map {
    let curve = Curve::polyline(points, false).unwrap();
    Map::new(vec![Boundary::new(Role::Wall, curve, None).unwrap()]).unwrap()
}

/// The wavy wall and a post, which the whisker touches with its side.
fn post(edges: usize, radius: f64) -> Map {
    let mut boundaries = wavy(edges).boundaries().to_vec();
    let points: Vec<Vec2> = (0..6).map(|i| Vec2::new(0.0, 0.04) + Vec2::from_angle(i as f64) * radius).collect();
    boundaries.push(Boundary::new(Role::Obstacle, Curve::polyline(&points, true).unwrap(), None).unwrap());
    Map::new(boundaries).unwrap()
}

fn path(ends: [[f64; 3]; 2]) -> Vec<StampedPose> {
    let poses = ends.map(|[x, y, theta]| Pose2::new(x, y, theta));
    path_through(&poses, &Pace { speed: 0.15, turn_rate: 1.0, rate: 300.0 }).unwrap()
}

fn whiskers(count: usize, friction: f64) -> Robot {
    let one = |i: usize| MountedWhisker { name: format!("w{i}"), friction, ..MountedWhisker::default() };
    Robot { whiskers: (0..count).map(one).collect(), ..Robot::default() }
}

/// The tip drags along the wavy wall.
const TIP: [[f64; 3]; 2] = [[0.0, -0.0032, 1.9], [0.2, 0.012, 1.9]];
/// The side is pushed against the post.
const SIDE: [[f64; 3]; 2] = [[-0.0075, -0.01, 1.5], [0.03, -0.01, 1.5]];

fn rows(c: &mut Criterion) {
    let cases = [
        ("tip", wavy(2000), TIP, 0.0),
        ("side", post(2000, 0.003), SIDE, 0.0),
        ("tip with friction", wavy(2000), TIP, 0.3),
        ("side with friction", post(2000, 0.003), SIDE, 0.3),
        ("two contacts", post(2000, 0.003), [[-0.045, -0.01, 1.3], [0.01, 0.005, 1.1]], 0.0),
    ];
    for (name, map, ends, friction) in cases {
        let (path, robot) = (path(ends), whiskers(1, friction));
        let mut group = c.benchmark_group(name);
        group.throughput(Throughput::Elements(path.len() as u64));
        group.sample_size(10);
        for (label, solver) in [("baseline: discrete rod", Solver::DiscreteRod), ("ours", Solver::Auto)] {
            let options = SimulateOptions { solver, ..SimulateOptions::default() };
            let run = || simulate(&map, &robot, &path, &SweepNoise::none(), &options).unwrap();
            let sweep = run();
            let touching = sweep.exact_moments.iter().filter(|m| m[0].abs() > 0.0).count();
            let kinds: Vec<_> = sweep.events.iter().map(|event| event.kind).collect();
            println!(
                "{name}, {label}: {touching} of {} rows in contact, {} contacts; {kinds:?}",
                path.len(),
                sweep.contacts.len()
            );
            group.bench_function(label, |b| b.iter(|| black_box(run())));
        }
        group.finish();
    }
}

fn growth(c: &mut Criterion) {
    let options = SimulateOptions::default();
    let mut group = c.benchmark_group("tip by edges of the map");
    group.sample_size(10);
    let path = path(TIP);
    group.throughput(Throughput::Elements(path.len() as u64));
    for edges in [2_000, 20_000, 200_000, 1_000_000] {
        let map = wavy(edges);
        group.bench_with_input(BenchmarkId::from_parameter(edges), &map, |b, map| {
            b.iter(|| black_box(simulate(map, &whiskers(1, 0.0), &path, &SweepNoise::none(), &options).unwrap()));
        });
    }
    group.finish();
    let mut group = c.benchmark_group("tip by whiskers");
    group.sample_size(10);
    let map = wavy(2000);
    for count in [1, 2, 4, 8] {
        group.throughput(Throughput::Elements((count * path.len()) as u64));
        group.bench_with_input(BenchmarkId::from_parameter(count), &whiskers(count, 0.0), |b, robot| {
            b.iter(|| black_box(simulate(&map, robot, &path, &SweepNoise::none(), &options).unwrap()));
        });
    }
    group.finish();
}

criterion_group!(benches, rows, growth);
criterion_main!(benches);
