//! The container, read: message by message, so that recordings with camera images need no more memory than a chunk.

use super::definition::Kind;
use super::records::{Fields, HEAD, MAGIC, head, op};
use crate::config::budgets::{INFLATED_BYTES, INFLATED_RATIO, LARGEST_CHUNK, LONGEST_NAME, MOST_TOPICS};
use crate::text::{beyond, short};
use crate::{Error, Result};
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

/// Reads an MCAP recording and calls `visit` with each message of a kind that we know: its topic, the time it was logged
/// (ns) and its bytes.
///
/// Chunks may be compressed by lz4 or zstd. A file that ends too early, as one does whose recorder was stopped, is read up
/// to there with a warning.
///
/// # Errors
///
/// What is not MCAP, is damaged, holds a chunk of more than 64 MiB or more than a thousand topics, or inflates to far more than its
/// size ([`crate::config::budgets`]); what `visit` finds at fault.
pub fn read_bag(
    mut source: impl Read,
    name: &str,
    mut visit: impl FnMut(&Topic, u64, &[u8]) -> Result<()>,
) -> Result<BagSummary> {
    let mut bag = Bag::default();
    match bag.records(&mut source, &mut visit) {
        Ok(()) => {}
        Err(Fault::Cut) if !bag.channels.is_empty() => {
            bag.summary.warnings.push("the recording ends in the middle of a record; what came before is used".into());
        }
        // What was not synchronised when the power went may hold anything; a recording that was closed has no such end.
        Err(Fault::Damaged(_) | Fault::Chunk(_)) if !bag.channels.is_empty() && !is_closed(&mut source) => {
            bag.summary
                .warnings
                .push("the recording was cut off and its last bytes are damaged; what came before is used".into());
        }
        Err(fault) => return Err(fault.told().in_file(name)),
    }
    Ok(bag.summary)
}

/// Whether the rest of a file ends as closed recordings do.
fn is_closed(source: &mut dyn Read) -> bool {
    let (mut last, mut piece) = (Vec::<u8>::new(), [0; 4096]);
    loop {
        match source.read(&mut piece) {
            Ok(count) if count > 0 => {
                last.extend(&piece[..count]);
                last.drain(..last.len().saturating_sub(MAGIC.len()));
            }
            _ => return last == MAGIC,
        }
    }
}

/// What is called with each message.
type Visit<'a> = dyn FnMut(&Topic, u64, &[u8]) -> Result<()> + 'a;

/// What ends the reading.
enum Fault {
    /// The file ends within a record.
    Cut,
    /// A record does not hold what it should.
    Damaged(&'static str),
    /// A chunk cannot be taken apart.
    Chunk(Error),
    Told(Error),
}

impl From<Error> for Fault {
    fn from(error: Error) -> Self {
        Self::Told(error)
    }
}

impl Fault {
    fn told(self) -> Error {
        match self {
            Self::Told(error) | Self::Chunk(error) => error,
            Self::Cut => Error::data("the recording ends before its first topic")
                .remedy("record again; was the recorder stopped at once?"),
            Self::Damaged(why) => Error::data("the recording is damaged")
                .value(why)
                .remedy("`mcap recover` saves what is whole; or record again"),
        }
    }
}

fn no_recording() -> Error {
    Error::data("not an MCAP recording")
        .value("it does not begin as MCAP files do")
        .remedy("convert other recordings with `ros2 bag convert`, or give a log .csv")
}

fn too_large(what: &str, bytes: u64) -> Error {
    Error::data(format!("{what} of the recording is too large"))
        .value(format!("{bytes} bytes"))
        .allowed(format!("up to {LARGEST_CHUNK} bytes"))
        .remedy("the file is damaged, or record with smaller chunks (`ros2 bag record --storage-preset-profile …`)")
}

fn too_long(what: &str, name: &str) -> Error {
    let remedy = "give it a shorter name, or leave it out: `mcap filter`";
    beyond(
        "a name in the recording is too long",
        format!("{what} of {} bytes, {}", name.len(), short(name)),
        LONGEST_NAME,
        remedy,
    )
}

fn inflates(inflated: u64, read: u64) -> Error {
    Error::data("the recording inflates to far more than its size")
        .value(format!("{read} bytes to {inflated} or more"))
        .allowed(format!("up to {INFLATED_BYTES} bytes, or {INFLATED_RATIO} times its size"))
        .remedy("the file is damaged or made to do harm; record again, or `mcap compress --compression none` elsewhere")
}

/// What was met so far.
#[derive(Default)]
struct Bag {
    schemas: BTreeMap<u16, String>,
    /// By channel: the index of its topic, and whether its messages are CDR.
    channels: BTreeMap<u16, (usize, bool)>,
    summary: BagSummary,
    /// Bytes of chunks so far, as they stand in the file and inflated.
    read: u64,
    inflated: u64,
}

impl Bag {
    /// Reads records up to the footer, or to the end of the file between two records.
    fn records(&mut self, source: &mut dyn Read, visit: &mut Visit) -> core::result::Result<(), Fault> {
        let mut bytes = Vec::new();
        if !filled(source, MAGIC.len(), &mut bytes)? {
            return Ok(());
        }
        if bytes != MAGIC {
            return Err(no_recording().into());
        }
        while filled(source, HEAD, &mut bytes)? {
            let (kind, length) = head(bytes[..].try_into().map_err(|_| Fault::Cut)?);
            let count = usize::try_from(length).ok().filter(|count| *count <= LARGEST_CHUNK);
            let Some(count) = count else { return self.oversized(source, length) };
            if !filled(source, count, &mut bytes)? && count > 0 {
                return Err(Fault::Cut);
            }
            match kind {
                // What follows the data is an index of it.
                op::FOOTER | op::DATA_END => break,
                op::CHUNK => {
                    self.read += bytes.len() as u64;
                    self.chunk(&bytes, visit)?;
                }
                _ => self.record(kind, &bytes, visit)?,
            }
        }
        Ok(())
    }

    /// A record that is too large to be one.
    fn oversized(&self, source: &mut dyn Read, length: u64) -> core::result::Result<(), Fault> {
        let cut = !self.channels.is_empty() && !is_closed(source);
        Err(if cut { Fault::Cut } else { too_large("a record", length).into() })
    }

    /// A record that may stand in a chunk.
    fn record(&mut self, kind: u8, body: &[u8], visit: &mut Visit) -> core::result::Result<(), Fault> {
        let mut fields = Fields(body);
        match kind {
            op::SCHEMA => {
                let fields = fields.u16().zip(fields.text());
                let (id, name) = fields.ok_or(Fault::Damaged("a schema's record is too short"))?;
                if name.len() > LONGEST_NAME {
                    return Err(too_long("a kind of message", name).into());
                }
                self.schemas.insert(id, name.to_owned());
            }
            op::CHANNEL => self.channel(fields).unwrap_or(Err(Fault::Damaged("a channel's record is too short")))?,
            op::MESSAGE => {
                let header = fields.u16().zip(fields.u32()).zip(fields.u64()).zip(fields.u64());
                let (((channel, _), time), _) = header.ok_or(Fault::Damaged("a message's record is too short"))?;
                if let Some((topic, true)) = self.channels.get(&channel) {
                    let topic = &self.summary.topics[*topic];
                    if topic.kind.is_some() {
                        visit(topic, time, fields.0)?;
                    }
                }
            }
            _ => {}
        }
        Ok(())
    }

    /// None where the record is too short.
    fn channel(&mut self, mut fields: Fields) -> Option<core::result::Result<(), Fault>> {
        let (id, schema) = (fields.u16()?, fields.u16()?);
        let (name, encoding) = (fields.text()?, fields.text()?);
        if self.channels.contains_key(&id) {
            return Some(Ok(()));
        }
        if name.len() > LONGEST_NAME {
            return Some(Err(too_long("a topic", name).into()));
        }
        if self.summary.topics.len() >= MOST_TOPICS {
            let remedy = "`mcap filter` keeps the topics that are needed";
            return Some(Err(beyond("the recording has too many topics", MOST_TOPICS + 1, MOST_TOPICS, remedy).into()));
        }
        let kind_name = self.schemas.get(&schema).cloned().unwrap_or_default();
        let topic = Topic { kind: Kind::from_name(&kind_name), kind_name, name: name.to_owned() };
        let is_cdr = encoding == "cdr";
        if topic.kind.is_some() && !is_cdr {
            self.summary.warnings.push(format!(
                "the topic {} is left out: its messages are {}, not cdr (ROS 2)",
                topic.name,
                short(encoding)
            ));
        }
        let known = self.summary.topics.iter().position(|t| *t == topic);
        let index = known.unwrap_or_else(|| {
            self.summary.topics.push(topic);
            self.summary.topics.len() - 1
        });
        self.channels.insert(id, (index, is_cdr));
        Some(Ok(()))
    }

    fn chunk(&mut self, body: &[u8], visit: &mut Visit) -> core::result::Result<(), Fault> {
        let chunk = ChunkHeader::read(body).ok_or(Fault::Damaged("a chunk's record is too short"))?;
        // What no chunk may say is damage, which `whole_chunk` tells.
        if chunk.size <= LARGEST_CHUNK as u64 {
            self.inflated = self.inflated.saturating_add(chunk.size);
        }
        if self.inflated > INFLATED_BYTES.max(INFLATED_RATIO.saturating_mul(self.read)) {
            return Err(inflates(self.inflated, self.read).into());
        }
        let whole = whole_chunk(&chunk).map_err(Fault::Chunk)?;
        if chunk.checksum != 0 && checksum(&whole) != chunk.checksum {
            return Err(Fault::Damaged("the checksum of a chunk is wrong"));
        }
        let mut rest = &whole[..];
        while let Some((front, body)) = rest.split_first_chunk() {
            let (kind, length) = head(front);
            let record = usize::try_from(length).ok().and_then(|n| body.split_at_checked(n));
            let (record, next) = record.ok_or(Fault::Damaged("a chunk ends in the middle of a record"))?;
            // Chunks hold no chunks.
            self.record(kind, record, visit)?;
            rest = next;
        }
        Ok(())
    }
}

/// Reads `count` bytes into `bytes`, or none at the end of the file; what a damaged file promises takes no memory before it is there.
fn filled(source: &mut dyn Read, count: usize, bytes: &mut Vec<u8>) -> core::result::Result<bool, Fault> {
    bytes.clear();
    let read = source.take(count as u64).read_to_end(bytes);
    match read.map_err(|e| Error::data("cannot read the recording").value(e))? {
        0 => Ok(false),
        read if read == count => Ok(true),
        _ => Err(Fault::Cut),
    }
}

/// A chunk as it stands in the file.
struct ChunkHeader<'a> {
    /// Its length when it is not compressed (bytes).
    size: u64,
    /// Zero where there is none.
    checksum: u32,
    compression: &'a str,
    data: &'a [u8],
}

impl<'a> ChunkHeader<'a> {
    fn read(body: &'a [u8]) -> Option<Self> {
        let mut fields = Fields(body);
        let (_from, _to) = (fields.u64()?, fields.u64()?);
        let (size, checksum) = (fields.u64()?, fields.u32()?);
        Some(Self { size, checksum, compression: fields.text()?, data: fields.long_bytes()? })
    }
}

/// CRC-32 as zip and PNG have it.
#[cfg(not(target_family = "wasm"))]
fn checksum(bytes: &[u8]) -> u32 {
    crc32fast::hash(bytes)
}

/// The same by its definition: the tables of the fast way do not compress, and would be a fortieth of a page.
#[cfg(target_family = "wasm")]
fn checksum(bytes: &[u8]) -> u32 {
    let shifted = |rest: u32| if rest & 1 == 1 { rest >> 1 ^ 0xedb8_8320 } else { rest >> 1 };
    !bytes.iter().fold(u32::MAX, |rest, &byte| (0..8).fold(rest ^ u32::from(byte), |rest, _| shifted(rest)))
}

/// The records of a chunk, decompressed.
fn whole_chunk<'a>(chunk: &ChunkHeader<'a>) -> Result<Cow<'a, [u8]>> {
    if chunk.size > LARGEST_CHUNK as u64 {
        return Err(too_large("a chunk", chunk.size));
    }
    #[cfg(not(target_family = "wasm"))]
    let size = chunk.size as usize;
    match chunk.compression {
        "" => Ok(Cow::Borrowed(chunk.data)),
        #[cfg(target_family = "wasm")]
        "lz4" | "zstd" => Err(Error::data("the recording is compressed, which is for the command")
            .value(chunk.compression)
            .allowed("none")
            .remedy("`mcap decompress IN.mcap -o OUT.mcap` changes it")),
        #[cfg(not(target_family = "wasm"))]
        "lz4" => inflated(&mut lz4_flex::frame::FrameDecoder::new(chunk.data), size).map(Cow::Owned),
        #[cfg(not(target_family = "wasm"))]
        "zstd" => {
            let decoder = ruzstd::decoding::StreamingDecoder::new(chunk.data);
            inflated(&mut decoder.map_err(|e| not_inflated(&e))?, size).map(Cow::Owned)
        }
        other => Err(Error::data("the recording is compressed in a way that is not read")
            .value(other)
            .allowed("none, lz4 or zstd")
            .remedy("`mcap compress --compression zstd IN.mcap -o OUT.mcap` changes it")),
    }
}

/// All that a decoder gives, which must be as much as the chunk says.
#[cfg(not(target_family = "wasm"))]
fn inflated(decoder: &mut dyn Read, size: usize) -> Result<Vec<u8>> {
    let mut whole = Vec::with_capacity(size);
    let read = decoder.take(size as u64).read_to_end(&mut whole).map_err(|e| not_inflated(&e))?;
    if read == size { Ok(whole) } else { Err(not_inflated(&format!("{read} of {size} bytes"))) }
}

#[cfg(not(target_family = "wasm"))]
fn not_inflated(why: &dyn core::fmt::Display) -> Error {
    Error::data("a chunk of the recording is damaged")
        .value(why)
        .remedy("`mcap recover` saves what is whole; or record again")
}
