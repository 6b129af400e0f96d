//! A chunk of an MCAP file that is being written: schemas, channels and messages together, with an index of the messages.

use super::records::{Body, op};
use std::collections::BTreeMap;

/// The least and the largest time of messages (ns).
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Bounds(Option<(u64, u64)>);

impl Bounds {
    pub(super) fn widen(&mut self, time: u64) {
        let (start, end) = self.0.unwrap_or((time, time));
        self.0 = Some((start.min(time), end.max(time)));
    }

    /// Both; zero where there was no message.
    pub(super) fn both(self) -> (u64, u64) {
        self.0.unwrap_or_default()
    }
}

/// Records that become one chunk, not compressed.
#[derive(Clone, Debug, Default)]
pub(super) struct Chunk {
    /// The records.
    pub(super) bytes: Vec<u8>,
    bounds: Bounds,
    /// By channel: time and place in the chunk of each message, as they are written.
    index: BTreeMap<u16, Vec<u8>>,
}

impl Chunk {
    /// Adds a message of a channel, its `sequence`-th one.
    pub(super) fn message(&mut self, channel: u16, sequence: u32, time: u64, message: &[u8]) {
        self.bounds.widen(time);
        let index = self.index.entry(channel).or_default();
        index.extend(time.to_le_bytes());
        index.extend((self.bytes.len() as u64).to_le_bytes());
        let header = Body::default().u16(channel).u32(sequence).u64(time).u64(time);
        header.bytes(message).write(op::MESSAGE, &mut self.bytes);
    }

    /// Writes the chunk and the indices of its messages behind what is in `file`, before which so many bytes were written; the
    /// fields of the index of the chunk itself.
    pub(super) fn write(self, written: u64, file: &mut Vec<u8>) -> Body {
        let end = |file: &Vec<u8>| written + file.len() as u64;
        let ((from, to), size, at) = (self.bounds.both(), self.bytes.len() as u64, end(file));
        let chunk = Body::default().u64(from).u64(to).u64(size).u32(crc32fast::hash(&self.bytes)).text("");
        chunk.u64(size).bytes(&self.bytes).write(op::CHUNK, file);
        let indices_at = end(file);
        let mut places = Body::default();
        for (channel, index) in self.index {
            places = places.u16(channel).u64(end(file));
            Body::default().u16(channel).counted(&index).write(op::MESSAGE_INDEX, file);
        }
        let index = Body::default().u64(from).u64(to).u64(at).u64(indices_at - at);
        let index = index.counted(&places.into_bytes()).u64(end(file) - indices_at);
        index.text("").u64(size).u64(size)
    }
}
