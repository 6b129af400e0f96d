//! Work on many candidates on all cores, with the same result as on one.

use std::num::NonZero;
use std::thread;

/// Fewer items than this for each thread are not worth starting it.
const LEAST_SHARE: usize = 2000;

/// How many items each thread takes.
fn share(items: usize) -> usize {
    let cores = if items < 2 * LEAST_SHARE { 1 } else { thread::available_parallelism().map_or(1, NonZero::get) };
    items.div_ceil(cores).max(LEAST_SHARE)
}

/// Calls `work` once for each item.
pub(crate) fn for_each<T: Send>(items: &mut [T], work: impl Fn(&mut T) + Sync) {
    let share = share(items.len());
    if items.len() <= share {
        return items.iter_mut().for_each(work);
    }
    thread::scope(|scope| {
        for part in items.chunks_mut(share) {
            scope.spawn(|| part.iter_mut().for_each(&work));
        }
    });
}

/// What `work` makes of each item, in order, without those that it makes nothing of.
pub(crate) fn filter_map<T: Sync, U: Send>(items: &[T], work: impl Fn(&T) -> Option<U> + Sync) -> Vec<U> {
    let share = share(items.len());
    if items.len() <= share {
        return items.iter().filter_map(work).collect();
    }
    let of = |part: &[T]| part.iter().filter_map(&work).collect::<Vec<U>>();
    let of = &of;
    thread::scope(|scope| {
        let parts: Vec<_> = items.chunks(share).map(|part| scope.spawn(move || of(part))).collect();
        let done = parts.into_iter().map(|part| part.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)));
        done.flatten().collect()
    })
}
