//! The calibration of a file as a sensor head holds it.

use crate::{Error, Result};
use vibrissa_core::world::calibration::Calibration;
use vibrissa_head::calibration::{self as head, CURVE_TERMS, Response, Signal};
pub use vibrissa_head::command::Command;
pub use vibrissa_head::frame::{ChipName, Identity, Reading, State, VERSION};

/// What a head reads, in its order.
const AXES: [&str; 3] = ["bx", "by", "bz"];

/// The calibration that a head loads: what it makes of a flux is, bit by bit, what the host makes of it.
///
/// A head looks at each signal's range alone: where both are strong at once it also tells moments that the host refuses.
///
/// # Errors
///
/// Data: a calibration without moments, of counts, or of a curve with more terms than a head holds.
pub fn head_calibration(calibration: &Calibration) -> Result<head::Calibration> {
    let held = if let Some(plane) = &calibration.plane {
        let [first, second] = &plane.directions;
        let signals = [
            Signal { direction: of_axes(&plane.inputs, first)?, range: plane.ranges[0] },
            Signal { direction: of_axes(&plane.inputs, second)?, range: plane.ranges[1] },
        ];
        let rest = of_axes(&plane.inputs, &plane.rest)?;
        head::Calibration { rest, response: Response::Plane(signals, plane.coefficients) }
    } else if let Some(curve) = &calibration.moment {
        let signal = Signal { direction: of_axes(&curve.inputs, &curve.direction)?, range: curve.range };
        if curve.coefficients.len() > CURVE_TERMS {
            return Err(Error::data("the curve has too many terms for a sensor head")
                .value(curve.coefficients.len())
                .allowed(format!("{CURVE_TERMS} or fewer")));
        }
        let mut coefficients = [0.0; CURVE_TERMS];
        coefficients.iter_mut().zip(&curve.coefficients).for_each(|(place, value)| *place = *value);
        let rest = of_axes(&curve.inputs, &curve.rest)?;
        head::Calibration { rest, response: Response::Line(signal, coefficients) }
    } else {
        return Err(Error::data("the calibration does not turn readings into moments")
            .remedy("make one with `vibrissa calibrate LOG.csv --out DIR` from labelled contacts"));
    };
    if held.is_valid() { Ok(held) } else { Err(Error::data("the calibration has numbers that a sensor head refuses")) }
}

/// A number for each axis of the flux; 0 for those that are not read.
fn of_axes(inputs: &[String], values: &[f64]) -> Result<[f64; 3]> {
    let mut of = [0.0; 3];
    for (input, value) in inputs.iter().zip(values) {
        let axis = AXES
            .iter()
            .position(|axis| axis == input)
            .ok_or_else(|| Error::data("a sensor head reads flux alone").value(input).allowed(AXES.join(", ")))?;
        of[axis] = *value;
    }
    Ok(of)
}
