//! The container, written.

use super::chunk::{Bounds, Chunk};
use super::definition::Kind;
use super::message::Stamp;
use super::records::{Body, HEAD, MAGIC, op};
use crate::{Error, Result};
use std::collections::BTreeMap;

/// A topic of a recording that is being written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TopicId(usize);

/// Collects messages and makes an MCAP recording of them, in order of time.
#[derive(Clone, Debug, Default)]
pub struct BagWriter {
    topics: Vec<(String, Kind, bool)>,
    messages: Vec<(Stamp, TopicId, Vec<u8>)>,
}

/// What ROS 2 tells late subscribers of: the last message of a topic that is said once.
const LATCHED: &str = "- history: 1\n  depth: 1\n  reliability: 1\n  durability: 1\n  deadline:\n    sec: 9223372036\n    \
                       nsec: 854775807\n  lifespan:\n    sec: 9223372036\n    nsec: 854775807\n  liveliness: 1\n  \
                       liveliness_lease_duration:\n    sec: 9223372036\n    nsec: 854775807\n  \
                       avoid_ros_namespace_conventions: false";

/// A chunk of this size is closed before the next message (bytes).
const CHUNK_SIZE: usize = 1 << 20;

impl BagWriter {
    /// Adds a topic; `latched` ones are said once and hold until they are said again.
    pub fn topic(&mut self, name: impl Into<String>, kind: Kind, latched: bool) -> TopicId {
        self.topics.push((name.into(), kind, latched));
        TopicId(self.topics.len() - 1)
    }

    /// Adds a message.
    pub fn push(&mut self, topic: TopicId, stamp: Stamp, message: Vec<u8>) {
        self.messages.push((stamp, topic, message));
    }

    /// The bytes of the file: indexed, in chunks, not compressed; the same messages give the same bytes.
    ///
    /// # Errors
    ///
    /// More topics than a recording holds.
    pub fn finish(mut self) -> Result<Vec<u8>> {
        self.messages.sort_by_key(|(stamp, ..)| *stamp);
        if self.topics.len() > usize::from(u16::MAX) {
            return Err(Error::data("cannot make an MCAP recording")
                .value(format!("{} topics", self.topics.len()))
                .allowed(format!("up to {}", u16::MAX))
                .remedy("leave out some whiskers"));
        }
        Ok(self.write())
    }

    fn write(&self) -> Vec<u8> {
        let mut file = File::begin();
        let channels: Vec<u16> = self.topics.iter().map(|topic| file.channel(topic)).collect();
        let mut sequences = vec![0; channels.len()];
        for (stamp, topic, message) in &self.messages {
            file.message(channels[topic.0], sequences[topic.0], stamp.nanoseconds(), message);
            sequences[topic.0] += 1;
        }
        file.finish()
    }
}

/// An MCAP file that grows, and what its summary will say.
#[derive(Debug, Default)]
struct File<'a> {
    bytes: Vec<u8>,
    chunk: Option<Chunk>,
    /// Every definition and every channel once; their numbers count from 1.
    kinds: Vec<Kind>,
    topics: Vec<&'a (String, Kind, bool)>,
    /// Their records, and those of the indices of chunks, for the summary.
    schema_records: Vec<u8>,
    channel_records: Vec<u8>,
    chunk_indices: Vec<u8>,
    chunks: u32,
    bounds: Bounds,
    /// Messages by channel.
    counts: BTreeMap<u16, u64>,
}

impl<'a> File<'a> {
    fn begin() -> Self {
        let mut bytes = MAGIC.to_vec();
        Body::default().text("ros2").text("vibrissa").write(op::HEADER, &mut bytes);
        Self { bytes, ..Self::default() }
    }

    /// The number of the schema of messages of a kind.
    fn schema(&mut self, kind: Kind) -> u16 {
        let known = self.kinds.iter().position(|other| *other == kind);
        let number = known.unwrap_or(self.kinds.len()) as u16 + 1;
        if known.is_none() {
            self.kinds.push(kind);
            let body = Body::default().u16(number).text(kind.name()).text("ros2msg");
            let body = body.counted(kind.definition().as_bytes());
            body.clone().write(op::SCHEMA, &mut self.schema_records);
            body.write(op::SCHEMA, &mut self.chunk.get_or_insert_default().bytes);
        }
        number
    }

    /// The number of the channel of a topic.
    fn channel(&mut self, topic: &'a (String, Kind, bool)) -> u16 {
        let schema = self.schema(topic.1);
        let known = self.topics.iter().position(|other| *other == topic);
        let number = known.unwrap_or(self.topics.len()) as u16 + 1;
        if known.is_none() {
            self.topics.push(topic);
            let (name, _, latched) = topic;
            let metadata = Body::default().text("offered_qos_profiles").text(if *latched { LATCHED } else { "" });
            let body = Body::default().u16(number).u16(schema).text(name).text("cdr");
            let body = body.counted(&metadata.into_bytes());
            body.clone().write(op::CHANNEL, &mut self.channel_records);
            body.write(op::CHANNEL, &mut self.chunk.get_or_insert_default().bytes);
        }
        number
    }

    fn message(&mut self, channel: u16, sequence: u32, time: u64, message: &[u8]) {
        self.bounds.widen(time);
        *self.counts.entry(channel).or_default() += 1;
        if self.chunk.as_ref().is_some_and(|chunk| chunk.bytes.len() > CHUNK_SIZE) {
            self.close_chunk();
        }
        self.chunk.get_or_insert_default().message(channel, sequence, time, message);
    }

    fn close_chunk(&mut self) {
        if let Some(chunk) = self.chunk.take() {
            chunk.write(&mut self.bytes).write(op::CHUNK_INDEX, &mut self.chunk_indices);
            self.chunks += 1;
        }
    }

    /// The whole file, with its summary.
    fn finish(mut self) -> Vec<u8> {
        self.close_chunk();
        let statistics = self.statistics();
        let mut file = self.bytes;
        let checksum = crc32fast::hash(&file);
        Body::default().u32(checksum).write(op::DATA_END, &mut file);
        let summary = file.len();
        let mut offsets = Vec::new();
        let groups = [
            (op::SCHEMA, self.schema_records),
            (op::CHANNEL, self.channel_records),
            (op::STATISTICS, statistics),
            (op::CHUNK_INDEX, self.chunk_indices),
        ];
        for (kind, records) in groups.into_iter().filter(|(_, records)| !records.is_empty()) {
            let offset = Body::default().bytes(&[kind]).u64(file.len() as u64).u64(records.len() as u64);
            offset.write(op::SUMMARY_OFFSET, &mut offsets);
            file.extend(records);
        }
        let offsets_at = file.len() as u64;
        file.extend(offsets);
        // The summary's checksum covers the footer up to itself.
        let front = Body::default().u64(summary as u64).u64(offsets_at);
        let mut footer = Vec::new();
        front.clone().u32(0).write(op::FOOTER, &mut footer);
        let mut hasher = crc32fast::Hasher::new();
        hasher.update(&file[summary..]);
        hasher.update(&footer[..HEAD + 16]);
        front.u32(hasher.finalize()).write(op::FOOTER, &mut file);
        file.extend(MAGIC);
        file
    }

    fn statistics(&self) -> Vec<u8> {
        let ((from, to), mut counts) = (self.bounds.both(), Body::default());
        for (channel, count) in &self.counts {
            counts = counts.u16(*channel).u64(*count);
        }
        let body = Body::default().u64(self.counts.values().sum()).u16(self.kinds.len() as u16);
        // No attachments and no metadata.
        let body = body.u32(self.topics.len() as u32).u32(0).u32(0).u32(self.chunks);
        let mut record = Vec::new();
        body.u64(from).u64(to).counted(&counts.into_bytes()).write(op::STATISTICS, &mut record);
        record
    }
}
