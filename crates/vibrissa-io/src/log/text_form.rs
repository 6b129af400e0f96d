//! How a CSV file is written: its encoding, line ends, separator and decimal mark.
//!
//! Spreadsheets of many countries write UTF-16, semicolons and decimal commas. What differs from the plain form (UTF-8, line
//! feeds, commas, decimal points) is read and told.

use crate::{Error, Result};
use std::io::{Cursor, Read};

/// Bytes that are looked at: a header and some rows.
const LOOKED_AT: usize = 1 << 16;

/// How a file is written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct TextForm {
    /// Between two columns.
    pub(super) delimiter: u8,
    /// Whether numbers may have a comma instead of the point.
    pub(super) decimal_comma: bool,
    /// What is not as usual, for people.
    pub(super) warnings: Vec<String>,
}

/// A text as UTF-8 with line feeds.
type Plain<'a> = Box<dyn Read + 'a>;

/// The form of a stream, and the stream as UTF-8 with line feeds.
///
/// # Errors
///
/// A spreadsheet or another container in the place of a text, and a stream that cannot be read.
pub(super) fn recognised<'a>(mut reader: impl Read + 'a) -> Result<(TextForm, Plain<'a>)> {
    let mut head = Vec::new();
    let unreadable = |e: std::io::Error| Error::data("cannot read the log").value(e);
    reader.by_ref().take(LOOKED_AT as u64).read_to_end(&mut head).map_err(unreadable)?;
    refuse_containers(&head)?;
    let mut warnings = Vec::new();
    let wide = match head.as_slice() {
        [0xff, 0xfe, ..] => Some(u16::from_le_bytes as fn([u8; 2]) -> u16),
        [0xfe, 0xff, ..] => Some(u16::from_be_bytes as fn([u8; 2]) -> u16),
        _ => None,
    };
    let mut sample = head.clone();
    let mut plain: Plain<'a> = Box::new(Cursor::new(head).chain(reader));
    if let Some(unit) = wide {
        warnings.push("the file is UTF-16, not UTF-8".to_owned());
        sample = sample.chunks_exact(2).map(|pair| u8::try_from(unit([pair[0], pair[1]])).unwrap_or(b'?')).collect();
        plain = Box::new(Utf16 { inner: plain, unit, started: false, out: Vec::new(), high: None });
    }
    if sample.contains(&b'\r') && !sample.contains(&b'\n') {
        warnings.push("its lines end in carriage returns".to_owned());
        plain = Box::new(LineFeeds(plain));
    }
    let mut lines = sample.split(|byte| matches!(byte, b'\n' | b'\r')).filter(|line| !line.is_empty());
    let header = lines.next().unwrap_or_default();
    let delimiter = match header.iter().find(|byte| matches!(byte, b',' | b';' | b'\t')) {
        Some(&found) => found,
        None => b',',
    };
    let decimal_comma = delimiter != b',';
    if delimiter != b',' {
        let name = if delimiter == b';' { "semicolons" } else { "tabs" };
        warnings.push(format!("its columns are separated by {name}"));
    }
    if decimal_comma && lines.any(|line| line.contains(&b',')) {
        warnings.push("its decimal mark is a comma".to_owned());
    }
    Ok((TextForm { delimiter, decimal_comma, warnings }, plain))
}

impl TextForm {
    /// What is not as usual in one sentence; none where all is.
    pub(super) fn warning(&self) -> Option<String> {
        let words = self.warnings.join("; ");
        (!words.is_empty()).then(|| format!("{words}; it is read as that"))
    }
}

/// Files that people take for tables and that are none.
fn refuse_containers(head: &[u8]) -> Result<()> {
    let remedy = "save the sheet as CSV (in UTF-8), and give that file";
    let refused = |what: &str| Err(Error::data(what).allowed("a CSV file").remedy(remedy));
    match head {
        [b'P', b'K', 3, 4, ..] => refused("the log is a spreadsheet (.xlsx, .ods) or another zip archive"),
        [0xd0, 0xcf, 0x11, 0xe0, ..] => refused("the log is a spreadsheet of old (.xls)"),
        [0x1f, 0x8b, ..] => Err(Error::data("the log is compressed (gzip)").remedy("unpack it first: gunzip FILE")),
        _ => Ok(()),
    }
}

/// UTF-16 as UTF-8; what is no text becomes U+FFFD.
struct Utf16<R> {
    inner: R,
    unit: fn([u8; 2]) -> u16,
    started: bool,
    /// What was decoded and not taken yet.
    out: Vec<u8>,
    /// The first half of a pair of surrogates.
    high: Option<u16>,
}

impl<R: Read> Read for Utf16<R> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        while self.out.is_empty() && !buffer.is_empty() {
            let mut bytes = Vec::new();
            if self.inner.by_ref().take(4096).read_to_end(&mut bytes)? == 0 {
                break;
            }
            let units = self.high.take().into_iter().chain(bytes.chunks_exact(2).map(|p| (self.unit)([p[0], p[1]])));
            let mut units: Vec<u16> = units.collect();
            if units.last().is_some_and(|last| (0xd800..0xdc00).contains(last)) {
                self.high = units.pop();
            }
            for character in char::decode_utf16(units) {
                let character = character.unwrap_or(char::REPLACEMENT_CHARACTER);
                // The mark of the byte order.
                if self.started || character != '\u{feff}' {
                    self.out.extend(character.encode_utf8(&mut [0; 4]).bytes());
                }
                self.started = true;
            }
        }
        let count = self.out.len().min(buffer.len());
        buffer[..count].copy_from_slice(&self.out[..count]);
        self.out.drain(..count);
        Ok(count)
    }
}

/// Carriage returns as line feeds.
struct LineFeeds<R>(R);

impl<R: Read> Read for LineFeeds<R> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let count = self.0.read(buffer)?;
        buffer[..count].iter_mut().filter(|byte| **byte == b'\r').for_each(|byte| *byte = b'\n');
        Ok(count)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

    use super::super::csv_reader::from_reader;

    const PLAIN: &str = "t,x,y,theta,moment\n0,0,0,0,0.001\n0.01,0.0005,0,0,0.002\n";

    fn read(bytes: &[u8]) -> crate::Result<crate::flow::sensor_log::SensorLog> {
        from_reader(bytes, "log.csv")
    }

    #[test]
    fn the_same_log_is_read_in_every_form() {
        let plain = read(PLAIN.as_bytes()).unwrap();
        let wide = |order: fn(u16) -> [u8; 2]| -> Vec<u8> {
            core::iter::once(0xfeff).chain(PLAIN.encode_utf16()).flat_map(order).collect()
        };
        let continental = PLAIN.replace(',', ";").replace('.', ",");
        let forms: [(Vec<u8>, &str); 6] = [
            (wide(u16::to_le_bytes), "UTF-16"),
            (wide(u16::to_be_bytes), "UTF-16"),
            (PLAIN.replace('\n', "\r").into_bytes(), "carriage returns"),
            (continental.clone().into_bytes(), "comma"),
            (PLAIN.replace(',', "\t").into_bytes(), "tabs"),
            (continental.replace('\n', "\r\n").into_bytes(), "semicolons"),
        ];
        for (bytes, word) in forms {
            let log = read(&bytes).unwrap();
            assert_eq!(log.rows, plain.rows, "{word}");
            assert!(log.warnings.iter().any(|warning| warning.contains(word)), "{word}: {:?}", log.warnings);
        }
        assert!(plain.warnings.is_empty());
    }

    #[test]
    fn units_in_the_header_are_heeded() {
        let plain = read(PLAIN.as_bytes()).unwrap();
        let si = PLAIN.replace("t,x,y,theta,moment", "t [s],x (m),y [m],theta [rad],moment [N m]");
        assert_eq!(read(si.as_bytes()).unwrap().rows, plain.rows);
        let error = read(PLAIN.replace("t,x", "t [ms],x").as_bytes()).unwrap_err().to_string();
        assert!(error.contains("t [ms]") && error.contains("in s"), "{error}");
    }

    #[test]
    fn spreadsheets_are_named() {
        for (bytes, word) in
            [(&b"PK\x03\x04rest"[..], ".xlsx"), (b"\xd0\xcf\x11\xe0rest", ".xls"), (b"\x1f\x8b", "gzip")]
        {
            let error = read(bytes).unwrap_err().to_string();
            assert!(error.contains(word) && error.contains("help:"), "{error}");
        }
    }
}
