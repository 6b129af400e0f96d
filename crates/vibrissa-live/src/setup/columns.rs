//! What a source's lines hold, as its entry says it.

use crate::Result;
use toml::Spanned;
use toml::de::DeValue;
use vibrissa_io::toml_section::{Section, show};

/// The truth value under a key; false without it.
pub(super) fn flag(entry: &Section<'_>, key: &str) -> Result<bool> {
    let Some(value) = entry.get(key) else { return Ok(false) };
    value.get_ref().as_bool().ok_or_else(|| {
        entry
            .source
            .fault(&value.span(), format!("{} must be true or false", entry.key(key)))
            .value(show(value.get_ref()))
    })
}

/// The columns that are named.
pub(super) fn said(entry: &Section<'_>) -> Result<Option<Vec<String>>> {
    let key = "columns";
    let Some(value) = entry.get(key) else { return Ok(None) };
    let wrong = |found: String| {
        entry
            .source
            .fault(&value.span(), format!("{} must be a list of texts", entry.key(key)))
            .value(found)
            .remedy("such as columns = [\"t_us\", \"bx_uT\", \"by_uT\", \"bz_uT\"]")
    };
    let list = value.get_ref().as_array().ok_or_else(|| wrong(show(value.get_ref())))?;
    let one = |value: &Spanned<DeValue<'_>>| match value.get_ref().as_str() {
        Some(text) => Ok(text.trim().to_owned()),
        None => Err(wrong(show(value.get_ref()))),
    };
    list.iter().map(one).collect::<Result<Vec<_>>>().map(Some)
}
