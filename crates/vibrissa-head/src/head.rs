//! One slot of the sampling clock after the other.

use crate::bus::{Bus, Guarded};
use crate::calibration::Calibration;
use crate::chip::{Fault, Magnetometer};
use crate::command::{Command, Inbox, RATES, Refusal};
use crate::frame::{Health, Identity, Message, Reading, State, VERSION};
use crate::packet::Damage;
use crate::unwrap::Unwrap;
use embedded_hal::delay::DelayNs;

/// Faults of the bus on end after which it is freed though no line is seen to be down: one may be a disturbance.
const FAULTS_BEFORE_FREEING: u8 = 2;
/// Slots between two attempts to set up a chip that does not answer: an attempt takes milliseconds.
const SLOTS_BETWEEN_SET_UPS: u8 = 10;

/// A mean that is being taken for the flux at rest.
#[derive(Clone, Copy, Debug)]
struct Tare {
    sum: [f64; 3],
    left: u16,
    of: u16,
}

/// A sensor head: everything but the pins.
#[derive(Clone, Debug)]
pub struct Head<M> {
    chip: M,
    unwrap: Unwrap,
    calibration: Option<Calibration>,
    tare: Option<Tare>,
    inbox: Inbox,
    rate: u16,
    /// The slot's number and the time of the last one.
    number: u32,
    last_us: Option<u32>,
    /// When the conversion began that is to be collected, and in which slot.
    begun: Option<(u32, u32)>,
    is_set_up: bool,
    faults: u8,
    wait: u8,
    recovered: bool,
    health: Health,
}

impl<M: Magnetometer> Head<M> {
    /// A head with a chip that is not yet set up, and so many slots a second (Hz).
    #[must_use]
    pub fn new(chip: M, rate: u16) -> Self {
        Self {
            chip,
            unwrap: Unwrap::default(),
            calibration: None,
            tare: None,
            inbox: Inbox::default(),
            rate: rate.clamp(*RATES.start(), *RATES.end()),
            number: 0,
            last_us: None,
            begun: None,
            is_set_up: false,
            faults: 0,
            wait: 0,
            recovered: false,
            health: Health::default(),
        }
    }

    /// Slots a second (Hz): what the sampling clock is to be set to.
    #[must_use]
    pub fn rate(&self) -> u16 {
        self.rate
    }

    /// Time between two slots (µs).
    #[must_use]
    pub fn period_us(&self) -> u32 {
        1_000_000 / u32::from(self.rate)
    }

    /// What went wrong so far.
    #[must_use]
    pub fn health(&self) -> Health {
        self.health
    }

    /// One slot: collects the conversion that was begun in the slot before, and begins the next.
    ///
    /// `now_us` is the device's time (µs), which may wrap. Slots that were slept through are counted by it. A reading has the
    /// number and the time of the slot that began it; none where there is none.
    pub fn slot<B: Bus, D: DelayNs>(&mut self, bus: &mut B, delay: &mut D, now_us: u32) -> Option<Reading> {
        self.count(now_us);
        if !bus.is_idle() && !self.unlock(bus) {
            return None;
        }
        if !self.is_set_up && !self.set_up(bus, delay) {
            self.health.missed += 1;
            return None;
        }
        let reading = self.begun.take().and_then(|slot| self.collect(bus, slot));
        if !self.is_set_up {
            self.health.missed += 1;
            return None;
        }
        match self.chip.begin(&mut Guarded(bus)) {
            Ok(()) => self.begun = Some((self.number, now_us)),
            Err(fault) => self.fail(fault, bus),
        }
        reading
    }

    /// Takes a byte that was received; the answer where it was the last one of a command.
    pub fn receive(&mut self, byte: u8) -> Option<Message> {
        self.inbox.push(byte).map(|command| self.obey(command))
    }

    /// Who this is.
    #[must_use]
    pub fn identity(&self) -> Identity {
        let calibrated_axes = self.calibration.map_or(0, |calibration| calibration.axes());
        Identity { version: VERSION, chip: self.chip.name(), rate: self.rate, calibrated_axes }
    }

    /// What went wrong so far, in every slot whose number is a multiple of the rate; for firmware to send beside the readings.
    #[must_use]
    pub fn once_a_second(&self) -> Option<Message> {
        self.number.is_multiple_of(u32::from(self.rate)).then_some(Message::Health(self.health))
    }

    fn count(&mut self, now_us: u32) {
        let period = self.period_us();
        let slots = self.last_us.map_or(1, |last| ((now_us.wrapping_sub(last) + period / 2) / period).max(1));
        self.last_us = Some(now_us);
        self.number = self.number.wrapping_add(slots);
        self.health.slots = self.health.slots.wrapping_add(slots);
        self.health.missed = self.health.missed.wrapping_add(slots - 1);
    }

    /// The reading of the conversion that was begun in this slot.
    fn collect<B: Bus>(&mut self, bus: &mut B, slot: (u32, u32)) -> Option<Reading> {
        match self.chip.collect(&mut Guarded(bus)) {
            Ok(counts) => {
                self.faults = 0;
                Some(self.reading(slot, counts))
            }
            Err(fault) => {
                self.fail(fault, bus);
                None
            }
        }
    }

    fn set_up<B: Bus, D: DelayNs>(&mut self, bus: &mut B, delay: &mut D) -> bool {
        if self.wait > 0 {
            self.wait -= 1;
            return false;
        }
        self.wait = SLOTS_BETWEEN_SET_UPS;
        self.begun = None;
        self.unwrap.forget();
        match self.chip.set_up(&mut Guarded(bus), delay) {
            Ok(()) => {
                (self.is_set_up, self.faults, self.recovered, self.wait) = (true, 0, true, 0);
            }
            Err(fault) => {
                self.note(fault);
                self.free(bus);
            }
        }
        self.is_set_up
    }

    fn note<E>(&mut self, fault: Fault<E>) {
        match fault {
            Fault::Bus(_) => self.health.bus_faults += 1,
            Fault::NotReady | Fault::Chip(_) | Fault::Reset => self.health.chip_faults += 1,
        }
    }

    /// A slot is without its reading.
    fn fail<B: Bus, E>(&mut self, fault: Fault<E>, bus: &mut B) {
        self.health.missed += 1;
        let (is_reset, is_bus) = (matches!(fault, Fault::Reset), matches!(fault, Fault::Bus(_)));
        self.note(fault);
        self.faults = self.faults.saturating_add(1);
        if is_bus && (self.faults >= FAULTS_BEFORE_FREEING || !bus.is_idle()) {
            self.free(bus);
        }
        if is_reset || self.faults > FAULTS_BEFORE_FREEING {
            (self.is_set_up, self.wait) = (false, 0);
        }
    }

    /// Frees a bus that is held down before anything is sent; where it stays down the slot is without its reading, and so is the one that
    /// waits to be collected.
    fn unlock<B: Bus>(&mut self, bus: &mut B) -> bool {
        self.health.bus_faults += 1;
        self.recovered = true;
        let is_free = self.free(bus);
        if !is_free {
            (self.is_set_up, self.wait) = (false, 0);
            self.health.missed += 1 + u32::from(self.begun.take().is_some());
        }
        is_free
    }

    fn free<B: Bus>(&mut self, bus: &mut B) -> bool {
        let is_free = bus.free();
        if is_free {
            self.health.freed += 1;
        } else {
            self.health.stuck += 1;
        }
        is_free
    }

    fn reading(&mut self, (number, stamp_us): (u32, u32), counts: [i32; 3]) -> Reading {
        let chip = self.chip.chip();
        let (counts, ran_over) = self.unwrap.push(counts, chip.wraps());
        let flux = chip.flux(counts).map(|flux| flux as f32);
        let saturated = counts.iter().any(|count| chip.is_saturated(*count));
        let exact = flux.map(f64::from);
        if !saturated {
            self.take_tare(exact);
        }
        let moments = match &self.calibration {
            Some(calibration) if !saturated => calibration.moments(exact),
            _ => None,
        };
        let beyond = moments.is_none() && !saturated && self.calibration.is_some();
        let recovered = core::mem::take(&mut self.recovered);
        let bits = [
            (saturated, State::SATURATED),
            (ran_over, State::WRAPPED),
            (beyond, State::BEYOND),
            (recovered, State::RECOVERED),
        ];
        let state = State(bits.into_iter().filter(|(set, _)| *set).fold(0, |state, (_, bit)| state | bit));
        let (moment, across) = (moments.map(|m| m.moment), moments.and_then(|m| m.across));
        Reading { number, stamp_us, flux, moment, across, state }
    }

    fn take_tare(&mut self, flux: [f64; 3]) {
        let Some(tare) = &mut self.tare else { return };
        tare.sum = [0, 1, 2].map(|axis| tare.sum[axis] + flux[axis]);
        tare.left -= 1;
        if tare.left == 0 {
            let rest = tare.sum.map(|sum| sum / f64::from(tare.of));
            self.calibration = self.calibration.map(|calibration| calibration.tared(rest));
            self.tare = None;
        }
    }

    fn obey(&mut self, command: Result<Command, Damage>) -> Message {
        let done = match command {
            Err(_) => {
                self.health.damaged_commands += 1;
                Err(Refusal::Damaged)
            }
            Ok(Command::Identify) => return Message::Identity(self.identity()),
            Ok(Command::Tare(0)) => Err(Refusal::Range),
            Ok(Command::Tare(_)) if self.calibration.is_none() => Err(Refusal::Uncalibrated),
            Ok(Command::Tare(of)) => {
                self.tare = Some(Tare { sum: [0.0; 3], left: of, of });
                Ok(())
            }
            Ok(Command::Rate(rate)) => self.set_rate(rate),
            Ok(Command::Load(calibration)) if !calibration.is_valid() => Err(Refusal::Range),
            Ok(Command::Load(calibration)) => {
                (self.calibration, self.tare) = (Some(calibration), None);
                Ok(())
            }
            Ok(Command::Unload) => {
                (self.calibration, self.tare) = (None, None);
                Ok(())
            }
        };
        done.map_or_else(Message::Refused, |()| Message::Done)
    }

    fn set_rate(&mut self, rate: u16) -> Result<(), Refusal> {
        if !RATES.contains(&rate) {
            return Err(Refusal::Range);
        }
        if self.chip.conversion_us() >= 1_000_000 / u32::from(rate) {
            return Err(Refusal::TooFast);
        }
        // The numbers go on; the time of the slot before says nothing about the new ones.
        (self.rate, self.last_us) = (rate, None);
        Ok(())
    }
}
