//! The guard beside the tries: it ends the program when an input hangs or fills the memory, and keeps that input.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// A try that computes for longer than this hangs (s),
const HANG: u64 = 60;
/// and so does one that has not ended after so many times that: a busy machine gives the program little of its time.
const WAITING: u64 = 10;
/// Units of processor time in a second, as Linux tells them whatever its kernel counts in.
const TICKS: u64 = 100;
/// Most memory that a try may add to what the program held when it began (kB): inputs are small, and a grid map of the most cells takes
/// two thirds of it.
const MEMORY: u64 = 500_000;
/// Time between two looks.
const LOOK: Duration = Duration::from_millis(50);

/// What is being tried now.
#[derive(Clone, Default)]
pub(crate) struct Watch(Arc<Mutex<Option<Try>>>);

struct Try {
    target: &'static str,
    input: Vec<u8>,
    since: Instant,
    /// Processor time of the program before (s); none where the system does not tell.
    computed: Option<u64>,
    /// What the program held before (kB).
    held: u64,
}

impl Watch {
    /// A watch whose guard runs until the program ends; inputs are kept in `folder`.
    pub(crate) fn start(folder: PathBuf) -> Self {
        let watch = Self::default();
        let seen = watch.clone();
        std::thread::spawn(move || {
            loop {
                std::thread::sleep(LOOK);
                seen.look(&folder);
            }
        });
        watch
    }

    /// Says what is tried from now on.
    pub(crate) fn begin(&self, target: &'static str, input: &[u8]) {
        let now = Try { target, input: input.to_vec(), since: Instant::now(), computed: computed(), held: memory() };
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = Some(now);
    }

    /// Says that nothing is tried.
    pub(crate) fn end(&self) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = None;
    }

    fn look(&self, folder: &std::path::Path) {
        let guard = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let Some(now) = guard.as_ref() else { return };
        let passed = now.since.elapsed().as_secs();
        let works = computed().zip(now.computed).map_or(passed, |(now, then)| now.saturating_sub(then));
        let hangs = works >= HANG || passed >= WAITING * HANG;
        let held = memory().saturating_sub(now.held);
        if !hangs && held <= MEMORY {
            return;
        }
        let path = folder.join(format!("{}-stopped.input", now.target));
        let kept = std::fs::create_dir_all(folder).and_then(|()| std::fs::write(&path, &now.input));
        let why = if hangs { format!("hangs for {HANG} s") } else { format!("takes {held} kB of memory") };
        eprintln!("{}: an input {why}; it is in {} ({kept:?})", now.target, path.display());
        std::process::exit(1);
    }
}

/// Processor time that the program has taken (s), of its own and in the system.
fn computed() -> Option<u64> {
    let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
    // The name before may hold blanks; behind it user and system time are the 12th and 13th.
    let mut fields = stat.rsplit_once(')')?.1.split_whitespace().skip(11);
    let mut ticks = || fields.next()?.parse::<u64>().ok();
    Some((ticks()? + ticks()?) / TICKS)
}

/// How long this thread has worked since it began, where the system tells.
pub(crate) fn worked() -> Option<Duration> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    text.split(' ').next()?.parse().ok().map(Duration::from_nanos)
}

/// What the program holds (kB); 0 where the system does not tell.
fn memory() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    line.and_then(|line| line.split_whitespace().next()?.parse().ok()).unwrap_or(0)
}
