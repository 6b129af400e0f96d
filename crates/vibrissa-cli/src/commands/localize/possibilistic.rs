//! Options of the possibilistic method.

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
    /// Bound on the error of the log's absolute headings, in rad [default: 0.05]
    #[arg(long, value_name = "RAD")]
    heading_error: Option<f64>,
    /// Largest slope of the whisker at its contact, in rad [default: 2.2]
    #[arg(long, value_name = "RAD")]
    largest_slope: Option<f64>,
    /// Where the robot is at the first row, in m and rad: least and largest x, y and heading, six numbers
    #[arg(long, value_name = "BOX", value_delimiter = ',', num_args = 6, allow_hyphen_values = true)]
    within: Option<Vec<f64>>,
    /// Meetings of cells and readings in one row: more is tighter and slower, never less sound [default: 80]
    #[arg(long, value_name = "N")]
    work: Option<usize>,
    /// The same once more at the end of the log [default: 300000]
    #[arg(long, value_name = "N")]
    last_work: Option<usize>,
}

impl PossibilisticArgs {
    /// The library's options.
    pub(crate) fn options(&self) -> Result<LocalizeOptions> {
        let default = PossibilisticOptions::default();
        let prior = self.within.as_deref().and_then(|v| match *v {
            [a, b, c, d, e, f] => Some([[a, b], [c, d], [e, f]]),
            _ => None,
        });
        let possibilistic = PossibilisticOptions {
            tolerate: self.tolerate.unwrap_or(default.tolerate),
            heading_error: self.heading_error.unwrap_or(default.heading_error),
            largest_slope: self.largest_slope.unwrap_or(default.largest_slope),
            work: self.work.unwrap_or(default.work),
            last_work: self.last_work.unwrap_or(default.last_work),
            prior,
            ..default
        };
        possibilistic.check()?;
        Ok(LocalizeOptions { method: Method::Possibilistic, possibilistic, ..LocalizeOptions::default() })
    }
}
