//! Two numbers at once.

/// Two numbers that are loaded, added and multiplied as one; aligned, so that a sum may take one straight from memory.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(align(16))]
pub(super) struct Pair(pub(super) [f64; 2]);

impl Pair {
    #[inline(always)]
    pub(super) fn times(self, x: f64) -> Self {
        Self([self.0[0] * x, self.0[1] * x])
    }

    #[inline(always)]
    pub(super) fn by(self, other: Self) -> Self {
        Self([self.0[0] * other.0[0], self.0[1] * other.0[1]])
    }

    #[inline(always)]
    pub(super) fn plus(self, other: Self) -> Self {
        Self([self.0[0] + other.0[0], self.0[1] + other.0[1]])
    }
}
