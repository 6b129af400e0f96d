//! An MCAP file that grows, and what its summary will say: what a whole recording and a stream have in common.

use super::chunk::{Bounds, Chunk};
use super::definition::Kind;
use super::growing_file::GrowingFile;
use super::records::{Body, HEAD, MAGIC, op};
use super::summary::{ChunkIndices, Summary};
use std::collections::BTreeMap;
use std::io::Result;

/// What ROS 2 tells late subscribers of: the last message of a topic that is said once.
const LATCHED: &str = "- history: 1\n  depth: 1\n  reliability: 1\n  durability: 1\n  deadline:\n    sec: 9223372036\n    \
                       nsec: 854775807\n  lifespan:\n    sec: 9223372036\n    nsec: 854775807\n  liveliness: 1\n  \
                       liveliness_lease_duration:\n    sec: 9223372036\n    nsec: 854775807\n  \
                       avoid_ros_namespace_conventions: false";

/// A chunk of this size is closed before the next message (bytes).
pub(super) const CHUNK_SIZE: usize = 1 << 20;

/// Most chunks whose index is kept in memory until the end: four minutes of a live run. The index of more is read from the file again.
const MOST_KEPT: u32 = 1 << 10;
/// Index that is handed over at once where it is read from the file (bytes).
const INDEX_PIECE: usize = 64 << 10;

/// The record between data and summary (bytes).
const DATA_END: u64 = HEAD as u64 + 4;

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
            if !self.keeps_index() {
                self.chunk_indices = Vec::new();
            }
        }
    }

    fn keeps_index(&self) -> bool {
        self.chunks <= MOST_KEPT
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

    /// The rest of the file, with its summary; without an index where it was not kept.
    pub(super) fn finish(mut self) -> Vec<u8> {
        self.close_chunk();
        let mut file = self.take();
        file.extend(self.data_end());
        let mut summary = Summary::begin(self.taken + DATA_END);
        summary.groups(self.definitions(), &mut file);
        summary.group(op::CHUNK_INDEX, &self.chunk_indices, &mut file);
        summary.end(&mut file);
        file.extend(MAGIC);
        file
    }

    /// Appends the rest of the file, with its summary, to the file of all bytes that were taken, but for the last bytes, which
    /// are returned.
    pub(super) fn finish_in(mut self, file: &mut dyn GrowingFile) -> Result<Vec<u8>> {
        self.close_chunk();
        let mut piece = self.take();
        file.append(&piece)?;
        piece = self.data_end();
        let mut summary = Summary::begin(self.taken + DATA_END);
        summary.groups(self.definitions(), &mut piece);
        if self.keeps_index() {
            summary.group(op::CHUNK_INDEX, &self.chunk_indices, &mut piece);
        } else {
            let mut index = ChunkIndices::new(self.taken);
            let mut records = Vec::new();
            while index.read(file, INDEX_PIECE, &mut records)? {
                summary.group(op::CHUNK_INDEX, &records, &mut piece);
                file.append(&piece)?;
                piece.clear();
                records.clear();
            }
        }
        summary.end(&mut piece);
        file.append(&piece)?;
        Ok(MAGIC.to_vec())
    }

    fn data_end(&self) -> Vec<u8> {
        let mut record = Vec::new();
        Body::default().u32(self.checksum.clone().finalize()).write(op::DATA_END, &mut record);
        record
    }

    /// What the summary repeats, and what it counts.
    fn definitions(&mut self) -> [(u8, Vec<u8>); 3] {
        let statistics = self.statistics();
        [
            (op::SCHEMA, core::mem::take(&mut self.schema_records)),
            (op::CHANNEL, core::mem::take(&mut self.channel_records)),
            (op::STATISTICS, statistics),
        ]
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
