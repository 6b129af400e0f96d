//! A rod as a list of numbers and back.
use super::Rod;
use super::section::RodPiece;
use crate::error::{Error, Result};
use crate::platform::Shared;
use alloc::vec;
use alloc::vec::Vec;

impl Rod {
    /// Length, base compliance, the stretches (end, rigidity, narrowing) after their count, the curvature's coefficients.
    pub(in crate::beam) fn to_numbers(&self) -> Vec<f64> {
        let mut list = vec![self.length, self.base_compliance, self.pieces.len() as f64];
        list.extend(self.pieces.iter().flat_map(|piece| [piece.end, piece.rigidity, piece.narrowing]));
        list.extend(self.curvature.iter());
        list
    }

    /// The rod of [`Rod::to_numbers`].
    ///
    /// # Errors
    /// Data: a list that no rod gives.
    pub(in crate::beam) fn from_numbers(list: &[f64]) -> Result<Self> {
        let bad = || Error::data("the numbers of a stored rod make no rod").remedy("describe the whisker again");
        let ([length, base_compliance, count], rest) = list.split_first_chunk::<3>().ok_or_else(bad)?;
        if !(1.0..=1e4).contains(count) || rest.len() < 3 * (*count as usize) {
            return Err(bad());
        }
        let (stretches, curvature) = rest.split_at(3 * (*count as usize));
        let mut start = 0.0;
        let piece = |p: &[f64]| {
            let piece = RodPiece { start, end: p[0], rigidity: p[1], narrowing: p[2] };
            start = piece.end;
            piece
        };
        let pieces: Shared<[RodPiece]> = stretches.chunks_exact(3).map(piece).collect();
        let rising = pieces.windows(2).all(|pair| pair[0].end < pair[1].end);
        let sound = pieces.iter().all(|p| p.end > 0.0 && p.rigidity > 0.0 && p.narrowing * (p.end - p.start) < 1.0);
        let finite = list.iter().all(|x| x.is_finite());
        if !(rising && sound && finite && *length > 0.0 && *base_compliance >= 0.0) {
            return Err(bad());
        }
        let straight = Self { length: *length, pieces, curvature: Shared::new([]), base_compliance: *base_compliance };
        straight.with_curvature(curvature)
    }
}
