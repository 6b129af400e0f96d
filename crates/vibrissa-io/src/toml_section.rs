//! Tables of a TOML file with lines, units and ranges: what the readers of robots and scenarios share.

use crate::config::budgets::TOML_DEPTH;
use crate::text::{beyond, did_you_mean, line_at, short};
use crate::units::{Dimension, parse_quantity};
use crate::{Error, Result};
use core::f64::consts::TAU;
use core::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// The text of a file and its name in messages.
pub struct Source<'a> {
    /// The text.
    pub text: &'a str,
    /// Its file's name.
    pub name: &'a str,
}

impl<'a> Source<'a> {
    /// The text without a byte order mark.
    #[must_use]
    pub fn new(text: &'a str, name: &'a str) -> Self {
        Self { text: text.strip_prefix('\u{feff}').unwrap_or(text), name }
    }

    /// The tables of the text.
    ///
    /// # Errors
    ///
    /// Text that is not TOML, or nested deeper than any, with its line.
    pub fn parse(&self) -> Result<Spanned<DeTable<'a>>> {
        if let Some(at) = too_deep(self.text) {
            let remedy = "robots, scenarios and setups have three levels; remove brackets and dots";
            return Err(beyond(
                "keys or lists are nested too deeply",
                format!("more than {TOML_DEPTH} levels"),
                TOML_DEPTH,
                remedy,
            )
            .in_file(self.name)
            .at_line(line_at(self.text.as_bytes(), at)));
        }
        DeTable::parse(self.text).map_err(|e| {
            let line = e.span().map_or(1, |span| self.line(&span));
            Error::data("not valid TOML").in_file(self.name).at_line(line).value(e.message())
        })
    }

    /// The line of a place in the text, counted from 1.
    #[must_use]
    pub fn line(&self, span: &Range<usize>) -> usize {
        line_at(self.text.as_bytes(), span.start)
    }

    /// An error that names file and line.
    pub fn fault(&self, span: &Range<usize>, what: impl Into<String>) -> Error {
        Error::data(what).in_file(self.name).at_line(self.line(span))
    }
}

/// Where a text opens more brackets than it closed, or joins more names by dots, than [`TOML_DEPTH`]; signs are counted without regard to
/// quotes and comments, in which there are seldom so many.
fn too_deep(text: &str) -> Option<usize> {
    let (mut open, mut dots, mut before) = (0_usize, 0_usize, b' ');
    for (at, byte) in text.bytes().enumerate() {
        match byte {
            b'[' | b'{' => (open, dots) = (open + 1, 0),
            b']' | b'}' => (open, dots) = (open.saturating_sub(1), 0),
            b',' | b'=' | b'\n' => dots = 0,
            // Rows of dots stand in comments.
            b'.' if before != b'.' => dots += 1,
            _ => {}
        }
        if open > TOML_DEPTH || dots > TOML_DEPTH {
            return Some(at);
        }
        if byte != b' ' && byte != b'\t' {
            before = byte;
        }
    }
    None
}

/// Where a number must lie, and how to say so.
pub struct Allowed {
    /// Whether a number is allowed.
    pub holds: fn(f64) -> bool,
    /// The range in words.
    pub text: &'static str,
    /// What to do about a number outside of it; may be empty.
    pub remedy: &'static str,
}

/// Above zero.
pub const POSITIVE: Allowed = Allowed { holds: |v| v > 0.0 && v.is_finite(), text: "above 0", remedy: "" };
/// Any number.
pub const FINITE: Allowed = Allowed { holds: f64::is_finite, text: "a finite number", remedy: "" };
/// Zero or more.
pub const NOT_NEGATIVE: Allowed = Allowed { holds: |v| v >= 0.0 && v.is_finite(), text: "0 or more", remedy: "" };
/// A share below one.
pub const FRACTION: Allowed =
    Allowed { holds: |v| (0.0..1.0).contains(&v), text: "0 or more, below 1", remedy: "5 % is 0.05 or \"5 %\"" };
/// Lengths of whiskers and their parts (m).
pub const LENGTH: Allowed = Allowed {
    holds: |v| v > 0.0 && v <= 10.0,
    text: "above 0, up to 10 m",
    remedy: "a bare number is in metres; write \"75 mm\" for millimetres",
};
/// Coordinates on the robot (m).
pub const MOUNT: Allowed = Allowed {
    holds: |v| v.abs() <= 100.0,
    text: "-100 to 100 m",
    remedy: "a bare number is in metres; write \"75 mm\" for millimetres",
};
/// Angles (rad).
pub const HEADING: Allowed = Allowed {
    holds: |v| v.abs() <= TAU,
    text: "-2 pi to 2 pi rad",
    remedy: "a bare number is in radians; write \"90 deg\" for degrees",
};

/// One table of the file, with its path for messages.
pub struct Section<'a> {
    /// The file.
    pub source: &'a Source<'a>,
    /// The keys and values.
    pub table: &'a DeTable<'a>,
    /// Where it stands in the file, such as `whisker[1].noise`; empty for the whole file.
    pub path: String,
    /// Its place in the text (bytes).
    pub span: Range<usize>,
}

impl<'a> Section<'a> {
    /// The whole file.
    #[must_use]
    pub fn top(source: &'a Source<'a>, root: &'a Spanned<DeTable<'a>>) -> Self {
        Section { source, table: root.get_ref(), path: String::new(), span: root.span() }
    }

    /// Where the value of `key` stands; the section where it is missing.
    pub fn span_of(&self, key: &str) -> Range<usize> {
        self.get(key).map_or(self.span.clone(), Spanned::span)
    }

    /// The line of the value of `key`, or of the section where it is missing.
    #[must_use]
    pub fn line_of(&self, key: &str) -> usize {
        self.source.line(&self.span_of(key))
    }

    /// The full name of a key for messages.
    #[must_use]
    pub fn key(&self, key: &str) -> String {
        if self.path.is_empty() { key.to_owned() } else { format!("{}.{key}", self.path) }
    }

    /// The value of a key.
    #[must_use]
    pub fn get(&self, key: &str) -> Option<&'a Spanned<DeValue<'a>>> {
        self.table.get(key)
    }

    /// Rejects every key but `known`, the first in the file first.
    pub fn only(&self, known: &[&str]) -> Result<()> {
        let unknown = |key: &&Spanned<_>| !known.contains(&Spanned::<std::borrow::Cow<'_, str>>::get_ref(key).as_ref());
        match self.table.keys().filter(unknown).min_by_key(|key| key.span().start) {
            Some(key) => {
                let word = key.get_ref().as_ref();
                Err(self
                    .source
                    .fault(&key.span(), "unknown key")
                    .value(self.key(&short(word)))
                    .remedy(did_you_mean(word, known)))
            }
            None => Ok(()),
        }
    }

    /// The table under a key.
    pub fn section(&self, key: &str) -> Result<Option<Section<'a>>> {
        let Some(value) = self.get(key) else { return Ok(None) };
        match value.get_ref().as_table() {
            Some(table) => Ok(Some(Section { source: self.source, table, path: self.key(key), span: value.span() })),
            None => Err(self.source.fault(&value.span(), format!("{} must be a table", self.key(key)))),
        }
    }

    /// The text under a key.
    pub fn text(&self, key: &str) -> Result<Option<&'a str>> {
        let Some(value) = self.get(key) else { return Ok(None) };
        match value.get_ref().as_str() {
            Some(text) if !text.trim().is_empty() => Ok(Some(text.trim())),
            _ => Err(self
                .source
                .fault(&value.span(), format!("{} must be a text in quotes", self.key(key)))
                .value(show(value.get_ref()))),
        }
    }

    /// The number under a key in SI, checked.
    pub fn number(&self, key: &str, dimension: Dimension, allowed: &Allowed) -> Result<Option<f64>> {
        self.get(key).map(|value| self.quantity(&self.key(key), value, dimension, allowed)).transpose()
    }

    /// The whole number under a key, at least 0.
    pub fn whole(&self, key: &str) -> Result<Option<u64>> {
        let Some(value) = self.get(key) else { return Ok(None) };
        let number = match value.get_ref() {
            DeValue::Integer(i) if i.radix() == 10 => i.as_str().parse::<u64>().ok(),
            _ => None,
        };
        number.map(Some).ok_or_else(|| {
            self.source
                .fault(&value.span(), format!("{} must be a whole number", self.key(key)))
                .value(show(value.get_ref()))
                .allowed(format!("0 to {}", u64::MAX))
        })
    }

    /// The tables of a list `[[key]]`, each with its path; none where the key is missing.
    pub fn entries(&self, key: &str) -> Result<Vec<Section<'a>>> {
        let Some(value) = self.get(key) else { return Ok(Vec::new()) };
        let full = self.key(key);
        let wrong = |span: &Range<usize>| {
            self.source
                .fault(span, format!("{full} is written as list entries"))
                .remedy(format!("write [[{full}]] once for each"))
        };
        let list = value.get_ref().as_array().ok_or_else(|| wrong(&value.span()))?;
        let entry = |(index, entry): (usize, &'a Spanned<DeValue<'a>>)| {
            let table = entry.get_ref().as_table().ok_or_else(|| wrong(&entry.span()))?;
            let path = if list.len() == 1 { full.clone() } else { format!("{full}[{index}]") };
            Ok(Section { source: self.source, table, path, span: entry.span() })
        };
        list.iter().enumerate().map(entry).collect()
    }

    /// A number in SI or a text with a unit, checked.
    pub fn quantity(
        &self,
        key: &str,
        value: &Spanned<DeValue<'_>>,
        dimension: Dimension,
        allowed: &Allowed,
    ) -> Result<f64> {
        let raw = value.get_ref();
        let fault = |what: String| self.source.fault(&value.span(), what);
        let number = match raw {
            DeValue::Float(f) => f.as_str().parse::<f64>().ok(),
            DeValue::Integer(i) if i.radix() == 10 => i.as_str().parse::<f64>().ok(),
            DeValue::String(text) => Some(
                parse_quantity(text, dimension)
                    .map_err(|e| e.about(key).in_file(self.source.name).at_line(self.source.line(&value.span())))?,
            ),
            _ => None,
        };
        let Some(number) = number else {
            let example = format!("1.5 or \"1.5 {}\"", dimension.allowed()[0]);
            return Err(fault(format!("{key} must be a number or a text with a unit"))
                .value(show(raw))
                .allowed(if dimension == Dimension::Ratio { "0.05 or \"5 %\"".to_owned() } else { example }));
        };
        if (allowed.holds)(number) {
            return Ok(number);
        }
        let shown = match raw {
            DeValue::String(_) => format!("{} = {number} {}", show(raw), dimension.unit()),
            _ => format!("{} {}", show(raw), dimension.unit()),
        };
        let error = fault(format!("{key} is out of range")).value(shown.trim()).allowed(allowed.text);
        // Remedies are about units and ranges; a negative number has neither mistaken.
        Err(if allowed.remedy.is_empty() || number.is_nan() || number < 0.0 {
            error
        } else {
            error.remedy(allowed.remedy)
        })
    }
}

/// A value as the file's author wrote it, roughly.
#[must_use]
pub fn show(value: &DeValue<'_>) -> String {
    match value {
        DeValue::String(s) => format!("\"{}\"", short(s)),
        DeValue::Integer(i) => i.to_string(),
        DeValue::Float(f) => f.as_str().to_owned(),
        DeValue::Boolean(b) => b.to_string(),
        other => format!("{} here", other.type_str()),
    }
}
