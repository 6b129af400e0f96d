//! Options of the possibilistic method.

use super::known::KnownArgs;
use vibrissa::config::PossibilisticOptions;
use vibrissa::flow::pose::Method;
use vibrissa::{LocalizeOptions, Result};

/// What can be set about the possibilistic method; each default lives in `vibrissa::config`.
#[derive(Clone, Debug, Default, clap::Args)]
#[command(next_help_heading = "Options of the possibilistic method")]
pub(crate) struct PossibilisticArgs {
    /// How many readings may break their bounds [default: 0]
    #[arg(long, value_name = "K")]
    tolerate: Option<usize>,
    /// Largest slope of the whisker at its contact, in rad [default: 2.2]
    #[arg(long, value_name = "RAD")]
    largest_slope: Option<f64>,
    /// Meetings of cells and readings in one row: more is tighter and slower, never less sound [default: 130]
    #[arg(long, value_name = "N")]
    work: Option<usize>,
    /// The same once more at the end of the log [default: 5000000]
    #[arg(long, value_name = "N")]
    last_work: Option<usize>,
}

impl PossibilisticArgs {
    /// The library's options.
    pub(crate) fn options(&self, known: &KnownArgs) -> Result<LocalizeOptions> {
        let default = PossibilisticOptions::default();
        let possibilistic = PossibilisticOptions {
            tolerate: self.tolerate.unwrap_or(default.tolerate),
            heading_error: known.heading_error.unwrap_or(default.heading_error),
            largest_slope: self.largest_slope.unwrap_or(default.largest_slope),
            work: self.work.unwrap_or(default.work),
            last_work: self.last_work.unwrap_or(default.last_work),
            prior: known.region(),
            ..default
        };
        possibilistic.check()?;
        Ok(LocalizeOptions { method: Method::Possibilistic, possibilistic, ..LocalizeOptions::default() })
    }
}
