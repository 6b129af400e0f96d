//! Quantities written with their unit, such as "75 mm" or "17 mN m".

use crate::flow::contact_set::VirtualSensor;
use crate::text::suggestion;
use crate::{Error, Result};

/// The kind of a quantity, which says the units it may carry and the SI unit it is returned in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dimension {
    /// Length, in m.
    Length,
    /// Force, in N.
    Force,
    /// Moment, in N m.
    Moment,
    /// Angle, in rad.
    Angle,
    /// Pressure or modulus, in Pa.
    Pressure,
    /// Rotational stiffness, in N m/rad.
    Stiffness,
    /// Flexural rigidity, in N m².
    FlexuralRigidity,
    /// Curvature, in 1/m.
    Curvature,
    /// A plain number; also percent.
    Ratio,
    /// Time, in s.
    Time,
    /// Magnetic flux density, in T.
    Flux,
    /// Magnetic dipole moment, in A m².
    MagneticMoment,
    /// Speed, in m/s.
    Speed,
    /// Turning rate, in rad/s.
    TurnRate,
    /// Rate, in Hz.
    Frequency,
    /// Moment gained per time, in N m/s.
    MomentRate,
    /// Turn per length of way, in rad/m.
    TurnPerLength,
}

impl From<VirtualSensor> for Dimension {
    /// What a virtual sensor's reading measures.
    fn from(sensor: VirtualSensor) -> Self {
        match sensor {
            VirtualSensor::Load => Self::Force,
            VirtualSensor::Strip => Self::Length,
            VirtualSensor::Slope => Self::Angle,
            VirtualSensor::Moment(_) => Self::Moment,
        }
    }
}

impl Dimension {
    /// The SI unit of a number without unit; empty for plain numbers.
    #[must_use]
    pub fn unit(self) -> &'static str {
        match self {
            Self::Length => "m",
            Self::Force => "N",
            Self::Moment => "N m",
            Self::Angle => "rad",
            Self::Pressure => "Pa",
            Self::Stiffness => "N m/rad",
            Self::FlexuralRigidity => "N m^2",
            Self::Curvature => "1/m",
            Self::Ratio => "",
            Self::Time => "s",
            Self::Flux => "T",
            Self::MagneticMoment => "A m^2",
            Self::Speed => "m/s",
            Self::TurnRate => "rad/s",
            Self::Frequency => "Hz",
            Self::MomentRate => "N m/s",
            Self::TurnPerLength => "rad/m",
        }
    }

    /// Units that a quantity may carry, for people; every SI prefix from p to T works too.
    #[must_use]
    pub fn allowed(self) -> &'static [&'static str] {
        match self {
            Self::Length => &["m", "cm", "mm", "um", "km", "in"],
            Self::Force => &["N", "mN", "uN", "kN"],
            Self::Moment => &["N m", "mN m", "uN m", "N mm", "mN mm"],
            Self::Angle => &["rad", "mrad", "deg"],
            Self::Pressure => &["Pa", "kPa", "MPa", "GPa", "N/mm^2"],
            Self::Stiffness => &["N m/rad", "mN m/rad", "N mm/rad", "N m/deg"],
            Self::FlexuralRigidity => &["N m^2", "mN m^2", "N mm^2"],
            Self::Curvature => &["1/m", "1/cm", "1/mm"],
            Self::Ratio => &["%", "no unit"],
            Self::Time => &["s", "ms", "us", "min"],
            Self::Flux => &["T", "mT", "uT", "nT", "G"],
            Self::MagneticMoment => &["A m^2", "mA m^2", "uA m^2"],
            Self::Speed => &["m/s", "cm/s", "mm/s"],
            Self::TurnRate => &["rad/s", "deg/s"],
            Self::Frequency => &["Hz", "kHz"],
            Self::MomentRate => &["N m/s", "mN m/s", "uN m/s"],
            Self::TurnPerLength => &["rad/m", "deg/m"],
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Length => "a length",
            Self::Force => "a force",
            Self::Moment => "a moment",
            Self::Angle => "an angle",
            Self::Pressure => "a pressure",
            Self::Stiffness => "a rotational stiffness",
            Self::FlexuralRigidity => "a flexural rigidity",
            Self::Curvature => "a curvature",
            Self::Ratio => "a plain number",
            Self::Time => "a time",
            Self::Flux => "a magnetic flux density",
            Self::MagneticMoment => "a magnetic dipole moment",
            Self::Speed => "a speed",
            Self::TurnRate => "a turning rate",
            Self::Frequency => "a rate",
            Self::MomentRate => "a moment per time",
            Self::TurnPerLength => "a turn per length",
        }
    }
}

/// The value in SI units of a quantity written as a number and a unit.
///
/// A space between them is optional; `N m`, `N·m`, `N*m` and `Nm` are the same, and so are `µ` and `u`, `^2` and `²`.
/// `inf` needs no unit.
///
/// # Errors
///
/// Text that does not start with a number, a missing unit (except for plain numbers), a unit of another kind.
pub fn parse_quantity(text: &str, dimension: Dimension) -> Result<f64> {
    let trimmed = text.trim();
    let cut = number_end(trimmed);
    let unit = normalized(&trimmed[cut..]);
    let value = match trimmed[..cut].parse::<f64>() {
        Ok(value) => value,
        Err(_) => return Err(not_a_quantity(text, dimension)),
    };
    if value.is_nan() || (unit.is_empty() && value.is_infinite()) {
        return if value.is_nan() { Err(not_a_quantity(text, dimension)) } else { Ok(value) };
    }
    match factor(dimension, &unit) {
        Some(Scale::Times(factor)) => Ok(value * factor),
        Some(Scale::Over(divisor)) => Ok(value / divisor),
        None => Err(wrong_unit(text, trimmed[..cut].trim(), trimmed[cut..].trim(), dimension)),
    }
}

fn not_a_quantity(text: &str, dimension: Dimension) -> Error {
    Error::data("not a number with a unit").value(format!("\"{text}\"")).allowed(format!(
        "{}, such as \"1 {}\"",
        dimension.name(),
        dimension.allowed()[0]
    ))
}

fn wrong_unit(text: &str, number: &str, unit: &str, dimension: Dimension) -> Error {
    let allowed = dimension.allowed();
    let what = if unit.is_empty() {
        "the unit is missing".to_owned()
    } else {
        format!("`{unit}` is not the unit of {}", dimension.name())
    };
    let error = Error::data(what).value(format!("\"{text}\"")).allowed(allowed.join(", "));
    if unit.is_empty() {
        return error.remedy(format!("write \"{number} {}\", or the bare number for SI", dimension.unit()));
    }
    match suggestion(unit, allowed.iter().copied()) {
        Some(near) if near != "no unit" => error.remedy(format!("did you mean \"{number} {near}\"?")),
        _ => error,
    }
}

/// Where the number at the start of `text` ends.
fn number_end(text: &str) -> usize {
    let bytes = text.as_bytes();
    let digits = |mut i: usize| {
        while bytes.get(i).is_some_and(u8::is_ascii_digit) {
            i += 1;
        }
        i
    };
    let sign = usize::from(matches!(bytes.first(), Some(b'+' | b'-')));
    if text[sign..].starts_with("inf") {
        return sign + 3;
    }
    let mut end = digits(sign);
    if bytes.get(end) == Some(&b'.') {
        end = digits(end + 1);
    }
    if matches!(bytes.get(end), Some(b'e' | b'E')) {
        let exponent = end + 1 + usize::from(matches!(bytes.get(end + 1), Some(b'+' | b'-')));
        if digits(exponent) > exponent {
            end = digits(exponent);
        }
    }
    end
}

/// The unit in plain letters, without the spaces and dots that may stand after `N` and around `/`.
///
/// Any other gap stays, so that `m m` is no millimetre.
fn normalized(unit: &str) -> String {
    let is_gap = |c: char| c.is_whitespace() || matches!(c, '·' | '⋅' | '*');
    let mut out = String::new();
    let mut gap = false;
    for c in unit.trim().chars() {
        if is_gap(c) {
            gap = true;
            continue;
        }
        if gap && !out.ends_with(['N', '/']) && c != '/' {
            out.push(' ');
        }
        gap = false;
        match c {
            'µ' | 'μ' => out.push('u'),
            '²' => out.push('2'),
            '^' => {}
            c => out.push(c),
        }
    }
    out
}

/// How a number in some unit becomes SI. Powers of ten below one are divided by, so that 75 mm is exactly 0.075 m.
#[derive(Clone, Copy)]
enum Scale {
    Times(f64),
    Over(f64),
}

impl Scale {
    fn and(self, other: Self) -> Self {
        match (self, other) {
            (Self::Times(a), Self::Times(b)) => Self::Times(a * b),
            (Self::Over(a), Self::Over(b)) => Self::Over(a * b),
            (Self::Times(a), Self::Over(b)) | (Self::Over(b), Self::Times(a)) if a >= b => Self::Times(a / b),
            (Self::Times(a), Self::Over(b)) | (Self::Over(b), Self::Times(a)) => Self::Over(b / a),
        }
    }

    fn inverse(self) -> Self {
        match self {
            Self::Times(a) => Self::Over(a),
            Self::Over(a) => Self::Times(a),
        }
    }
}

fn factor(dimension: Dimension, unit: &str) -> Option<Scale> {
    match dimension {
        Dimension::Length => length(unit),
        Dimension::Force => prefixed(unit, "N"),
        Dimension::Moment => moment(unit),
        Dimension::Angle => angle(unit),
        Dimension::Pressure => pressure(unit),
        Dimension::Stiffness => {
            let (numerator, denominator) = unit.split_once('/')?;
            Some(moment(numerator)?.and(angle(denominator)?.inverse()))
        }
        Dimension::FlexuralRigidity => {
            let (force, squared) = force_and_rest(unit)?;
            let side = length(squared.strip_suffix('2')?)?;
            Some(force.and(side).and(side))
        }
        Dimension::Curvature => curvature(unit),
        Dimension::Ratio => match unit {
            "" => Some(Scale::Times(1.0)),
            "%" => Some(Scale::Over(100.0)),
            _ => None,
        },
        Dimension::Time => {
            if unit == "min" {
                Some(Scale::Times(60.0))
            } else {
                prefixed(unit, "s")
            }
        }
        Dimension::Flux => match unit.strip_suffix('G') {
            Some("") => Some(Scale::Over(1e4)),
            Some("m") => Some(Scale::Over(1e7)),
            _ => prefixed(unit, "T"),
        },
        Dimension::MagneticMoment => {
            let current = unit.find('A')? + 1;
            let side = length(unit[current..].trim().strip_suffix('2')?)?;
            Some(prefixed(&unit[..current], "A")?.and(side).and(side))
        }
        Dimension::Frequency => prefixed(unit, "Hz"),
        Dimension::Speed => per(unit, length, |time| prefixed(time, "s")),
        Dimension::TurnRate => per(unit, angle, |time| prefixed(time, "s")),
        Dimension::MomentRate => per(unit, moment, |time| prefixed(time, "s")),
        Dimension::TurnPerLength => per(unit, angle, length),
    }
}

/// The factor of `above/below`.
fn per(unit: &str, above: fn(&str) -> Option<Scale>, below: fn(&str) -> Option<Scale>) -> Option<Scale> {
    let (numerator, denominator) = unit.rsplit_once('/')?;
    Some(above(numerator)?.and(below(denominator)?.inverse()))
}

fn length(unit: &str) -> Option<Scale> {
    match unit {
        "in" | "inch" => Some(Scale::Times(0.0254)),
        _ => prefixed(unit, "m"),
    }
}

fn angle(unit: &str) -> Option<Scale> {
    match unit {
        "deg" | "°" => Some(Scale::Times(core::f64::consts::PI / 180.0)),
        _ => prefixed(unit, "rad"),
    }
}

fn moment(unit: &str) -> Option<Scale> {
    let (force, arm) = force_and_rest(unit)?;
    Some(force.and(length(arm)?))
}

fn pressure(unit: &str) -> Option<Scale> {
    match unit.split_once('/') {
        Some((force, area)) => {
            let side = length(area.strip_suffix('2')?)?.inverse();
            Some(prefixed(force, "N")?.and(side).and(side))
        }
        None => prefixed(unit, "Pa"),
    }
}

fn curvature(unit: &str) -> Option<Scale> {
    let side = match unit.strip_suffix("-1").or_else(|| unit.strip_suffix("⁻¹")) {
        Some(side) => side,
        None => unit.strip_prefix("1/").or_else(|| unit.strip_prefix('/'))?,
    };
    Some(length(side)?.inverse())
}

/// Splits `mNmm` into the force `mN` and the rest `mm`.
fn force_and_rest(unit: &str) -> Option<(Scale, &str)> {
    let end = unit.find('N')? + 1;
    Some((prefixed(&unit[..end], "N")?, &unit[end..]))
}

/// The factor of an SI unit with or without prefix.
fn prefixed(unit: &str, symbol: &str) -> Option<Scale> {
    Some(match unit.strip_suffix(symbol)? {
        "p" => Scale::Over(1e12),
        "n" => Scale::Over(1e9),
        "u" => Scale::Over(1e6),
        "m" => Scale::Over(1e3),
        "c" => Scale::Over(1e2),
        "" => Scale::Times(1.0),
        "k" => Scale::Times(1e3),
        "M" => Scale::Times(1e6),
        "G" => Scale::Times(1e9),
        "T" => Scale::Times(1e12),
        _ => return None,
    })
}
