//! One file or folder for each command.

mod beam;
mod calibrate;
mod contact;
mod contact_set;
mod demo;
mod join;
#[cfg(feature = "live")]
mod live;
mod localize;
mod preimage;
mod profile;
mod readings;
mod reproduce;
mod simulate;

use clap::Subcommand;
pub(crate) use localize::joined;
use vibrissa::Result;

/// The commands, described by their own arguments.
///
/// A new one takes three lines: its module above, its variant here, its arm in [`run`].
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    Demo(demo::Args),
    Beam(beam::Args),
    Calibrate(calibrate::Args),
    Contact(contact::Args),
    Profile(profile::Args),
    Localize(localize::Args),
    Join(join::Args),
    #[cfg(feature = "live")]
    Live(live::Args),
    ContactSet(contact_set::Args),
    Preimage(preimage::Args),
    Simulate(simulate::Args),
    Reproduce(reproduce::Args),
}

/// Runs a command.
pub(crate) fn run(command: &Command) -> Result<()> {
    match command {
        Command::Beam(args) => beam::run(args),
        Command::Calibrate(args) => calibrate::run(args),
        Command::Contact(args) => contact::run(args),
        Command::ContactSet(args) => contact_set::run(args),
        Command::Preimage(args) => preimage::run(args),
        Command::Profile(args) => profile::run(args),
        Command::Demo(args) => demo::run(args),
        Command::Localize(args) => localize::run(args),
        Command::Join(args) => join::run(args),
        #[cfg(feature = "live")]
        Command::Live(args) => live::run(args),
        Command::Simulate(args) => simulate::run(args),
        Command::Reproduce(args) => reproduce::run(args),
    }
}
