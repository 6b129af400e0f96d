//! Lines and packets out of bytes that come in pieces.

use crate::config::LONGEST_LINE;

/// What a stream of bytes falls into.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Piece {
    /// A line without its end; never empty.
    Line(String),
    /// A packet of bytes without zeros, without the zero at its end; never empty.
    Packet(Vec<u8>),
    /// A line that is no text, or too long for one.
    Noise,
    /// The end of a line whose beginning was not seen.
    Torn,
}

/// Puts bytes together to lines or packets. A line ends in `\n`, `\r` or both, so that a lost one of them does no harm; a packet ends
/// in a zero.
#[derive(Clone, Debug)]
pub struct LineSplitter {
    packets: bool,
    line: Vec<u8>,
    /// Whether the beginning of this line was not seen.
    torn: bool,
    /// Whether this line is too long.
    long: bool,
}

impl LineSplitter {
    /// A splitter; `torn` where the stream may begin in the middle of a line, as that of a serial port does: such a line may
    /// look whole though digits are missing.
    #[must_use]
    pub fn new(torn: bool) -> Self {
        Self { packets: false, line: Vec::new(), torn, long: false }
    }

    /// The same for packets.
    #[must_use]
    pub fn of_packets(torn: bool) -> Self {
        Self { packets: true, ..Self::new(torn) }
    }

    /// Takes bytes, and calls `found` with each piece that ends in them.
    pub fn push(&mut self, bytes: &[u8], mut found: impl FnMut(Piece)) {
        let packets = self.packets;
        let ends = |byte: &u8| if packets { *byte == 0 } else { matches!(byte, b'\n' | b'\r') };
        for part in bytes.split_inclusive(ends) {
            let (body, ended) = match part.split_last() {
                Some((last, body)) if ends(last) => (body, true),
                _ => (part, false),
            };
            if self.line.len() + body.len() > LONGEST_LINE {
                self.long = true;
                self.line.clear();
            } else {
                self.line.extend(body);
            }
            if ended && let Some(piece) = self.end() {
                found(piece);
            }
        }
    }

    /// Forgets the line that has begun: the stream broke off. Whether there was one.
    pub fn break_off(&mut self, torn: bool) -> bool {
        let begun = !self.line.is_empty() || self.long;
        *self = Self { packets: self.packets, ..Self::new(torn) };
        begun
    }

    fn end(&mut self) -> Option<Piece> {
        let (line, torn, long) =
            (core::mem::take(&mut self.line), core::mem::take(&mut self.torn), core::mem::take(&mut self.long));
        if torn && (long || !line.is_empty()) {
            return Some(Piece::Torn);
        }
        if long {
            return Some(Piece::Noise);
        }
        if self.packets {
            return (!line.is_empty()).then_some(Piece::Packet(line));
        }
        match String::from_utf8(line) {
            Ok(text) if text.trim().is_empty() => None,
            Ok(text) => Some(Piece::Line(text.trim().to_owned())),
            Err(_) => Some(Piece::Noise),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{LineSplitter, Piece};

    fn pieces(splitter: &mut LineSplitter, parts: &[&[u8]]) -> Vec<Piece> {
        let mut found = Vec::new();
        parts.iter().for_each(|part| splitter.push(part, |piece| found.push(piece)));
        found
    }

    fn line(text: &str) -> Piece {
        Piece::Line(text.to_owned())
    }

    #[test]
    fn lines_are_whole_however_the_bytes_come() {
        let text = b"1,2\r\n3,4\n\n5,6\r7,8\r\n9";
        let want = [line("1,2"), line("3,4"), line("5,6"), line("7,8")];
        for size in 1..text.len() {
            let parts: Vec<&[u8]> = text.chunks(size).collect();
            let mut splitter = LineSplitter::new(false);
            assert_eq!(pieces(&mut splitter, &parts), want, "{size}");
            assert!(splitter.break_off(false) && !splitter.break_off(false));
        }
    }

    #[test]
    fn torn_and_foreign_bytes_are_no_lines() {
        let mut splitter = LineSplitter::new(true);
        assert_eq!(
            pieces(&mut splitter, &[b"2,3\r\n4,5\n\xff\xfe\n6,7\n"]),
            [Piece::Torn, line("4,5"), Piece::Noise, line("6,7")]
        );
        let mut packets = LineSplitter::of_packets(true);
        let packet = |bytes: &[u8]| Piece::Packet(bytes.to_vec());
        assert_eq!(
            pieces(&mut packets, &[b"12\0\0\n\r", b"4\0", &[0xff, 0]]),
            [Piece::Torn, packet(b"\n\r4"), packet(b"\xff")]
        );
        assert!(!packets.break_off(true));
        assert_eq!(pieces(&mut packets, &[b"5\0", b"6\0"]), [Piece::Torn, packet(b"6")]);
        let long = vec![b'7'; 5000];
        assert_eq!(pieces(&mut splitter, &[&long, &long, b"\n8\n"]), [Piece::Noise, line("8")]);
    }
}
