//! Bytes of a message: postcard, then its CRC-32, all of it without zeros between two zeros.

use crc::{CRC_32_ISO_HDLC, Crc, Table};
use postcard::ser_flavors::crc::CrcModifier;
use postcard::ser_flavors::{Cobs, Slice};
use serde::Serialize;
use serde::de::DeserializeOwned;

/// The most bytes of a packet, with the zero at its end: a calibration of two axes is the longest.
pub const LONGEST: usize = 320;

/// A table of a kilobyte.
static CRC: Crc<u32, Table<1>> = Crc::<u32, Table<1>>::new(&CRC_32_ISO_HDLC);

/// Why bytes are no packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Damage {
    /// Longer than any packet.
    Long,
    /// Zeros or lengths where none may be: cut, or bytes are missing.
    Framing,
    /// The checksum is of other bytes.
    Checksum,
    /// Whole, but no message that this version knows.
    Unknown,
}

/// Writes a message with the zero that ends it; how many bytes, or none where `out` is too short.
pub(crate) fn write<T: Serialize>(message: &T, out: &mut [u8]) -> Option<usize> {
    let flavor = Cobs::try_new(Slice::new(out)).ok()?;
    let checked = CrcModifier::new(flavor, CRC.digest());
    postcard::serialize_with_flavor(message, checked).ok().map(|written| written.len())
}

/// Reads the bytes between two zeros, without these.
pub(crate) fn read<T: DeserializeOwned>(packet: &[u8]) -> Result<T, Damage> {
    let mut bytes = [0; LONGEST];
    let bytes = bytes.get_mut(..packet.len()).ok_or(Damage::Long)?;
    bytes.copy_from_slice(packet);
    let length = cobs::decode_in_place(bytes).map_err(|_| Damage::Framing)?;
    let (body, sum) = bytes.get(..length).and_then(<[u8]>::split_last_chunk::<4>).ok_or(Damage::Framing)?;
    if CRC.checksum(body) != u32::from_le_bytes(*sum) {
        return Err(Damage::Checksum);
    }
    match postcard::take_from_bytes(body) {
        Ok((message, [])) => Ok(message),
        _ => Err(Damage::Unknown),
    }
}
