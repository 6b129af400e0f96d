//! The container, written while the messages come.

use super::container::Container;
use super::definition::Kind;
use super::growing_file::GrowingFile;
use super::message::Stamp;

/// A topic of a recording that is being streamed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StreamTopic(usize);

/// An MCAP recording whose bytes are handed over piece by piece; each piece ends between two records, so that a file of the
/// pieces so far is read up to its end, whenever it is cut off.
///
/// ```
/// use vibrissa_io::ros::{BagStream, Kind, Stamp, encode_text, read_bag};
///
/// let mut stream = BagStream::new();
/// let topic = stream.topic("/vibrissa/event", Kind::Text, false);
/// stream.push(topic, Stamp::from_seconds(1.0), &encode_text("contact"));
/// let mut file = stream.flush();
/// let mut seen = 0;
/// read_bag(&file[..], "cut.mcap", |_, _, _| { seen += 1; Ok(()) })?;
/// assert_eq!(seen, 1);
/// file.extend(stream.finish());
/// assert!(read_bag(&file[..], "whole.mcap", |_, _, _| Ok(()))?.warnings.is_empty());
/// # Ok::<(), vibrissa_core::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct BagStream {
    container: Container,
    /// For each topic its channel, and how many messages it had.
    topics: Vec<(u16, u32)>,
}

impl Default for BagStream {
    fn default() -> Self {
        Self::new()
    }
}

impl BagStream {
    /// A recording without messages.
    #[must_use]
    pub fn new() -> Self {
        Self { container: Container::begin(), topics: Vec::new() }
    }

    /// Adds a topic; `latched` ones are said once and hold until they are said again.
    pub fn topic(&mut self, name: impl Into<String>, kind: Kind, latched: bool) -> StreamTopic {
        let channel = self.container.channel(&(name.into(), kind, latched));
        self.topics.push((channel, 0));
        StreamTopic(self.topics.len() - 1)
    }

    /// Adds a message, logged at `stamp`.
    pub fn push(&mut self, topic: StreamTopic, stamp: Stamp, message: &[u8]) {
        let (channel, sequence) = &mut self.topics[topic.0];
        self.container.message(*channel, *sequence, stamp.nanoseconds(), message);
        *sequence = sequence.wrapping_add(1);
    }

    /// Counts messages of a topic that were left out: their places in the sequence stay empty, so that readers know.
    pub fn skip(&mut self, topic: StreamTopic, messages: u32) {
        let sequence = &mut self.topics[topic.0].1;
        *sequence = sequence.wrapping_add(messages);
    }

    /// Bytes that the next [`BagStream::flush`] would close a chunk of.
    #[must_use]
    pub fn open_bytes(&self) -> usize {
        self.container.open_bytes()
    }

    /// Closes the chunk that is open; the bytes since the last call, to be appended to the file.
    #[must_use]
    pub fn flush(&mut self) -> Vec<u8> {
        self.container.close_chunk();
        self.container.take()
    }

    /// The last bytes of the file: what was not flushed yet, and the summary, with an index of up to 1024 chunks.
    #[must_use]
    pub fn finish(self) -> Vec<u8> {
        self.container.finish()
    }

    /// Appends the same, with an index of however many chunks, to the file of all pieces so far, from which the index is read
    /// again; but for the last bytes, which are returned: they say that the file is whole, and are written when all before them
    /// is on the disk.
    ///
    /// # Errors
    ///
    /// What the file says; a part of the bytes may be there.
    pub fn finish_in(self, file: &mut dyn GrowingFile) -> std::io::Result<Vec<u8>> {
        self.container.finish_in(file)
    }
}
