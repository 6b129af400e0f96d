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
//! A chunk of the file is closed, written and synchronised four times a second. What does not fit into memory while the disk
//! is slow or full is dropped and counted, and the sequence of its topic has a hole there.

mod storage;

pub use storage::{FileStorage, Storage};

use crate::config::{DISK_RETRY, RECORD_WAITING, SYNC};
use std::sync::atomic::{AtomicU32, AtomicU64, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use vibrissa_io::ros::{BagStream, Kind, Stamp, StreamTopic};

/// A chunk of this size is written before its time (bytes).
const LARGE: usize = 256 << 10;

/// A topic of a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RecordTopic(usize);

/// One message on its way to the disk.
struct Entry {
    topic: usize,
    t: f64,
    message: Vec<u8>,
}

/// What recorder and run both look at.
#[derive(Debug, Default)]
struct Shared {
    /// Bytes that wait.
    waiting: AtomicUsize,
    /// Messages that were dropped in all, and of each topic since the last one that was written.
    dropped: AtomicU64,
    holes: Vec<AtomicU32>,
    /// Bytes that are safe on the disk.
    synced: AtomicU64,
    /// What the disk said last, while it refuses.
    fault: Mutex<Option<String>>,
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
        let writer = Writer { stream, topics: known, pending: Vec::new(), length: 0, shared: Arc::clone(&shared) };
        let thread = std::thread::spawn(move || writer.run(storage, &receiver));
        let topics = (0..topics.len()).map(RecordTopic).collect();
        (Self { sender: Some(sender), shared, thread: Some(thread), limit }, topics)
    }

    /// Records a message, logged at `t` (s); false where it had to be dropped.
    #[allow(clippy::must_use_candidate, reason = "what is dropped is counted")]
    pub fn push(&self, topic: RecordTopic, t: f64, message: Vec<u8>) -> bool {
        let size = message.len() + size_of::<Entry>();
        let full = self.shared.waiting.load(Ordering::Relaxed) + size > self.limit;
        if !full && let Some(sender) = &self.sender {
            self.shared.waiting.fetch_add(size, Ordering::Relaxed);
            if sender.send(Entry { topic: topic.0, t, message }).is_ok() {
                return true;
            }
        }
        self.shared.holes[topic.0].fetch_add(1, Ordering::Relaxed);
        self.shared.dropped.fetch_add(1, Ordering::Relaxed);
        false
    }

    /// Messages that were dropped.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.shared.dropped.load(Ordering::Relaxed)
    }

    /// Bytes that are safe on the disk.
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

/// The writing thread's side.
struct Writer {
    stream: BagStream,
    topics: Vec<StreamTopic>,
    /// Bytes that the disk refused so far, and those before them.
    pending: Vec<u8>,
    length: u64,
    shared: Arc<Shared>,
}

impl Writer {
    fn run(mut self, mut storage: impl Storage, entries: &Receiver<Entry>) {
        let period = Duration::from_secs_f64(SYNC);
        let mut due = Instant::now() + period;
        loop {
            match entries.recv_timeout(due.saturating_duration_since(Instant::now())) {
                Ok(entry) => self.take(entry),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break,
            }
            if Instant::now() >= due || self.stream.open_bytes() > LARGE {
                let written = self.write(&mut storage);
                // A disk that refuses is not asked at once again; what comes waits in the queue.
                if !written {
                    std::thread::sleep(Duration::from_secs_f64(DISK_RETRY));
                }
                due = Instant::now() + period;
            }
        }
        if self.write(&mut storage) {
            let ended = self.end(&mut storage);
            self.note(&mut storage, ended);
        }
    }

    /// Writes the summary; the last bytes say that the file is whole: they are written when all before them is on the disk.
    fn end(&mut self, storage: &mut impl Storage) -> std::io::Result<()> {
        let seal = core::mem::take(&mut self.stream).finish_in(storage)?;
        storage.sync()?;
        storage.append(&seal)?;
        storage.sync()
    }

    fn take(&mut self, entry: Entry) {
        let topic = self.topics[entry.topic];
        let holes = self.shared.holes[entry.topic].swap(0, Ordering::Relaxed);
        self.stream.skip(topic, holes);
        self.stream.push(topic, Stamp::from_seconds(entry.t), &entry.message);
        self.shared.waiting.fetch_sub(entry.message.len() + size_of::<Entry>(), Ordering::Relaxed);
    }

    fn write(&mut self, storage: &mut impl Storage) -> bool {
        let bytes = self.stream.flush();
        self.pending.extend(bytes);
        self.pending.is_empty() || self.append(storage)
    }

    /// Appends what is pending; a part that was written before the disk refused is taken back.
    fn append(&mut self, storage: &mut impl Storage) -> bool {
        let result = storage.append(&self.pending).and_then(|()| storage.sync());
        self.note(storage, result)
    }

    /// Notes what the disk said to what is pending.
    fn note(&mut self, storage: &mut impl Storage, result: std::io::Result<()>) -> bool {
        let mut fault = self.shared.fault.lock().unwrap_or_else(PoisonError::into_inner);
        match result {
            Ok(()) => {
                self.length += self.pending.len() as u64;
                self.pending.clear();
                self.shared.synced.store(self.length, Ordering::Relaxed);
                *fault = None;
                true
            }
            Err(error) => {
                // Where even this fails, readers stop at the part that is there.
                let _ = storage.truncate(self.length);
                *fault = Some(error.to_string());
                false
            }
        }
    }
}
