//! Options of the deterministic method.

use super::known::KnownArgs;
use clap::ValueEnum;
use vibrissa::config::{DeterministicOptions, TipLoad};
use vibrissa::{LocalizeOptions, Result};

/// What can be set about the deterministic method; each default lives in `vibrissa::config`.
#[derive(Clone, Debug, Default, clap::Args)]
#[command(next_help_heading = "Options of the deterministic method")]
pub(crate) struct DeterministicArgs {
    /// Which way the force acts at the tip [default: boundary-normal]
    #[arg(long, value_enum, value_name = "LOAD")]
    tip_load: Option<TipLoadArg>,
    /// Spacing of the points along the boundary at which the whisker is aligned, in m [default: 0.003]
    #[arg(long, value_name = "M")]
    boundary_spacing: Option<f64>,
    /// Whisker shapes that estimate the boundary's slope, 2 to 5 [default: 5]
    #[arg(long, value_name = "N")]
    history_shapes: Option<usize>,
    /// Travel of the whisker base from the first to the last of these shapes, in m [default: 0.01]
    #[arg(long, value_name = "M")]
    history_travel: Option<f64>,
    /// Travel of the whisker base between two updates, in m [default: 0.002]
    #[arg(long, value_name = "M")]
    update_travel: Option<f64>,
    /// How far a candidate may lie from an observation, in standard deviations [default: 4]
    #[arg(long, value_name = "SIGMA")]
    tolerance: Option<f64>,
    /// Share of the observations that a candidate may miss; 0 is the paper's plain intersection [default: 0.25]
    #[arg(long, value_name = "SHARE")]
    missed_share: Option<f64>,
}

/// The tip loads by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum TipLoadArg {
    /// Normal to the wall, as frictionless contact is
    BoundaryNormal,
    /// Normal to the whisker, as in the paper
    WhiskerNormal,
}

impl DeterministicArgs {
    /// The library's options.
    pub(crate) fn options(&self, known: &KnownArgs) -> Result<LocalizeOptions> {
        let default = DeterministicOptions::default();
        let tip_load = self.tip_load.map_or(default.tip_load, |load| match load {
            TipLoadArg::BoundaryNormal => TipLoad::BoundaryNormal,
            TipLoadArg::WhiskerNormal => TipLoad::WhiskerNormal,
        });
        let deterministic = DeterministicOptions {
            tip_load,
            boundary_spacing: self.boundary_spacing.unwrap_or(default.boundary_spacing),
            history_shapes: self.history_shapes.unwrap_or(default.history_shapes),
            history_travel: self.history_travel.unwrap_or(default.history_travel),
            update_travel: self.update_travel.unwrap_or(default.update_travel),
            tolerance: self.tolerance.unwrap_or(default.tolerance),
            missed_share: self.missed_share.unwrap_or(default.missed_share),
            prior: known.region(),
            ..default
        };
        deterministic.check()?;
        Ok(LocalizeOptions { deterministic, ..LocalizeOptions::default() })
    }
}
