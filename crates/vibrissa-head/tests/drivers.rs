//! The drivers against chips that are simulated byte by byte.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must fail")]

use embedded_hal::delay::DelayNs;
use embedded_hal::i2c::ErrorKind;
use vibrissa_beam::sensing::{Mlx90393, Tle493d};
use vibrissa_head::bus::{Lines, free};
use vibrissa_head::chip::{Fault, Magnetometer, MlxDriver, TleDriver};
use vibrissa_head::simulated::{HeldLines, MlxRegisters, SimulatedBus, TleRegisters};

struct NoDelay;

impl DelayNs for NoDelay {
    fn delay_ns(&mut self, _: u32) {}
}

#[test]
fn every_setting_of_the_mlx90393_arrives_and_its_flux_is_read() {
    let flux = [1.5e-3, -2.25e-3, 3e-3];
    for gain in 0..8 {
        for resolution in 0..4 {
            for (oversampling, filter) in [(0, 2), (3, 7), (1, 0)] {
                let settings = Mlx90393 { gain, resolution, oversampling, filter };
                let mut driver = MlxDriver::new(0x0c, settings);
                let mut bus = SimulatedBus::new(MlxRegisters::new(0x0c));
                driver.set_up(&mut bus, &mut NoDelay).unwrap();
                assert_eq!(bus.device.settings(), settings);
                // A bit of its memory that it corrects is no fault.
                bus.device.corrects_a_bit = gain == 3;
                bus.device.flux = flux;
                driver.begin(&mut bus).unwrap();
                assert_eq!(driver.collect(&mut bus), Err(Fault::NotReady), "{settings:?}");
                assert!(driver.begin(&mut bus).is_err(), "a conversion that goes on is not begun again");
                bus.now_us += u64::from(driver.conversion_us());
                let counts = driver.collect(&mut bus).unwrap();
                let (read, step) = (driver.chip().flux(counts), driver.chip().per_count());
                for axis in 0..3 {
                    assert!((read[axis] - flux[axis]).abs() <= step[axis], "{settings:?}: {read:?}");
                }
                assert_eq!(driver.collect(&mut bus), Err(Fault::NotReady), "a result is read once");
            }
        }
    }
}

#[test]
fn an_mlx90393_that_lost_its_supply_is_noticed() {
    let mut driver = MlxDriver::new(0x0c, Mlx90393::default());
    let mut bus = SimulatedBus::new(MlxRegisters::new(0x0c));
    driver.set_up(&mut bus, &mut NoDelay).unwrap();
    driver.begin(&mut bus).unwrap();
    use vibrissa_head::simulated::Device;
    bus.device.power_cycle();
    bus.now_us += 10_000;
    assert_eq!(driver.collect(&mut bus), Err(Fault::Reset));
    let mut stranger = SimulatedBus::new(MlxRegisters::new(0x0d));
    assert!(matches!(driver.set_up(&mut stranger, &mut NoDelay), Err(Fault::Bus(ErrorKind::NoAcknowledge(_)))));
}

/// Boards are sold with chips of other addresses under the same name.
#[test]
fn chips_at_other_addresses_of_their_kind_are_found() {
    for (address, at) in [(0x0c, 0x0c), (0x0c, 0x18), (0x18, 0x0c), (0x0e, 0x1a)] {
        let mut driver = MlxDriver::new(address, Mlx90393::default());
        let mut bus = SimulatedBus::new(MlxRegisters::new(at));
        driver.set_up(&mut bus, &mut NoDelay).unwrap();
        bus.device.flux = [1e-3, 2e-3, -3e-3];
        driver.begin(&mut bus).unwrap();
        bus.now_us += u64::from(driver.conversion_us());
        assert!((driver.chip().flux(driver.collect(&mut bus).unwrap())[2] + 3e-3).abs() < 1e-6, "{address:#x} {at:#x}");
    }
    for at in [0x35, 0x22, 0x78, 0x44] {
        let mut bus = SimulatedBus::new(TleRegisters::new(at));
        TleDriver::new(0x35, Tle493d::default()).set_up(&mut bus, &mut NoDelay).unwrap();
    }
    // A bus that is held down is not asked again and again.
    let mut bus = SimulatedBus::new(MlxRegisters::new(0x18));
    bus.held_for = 3;
    assert!(MlxDriver::new(0x0c, Mlx90393::default()).set_up(&mut bus, &mut NoDelay).is_err());
    assert_eq!(bus.hung, 1);
}

#[test]
fn the_tle493d_gives_the_conversion_of_the_slot_before_with_right_parities() {
    // A controller that sends no empty transfer cannot send the reset; a board that starts anew finds a chip that is set up.
    let cases = [(false, false, 1, 0x35), (true, false, 2, 0x22), (false, true, 1, 0x78), (true, true, 3, 0x44)];
    for (short_range, refuses_empty, starts, address) in cases {
        let mut driver = TleDriver::new(address, Tle493d { short_range });
        let mut bus = SimulatedBus::new(TleRegisters::new(address));
        bus.refuses_empty = refuses_empty;
        for _ in 0..starts {
            // What is in the registers of the flux is no threshold.
            bus.device.flux = [0.031, -0.017, 0.044];
            bus.now_us += 1000;
            driver.set_up(&mut bus, &mut NoDelay).unwrap();
        }
        assert!(bus.device.is_configuration_right() && bus.device.is_mode_right(), "{short_range}");
        bus.now_us += 1000;
        bus.device.flux = [1e-3, 1e-3, 1e-3];
        driver.begin(&mut bus).unwrap();
        for k in 0..50 {
            let before = bus.device.flux;
            bus.device.flux = [0.02, -0.09, 0.001].map(|b| b * (1.0 - 0.04 * f64::from(k)));
            bus.now_us += 1000;
            let counts = driver.collect(&mut bus).unwrap();
            let (read, step) = (driver.chip().flux(counts), driver.chip().per_count());
            for axis in 0..3 {
                assert!((read[axis] - before[axis]).abs() <= 0.51 * step[axis], "{k}: {read:?} for {before:?}");
            }
        }
        // No time for a conversion.
        assert_eq!(driver.collect(&mut bus), Err(Fault::NotReady));
    }
}

#[test]
fn a_held_data_line_is_let_go_after_the_clocks_that_its_chip_waits_for() {
    for held in 0..=9 {
        let mut lines = HeldLines::new(held);
        assert_eq!(free(&mut lines), Some(held));
        assert!(lines.stops() == 1 && lines.data_is_high(), "{held}");
    }
    let mut lines = HeldLines::new(2).with_clock_held(true);
    assert_eq!((free(&mut lines), lines.stops()), (None, 0), "no master helps against a clock that is held");
    let mut lines = HeldLines::new(30);
    assert_eq!(free(&mut lines), None);
    assert_eq!((lines.stops(), lines.held_for()), (0, 21));
}
