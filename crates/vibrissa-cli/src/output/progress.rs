//! What goes on, on one line of a terminal, for whoever waits longer than a second.

use std::io::{IsTerminal, Write};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Nobody wonders before this time has passed,
const PATIENCE: Duration = Duration::from_secs(1);
/// and the line is drawn as often as this.
const REDRAW: Duration = Duration::from_millis(250);

/// What is counted unless said otherwise.
const ROWS: &str = "rows";

/// The work under way; one command runs at a time.
static LINE: Mutex<Line> = Mutex::new(Line { what: String::new(), done: 0, all: 0, counted: ROWS, drawn: false });

#[derive(Debug)]
struct Line {
    what: String,
    /// How many of all are done, and what they are; 0 of 0 where they are not counted.
    done: usize,
    all: usize,
    counted: &'static str,
    drawn: bool,
}

fn line() -> MutexGuard<'static, Line> {
    LINE.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Line {
    fn words(&self, passed: Duration) -> String {
        let Self { what, done, all, counted, .. } = self;
        let seconds = passed.as_secs();
        if *all == 0 {
            format!("{what} … {seconds} s")
        } else {
            format!("{what}: {done} of {all} {counted}, {seconds} s")
        }
    }

    fn clear(&mut self) {
        if core::mem::take(&mut self.drawn) {
            // If standard error is closed, nobody watches.
            let _ = write!(std::io::stderr(), "\r\x1b[K");
        }
    }
}

/// Says what goes on now.
pub(crate) fn phase(what: &str) {
    let mut line = line();
    (line.what, line.done, line.all) = (what.to_owned(), 0, 0);
}

/// Says how many rows of all are done.
pub(crate) fn count(done: usize, all: usize) {
    let mut line = line();
    (line.done, line.all, line.counted) = (done, all, ROWS);
}

/// Says how many readings in contact of all are gone through.
pub(crate) fn readings(done: usize, all: usize) {
    let mut line = line();
    (line.done, line.all, line.counted) = (done, all, "readings in contact");
}

/// Takes the line away, before something else is written there.
pub(crate) fn clear() {
    line().clear();
}

/// The line, as long as the value lives; none where nobody sits in front of standard error.
pub(crate) struct Progress {
    watch: Option<(Sender<()>, JoinHandle<()>)>,
}

impl Progress {
    /// Shows what goes on from now on.
    pub(crate) fn begin(what: &str) -> Self {
        phase(what);
        if !std::io::stderr().is_terminal() {
            return Self { watch: None };
        }
        let (stop, stopped) = channel();
        let begin = Instant::now();
        let draw = move || {
            let mut wait = PATIENCE;
            while stopped.recv_timeout(wait) == Err(RecvTimeoutError::Timeout) {
                wait = REDRAW;
                let mut line = line();
                let words = line.words(begin.elapsed());
                line.drawn = true;
                let _ = write!(std::io::stderr(), "\r\x1b[K{}", super::plain(&words));
            }
            clear();
        };
        // Without a thread to spare there is no line.
        let thread = std::thread::Builder::new().name("progress".into()).spawn(draw).ok();
        Self { watch: thread.map(|thread| (stop, thread)) }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some((stop, thread)) = self.watch.take() {
            drop(stop);
            let _ = thread.join();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Line;
    use std::time::Duration;

    #[test]
    fn the_line_tells_rows_where_they_are_counted() {
        let mut line = Line { what: "localizing".into(), done: 0, all: 0, counted: super::ROWS, drawn: false };
        assert_eq!(line.words(Duration::from_millis(2500)), "localizing … 2 s");
        (line.done, line.all) = (3, 70);
        assert_eq!(line.words(Duration::from_secs(61)), "localizing: 3 of 70 rows, 61 s");
    }
}
