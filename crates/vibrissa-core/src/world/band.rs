//! How exactly the course of a boundary is known: a band around it, and stretches of which nothing is known.
//!
//! The true boundary is the drawn one displaced by a vector field `u(s)` along its arc length: `|u| <= bound`,
//! `|u'| <= bound / l`, `|u''| <= bound / l²` with the correlation length `l`. So places are off by no more than the bound
//! and directions by no more than `asin(bound / l)`; a corner moves with both of its walls. As a random field the part of `u`
//! across the wall has mean zero, the standard deviation of the band, and is alike over about `l`: what felt a wall, or drew
//! it, was off in the same way along a stretch \[rasmussen2006gaussian, ch. 4\].
//!
//! Of an unknown stretch nothing is known but that the true boundary, and all else that may stand there, lies within its depth.

use crate::math;
use crate::{Error, Result};
use core::f64::consts::PI;

/// The distances within which a place of a boundary lies, to either side (m).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Band {
    /// Standard deviation across the wall.
    pub std: f64,
    /// What the error does not exceed.
    pub bound: f64,
}

impl Band {
    /// Errors that lie evenly within a bound (m).
    #[must_use]
    pub fn even(bound: f64) -> Self {
        Self { std: bound / SQRT_3, bound }
    }

    fn largest(self, other: Self) -> Self {
        Self { std: self.std.max(other.std), bound: self.bound.max(other.bound) }
    }
}

const SQRT_3: f64 = 1.732_050_807_568_877_2;

/// What is known of one piece of a boundary.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PieceCourse {
    /// It lies in a band, which goes in a straight line from its start to its end.
    Band([Band; 2]),
    /// Nothing, but that what is there lies within this distance of it (m).
    Unknown(f64),
}

impl PieceCourse {
    fn reversed(self) -> Self {
        match self {
            Self::Band([from, to]) => Self::Band([to, from]),
            unknown => unknown,
        }
    }

    /// The widest that its band gets; none where nothing is known of it.
    #[must_use]
    pub fn widest(self) -> Option<Band> {
        match self {
            Self::Band([from, to]) => Some(from.largest(to)),
            Self::Unknown(_) => None,
        }
    }
}

/// How exactly each piece of a boundary is known.
#[derive(Clone, Debug, PartialEq)]
pub struct Course {
    pieces: Vec<PieceCourse>,
    correlation_length: f64,
}

/// The largest bound, depth and correlation length (m): no map is so large.
const LARGEST: f64 = 1e5;

impl Course {
    /// One entry for each piece of the boundary's curve, in its order, and over which length its error is alike (m).
    ///
    /// # Errors
    ///
    /// No correlation length above 0; bounds, standard deviations or depths that are negative, not finite or beyond all maps; standard
    /// deviations above their bounds.
    pub fn new(pieces: Vec<PieceCourse>, correlation_length: f64) -> Result<Self> {
        if !(correlation_length > 0.0 && correlation_length <= LARGEST) {
            return Err(Error::data("the length over which a band's error is alike is out of range")
                .value(format!("{correlation_length} m"))
                .allowed(format!("above 0, up to {LARGEST} m"))
                .remedy("give \"band_length\" in metres, or leave it out"));
        }
        for piece in &pieces {
            let (lengths, stds_fit) = match piece {
                PieceCourse::Band(ends) => {
                    ([ends[0].bound, ends[1].bound], ends.iter().all(|band| (0.0..=band.bound).contains(&band.std)))
                }
                PieceCourse::Unknown(depth) => ([*depth; 2], true),
            };
            if let Some(length) = lengths.into_iter().find(|length| !(0.0..=LARGEST).contains(length)) {
                return Err(Error::data("a band or a depth is out of range")
                    .value(format!("{length} m"))
                    .allowed(format!("0 to {LARGEST} m"))
                    .remedy("a band is how far the wall may be from where it is drawn, in metres"));
            }
            if !stds_fit {
                return Err(Error::data("a band's standard deviation is out of range")
                    .allowed("0 to the band's bound")
                    .remedy("make the bound at least as large, as two or three times the standard deviation"));
            }
        }
        Ok(Self { pieces, correlation_length })
    }

    /// The same of the curve that runs the other way.
    pub(super) fn reversed(mut self) -> Self {
        self.pieces.reverse();
        self.pieces.iter_mut().for_each(|piece| *piece = piece.reversed());
        self
    }

    /// What is known of each piece of the curve.
    #[must_use]
    pub fn pieces(&self) -> &[PieceCourse] {
        &self.pieces
    }

    /// Over which length of boundary the error is alike (m).
    #[must_use]
    pub fn correlation_length(&self) -> f64 {
        self.correlation_length
    }

    /// What a bound of this size leaves open of directions (rad) and of curvature (1/m).
    pub(crate) fn slope_and_bend(&self, bound: f64) -> (f64, f64) {
        let share = bound / self.correlation_length;
        if share >= 1.0 {
            return (PI, f64::INFINITY);
        }
        // The curvature of a displaced line is |x' × x''| / |x'|³, and |x'| is no less than 1 - share.
        let bend = share / self.correlation_length * (1.0 - share).powi(-3);
        (math::asin(share), bend)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

    use super::*;

    #[test]
    fn a_course_turns_round_with_its_curve() {
        let band = |bound| Band::even(bound);
        let course =
            Course::new(vec![PieceCourse::Band([band(1e-3), band(2e-3)]), PieceCourse::Unknown(0.03)], 0.05).unwrap();
        let back = course.clone().reversed();
        assert_eq!(back.pieces(), [PieceCourse::Unknown(0.03), PieceCourse::Band([band(2e-3), band(1e-3)])]);
        assert_eq!(back.reversed(), course);
    }

    #[test]
    fn a_sine_within_its_bound_keeps_to_the_slopes_and_bends_told() {
        let (bound, length) = (1e-3, 0.02);
        let (slope, bend) = Course::new(Vec::new(), length).unwrap().slope_and_bend(bound);
        let steepest = (bound / length).atan();
        assert!(slope >= steepest && slope < 1.1 * steepest);
        assert!(bend >= bound / (length * length) && bend < 1.3 * bound / (length * length));
        assert_eq!(Course::new(Vec::new(), 1e-3).unwrap().slope_and_bend(2e-3), (PI, f64::INFINITY));
    }

    #[test]
    fn nonsense_is_refused_with_what_is_allowed() {
        let one = |piece| Course::new(vec![piece], 0.05).unwrap_err().to_string();
        let wrong = [
            one(PieceCourse::Unknown(f64::NAN)),
            one(PieceCourse::Band([Band::even(-1e-3), Band::default()])),
            one(PieceCourse::Band([Band { std: 2e-3, bound: 1e-3 }, Band::default()])),
            Course::new(Vec::new(), 0.0).unwrap_err().to_string(),
        ];
        assert!(wrong.iter().all(|text| text.contains("0") && text.contains("help: ")), "{wrong:?}");
    }
}
