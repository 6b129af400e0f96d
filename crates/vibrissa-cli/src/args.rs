//! The command line as a whole.

use clap::Parser;

/// Where a robot is, by touch: whisker mechanics and localization.
///
/// Files hold SI units (m, rad, s, N m); what is shown carries its unit. Exit codes: 0 done, 1 the data or the map is at
/// fault, 2 the call is at fault.
#[derive(Debug, Parser)]
#[command(name = "vibrissa", version, arg_required_else_help = true, max_term_width = 100)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: crate::commands::Command,
}
