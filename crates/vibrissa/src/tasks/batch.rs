//! Many whiskers at once, on all cores: the same answers in the same order, whatever the number of threads.

use crate::beam::normal::{Branch, NormalBend, by_force_batch, by_moment_batch, by_point_batch};
use crate::plane::Vec2;
use core::num::NonZero;
use std::sync::{Mutex, PoisonError};
use std::thread;

/// Whiskers that a thread takes at a time where one takes nanoseconds: 4096 are some 50 µs.
const GRAIN: usize = 4096;

/// As many threads as the machine has processors; one where that is not known.
#[must_use]
pub fn all_cores() -> usize {
    thread::available_parallelism().map_or(1, NonZero::get)
}

/// `solve` of every item, in the order of `items`, by up to `threads` threads.
#[must_use]
pub fn map<T: Sync, R: Send>(items: &[T], threads: usize, solve: impl Fn(&T) -> R + Sync) -> Vec<R> {
    let mut out: Vec<Option<R>> = Vec::new();
    out.resize_with(items.len(), || None);
    // Some take longer than others, so that small shares keep all threads busy to the end.
    let grain = (items.len() / (16 * threads.max(1))).clamp(1, GRAIN);
    fill(&mut out, grain, threads, |start, part| {
        for (slot, item) in part.iter_mut().zip(items.iter().skip(start)) {
            *slot = Some(solve(item));
        }
    });
    out.into_iter().flatten().collect()
}

/// [`by_force_batch`] by up to `threads` threads.
pub fn by_force(ei: f64, forces: &[f64], arc_lengths: &[f64], out: &mut [NormalBend], threads: usize) {
    let n = out.len().min(forces.len()).min(arc_lengths.len());
    fill(&mut out[..n], GRAIN, threads, |start, part| {
        by_force_batch(ei, &forces[start..], &arc_lengths[start..], part);
    });
}

/// [`by_moment_batch`] by up to `threads` threads.
pub fn by_moment(
    ei: f64,
    moments: &[f64],
    arc_lengths: &[f64],
    branch: Branch,
    out: &mut [NormalBend],
    threads: usize,
) {
    let n = out.len().min(moments.len()).min(arc_lengths.len());
    fill(&mut out[..n], GRAIN, threads, |start, part| {
        by_moment_batch(ei, &moments[start..], &arc_lengths[start..], branch, part);
    });
}

/// [`by_point_batch`] by up to `threads` threads.
pub fn by_point(ei: f64, length: f64, points: &[Vec2], branch: Branch, out: &mut [NormalBend], threads: usize) {
    let n = out.len().min(points.len());
    fill(&mut out[..n], GRAIN, threads, |start, part| by_point_batch(ei, length, &points[start..], branch, part));
}

/// Lets `work` fill `out` in parts of `grain`, each told where it starts. Whoever is free takes the next part.
fn fill<R: Send>(out: &mut [R], grain: usize, threads: usize, work: impl Fn(usize, &mut [R]) + Sync) {
    let workers = threads.min(out.len().div_ceil(grain));
    if workers < 2 {
        work(0, out);
        return;
    }
    let parts = Mutex::new(out.chunks_mut(grain).enumerate());
    let work_on = || {
        while let Some((i, part)) = { parts.lock().unwrap_or_else(PoisonError::into_inner).next() } {
            work(i * grain, part);
        }
    };
    thread::scope(|scope| {
        for _ in 1..workers {
            scope.spawn(work_on);
        }
        work_on();
    });
}
