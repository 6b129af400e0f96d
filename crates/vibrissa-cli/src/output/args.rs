//! Where results go, as every command understands it.

use std::path::PathBuf;

/// Where results go.
#[derive(Clone, Debug, Default, clap::Args)]
pub(crate) struct OutputArgs {
    /// Write the result files into this folder, made if missing; without it nothing is written
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Print the result as JSON instead of words
    #[arg(long)]
    pub(crate) json: bool,
}
