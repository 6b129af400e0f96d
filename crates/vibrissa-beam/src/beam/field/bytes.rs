//! A field as bytes: the rod, the samples and what was measured, with a version and a checksum.
//!
//! All numbers are little-endian. The table itself is not kept: it follows from the samples, bit for bit, in milliseconds.
use super::chart::Bunched;
use super::errors::ErrorBounds;
use super::side::{self, SideField};
use super::state::FieldErrors;
use super::table::QUANTITIES;
use super::tip::{Measured, TipField, layout};
use crate::beam::rod::Rod;
use crate::error::{Error, Result};
use alloc::format;
use alloc::vec::Vec;

/// What a file of this kind starts with; the last byte is the version.
const MAGIC: &[u8; 16] = b"vibrissa field\n\x02";
const SIDE_MAGIC: &[u8; 16] = b"vibrissa sides\n\x01";
/// Most numbers in a list: a field has some ten thousand.
const MOST: usize = 10_000_000;

impl TipField {
    /// The field as bytes, for [`TipField::from_bytes`].
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut errors = self.errors.to_numbers();
        errors.push(self.refinement as f64);
        let lists = [
            self.rod.to_numbers(),
            self.limits.forces.iter().flatten().copied().collect(),
            errors,
            self.samples.iter().flatten().copied().collect(),
        ];
        written(MAGIC, &lists)
    }

    /// The field that [`TipField::to_bytes`] wrote: the same numbers to the last bit.
    ///
    /// # Errors
    /// Data: bytes that are no field, of another version, cut short, or damaged.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self> {
        let [rod, limits, errors, samples] = lists(MAGIC, bytes)?;
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
        let measured = Measured { forces: limits.as_chunks().0.to_vec(), samples: samples.as_chunks().0.to_vec() };
        let mut field = Self::from_measured(rod, measured, errors[12] as usize)?;
        field.errors = ErrorBounds::from_numbers(&errors);
        Ok(field)
    }
}

impl SideField {
    /// The field as bytes, for [`SideField::from_bytes`].
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let lists = [
            self.rod.to_numbers(),
            self.limits.iter().flatten().copied().collect(),
            self.errors.to_numbers(),
            self.samples.iter().flatten().copied().collect(),
        ];
        written(SIDE_MAGIC, &lists)
    }

    /// The field that [`SideField::to_bytes`] wrote: the same numbers to the last bit.
    ///
    /// # Errors
    /// Data: bytes that are no field, of another version, cut short, or damaged.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self> {
        let [rod, limits, errors, samples] = lists(SIDE_MAGIC, bytes)?;
        let rod = Rod::from_numbers(&rod)?;
        let whole =
            samples.len() == side::layout(&rod).count() * QUANTITIES && limits.len() % 2 == 0 && limits.len() >= 4;
        let (Ok::<[f64; 12], _>(errors), true) = (errors.try_into(), whole) else {
            return Err(damaged("its lists have the wrong lengths"));
        };
        if !samples.iter().chain(&limits).chain(&errors).all(|x| x.is_finite()) {
            return Err(damaged("it holds numbers that are not finite"));
        }
        let mut field = Self::from_measured(rod, limits.as_chunks().0.to_vec(), samples.as_chunks().0.to_vec());
        field.errors = ErrorBounds::from_numbers(&errors);
        Ok(field)
    }
}

impl ErrorBounds {
    fn to_numbers(self) -> Vec<f64> {
        let errors = [self.value, self.by_u, self.by_v];
        errors.iter().flat_map(|e| [e.slope, e.position, e.moment, e.energy]).collect()
    }

    /// Of at least twelve numbers.
    fn from_numbers(n: &[f64]) -> Self {
        let [value, by_u, by_v] =
            [0, 4, 8].map(|k| FieldErrors { slope: n[k], position: n[k + 1], moment: n[k + 2], energy: n[k + 3] });
        Self { value, by_u, by_v }
    }
}

/// Lists of numbers behind a kind and a version, with a checksum.
fn written(magic: &[u8; 16], lists: &[Vec<f64>; 4]) -> Vec<u8> {
    let mut bytes = magic.to_vec();
    for list in lists {
        bytes.extend((list.len() as u64).to_le_bytes());
        bytes.extend(list.iter().flat_map(|x| x.to_le_bytes()));
    }
    bytes.extend(checksum(&bytes).to_le_bytes());
    bytes
}

fn damaged(what: &str) -> Error {
    Error::data(format!("a stored whisker field is damaged: {what}")).remedy("build the field again from the whisker")
}

/// The lists of numbers in a file whose checksum is right.
fn lists(magic: &[u8; 16], bytes: &[u8]) -> Result<[Vec<f64>; 4]> {
    let (head, version) = (magic.len() - 1, magic[magic.len() - 1]);
    if bytes.len() < magic.len() + 8 || bytes[..head] != magic[..head] {
        return Err(Error::data("this is no stored whisker field")
            .remedy("give bytes that to_bytes of the same kind of field wrote"));
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
    let mut rest = &body[magic.len()..];
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
