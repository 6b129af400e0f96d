//! The estimator of a setup, with its options.

use super::at;
use crate::Result;
use toml::de::DeValue;
use vibrissa_core::config::{SettingValue, Slot};
use vibrissa_core::localizer::Method;
use vibrissa_io::Dimension;
use vibrissa_io::text::did_you_mean;
use vibrissa_io::toml_section::{Allowed, Section};

/// The method with the options of the table `options`.
pub(super) fn method(top: &Section<'_>) -> Result<Method> {
    let mut method = match top.text("method")? {
        Some(name) => Method::named(name).map_err(|e| {
            at(top, "method", e.into_data()).remedy(did_you_mean(name, &Method::all().each_ref().map(Method::name)))
        })?,
        None => Method::default(),
    };
    let Some(options) = top.section("options")? else { return Ok(method) };
    let names: Vec<&str> = method.settings().iter().map(|setting| setting.name).collect();
    options.only(&names)?;
    for name in names.into_iter().filter(|name| options.get(name).is_some()) {
        let kind = method.settings().into_iter().find(|s| s.name == name).map(|setting| match setting.field {
            Slot::Count(_) => 0,
            Slot::Choice(_) => 1,
            Slot::Region(_) => 2,
            Slot::Number(_) | Slot::OptionalNumber(..) => 3,
        });
        let value = match kind {
            Some(0) => SettingValue::Count(options.whole(name)?.unwrap_or_default() as usize),
            Some(1) => SettingValue::Choice(options.text(name)?.unwrap_or_default().to_owned()),
            Some(2) => SettingValue::Region(region(&options, name)?),
            _ => SettingValue::Number(number(&options, name)?),
        };
        method.set(name, value).map_err(|e| at(&options, name, e.into_data()))?;
    }
    method.check().map_err(|e| at(top, "options", e.into_data()))?;
    Ok(method)
}

fn number(options: &Section<'_>, name: &str) -> Result<f64> {
    let any = Allowed { holds: |v| !v.is_nan(), text: "a number", remedy: "" };
    Ok(options.number(name, Dimension::Ratio, &any)?.unwrap_or_default())
}

fn region(options: &Section<'_>, name: &str) -> Result<[[f64; 2]; 3]> {
    let wrong = || {
        options
            .source
            .fault(&options.span_of(name), format!("{} must be six numbers", options.key(name)))
            .remedy("least x, largest x, least y, largest y (m), least heading, largest heading (rad)")
    };
    let list = options.get(name).and_then(|value| value.get_ref().as_array()).ok_or_else(wrong)?;
    let values: Vec<f64> = list
        .iter()
        .map(|value| match value.get_ref() {
            DeValue::Float(f) => f.as_str().parse::<f64>().ok(),
            DeValue::Integer(i) => i.as_str().parse::<f64>().ok(),
            _ => None,
        })
        .collect::<Option<_>>()
        .ok_or_else(wrong)?;
    let [a, b, c, d, e, f] = values[..] else { return Err(wrong()) };
    Ok([[a, b], [c, d], [e, f]])
}
