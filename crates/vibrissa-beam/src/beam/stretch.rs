//! A whisker of several wires: its stretches, in order from the base.

use crate::error::{Error, Result};
use alloc::format;
#[cfg(not(feature = "std"))]
use num_traits::Float as _;

/// Most wires that a whisker may be made of.
pub const MOST_STRETCHES: usize = 8;
/// Smallest tip radius over base radius: a point is no beam.
pub(super) const SHARPEST: f64 = 1e-3;

/// A stretch of a whisker: one wire, which may narrow linearly.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stretch {
    /// Arc length of the stretch (m), positive.
    pub length: f64,
    /// Flexural rigidity E I where the stretch begins, seen from the base (N m²), positive.
    pub flexural_rigidity: f64,
    /// Radius at its end over radius at its beginning, from 0.001 to 1000.
    pub tip_ratio: f64,
    /// Diameter where it begins (m), where it is known; for strains only.
    pub diameter: Option<f64>,
}

/// Up to [`MOST_STRETCHES`] stretches; none for a whisker of one wire.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stretches {
    list: [Stretch; MOST_STRETCHES],
    count: usize,
}

impl Stretches {
    /// The stretches in order from the base.
    ///
    /// # Errors
    /// Data: none or too many, or one with a number out of its range; the message counts from 0.
    pub fn new(stretches: &[Stretch]) -> Result<Self> {
        if stretches.is_empty() || stretches.len() > MOST_STRETCHES {
            let error = Error::data("number of segments").value(stretches.len());
            return Err(error.allowed(format!("1 to {MOST_STRETCHES}")));
        }
        for (i, stretch) in stretches.iter().enumerate() {
            stretch.check(i)?;
        }
        let mut list = [Stretch::default(); MOST_STRETCHES];
        list[..stretches.len()].copy_from_slice(stretches);
        Ok(Self { list, count: stretches.len() })
    }

    /// The stretches in order from the base; empty for a whisker of one wire.
    #[must_use]
    pub fn as_slice(&self) -> &[Stretch] {
        self.list.get(..self.count).unwrap_or(&[])
    }

    /// Their length together (m).
    #[must_use]
    pub fn length(&self) -> f64 {
        self.as_slice().iter().map(|stretch| stretch.length).sum()
    }

    /// The radius at arc length `s` (m), where the diameter there is known; at a joint that of the outer wire.
    #[must_use]
    pub fn radius_at(&self, s: f64) -> Option<f64> {
        let (stretch, share) = self.at(s)?;
        stretch.diameter.map(|diameter| 0.5 * diameter * share)
    }

    /// The flexural rigidity at arc length `s` (N m²); at a joint that of the outer wire, 0 where there is no wire.
    #[must_use]
    pub fn rigidity_at(&self, s: f64) -> f64 {
        self.at(s).map_or(0.0, |(stretch, share)| stretch.flexural_rigidity * share.powi(4))
    }

    /// The wire at arc length `s` and its radius there as a share of that at its beginning.
    fn at(&self, s: f64) -> Option<(&Stretch, f64)> {
        let (mut start, last) = (0.0, self.as_slice().len().checked_sub(1)?);
        for (i, stretch) in self.as_slice().iter().enumerate() {
            if s < start + stretch.length || i == last {
                let along = ((s - start) / stretch.length).clamp(0.0, 1.0);
                return Some((stretch, 1.0 - (1.0 - stretch.tip_ratio) * along));
            }
            start += stretch.length;
        }
        None
    }
}

impl Stretch {
    fn check(&self, i: usize) -> Result<()> {
        let positive = |value: f64| value > 0.0 && value.is_finite();
        let tapers = |value: f64| (SHARPEST..=1.0 / SHARPEST).contains(&value);
        let checks = [
            ("length", self.length, positive(self.length), "above 0 m"),
            ("flexural_rigidity", self.flexural_rigidity, positive(self.flexural_rigidity), "above 0 N m²"),
            ("tip_ratio", self.tip_ratio, tapers(self.tip_ratio), "0.001 to 1000"),
        ];
        match checks.into_iter().find(|(_, _, holds, _)| !holds) {
            Some((name, value, _, allowed)) => {
                Err(Error::data(format!("segment {i}: {name}")).value(value).allowed(allowed))
            }
            None => Ok(()),
        }
    }
}
