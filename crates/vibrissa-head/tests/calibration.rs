//! Two moments out of three fluxes that both of them move.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must fail")]

use vibrissa_head::calibration::{Calibration, Moments, Response, Signal};

/// Flux of a sensor whose axes stand askew: each moment moves all three, and the third by its square.
const REST: [f64; 3] = [1e-4, -2e-4, 6e-3];
const MOVED: [[f64; 2]; 2] = [[0.11, 0.02], [-0.03, 0.12]];

#[test]
fn cross_talk_of_both_axes_is_undone_and_what_is_beyond_has_no_moment() {
    let determinant = MOVED[0][0] * MOVED[1][1] - MOVED[0][1] * MOVED[1][0];
    // The rows of the inverse, so that each signal is one moment; both ranges are 0.02 N m.
    let inverse = [
        [MOVED[1][1] / determinant, -MOVED[0][1] / determinant],
        [-MOVED[1][0] / determinant, MOVED[0][0] / determinant],
    ];
    let signal = |row: [f64; 2]| Signal { direction: [row[0], row[1], 0.0], range: [0.0, 0.02] };
    let mut coefficients = [[0.0; 10]; 2];
    (coefficients[0][1], coefficients[1][2]) = (0.02, 0.02);
    // What a bent plane adds: u²v to the first, v³ to the second.
    (coefficients[0][7], coefficients[1][9]) = (1e-3, -2e-3);
    let response = Response::Plane([signal(inverse[0]), signal(inverse[1])], coefficients);
    let calibration = Calibration { rest: REST, response };
    assert!(calibration.is_valid() && calibration.axes() == 2);
    for k in -9..=9 {
        for l in -9..=9 {
            let (u, v) = (f64::from(k) * 0.1, f64::from(l) * 0.1);
            let moments = [0.02 * u, 0.02 * v];
            let flux = [0, 1].map(|axis| REST[axis] + MOVED[axis][0] * moments[0] + MOVED[axis][1] * moments[1]);
            let Moments { moment, across } = calibration.moments([flux[0], flux[1], 0.1 * u * u]).unwrap();
            let want = [moments[0] + 1e-3 * u * u * v, moments[1] - 2e-3 * v * v * v];
            assert!((moment - want[0]).abs() < 1e-14 && (across.unwrap() - want[1]).abs() < 1e-14, "{u} {v}");
        }
    }
    let far = [REST[0] + MOVED[0][1] * 0.023, REST[1] + MOVED[1][1] * 0.023, 0.0];
    assert_eq!(calibration.moments(far), None);
    let nothing =
        Calibration { rest: [0.0; 3], response: Response::Plane([signal([1.0, 0.0]); 2], [[f64::NAN; 10]; 2]) };
    assert!(!nothing.is_valid());
}

#[test]
fn a_valid_calibration_has_a_finite_moment_for_every_flux_within_reach() {
    let signal = Signal { direction: [0.0, 0.6, 0.8], range: [0.0, 1e-3] };
    let line =
        |last: f64| Calibration { rest: REST, response: Response::Line(signal, [0.0, 1e-3, 0.0, 0.0, 0.0, last]) };
    // 1.1 to the fifth power is 1.6.
    assert!(line(1e308).is_valid() && !line(1.7e308).is_valid() && !line(f64::NAN).is_valid());
    let flux = [REST[0], REST[1] + 0.6 * 1.09e-3, REST[2] + 0.8 * 1.09e-3];
    assert!(line(1e308).moments(flux).is_some_and(|found| found.moment.is_finite()));
    let mut coefficients = [[0.0; 10]; 2];
    (coefficients[1][3], coefficients[1][9]) = (1e308, -1e308);
    assert!(!Calibration { rest: REST, response: Response::Plane([signal; 2], coefficients) }.is_valid());
}
