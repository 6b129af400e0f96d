//! Topics of a ROS 2 system, as lines that the program `vibrissa-ros2` makes of their messages: a DDS is a hundred crates, and stays a
//! program of its own.

use super::link::Link;
use std::io::{Error, ErrorKind, Read, Result};
use std::path::PathBuf;
use std::process::{Child, ChildStdout, Command, Stdio};
use std::time::Duration;

/// The program's name.
const PROGRAM: &str = "vibrissa-ros2";
/// Most of what it says about a fault that is told on (bytes).
const SAID: u64 = 4096;

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
        Ok(Self { child, lines })
    }

    /// Why the program ended, in its own last words.
    fn last_words(&mut self) -> Error {
        let mut said = String::new();
        if let Some(errors) = self.child.stderr.take() {
            // What it says may be no text.
            let _ = errors.take(SAID).read_to_string(&mut said);
        }
        let words = said.trim().replace("\n  help: ", "; ").replace('\n', " ");
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
