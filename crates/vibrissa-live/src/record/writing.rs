//! The thread that writes.

use super::syncing::Synchronising;
use super::{Entry, Shared, Storage};
use crate::config::{DISK_RETRY, WRITE};
use std::io::{Error, Result};
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::sync::{Arc, PoisonError};
use std::time::{Duration, Instant};
use vibrissa_io::ros::{BagStream, GrowingFile, Stamp, StreamTopic};

/// A chunk that takes such a share of the memory is written before its time: 256 kB.
const LARGE: usize = 128;

/// Memory for what is not synchronised (bytes) that is kept for what comes next; more of it, from a time when the disk was slow, is given back.
const SPARE: usize = 1 << 18;

/// Length of the last bytes of a file, which say that it is whole.
const SEAL: usize = 8;

/// A file that is read again until somebody is in a hurry.
struct Patient<'a, S> {
    storage: &'a mut S,
    shared: &'a Shared,
}

impl<S: Storage> GrowingFile for Patient<'_, S> {
    fn append(&mut self, bytes: &[u8]) -> Result<()> {
        self.storage.append(bytes)
    }

    fn read_at(&mut self, place: u64, buffer: &mut [u8]) -> Result<usize> {
        if self.shared.is_hurried() { Err(Error::other("in a hurry")) } else { self.storage.read_at(place, buffer) }
    }
}

/// Makes chunks of messages and hands them to the system.
pub(super) struct Writer<S> {
    stream: BagStream,
    topics: Vec<StreamTopic>,
    storage: S,
    /// Bytes of the file that are on the disk.
    safe: u64,
    /// Bytes after them: so many were handed to the system, the others not yet.
    kept: Vec<u8>,
    written: usize,
    /// A chunk of this size is written before its time (bytes).
    large: usize,
    shared: Arc<Shared>,
}

impl<S: Storage> Writer<S> {
    /// For so much memory (bytes).
    pub(super) fn new(
        stream: BagStream,
        topics: Vec<StreamTopic>,
        storage: S,
        shared: Arc<Shared>,
        limit: usize,
    ) -> Self {
        let large = limit / LARGE;
        Self { stream, topics, storage, safe: 0, kept: Vec::new(), written: 0, large, shared }
    }

    /// Writes until nobody records any more, then the end of the file.
    pub(super) fn run(mut self, entries: &Receiver<Entry>) {
        let synchronising = Synchronising::begin(self.storage.synchroniser());
        let period = Duration::from_secs_f64(WRITE);
        let mut due = Instant::now() + period;
        while !self.shared.is_hurried() {
            match entries.recv_timeout(due.saturating_duration_since(Instant::now())) {
                Ok(entry) => self.take(entry),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break,
            }
            if Instant::now() >= due || self.stream.open_bytes() > self.large {
                // A disk that refuses is not asked at once again; what comes waits in the queue.
                if let Err(error) = self.write(&synchronising) {
                    self.refused(&error);
                    self.pause();
                }
                due = Instant::now() + period;
            }
        }
        // Who is in a hurry does not wait for what is still to come.
        entries.try_iter().for_each(|entry| self.take(entry));
        match synchronising.end() {
            Some(done) => drop(self.synced(done)),
            None => self.take_back(),
        }
        match self.end() {
            Ok(()) => self.shared.close(),
            Err(error) => {
                self.refused(&error);
                // The error is told already.
                let _ = self.storage.synchroniser()();
            }
        }
    }

    /// Leaves a full disk alone for a while.
    fn pause(&self) {
        let until = Instant::now() + Duration::from_secs_f64(DISK_RETRY);
        while Instant::now() < until && !self.shared.is_hurried() {
            std::thread::sleep(Duration::from_secs_f64(WRITE));
        }
    }

    fn take(&mut self, entry: Entry) {
        let topic = self.topics[entry.topic];
        let holes = self.shared.holes[entry.topic].swap(0, Ordering::Relaxed);
        self.stream.skip(topic, holes);
        self.stream.push(topic, Stamp::from_seconds(entry.t), &entry.message);
        self.shared.waiting.fetch_sub(entry.size(), Ordering::Relaxed);
        self.count();
    }

    /// Hands what is new to the system and asks for it to be synchronised; what the disk has refused is written again.
    fn write(&mut self, synchronising: &Synchronising) -> Result<()> {
        let (done, fault) = synchronising.progress();
        let went_on = self.synced(done);
        if let Some(error) = fault {
            self.take_back();
            return Err(error);
        }
        let flushed = self.stream.flush();
        self.kept.extend(flushed);
        self.append()?;
        synchronising.ask(self.safe + self.written as u64);
        if went_on {
            self.said(None);
        }
        Ok(())
    }

    /// Appends what the system does not have yet.
    fn append(&mut self) -> Result<()> {
        if self.written < self.kept.len() {
            self.storage.append(&self.kept[self.written..])?;
            self.written = self.kept.len();
        }
        self.count();
        Ok(())
    }

    /// So many bytes of the file are on the disk; whether these are more than before.
    fn synced(&mut self, length: u64) -> bool {
        let more = (length.saturating_sub(self.safe) as usize).min(self.written);
        self.kept.drain(..more);
        let wanted = self.kept.len().max(SPARE);
        if self.kept.capacity() > 2 * wanted {
            self.kept.shrink_to(wanted);
        }
        self.written -= more;
        self.safe += more as u64;
        self.shared.synced.store(self.safe, Ordering::Relaxed);
        self.count();
        more > 0
    }

    /// Writes what is left and the summary; the last bytes say that the file is whole: they are written when all before them is
    /// on the disk.
    fn end(&mut self) -> Result<()> {
        let mut synchronise = self.storage.synchroniser();
        let flushed = self.stream.flush();
        self.kept.extend(flushed);
        self.append()?;
        if synchronise().is_err() {
            self.take_back();
            self.append()?;
            synchronise()?;
        }
        self.synced(self.safe + self.written as u64);
        let seal = self.summary()?;
        synchronise()?;
        self.storage.append(&seal)?;
        synchronise()?;
        self.said(None);
        Ok(())
    }

    /// Appends the summary, with the index of all chunks unless somebody is in a hurry; the last bytes, which are to follow it.
    fn summary(&mut self) -> Result<Vec<u8>> {
        let stream = core::mem::take(&mut self.stream);
        if !self.shared.is_hurried() {
            let mut file = Patient { storage: &mut self.storage, shared: &self.shared };
            let ended = stream.clone().finish_in(&mut file);
            if ended.is_ok() || !self.shared.is_hurried() {
                return ended;
            }
            self.storage.truncate(self.safe)?;
        }
        let mut summary = stream.finish();
        let seal = summary.split_off(summary.len().saturating_sub(SEAL));
        self.storage.append(&summary)?;
        Ok(seal)
    }

    /// Notes that the disk has refused; a part that was written before is taken back.
    fn refused(&mut self, error: &Error) {
        // Where even this fails, readers stop at the part that is there.
        let _ = self.storage.truncate(self.safe + self.written as u64);
        self.said(Some(error.to_string()));
    }

    /// What was written and cannot be synchronised is to be written again: the system may have forgotten it.
    fn take_back(&mut self) {
        self.written = 0;
        let _ = self.storage.truncate(self.safe);
    }

    fn said(&self, fault: Option<String>) {
        *self.shared.fault.lock().unwrap_or_else(PoisonError::into_inner) = fault;
    }

    /// Counts the memory of what is not synchronised.
    fn count(&self) {
        self.shared.kept.store(self.kept.len() + self.stream.open_bytes(), Ordering::Relaxed);
    }
}
