//! The summary at the end of an MCAP file, written group by group.

use super::growing_file::{GrowingFile, Window};
use super::records::{Body, Fields, HEAD, MAGIC, head, op};
use std::io::{Error, Result};

/// Fields of a chunk before its records: times, size, checksum, the length of no name of a compression, the length of the records.
const CHUNK_FRONT: usize = 8 + 8 + 8 + 4 + 4 + 8;

/// A summary that is being written.
#[derive(Debug)]
pub(super) struct Summary {
    /// Where it begins and where it ends by now (bytes of the file).
    start: u64,
    end: u64,
    checksum: crc32fast::Hasher,
    /// Kind, place and length of each group.
    groups: Vec<(u8, u64, u64)>,
}

impl Summary {
    pub(super) fn begin(start: u64) -> Self {
        Self { start, end: start, checksum: crc32fast::Hasher::new(), groups: Vec::new() }
    }

    fn write(&mut self, records: &[u8], file: &mut Vec<u8>) {
        self.checksum.update(records);
        self.end += records.len() as u64;
        file.extend(records);
    }

    /// Adds records of a kind, to the group before where that is of the same kind.
    pub(super) fn group(&mut self, kind: u8, records: &[u8], file: &mut Vec<u8>) {
        let length = records.len() as u64;
        match self.groups.last_mut() {
            _ if records.is_empty() => {}
            Some(last) if last.0 == kind => last.2 += length,
            _ => self.groups.push((kind, self.end, length)),
        }
        self.write(records, file);
    }

    pub(super) fn groups(&mut self, groups: impl IntoIterator<Item = (u8, Vec<u8>)>, file: &mut Vec<u8>) {
        groups.into_iter().for_each(|(kind, records)| self.group(kind, &records, file));
    }

    /// Writes where the groups are, and the footer.
    pub(super) fn end(mut self, file: &mut Vec<u8>) {
        let offsets_at = self.end;
        let mut offsets = Vec::new();
        for (kind, place, length) in &self.groups {
            let offset = Body::default().bytes(&[*kind]).u64(*place).u64(*length);
            offset.write(op::SUMMARY_OFFSET, &mut offsets);
        }
        self.write(&offsets, file);
        // The summary's checksum covers the footer up to itself.
        let front = Body::default().u64(self.start).u64(offsets_at);
        let mut footer = Vec::new();
        front.clone().u32(0).write(op::FOOTER, &mut footer);
        self.checksum.update(&footer[..HEAD + 16]);
        front.u32(self.checksum.finalize()).write(op::FOOTER, file);
    }
}

/// The indices of the chunks of a file, made from the chunks and the indices of messages behind them: their memory does not
/// grow with the file.
#[derive(Debug)]
pub(super) struct ChunkIndices {
    /// The next record, and the end of the data.
    place: u64,
    end: u64,
}

impl ChunkIndices {
    /// The indices of chunks before a place.
    pub(super) fn new(end: u64) -> Self {
        Self { place: MAGIC.len() as u64, end }
    }

    /// Adds records of indices, until so many bytes are there; whether there were any.
    pub(super) fn read(&mut self, file: &mut dyn GrowingFile, enough: usize, records: &mut Vec<u8>) -> Result<bool> {
        let mut file = Window::new(file);
        while self.place < self.end && records.len() < enough {
            let (kind, length) = self.head(&mut file, self.place)?;
            if kind == op::CHUNK {
                self.chunk(&mut file, length, records)?;
            } else {
                self.place += HEAD as u64 + length;
            }
        }
        Ok(!records.is_empty())
    }

    fn head(&self, file: &mut Window<'_>, place: u64) -> Result<(u8, u64)> {
        let mut bytes = [0; HEAD];
        file.read(place, &mut bytes)?;
        let (kind, length) = head(&bytes);
        let fits =
            place.checked_add(HEAD as u64).and_then(|at| at.checked_add(length)).is_some_and(|at| at <= self.end);
        if fits { Ok((kind, length)) } else { Err(Error::other("the recording was changed while it was written")) }
    }

    /// Adds the index of the chunk at the present place, and goes behind it and the indices of its messages.
    fn chunk(&mut self, file: &mut Window<'_>, length: u64, records: &mut Vec<u8>) -> Result<()> {
        let at = self.place;
        let mut front = [0; CHUNK_FRONT];
        file.read(at + HEAD as u64, &mut front)?;
        let mut fields = Fields(&front);
        let (from, to, size) = (fields.u64(), fields.u64(), fields.u64());
        let (Some(from), Some(to), Some(size)) = (from, to, size) else { return Err(Error::other("no chunk")) };
        let indices_at = at + HEAD as u64 + length;
        let (mut places, mut place) = (Body::default(), indices_at);
        while place < self.end {
            let (kind, length) = self.head(file, place)?;
            if kind != op::MESSAGE_INDEX {
                break;
            }
            let mut channel = [0; 2];
            file.read(place + HEAD as u64, &mut channel)?;
            places = places.u16(u16::from_le_bytes(channel)).u64(place);
            place += HEAD as u64 + length;
        }
        let index = Body::default().u64(from).u64(to).u64(at).u64(indices_at - at);
        let index = index.counted(&places.into_bytes()).u64(place - indices_at);
        index.text("").u64(size).u64(size).write(op::CHUNK_INDEX, records);
        self.place = place;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::{BagStream, Kind, Stamp, encode_text};
    use super::ChunkIndices;

    /// Both ways to the index lead to the same file, and the index that is read again does not depend on its pieces.
    #[test]
    fn an_index_that_is_read_from_the_file_is_the_one_that_was_kept() {
        let mut stream = BagStream::new();
        let topics: Vec<_> = (0..5).map(|i| stream.topic(format!("/t{i}"), Kind::Text, i == 0)).collect();
        let mut file = Vec::new();
        for chunk in 0_u32..300 {
            // Some chunks hold no message of some topics, times go back, and one chunk is large.
            for message in 0..=(chunk * 7919 % 13) {
                let topic = topics[(chunk as usize * 31 + message as usize * 17) % topics.len()];
                let text = "x".repeat(if chunk == 150 { 5000 } else { (message * 37 % 200) as usize });
                stream.push(topic, Stamp::from_seconds(f64::from(chunk * 101 % 89)), &encode_text(&text));
            }
            file.extend(stream.flush());
        }
        let (data, whole) = (file.len() as u64, [file.clone(), stream.clone().finish()].concat());
        let mut ended = file.clone();
        let seal = stream.finish_in(&mut ended).unwrap();
        ended.extend(seal);
        assert!(ended == whole);
        for enough in [1, 1000, usize::MAX] {
            let (mut indices, mut all, mut piece) = (ChunkIndices::new(data), Vec::new(), Vec::new());
            while indices.read(&mut file, enough, &mut piece).unwrap() {
                all.append(&mut piece);
            }
            assert!(whole.windows(all.len()).any(|part| part == all), "pieces of {enough}");
            assert!(all.len() > 300 * 80);
        }
        let cut = &mut file[..file.len() / 2].to_vec();
        assert!(ChunkIndices::new(data).read(cut, usize::MAX, &mut Vec::new()).is_err());
    }

    /// Above what is kept in memory.
    #[test]
    fn a_long_recording_has_its_index_too() {
        let mut stream = BagStream::new();
        let topic = stream.topic("/t", Kind::Text, false);
        let (mut file, chunks) = (Vec::new(), 5000_u32);
        for chunk in 0..chunks {
            stream.push(topic, Stamp::from_seconds(f64::from(chunk)), &encode_text("x"));
            file.extend(stream.flush());
        }
        stream.push(topic, Stamp::from_seconds(f64::from(chunks)), &encode_text("not flushed"));
        let seal = stream.finish_in(&mut file).unwrap();
        file.extend(seal);
        let mut messages = 0;
        let summary = super::super::read_bag(&file[..], "long.mcap", |_, _, _| {
            messages += 1;
            Ok(())
        });
        assert!(summary.unwrap().warnings.is_empty());
        assert_eq!(messages, chunks + 1);
        // By the footer alone: the summary's place, its groups, and every chunk where the index says.
        let number = |at: usize| u64::from_le_bytes(file[at..at + 8].try_into().unwrap()) as usize;
        let footer = file.len() - 8 - 29;
        let (mut at, mut found) = (number(footer + 9), 0);
        while at < footer {
            if file[at] == super::op::CHUNK_INDEX {
                let chunk = number(at + 9 + 16);
                assert_eq!(file[chunk], super::op::CHUNK);
                assert_eq!(file[chunk + number(at + 9 + 24)], super::op::MESSAGE_INDEX);
                found += 1;
            }
            at += 9 + number(at + 1);
        }
        assert_eq!((at, found), (footer, chunks + 1));
    }
}
