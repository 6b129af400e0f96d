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

/// Reads a whole buffer at a place.
pub(super) fn read_whole(file: &mut dyn GrowingFile, mut place: u64, mut buffer: &mut [u8]) -> Result<()> {
    while !buffer.is_empty() {
        match file.read_at(place, buffer) {
            Ok(0) => return Err(std::io::ErrorKind::UnexpectedEof.into()),
            Ok(count) => {
                place += count as u64;
                buffer = &mut buffer[count..];
            }
            Err(error) if error.kind() == std::io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    Ok(())
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
