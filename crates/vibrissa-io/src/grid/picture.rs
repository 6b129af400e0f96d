//! A map's picture as shades and opacities: PNG, PGM and their kin.

use super::{pnm, portable_network as png};
use crate::config::limits::MOST_CELLS;
use crate::{Error, Result};
use std::borrow::Cow;

/// What is wrong with a picture's bytes.
pub(super) type Fault = Cow<'static, str>;

/// A picture's size (pixels).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Size {
    pub(super) width: u32,
    pub(super) height: u32,
}

impl Size {
    /// How many pixels there are, unless they cannot be counted.
    pub(super) fn pixels(self) -> Option<usize> {
        usize::try_from(u64::from(self.width) * u64::from(self.height)).ok()
    }
}

/// A picture, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Picture {
    pub(super) width: usize,
    /// Shade (white is 255) and opacity (opaque is 255) of each pixel.
    pub(super) pixels: Vec<[u8; 2]>,
}

impl Picture {
    /// Reads PNG, PBM, PGM or PPM, whichever the bytes say they are.
    ///
    /// # Errors
    ///
    /// Other bytes, damaged ones, and pictures with more than 16 million pixels.
    pub(super) fn read(bytes: &[u8]) -> Result<Self> {
        let fault = |why: Fault| Error::data("cannot read the map's image").value(why).remedy("save it as PGM or PNG");
        let is_pnm = pnm::is_pnm(bytes);
        let size = if is_pnm { pnm::size(bytes) } else { png::size(bytes) }.map_err(fault)?;
        if u64::from(size.width) * u64::from(size.height) > MOST_CELLS as u64 {
            return Err(Error::data("the map's image is too large")
                .value(format!("{} by {} pixels", size.width, size.height))
                .allowed(format!("up to {MOST_CELLS} pixels"))
                .remedy("cut out the part of the map that the robot can be in"));
        }
        let pixels = if is_pnm {
            pnm::shades(bytes).map(|shades| shades.into_iter().map(|shade| [shade, u8::MAX]).collect())
        } else {
            png::pixels(bytes)
        };
        Ok(Self { width: size.width as usize, pixels: pixels.map_err(fault)? })
    }
}

/// A sample of sixteen bits in eight, rounded.
pub(super) fn eight_bits(sample: u16) -> u8 {
    ((u32::from(sample) + 128) / 257) as u8
}

/// The mean of the samples of each pixel, of which there are one or three: not what an eye sees, but what `map_server` takes.
pub(super) fn means(samples: Vec<u8>, per_pixel: usize) -> Vec<u8> {
    if per_pixel == 1 { samples } else { samples.as_chunks::<3>().0.iter().map(|&rgb| mean(rgb)).collect() }
}

pub(super) fn mean([r, g, b]: [u8; 3]) -> u8 {
    ((u16::from(r) + u16::from(g) + u16::from(b)) / 3) as u8
}
