//! Topics of a ROS 2 system, as lines that the program `vibrissa-ros2` makes of their messages: a DDS is a hundred crates, and stays a
//! program of its own.

use super::link::Link;
use std::collections::VecDeque;
use std::io::{Error, ErrorKind, Read, Result};
use std::path::PathBuf;
use std::process::{Child, ChildStderr, ChildStdout, Command, Stdio};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// The program's name.
const PROGRAM: &str = "vibrissa-ros2";
/// The end of what it says about a fault, which is told on (bytes).
const SAID: usize = 4096;
/// How long its last words may take after its last line.
const LAST_WORDS: Duration = Duration::from_millis(500);
/// How often they are looked for.
const LOOK: Duration = Duration::from_millis(10);

/// What a topic's messages are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ros2Message {
    /// `nav_msgs/Odometry`.
    Odometry,
    /// `sensor_msgs/JointState`: positions named as columns of a log, or moments (N m) as efforts named as whiskers.
    Joints,
    /// `std_msgs/Float64MultiArray`: numbers in the order of the setup's columns, timed by their arrival.
    Array,
    /// `geometry_msgs/WrenchStamped`: the moment about z.
    Wrench,
}

impl Ros2Message {
    /// Every kind.
    pub const ALL: [Self; 4] = [Self::Odometry, Self::Joints, Self::Array, Self::Wrench];

    /// The word that names it.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Odometry => "odometry",
            Self::Joints => "joints",
            Self::Array => "array",
            Self::Wrench => "wrench",
        }
    }

    /// The columns of its lines; none where a header line, or the setup, says them.
    #[must_use]
    pub fn columns(self) -> Option<Vec<String>> {
        let names: &[&str] = match self {
            Self::Odometry => &["t", "x", "y", "theta"],
            Self::Wrench => &["t", "moment"],
            Self::Joints | Self::Array => return None,
        };
        Some(names.iter().map(|&name| name.to_owned()).collect())
    }
}

/// The program while it runs; it ends when its standard input closes.
pub(super) struct Ros2Lines {
    child: Child,
    lines: ChildStdout,
    /// The end of what it said.
    said: Arc<Mutex<VecDeque<u8>>>,
    /// Sets it while the program runs: a pipe that nobody reads would stop the program.
    listener: std::thread::JoinHandle<()>,
}

/// Reads to the end, and keeps the last of it.
fn listen(mut errors: ChildStderr, said: &Mutex<VecDeque<u8>>) {
    let mut buffer = [0; 512];
    while let Ok(count @ 1..) = errors.read(&mut buffer) {
        let mut said = said.lock().unwrap_or_else(PoisonError::into_inner);
        said.extend(&buffer[..count]);
        let old = said.len().saturating_sub(SAID);
        said.drain(..old);
    }
}

impl Ros2Lines {
    /// Starts the program beside this one, or that of the search path.
    pub(super) fn open(topic: &str, message: Ros2Message) -> Result<Self> {
        let mut child = Command::new(program())
            .args(["--lines", message.as_str(), topic])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()?;
        let lines = child.stdout.take().ok_or_else(|| Error::from(ErrorKind::BrokenPipe))?;
        let errors = child.stderr.take().ok_or_else(|| Error::from(ErrorKind::BrokenPipe))?;
        let said = Arc::new(Mutex::default());
        let theirs = Arc::clone(&said);
        let listener = std::thread::spawn(move || listen(errors, &theirs));
        Ok(Self { child, lines, said, listener })
    }

    /// Why the program ended, in its own last words; what it started may hold its standard error open for longer.
    fn last_words(&mut self) -> Error {
        let begun = Instant::now();
        while !self.listener.is_finished() && begun.elapsed() < LAST_WORDS {
            std::thread::sleep(LOOK);
        }
        let said: Vec<u8> = self.said.lock().unwrap_or_else(PoisonError::into_inner).iter().copied().collect();
        let words = String::from_utf8_lossy(&said);
        let words = words.trim().replace("\n  help: ", "; ").replace('\n', " ");
        Error::other(if words.is_empty() { format!("{PROGRAM} ended") } else { format!("{PROGRAM}: {words}") })
    }
}

impl Drop for Ros2Lines {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Link for Ros2Lines {
    fn read(&mut self, buffer: &mut [u8], patience: Duration) -> Result<Option<usize>> {
        if !super::link::readable(&self.lines, patience)? {
            return Ok(None);
        }
        match Read::read(&mut self.lines, buffer) {
            Ok(0) => Err(self.last_words()),
            Ok(count) => Ok(Some(count)),
            Err(error) if error.kind() == ErrorKind::Interrupted => Ok(None),
            Err(error) => Err(error),
        }
    }
}

fn program() -> PathBuf {
    let beside = std::env::current_exe().ok().and_then(|path| Some(path.parent()?.join(PROGRAM)));
    beside.filter(|path| path.is_file()).unwrap_or_else(|| PathBuf::from(PROGRAM))
}
