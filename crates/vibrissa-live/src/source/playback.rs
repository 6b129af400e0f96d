//! Logs that are played as if their rows came now.

use super::link::Link;
use crate::{Error, Result};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};
use vibrissa_core::flow::sensor_log::SensorLog;
use vibrissa_io::log::to_csv;
use vibrissa_sim::scenario::Scenario;

/// What is played.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Played {
    /// A log, `.csv` or `.mcap`; a recorded live run is one.
    Log,
    /// The log that a simulated robot makes along a scenario, `.toml`.
    Scenario,
}

impl Played {
    /// The key of the setup that names the file.
    #[must_use]
    pub fn key(self) -> &'static str {
        match self {
            Self::Log => "recording",
            Self::Scenario => "simulated",
        }
    }
}

/// A log that is played at its own or another speed, as lines of CSV with a header.
#[derive(Clone, Debug)]
pub struct Playback {
    /// What the file holds.
    pub kind: Played,
    /// The file.
    pub path: PathBuf,
    /// Times its own speed.
    pub speed: f64,
    log: Option<Arc<SensorLog>>,
}

impl PartialEq for Playback {
    fn eq(&self, other: &Self) -> bool {
        (self.kind, &self.path) == (other.kind, &other.path) && self.speed.total_cmp(&other.speed).is_eq()
    }
}

impl Playback {
    /// The playing of a file that is not read yet.
    #[must_use]
    pub fn new(kind: Played, path: impl AsRef<Path>, speed: f64) -> Self {
        Self { kind, path: path.as_ref().to_owned(), speed, log: None }
    }

    /// Reads the log, or simulates it, so that faults are told before anything begins.
    ///
    /// # Errors
    ///
    /// A file that cannot be read or is at fault, a log without rows, a path that the simulator cannot follow.
    pub fn load(&mut self) -> Result<()> {
        let log = match self.kind {
            Played::Log => vibrissa_io::read_log(&self.path)?,
            Played::Scenario => Scenario::read(&self.path)?.simulate()?.recording.log,
        };
        if log.rows.is_empty() {
            return Err(Error::data("the log has no rows to play").in_file(&self.path));
        }
        self.log = Some(Arc::new(log));
        Ok(())
    }

    /// Begins to play.
    pub(super) fn open(&self) -> Result<Player> {
        let mut loaded = self.clone();
        if loaded.log.is_none() {
            loaded.load()?;
        }
        let log = loaded.log.unwrap_or_default();
        let first = log.rows.first().map_or(0.0, |row| row.t);
        let due = |t: f64| Duration::try_from_secs_f64((t - first) / self.speed).unwrap_or_default();
        // The header comes with the first row.
        let due = core::iter::once(Duration::ZERO).chain(log.rows.iter().map(|row| due(row.t))).collect();
        Ok(Player { text: to_csv(&log).into_bytes(), due, sent: 0, ready: 0, line: 0, began: Instant::now() })
    }
}

/// A log on its way.
pub(super) struct Player {
    text: Vec<u8>,
    /// When each line is due, since the beginning.
    due: Vec<Duration>,
    /// Bytes that were handed over, bytes that are due, and lines in these.
    sent: usize,
    ready: usize,
    line: usize,
    began: Instant,
}

impl Link for Player {
    fn read(&mut self, buffer: &mut [u8], patience: Duration) -> std::io::Result<Option<usize>> {
        if self.sent == self.ready {
            let Some(due) = self.due.get(self.line) else { return Ok(Some(0)) };
            let wait = due.saturating_sub(self.began.elapsed());
            std::thread::sleep(wait.min(patience));
            if wait > patience {
                return Ok(None);
            }
            let now = self.began.elapsed();
            while self.due.get(self.line).is_some_and(|due| *due <= now) && self.ready - self.sent < buffer.len() {
                let rest = &self.text[self.ready..];
                self.ready += rest.iter().position(|&byte| byte == b'\n').map_or(rest.len(), |end| end + 1);
                self.line += 1;
            }
        }
        let count = (self.ready - self.sent).min(buffer.len());
        buffer[..count].copy_from_slice(&self.text[self.sent..self.sent + count]);
        self.sent += count;
        Ok(if count == 0 { None } else { Some(count) })
    }
}

#[cfg(test)]
mod tests {
    use super::{Link, Playback, Played};
    use std::sync::Arc;
    use std::time::{Duration, Instant};
    use vibrissa_core::flow::sensor_log::SensorLog;
    use vibrissa_io::log::{from_csv, to_csv};

    #[test]
    fn a_log_is_played_whole_and_never_before_its_time() {
        let rows: String = (0..200).map(|i| format!("{},0,0,0,{}\n", 7.0 + 0.01 * f64::from(i), i)).collect();
        let log: SensorLog = from_csv(&format!("t,x,y,theta,moment\n{rows}"), "log").unwrap();
        let playback = Playback { log: Some(Arc::new(log.clone())), ..Playback::new(Played::Log, "log.csv", 10.0) };
        // As small a buffer as cuts lines, and a large one.
        for size in [7, 4096] {
            let began = Instant::now();
            let mut player = playback.open().unwrap();
            let (mut got, mut buffer) = (Vec::new(), vec![0; size]);
            loop {
                match player.read(&mut buffer, Duration::from_millis(20)).unwrap() {
                    Some(0) => break,
                    Some(count) => got.extend(&buffer[..count]),
                    None => continue,
                }
                let lines = got.iter().filter(|&&byte| byte == b'\n').count();
                let newest = 1e-3 * lines.saturating_sub(2) as f64;
                assert!(began.elapsed().as_secs_f64() >= newest, "{lines} lines after {:?}", began.elapsed());
            }
            assert_eq!(String::from_utf8(got).unwrap(), to_csv(&log));
        }
    }
}
