//! Options of the deterministic method.

use vibrissa::{LocalizeOptions, Result};

/// What can be set about the deterministic method; each default lives in `vibrissa::config`.
#[derive(Clone, Debug, Default, clap::Args)]
#[command(next_help_heading = "Options of the deterministic method")]
pub(crate) struct DeterministicArgs {}

impl DeterministicArgs {
    /// The library's options.
    pub(crate) fn options(&self) -> Result<LocalizeOptions> {
        Ok(LocalizeOptions::default())
    }
}
