//! `vibrissa contact-set`: which contacts explain readings.

mod report;

use super::readings::ReadingArgs;
use crate::output::{OutputArgs, print, warn, write_all, wrote};
use vibrissa::Result;

/// Tell which contacts explain a reading of a virtual sensor, or several readings at once.
///
/// The contact points are in the frame of the (first) whisker: base at the origin, undeflected along +x, a push towards +y is
/// positive. An exact reading leaves curves, every branch; a reading with a bound leaves regions; readings of one
/// whisker are combined on the contact itself, those of several whiskers at the place that all touch.
///
/// With --out DIR: contact-set.csv (contacts, or cells of regions) and the figure contact-set.svg.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    #[command(flatten)]
    readings: ReadingArgs,
    #[command(flatten)]
    output: OutputArgs,
}

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<()> {
    let whiskers = args.readings.read()?;
    let found = report::Found::new(&whiskers)?;
    if found.is_empty() {
        warn("no contact explains the readings: they contradict each other, or the whisker's length and limits");
    }
    let mut written = Vec::new();
    if let Some(to) = args.output.destination() {
        written = write_all(to, &[("contact-set.csv", found.csv()), ("contact-set.svg", found.figure())])?;
    }
    print(&if args.output.json { found.json() } else { found.text() + &wrote(&written) })
}
