//! The head over simulated chips: readings against the dipole, every slot accounted for, whatever the bus does.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must fail")]

use embedded_hal::delay::DelayNs;
use vibrissa_beam::sensing::{Chip, Mlx90393, SensingChain, Tle493d};
use vibrissa_head::LONGEST;
use vibrissa_head::calibration::{Calibration, Response, Signal};
use vibrissa_head::chip::{Magnetometer, MlxDriver, TleDriver};
use vibrissa_head::command::{Command, Refusal};
use vibrissa_head::frame::{Message, Reading, State};
use vibrissa_head::head::Head;
use vibrissa_head::simulated::{Device, MlxRegisters, SimulatedBus, TleRegisters};

/// A wait takes time.
struct Delay<'a>(&'a core::cell::Cell<u64>);

impl DelayNs for Delay<'_> {
    fn delay_ns(&mut self, ns: u32) {
        self.0.set(self.0.get() + u64::from(ns) / 1000 + 1);
    }
}

fn ask<M: Magnetometer>(head: &mut Head<M>, command: Command) -> Message {
    let mut packet = [0; LONGEST];
    let length = command.write(&mut packet).unwrap();
    let answers: Vec<Message> = packet[..length].iter().filter_map(|byte| head.receive(*byte)).collect();
    assert_eq!(answers.len(), 1);
    answers[0]
}

/// Slots of a head, each at its time.
fn slots<M: Magnetometer, D: Device>(
    head: &mut Head<M>,
    bus: &mut SimulatedBus<D>,
    count: usize,
    mut before: impl FnMut(usize, &mut SimulatedBus<D>),
) -> Vec<Reading> {
    let clock = core::cell::Cell::new(0);
    let mut readings = Vec::new();
    for k in 0..count {
        bus.now_us += u64::from(head.period_us());
        before(k, bus);
        clock.set(0);
        readings.extend(head.slot(bus, &mut Delay(&clock), bus.now_us as u32));
        assert!(clock.get() < 20_000);
    }
    readings
}

/// A straight line through the dipole's response, good enough to follow a moment.
fn calibration(chain: &SensingChain) -> Calibration {
    let (rest, [_, low, _], [_, high, _]) = (chain.flux(0.0), chain.flux(-0.01), chain.flux(0.01));
    let half = 0.5 * (high - low);
    let signal = Signal { direction: [0.0, half.signum(), 0.0], range: [0.0, half.abs()] };
    Calibration { rest, response: Response::Line(signal, [0.0, 0.01, 0.0, 0.0, 0.0, 0.0]) }
}

#[test]
fn a_moment_at_the_magnet_is_the_moment_that_is_sent() {
    let chain = SensingChain::default();
    let mut head = Head::new(MlxDriver::new(0x0c, Mlx90393::default()), 300);
    let mut bus = SimulatedBus::new(MlxRegisters::new(0x0c));
    assert_eq!(ask(&mut head, Command::Load(calibration(&chain))), Message::Done);
    let truth = |k: usize| 8e-3 * (k as f64 * 0.02).sin();
    let readings = slots(&mut head, &mut bus, 1000, |k, bus| bus.device.flux = chain.flux(truth(k)));
    // The first slot sets up and begins; the last one has only begun.
    assert_eq!(readings.len(), 999);
    for (k, reading) in readings.iter().enumerate() {
        assert_eq!((reading.number, reading.stamp_us), (k as u32 + 1, (k as u32 + 1) * 3333));
        for (axis, want) in chain.flux(truth(k)).into_iter().enumerate() {
            assert!((f64::from(reading.flux[axis]) - want).abs() < 5e-7, "slot {k}: {reading:?}");
        }
        // The dipole is no straight line.
        let off = (reading.moment.unwrap() - truth(k)).abs();
        assert!(off < 5e-4, "slot {k}: off by {off} N m");
    }
    assert_eq!((head.health().missed, head.health().slots), (0, 1000));
}

/// The device's moment is that of the same arithmetic on the host, bit by bit.
#[test]
fn moments_have_the_bits_of_the_host() {
    let chain = SensingChain::default();
    let held = calibration(&chain);
    let Response::Line(signal, coefficients) = held.response else { panic!() };
    let mut head = Head::new(MlxDriver::new(0x0c, Mlx90393::default()), 300);
    let mut bus = SimulatedBus::new(MlxRegisters::new(0x0c));
    ask(&mut head, Command::Load(held));
    let readings =
        slots(&mut head, &mut bus, 500, |k, bus| bus.device.flux = chain.flux(8e-3 * (k as f64 * 0.05).cos()));
    for reading in readings {
        let sum: f64 = (0..3).map(|k| (f64::from(reading.flux[k]) - held.rest[k]) * signal.direction[k]).sum();
        let z = (sum - signal.range[0]) / signal.range[1];
        let want = coefficients.iter().rev().fold(0.0, |sum, c| sum * z + c);
        assert_eq!(reading.moment.unwrap().to_bits(), want.to_bits());
    }
}

#[test]
fn locked_buses_lost_bytes_and_supplies_cost_slots_that_are_counted() {
    for held in [1, 5, 9] {
        let mut head = Head::new(MlxDriver::new(0x0c, Mlx90393::default()), 300);
        let mut bus = SimulatedBus::new(MlxRegisters::new(0x0c));
        let readings = slots(&mut head, &mut bus, 2000, |k, bus| {
            bus.device.flux = [1e-3, 2e-3, 3e-3];
            match k {
                200 | 900 => bus.held_for = held,
                400 => bus.unacknowledged = 1,
                600 => bus.device.power_cycle(),
                1200 => bus.unacknowledged = 8,
                1500 => bus.cut_off = Some(held),
                _ => {}
            }
        });
        let health = head.health();
        let numbers: Vec<u32> = readings.iter().map(|reading| reading.number).collect();
        assert!(numbers.windows(2).all(|pair| pair[1] > pair[0]));
        // The last slot's conversion has only begun.
        assert_eq!(numbers.len() as u32 + health.missed + 1, 2000, "{health:?}");
        assert!(health.freed >= 3 && health.stuck == 0 && health.missed < 120, "{health:?}");
        assert_eq!(bus.hung, 0, "a controller may wait for ever on a line that is held");
        let gaps: u32 = numbers.windows(2).map(|pair| pair[1] - pair[0] - 1).sum();
        assert_eq!(gaps, health.missed, "what is missed is a gap in the numbers");
        assert!(readings.iter().any(|reading| reading.state.has(State::RECOVERED)));
    }
}

#[test]
fn a_line_that_stays_down_is_told_and_comes_back() {
    let mut head = Head::new(TleDriver::new(0x35, Tle493d::default()), 300);
    let mut bus = SimulatedBus::new(TleRegisters::new(0x35));
    let readings = slots(&mut head, &mut bus, 1000, |k, bus| match k {
        300 => bus.held_for = 200,
        600 => bus.clock_held = true,
        650 => bus.clock_held = false,
        _ => bus.device.flux = [0.01, 0.02, 0.03],
    });
    let health = head.health();
    assert!(health.stuck > 60 && health.freed > 0 && bus.hung == 0, "{health:?}");
    assert_eq!(readings.len() as u32 + health.missed + 1, 1000, "{health:?}");
    assert!(readings.last().is_some_and(|last| last.number == 999), "{health:?}");
}

#[test]
fn counts_that_wrap_are_carried_on_and_saturation_is_told() {
    let mut head = Head::new(MlxDriver::new(0x0c, Mlx90393::default()), 300);
    let mut bus = SimulatedBus::new(MlxRegisters::new(0x0c));
    let end = Chip::Mlx90393(Mlx90393::default()).range();
    // Beyond 16 bits, to the end of the converter and back.
    let truth = |k: usize| 1.6 * end[0] * (k as f64 * 0.01).sin();
    let readings = slots(&mut head, &mut bus, 620, |k, bus| bus.device.flux = [truth(k), 0.0, 0.0]);
    let (mut wrapped, mut saturated) = (0, 0);
    for (k, reading) in readings.iter().enumerate() {
        wrapped += usize::from(reading.state.has(State::WRAPPED));
        if reading.state.has(State::SATURATED) {
            saturated += 1;
            assert_eq!(reading.moment, None);
        } else {
            assert!((f64::from(reading.flux[0]) - truth(k)).abs() < 4e-7, "{k}: {reading:?}");
        }
    }
    assert!(wrapped == 4 && saturated > 100, "{wrapped} {saturated}");
}

#[test]
fn commands_are_done_or_refused_with_their_reason() {
    let chain = SensingChain::default();
    let mut head = Head::new(MlxDriver::new(0x0c, Mlx90393::default()), 300);
    let mut bus = SimulatedBus::new(MlxRegisters::new(0x0c));
    assert_eq!(ask(&mut head, Command::Tare(10)), Message::Refused(Refusal::Uncalibrated));
    assert_eq!(ask(&mut head, Command::Rate(5)), Message::Refused(Refusal::Range));
    assert_eq!(ask(&mut head, Command::Rate(800)), Message::Refused(Refusal::TooFast));
    let Message::Identity(identity) = ask(&mut head, Command::Identify) else { panic!() };
    assert_eq!((identity.rate, identity.calibrated_axes), (300, 0));
    let broken = Calibration { rest: [f64::NAN; 3], ..calibration(&chain) };
    assert_eq!(ask(&mut head, Command::Load(broken)), Message::Refused(Refusal::Range));
    assert_eq!(ask(&mut head, Command::Load(calibration(&chain))), Message::Done);
    assert_eq!(ask(&mut head, Command::Tare(0)), Message::Refused(Refusal::Range));

    // Beside a piece of iron the field at rest is another one; after the tare a free whisker has no moment.
    let shift = [0.0, 3e-4, 1e-4];
    let shifted = |moment: f64| {
        let flux = chain.flux(moment);
        [0, 1, 2].map(|k| flux[k] + shift[k])
    };
    let before = slots(&mut head, &mut bus, 50, |_, bus| bus.device.flux = shifted(0.0));
    assert!(before.last().unwrap().moment.unwrap().abs() > 1e-3);
    assert_eq!(ask(&mut head, Command::Tare(20)), Message::Done);
    let after = slots(&mut head, &mut bus, 50, |_, bus| bus.device.flux = shifted(0.0));
    assert!(after.last().unwrap().moment.unwrap().abs() < 3e-6, "{:?}", after.last());
    assert_eq!(ask(&mut head, Command::Unload), Message::Done);
    let none = slots(&mut head, &mut bus, 5, |_, _| {});
    assert!(none.last().is_some_and(|reading| reading.moment.is_none() && !reading.state.has(State::BEYOND)));
    assert_eq!(head.receive(1), None);
    assert_eq!(head.receive(0), Some(Message::Refused(Refusal::Damaged)));
}

#[test]
fn slots_that_were_slept_through_are_counted() {
    let mut head = Head::new(MlxDriver::new(0x0c, Mlx90393::default()), 300);
    let mut bus = SimulatedBus::new(MlxRegisters::new(0x0c));
    let readings = slots(&mut head, &mut bus, 300, |k, bus| {
        if k % 100 == 50 {
            bus.now_us += 3 * 3333;
        }
    });
    assert_eq!((head.health().missed, head.health().slots), (9, 309));
    assert_eq!(readings.last().map(|reading| reading.number), Some(308));
}
