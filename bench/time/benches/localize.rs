//! Whole-log localization of the demo's sweep: the probabilistic method beside the deterministic one, in one run.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use std::hint::black_box;
use vibrissa::tasks::demo;
use vibrissa::world::Robot;
use vibrissa::{Method, Result, localize};

fn whole_log(criterion: &mut Criterion) {
    let sweep_on = || -> Result<_> { Ok((demo::arena()?, demo::sweep(1)?)) };
    let Ok((map, sweep)) = sweep_on() else { return };
    let mut group = criterion.benchmark_group("localize the demo");
    group.sample_size(10).throughput(Throughput::Elements(sweep.log.rows.len() as u64));
    for (name, method) in [("deterministic (baseline)", "deterministic"), ("probabilistic", "probabilistic")] {
        let Ok(method) = Method::named(method) else { return };
        group.bench_function(name, |bencher| {
            bencher.iter(|| localize(black_box(&sweep.log), &map, &Robot::default(), &method, &mut |_| {}));
        });
    }
    group.finish();
}

criterion_group!(benches, whole_log);
criterion_main!(benches);
