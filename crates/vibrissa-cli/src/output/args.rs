//! Where results go, as every command understands it.

use super::files::Destination;
use super::picture::Picture;
use std::path::PathBuf;

/// Where results go.
#[derive(Clone, Debug, Default, clap::Args)]
pub(crate) struct OutputArgs {
    /// Write the result files into this folder, made if missing; without it nothing is written
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Write each figure in these formats, too, with commas between them
    #[arg(long, value_name = "FORMAT", value_enum, value_delimiter = ',', requires = "out")]
    pub(crate) pictures: Vec<Picture>,
    /// Print the result as JSON instead of words
    #[arg(long)]
    pub(crate) json: bool,
}

impl OutputArgs {
    /// Where files go; none where they are not asked for.
    pub(crate) fn destination(&self) -> Option<Destination<'_>> {
        self.out.as_deref().map(|folder| Destination { folder, pictures: &self.pictures })
    }
}
