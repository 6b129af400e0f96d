//! The runs of one cell and method, counted.

use crate::judge::{Judged, Outcome};

/// Counts and errors of one row of a table.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tally {
    pub(crate) runs: usize,
    /// In the order of [`Outcome`].
    pub(crate) outcomes: [usize; 6],
    /// Runs in which the truth is in what the method tells.
    pub(crate) held: usize,
    /// Runs that are localized 5 mm or more off, with the truth outside of what the method tells.
    pub(crate) silent: usize,
    /// Of localized runs, sorted: errors (m, rad) and what the method says of them (m).
    pub(crate) errors: Vec<f64>,
    pub(crate) turns: Vec<f64>,
    pub(crate) bounds: Vec<f64>,
    /// Error over the Cramer-Rao bound, sorted, of runs localized right at a place that is not open.
    pub(crate) ratios: Vec<f64>,
}

impl Tally {
    pub(crate) fn of(runs: impl Iterator<Item = Judged>) -> Self {
        let mut tally = Self::default();
        for run in runs {
            tally.runs += 1;
            tally.outcomes[run.outcome as usize] += 1;
            tally.held += usize::from(run.held);
            tally.silent += usize::from(matches!(run.outcome, Outcome::Off | Outcome::Wrong) && !run.held);
            tally.errors.extend(run.error.map(|error| error.0));
            tally.turns.extend(run.error.map(|error| error.1));
            tally.bounds.extend(run.bound);
            if let (Some(error), Some(least), Outcome::Right, false) = (run.error, run.least, run.outcome, run.ridge) {
                tally.ratios.push(error.0 / least);
            }
        }
        for values in [&mut tally.errors, &mut tally.turns, &mut tally.bounds, &mut tally.ratios] {
            values.sort_by(f64::total_cmp);
        }
        tally
    }

    pub(crate) fn wrong(&self) -> usize {
        self.outcomes[Outcome::Wrong as usize]
    }

    pub(crate) fn inconsistent(&self) -> usize {
        self.outcomes[Outcome::Inconsistent as usize]
    }

    /// The outcomes as in the tables: `14/0/0/8/0/0`, a wrong place in bold.
    pub(crate) fn cells(&self) -> String {
        let show = |(k, count): (usize, &usize)| {
            if k == Outcome::Wrong as usize && *count > 0 { format!("**{count}**") } else { count.to_string() }
        };
        self.outcomes.iter().enumerate().map(show).collect::<Vec<_>>().join("/")
    }
}

/// The value below which this share of the sorted values lie.
pub(crate) fn quantile(sorted: &[f64], share: f64) -> f64 {
    sorted.get((share * sorted.len() as f64) as usize).copied().unwrap_or(f64::NAN)
}
