//! Commands to a head over a serial port that does not exist: done, refused, drowned in readings, unanswered.

#![cfg(unix)]
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must fail")]

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{JoinHandle, sleep, spawn};
use std::time::Duration;
use vibrissa_core::sensing::Mlx90393;
use vibrissa_head::LONGEST;
use vibrissa_head::calibration::{Calibration, Response, Signal};
use vibrissa_head::chip::MlxDriver;
use vibrissa_head::command::Command;
use vibrissa_head::frame::{Message, Reading};
use vibrissa_head::head::Head;
use vibrissa_live::source::{HeadPort, PseudoTerminal};

/// A head on the other end: answers, with readings and rubbish in between.
struct Device {
    port: PathBuf,
    end: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Device {
    fn new(answers: bool) -> Self {
        let mut terminal = PseudoTerminal::new().unwrap();
        let (port, end) = (terminal.port().to_path_buf(), Arc::new(AtomicBool::new(false)));
        let until = Arc::clone(&end);
        let thread = spawn(move || {
            let mut head = Head::new(MlxDriver::new(0x0c, Mlx90393::default()), 300);
            let (mut bytes, mut packet, mut number) = ([0; 64], [0; LONGEST], 0);
            while !until.load(Ordering::Relaxed) {
                // Before and after, nobody has the port open: what is sent then would fill it.
                let Ok(count) = terminal.receive(&mut bytes, Duration::from_millis(5)) else {
                    sleep(Duration::from_millis(2));
                    continue;
                };
                let mut send = |message: &Message| {
                    let length = message.write(&mut packet).unwrap();
                    let _ = terminal.send(&packet[..length]);
                };
                number += 1;
                if number % 4 == 0 {
                    send(&Message::Reading(Reading { number, ..Reading::default() }));
                }
                for byte in &bytes[..count] {
                    if let Some(answer) = head.receive(*byte).filter(|_| answers) {
                        send(&answer);
                    }
                }
                if number % 7 == 0 {
                    let _ = terminal.send(b"not a packet\0");
                }
            }
        });
        Self { port, end, thread: Some(thread) }
    }

    fn open(&self) -> HeadPort {
        HeadPort::open(&self.port, 115_200, Duration::from_secs(5)).unwrap()
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        self.end.store(true, Ordering::Relaxed);
        self.thread.take().map(JoinHandle::join);
    }
}

fn both_axes() -> Calibration {
    let signal = |k: usize| {
        let mut direction = [0.1; 3];
        direction[k] = 8.0;
        Signal { direction, range: [1e-4, 0.02] }
    };
    Calibration { rest: [1e-4, 0.0, 6e-3], response: Response::Plane([signal(0), signal(1)], [[1e-3; 10]; 2]) }
}

#[test]
fn a_head_is_loaded_tared_and_set() {
    let device = Device::new(true);
    let mut head = device.open();
    let before = head.identify().unwrap();
    assert_eq!((before.calibrated_axes, before.rate), (0, 300));
    let told = head.tell(&Command::Tare(100)).unwrap_err().to_string();
    assert!(told.contains("no calibration") && told.contains("--load"), "{told}");
    head.tell(&Command::Load(both_axes())).unwrap();
    head.tell(&Command::Tare(100)).unwrap();
    head.tell(&Command::Rate(200)).unwrap();
    let after = head.identify().unwrap();
    assert_eq!((after.calibrated_axes, after.rate), (2, 200));
    let told = head.tell(&Command::Rate(5)).unwrap_err().to_string();
    assert!(told.contains("10 to 1000 readings a second"), "{told}");
    head.tell(&Command::Unload).unwrap();
    assert_eq!(head.identify().unwrap().calibrated_axes, 0);
}

#[test]
fn readings_are_taken_one_by_one() {
    let device = Device::new(true);
    let mut head = device.open();
    let readings = head.readings(25).unwrap();
    assert!(readings.len() == 25 && readings.windows(2).all(|pair| pair[1].number == pair[0].number + 4));
    // A port on which nobody sends.
    let silent = PseudoTerminal::new().unwrap();
    let mut head = HeadPort::open(silent.port(), 115_200, Duration::from_millis(200)).unwrap();
    let told = head.readings(2).unwrap_err().to_string();
    assert!(told.contains("no readings") && told.contains("wired"), "{told}");
}

#[test]
fn silence_and_missing_ports_are_told() {
    let device = Device::new(false);
    let mut head = HeadPort::open(&device.port, 115_200, Duration::from_millis(300)).unwrap();
    let told = head.identify().unwrap_err().to_string();
    assert!(told.contains("no answer") && told.contains("0.3 s"), "{told}");
    // Two programs would share the bytes between them.
    assert!(HeadPort::open(&device.port, 115_200, Duration::from_secs(1)).is_err() || is_root());
    for (port, words) in [("/dev/no-such-port", "plugged in"), ("/dev/null", "no serial port")] {
        let told = HeadPort::open(port.as_ref(), 115_200, Duration::from_secs(1)).unwrap_err().to_string();
        assert!(told.contains(port) && told.contains(words), "{told}");
    }
}

/// The superuser may open a port that is held.
fn is_root() -> bool {
    std::fs::metadata("/proc/self").is_ok_and(|own| std::os::unix::fs::MetadataExt::uid(&own) == 0)
}
