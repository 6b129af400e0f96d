//! The container, read: message by message, so that recordings with camera images need no more memory than a chunk.

use super::definition::Kind;
use crate::config::limits::LARGEST_CHUNK;
use crate::{Error, Result};
use mcap::records::{ChunkHeader, Record};
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::{McapError, parse_record};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::Read;

/// A topic of a recording.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Topic {
    /// Its name, `/odom`.
    pub name: String,
    /// The name of its messages' kind as written, `nav_msgs/msg/Odometry`.
    pub kind_name: String,
    /// The kind, where it is one that we know.
    pub kind: Option<Kind>,
}

/// What a reader learns of a recording as a whole.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BagSummary {
    /// Every topic, in order of appearance.
    pub topics: Vec<Topic>,
    /// What looked wrong but could be read, for people.
    pub warnings: Vec<String>,
}

/// Most bytes that are asked for at once: what a damaged file promises need not be there.
const STEP: usize = 1 << 20;

/// Reads an MCAP recording and calls `visit` with each message of a kind that we know: its topic, the time it was logged
/// (ns) and its bytes.
///
/// Chunks may be compressed by lz4 or zstd. A file that ends too early, as one does whose recorder was stopped, is read up
/// to there with a warning.
///
/// # Errors
///
/// What is not MCAP, is damaged, or holds a chunk of more than 256 MiB; what `visit` finds at fault.
pub fn read_bag(
    mut source: impl Read,
    name: &str,
    mut visit: impl FnMut(&Topic, u64, &[u8]) -> Result<()>,
) -> Result<BagSummary> {
    let options = LinearReaderOptions::default()
        .with_emit_chunks(true)
        .with_skip_end_magic(true)
        .with_record_length_limit(LARGEST_CHUNK);
    let mut reader = LinearReader::new_with_options(options);
    let mut bag = Bag::default();
    let done = loop {
        match reader.next_event() {
            None => break Ok(()),
            Some(Ok(LinearReadEvent::ReadRequest(wanted))) => {
                if wanted > LARGEST_CHUNK {
                    break Err(Fault::Ours(too_large("a record", wanted as u64)));
                }
                let room = reader.insert(wanted.min(STEP));
                let count = source.read(room).map_err(|e| Error::data("cannot read the recording").value(e));
                match count {
                    Ok(count) => reader.notify_read(count),
                    Err(error) => break Err(Fault::Ours(error)),
                }
            }
            Some(Ok(LinearReadEvent::Record { data, opcode })) => {
                if let Err(fault) = bag.record(opcode, data, &mut visit) {
                    break Err(fault);
                }
            }
            Some(Err(error)) => break Err(Fault::Container(error)),
        }
    };
    match done {
        Ok(()) => {}
        Err(Fault::Container(McapError::UnexpectedEof)) if !bag.channels.is_empty() => {
            bag.summary.warnings.push("the recording ends in the middle of a record; what came before is used".into());
        }
        Err(fault) => return Err(fault.told(name)),
    }
    Ok(bag.summary)
}

/// Who found what is wrong.
enum Fault {
    Container(McapError),
    Ours(Error),
}

impl From<McapError> for Fault {
    fn from(error: McapError) -> Self {
        Self::Container(error)
    }
}

impl From<Error> for Fault {
    fn from(error: Error) -> Self {
        Self::Ours(error)
    }
}

impl Fault {
    fn told(self, name: &str) -> Error {
        match self {
            Self::Ours(error) => error,
            Self::Container(McapError::BadMagic) => Error::data("not an MCAP recording")
                .value("it does not begin as MCAP files do")
                .remedy("convert other recordings with `ros2 bag convert`, or give a log .csv"),
            Self::Container(McapError::UnexpectedEof) => Error::data("the recording ends before its first topic")
                .remedy("record again; was the recorder stopped at once?"),
            Self::Container(error) => Error::data("the recording is damaged")
                .value(error)
                .remedy("`mcap recover` saves what is whole; or record again"),
        }
        .in_file(name)
    }
}

fn too_large(what: &str, bytes: u64) -> Error {
    Error::data(format!("{what} of the recording is too large"))
        .value(format!("{bytes} bytes"))
        .allowed(format!("up to {LARGEST_CHUNK} bytes"))
        .remedy("the file is damaged, or record with smaller chunks (`ros2 bag record --storage-preset-profile …`)")
}

/// What was met so far.
#[derive(Default)]
struct Bag {
    schemas: BTreeMap<u16, String>,
    /// By channel: the index of its topic, and whether its messages are CDR.
    channels: BTreeMap<u16, (usize, bool)>,
    summary: BagSummary,
}

impl Bag {
    fn record(
        &mut self,
        opcode: u8,
        data: &[u8],
        visit: &mut impl FnMut(&Topic, u64, &[u8]) -> Result<()>,
    ) -> core::result::Result<(), Fault> {
        match parse_record(opcode, data)? {
            Record::Schema { header, .. } => {
                self.schemas.insert(header.id, header.name);
            }
            Record::Channel(channel) => self.channel(channel),
            Record::Message { header, data } => {
                if let Some((topic, true)) = self.channels.get(&header.channel_id) {
                    let topic = &self.summary.topics[*topic];
                    if topic.kind.is_some() {
                        visit(topic, header.log_time, &data)?;
                    }
                }
            }
            Record::Chunk { header, data } => self.chunk(&header, &data, visit)?,
            _ => {}
        }
        Ok(())
    }

    fn channel(&mut self, channel: mcap::records::Channel) {
        if self.channels.contains_key(&channel.id) {
            return;
        }
        let kind_name = self.schemas.get(&channel.schema_id).cloned().unwrap_or_default();
        let topic = Topic { kind: Kind::from_name(&kind_name), kind_name, name: channel.topic };
        let is_cdr = channel.message_encoding == "cdr";
        if topic.kind.is_some() && !is_cdr {
            self.summary.warnings.push(format!(
                "the topic {} is left out: its messages are {}, not cdr (ROS 2)",
                topic.name, channel.message_encoding
            ));
        }
        let known = self.summary.topics.iter().position(|t| *t == topic);
        let index = known.unwrap_or_else(|| {
            self.summary.topics.push(topic);
            self.summary.topics.len() - 1
        });
        self.channels.insert(channel.id, (index, is_cdr));
    }

    fn chunk(
        &mut self,
        header: &ChunkHeader,
        data: &[u8],
        visit: &mut impl FnMut(&Topic, u64, &[u8]) -> Result<()>,
    ) -> core::result::Result<(), Fault> {
        let whole = whole_chunk(header, data)?;
        if header.uncompressed_crc != 0 && crc32fast::hash(&whole) != header.uncompressed_crc {
            return Err(not_inflated(&"its checksum is wrong").into());
        }
        let mut rest = &whole[..];
        while let Some((head, body)) = rest.split_at_checked(9) {
            let length = head[1..].iter().rev().fold(0, |n: u64, &b| n << 8 | u64::from(b));
            let Some((record, next)) = usize::try_from(length).ok().and_then(|n| body.split_at_checked(n)) else {
                return Err(McapError::UnexpectedEoc.into());
            };
            // Chunks hold no chunks.
            if head[0] != mcap::records::op::CHUNK {
                self.record(head[0], record, visit)?;
            }
            rest = next;
        }
        Ok(())
    }
}

/// The records of a chunk, decompressed.
fn whole_chunk<'a>(header: &ChunkHeader, data: &'a [u8]) -> Result<Cow<'a, [u8]>> {
    if header.uncompressed_size > LARGEST_CHUNK as u64 {
        return Err(too_large("a chunk", header.uncompressed_size));
    }
    let size = header.uncompressed_size as usize;
    match header.compression.as_str() {
        "" => Ok(Cow::Borrowed(data)),
        "lz4" => inflated(lz4_flex::frame::FrameDecoder::new(data), size).map(Cow::Owned),
        "zstd" => {
            let decoder = ruzstd::decoding::StreamingDecoder::new(data).map_err(|e| not_inflated(&e))?;
            inflated(decoder, size).map(Cow::Owned)
        }
        other => Err(Error::data("the recording is compressed in a way that is not read")
            .value(other)
            .allowed("none, lz4 or zstd")
            .remedy("`mcap compress --compression zstd IN.mcap -o OUT.mcap` changes it")),
    }
}

/// All that a decoder gives, which must be as much as the chunk says.
fn inflated(decoder: impl Read, size: usize) -> Result<Vec<u8>> {
    let mut whole = Vec::new();
    let read = decoder.take(size as u64).read_to_end(&mut whole).map_err(|e| not_inflated(&e))?;
    if read == size { Ok(whole) } else { Err(not_inflated(&format!("{read} of {size} bytes"))) }
}

fn not_inflated(why: &dyn core::fmt::Display) -> Error {
    Error::data("a chunk of the recording is damaged")
        .value(why)
        .remedy("`mcap recover` saves what is whole; or record again")
}
