//! Closed intervals of the real line.

/// A closed interval `[lo, hi]`, or the empty set.
///
/// | `a`, `b` | hull | intersection |
/// | --- | --- | --- |
/// | both empty | empty | empty |
/// | one empty | the other | empty |
/// | apart | from the lower `lo` to the higher `hi` | empty |
/// | touching or overlapping | the same | from the higher `lo` to the lower `hi` |
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    lo: f64,
    hi: f64,
}

impl Interval {
    /// The empty set.
    pub const EMPTY: Self = Self { lo: f64::INFINITY, hi: f64::NEG_INFINITY };

    /// The interval `[lo, hi]`; empty when `lo > hi`, when either bound is not a number, and when both are the same
    /// infinity, which no number reaches.
    #[must_use]
    pub fn new(lo: f64, hi: f64) -> Self {
        if lo <= hi && lo < f64::INFINITY && hi > f64::NEG_INFINITY { Self { lo, hi } } else { Self::EMPTY }
    }

    /// The interval of one number; empty when it is not a number.
    #[must_use]
    pub fn point(value: f64) -> Self {
        Self::new(value, value)
    }

    /// The lower bound; plus infinity for the empty set.
    #[must_use]
    pub fn lo(self) -> f64 {
        self.lo
    }

    /// The upper bound; minus infinity for the empty set.
    #[must_use]
    pub fn hi(self) -> f64 {
        self.hi
    }

    /// Whether no number is in the set.
    #[must_use]
    pub fn is_empty(self) -> bool {
        self.lo > self.hi
    }

    /// `hi - lo`, and 0 for the empty set.
    #[must_use]
    pub fn width(self) -> f64 {
        if self.is_empty() { 0.0 } else { self.hi - self.lo }
    }

    /// Whether `value` is in the set.
    #[must_use]
    pub fn contains(self, value: f64) -> bool {
        self.lo <= value && value <= self.hi
    }

    /// The smallest interval that holds both.
    #[must_use]
    pub fn hull(self, other: Self) -> Self {
        Self { lo: self.lo.min(other.lo), hi: self.hi.max(other.hi) }
    }

    /// The numbers in both.
    #[must_use]
    pub fn intersection(self, other: Self) -> Self {
        Self::new(self.lo.max(other.lo), self.hi.min(other.hi))
    }
}
