//! Links that can be opened and read with patience.

use super::playback::Playback;
use super::ros2::{Ros2Lines, Ros2Message};
use std::fs::File;
use std::io::{ErrorKind, Read, Result};
use std::net::{TcpStream, ToSocketAddrs, UdpSocket};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// How long a connection may take (s).
const CONNECT: Duration = Duration::from_secs(2);

/// Where a source's bytes come from.
#[derive(Clone, Debug, PartialEq)]
pub enum Wire {
    /// A serial port and its baud rate.
    Serial {
        /// `/dev/ttyACM0` or a name in `/dev/serial/by-id`.
        port: PathBuf,
        /// Bits a second.
        baud: u32,
    },
    /// The address `host:port` of a stream socket.
    Tcp(String),
    /// The address `host:port` at which datagrams are received.
    Udp(String),
    /// A Unix stream socket.
    Unix(PathBuf),
    /// A named pipe or a file; `-` is standard input.
    Pipe(PathBuf),
    /// A topic of a ROS 2 system, through the program `vibrissa-ros2`.
    Ros2 {
        /// Its name.
        topic: String,
        /// What its messages are.
        message: Ros2Message,
    },
    /// A log that is played in real time.
    Played(Playback),
}

impl Wire {
    /// Whether it ends for good when its other side closes.
    #[must_use]
    pub fn ends(&self) -> bool {
        matches!(self, Self::Pipe(_) | Self::Played(_))
    }

    /// Reads the file that it plays, so that faults are told before anything begins.
    ///
    /// # Errors
    ///
    /// As [`Playback::load`].
    pub fn load(&mut self) -> crate::Result<()> {
        match self {
            Self::Played(playback) => playback.load(),
            _ => Ok(()),
        }
    }

    /// Whether trying again would meet the same fault.
    pub(super) fn is_lasting(&self) -> bool {
        matches!(self, Self::Played(_))
    }

    /// Whether it can begin in the middle of a line.
    #[must_use]
    pub fn may_be_torn(&self) -> bool {
        matches!(self, Self::Serial { .. })
    }

    /// Whether it is a file on the disk, which waits until it is read.
    #[must_use]
    pub fn is_file(&self) -> bool {
        let Self::Pipe(path) = self else { return false };
        let path = if path.as_os_str() == "-" { Path::new("/dev/stdin") } else { path };
        std::fs::metadata(path).is_ok_and(|data| data.is_file())
    }

    /// What else to check where lines do not come as they were sent.
    pub(crate) fn also_to_check(&self) -> &'static str {
        match self {
            Self::Serial { .. } => ", and that one device alone sends on this port",
            Self::Udp(_) => ", since a network may drop datagrams and turn their order around",
            _ => "",
        }
    }

    pub(super) fn is_datagrams(&self) -> bool {
        matches!(self, Self::Udp(_))
    }

    /// The name for words.
    #[must_use]
    pub fn shown(&self) -> String {
        match self {
            Self::Serial { port, baud } => format!("{} at {baud} baud", port.display()),
            Self::Tcp(address) => format!("tcp {address}"),
            Self::Udp(address) => format!("udp {address}"),
            Self::Unix(path) => format!("the socket {}", path.display()),
            Self::Pipe(path) if path.as_os_str() == "-" => "standard input".to_owned(),
            Self::Pipe(path) => path.display().to_string(),
            Self::Ros2 { topic, .. } => format!("the topic {topic}"),
            Self::Played(playback) => playback.path.display().to_string(),
        }
    }

    /// Opens it; why it cannot be, and what to do. `remembered` is kept between the calls for one wire.
    pub(super) fn open(&self, remembered: &mut Option<PathBuf>) -> core::result::Result<Box<dyn Link>, String> {
        let told = |error: std::io::Error| self.cannot_open(&error);
        match self {
            Self::Serial { port, baud } => open_serial(port, *baud, remembered).map_err(told),
            Self::Tcp(address) => connect(address).map(|stream| Box::new(stream) as Box<dyn Link>).map_err(told),
            Self::Udp(address) => {
                UdpSocket::bind(address).map(|socket| Box::new(socket) as Box<dyn Link>).map_err(told)
            }
            Self::Unix(path) => open_unix(path).map_err(told),
            Self::Pipe(path) if path.as_os_str() == "-" => Ok(Box::new(StandardInput)),
            Self::Pipe(path) => File::open(path).map(|file| Box::new(file) as Box<dyn Link>).map_err(told),
            Self::Ros2 { topic, message } => {
                Ros2Lines::open(topic, *message).map(|lines| Box::new(lines) as Box<dyn Link>).map_err(told)
            }
            Self::Played(playback) => {
                let player = playback.open().map(|player| Box::new(player) as Box<dyn Link>);
                player.map_err(|error| error.to_string().replace("\n  help: ", "; "))
            }
        }
    }

    fn cannot_open(&self, error: &std::io::Error) -> String {
        let remedy = match (self, error.kind()) {
            (Self::Serial { .. }, _) => serial_remedy(error),
            (Self::Tcp(_) | Self::Unix(_), _) => "the other side has to listen there",
            (Self::Ros2 { .. }, _) => {
                "it needs the program vibrissa-ros2 beside this one or on the search path: \
                 `cargo build --release --manifest-path ros2/Cargo.toml` makes it"
            }
            (Self::Udp(_), _) => "another program may have the address; choose another port",
            _ => "check path and permissions",
        };
        format!("cannot open {}: {error}; {remedy}; trying again", self.shown())
    }
}

/// Something open.
pub(super) trait Link {
    /// Reads bytes; none where there are none for so long, 0 at the end.
    fn read(&mut self, buffer: &mut [u8], patience: Duration) -> Result<Option<usize>>;
}

/// None where an error only says that there is nothing yet.
fn patient(read: Result<usize>) -> Result<Option<usize>> {
    match read {
        Ok(count) => Ok(Some(count)),
        Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted) => {
            Ok(None)
        }
        Err(error) => Err(error),
    }
}

/// What to do about a serial port that cannot be opened.
pub(super) fn serial_remedy(error: &std::io::Error) -> &'static str {
    match error.kind() {
        ErrorKind::PermissionDenied => {
            "add yourself to the group of the port (`ls -l` shows it, often dialout) and log in again"
        }
        ErrorKind::NotFound => "is the device plugged in? `ls /dev/serial/by-id` lists those that are",
        ErrorKind::ResourceBusy => "another program has it open; close that",
        _ if is_no_terminal(error) => "that is no serial port; `ls /dev/serial/by-id` lists those that are there",
        _ => "check the cable and the name",
    }
}

/// Whether a system of Unix says that what was opened is no terminal, so that it has no baud rate.
fn is_no_terminal(error: &std::io::Error) -> bool {
    /// `ENOTTY`, on Linux and macOS.
    const NO_TERMINAL: i32 = 25;
    cfg!(unix) && error.raw_os_error() == Some(NO_TERMINAL)
}

fn connect(address: &str) -> Result<TcpStream> {
    let mut last = std::io::Error::new(ErrorKind::NotFound, "no such host");
    for one in address.to_socket_addrs()? {
        match TcpStream::connect_timeout(&one, CONNECT) {
            Ok(stream) => return Ok(stream),
            Err(error) => last = error,
        }
    }
    Err(last)
}

impl Link for TcpStream {
    fn read(&mut self, buffer: &mut [u8], patience: Duration) -> Result<Option<usize>> {
        self.set_read_timeout(Some(patience))?;
        patient(Read::read(self, buffer))
    }
}

impl Link for UdpSocket {
    fn read(&mut self, buffer: &mut [u8], patience: Duration) -> Result<Option<usize>> {
        self.set_read_timeout(Some(patience))?;
        // An empty datagram is no end.
        Ok(patient(self.recv(buffer))?.filter(|count| *count > 0))
    }
}

/// A regular file is read as fast as it is taken; a pipe where it can be waited for, with patience.
impl Link for File {
    fn read(&mut self, buffer: &mut [u8], patience: Duration) -> Result<Option<usize>> {
        if !readable(self, patience)? {
            return Ok(None);
        }
        patient(Read::read(self, buffer))
    }
}

/// Standard input without a buffer of our own: what waits in one could not be waited for.
struct StandardInput;

impl Link for StandardInput {
    #[cfg(unix)]
    fn read(&mut self, buffer: &mut [u8], patience: Duration) -> Result<Option<usize>> {
        let input = std::io::stdin();
        if !readable(&input, patience)? {
            return Ok(None);
        }
        patient(rustix::io::read(&input, buffer).map_err(Into::into))
    }

    #[cfg(not(unix))]
    fn read(&mut self, buffer: &mut [u8], _: Duration) -> Result<Option<usize>> {
        patient(std::io::stdin().lock().read(buffer))
    }
}

#[cfg(unix)]
pub(super) use super::serial::readable;

#[cfg(not(unix))]
pub(super) fn readable<T>(_: &T, _: Duration) -> Result<bool> {
    Ok(true)
}

#[cfg(unix)]
fn open_serial(port: &Path, baud: u32, remembered: &mut Option<PathBuf>) -> Result<Box<dyn Link>> {
    super::serial::SerialPort::open(port, baud, remembered).map(|port| Box::new(port) as Box<dyn Link>)
}

#[cfg(not(unix))]
fn open_serial(_: &Path, _: u32, _: &mut Option<PathBuf>) -> Result<Box<dyn Link>> {
    Err(std::io::Error::new(
        ErrorKind::Unsupported,
        "serial ports are read on Linux and macOS; here use tcp, udp or a pipe",
    ))
}

#[cfg(unix)]
impl Link for std::os::unix::net::UnixStream {
    fn read(&mut self, buffer: &mut [u8], patience: Duration) -> Result<Option<usize>> {
        self.set_read_timeout(Some(patience))?;
        patient(Read::read(self, buffer))
    }
}

#[cfg(unix)]
fn open_unix(path: &Path) -> Result<Box<dyn Link>> {
    std::os::unix::net::UnixStream::connect(path).map(|stream| Box::new(stream) as Box<dyn Link>)
}

#[cfg(not(unix))]
fn open_unix(_: &Path) -> Result<Box<dyn Link>> {
    Err(std::io::Error::new(ErrorKind::Unsupported, "sockets with a path are a thing of Unix; here use tcp"))
}
