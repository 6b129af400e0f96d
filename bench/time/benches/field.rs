//! How long a look-up in the tip field takes. The baselines, in the same run: the closed form, and a march along the rod.
//!
//! `cargo bench -p vibrissa-time --bench field`

#![allow(missing_docs, clippy::unwrap_used, reason = "the macros of the harness make functions")]

use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use vibrissa_beam::beam::elastica::bend;
use vibrissa_beam::beam::field::{SideField, TipField, TipState};
use vibrissa_beam::beam::{Load, Rod, Whisker, tip_mode};
use vibrissa_beam::plane::Vec2;

/// Loads in turn, so that no answer is remembered.
const N: usize = 1024;

fn states(field: &TipField) -> Vec<TipState> {
    let mut state = 1u64;
    let mut unit = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    let mut draw = || {
        let (tilt, sign) = (0.8 * (2.0 * unit() - 1.0), if unit() < 0.5 { -1.0 } else { 1.0 });
        field.at(tilt, sign * field.largest_force(tilt, sign) * (0.1 + 0.5 * unit())).unwrap()
    };
    (0..N).map(|_| draw()).collect()
}

fn look_ups(c: &mut Criterion) {
    let plain = Whisker::default();
    let tapered = Whisker { tip_ratio: 0.4, curvature: 6.0, base_stiffness: 0.3, ..plain };
    let mut group = c.benchmark_group("field");
    for (name, whisker) in [("uniform", plain), ("tapered, curved, elastic base", tapered)] {
        let (field, rod) = (TipField::new(&whisker).unwrap(), Rod::new(&whisker).unwrap());
        let list = states(&field);
        let loads: Vec<(f64, f64)> = list.iter().map(|s| (s.tilt, s.force)).collect();
        let mut i = 0;
        let mut next = || {
            i = (i + 1) % N;
            list[i]
        };
        if whisker.is_uniform() {
            group.bench_function("baseline: closed form, no derivatives", |b| {
                b.iter(|| {
                    let s = next();
                    bend(whisker.flexural_rigidity, s.force, whisker.length, s.tilt)
                });
            });
        }
        group.bench_function(format!("{name}: baseline: rod, no derivatives"), |b| {
            b.iter(|| {
                let s = next();
                rod.force_mode(s.force, whisker.length, Load::Tilted(s.tilt)).unwrap()
            });
        });
        // Looked at where it is written: a caller does not move the answer elsewhere, which takes 6 ns.
        let mut k = 0;
        group.bench_function(format!("{name}: at, with derivatives, all over the field"), |b| {
            b.iter(|| {
                k = (k + 1) % N;
                black_box(&field.at(loads[k].0, loads[k].1));
            });
        });
        // A search asks around one place.
        let near: Vec<(f64, f64)> = (0..N).map(|i| (0.2 + 1e-5 * i as f64, list[0].force.abs())).collect();
        let mut k = 0;
        group.bench_function(format!("{name}: at, with derivatives, around one place"), |b| {
            b.iter(|| {
                k = (k + 1) % N;
                black_box(&field.at(near[k].0, near[k].1));
            });
        });
        group.bench_function(format!("{name}: direction and moment, from a neighbour"), |b| {
            b.iter(|| {
                let s = next();
                field.by_direction_and_moment_from(s.direction() + 0.01, 1.01 * s.moment, &s)
            });
        });
        group.bench_function(format!("{name}: direction and moment, every branch"), |b| {
            b.iter(|| {
                let s = next();
                field.by_direction_and_moment(s.direction(), s.moment)
            });
        });
        group.bench_function(format!("{name}: position, from a neighbour"), |b| {
            b.iter(|| {
                let s = next();
                field.by_position_from(s.position + Vec2::new(1e-5, 1e-5), &s)
            });
        });
        group.bench_function(format!("{name}: position, every branch"), |b| {
            b.iter(|| {
                let s = next();
                field.by_position(s.position)
            });
        });
    }
    group.finish();
}

fn slow(c: &mut Criterion) {
    let plain = Whisker::default();
    let mut group = c.benchmark_group("field, slow");
    group.sample_size(10);
    let tip = Vec2::new(0.06, 0.03);
    group.bench_function("baseline: tip mode, every branch", |b| b.iter(|| tip_mode(&plain, black_box(tip)).unwrap()));
    let whiskers = [
        ("uniform", plain),
        ("tapered to one twentieth", Whisker { tip_ratio: 0.05, ..plain }),
        ("tapered, curved, elastic base", Whisker { tip_ratio: 0.4, curvature: 6.0, base_stiffness: 0.3, ..plain }),
    ];
    for (name, whisker) in whiskers {
        group.bench_function(format!("{name}: build the tip field"), |b| b.iter(|| TipField::new(&whisker).unwrap()));
        group.bench_function(format!("{name}: build the side field"), |b| b.iter(|| SideField::new(&whisker).unwrap()));
        let bytes = TipField::new(&whisker).unwrap().to_bytes();
        group.bench_function(format!("{name}: load"), |b| b.iter(|| TipField::from_bytes(&bytes).unwrap()));
    }
    group.finish();
}

criterion_group!(benches, look_ups, slow);
criterion_main!(benches);
