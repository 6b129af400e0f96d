//! A field as bytes: the rod, the samples and what was measured, with a version and a checksum.
//!
//! All numbers are little-endian. The table itself is not kept: it follows from the samples, bit for bit, in milliseconds.

extern crate alloc;
use super::chart::Bunched;
use super::errors::Bounds;
use super::state::FieldErrors;
use super::table::QUANTITIES;
use super::tip::{Measured, TipField, layout};
use crate::beam::rod::Rod;
use crate::error::{Error, Result};
use alloc::format;
use alloc::vec::Vec;

/// What a file of this kind starts with; the last byte is the version.
const MAGIC: &[u8; 16] = b"vibrissa field\n\x02";
/// Most numbers in a list: a field has some ten thousand.
const MOST: usize = 10_000_000;

impl TipField {
    /// The field as bytes, for [`TipField::from_bytes`].
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let errors = [self.errors.value, self.errors.by_u, self.errors.by_v];
        let errors = errors.iter().flat_map(|e| [e.slope, e.position, e.moment, e.energy]);
        let lists: [Vec<f64>; 4] = [
            self.rod.to_numbers(),
            self.limits.forces.iter().flatten().copied().collect(),
            errors.chain([self.refinement as f64]).collect(),
            self.samples.iter().flatten().copied().collect(),
        ];
        let mut bytes = MAGIC.to_vec();
        for list in lists {
            bytes.extend((list.len() as u64).to_le_bytes());
            bytes.extend(list.iter().flat_map(|x| x.to_le_bytes()));
        }
        bytes.extend(checksum(&bytes).to_le_bytes());
        bytes
    }

    /// The field that [`TipField::to_bytes`] wrote: the same numbers to the last bit.
    ///
    /// # Errors
    /// Data: bytes that are no field, of another version, cut short, or damaged.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self> {
        let [rod, limits, errors, samples] = lists(bytes)?;
        let rod = Rod::from_numbers(&rod)?;
        let whole = samples.len() == layout(&rod, 0, Bunched::new(1.0, 1.0)).count() * QUANTITIES
            && limits.len() % 2 == 0
            && limits.len() >= 4;
        let (Ok::<[f64; 13], _>(errors), true) = (errors.try_into(), whole) else {
            return Err(damaged("its lists have the wrong lengths"));
        };
        let all_finite = samples.iter().chain(&limits).all(|x| x.is_finite()) && (0.0..8.0).contains(&errors[12]);
        if !all_finite {
            return Err(damaged("it holds numbers that are not finite"));
        }
        let measured = Measured {
            forces: limits.chunks_exact(2).map(|pair| [pair[0], pair[1]]).collect(),
            samples: samples
                .chunks_exact(QUANTITIES)
                .map(|row| {
                    let mut out = [0.0; QUANTITIES];
                    out.copy_from_slice(row);
                    out
                })
                .collect(),
        };
        let mut field = Self::from_measured(rod, measured, errors[12] as usize)?;
        let [value, by_u, by_v] = [0, 4, 8].map(|k| FieldErrors {
            slope: errors[k],
            position: errors[k + 1],
            moment: errors[k + 2],
            energy: errors[k + 3],
        });
        field.errors = Bounds { value, by_u, by_v };
        Ok(field)
    }
}

fn damaged(what: &str) -> Error {
    Error::data(format!("a stored whisker field is damaged: {what}")).remedy("build the field again from the whisker")
}

/// The lists of numbers in a file whose checksum is right.
fn lists(bytes: &[u8]) -> Result<[Vec<f64>; 4]> {
    let (head, version) = (MAGIC.len() - 1, MAGIC[MAGIC.len() - 1]);
    if bytes.len() < MAGIC.len() + 8 || bytes[..head] != MAGIC[..head] {
        return Err(Error::data("this is no stored whisker field").remedy("give bytes that TipField::to_bytes wrote"));
    }
    if bytes[head] != version {
        return Err(Error::data("version of a stored whisker field")
            .value(bytes[head])
            .allowed(format!("{version}"))
            .remedy("build the field again from the whisker"));
    }
    let (body, sum) = bytes.split_at(bytes.len() - 8);
    if checksum(body).to_le_bytes() != sum {
        return Err(damaged("its checksum does not match"));
    }
    let mut rest = &body[MAGIC.len()..];
    let mut lists = [const { Vec::new() }; 4];
    for list in &mut lists {
        *list = take(&mut rest).ok_or_else(|| damaged("it is cut short"))?;
    }
    if rest.is_empty() { Ok(lists) } else { Err(damaged("something follows its end")) }
}

fn take(rest: &mut &[u8]) -> Option<Vec<f64>> {
    let (count, tail) = rest.split_first_chunk::<8>()?;
    let count = usize::try_from(u64::from_le_bytes(*count)).ok().filter(|n| *n <= MOST)?;
    let (numbers, tail) = (tail.get(..8 * count)?, tail.get(8 * count..)?);
    *rest = tail;
    Some(numbers.as_chunks::<8>().0.iter().map(|b| f64::from_le_bytes(*b)).collect())
}

/// Fowler, Noll and Vo's checksum of 64 bits.
fn checksum(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |sum, b| (sum ^ u64::from(*b)).wrapping_mul(0x0100_0000_01b3))
}
