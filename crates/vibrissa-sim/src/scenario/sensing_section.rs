//! The magnetometer and what is logged.

use super::points::triple;
use crate::Result;
use crate::io::Dimension;
use crate::io::text::did_you_mean;
use crate::io::toml_section::{Allowed, FINITE, NOT_NEGATIVE, POSITIVE, Section, show};
use crate::sensing::{Chip, Mlx90393, SensingChain, Tle493d};
use crate::simulate::recorder::{Columns, Magnetometer, STRIP_CELL, SerialLayout};
use crate::world::Robot;
use toml::de::DeValue;

const COLUMNS: [&str; 6] = ["moment", "flux", "counts", "force", "slope", "strip"];
const CHIPS: [&str; 2] = ["MLX90393", "TLE493D"];
const LAYOUTS: [&str; 2] = ["single", "interleaved"];
const OFFSET: Allowed = Allowed {
    holds: |v| v.abs() <= 0.1,
    text: "-0.1 to 0.1 m",
    remedy: "a bare number is in metres; write \"5 mm\" for millimetres",
};

/// What a `[sensing]` section says.
pub(super) struct Sensing {
    pub(super) magnetometer: Magnetometer,
    pub(super) columns: Vec<Columns>,
    pub(super) strip_cell: f64,
    pub(super) serial: Option<SerialLayout>,
    pub(super) heading_noise: Option<f64>,
}

impl Default for Sensing {
    fn default() -> Self {
        Self {
            magnetometer: Magnetometer::default(),
            columns: vec![Columns::Moment],
            strip_cell: STRIP_CELL,
            serial: None,
            heading_noise: None,
        }
    }
}

/// Reads the section for a robot recorded at `rate` (Hz).
pub(super) fn sensing(section: &Section<'_>, robot: &Robot, rate: f64) -> Result<Sensing> {
    section.only(&[
        "columns",
        "strip_cell",
        "serial",
        "chip",
        "gain",
        "resolution",
        "oversampling",
        "filter",
        "short_range",
        "stiffness",
        "magnet_moment",
        "magnet_offset",
        "chip_offset",
        "ambient",
        "flux_noise",
        "heading_noise",
    ])?;
    let default = SensingChain::default();
    let chain = SensingChain {
        stiffness: section.number("stiffness", Dimension::Stiffness, &POSITIVE)?.unwrap_or(default.stiffness),
        magnet_moment: triple(section, "magnet_moment", Dimension::MagneticMoment, &FINITE)?
            .unwrap_or(default.magnet_moment),
        magnet_offset: triple(section, "magnet_offset", Dimension::Length, &OFFSET)?.unwrap_or(default.magnet_offset),
        chip_offset: triple(section, "chip_offset", Dimension::Length, &OFFSET)?.unwrap_or(default.chip_offset),
        ambient: triple(section, "ambient", Dimension::Flux, &FINITE)?.unwrap_or(default.ambient),
        chip: chip(section)?,
    };
    if chain.flux(0.0).iter().any(|b| !b.is_finite()) {
        return Err(section
            .source
            .fault(&section.span_of("chip_offset"), "the chip sits in the magnet")
            .remedy("set them a few millimetres apart"));
    }
    let serial = serial(section, robot)?;
    in_time(section, &chain.chip, serial, rate)?;
    let flux_noise = section.number("flux_noise", Dimension::Flux, &NOT_NEGATIVE)?.unwrap_or(0.0);
    let heading_noise = section.number("heading_noise", Dimension::Angle, &NOT_NEGATIVE)?;
    let strip_cell = section.number("strip_cell", Dimension::Length, &POSITIVE)?.unwrap_or(STRIP_CELL);
    let magnetometer = Magnetometer { chain, flux_noise };
    Ok(Sensing { magnetometer, columns: columns(section)?, strip_cell, serial, heading_noise })
}

/// One of some words, whatever its case.
fn word<'a>(section: &Section<'_>, key: &str, known: &[&'a str]) -> Result<Option<&'a str>> {
    let Some(text) = section.text(key)? else { return Ok(None) };
    match known.iter().find(|word| word.eq_ignore_ascii_case(text)) {
        Some(word) => Ok(Some(word)),
        None => Err(section
            .source
            .fault(&section.span_of(key), format!("{}: unknown word", section.key(key)))
            .value(format!("\"{text}\""))
            .allowed(known.join(", "))
            .remedy(did_you_mean(text, known))),
    }
}

fn columns(section: &Section<'_>) -> Result<Vec<Columns>> {
    let Some(value) = section.get("columns") else { return Ok(vec![Columns::Moment]) };
    let wrong = |value: &toml::Spanned<DeValue<'_>>| {
        section
            .source
            .fault(&value.span(), "sensing.columns is a list of words")
            .value(show(value.get_ref()))
            .allowed(COLUMNS.join(", "))
            .remedy("write columns = [\"counts\"], or [\"moment\", \"flux\"]")
    };
    let list = value.get_ref().as_array().filter(|list| !list.is_empty()).ok_or_else(|| wrong(value))?;
    let mut columns = Vec::new();
    for entry in list.iter() {
        let column = match entry.get_ref().as_str() {
            Some("moment") => Columns::Moment,
            Some("flux") => Columns::Flux,
            Some("counts") => Columns::Counts,
            Some("force") => Columns::Force,
            Some("slope") => Columns::Slope,
            Some("strip") => Columns::Strip,
            _ => return Err(wrong(entry)),
        };
        if !columns.contains(&column) {
            columns.push(column);
        }
    }
    Ok(columns)
}

fn chip(section: &Section<'_>) -> Result<Chip> {
    let name = word(section, "chip", &CHIPS)?.unwrap_or(CHIPS[0]);
    let (own, strange): (&[&str], &[&str]) = if name == CHIPS[0] {
        (&["gain", "resolution", "oversampling", "filter"], &["short_range"])
    } else {
        (&["short_range"], &["gain", "resolution", "oversampling", "filter"])
    };
    if let Some(key) = strange.iter().find(|key| section.get(key).is_some()) {
        return Err(section
            .source
            .fault(&section.span_of(key), format!("the {name} has no {key}"))
            .remedy(format!("its settings are: {}", own.join(", "))));
    }
    let default = Mlx90393::default();
    let register = |key: &str, most: u8, default: u8| match section.whole(key)? {
        None => Ok(default),
        Some(value) if value <= u64::from(most) => Ok(value as u8),
        Some(value) => Err(section
            .source
            .fault(&section.span_of(key), format!("{} is out of range", section.key(key)))
            .value(value)
            .allowed(format!("0 to {most}, as the register's value"))),
    };
    if name == CHIPS[0] {
        return Ok(Chip::Mlx90393(Mlx90393 {
            gain: register("gain", 7, default.gain)?,
            resolution: register("resolution", 3, default.resolution)?,
            oversampling: register("oversampling", 3, default.oversampling)?,
            filter: register("filter", 7, default.filter)?,
        }));
    }
    let short_range = match section.get("short_range").map(|value| (value.get_ref(), value)) {
        None => false,
        Some((DeValue::Boolean(yes), _)) => *yes,
        Some((other, value)) => {
            return Err(section.source.fault(&value.span(), "sensing.short_range is true or false").value(show(other)));
        }
    };
    Ok(Chip::Tle493d(Tle493d { short_range }))
}

fn serial(section: &Section<'_>, robot: &Robot) -> Result<Option<SerialLayout>> {
    let (layout, sensors) = match word(section, "serial", &LAYOUTS)? {
        None => return Ok(None),
        Some("single") => (SerialLayout::Single, 1),
        Some(_) => (SerialLayout::Interleaved, 2),
    };
    if robot.whiskers.len() != sensors {
        return Err(section
            .source
            .fault(&section.span_of("serial"), "the serial layout does not fit the number of whiskers")
            .value(format!("{} whiskers", robot.whiskers.len()))
            .allowed("1 for single, 2 for interleaved"));
    }
    Ok(Some(layout))
}

/// Refuses a chip that is slower than the rows; interleaved sensors have two rows each.
fn in_time(section: &Section<'_>, chip: &Chip, serial: Option<SerialLayout>, rate: f64) -> Result<()> {
    let rows = if serial == Some(SerialLayout::Interleaved) { 2.0 } else { 1.0 };
    match chip.conversion_time() {
        Some(time) if time > rows / rate => Err(section
            .source
            .fault(
                &section.span_of("filter"),
                "the chip is too slow for the path's rate with this filter and oversampling",
            )
            .value(format!("{:.2} ms a reading", time * 1e3))
            .allowed(format!("up to {:.2} ms", rows / rate * 1e3))
            .remedy("lower filter or oversampling, or the path's rate")),
        _ => Ok(()),
    }
}
