//! The beam of a whisker section: one wire or several, and their rest curvature.

use super::toml_reader::{DIAMETER, RIGIDITY_AGREEMENT, STIFFNESS, TIP_RATIO};
use crate::Result;
use crate::beam::{CURVATURE_TERMS, MOST_STRETCHES, Stretch, Stretches, Whisker};
use crate::config::{defaults, limits};
use crate::toml_section::{Allowed, FINITE, LENGTH, POSITIVE, Section, show};
use crate::units::Dimension;
use core::f64::consts::PI;
use toml::Spanned;

const SEGMENT_KEYS: [&str; 6] =
    ["length", "flexural_rigidity", "young_modulus", "diameter", "tip_diameter", "tip_ratio"];
/// What each segment says for itself.
const OF_SEGMENTS: [&str; 5] = ["length", "flexural_rigidity", "young_modulus", "diameter", "tip_ratio"];
const SEGMENT_TAPER: Allowed = Allowed {
    holds: |v| (1e-3..=1e3).contains(&v),
    text: "0.001 to 1000",
    remedy: "radius at its end over radius at its beginning",
};
const STRAIN_LIMIT: Allowed = Allowed {
    holds: |v| v > 0.0 && v <= limits::LARGEST_STRAIN,
    text: "above 0, up to 1",
    remedy: "6 % is 0.06 or \"6 %\"",
};

/// The beam that a `[[whisker]]` describes.
pub(super) fn beam(section: &Section<'_>) -> Result<Whisker> {
    let wire = if section.get("segments").is_some() { jointed(section)? } else { single(section)? };
    let number = |key, dimension, allowed: &Allowed| section.number(key, dimension, allowed);
    let [curvature, rise @ ..] = curvature(section)?;
    let beam = Whisker {
        curvature,
        curvature_rise: rise,
        base_stiffness: number("base_stiffness", Dimension::Stiffness, &STIFFNESS)?.unwrap_or(wire.base_stiffness),
        strain_limit: number("strain_limit", Dimension::Ratio, &STRAIN_LIMIT)?.unwrap_or(wire.strain_limit),
        ..wire
    };
    // What no single key shows: a whisker that winds up.
    beam.rod().map_err(|error| {
        let key = if section.get("curvature").is_some() { "curvature" } else { "segments" };
        let span = section.get(key).map_or(section.span.clone(), Spanned::span);
        error.in_file(section.source.name).at_line(section.source.line(&span))
    })?;
    Ok(beam)
}

fn single(section: &Section<'_>) -> Result<Whisker> {
    let default = Whisker::default();
    let number = |key, dimension, allowed: &Allowed| section.number(key, dimension, allowed);
    let rigidity = flexural_rigidity(section)?;
    let diameter = number("diameter", Dimension::Length, &DIAMETER)?;
    Ok(Whisker {
        length: number("length", Dimension::Length, &LENGTH)?.unwrap_or(default.length),
        flexural_rigidity: rigidity.unwrap_or(default.flexural_rigidity),
        tip_ratio: number("tip_ratio", Dimension::Ratio, &TIP_RATIO)?.unwrap_or(default.tip_ratio),
        diameter: diameter.or(diameter_of(rigidity)),
        ..default
    })
}

/// The paper's wire, when the rigidity is its own.
fn diameter_of(rigidity: Option<f64>) -> Option<f64> {
    let paper = defaults::FLEXURAL_RIGIDITY;
    ((rigidity.unwrap_or(paper) / paper - 1.0).abs() < 1e-3).then_some(defaults::DIAMETER)
}

/// The coefficients of the rest curvature by rising power: one number, or a list.
fn curvature(section: &Section<'_>) -> Result<[f64; CURVATURE_TERMS + 1]> {
    let mut terms = [0.0; CURVATURE_TERMS + 1];
    let Some(value) = section.get("curvature") else { return Ok(terms) };
    let Some(list) = value.get_ref().as_array() else {
        terms[0] = section.number("curvature", Dimension::Curvature, &FINITE)?.unwrap_or(defaults::CURVATURE);
        return Ok(terms);
    };
    if list.is_empty() || list.len() > terms.len() {
        let error =
            section.source.fault(&value.span(), format!("{} has too many or no values", section.key("curvature")));
        return Err(error.value(list.len()).allowed(format!("1 to {} coefficients of 1, s, s², …", terms.len())));
    }
    for (power, (entry, term)) in list.iter().zip(&mut terms).enumerate() {
        let key = format!("{}[{power}]", section.key("curvature"));
        if power > 0 && entry.get_ref().as_str().is_some() {
            let error = section.source.fault(&entry.span(), format!("{key} must be a bare number"));
            return Err(error.value(show(entry.get_ref())).allowed(format!("a number of 1/m^{}", power + 1)));
        }
        *term = section.quantity(&key, entry, Dimension::Curvature, &FINITE)?;
    }
    Ok(terms)
}

fn jointed(section: &Section<'_>) -> Result<Whisker> {
    let Some(value) = section.get("segments") else { return Ok(Whisker::default()) };
    let fault = |what: String| section.source.fault(&value.span(), what);
    if let Some(key) = OF_SEGMENTS.iter().find(|key| section.get(key).is_some()) {
        let span = section.get(key).map_or(section.span.clone(), Spanned::span);
        return Err(section
            .source
            .fault(&span, format!("{} contradicts {}", section.key(key), section.key("segments")))
            .remedy(format!("give {key} in each segment only")));
    }
    let list: &[_] = value.get_ref().as_array().map_or(&[], |list| list);
    if list.is_empty() || list.len() > MOST_STRETCHES {
        return Err(fault(format!("{} must be a list of wires", section.key("segments")))
            .value(if list.is_empty() { show(value.get_ref()) } else { list.len().to_string() })
            .allowed(format!(
                "1 to {MOST_STRETCHES} entries like {{ length = \"25 mm\", flexural_rigidity = 2.9e-4 }}"
            )));
    }
    let stretches = list.iter().enumerate().map(|(i, entry)| stretch(section, i, entry)).collect::<Result<Vec<_>>>()?;
    let length = Stretches::new(&stretches)?.length();
    if !(LENGTH.holds)(length) {
        return Err(fault(format!("{} are too long", section.key("segments"))).value(length).allowed(LENGTH.text));
    }
    Whisker::of_stretches(&stretches)
}

fn stretch(section: &Section<'_>, i: usize, entry: &Spanned<toml::de::DeValue<'_>>) -> Result<Stretch> {
    let path = format!("{}[{i}]", section.key("segments"));
    let Some(table) = entry.get_ref().as_table() else {
        let error = section.source.fault(&entry.span(), format!("{path} must be a table"));
        return Err(error.value(show(entry.get_ref())).allowed("{ length = \"25 mm\", flexural_rigidity = 2.9e-4 }"));
    };
    let own = Section { source: section.source, table, path, span: entry.span() };
    own.only(&SEGMENT_KEYS)?;
    let missing = |key: &str, remedy: &str| {
        Err::<f64, _>(own.source.fault(&own.span, format!("{} is missing", own.key(key))).remedy(remedy))
    };
    let diameter = own.number("diameter", Dimension::Length, &DIAMETER)?;
    Ok(Stretch {
        length: match own.number("length", Dimension::Length, &LENGTH)? {
            Some(length) => length,
            None => missing("length", "each segment says how long it is")?,
        },
        flexural_rigidity: match flexural_rigidity(&own)? {
            Some(rigidity) => rigidity,
            None => missing("flexural_rigidity", "or give young_modulus and diameter")?,
        },
        tip_ratio: taper(&own, diameter)?,
        diameter,
    })
}

/// The taper of a segment, told by a ratio or by its last diameter.
fn taper(section: &Section<'_>, diameter: Option<f64>) -> Result<f64> {
    let ratio = section.number("tip_ratio", Dimension::Ratio, &SEGMENT_TAPER)?;
    let Some(tip) = section.number("tip_diameter", Dimension::Length, &DIAMETER)? else {
        return Ok(ratio.unwrap_or(1.0));
    };
    let span = section.get("tip_diameter").map_or(section.span.clone(), Spanned::span);
    let fault = |what: &str| section.source.fault(&span, format!("{} {what}", section.key("tip_diameter")));
    if ratio.is_some() {
        return Err(fault("contradicts tip_ratio").remedy("give one or the other"));
    }
    let Some(diameter) = diameter else {
        return Err(fault("without diameter").remedy("give the diameter where the segment begins, or tip_ratio"));
    };
    let ratio = tip / diameter;
    if (SEGMENT_TAPER.holds)(ratio) {
        return Ok(ratio);
    }
    Err(fault("is out of range").value(format!("{ratio} of the first diameter")).allowed(SEGMENT_TAPER.text))
}

/// E I of a round wire is E pi d⁴ / 64; given beside it, it must agree within 1 %.
fn flexural_rigidity(section: &Section<'_>) -> Result<Option<f64>> {
    let given = section.number("flexural_rigidity", Dimension::FlexuralRigidity, &POSITIVE)?;
    let modulus = section.number("young_modulus", Dimension::Pressure, &POSITIVE)?;
    let diameter = section.number("diameter", Dimension::Length, &DIAMETER)?;
    let fault = |key: &str, what: String| {
        let span = section.get(key).map_or(section.span.clone(), Spanned::span);
        section.source.fault(&span, what)
    };
    let computed = match (modulus, diameter) {
        (Some(e), Some(d)) => e * PI * d.powi(4) / 64.0,
        (None, None) => return Ok(given),
        (Some(_), None) if given.is_some() => return Ok(given),
        (None, Some(_)) if given.is_some() => return Ok(given),
        (Some(_), None) => {
            return Err(fault("young_modulus", "young_modulus without diameter".into())
                .remedy("add diameter = \"0.58 mm\", or give flexural_rigidity instead"));
        }
        (None, Some(_)) => {
            return Err(fault("diameter", "diameter without young_modulus".into())
                .remedy("add young_modulus = \"52 GPa\", or give flexural_rigidity instead"));
        }
    };
    match given {
        Some(ei) if (ei - computed).abs() > RIGIDITY_AGREEMENT * computed => {
            Err(fault("flexural_rigidity", "flexural_rigidity contradicts young_modulus and diameter".into())
                .value(format!("{ei} N m^2, but E pi d^4 / 64 = {computed:.5e} N m^2"))
                .allowed("equal within 1 %")
                .remedy("give one or the other"))
        }
        Some(ei) => Ok(Some(ei)),
        None => Ok(Some(computed)),
    }
}
