//! One file or folder for each command.

mod beam;
mod calibrate;
mod contact;
mod contact_set;
mod demo;
mod explore;
mod join;
#[cfg(feature = "live")]
mod live;
mod localize;
mod logs;
mod map;
mod plan;
mod preimage;
mod profile;
mod readings;
mod reproduce;
mod sensor;
mod simulate;
mod studio;

use crate::output::progress::Progress;
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
    Map(map::Args),
    Localize(localize::Args),
    Plan(plan::Args),
    Explore(explore::Args),
    Join(join::Args),
    #[cfg(feature = "live")]
    Live(live::Args),
    ContactSet(contact_set::Args),
    Preimage(preimage::Args),
    Simulate(simulate::Args),
    Sensor(sensor::Args),
    Studio(studio::Args),
    Reproduce(reproduce::Args),
}

/// What a command that may take long does, for the line that says so; none for those that have a line of their own.
fn doing(command: &Command) -> Option<&'static str> {
    Some(match command {
        Command::Beam(_) => "bending",
        Command::Calibrate(_) => "calibrating",
        Command::Contact(_) => "finding contacts",
        Command::ContactSet(_) => "finding the contact set",
        Command::Preimage(_) => "finding the preimage",
        Command::Profile(_) => "finding the outline",
        Command::Map(_) => "mapping",
        Command::Demo(_) => "simulating and localizing",
        Command::Localize(_) => "reading",
        Command::Plan(_) => "reading",
        Command::Explore(_) => "reading the scenario",
        Command::Join(_) => "joining",
        Command::Simulate(_) => "reading the scenario",
        Command::Sensor(_) => "designing",
        #[cfg(feature = "live")]
        Command::Live(_) => return None,
        Command::Studio(_) | Command::Reproduce(_) => return None,
    })
}

/// Runs a command.
pub(crate) fn run(command: &Command) -> Result<()> {
    let _line = doing(command).map(Progress::begin);
    match command {
        Command::Beam(args) => beam::run(args),
        Command::Calibrate(args) => calibrate::run(args),
        Command::Contact(args) => contact::run(args),
        Command::ContactSet(args) => contact_set::run(args),
        Command::Preimage(args) => preimage::run(args),
        Command::Profile(args) => profile::run(args),
        Command::Map(args) => map::run(args),
        Command::Demo(args) => demo::run(args),
        Command::Localize(args) => localize::run(args),
        Command::Plan(args) => plan::run(args),
        Command::Explore(args) => explore::run(args),
        Command::Join(args) => join::run(args),
        #[cfg(feature = "live")]
        Command::Live(args) => live::run(args),
        Command::Simulate(args) => simulate::run(args),
        Command::Sensor(args) => sensor::run(args),
        Command::Studio(args) => studio::run(args),
        Command::Reproduce(args) => reproduce::run(args),
    }
}
