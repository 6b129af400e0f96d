//! Serial ports and pseudo-terminals.

use super::link::Link;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::{Mode, OFlags, fcntl_setfl, open};
use rustix::io::Errno;
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{ControlModes, OptionalActions, SpecialCodeIndex, tcgetattr, tcsetattr};
use std::fs::File;
use std::io::{ErrorKind, Read, Result, Write};
use std::os::fd::AsFd;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// How long a pseudo-terminal waits for room where nobody reads its port.
const ROOM: Duration = Duration::from_secs(5);

/// Where Linux names ports after their devices: these names stay when a device is plugged in again.
const BY_ID: &str = "/dev/serial/by-id";

/// An open serial port.
pub(super) struct SerialPort(File);

impl SerialPort {
    /// Opens a port; one that was open before is found again under its device's name.
    pub(super) fn open(port: &Path, baud: u32, remembered: &mut Option<PathBuf>) -> Result<Self> {
        let opened = match (open_raw(port, baud), remembered.as_ref()) {
            (Err(_), Some(device)) => open_raw(device, baud)?,
            (opened, _) => opened?,
        };
        if remembered.is_none() {
            *remembered = device_name(port);
        }
        Ok(Self(opened))
    }
}

impl Link for SerialPort {
    fn read(&mut self, buffer: &mut [u8], patience: Duration) -> Result<Option<usize>> {
        if !readable(&self.0, patience)? {
            return Ok(None);
        }
        match Read::read(&mut self.0, buffer) {
            Ok(count) => Ok(Some(count)),
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted) => Ok(None),
            Err(error) => Err(error),
        }
    }
}

impl SerialPort {
    /// Writes all bytes, as long as room for some comes within `patience` each time.
    pub(super) fn write_all(&mut self, bytes: &[u8], patience: Duration) -> Result<()> {
        write_all(&mut self.0, bytes, patience)
    }
}

/// Writes all bytes to a file that does not block, as long as room for some comes within `patience` each time.
fn write_all(file: &mut File, mut bytes: &[u8], patience: Duration) -> Result<()> {
    let limit = Timespec { tv_sec: patience.as_secs() as i64, tv_nsec: patience.subsec_nanos().into() };
    while !bytes.is_empty() {
        if poll(&mut [PollFd::new(file, PollFlags::OUT)], Some(&limit))? == 0 {
            return Err(ErrorKind::TimedOut.into());
        }
        match file.write(bytes) {
            Ok(count) => bytes = &bytes[count..],
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted) => {}
            Err(error) => return Err(error),
        }
    }
    Ok(())
}

/// Whether there are bytes, or an end, within so long.
pub(super) fn readable(link: &impl AsFd, patience: Duration) -> Result<bool> {
    let mut fds = [PollFd::new(link, PollFlags::IN)];
    let patience = Timespec { tv_sec: patience.as_secs() as i64, tv_nsec: patience.subsec_nanos().into() };
    match poll(&mut fds, Some(&patience)) {
        Ok(count) => Ok(count > 0),
        Err(Errno::INTR) => Ok(false),
        Err(error) => Err(error.into()),
    }
}

/// A port with all bytes as they are: no echo, no line editing, no flow control.
fn open_raw(path: &Path, baud: u32) -> Result<File> {
    let fd = open(path, OFlags::RDWR | OFlags::NOCTTY | OFlags::NONBLOCK | OFlags::CLOEXEC, Mode::empty())?;
    // Two readers would share the bytes between them.
    rustix::termios::ioctl_tiocexcl(&fd)?;
    let mut modes = tcgetattr(&fd)?;
    modes.make_raw();
    modes.control_modes |= ControlModes::CREAD | ControlModes::CLOCAL;
    modes.special_codes[SpecialCodeIndex::VMIN] = 1;
    modes.special_codes[SpecialCodeIndex::VTIME] = 0;
    modes.set_speed(baud)?;
    tcsetattr(&fd, OptionalActions::Now, &modes)?;
    Ok(File::from(fd))
}

/// The name of a port's device that stays when it is plugged in again, where there is one.
fn device_name(port: &Path) -> Option<PathBuf> {
    let target = port.canonicalize().ok()?;
    let entries = std::fs::read_dir(BY_ID).ok()?;
    entries.filter_map(|entry| Some(entry.ok()?.path())).find(|name| name.canonicalize().ok().as_ref() == Some(&target))
}

/// The other end of a serial port that does not exist: what is written here is read from [`PseudoTerminal::port`].
#[derive(Debug)]
pub struct PseudoTerminal {
    device: File,
    port: PathBuf,
}

impl PseudoTerminal {
    /// A new pair.
    ///
    /// # Errors
    ///
    /// The system has none left.
    pub fn new() -> Result<Self> {
        let device = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY)?;
        // A port that nobody reads fills, and a write that blocks would never return.
        fcntl_setfl(&device, OFlags::RDWR | OFlags::NONBLOCK)?;
        grantpt(&device)?;
        unlockpt(&device)?;
        let name = ptsname(&device, Vec::new())?;
        let port = PathBuf::from(name.to_string_lossy().into_owned());
        // Raw from the start, so that nothing is echoed before the port is opened.
        let mut modes = tcgetattr(&device)?;
        modes.make_raw();
        tcsetattr(&device, OptionalActions::Now, &modes)?;
        Ok(Self { device: File::from(device), port })
    }

    /// The port that reads what is written here.
    #[must_use]
    pub fn port(&self) -> &Path {
        &self.port
    }

    /// The bytes that were written to the port, as many as came within so long and fit; none where none came.
    ///
    /// # Errors
    ///
    /// The pair is gone, or nobody has the port open any more.
    pub fn receive(&mut self, buffer: &mut [u8], patience: Duration) -> Result<usize> {
        if readable(&self.device, patience)? { Read::read(&mut self.device, buffer) } else { Ok(0) }
    }

    /// Writes bytes as a device would. Where nobody reads and the port's buffer is full, this waits for room, at most 5 s.
    ///
    /// # Errors
    ///
    /// The pair is gone, or no room came.
    pub fn send(&mut self, bytes: &[u8]) -> Result<()> {
        write_all(&mut self.device, bytes, ROOM)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_port_that_nobody_reads_does_not_hold_its_device_for_ever() {
        let mut terminal = PseudoTerminal::new().unwrap();
        let told =
            (0..10_000).find_map(|_| write_all(&mut terminal.device, &[b'x'; 100], Duration::from_millis(20)).err());
        assert_eq!(told.unwrap().kind(), ErrorKind::TimedOut);
        // Whoever opens the port reads what was kept, and there is room again.
        let mut port = SerialPort::open(terminal.port(), 115_200, &mut None).unwrap();
        let mut bytes = [0; 4096];
        while port.read(&mut bytes, Duration::from_millis(50)).unwrap().is_some() {}
        terminal.send(b"room").unwrap();
        assert_eq!(port.read(&mut bytes, Duration::from_secs(5)).unwrap(), Some(4));
    }
}
