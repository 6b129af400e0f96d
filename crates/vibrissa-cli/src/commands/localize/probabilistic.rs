//! Options of the probabilistic method.

use super::known::KnownArgs;
use vibrissa::config::ProbabilisticOptions;
use vibrissa::flow::pose::Method;
use vibrissa::{LocalizeOptions, Result};

/// What can be set about the probabilistic method; each default lives in `vibrissa::config`.
#[derive(Clone, Debug, Default, clap::Args)]
#[command(next_help_heading = "Options of the probabilistic method")]
pub(crate) struct ProbabilisticArgs {
    /// Spacing along the boundary of the first hypotheses, in m [default: 0.004]
    #[arg(long, value_name = "M")]
    seed_spacing: Option<f64>,
    /// Spacing of their headings, in rad [default: 0.11]
    #[arg(long, value_name = "RAD")]
    seed_turn: Option<f64>,
    /// Travel of the whisker base in contact before the first hypotheses, in m [default: 0.012]
    #[arg(long, value_name = "M")]
    seed_travel: Option<f64>,
    /// Standard deviation of a relative error that all readings share [default: a quarter of the noise bound]
    #[arg(long, value_name = "SHARE")]
    shared_gain: Option<f64>,
    /// Share of the rows that no contact needs to explain, since the whisker has snapped or touches at three places
    /// [default: 0.05]
    #[arg(long, value_name = "SHARE")]
    tolerated_share: Option<f64>,
}

impl ProbabilisticArgs {
    /// The library's options.
    pub(crate) fn options(&self, known: &KnownArgs) -> Result<LocalizeOptions> {
        let default = ProbabilisticOptions::default();
        let probabilistic = ProbabilisticOptions {
            seed_spacing: self.seed_spacing.unwrap_or(default.seed_spacing),
            seed_turn: self.seed_turn.unwrap_or(default.seed_turn),
            seed_travel: self.seed_travel.unwrap_or(default.seed_travel),
            shared_gain: self.shared_gain,
            tolerated_share: self.tolerated_share.unwrap_or(default.tolerated_share),
            heading_error: known.heading_error.unwrap_or(default.heading_error),
            prior: known.region(),
            ..default
        };
        probabilistic.check()?;
        Ok(LocalizeOptions { method: Method::Probabilistic, probabilistic, ..LocalizeOptions::default() })
    }
}
