//! The general rod: tapered, curved at rest, of several wires, on an elastic base.
//!
//! The contact carries no moment, so a march from the contact back to the base needs no search when the force turns with
//! the whisker: it ends with the slope at the contact less the slope at the base, and the base moment, which turns the base
//! by `theta_0 = M0 / k_base`. Everything else is a root of few unknowns over that march.
//!
//! A rod has no scaling law, so branches are looked for on a grid of the unknowns and then refined; two branches that lie
//! closer together than the grid are told apart only next to a fold. First mode means here: the moment or the curvature keeps
//! one sign from the contact to the base. For a rod that is straight at rest these are the same. Shapes for which the
//! base would turn by more than half a turn are left out.

mod follow;
mod force;
mod forward;
mod loaded;
mod march;
mod moment;
mod newton;
mod numbers;
mod point;
mod pushed;
mod scan;
mod section;
mod shot;
mod stability;
mod tip;
mod view;

use crate::platform::Shared;
use alloc::format;

pub use follow::{Followed, Status};
pub use forward::Touched;
pub(in crate::beam) use loaded::Loaded;
pub use section::Segment;
pub(in crate::beam) use stability::Hold;

use super::stretch::{SHARPEST, Stretch, Stretches};
use super::whisker::Whisker;
use crate::error::{Error, Result};
use march::{ORDER, RodState};
use section::{RodPiece, pieces, tapered};

/// A rod ready to be bent: checked, and independent of its load.
///
/// In its own frame: base at the origin, leaving the base along +x, curved as it is at rest.
#[derive(Clone, Debug, PartialEq)]
pub struct Rod {
    length: f64,
    /// Shared, since every equilibrium found keeps its rod.
    pieces: Shared<[RodPiece]>,
    /// Coefficients of the rest curvature by rising power of `s`.
    curvature: Shared<[f64]>,
    /// `1 / k_base` (rad/(N m)); 0 when clamped.
    base_compliance: f64,
}

impl Rod {
    /// The rod that a whisker describes.
    ///
    /// # Errors
    /// Data: a length or rigidity that is not positive, a tip ratio outside [0.001, 1], a curvature that is not finite or
    /// winds the whisker up, a base stiffness that is not positive, stretches that are not as long as the whisker.
    pub fn new(whisker: &Whisker) -> Result<Self> {
        Self::of_wires(whisker)?.with_curvature(&whisker.curvature_terms())?.with_base_stiffness(whisker.base_stiffness)
    }

    /// The rod that a clamped whisker describes, wound up or not.
    ///
    /// # Errors
    /// Data: as [`Rod::new`].
    pub(in crate::beam) fn clamped(whisker: &Whisker) -> Result<Self> {
        let rod = Self::of_wires(whisker)?;
        let terms = whisker.curvature_terms();
        let used = terms.iter().rposition(|c| c.abs() > 0.0).map_or(0, |last| last + 1);
        Ok(Self { curvature: terms[..used].into(), ..rod })
    }

    /// The whisker's wires, straight and clamped.
    fn of_wires(whisker: &Whisker) -> Result<Self> {
        let Whisker { length, flexural_rigidity, tip_ratio, .. } = *whisker;
        let positive = |value: f64| value > 0.0 && value.is_finite();
        if !positive(length) {
            return Err(Error::data("whisker length").value(length).allowed("above 0 m"));
        }
        if !positive(flexural_rigidity) {
            return Err(Error::data("flexural_rigidity").value(flexural_rigidity).allowed("above 0 N m²"));
        }
        if !whisker.stretches.as_slice().is_empty() {
            let together = whisker.stretches.length();
            if (together - length).abs() > 1e-9 * length {
                let error = Error::data("whisker length").value(length);
                return Err(error.allowed(format!("{together} m, the length of its segments together")));
            }
            return Self::from_stretches(whisker.stretches.as_slice());
        }
        if !(SHARPEST..=1.0).contains(&tip_ratio) {
            let error = Error::data("tip_ratio").value(tip_ratio).allowed("0.001 to 1");
            return Err(error.remedy("give the tip's radius over the base's; a point is no beam"));
        }
        let piece =
            RodPiece { start: 0.0, end: length, rigidity: flexural_rigidity, narrowing: (1.0 - tip_ratio) / length };
        Ok(Self { length, pieces: Shared::new([piece]), curvature: Shared::new([]), base_compliance: 0.0 })
    }

    /// A straight clamped rod of stretches that may taper, joined in order from the base.
    ///
    /// # Errors
    /// Data: as [`Stretches::new`](super::Stretches::new).
    pub fn from_stretches(stretches: &[Stretch]) -> Result<Self> {
        let pieces = tapered(Stretches::new(stretches)?.as_slice());
        let length = pieces.last().map_or(0.0, |piece| piece.end);
        Ok(Self { length, pieces: pieces.into(), curvature: Shared::new([]), base_compliance: 0.0 })
    }

    /// A straight clamped rod of several wires, joined in order from the base; its length is theirs together.
    ///
    /// # Errors
    /// Data: no segment, or one with a number that is not positive.
    pub fn from_segments(segments: &[Segment]) -> Result<Self> {
        let pieces = pieces(segments)?;
        let length = pieces.last().map_or(0.0, |piece| piece.end);
        Ok(Self { length, pieces: pieces.into(), curvature: Shared::new([]), base_compliance: 0.0 })
    }

    /// The rod with the rest curvature `sum_k coefficients[k] s^k` (1/m, s in m), counter-clockwise positive.
    ///
    /// # Errors
    /// Data: a coefficient that is not finite, more than 20 of them, or a rod that winds up more than once.
    pub fn with_curvature(mut self, coefficients: &[f64]) -> Result<Self> {
        if let Some(bad) = coefficients.iter().find(|c| !c.is_finite()) {
            return Err(Error::data("curvature").value(bad).allowed("finite numbers of 1/m"));
        }
        if coefficients.len() > ORDER {
            return Err(Error::data("curvature coefficients")
                .value(coefficients.len())
                .allowed(format!("up to {ORDER}")));
        }
        let used = coefficients.iter().rposition(|c| c.abs() > 0.0).map_or(0, |last| last + 1);
        self.curvature = coefficients[..used].into();
        let turns = coefficients.iter().rev().fold(0.0, |sum, c| sum * self.length + c.abs()) * self.length;
        if turns > core::f64::consts::TAU {
            let error = Error::data("curvature").value(format!("{coefficients:?}"));
            return Err(error.allowed("a whisker that turns by less than 2 pi from base to tip"));
        }
        Ok(self)
    }

    /// The rod on a base of rotational stiffness `stiffness` (N m/rad); infinite when clamped.
    ///
    /// # Errors
    /// Data: a stiffness that is not positive.
    pub fn with_base_stiffness(mut self, stiffness: f64) -> Result<Self> {
        if stiffness.is_nan() || stiffness <= 0.0 {
            let error = Error::data("base_stiffness").value(stiffness).allowed("above 0 N m/rad, or inf");
            return Err(error.remedy("a base without stiffness holds no whisker; a clamped base is inf"));
        }
        self.base_compliance = 1.0 / stiffness;
        Ok(self)
    }

    /// Shared length from base to tip (m).
    #[must_use]
    pub fn length(&self) -> f64 {
        self.length
    }

    /// How far the base turns under `moment` (N m): `M0 / k_base` (rad).
    #[must_use]
    pub fn base_angle(&self, moment: f64) -> f64 {
        moment * self.base_compliance
    }

    /// The curvature at rest at arc length `s` (1/m).
    pub(in crate::beam) fn rest_curvature(&self, s: f64) -> f64 {
        self.curvature.iter().rev().fold(0.0, |sum, c| sum * s + c)
    }

    /// `1 / EI` at arc length `s` (1/(N m²)).
    pub(super) fn compliance(&self, s: f64) -> f64 {
        self.piece(s, false).compliance(s)
    }

    /// How fast the radius falls from the base on, as a share of the radius there (1/m); 0 for several wires.
    pub(super) fn narrowing(&self) -> f64 {
        match &*self.pieces {
            [only] => only.narrowing,
            _ => 0.0,
        }
    }

    /// Where the wires are joined (m).
    pub(super) fn joints(&self) -> impl Iterator<Item = f64> + '_ {
        self.pieces.iter().map(|piece| piece.end).filter(|&end| end < self.length)
    }

    /// The derivative of the slope (1/m).
    fn curvature_of(&self, state: &RodState) -> f64 {
        state.moment * self.compliance(state.s) + self.rest_curvature(state.s)
    }

    /// The stretch that a march from `s` enters.
    fn piece(&self, s: f64, backwards: bool) -> RodPiece {
        let last = self.pieces[self.pieces.len() - 1];
        let inside = |piece: &&RodPiece| if backwards { s <= piece.end } else { s < piece.end };
        let piece = self.pieces.iter().find(inside).copied().unwrap_or(last);
        // Slightly beyond the tip the last stretch goes on.
        if piece.end >= self.length { RodPiece { end: f64::INFINITY, ..piece } } else { piece }
    }

    /// Where the stretch begins that a march from `s` towards the base enters.
    fn piece_start(&self, s: f64) -> f64 {
        self.pieces.iter().rev().skip(1).map(|piece| piece.end).find(|&end| end < s).unwrap_or(f64::NEG_INFINITY)
    }

    /// At least [`Rod::softness`], and nearer to it than the largest and the smallest rigidity are to each other.
    fn softness_at_most(&self, s_a: f64) -> f64 {
        let ends = self.pieces.iter().filter(|piece| piece.start < s_a);
        let softest = |piece: &RodPiece| piece.compliance(piece.start).max(piece.compliance(piece.end.min(s_a)));
        0.5 * s_a * s_a * ends.map(softest).fold(0.0, f64::max)
    }

    /// The slope at `s_a` that a unit normal force there causes by small-angle theory (rad/N): the scale of forces.
    fn softness(&self, s_a: f64) -> f64 {
        const PARTS: usize = 16;
        let (mut sum, mut start) = (0.0, 0.0);
        for piece in self.pieces.iter() {
            let end = if piece.end >= self.length { s_a } else { piece.end.min(s_a) };
            let width = (end - start).max(0.0) / PARTS as f64;
            for i in 0..PARTS {
                let s = start + (i as f64 + 0.5) * width;
                sum += width * (s_a - s) * piece.compliance(s);
            }
            start = end.max(start);
        }
        sum
    }
}
