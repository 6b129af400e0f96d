//! Files that grow at their end.

use std::io::Result;

/// A file that grows at its end, and can be read again.
pub trait GrowingFile {
    /// Writes bytes at the end.
    ///
    /// # Errors
    ///
    /// What the system says; a part of the bytes may be there.
    fn append(&mut self, bytes: &[u8]) -> Result<()>;

    /// Reads what stands at a place (bytes from the beginning); how many bytes, 0 at the end.
    ///
    /// # Errors
    ///
    /// What the system says.
    fn read_at(&mut self, place: u64, buffer: &mut [u8]) -> Result<usize>;
}

/// A file that is read here and there from front to back, by few and larger reads.
pub(super) struct Window<'a> {
    file: &'a mut dyn GrowingFile,
    /// Where the bytes stand that were read last.
    place: u64,
    bytes: Vec<u8>,
}

/// How much is read at once (bytes): some chunks of a recording, which have a few kilobytes each.
const WINDOW: usize = 64 << 10;

impl<'a> Window<'a> {
    pub(super) fn new(file: &'a mut dyn GrowingFile) -> Self {
        Self { file, place: 0, bytes: Vec::new() }
    }

    /// Reads a whole buffer at a place.
    pub(super) fn read(&mut self, place: u64, buffer: &mut [u8]) -> Result<()> {
        if !self.holds(place, buffer.len()) {
            self.fill(place, buffer.len())?;
        }
        let at = (place - self.place) as usize;
        buffer.copy_from_slice(&self.bytes[at..at + buffer.len()]);
        Ok(())
    }

    fn holds(&self, place: u64, length: usize) -> bool {
        place >= self.place && place.saturating_add(length as u64) <= self.place + self.bytes.len() as u64
    }

    /// Reads what stands at a place, at least so much.
    fn fill(&mut self, place: u64, least: usize) -> Result<()> {
        self.place = place;
        self.bytes.resize(WINDOW.max(least), 0);
        let mut length = 0;
        while length < least {
            match self.file.read_at(place + length as u64, &mut self.bytes[length..]) {
                Ok(0) => {
                    self.bytes.clear();
                    return Err(std::io::ErrorKind::UnexpectedEof.into());
                }
                Ok(count) => length += count,
                Err(error) if error.kind() == std::io::ErrorKind::Interrupted => {}
                Err(error) => {
                    self.bytes.clear();
                    return Err(error);
                }
            }
        }
        self.bytes.truncate(length);
        Ok(())
    }
}

impl GrowingFile for Vec<u8> {
    fn append(&mut self, bytes: &[u8]) -> Result<()> {
        self.extend(bytes);
        Ok(())
    }

    fn read_at(&mut self, place: u64, buffer: &mut [u8]) -> Result<usize> {
        let rest = usize::try_from(place).ok().and_then(|place| self.get(place..)).unwrap_or_default();
        let count = rest.len().min(buffer.len());
        buffer[..count].copy_from_slice(&rest[..count]);
        Ok(count)
    }
}
