//! Common Data Representation, the bytes of ROS 2 messages: numbers at multiples of their size behind four header bytes.

/// Reads the fields of one message in order; none where the message ends too early.
#[derive(Clone, Debug)]
pub(crate) struct CdrReader<'a> {
    body: &'a [u8],
    at: usize,
    little: bool,
}

impl<'a> CdrReader<'a> {
    /// A reader of plain CDR in either byte order; none for other encapsulations.
    pub(crate) fn new(message: &'a [u8]) -> Option<Self> {
        let (header, body) = message.split_at_checked(4)?;
        let little = match header[..2] {
            [0, 0] => false,
            [0, 1] => true,
            _ => return None,
        };
        Some(Self { body, at: 0, little })
    }

    /// The next `N` bytes, after the padding that numbers of this size have.
    fn number<const N: usize>(&mut self) -> Option<[u8; N]> {
        let start = self.at.checked_next_multiple_of(N)?;
        let bytes = self.body.get(start..start.checked_add(N)?)?;
        self.at = start + N;
        let mut number: [u8; N] = bytes.try_into().ok()?;
        if !self.little {
            number.reverse();
        }
        Some(number)
    }

    pub(crate) fn u32(&mut self) -> Option<u32> {
        self.number().map(u32::from_le_bytes)
    }

    pub(crate) fn i32(&mut self) -> Option<i32> {
        self.number().map(i32::from_le_bytes)
    }

    pub(crate) fn f32(&mut self) -> Option<f32> {
        self.number().map(f32::from_le_bytes)
    }

    pub(crate) fn f64(&mut self) -> Option<f64> {
        self.number().map(f64::from_le_bytes)
    }

    pub(crate) fn f64s<const N: usize>(&mut self) -> Option<[f64; N]> {
        let mut values = [0.0; N];
        for value in &mut values {
            *value = self.f64()?;
        }
        Some(values)
    }

    /// As many bytes as a count in front of them says.
    pub(crate) fn bytes(&mut self) -> Option<&'a [u8]> {
        let count = self.u32()? as usize;
        let bytes = self.body.get(self.at..self.at.checked_add(count)?)?;
        self.at += count;
        Some(bytes)
    }

    /// A text, which ends in a zero byte that counts.
    pub(crate) fn text(&mut self) -> Option<&'a str> {
        let bytes = self.bytes()?;
        core::str::from_utf8(bytes.strip_suffix(b"\0").unwrap_or(bytes)).ok()
    }
}

/// Writes the fields of one message in order, little-endian.
#[derive(Clone, Debug)]
pub(crate) struct CdrWriter {
    bytes: Vec<u8>,
}

impl CdrWriter {
    pub(crate) fn new() -> Self {
        Self { bytes: vec![0, 1, 0, 0] }
    }

    pub(crate) fn finish(self) -> Vec<u8> {
        self.bytes
    }

    fn number<const N: usize>(&mut self, number: [u8; N]) -> &mut Self {
        while !(self.bytes.len() - 4).is_multiple_of(N) {
            self.bytes.push(0);
        }
        self.bytes.extend(number);
        self
    }

    pub(crate) fn u8(&mut self, value: u8) -> &mut Self {
        self.number([value])
    }

    pub(crate) fn u32(&mut self, value: u32) -> &mut Self {
        self.number(value.to_le_bytes())
    }

    pub(crate) fn i32(&mut self, value: i32) -> &mut Self {
        self.number(value.to_le_bytes())
    }

    pub(crate) fn f32(&mut self, value: f32) -> &mut Self {
        self.number(value.to_le_bytes())
    }

    pub(crate) fn f64(&mut self, value: f64) -> &mut Self {
        self.number(value.to_le_bytes())
    }

    pub(crate) fn f64s(&mut self, values: &[f64]) -> &mut Self {
        values.iter().for_each(|&value| {
            self.f64(value);
        });
        self
    }

    /// A count, then the bytes; what no message holds is cut.
    pub(crate) fn bytes(&mut self, bytes: &[u8]) -> &mut Self {
        let count = u32::try_from(bytes.len()).unwrap_or(u32::MAX);
        self.u32(count).bytes.extend(&bytes[..count as usize]);
        self
    }

    pub(crate) fn text(&mut self, text: &str) -> &mut Self {
        self.u32(text.len() as u32 + 1).bytes.extend(text.as_bytes());
        self.u8(0)
    }
}

#[cfg(test)]
mod tests {
    use super::{CdrReader, CdrWriter};

    #[test]
    fn numbers_stand_at_multiples_of_their_size_behind_the_header() {
        let mut writer = CdrWriter::new();
        writer.u8(7).f64(1.0).text("ab").u32(258).i32(-2).f32(0.5).bytes(&[9]);
        let written = writer.finish();
        let by_hand: Vec<u8> = [
            &[0, 1, 0, 0][..],                        // plain CDR, little-endian
            &[7, 0, 0, 0, 0, 0, 0, 0],                // u8, then padding up to 8
            &[0, 0, 0, 0, 0, 0, 0xf0, 0x3f],          // 1.0
            &[3, 0, 0, 0, b'a', b'b', 0],             // text with its end counted
            &[0, 2, 1, 0, 0, 0xfe, 0xff, 0xff, 0xff], // padding, 258, -2
            &[0, 0, 0, 0x3f, 1, 0, 0, 0, 9],          // 0.5, one byte
        ]
        .concat();
        assert_eq!(written, by_hand);
    }

    #[test]
    fn both_byte_orders_are_read_and_nothing_beyond_the_end() {
        let big = [0, 0, 0, 0, 0, 0, 1, 2, 0, 0, 0, 0, 0x40, 0x08, 0, 0, 0, 0, 0, 0, 0, 0, 0, 3, b'x', b'y', 0];
        let mut reader = CdrReader::new(&big).unwrap();
        assert_eq!((reader.u32(), reader.f64(), reader.text()), (Some(258), Some(3.0), Some("xy")));
        assert_eq!((reader.u32(), reader.f64(), reader.text()), (None, None, None));
        let mut long = CdrReader::new(&[0, 1, 0, 0, 0xff, 0xff, 0xff, 0xff, 1]).unwrap();
        assert_eq!(long.bytes(), None, "a count beyond the end");
        assert!(CdrReader::new(&[0, 7, 0, 0, 1]).is_none() && CdrReader::new(&[0, 1]).is_none());
    }
}
