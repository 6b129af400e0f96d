//! Commands to a sensor head, and what it answers.

use super::link::{Link, serial_remedy};
use super::serial::SerialPort;
use crate::{Error, Result};
use std::path::Path;
use std::time::{Duration, Instant};
use vibrissa_head::Damage;
use vibrissa_head::LONGEST;
use vibrissa_head::command::{Command, RATES, Refusal};
use vibrissa_head::frame::{Identity, Message, Reading};

/// How long one look for bytes takes.
const LOOK: Duration = Duration::from_millis(50);

/// A sensor head on a serial port that nobody else reads.
pub struct HeadPort {
    port: SerialPort,
    name: String,
    patience: Duration,
    /// Bytes since the last zero.
    pending: Vec<u8>,
}

impl core::fmt::Debug for HeadPort {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("HeadPort").field("name", &self.name).finish_non_exhaustive()
    }
}

impl HeadPort {
    /// Opens the port of a head; each answer is waited for that long.
    ///
    /// # Errors
    ///
    /// A port that is not there, or that another program reads.
    pub fn open(port: &Path, baud: u32, patience: Duration) -> Result<Self> {
        let name = port.display().to_string();
        let opened = SerialPort::open(port, baud, &mut None).map_err(|error| {
            Error::data(format!("cannot open the port ({error})")).in_file(&name).remedy(serial_remedy(&error))
        })?;
        Ok(Self { port: opened, name, patience, pending: Vec::new() })
    }

    /// Who is there.
    ///
    /// # Errors
    ///
    /// No answer, or another one.
    pub fn identify(&mut self) -> Result<Identity> {
        match self.ask(&Command::Identify)? {
            Message::Identity(identity) => Ok(identity),
            _ => Err(self.fault("the head did not say who it is")),
        }
    }

    /// Tells a command and waits until it is done.
    ///
    /// # Errors
    ///
    /// No answer, or a refusal with its reason.
    pub fn tell(&mut self, command: &Command) -> Result<()> {
        match self.ask(command)? {
            Message::Refused(refusal) => Err(self.refused(refusal)),
            _ => Ok(()),
        }
    }

    /// The next readings, so many; what is damaged on the way is passed over.
    ///
    /// # Errors
    ///
    /// No reading for as long as an answer is waited for.
    pub fn readings(&mut self, count: usize) -> Result<Vec<Reading>> {
        let mut readings = Vec::new();
        let mut end = Instant::now() + self.patience;
        while readings.len() < count && Instant::now() < end {
            let before = readings.len();
            self.look(&mut |message| {
                if let Ok(Message::Reading(reading)) = message {
                    readings.push(reading);
                }
            })?;
            if readings.len() > before {
                end = Instant::now() + self.patience;
            }
        }
        if readings.len() < count {
            return Err(self
                .fault("the head sends no readings")
                .value(format!("{} in all, then none for {} s", readings.len(), self.patience.as_secs_f64()))
                .remedy("is the chip wired, and at the address that the firmware asks? docs/sensor-head.md"));
        }
        readings.truncate(count);
        Ok(readings)
    }

    /// Hands over the messages that have come, after a short wait for them.
    fn look(&mut self, each: &mut dyn FnMut(core::result::Result<Message, Damage>)) -> Result<()> {
        let mut bytes = [0; 4096];
        let read = self.port.read(&mut bytes, LOOK).map_err(|error| gone(&self.name, &error))?;
        for byte in &bytes[..read.unwrap_or(0)] {
            if *byte != 0 {
                // What is no packet of a head ends nowhere.
                if self.pending.len() <= LONGEST {
                    self.pending.push(*byte);
                }
                continue;
            }
            each(Message::read(&self.pending));
            self.pending.clear();
        }
        Ok(())
    }

    /// The head's answer to a command; readings in between are passed over.
    fn ask(&mut self, command: &Command) -> Result<Message> {
        let mut packet = [0; LONGEST + 1];
        // A zero ahead ends what another program may have left half written.
        let length = command.write(&mut packet[1..]).ok_or_else(|| self.fault("the command is too long"))?;
        let sent = self.port.write_all(&packet[..=length], self.patience);
        sent.map_err(|error| gone(&self.name, &error))?;
        let end = Instant::now() + self.patience;
        let mut is_damaged = false;
        while Instant::now() < end {
            let mut answer = None;
            // What was half written before is refused, too: that answer is not to this command, if another one comes.
            self.look(&mut |message| match message {
                Ok(Message::Refused(Refusal::Damaged)) => is_damaged = true,
                Ok(Message::Reading(_) | Message::Health(_)) | Err(_) => {}
                Ok(message) => answer = answer.or(Some(message)),
            })?;
            if let Some(answer) = answer {
                return Ok(answer);
            }
        }
        if is_damaged {
            return Err(self.refused(Refusal::Damaged));
        }
        let waited = self.patience.as_secs_f64();
        Err(self
            .fault("no answer of a sensor head")
            .value(format!("within {waited} s"))
            .remedy("is its firmware vibrissa's, and the port the head's? docs/sensor-head.md"))
    }

    fn fault(&self, what: &str) -> Error {
        Error::data(what).in_file(&self.name)
    }

    fn refused(&self, refusal: Refusal) -> Error {
        let fault = |what: &str| self.fault(&format!("the head refuses: {what}"));
        match refusal {
            Refusal::Range => fault("a number is out of its range").allowed(format!(
                "{} to {} readings a second, 1 reading or more to tare",
                RATES.start(),
                RATES.end()
            )),
            Refusal::Uncalibrated => fault("it has no calibration whose rest could be set")
                .remedy("load one first: `vibrissa sensor head PORT --load cal.json`"),
            Refusal::TooFast => fault("its chip does not convert so fast").remedy("take a lower --rate"),
            Refusal::Damaged => fault("the command was damaged on its way").remedy("try again"),
        }
    }
}

fn gone(name: &str, error: &std::io::Error) -> Error {
    Error::data(format!("the port is gone ({error})")).in_file(name).remedy("plug the head in again")
}
