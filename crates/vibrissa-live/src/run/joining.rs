//! Chunks to rows, on a thread of its own.

use super::queue::{Handed, Shared};
use super::silence::Silence;
use crate::config::READ_PATIENCE;
use crate::journal::{Journal, recorded_time};
use crate::pipeline::{Notice, Pipeline};
use crate::source::{Arrived, Chunk, HostClock};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::Duration;

/// Joins chunks until every source has ended or the run is stopped.
pub(super) fn join_chunks(
    mut pipeline: Pipeline,
    chunks: &Receiver<Chunk>,
    journal: Option<&Journal>,
    clock: &HostClock,
    stop: &AtomicBool,
    shared: &Shared,
) {
    let mut ended = 0;
    let names: Vec<String> = pipeline.counts().map(|(name, _)| name.to_owned()).collect();
    let sources = names.len();
    let mut silence = Silence::new(sources, clock.now());
    let mut known = false;
    while ended < sources && !stop.load(Ordering::Relaxed) {
        let (mut rows, mut fault) = (Vec::new(), None);
        match chunks.recv_timeout(Duration::from_secs_f64(READ_PATIENCE)) {
            Ok(mut chunk) => {
                chunk.arrival = recorded_time(chunk.arrival);
                if let Some(journal) = journal {
                    journal.chunk(&chunk);
                }
                ended += usize::from(chunk.what == Arrived::Ended);
                silence.heard(&chunk, clock.now());
                fault = pipeline.push(&chunk, &mut |row| rows.push(row)).err();
            }
            Err(RecvTimeoutError::Timeout) => silence.all_heard(),
            Err(RecvTimeoutError::Disconnected) => break,
        }
        let mut notices = pipeline.take_notices();
        let now = clock.now();
        let words = silence.words(now).into_iter();
        notices.extend(words.map(|(source, text)| Notice { t: now, source: names[source].clone(), text }));
        let failed = fault.is_some();
        shared.hand_over(&pipeline, &mut known, Handed { rows, notices, fault });
        if failed {
            break;
        }
    }
    let mut rows = Vec::new();
    pipeline.finish(&mut |row| rows.push(row));
    let notices = pipeline.take_notices();
    shared.hand_over(&pipeline, &mut known, Handed { rows, notices, fault: None });
    shared.end();
}
