//! The records of an MCAP file, by the [MCAP specification](https://mcap.dev/spec): a byte for the kind, eight for the length, then
//! fields without padding, little-endian.

/// What a file begins and ends with.
pub(super) const MAGIC: [u8; 8] = *b"\x89MCAP0\r\n";
/// Bytes in front of every record's fields.
pub(super) const HEAD: usize = 9;

/// The kinds of records.
pub(super) mod op {
    pub(crate) const HEADER: u8 = 0x01;
    pub(crate) const FOOTER: u8 = 0x02;
    pub(crate) const SCHEMA: u8 = 0x03;
    pub(crate) const CHANNEL: u8 = 0x04;
    pub(crate) const MESSAGE: u8 = 0x05;
    pub(crate) const CHUNK: u8 = 0x06;
    pub(crate) const MESSAGE_INDEX: u8 = 0x07;
    pub(crate) const CHUNK_INDEX: u8 = 0x08;
    pub(crate) const STATISTICS: u8 = 0x0b;
    pub(crate) const SUMMARY_OFFSET: u8 = 0x0e;
    pub(crate) const DATA_END: u8 = 0x0f;
}

/// The kind of a record and the length of its fields (bytes), from the bytes in front of them.
pub(super) fn head(bytes: &[u8; HEAD]) -> (u8, u64) {
    let [kind, length @ ..] = *bytes;
    (kind, u64::from_le_bytes(length))
}

/// Reads fields in order; none where the record ends too early.
#[derive(Clone, Debug)]
pub(super) struct Fields<'a>(pub(super) &'a [u8]);

impl<'a> Fields<'a> {
    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(taken)
    }

    fn number<const N: usize>(&mut self) -> Option<[u8; N]> {
        self.take(N)?.try_into().ok()
    }

    pub(super) fn u16(&mut self) -> Option<u16> {
        self.number().map(u16::from_le_bytes)
    }

    pub(super) fn u32(&mut self) -> Option<u32> {
        self.number().map(u32::from_le_bytes)
    }

    pub(super) fn u64(&mut self) -> Option<u64> {
        self.number().map(u64::from_le_bytes)
    }

    /// As many bytes as a count of 64 bits in front of them says.
    pub(super) fn long_bytes(&mut self) -> Option<&'a [u8]> {
        let count = usize::try_from(self.u64()?).ok()?;
        self.take(count)
    }

    pub(super) fn text(&mut self) -> Option<&'a str> {
        let count = usize::try_from(self.u32()?).ok()?;
        core::str::from_utf8(self.take(count)?).ok()
    }
}

/// The fields of a record, written in order.
#[derive(Clone, Debug, Default)]
pub(super) struct Body(Vec<u8>);

impl Body {
    pub(super) fn u16(mut self, value: u16) -> Self {
        self.0.extend(value.to_le_bytes());
        self
    }

    pub(super) fn u32(mut self, value: u32) -> Self {
        self.0.extend(value.to_le_bytes());
        self
    }

    pub(super) fn u64(mut self, value: u64) -> Self {
        self.0.extend(value.to_le_bytes());
        self
    }

    /// Bytes without a count.
    pub(super) fn bytes(mut self, bytes: &[u8]) -> Self {
        self.0.extend(bytes);
        self
    }

    pub(super) fn text(self, text: &str) -> Self {
        self.counted(text.as_bytes())
    }

    /// Bytes behind a count of 32 bits: texts, lists and maps.
    pub(super) fn counted(self, bytes: &[u8]) -> Self {
        self.u32(bytes.len() as u32).bytes(bytes)
    }

    pub(super) fn into_bytes(self) -> Vec<u8> {
        self.0
    }

    /// The whole record, at the end of `file`.
    pub(super) fn write(self, kind: u8, file: &mut Vec<u8>) {
        file.push(kind);
        file.extend((self.0.len() as u64).to_le_bytes());
        file.extend(self.0);
    }
}

#[cfg(test)]
mod tests {
    use super::{Body, Fields, HEAD, head, op};

    #[test]
    fn fields_follow_each_other_without_padding() {
        let mut file = Vec::new();
        Body::default().u16(258).u32(1).u64(3).text("ab").counted(&[9]).bytes(&[7]).write(op::SCHEMA, &mut file);
        let by_hand: [&[u8]; 7] = [
            &[3, 26, 0, 0, 0, 0, 0, 0, 0], // the kind, and the length of what follows
            &[2, 1],
            &[1, 0, 0, 0],
            &[3, 0, 0, 0, 0, 0, 0, 0],
            &[2, 0, 0, 0, b'a', b'b'],
            &[1, 0, 0, 0, 9],
            &[7],
        ];
        assert_eq!(file, by_hand.concat());
        let (front, body) = file.split_at(HEAD);
        assert_eq!(head(front.try_into().unwrap()), (op::SCHEMA, 26));
        let mut fields = Fields(body);
        assert_eq!(
            (fields.u16(), fields.u32(), fields.u64(), fields.text()),
            (Some(258), Some(1), Some(3), Some("ab"))
        );
        assert_eq!(fields.0, [1, 0, 0, 0, 9, 7]);
    }

    #[test]
    fn nothing_is_read_beyond_the_end() {
        assert_eq!(Fields(&[1]).u16(), None);
        assert_eq!(Fields(&[0xff, 0xff, 0xff, 0xff, 1]).text(), None);
        assert_eq!(Fields(&[0xff; 12]).long_bytes(), None);
        assert_eq!(Fields(&[1, 0, 0, 0, 0xff]).text(), None, "not UTF-8");
    }
}
