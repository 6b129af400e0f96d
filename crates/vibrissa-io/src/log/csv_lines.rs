//! The lines of a CSV text, and the fields of a line.

use crate::config::budgets::MOST_COLUMNS;
use crate::config::limits::LONGEST_LOG_LINE;
use crate::text::beyond;
use crate::{Error, Result};
use std::io::{BufRead, BufReader, Read};

/// A line, without its end.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line<'a> {
    /// Counted from 1.
    pub(super) number: usize,
    bytes: &'a [u8],
    /// Whether a line end followed it.
    pub(super) ended: bool,
}

/// A stream, line by line; takes as much memory as its longest line may have.
pub(super) struct Lines<R> {
    reader: BufReader<R>,
    number: usize,
    bytes: Vec<u8>,
}

impl<R: Read> Lines<R> {
    pub(super) fn new(reader: R) -> Self {
        Self { reader: BufReader::with_capacity(1 << 16, reader), number: 0, bytes: Vec::new() }
    }

    /// The next line; none at the end.
    ///
    /// # Errors
    ///
    /// A stream that cannot be read, a line of more than a megabyte.
    pub(super) fn next(&mut self) -> Result<Option<Line<'_>>> {
        self.bytes.clear();
        self.number += 1;
        let (number, most) = (self.number, LONGEST_LOG_LINE);
        let cannot = |e| Error::data("cannot read the log").at_line(number).value(e);
        let read = self.reader.by_ref().take(most as u64 + 2).read_until(b'\n', &mut self.bytes).map_err(cannot)?;
        if read > most + 1 {
            return Err(
                beyond("a line is too long", format!("more than {most} bytes"), most, "is it a log?").at_line(number)
            );
        }
        let bytes = self.bytes.strip_suffix(b"\n").unwrap_or(&self.bytes);
        // A byte order mark in front of the header.
        let bytes = if number == 1 { bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes) } else { bytes };
        // A carriage return ends a line, too; the line feed behind it may be what is missing.
        let ended = matches!(self.bytes.last(), Some(b'\n' | b'\r'));
        Ok((read > 0).then_some(Line { number, bytes, ended }))
    }
}

impl Line<'_> {
    pub(super) fn is_blank(&self) -> bool {
        self.bytes.trim_ascii().is_empty()
    }

    pub(super) fn is_comment(&self) -> bool {
        self.bytes.trim_ascii_start().starts_with(b"#")
    }
}

/// The fields of a line, which this byte parts, without blanks and quotes around them.
///
/// # Errors
///
/// A quote that does not end in its line; more fields than a log may have columns.
pub(super) fn fields<'a>(line: &Line<'a>, delimiter: u8) -> Result<Vec<&'a [u8]>> {
    let (mut fields, mut rest) = (Vec::new(), line.bytes);
    loop {
        if fields.len() >= MOST_COLUMNS {
            let remedy = "leave out the columns that are not used";
            return Err(beyond(
                "a line has too many fields",
                format!("{} or more", fields.len() + 1),
                MOST_COLUMNS,
                remedy,
            ));
        }
        let (field, next) = match trimmed(rest, delimiter).strip_prefix(b"\"") {
            Some(quoted) => in_quotes(quoted, delimiter).ok_or_else(stray)?,
            None => {
                let end = rest.iter().position(|byte| *byte == delimiter);
                (end.map_or(rest, |end| &rest[..end]).trim_ascii(), end.map(|end| &rest[end + 1..]))
            }
        };
        fields.push(field);
        match next {
            Some(next) => rest = next,
            None => return Ok(fields),
        }
    }
}

/// What stands before the closing quote, and what follows the delimiter behind it; a doubled quote closes nothing.
fn in_quotes(text: &[u8], delimiter: u8) -> Option<(&[u8], Option<&[u8]>)> {
    let mut at = 0;
    let end = loop {
        at += text.get(at..)?.iter().position(|byte| *byte == b'"')?;
        if text.get(at + 1) != Some(&b'"') {
            break at;
        }
        at += 2;
    };
    match trimmed(&text[end + 1..], delimiter) {
        [] => Some((text[..end].trim_ascii(), None)),
        [byte, next @ ..] if *byte == delimiter => Some((text[..end].trim_ascii(), Some(next))),
        _ => None,
    }
}

/// Without the blanks in front that are no delimiters.
fn trimmed(text: &[u8], delimiter: u8) -> &[u8] {
    let begin = text.iter().position(|byte| *byte == delimiter || !byte.is_ascii_whitespace());
    &text[begin.unwrap_or(text.len())..]
}

fn stray() -> Error {
    Error::data("a quote that does not end in its line")
        .allowed("quotes around a whole field, closed in the same line")
        .remedy("remove the quote, or the line; numbers need no quotes")
}

#[cfg(test)]
mod tests {
    use super::{Line, Lines, fields};

    fn split(text: &str) -> Option<Vec<String>> {
        let line = Line { number: 1, bytes: text.as_bytes(), ended: true };
        let fields = fields(&line, b',').ok()?;
        Some(fields.iter().map(|field| String::from_utf8_lossy(field).into_owned()).collect())
    }

    #[test]
    fn fields_are_split_at_commas_outside_quotes() {
        let is = |text: &str, want: &[&str]| assert_eq!(split(text).unwrap(), want, "{text}");
        is("a,b ,\tc\r", &["a", "b", "c"]);
        is("a,,", &["a", "", ""]);
        is("\"a\", \"b, c\" ,5\" pipe", &["a", "b, c", "5\" pipe"]);
        is("\"he said \"\"x\"\"\",1", &["he said \"\"x\"\"", "1"]);
        for text in ["\"a,b", "1,\"", "\"a\"b,c", "1,\"a\"\""] {
            assert_eq!(split(text), None, "{text}");
        }
    }

    #[test]
    fn lines_tell_their_number_and_their_end() {
        let mut lines = Lines::new(&b"\xef\xbb\xbfa\n\nb\r\nc"[..]);
        let mut found = Vec::new();
        while let Some(line) = lines.next().unwrap() {
            found.push((line.number, split(core::str::from_utf8(line.bytes).unwrap()).unwrap().join(","), line.ended));
        }
        let want = [(1, "a", true), (2, "", true), (3, "b", true), (4, "c", false)];
        assert_eq!(found, want.map(|(number, text, ended)| (number, text.to_owned(), ended)));
        let long = vec![b'1'; 3 << 20];
        assert!(Lines::new(&long[..]).next().unwrap_err().to_string().contains("too long"));
    }
}
