//! Lines and numbers of a file that may hold anything.

/// Longest line that is looked at (bytes); no format has longer ones.
const LONGEST: usize = 4096;

/// One line: its number from 1, its text without blanks around it, and whether a line end followed it.
pub(super) struct Line<'a> {
    pub(super) number: usize,
    pub(super) text: &'a str,
    pub(super) ended: bool,
}

/// The lines of a file; what is not UTF-8 or absurdly long comes as one replacement character, which no format reads.
pub(super) fn lines(bytes: &[u8]) -> impl Iterator<Item = Line<'_>> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    bytes.split_inclusive(|&b| b == b'\n').enumerate().map(|(index, raw)| {
        let text = if raw.len() > LONGEST { None } else { core::str::from_utf8(raw).ok() };
        Line { number: index + 1, text: text.map_or("\u{fffd}", str::trim), ended: raw.ends_with(b"\n") }
    })
}

/// A finite number.
#[must_use]
pub fn number(text: &str) -> Option<f64> {
    text.trim().parse::<f64>().ok().filter(|value| value.is_finite())
}

/// A line of exactly `N` finite numbers, separated by commas.
#[must_use]
pub fn numbers<const N: usize>(text: &str) -> Option<[f64; N]> {
    let mut values = [0.0; N];
    let mut fields = text.split(',');
    for value in &mut values {
        *value = number(fields.next()?)?;
    }
    fields.next().is_none().then_some(values)
}

/// A line of exactly `N` fields, separated by commas.
pub(super) fn fields<const N: usize>(text: &str) -> Option<[&str; N]> {
    let mut parts = [""; N];
    let mut fields = text.split(',');
    for part in &mut parts {
        *part = fields.next()?.trim();
    }
    fields.next().is_none().then_some(parts)
}
