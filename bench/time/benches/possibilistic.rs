//! The possibilistic method row by row, on a sweep along the built-in arena: the whole log, the first contact, and the
//! rows after the first hundred in contact.

#![allow(missing_docs, clippy::unwrap_used, reason = "a benchmark that cannot go on must fail")]

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use vibrissa::beam::press::PressTable;
use vibrissa::config::PossibilisticOptions;
use vibrissa::localizer::{Estimator, PossibilisticEstimator};
use vibrissa::tasks::demo;
use vibrissa::world::Robot;

fn rows(c: &mut Criterion) {
    let (map, robot, sweep) = (demo::arena().unwrap(), Robot::default(), demo::sweep(1).unwrap());
    let log = &sweep.log;
    let options = PossibilisticOptions { last_work: 0, ..PossibilisticOptions::default() };
    let fresh = || PossibilisticEstimator::new(&map, &robot, &log.channels, options).unwrap();
    let first = log.rows.iter().position(|row| row.readings[0].abs() > 1e-4).unwrap();
    let until = |end: usize| {
        let mut localizer = fresh();
        log.rows[..end].iter().for_each(|row| localizer.step(row).unwrap());
        localizer
    };
    let mut group = c.benchmark_group("possibilistic");
    group.sample_size(10);
    group.bench_function("new", |b| b.iter(|| black_box(fresh())));
    group.bench_function("first contact", |b| b.iter(|| black_box(until(first + 1))));
    group.bench_function("whole log", |b| b.iter(|| black_box(until(log.rows.len()))));
    group.bench_function("100 rows after 100 in contact", |b| {
        let step = |mut localizer: PossibilisticEstimator<'_>| {
            log.rows[first + 100..first + 200].iter().for_each(|row| localizer.step(row).unwrap());
        };
        b.iter_batched(|| until(first + 100), step, BatchSize::LargeInput);
    });
    group.bench_function("slice of one reading, baseline: its table", |b| {
        let table = PressTable::new(64, 48, 0.0, 2.2);
        b.iter(|| table.slice(black_box(0.5), black_box(0.55)));
    });
    group.bench_function("table of one whisker", |b| b.iter(|| PressTable::new(black_box(64), 48, 0.0, 2.2)));
    group.finish();
}

criterion_group!(benches, rows);
criterion_main!(benches);
