//! How long a million force problems take in a loop of our own, on all cores: milliseconds, the median of five runs.
//!
//! `bench/python/run` sets it beside the same call from Python.

use std::time::Instant;
use vibrissa::beam::{Load, Whisker, force_mode};
use vibrissa::tasks::batch;

fn main() {
    // The same problems as in `bench/python/million_bends.py`.
    let count = 1_000_000;
    let share = |i: usize| i as f64 / (count - 1) as f64;
    let problems: Vec<(f64, f64)> = (0..count).map(|i| (-0.3 + 0.6 * share(i), 0.02 + 0.055 * share(i))).collect();
    let whisker = Whisker::default();
    let mut times: Vec<f64> = (0..5)
        .map(|_| {
            let start = Instant::now();
            let bends = batch::map(&problems, batch::all_cores(), |&(force, s_a)| {
                force_mode(&whisker, force, s_a, Load::Normal).unwrap_or_default()
            });
            let columns: [Vec<f64>; 3] = [
                bends.iter().flatten().map(|b| b.contact.x).collect(),
                bends.iter().flatten().map(|b| b.contact.y).collect(),
                bends.iter().flatten().map(|b| b.moment).collect(),
            ];
            assert!(columns.iter().all(|column| column.len() == columns[0].len()));
            start.elapsed().as_secs_f64() * 1e3
        })
        .collect();
    times.sort_by(f64::total_cmp);
    println!("{:.1}", times[2]);
}
