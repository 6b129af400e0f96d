//! A run of a head without hardware: a whisker's moments through magnet, chip, bus and head, with faults on the way. The same bytes on a
//! host and on an emulated processor.

use super::{Device, FluxNoise, MlxRegisters, SimulatedBus};
use crate::LONGEST;
use crate::calibration::{CURVE_TERMS, Calibration, Response, Signal};
use crate::chip::MlxDriver;
use crate::command::Command;
use crate::frame::Message;
use crate::head::Head;
use embedded_hal::delay::DelayNs;
use vibrissa_beam::sensing::{Mlx90393, SensingChain};

/// Standard deviation of the chip's noise (T): sixteen counts. An assumption; a chip that was built in tells its own.
pub const NOISE: f64 = 5e-6;

/// Slots of the faults: the data line is held, a transfer breaks off, no acknowledgement, the clock is held, the supply fails.
const HELD: usize = 250;
const CUT_OFF: usize = 400;
const UNACKNOWLEDGED: usize = 500;
const CLOCK_HELD: core::ops::Range<usize> = 600..605;
const POWER_CYCLE: usize = 700;
const MAGNET_NEAR: core::ops::Range<usize> = 900..908;
/// What a strong magnet that passes the sensor adds from slot to slot (T): beyond the converter, but never by half of a register at once.
const NEAR: [f64; 8] = [5e-3, 10e-3, 15e-3, 20e-3, 20e-3, 15e-3, 10e-3, 5e-3];

/// A head over a simulated MLX90393 at the magnet of the paper's sensor.
#[derive(Clone, Debug)]
pub struct Rehearsal {
    head: Head<MlxDriver>,
    bus: SimulatedBus<MlxRegisters>,
    chain: SensingChain,
    noise: FluxNoise,
}

/// Waits take no time.
struct AtOnce;

impl DelayNs for AtOnce {
    fn delay_ns(&mut self, _: u32) {}
}

impl Rehearsal {
    /// A head at so many readings a second (Hz) that has its calibration, for moments up to `largest` (N m).
    #[must_use]
    pub fn new(rate: u16, largest: f64) -> Self {
        let chain = SensingChain::default();
        let mut rehearsal = Self {
            head: Head::new(MlxDriver::new(0x0c, Mlx90393::default()), rate),
            bus: SimulatedBus::new(MlxRegisters::new(0x0c)),
            chain,
            noise: FluxNoise::new(NOISE, 1),
        };
        let mut packet = [0; LONGEST];
        let length = Command::Load(calibration(&chain, largest)).write(&mut packet).unwrap_or_default();
        for byte in packet.iter().take(length) {
            rehearsal.head.receive(*byte);
        }
        rehearsal
    }

    /// The head.
    #[must_use]
    pub fn head(&self) -> &Head<MlxDriver> {
        &self.head
    }

    /// Takes a byte that was received; the head's answer.
    pub fn receive(&mut self, byte: u8) -> Option<Message> {
        self.head.receive(byte)
    }

    /// The bus.
    #[must_use]
    pub fn bus(&self) -> &SimulatedBus<MlxRegisters> {
        &self.bus
    }

    /// The slot of this number from 0 under a moment (N m): the message that is sent; with the faults where `faulty`.
    pub fn slot(&mut self, slot: usize, moment: f64, faulty: bool) -> Option<Message> {
        self.bus.now_us = slot as u64 * 1_000_000 / u64::from(self.head.rate());
        let (flux, noise) = (self.chain.flux(moment), self.noise.draw());
        self.bus.device.flux = [0, 1, 2].map(|axis| flux[axis] + noise[axis]);
        if faulty {
            self.bus.clock_held = CLOCK_HELD.contains(&slot);
            match slot {
                HELD => self.bus.held_for = 5,
                CUT_OFF => self.bus.cut_off = Some(3),
                UNACKNOWLEDGED => self.bus.unacknowledged = 1,
                POWER_CYCLE => self.bus.device.power_cycle(),
                slot if MAGNET_NEAR.contains(&slot) => self.bus.device.flux[1] += NEAR[slot - MAGNET_NEAR.start],
                _ => {}
            }
        }
        let now_us = self.bus.now_us as u32;
        self.head.slot(&mut self.bus, &mut AtOnce, now_us).map(Message::Reading)
    }
}

/// The calibration of a chain for moments up to `largest` (N m), through as many points as a curve has coefficients: 0.2 µN m off up to 6 mN m,
/// where over 25 mN m the dipole is no such curve.
#[must_use]
pub fn calibration(chain: &SensingChain, largest: f64) -> Calibration {
    let rest = chain.flux(0.0);
    let y = |moment: f64| chain.flux(moment)[1] - rest[1];
    let (low, high) = (y(-largest), y(largest));
    let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
    let moments: [f64; CURVE_TERMS] =
        core::array::from_fn(|k| largest * (2.0 * k as f64 / (CURVE_TERMS - 1) as f64 - 1.0));
    let places = moments.map(|moment| (y(moment) - middle) / half);
    let signal = Signal { direction: [0.0, half.signum(), 0.0], range: [middle * half.signum(), half * half.signum()] };
    Calibration { rest, response: Response::Line(signal, through(places, moments)) }
}

/// The polynomial by rising power through points (Newton's divided differences).
fn through(places: [f64; CURVE_TERMS], mut values: [f64; CURVE_TERMS]) -> [f64; CURVE_TERMS] {
    for order in 1..CURVE_TERMS {
        for k in (order..CURVE_TERMS).rev() {
            values[k] = (values[k] - values[k - 1]) / (places[k] - places[k - order]);
        }
    }
    let mut power = [0.0; CURVE_TERMS];
    for k in (0..CURVE_TERMS).rev() {
        // power = power * (z - places[k]) + values[k]
        for term in (0..CURVE_TERMS).rev() {
            let below = if term > 0 { power[term - 1] } else { values[k] };
            power[term] = below - places[k] * power[term];
        }
    }
    power
}
