//! Commands to a sensor head, and what it answers.

use super::link::Link;
use super::serial::SerialPort;
use crate::{Error, Result};
use std::path::Path;
use std::time::{Duration, Instant};
use vibrissa_head::LONGEST;
use vibrissa_head::command::{Command, RATES, Refusal};
use vibrissa_head::frame::{Identity, Message};

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
            Error::data(format!("cannot open the port ({error})"))
                .in_file(&name)
                .remedy("check the cable and the name; end a live run that reads it, and see who may open it")
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

    /// The head's answer to a command; readings in between are passed over.
    fn ask(&mut self, command: &Command) -> Result<Message> {
        let mut packet = [0; LONGEST + 1];
        // A zero ahead ends what another program may have left half written.
        let length = command.write(&mut packet[1..]).ok_or_else(|| self.fault("the command is too long"))?;
        let gone = |name: &str, error: std::io::Error| {
            Error::data(format!("the port is gone ({error})")).in_file(name).remedy("plug the head in again")
        };
        let sent = self.port.write_all(&packet[..=length], self.patience);
        sent.map_err(|error| gone(&self.name, error))?;
        let end = Instant::now() + self.patience;
        let (mut bytes, mut is_damaged) = ([0; 4096], false);
        while Instant::now() < end {
            let Some(count) = self.port.read(&mut bytes, LOOK).map_err(|error| gone(&self.name, error))? else {
                continue;
            };
            let mut answer = None;
            for byte in &bytes[..count] {
                if *byte != 0 {
                    // What is no packet of a head ends nowhere.
                    if self.pending.len() <= LONGEST {
                        self.pending.push(*byte);
                    }
                    continue;
                }
                let message = Message::read(&self.pending);
                self.pending.clear();
                // What was half written before is refused, too: that answer is not to this command, if another one comes.
                match message {
                    Ok(Message::Refused(Refusal::Damaged)) => is_damaged = true,
                    Ok(Message::Reading(_) | Message::Health(_)) | Err(_) => {}
                    Ok(message) => answer = answer.or(Some(message)),
                }
            }
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
