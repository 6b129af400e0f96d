//! How long a loaded whisker takes. The baseline of every group is the closed form in elliptic functions, in the same run.
//!
//! `cargo bench -p vibrissa-time --bench beam`; `bench/beam/run` sets the usual Python beside it.

#![allow(missing_docs, clippy::unwrap_used, reason = "the macros of the harness make functions")]

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use std::hint::black_box;
use vibrissa::beam::elastica::bend;
use vibrissa::beam::normal::{
    Branch, NormalBend, by_force, by_force_batch, by_moment, by_moment_batch, by_point, by_point_batch,
};
use vibrissa::beam::{Load, Rod, Whisker, force_mode, moment_mode, point_mode};
use vibrissa::plane::Vec2;
use vibrissa::tasks::batch;

const EI: f64 = 2.8886e-4;
const LENGTH: f64 = 0.075;
/// Whiskers in a batch.
const N: usize = 1024;

/// Loads that a predictor of branches or a cache cannot learn: slopes up to 130 degrees.
struct Loads {
    force: Vec<f64>,
    s_a: Vec<f64>,
    moment: Vec<f64>,
    point: Vec<Vec2>,
}

fn loads() -> Loads {
    let mut state = 1u64;
    let mut unit = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    let mut loads = Loads { force: vec![], s_a: vec![], moment: vec![], point: vec![] };
    for _ in 0..N {
        let s_a = 0.02 + 0.055 * unit();
        let q = 3.2 * unit();
        let force = (if unit() < 0.5 { -2.0 } else { 2.0 }) * EI * q / (s_a * s_a);
        let shape = by_force(EI, force, s_a).unwrap();
        loads.force.push(force);
        loads.s_a.push(s_a);
        loads.moment.push(shape.moment);
        loads.point.push(shape.contact);
    }
    loads
}

/// One call at a time, each argument made to wait for the answer before it, as in a search.
fn singles(c: &mut Criterion) {
    let l = loads();
    let mut group = c.benchmark_group("single");
    let mut i = 0;
    let mut next = move |last: f64| {
        i = (i + 1) % N;
        // Adds nothing, but only the answer shows that.
        (i, 0.0 * last)
    };
    let mut last = 0.0;
    group.bench_function("baseline: elliptic functions, force mode", |b| {
        b.iter(|| {
            let (i, zero) = next(last);
            let shape = bend(EI, l.force[i] + zero, l.s_a[i], 0.0).unwrap();
            last = shape.tip(LENGTH).x + shape.moment;
        });
    });
    group.bench_function("force: contact, slope, moment, tip", |b| {
        b.iter(|| {
            let (i, zero) = next(last);
            let shape = by_force(EI, l.force[i] + zero, l.s_a[i]).unwrap();
            last = shape.tip(LENGTH).x + shape.moment + shape.phi_a;
        });
    });
    group.bench_function("moment: contact, slope, force, tip", |b| {
        b.iter(|| {
            let (i, zero) = next(last);
            let shape = by_moment(EI, l.moment[i] + zero, l.s_a[i], Branch::Least).unwrap();
            last = shape.tip(LENGTH).x + shape.force + shape.phi_a;
        });
    });
    group.bench_function("point: force, arc length, slope, tip", |b| {
        b.iter(|| {
            let (i, zero) = next(last);
            let point = l.point[i] + Vec2::new(zero, zero);
            let shape = by_point(EI, LENGTH, point, Branch::Least).unwrap();
            last = shape.tip(LENGTH).x + shape.force + shape.s_a + shape.phi_a;
        });
    });
    group.finish();
}

fn batches(c: &mut Criterion) {
    let l = loads();
    let mut out = vec![NormalBend::default(); N];
    let mut tips = vec![Vec2::ZERO; N];
    let mut group = c.benchmark_group("batch");
    group.throughput(Throughput::Elements(N as u64));
    group.bench_function("baseline: elliptic functions, force mode", |b| {
        b.iter(|| {
            for ((tip, &f), &s) in tips.iter_mut().zip(&l.force).zip(&l.s_a) {
                *tip = bend(EI, f, s, 0.0).unwrap().tip(LENGTH);
            }
            black_box(&mut tips);
        });
    });
    let tips_of = |out: &[NormalBend], tips: &mut [Vec2]| {
        for (tip, shape) in tips.iter_mut().zip(out) {
            *tip = shape.tip(LENGTH);
        }
    };
    group.bench_function("force: contact, slope, moment, tip", |b| {
        b.iter(|| {
            by_force_batch(EI, &l.force, &l.s_a, &mut out);
            tips_of(&out, &mut tips);
            black_box((&mut out, &mut tips));
        });
    });
    group.bench_function("moment: contact, slope, force, tip", |b| {
        b.iter(|| {
            by_moment_batch(EI, &l.moment, &l.s_a, Branch::Least, &mut out);
            tips_of(&out, &mut tips);
            black_box((&mut out, &mut tips));
        });
    });
    group.bench_function("point: force, arc length, slope, tip", |b| {
        b.iter(|| {
            by_point_batch(EI, LENGTH, &l.point, Branch::Least, &mut out);
            tips_of(&out, &mut tips);
            black_box((&mut out, &mut tips));
        });
    });
    group.finish();
}

fn general(c: &mut Criterion) {
    let plain = Whisker::default();
    let mut group = c.benchmark_group("general");
    group.bench_function("baseline: closed form, force mode, tilted", |b| {
        b.iter(|| force_mode(&plain, black_box(0.1), 0.06, Load::Tilted(0.1)));
    });
    let whiskers = [
        ("tapered to one half", Whisker { tip_ratio: 0.5, ..plain }, 0.05),
        ("tapered to one tenth", Whisker { tip_ratio: 0.1, ..plain }, 0.01),
        ("tapered to one twentieth", Whisker { tip_ratio: 0.05, ..plain }, 0.008),
        ("curved", Whisker { curvature: 6.0, ..plain }, 0.1),
        ("on an elastic base", Whisker { base_stiffness: 0.3, ..plain }, 0.1),
        ("all three", Whisker { tip_ratio: 0.4, curvature: 6.0, base_stiffness: 0.3, ..plain }, 0.04),
    ];
    for (name, whisker, force) in whiskers {
        let rod = Rod::new(&whisker).unwrap();
        group.bench_function(format!("{name}: force mode"), |b| {
            b.iter(|| rod.force_mode(black_box(force), 0.06, Load::Normal).unwrap());
        });
        let start = rod.force_mode(force, 0.06, Load::Normal).unwrap().remove(0);
        let point = start.contact + Vec2::new(1e-4, -1e-4);
        group.bench_function(format!("{name}: point mode, from a neighbour"), |b| {
            b.iter(|| rod.point_from(black_box(point), Load::Normal, &start).unwrap());
        });
        group.bench_function(format!("{name}: moment mode, every branch"), |b| {
            b.iter(|| rod.moment_mode(black_box(start.moment), 0.06, Load::Normal).unwrap());
        });
    }
    // The sharp end itself, turned by about a radian.
    let (tenth, twentieth) = (Whisker { tip_ratio: 0.1, ..plain }, Whisker { tip_ratio: 0.05, ..plain });
    let tips = [
        ("one tenth", tenth, 0.003),
        ("one twentieth", twentieth, 0.0008),
        (
            "one twentieth, curved, on an elastic base",
            Whisker { curvature: 6.0, base_stiffness: 0.3, ..twentieth },
            0.0008,
        ),
    ];
    for (name, whisker, force) in tips {
        let rod = Rod::new(&whisker).unwrap();
        group.bench_function(format!("tip of a whisker tapered to {name}"), |b| {
            b.iter(|| rod.force_mode(black_box(force), plain.length, Load::Normal).unwrap());
        });
    }
    group.bench_function("closed form, moment mode, every branch", |b| {
        b.iter(|| moment_mode(&plain, black_box(5e-3), 0.06, Load::Normal).unwrap());
    });
    group.bench_function("closed form, point mode, every branch", |b| {
        b.iter(|| point_mode(&plain, black_box(Vec2::new(0.05, 0.03)), Load::Normal).unwrap());
    });
    group.finish();
}

/// A million shapes on one thread, the baseline, and on two.
fn cores(c: &mut Criterion) {
    let l = loads();
    let many = |list: &[f64]| list.iter().copied().cycle().take(1_000_000).collect::<Vec<f64>>();
    let (forces, arcs) = (many(&l.force), many(&l.s_a));
    let mut out = vec![NormalBend::default(); forces.len()];
    let rod = Rod::new(&Whisker { tip_ratio: 0.1, ..Whisker::default() }).unwrap();
    let weak: Vec<f64> = (0..20_000).map(|i| 5e-7 * f64::from(i)).collect();
    let mut group = c.benchmark_group("cores");
    group.sample_size(10);
    for (name, threads) in [("baseline: one thread", 1), ("two threads", 2)] {
        group.bench_function(format!("{name}: a million normal loads"), |b| {
            b.iter(|| {
                batch::by_force(EI, &forces, &arcs, &mut out, threads);
                black_box(&mut out);
            });
        });
        group.bench_function(format!("{name}: 20000 tapered rods"), |b| {
            b.iter(|| batch::map(&weak, threads, |force| rod.force_mode(*force, 0.06, Load::Normal)));
        });
    }
    group.finish();
}

criterion_group!(benches, singles, batches, general, cores);
criterion_main!(benches);
