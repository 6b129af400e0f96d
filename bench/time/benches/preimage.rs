//! How long contact sets, their intersections and preimages take, beside general polygon operations in the same run.
//!
//! `cargo bench -p vibrissa-time --bench preimage`. The baseline for intersections is every pair of links (what a plain `polyxpoly`
//! does); `bench/run` sets Shapely beside it.

#![allow(missing_docs, clippy::unwrap_used, reason = "the macros of the harness make functions")]

use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use vibrissa::beam::{Load, Whisker};
use vibrissa::flow::contact_set::{
    ContactModel, ContactRegion, ContactSet, MomentRegime, Parts, PlacedSet, Reading, Resolution, VirtualSensor,
    intersect,
};
use vibrissa::flow::preimage::{Construction, PreimageOptions, reading_preimage};
use vibrissa::plane::{Curve, Pose2, Vec2, segment_contact};
use vibrissa::sets::Interval;
use vibrissa::tasks::demo;
use vibrissa::world::{Boundary, Map, Role};

fn paper() -> ContactModel {
    ContactModel::new(&Whisker::default(), Load::Normal).unwrap()
}

fn contact_sets(c: &mut Criterion) {
    let model = paper();
    let mut group = c.benchmark_group("contact set of 200 points a branch");
    // A moment may have two branches.
    let points = |model: &ContactModel, sensor: VirtualSensor, value: f64| -> usize {
        let set = ContactSet::new(model, sensor, value, 200).unwrap();
        set.curves.iter().map(|curve| curve.contacts().len()).sum()
    };
    for (sensor, value) in [
        (VirtualSensor::Load, 0.1),
        (VirtualSensor::Strip, 0.06),
        (VirtualSensor::Slope, 0.9),
        (VirtualSensor::Moment(MomentRegime::LargeAngle), 17e-3),
    ] {
        let count = points(&model, sensor, value);
        group.bench_function(format!("{}, uniform: {count} points", sensor.word()), |b| {
            b.iter(|| ContactSet::new(&model, sensor, black_box(value), 200).unwrap());
        });
    }
    let plain = Whisker::default();
    for (name, whisker) in [
        ("tapered", Whisker { tip_ratio: 0.5, ..plain }),
        ("curved", Whisker { curvature: 6.0, ..plain }),
        ("elastic base", Whisker { base_stiffness: 0.1, ..plain }),
    ] {
        let model = || ContactModel::new(&whisker, Load::Normal).unwrap();
        let other = model();
        for (sensor, value) in [
            (VirtualSensor::Load, 0.1),
            (VirtualSensor::Strip, 0.06),
            (VirtualSensor::Slope, 0.9),
            (VirtualSensor::Moment(MomentRegime::LargeAngle), 4e-3),
        ] {
            let count = points(&other, sensor, value);
            group.bench_function(format!("{}, {name}: {count} points", sensor.word()), |b| {
                b.iter(|| ContactSet::new(&other, sensor, black_box(value), 200).unwrap());
            });
        }
        group.sample_size(10).bench_function(format!("the first one, {name}"), |b| {
            b.iter(|| ContactSet::new(&model(), VirtualSensor::Slope, black_box(0.9), 200).unwrap());
        });
        group.sample_size(100);
    }
    group.sample_size(10);
    group.bench_function("region of a load of 5 %", |b| {
        let reading = Reading { sensor: VirtualSensor::Load, value: Interval::new(0.095, 0.105) };
        b.iter(|| ContactRegion::new(&model, &[black_box(reading)], &Resolution::default()).unwrap());
    });
    group.finish();
}

fn intersections(c: &mut Criterion) {
    let model = paper();
    let load = ContactSet::new(&model, VirtualSensor::Load, 0.1, 200).unwrap();
    let strip = ContactSet::new(&model, VirtualSensor::Strip, 0.06, 200).unwrap();
    let mut group = c.benchmark_group("intersection of two curves of 200 points");
    group.bench_function("ours, refined to the smooth crossing", |b| {
        b.iter(|| intersect(PlacedSet::at_home(black_box(&load)), PlacedSet::at_home(&strip), 1e-9));
    });
    let (p, q) = (load.curves[0].points(), strip.curves[0].points());
    group.bench_function("baseline: every pair of links, chords only", |b| {
        b.iter(|| {
            let mut found: Vec<Vec2> = Vec::new();
            for u in black_box(&p).windows(2) {
                found.extend(q.windows(2).filter_map(|v| segment_contact(u[0], u[1], v[0], v[1])));
            }
            found
        });
    });
    group.finish();
}

/// A boundary of two metres: a room of 0.5 m with straight walls.
fn two_metres() -> Map {
    let corners = [(0.0, 0.0), (0.5, 0.0), (0.5, 0.5), (0.0, 0.5)].map(|(x, y)| Vec2::new(x, y));
    let curve = Curve::polyline(&corners, true).unwrap();
    Map::new(vec![Boundary::new(Role::Arena, curve, None).unwrap()]).unwrap()
}

fn preimages(c: &mut Criterion) {
    let (model, room, arena) = (paper(), two_metres(), demo::arena().unwrap());
    let reading = Reading::exact(VirtualSensor::Load, 0.1);
    let mut group = c.benchmark_group("preimage at 1 mm and 1 degree");
    group.sample_size(10);
    let solve = |map: &Map, options: &PreimageOptions| {
        reading_preimage(map, &model, Pose2::IDENTITY, &[black_box(reading)], options).unwrap()
    };
    let tips = PreimageOptions::default();
    let aligned = PreimageOptions { contacts: Parts::Side, ..tips };
    let all = PreimageOptions { collision_free: false, ..aligned };
    let distance = PreimageOptions { construction: Construction::Distance, ..all };
    group.bench_function("2 m boundary, aligned, collision-free", |b| b.iter(|| solve(&room, &aligned)));
    group.bench_function("2 m boundary, aligned, collision-free, tips too", |b| b.iter(|| solve(&room, &tips)));
    group.bench_function("2 m boundary, aligned, collisions ignored", |b| b.iter(|| solve(&room, &all)));
    group.bench_function("2 m boundary, every heading (distance)", |b| b.iter(|| solve(&room, &distance)));
    group.bench_function("the demo arena, aligned, collision-free", |b| b.iter(|| solve(&arena, &aligned)));
    group.finish();
}

criterion_group!(benches, contact_sets, intersections, preimages);
criterion_main!(benches);
