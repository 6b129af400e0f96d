//! Two numbers at once.
//!
//! Where the processor has registers for two numbers they are asked for: left to itself the compiler pairs other numbers in a large
//! function, and shuffles. The results are the same to the last bit.

#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
use safe_arch::{
    add_m128d, get_f64_from_m128d_s, m128d, mul_m128d, set_m128d, set_splat_m128d, shuffle_abi_f64_all_m128d,
    unpack_high_m128d,
};

/// Two numbers that are loaded, added and multiplied as one; aligned, so that a sum may take one straight from memory.
#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Pair(m128d);

#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
impl Pair {
    #[inline(always)]
    pub(super) fn new(first: f64, second: f64) -> Self {
        Self(set_m128d(second, first))
    }

    /// The same number twice.
    #[inline(always)]
    pub(super) fn both(x: f64) -> Self {
        Self(set_splat_m128d(x))
    }

    #[inline(always)]
    pub(super) fn by(self, other: Self) -> Self {
        Self(mul_m128d(self.0, other.0))
    }

    #[inline(always)]
    pub(super) fn plus(self, other: Self) -> Self {
        Self(add_m128d(self.0, other.0))
    }

    /// The two the other way round.
    #[inline(always)]
    pub(super) fn swapped(self) -> Self {
        Self(shuffle_abi_f64_all_m128d::<0b01>(self.0, self.0))
    }

    #[inline(always)]
    pub(super) fn array(self) -> [f64; 2] {
        [get_f64_from_m128d_s(self.0), get_f64_from_m128d_s(unpack_high_m128d(self.0, self.0))]
    }
}

/// Two numbers that are loaded, added and multiplied as one.
#[cfg(not(all(target_arch = "x86_64", target_feature = "sse2")))]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(align(16))]
pub(super) struct Pair([f64; 2]);

#[cfg(not(all(target_arch = "x86_64", target_feature = "sse2")))]
impl Pair {
    #[inline(always)]
    pub(super) fn new(first: f64, second: f64) -> Self {
        Self([first, second])
    }

    /// The same number twice.
    #[inline(always)]
    pub(super) fn both(x: f64) -> Self {
        Self([x, x])
    }

    #[inline(always)]
    pub(super) fn by(self, other: Self) -> Self {
        Self([self.0[0] * other.0[0], self.0[1] * other.0[1]])
    }

    #[inline(always)]
    pub(super) fn plus(self, other: Self) -> Self {
        Self([self.0[0] + other.0[0], self.0[1] + other.0[1]])
    }

    /// The two the other way round.
    #[inline(always)]
    pub(super) fn swapped(self) -> Self {
        Self([self.0[1], self.0[0]])
    }

    #[inline(always)]
    pub(super) fn array(self) -> [f64; 2] {
        self.0
    }
}

impl Pair {
    #[inline(always)]
    pub(super) fn times(self, x: f64) -> Self {
        self.by(Self::both(x))
    }

    #[inline(always)]
    pub(super) fn first(self) -> f64 {
        self.array()[0]
    }

    /// The vector of the two turned by a quarter, counter-clockwise.
    #[inline(always)]
    pub(super) fn turned(self) -> Self {
        self.swapped().by(Self::new(-1.0, 1.0))
    }
}

impl core::ops::Add for Pair {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.plus(other)
    }
}

impl core::ops::Mul for Pair {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.by(other)
    }
}
