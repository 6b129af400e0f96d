//! One file or folder for each command.

mod beam;
mod contact;
mod demo;
mod localize;
mod profile;

use clap::Subcommand;
use vibrissa::Result;

/// The commands, described by their own arguments.
///
/// A new one takes three lines: its module above, its variant here, its arm in [`run`].
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    Demo(demo::Args),
    Beam(beam::Args),
    Contact(contact::Args),
    Profile(profile::Args),
    Localize(localize::Args),
}

/// Runs a command.
pub(crate) fn run(command: &Command) -> Result<()> {
    match command {
        Command::Beam(args) => beam::run(args),
        Command::Contact(args) => contact::run(args),
        Command::Profile(args) => profile::run(args),
        Command::Demo(args) => demo::run(args),
        Command::Localize(args) => localize::run(args),
    }
}
