//! `vibrissa demo`: the main job without any file.

use crate::args::OutputArgs;
use vibrissa::{Error, Result};

/// Simulate a sweep in the built-in arena, localize, and compare with the truth.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    #[command(flatten)]
    output: OutputArgs,
}

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<()> {
    crate::output::deliver(&built_in_run()?, &args.output)
}

/// The built-in sweep, localized; its log and its truth come from the library's simulator.
fn built_in_run() -> Result<crate::output::Run> {
    Err(Error::usage("the built-in sweep is not there yet")
        .remedy("localize a log of your own: vibrissa localize --help"))
}
