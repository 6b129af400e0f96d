//! Chunks to rows, on a thread of its own.

use super::queue::{Handed, Shared};
use crate::config::READ_PATIENCE;
use crate::journal::{Journal, recorded_time};
use crate::pipeline::{Notice, Pipeline};
use crate::source::{Arrived, Chunk, HostClock};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::Duration;

/// A source that has said nothing for so long (s) is told of once.
const SILENT: f64 = 3.0;

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
    let sources = pipeline.counts().count();
    let began = clock.now();
    let mut silence_told = false;
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
                fault = pipeline.push(&chunk, &mut |row| rows.push(row)).err();
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => break,
        }
        let mut notices = pipeline.take_notices();
        if !silence_told && clock.now() > began + SILENT {
            silence_told = true;
            notices.extend(silent(&pipeline, clock.now()));
        }
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

/// A word about each source that has sent nothing.
fn silent(pipeline: &Pipeline, t: f64) -> Vec<Notice> {
    let quiet = pipeline.counts().filter(|(_, counts)| counts.bytes == 0 && counts.gone == 0);
    let word = "no bytes yet: is the device switched on, and the cable in?";
    quiet.map(|(name, _)| Notice { t, source: name.to_owned(), text: word.to_owned() }).collect()
}
