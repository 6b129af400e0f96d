//! Points and lists of points in the file.

use crate::config::limits::LARGEST_COORDINATE;
use crate::io::Dimension;
use crate::io::toml_section::{Allowed, Section, show};
use crate::plane::Vec2;
use crate::{Error, Result};
use toml::Spanned;
use toml::de::DeValue;

pub(super) type Value<'a> = Spanned<DeValue<'a>>;

/// A coordinate of the map.
pub(super) const COORDINATE: Allowed = Allowed {
    holds: |v| v.abs() <= LARGEST_COORDINATE,
    text: "-1e5 to 1e5 m",
    remedy: "a bare number is in metres; write \"75 mm\" for millimetres",
};
/// An angle of any number of turns.
pub(super) const ANGLE: Allowed = Allowed {
    holds: |v| v.abs() <= 1e3,
    text: "-1000 to 1000 rad",
    remedy: "a bare number is in radians; write \"90 deg\" for degrees",
};

/// A point, with a heading (rad) where a third value stands.
pub(super) type Place = (Vec2, Option<f64>);

/// The point `[x, y]`, or `[x, y, theta]` where headings are allowed.
pub(super) fn place(section: &Section<'_>, key: &str, value: &Value<'_>, heading: bool) -> Result<Place> {
    let wrong = || -> Error {
        let (what, allowed) = if heading {
            (
                "a point must be two or three values: x, y and perhaps theta",
                "[0.1, 0.2] or [\"100 mm\", 0.2, \"90 deg\"]",
            )
        } else {
            ("a point must be two values: x, y", "[0.1, 0.2] or [\"100 mm\", \"200 mm\"]")
        };
        section
            .source
            .fault(&value.span(), format!("{}: {what}", section.key(key)))
            .value(show(value.get_ref()))
            .allowed(allowed)
    };
    let parts = value.get_ref().as_array().ok_or_else(wrong)?;
    let length = |v, name| section.quantity(&format!("{} {name}", section.key(key)), v, Dimension::Length, &COORDINATE);
    let parts: Vec<&Value<'_>> = parts.iter().collect();
    match parts.as_slice() {
        [x, y] => Ok((Vec2::new(length(x, "x")?, length(y, "y")?), None)),
        [x, y, theta] if heading => {
            let name = format!("{} theta", section.key(key));
            let theta = section.quantity(&name, theta, Dimension::Angle, &ANGLE)?;
            Ok((Vec2::new(length(x, "x")?, length(y, "y")?), Some(theta)))
        }
        _ => Err(wrong()),
    }
}

/// The one point under a key; none where the key is missing.
pub(super) fn point(section: &Section<'_>, key: &str) -> Result<Option<Vec2>> {
    section.get(key).map(|value| place(section, key, value, false).map(|(point, _)| point)).transpose()
}

/// The points under a key: one point or a list of points; none where the key is missing.
pub(super) fn places(section: &Section<'_>, key: &str, heading: bool) -> Result<Option<Vec<Place>>> {
    let Some(value) = section.get(key) else { return Ok(None) };
    list(section, key, value, heading).map(Some)
}

/// One point or a list of points.
pub(super) fn list(section: &Section<'_>, key: &str, value: &Value<'_>, heading: bool) -> Result<Vec<Place>> {
    if is_nested(value) {
        let entries = value.get_ref().as_array().into_iter().flat_map(|entries| entries.iter());
        return entries.map(|entry| place(section, key, entry, heading)).collect();
    }
    place(section, key, value, heading).map(|place| vec![place])
}

/// Whether the value is a list whose first entry is a list.
pub(super) fn is_nested(value: &Value<'_>) -> bool {
    value.get_ref().as_array().and_then(|entries| entries.iter().next()).is_some_and(|first| first.get_ref().is_array())
}

/// Three lengths or the like.
pub(super) fn triple(
    section: &Section<'_>,
    key: &str,
    dimension: Dimension,
    allowed: &Allowed,
) -> Result<Option<[f64; 3]>> {
    let Some(value) = section.get(key) else { return Ok(None) };
    let parts: Vec<&Value<'_>> = value.get_ref().as_array().into_iter().flat_map(|parts| parts.iter()).collect();
    let [x, y, z] = parts.as_slice() else {
        let what = format!("{} must be three values", section.key(key));
        return Err(section.source.fault(&value.span(), what).value(show(value.get_ref())));
    };
    let part = |v, name| section.quantity(&format!("{} {name}", section.key(key)), v, dimension, allowed);
    Ok(Some([part(x, "x")?, part(y, "y")?, part(z, "z")?]))
}
