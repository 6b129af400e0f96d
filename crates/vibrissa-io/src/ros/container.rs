//! An MCAP file that grows, and what its summary will say: what a whole recording and a stream have in common.

use super::chunk::{Bounds, Chunk};
use super::definition::Kind;
use super::records::{Body, HEAD, MAGIC, op};
use std::collections::BTreeMap;

/// What ROS 2 tells late subscribers of: the last message of a topic that is said once.
const LATCHED: &str = "- history: 1\n  depth: 1\n  reliability: 1\n  durability: 1\n  deadline:\n    sec: 9223372036\n    \
                       nsec: 854775807\n  lifespan:\n    sec: 9223372036\n    nsec: 854775807\n  liveliness: 1\n  \
                       liveliness_lease_duration:\n    sec: 9223372036\n    nsec: 854775807\n  \
                       avoid_ros_namespace_conventions: false";

/// A chunk of this size is closed before the next message (bytes).
pub(super) const CHUNK_SIZE: usize = 1 << 20;

/// Most chunks that the summary has an index of: 20 MB. Longer recordings are read without one, from their beginning.
const MOST_INDEXED: u32 = 1 << 17;

/// A topic: its name, the kind of its messages, and whether the last one holds until it is said again.
pub(super) type NewTopic = (String, Kind, bool);

/// An MCAP file that grows, and what its summary will say.
#[derive(Clone, Debug, Default)]
pub(super) struct Container {
    /// Bytes that were not taken yet, and how many were before them.
    bytes: Vec<u8>,
    taken: u64,
    checksum: crc32fast::Hasher,
    chunk: Option<Chunk>,
    /// Every definition and every channel once; their numbers count from 1.
    kinds: Vec<Kind>,
    topics: Vec<NewTopic>,
    /// Their records, and those of the indices of chunks, for the summary.
    schema_records: Vec<u8>,
    channel_records: Vec<u8>,
    chunk_indices: Vec<u8>,
    chunks: u32,
    bounds: Bounds,
    /// Messages by channel.
    counts: BTreeMap<u16, u64>,
}

impl Container {
    pub(super) fn begin() -> Self {
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
    pub(super) fn channel(&mut self, topic: &NewTopic) -> u16 {
        let schema = self.schema(topic.1);
        let known = self.topics.iter().position(|other| other == topic);
        let number = known.unwrap_or(self.topics.len()) as u16 + 1;
        if known.is_none() {
            self.topics.push(topic.clone());
            let (name, _, latched) = topic;
            let metadata = Body::default().text("offered_qos_profiles").text(if *latched { LATCHED } else { "" });
            let body = Body::default().u16(number).u16(schema).text(name).text("cdr");
            let body = body.counted(&metadata.into_bytes());
            body.clone().write(op::CHANNEL, &mut self.channel_records);
            body.write(op::CHANNEL, &mut self.chunk.get_or_insert_default().bytes);
        }
        number
    }

    pub(super) fn message(&mut self, channel: u16, sequence: u32, time: u64, message: &[u8]) {
        self.bounds.widen(time);
        *self.counts.entry(channel).or_default() += 1;
        if self.chunk.as_ref().is_some_and(|chunk| chunk.bytes.len() > CHUNK_SIZE) {
            self.close_chunk();
        }
        self.chunk.get_or_insert_default().message(channel, sequence, time, message);
    }

    /// Ends the chunk that is open, if there is one.
    pub(super) fn close_chunk(&mut self) {
        if let Some(chunk) = self.chunk.take() {
            chunk.write(self.taken, &mut self.bytes).write(op::CHUNK_INDEX, &mut self.chunk_indices);
            self.chunks += 1;
            if self.chunks > MOST_INDEXED {
                self.chunk_indices.clear();
            }
        }
    }

    /// Bytes that wait in the chunk that is open.
    pub(super) fn open_bytes(&self) -> usize {
        self.chunk.as_ref().map_or(0, |chunk| chunk.bytes.len())
    }

    /// The bytes since the last call, without those of the chunk that is open.
    pub(super) fn take(&mut self) -> Vec<u8> {
        self.checksum.update(&self.bytes);
        self.taken += self.bytes.len() as u64;
        core::mem::take(&mut self.bytes)
    }

    /// The rest of the file, with its summary.
    pub(super) fn finish(mut self) -> Vec<u8> {
        self.close_chunk();
        let statistics = self.statistics();
        let mut file = self.bytes;
        self.checksum.update(&file);
        Body::default().u32(self.checksum.finalize()).write(op::DATA_END, &mut file);
        let summary = file.len();
        let at = |length: usize| self.taken + length as u64;
        let mut offsets = Vec::new();
        let groups = [
            (op::SCHEMA, self.schema_records),
            (op::CHANNEL, self.channel_records),
            (op::STATISTICS, statistics),
            (op::CHUNK_INDEX, self.chunk_indices),
        ];
        for (kind, records) in groups.into_iter().filter(|(_, records)| !records.is_empty()) {
            let offset = Body::default().bytes(&[kind]).u64(at(file.len())).u64(records.len() as u64);
            offset.write(op::SUMMARY_OFFSET, &mut offsets);
            file.extend(records);
        }
        let offsets_at = at(file.len());
        file.extend(offsets);
        // The summary's checksum covers the footer up to itself.
        let front = Body::default().u64(at(summary)).u64(offsets_at);
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
