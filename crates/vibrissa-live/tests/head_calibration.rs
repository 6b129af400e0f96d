//! A calibration file on the host and on the head: the same bits of every moment.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on must fail")]

use vibrissa_core::world::calibration::{Calibration, MomentCurve, MomentPlane};
use vibrissa_live::head::head_calibration;

fn plane(inputs: &[&str]) -> MomentPlane {
    let n = inputs.len();
    let line = |from: f64| (0..n).map(|k| from + 3.3 * k as f64).collect::<Vec<_>>();
    MomentPlane {
        inputs: inputs.iter().map(|&name| name.to_owned()).collect(),
        rest: (0..n).map(|k| 1e-4 * (1.0 + k as f64)).collect(),
        directions: [line(-6.1), line(1.7)],
        ranges: [[1e-4, 0.02], [-3e-4, 0.018]],
        reach: 1.3,
        coefficients: [core::array::from_fn(|k| 0.01 / (1.0 + k as f64)), core::array::from_fn(|k| 1e-3 * k as f64)],
        residual_rms: [1e-5; 2],
        hysteresis: 0.0,
        bound: [1e-4; 2],
        samples: 100,
    }
}

fn fluxes() -> impl Iterator<Item = [f64; 3]> {
    let at = |k: i32| f64::from(k) * 7.3e-4;
    (-4..=4).flat_map(move |i| (-4..=4).map(move |j| [at(i), at(j), at(i * j % 3)]))
}

#[test]
fn host_and_head_give_the_same_bits() {
    for inputs in [&["bx", "by", "bz"][..], &["by", "bz"], &["bz", "bx"]] {
        let plane = plane(inputs);
        let held = head_calibration(&Calibration { plane: Some(plane.clone()), ..Calibration::default() }).unwrap();
        assert_eq!(held.axes(), 2);
        let mut told = 0;
        for flux in fluxes() {
            let readings: Vec<f64> = inputs
                .iter()
                .map(|name| flux[["bx", "by", "bz"].iter().position(|axis| axis == name).unwrap()])
                .collect();
            if let Ok([moment, across]) = plane.moments(&readings) {
                let head = held.moments(flux).unwrap();
                // A head sums in the order of its axes.
                let near = |a: f64, b: f64| {
                    if inputs == ["bz", "bx"] { (a - b).abs() < 1e-15 } else { a.to_bits() == b.to_bits() }
                };
                assert!(near(head.moment, moment) && near(head.across.unwrap(), across), "{flux:?}");
                told += 1;
            }
        }
        assert!(told > 20, "{told}");
    }
    let curve = MomentCurve {
        inputs: vec!["by".into()],
        rest: vec![2e-4],
        direction: vec![-1.0],
        range: [1e-5, 4e-3],
        coefficients: vec![1e-5, 0.011, 2e-4],
        residual_rms: 0.0,
        hysteresis: 0.0,
        bound: 0.0,
        samples: 9,
    };
    let held = head_calibration(&Calibration { moment: Some(curve.clone()), ..Calibration::default() }).unwrap();
    for flux in fluxes() {
        let head = held.moments(flux).unwrap();
        assert_eq!((head.moment.to_bits(), head.across), (curve.moment(&flux[1..2]).unwrap().to_bits(), None));
    }
}

#[test]
fn what_a_head_cannot_hold_is_refused() {
    let refused = |calibration: &Calibration| head_calibration(calibration).unwrap_err().to_string();
    assert!(refused(&Calibration::default()).contains("vibrissa calibrate"));
    let counts = Calibration { plane: Some(plane(&["ax", "ay"])), ..Calibration::default() };
    assert!(refused(&counts).contains("flux alone"), "{}", refused(&counts));
    let infinite = MomentPlane { rest: vec![f64::INFINITY; 3], ..plane(&["bx", "by", "bz"]) };
    assert!(refused(&Calibration { plane: Some(infinite), ..Calibration::default() }).contains("refuses"));
}
