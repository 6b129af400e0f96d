//! Errors of a wall that is known within a band, marginalised \[barshalom2001estimation, sec. 8.2; rasmussen2006gaussian, ch. 4\].
//!
//! The error of a drawn or felt wall is smooth: readings along one stretch share it, whichever whisker makes them and whenever. It
//! is taken for one number over a stretch, and for another, independent one over the next. Each number is a state
//! without dynamics of the Kalman filter that makes the readings' innovations independent.

use crate::plane::Vec2;

/// What the wall's error does to a reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct WallError {
    /// The stretch of boundary whose error it is.
    pub(super) stretch: (u32, u32),
    /// Change of the residual with a displacement of the wall (1/m), up to a sign that all readings of a stretch share.
    pub(super) by_displacement: f64,
    /// Standard deviation of the displacement (m).
    pub(super) std: f64,
}

impl WallError {
    /// That of a reading with this gradient by the base's place and heading, in units of its standard deviation with `scale`.
    ///
    /// A wall that is displaced against its normal does to a reading what a base does that is displaced along it, and neither does
    /// anything along the wall. So the size is that of the gradient; a whisker that bends to its left reads more, and one that bends to
    /// its right less, where the wall comes nearer.
    pub(super) fn new(gradient: [f64; 3], scale: f64, (std, stretch): (f64, (u32, u32)), bends_left: bool) -> Self {
        let size = Vec2::new(gradient[0], gradient[1]).norm() * scale;
        Self { stretch, by_displacement: if bends_left { size } else { -size }, std }
    }

    /// Variance that it adds to a residual.
    pub(super) fn variance(&self) -> f64 {
        (self.by_displacement * self.std).powi(2)
    }
}
