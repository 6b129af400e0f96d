//! What people see of a run: one line that changes, and an account at the end.

use super::{mapping, planning::Answer};
use crate::commands::plan::{waypoints, where_to_stop};
use crate::output::{plain, print};
use serde_json::json;
use std::fmt::Write as _;
use std::io::{IsTerminal, Write as _};
use std::time::{Duration, Instant};
use vibrissa::error::printable;
use vibrissa::flow::pose::Estimate;
use vibrissa::tasks::plan::{Plan, to_json};
use vibrissa_live::counts::Counts;
use vibrissa_live::estimate::Told;
use vibrissa_live::output::words;
use vibrissa_live::pipeline::Notice;
use vibrissa_live::run::Health;

/// Longest notice (characters): sources may send anything.
const LONGEST_NOTICE: usize = 600;
/// How often the line changes on a terminal, and how often a new one is written elsewhere.
const REDRAW: Duration = Duration::from_millis(100);
const NEW_LINE: Duration = Duration::from_secs(1);

/// The line on the terminal.
pub(super) struct Monitor {
    json: bool,
    is_terminal: bool,
    shown: Option<Instant>,
    /// Rows and time at the last look, for the rate.
    before: (u64, Instant),
    rate: f64,
    /// The last estimate in words, once there is one.
    words: Option<String>,
    drawn: bool,
    closed: bool,
    disk: Option<String>,
}

impl Monitor {
    pub(super) fn new(json: bool) -> Self {
        Self {
            json,
            is_terminal: std::io::stderr().is_terminal(),
            shown: None,
            before: (0, Instant::now()),
            rate: 0.0,
            words: None,
            drawn: false,
            closed: false,
            disk: None,
        }
    }

    /// Whether nobody reads the lines any more.
    pub(super) fn is_closed(&self) -> bool {
        self.closed
    }

    pub(super) fn estimate(&mut self, told: &Told, health: &Health) {
        self.line(told);
        self.words = Some(words(&told.estimate));
        self.redraw(health);
    }

    /// The line of JSON, where it is asked for.
    pub(super) fn line(&mut self, told: &Told) {
        if self.json {
            self.closed |= writeln!(std::io::stdout(), "{}", plain(&told.line)).is_err();
        }
    }

    /// The next motion: a line of JSON, or words.
    pub(super) fn plan(&mut self, answer: &Answer) {
        let Some(plan) = &answer.plan else { return };
        if self.json {
            self.closed |= writeln!(std::io::stdout(), "{}", plan_json(answer.t, plan)).is_err();
            return;
        }
        self.clear();
        let way = plan
            .next
            .as_ref()
            .map_or_else(String::new, |next| format!("; {}; stop {}", waypoints(&next.motion), where_to_stop(next)));
        let _ = writeln!(std::io::stderr(), "plan: {}{way}", plain(&plan.words()));
    }

    /// The map so far: a line of JSON, or the words of the line.
    pub(super) fn map(&mut self, answer: &mapping::Answer) {
        if self.json {
            self.closed |= writeln!(std::io::stdout(), "{}", answer.line()).is_err();
        }
        self.words = Some(answer.words.clone());
    }

    pub(super) fn notice(&mut self, notice: &Notice) {
        self.clear();
        // Standard error may be closed.
        let _ = writeln!(
            std::io::stderr(),
            "{}",
            plain(&format!("{}: {}", notice.source, printable(&notice.text, LONGEST_NOTICE)))
        );
    }

    pub(super) fn idle(&mut self, health: &Health) {
        // Where lines do not replace each other nothing new is said.
        if self.is_terminal {
            self.redraw(health);
        }
    }

    fn redraw(&mut self, health: &Health) {
        if health.disk != self.disk && !self.json {
            self.disk.clone_from(&health.disk);
            self.clear();
            let _ = match &self.disk {
                Some(reason) => writeln!(std::io::stderr(), "recording: {reason}; it waits in memory, trying again"),
                None => writeln!(std::io::stderr(), "recording: the disk takes it again"),
            };
        }
        let period = if self.is_terminal { REDRAW } else { NEW_LINE };
        if self.shown.is_some_and(|shown| shown.elapsed() < period) || (self.json && !self.is_terminal) {
            return;
        }
        self.shown = Some(Instant::now());
        let (rows, since) = self.before;
        let passed = since.elapsed().as_secs_f64();
        if passed >= 1.0 {
            self.rate = (health.rows - rows) as f64 / passed;
            self.before = (health.rows, Instant::now());
        }
        let missing: u64 = health.sources.iter().map(|(_, counts)| counts.missing()).sum();
        let mut line = format!(
            "{} | {:.0} rows/s, {missing} frames missing, pose within {:.1} ms (99 %)",
            self.words.clone().unwrap_or_else(|| waiting(health)),
            self.rate,
            1e3 * health.latency.quantile(0.99)
        );
        if health.merged + health.dropped > 0 {
            let _ = write!(line, ", {} merged, {} not recorded", health.merged, health.dropped);
        }
        let mut out = std::io::stderr();
        let _ = if self.is_terminal { write!(out, "\r\x1b[2K{line}") } else { writeln!(out, "{line}") };
        let _ = out.flush();
        self.drawn = self.is_terminal;
    }

    /// Ends the line.
    pub(super) fn end(&mut self) {
        self.clear();
    }

    fn clear(&mut self) {
        if core::mem::take(&mut self.drawn) {
            let _ = write!(std::io::stderr(), "\r\x1b[2K");
        }
    }
}

/// A plan as a line of JSON: `t` (s) is when the robot came to rest, `plan` is as in plan.json.
pub(super) fn plan_json(t: f64, plan: &Plan) -> String {
    json!({ "t": t, "plan": to_json(plan) }).to_string()
}

/// The sources of which nothing could be read yet.
fn silent(health: &Health) -> Vec<&str> {
    health.sources.iter().filter(|(_, counts)| counts.frames == 0).map(|(name, _)| name.as_str()).collect()
}

/// What is seen before the first row.
fn waiting(health: &Health) -> String {
    match silent(health).as_slice() {
        [] => "waiting for the first row".to_owned(),
        names => format!("waiting for the first row: nothing that can be read from {}", names.join(", ")),
    }
}

/// The estimate at the end, in words; where nothing was estimated, why.
pub(super) fn verdict(estimate: &Estimate, health: &Health) -> String {
    if health.rows > 0 {
        return format!("{}\n", words(estimate));
    }
    match silent(health).as_slice() {
        [] => "no row came: readings and odometry lie too far apart in time to be joined\n".to_owned(),
        names => format!("no row came: nothing that could be read from {}\n", names.join(", ")),
    }
}

/// What became of everything that arrived, in words.
pub(super) fn account(health: &Health, histogram: bool, makes_map: bool) -> String {
    let mut text = String::new();
    for (name, counts) in &health.sources {
        text.push_str(&source(name, counts));
    }
    if health.rows == 0 {
        return text;
    }
    let (latency, age) = (&health.latency, &health.age);
    let ms = |seconds: f64| 1e3 * seconds;
    // Writing into a string cannot fail.
    let _ = writeln!(
        text,
        "  rows: {} used, {} merged into others, {} refused; from the last byte to the {} {:.2} ms in the median, \
         {:.2} ms for 99 %, {:.1} ms at most{}",
        health.rows,
        health.merged,
        health.refused,
        if makes_map { "row" } else { "pose" },
        ms(latency.quantile(0.5)),
        ms(latency.quantile(0.99)),
        ms(latency.largest()),
        if age.count() > 0 {
            format!("; from the measurement {:.1} ms in the median", ms(age.quantile(0.5)))
        } else {
            String::new()
        },
    );
    if health.carried > 0 {
        let _ = writeln!(
            text,
            "  of {} rows odometry told the pose first, from the estimate before; they were estimated {:.1} ms after the last byte for 99 %",
            health.carried,
            ms(health.taken.quantile(0.99))
        );
    }
    if health.dropped > 0 {
        let _ = writeln!(text, "  recording: {} messages dropped, because the disk was too slow", health.dropped);
    }
    if histogram {
        text.push_str("\nlatency up to (ms)   rows\n");
        for (end, count) in latency.buckets() {
            let _ = writeln!(text, "{:>18.4} {count:>6}", ms(end));
        }
    }
    text
}

fn source(name: &str, counts: &Counts) -> String {
    let words = counts.words();
    let mended = if words.is_empty() { "nothing missing".to_owned() } else { words };
    format!("  {name}: {} frames in {} bytes; {mended}\n", counts.frames, counts.bytes)
}

/// Prints words, unless JSON was asked for.
pub(super) fn say(json: bool, text: &str) -> vibrissa::Result<()> {
    if json { Ok(()) } else { print(text) }
}
