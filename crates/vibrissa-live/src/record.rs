//! The recording: everything that arrives, on a thread of its own, so that a slow disk never stalls the estimate and a power
//! cut loses at most the last moments.
//!
//! | topic | kind | what |
//! | --- | --- | --- |
//! | `/raw/NAME` | `std_msgs/UInt8MultiArray` | bytes of a source, logged at their arrival |
//! | `/raw/NAME/event` | `std_msgs/String` | `opened`, `gone: …`, `ended` |
//! | `/vibrissa/row` | `sensor_msgs/JointState` | a row that the estimator took: positions by name |
//! | `/vibrissa/estimate` | `std_msgs/String` | the estimate, a line of JSON |
//! | `/vibrissa/pose` | `geometry_msgs/PoseWithCovarianceStamped` | its best place |
//! | `/vibrissa/notice` | `std_msgs/String` | what happened to a source |
//! | `/vibrissa/setup` | `std_msgs/String` | version, folder and `live.toml` of the run |
//!
//! A chunk of the file is closed and handed to the system twenty times a second: `kill -9` loses no more than that. A second thread
//! synchronises the file with the disk, five times a second where the disk is as fast; neither thread waits for the other. What is not synchronised
//! stays in memory and is written again where the disk refuses. What does not fit into memory while the disk is slow or full is
//! dropped and counted, and the sequence of its topic has a hole there.

mod storage;
mod syncing;
mod writing;

pub use storage::{FileStorage, Storage, Synchroniser};

use crate::config::RECORD_WAITING;
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, AtomicUsize, Ordering};
use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;
use vibrissa_io::ros::{BagStream, Kind, StreamTopic};
use writing::Writer;

/// A topic of a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RecordTopic(usize);

/// One message on its way to the disk.
struct Entry {
    topic: usize,
    t: f64,
    message: Vec<u8>,
}

impl Entry {
    /// What it takes in memory (bytes).
    fn size(&self) -> usize {
        self.message.len() + size_of::<Self>()
    }
}

/// What recorder and run both look at.
#[derive(Debug, Default)]
struct Shared {
    /// Bytes that wait for the writing thread, and those that it keeps until they are synchronised.
    waiting: AtomicUsize,
    kept: AtomicUsize,
    /// Messages that were dropped in all, and of each topic since the last one that was written.
    dropped: AtomicU64,
    holes: Vec<AtomicU32>,
    /// Bytes that are safe on the disk.
    synced: AtomicU64,
    /// What the disk said last, while it refuses.
    fault: Mutex<Option<String>>,
    /// Whether somebody wants the file to be whole at once, and whether it is.
    hurried: AtomicBool,
    closed: Mutex<bool>,
    closing: Condvar,
}

impl Shared {
    fn is_hurried(&self) -> bool {
        self.hurried.load(Ordering::Relaxed)
    }

    fn close(&self) {
        *self.closed.lock().unwrap_or_else(PoisonError::into_inner) = true;
        self.closing.notify_all();
    }
}

/// Closes a recording from another thread, before all that is still to come: for those who have to leave at once.
#[derive(Clone, Debug)]
pub struct Closer(Arc<Shared>);

impl Closer {
    /// Closes the file with what was recorded so far, without an index of a long recording; whether it is whole within so long (s). What is
    /// recorded later is dropped.
    #[must_use]
    pub fn close_now(&self, patience: f64) -> bool {
        self.0.hurried.store(true, Ordering::Relaxed);
        let closed = self.0.closed.lock().unwrap_or_else(PoisonError::into_inner);
        let patience = Duration::try_from_secs_f64(patience).unwrap_or_default();
        let waited = self.0.closing.wait_timeout_while(closed, patience, |closed| !*closed);
        *waited.map_or_else(|e| e.into_inner().0, |(closed, _)| closed)
    }
}

/// Hands messages to the thread that writes them.
#[derive(Debug)]
pub struct Recorder {
    sender: Option<Sender<Entry>>,
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
    limit: usize,
}

impl Recorder {
    /// Begins a recording with these topics: name, kind, and whether the last message holds until the next one.
    #[must_use]
    pub fn begin(storage: impl Storage + 'static, topics: &[(String, Kind, bool)]) -> (Self, Vec<RecordTopic>) {
        Self::with_limit(storage, topics, RECORD_WAITING)
    }

    /// The same with so much memory (bytes) for what waits for the disk.
    #[must_use]
    pub fn with_limit(
        storage: impl Storage + 'static,
        topics: &[(String, Kind, bool)],
        limit: usize,
    ) -> (Self, Vec<RecordTopic>) {
        let mut stream = BagStream::new();
        let known: Vec<StreamTopic> =
            topics.iter().map(|(name, kind, latched)| stream.topic(name.clone(), *kind, *latched)).collect();
        let holes = topics.iter().map(|_| AtomicU32::new(0)).collect();
        let shared = Arc::new(Shared { holes, ..Shared::default() });
        let (sender, receiver) = channel();
        let writer = Writer::new(stream, known, storage, Arc::clone(&shared), limit);
        let thread = std::thread::spawn(move || writer.run(&receiver));
        let topics = (0..topics.len()).map(RecordTopic).collect();
        (Self { sender: Some(sender), shared, thread: Some(thread), limit }, topics)
    }

    /// Records a message, logged at `t` (s); false where it had to be dropped.
    #[allow(clippy::must_use_candidate, reason = "what is dropped is counted")]
    pub fn push(&self, topic: RecordTopic, t: f64, message: Vec<u8>) -> bool {
        let entry = Entry { topic: topic.0, t, message };
        let size = entry.size();
        let held = self.shared.waiting.load(Ordering::Relaxed) + self.shared.kept.load(Ordering::Relaxed);
        let full = held + size > self.limit;
        if !full && let Some(sender) = &self.sender {
            self.shared.waiting.fetch_add(size, Ordering::Relaxed);
            if sender.send(entry).is_ok() {
                return true;
            }
        }
        self.shared.holes[topic.0].fetch_add(1, Ordering::Relaxed);
        self.shared.dropped.fetch_add(1, Ordering::Relaxed);
        false
    }

    /// What closes the file while this is elsewhere.
    #[must_use]
    pub fn closer(&self) -> Closer {
        Closer(Arc::clone(&self.shared))
    }

    /// Messages that were dropped.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.shared.dropped.load(Ordering::Relaxed)
    }

    /// Bytes of the file that are safe on the disk.
    #[must_use]
    pub fn synced(&self) -> u64 {
        self.shared.synced.load(Ordering::Relaxed)
    }

    /// What the disk says while it refuses.
    #[must_use]
    pub fn fault(&self) -> Option<String> {
        self.shared.fault.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Closes the file: what waits is written, with the index. What the disk refuses to the end is an error.
    ///
    /// # Errors
    ///
    /// What the disk says.
    pub fn finish(mut self) -> Result<(), String> {
        self.end();
        self.fault().map_or(Ok(()), Err)
    }

    fn end(&mut self) {
        drop(self.sender.take());
        if let Some(thread) = self.thread.take() {
            // A writer that panicked has nothing left to say.
            let _ = thread.join();
        }
    }
}

impl Drop for Recorder {
    fn drop(&mut self) {
        self.end();
    }
}
