//! Where bytes come from: a thread for each source, which opens it again when it goes away.
//!
//! | wire | what |
//! | --- | --- |
//! | `serial` | a serial port (Unix), raw, not shared with other programs |
//! | `tcp`, `unix` | a stream socket that is connected to |
//! | `udp` | datagrams; each ends its last line |
//! | `pipe` | standard input (`-`), a named pipe or a file |
//! | `ros2` | a topic of a ROS 2 system, through the program `vibrissa-ros2` |
//! | `recording`, `simulated` | a log, or one that a scenario makes, at its own or another speed |

#[cfg(unix)]
mod commands;
mod host_clock;
mod link;
mod playback;
mod ros2;
#[cfg(unix)]
mod serial;

#[cfg(unix)]
pub use commands::HeadPort;
pub use host_clock::HostClock;
pub use link::Wire;
pub use playback::{Playback, Played};
pub use ros2::Ros2Message;
#[cfg(unix)]
pub use serial::PseudoTerminal;

use crate::config::{READ_PATIENCE, READ_SIZE, REOPEN};
use link::Link;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::SyncSender;
use std::time::Duration;

/// What a source hands over.
#[derive(Clone, Debug, PartialEq)]
pub struct Chunk {
    /// The index of the source.
    pub source: usize,
    /// When it arrived (host, s).
    pub arrival: f64,
    /// What arrived.
    pub what: Arrived,
}

/// What can arrive.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Arrived {
    /// The source is open.
    Opened,
    /// Bytes.
    Bytes(Vec<u8>),
    /// The source went away, or cannot be opened: why. It will be opened again.
    Gone(String),
    /// The source has come to its end.
    Ended,
}

/// Reads a wire until it ends, `stop` is set or nobody listens any more; to be run on a thread of its own.
pub fn read_wire(source: usize, wire: &Wire, clock: &HostClock, out: &SyncSender<Chunk>, stop: &Arc<AtomicBool>) {
    let stopped = || stop.load(Ordering::Relaxed);
    let say = |what: Arrived| out.send(Chunk { source, arrival: clock.now(), what }).is_ok();
    let (mut told, mut remembered) = (None::<String>, None);
    while !stopped() {
        let mut link = match wire.open(&mut remembered) {
            Ok(link) => link,
            Err(reason) => {
                if told.as_ref() != Some(&reason) && !say(Arrived::Gone(reason.clone())) {
                    return;
                }
                if wire.is_lasting() {
                    say(Arrived::Ended);
                    return;
                }
                told = Some(reason);
                wait(REOPEN, &stopped);
                continue;
            }
        };
        told = None;
        if !say(Arrived::Opened) {
            return;
        }
        let Some(reason) = read_link(link.as_mut(), wire, &say, &stopped) else { return };
        if wire.ends() {
            say(Arrived::Ended);
            return;
        }
        if !say(Arrived::Gone(reason)) {
            return;
        }
        wait(REOPEN, &stopped);
    }
}

/// Reads an open link; why it went away, none where nobody wants to know.
fn read_link(
    link: &mut dyn Link,
    wire: &Wire,
    say: &dyn Fn(Arrived) -> bool,
    stopped: &dyn Fn() -> bool,
) -> Option<String> {
    let mut buffer = vec![0; READ_SIZE];
    let patience = Duration::from_secs_f64(READ_PATIENCE);
    while !stopped() {
        match link.read(&mut buffer, patience) {
            Ok(Some(0)) => return Some("the other side closed it".to_owned()),
            Ok(Some(count)) => {
                let mut bytes = buffer[..count].to_vec();
                if wire.is_datagrams() {
                    bytes.push(b'\n');
                }
                if !say(Arrived::Bytes(bytes)) {
                    return None;
                }
            }
            Ok(None) => {}
            Err(error) => return Some(error.to_string()),
        }
    }
    None
}

fn wait(seconds: f64, stopped: &dyn Fn() -> bool) {
    let steps = (seconds / READ_PATIENCE).ceil() as usize;
    for _ in 0..steps {
        if !stopped() {
            std::thread::sleep(Duration::from_secs_f64(READ_PATIENCE));
        }
    }
}
