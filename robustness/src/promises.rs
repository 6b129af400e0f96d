//! What must hold: a promise for each method and table.

use crate::tally::Tally;

/// A promise about some rows of a table, as shares of the runs.
pub(crate) struct Promise {
    pub(crate) method: &'static str,
    /// Whether it is about errors that nobody declared, or about laws within the declared bound.
    pub(crate) undeclared: bool,
    /// The rows; all where empty.
    pub(crate) cells: &'static [&'static str],
    pub(crate) quantity: Quantity,
    /// At least, or at most.
    pub(crate) least: f64,
    pub(crate) most: f64,
}

/// What is counted.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Quantity {
    /// The truth in the set, or in the 95 % region of a place, among all runs.
    Held,
    /// The same among the runs that are not inconsistent.
    HeldWhereTold,
    /// `inconsistent` among all runs.
    Inconsistent,
    /// Localized more than 5 cm off, among all runs.
    Wrong,
    /// Localized 5 mm or more off, and the truth outside of what is told, among all runs.
    Silent,
}

impl Quantity {
    pub(crate) fn text(self) -> &'static str {
        match self {
            Self::Held => "truth held, of all runs",
            Self::HeldWhereTold => "truth held, of runs with an answer",
            Self::Inconsistent => "inconsistent, of all runs",
            Self::Wrong => "localized at a wrong place, of all runs",
            Self::Silent => "localized 5 mm or more off without a word, of all runs",
        }
    }

    pub(crate) fn share(self, tally: &Tally) -> f64 {
        let told = tally.runs - tally.inconsistent();
        let (count, of) = match self {
            Self::Held => (tally.held, tally.runs),
            Self::HeldWhereTold => (tally.held, told),
            Self::Inconsistent => (tally.inconsistent(), tally.runs),
            Self::Wrong => (tally.wrong(), tally.runs),
            Self::Silent => (tally.silent, tally.runs),
        };
        if of > 0 { count as f64 / of as f64 } else { f64::NAN }
    }
}

const fn promise(method: &'static str, undeclared: bool, quantity: Quantity, least: f64, most: f64) -> Promise {
    Promise { method, undeclared, cells: &[], quantity, least, most }
}

/// The promises; a run of few worlds has room for one of them more.
pub(crate) const PROMISES: &[Promise] = &[
    // The guarantee, whatever the law.
    promise("possibilistic", false, Quantity::Held, 1.0, 1.0),
    promise("possibilistic", false, Quantity::Inconsistent, 0.0, 0.0),
    promise("possibilistic", false, Quantity::Silent, 0.0, 0.0),
    // 95 % regions, with room for what they leave out by chance.
    promise("probabilistic", false, Quantity::HeldWhereTold, 0.90, 1.0),
    promise("probabilistic", false, Quantity::Inconsistent, 0.0, 0.03),
    promise("probabilistic", false, Quantity::Silent, 0.0, 0.01),
    promise("probabilistic", false, Quantity::Wrong, 0.0, 0.01),
    // Nobody can tell what is not declared in every case; a wrong place without a word must be rare.
    promise("possibilistic", true, Quantity::Wrong, 0.0, 0.05),
    promise("probabilistic", true, Quantity::Wrong, 0.0, 0.05),
];
