//! Numbers on the command line, with or without their unit.

use vibrissa::io::{Dimension, parse_quantity};
use vibrissa::{Error, Result};

/// A number in SI units, or one that carries its unit.
pub(crate) fn quantity(text: &str, dimension: Dimension) -> Result<f64> {
    match text.trim().parse::<f64>() {
        Ok(value) if !value.is_nan() => Ok(value),
        _ => parse_quantity(text, dimension),
    }
}

/// The value that an option was given, named in errors.
pub(crate) fn of_option(name: &str, text: &str, dimension: Dimension) -> Result<f64> {
    quantity(text, dimension).map_err(|error| {
        Error::usage(format!("{name}: {error}")).or_remedy("give a number in SI units, or one with its unit: \"75 mm\"")
    })
}

/// The value of a command line option, if it was given.
pub(crate) fn option(name: &str, dimension: Dimension, text: Option<&str>) -> Result<Option<f64>> {
    text.map(|text| of_option(name, text, dimension)).transpose()
}
