//! Flux to moments on the device, by the arithmetic of the host.
//!
//! The curves are those of `cal.json` as arrays: [`vibrissa_beam::sensing::response`](vibrissa_beam::sensing) evaluates both.

use serde::{Deserialize, Serialize};
use vibrissa_beam::sensing::{SURFACE_TERMS, excursion, polynomial, surface};

/// Coefficients of a curve: up to the fifth degree, as many as are fitted.
pub const CURVE_TERMS: usize = 6;
/// How far beyond the middle of the calibrated range a signal may lie, in half widths: 5 % of the range at either end.
pub const REACH: f64 = 1.1;

/// One signal of the flux: the excursion from rest along a direction, and its calibrated range.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Signal {
    /// Along which flux moves (a unit vector for one axis); 0 for an axis of the chip that is not used.
    pub direction: [f64; 3],
    /// Middle and half width of the calibrated range (T).
    pub range: [f64; 2],
}

impl Signal {
    /// The signal from -1 to 1 over the calibrated range.
    #[must_use]
    pub fn at(&self, flux: [f64; 3], rest: [f64; 3]) -> f64 {
        (excursion(&flux, &rest, &self.direction) - self.range[0]) / self.range[1]
    }

    fn is_valid(&self) -> bool {
        let finite = self.direction.iter().chain(&self.range).all(|value| value.is_finite());
        finite && self.range[1] > 0.0
    }
}

/// How signals become moments.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[allow(clippy::large_enum_variant, reason = "nothing may allocate, and there is one at a time")]
pub enum Response {
    /// The moment in the whisker's plane (N m), a polynomial of one signal by rising power.
    Line(Signal, [f64; CURVE_TERMS]),
    /// The moments about both transverse axes (N m), each a polynomial of two signals.
    Plane([Signal; 2], [[f64; SURFACE_TERMS]; 2]),
}

/// A calibration as a head holds it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Calibration {
    /// The flux without contact (T).
    pub rest: [f64; 3],
    /// Signals to moments.
    pub response: Response,
}

/// The moments of a flux.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moments {
    /// In the whisker's plane (N m).
    pub moment: f64,
    /// About the other transverse axis (N m), where it is calibrated.
    pub across: Option<f64>,
}

impl Calibration {
    /// The moments of a flux (T); none where a signal is more than 5 % of its range beyond it.
    #[must_use]
    pub fn moments(&self, flux: [f64; 3]) -> Option<Moments> {
        match &self.response {
            Response::Line(signal, coefficients) => {
                let z = signal.at(flux, self.rest);
                (z.abs() <= REACH).then(|| Moments { moment: polynomial(coefficients, z), across: None })
            }
            Response::Plane(signals, coefficients) => {
                let z = [signals[0].at(flux, self.rest), signals[1].at(flux, self.rest)];
                let [moment, across] = [surface(&coefficients[0], z), surface(&coefficients[1], z)];
                z.iter().all(|z| z.abs() <= REACH).then_some(Moments { moment, across: Some(across) })
            }
        }
    }

    /// The same with the flux without contact set anew.
    #[must_use]
    pub fn tared(self, rest: [f64; 3]) -> Self {
        Self { rest, ..self }
    }

    /// How many moments it gives.
    #[must_use]
    pub fn axes(&self) -> u8 {
        match self.response {
            Response::Line(..) => 1,
            Response::Plane(..) => 2,
        }
    }

    /// Whether all numbers are finite, the ranges are above 0, and so are the moments of every flux within reach.
    #[must_use]
    pub fn is_valid(&self) -> bool {
        self.rest.iter().all(|value| value.is_finite())
            && match &self.response {
                Response::Line(signal, coefficients) => signal.is_valid() && is_bounded(coefficients),
                Response::Plane(signals, coefficients) => {
                    signals.iter().all(Signal::is_valid) && coefficients.iter().all(|axis| is_bounded(axis))
                }
            }
    }
}

/// Whether a polynomial of signals within [`REACH`] stays within the range of numbers; its powers are at most the fifth.
fn is_bounded(coefficients: &[f64]) -> bool {
    const LARGEST_POWER: f64 = REACH * REACH * REACH * REACH * REACH;
    let most = coefficients.iter().fold(0.0, |sum: f64, coefficient| sum + coefficient.abs() * LARGEST_POWER);
    most.is_finite()
}
