//! How the equilibria of a whisker with its tip in contact are solved.

use crate::beam::{TipChart, TipModel, TipTable, held_tip_chart, tip_chart};

/// How exactly equilibria are solved.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Mechanics<'a> {
    /// In closed form, to rounding.
    ClosedForm,
    /// From a table, to about 1e-4 of a moment.
    Table(&'a TipTable),
    /// From the table of a whisker that is not uniform: its tip alone.
    Model(&'a TipModel),
}

impl Mechanics<'_> {
    pub(super) fn chart(&self, q: f64, beta: f64) -> Option<TipChart> {
        match self {
            Self::ClosedForm => tip_chart(q, beta),
            Self::Table(table) => table.at(q, beta),
            Self::Model(tip) => tip.chart(q, beta),
        }
    }

    /// The same for a tip that is held in a corner, beyond the first mode too.
    pub(super) fn held_chart(&self, q: f64, beta: f64) -> Option<TipChart> {
        match self {
            Self::ClosedForm => held_tip_chart(q, beta),
            Self::Table(table) => table.at(q, beta).or_else(|| held_tip_chart(q, beta)),
            Self::Model(tip) => tip.chart(q, beta),
        }
    }

    /// One of two tolerances.
    pub(super) fn pick(&self, quick: f64, exact: f64) -> f64 {
        if matches!(self, Self::ClosedForm) { exact } else { quick }
    }

    /// Residual (whisker lengths, rad) from which one more Newton step ends the search; the error left is about its
    /// square, and more where the branch is about to fold: with a hundredth of a length left there, whiskers snap a row
    /// too early or late and sweeps of a thousand rows end two standard deviations off.
    pub(super) fn near(&self) -> f64 {
        match self {
            Self::ClosedForm | Self::Model(_) => 2e-5,
            Self::Table(_) => 1e-3,
        }
    }
}
