//! The command line of vibrissa as a function, so that other shells can call it.

mod args;
mod commands;
mod interrupt;
mod output;
mod quantity;

use args::Cli;
use clap::Parser;
use std::ffi::OsString;
use std::io::Write;

pub use interrupt::interrupt;

/// Exit code: the command did what it was asked.
pub const DONE: u8 = 0;
/// Exit code: the data or the map is at fault, or a result could not be written.
pub const DATA: u8 = 1;
/// Exit code: the call is at fault.
pub const USAGE: u8 = 2;
/// Exit code: an interrupt (Ctrl-C) ended the command early, as shells tell it.
pub const INTERRUPTED: u8 = 130;

/// Runs the command line `args`, the program's name first, and gives its exit code: 0 done, 1 data, 2 usage, 130 [interrupted](interrupt()).
///
/// Results go to standard output; warnings and errors go to standard error. Never panics on input.
pub fn run<I, T>(args: I) -> u8
where
    I: IntoIterator<Item = T>,
    T: Into<OsString> + Clone,
{
    let cli = match Cli::try_parse_from(commands::joined(args.into_iter().map(Into::into))) {
        Ok(cli) => cli,
        Err(error) => {
            let words = error.render().to_string();
            // A closed pipe is the reader's choice.
            let _ = match output::plain(&words) {
                std::borrow::Cow::Borrowed(_) => error.print(),
                std::borrow::Cow::Owned(safe) => write!(std::io::stderr(), "{safe}"),
            };
            return if error.use_stderr() { USAGE } else { DONE };
        }
    };
    interrupt::reset();
    match commands::run(&cli.command) {
        Ok(()) if interrupt::stopped() => INTERRUPTED,
        Ok(()) => DONE,
        Err(error) => {
            let code = if error.is_usage() { USAGE } else { DATA };
            let remedy = if error.is_usage() {
                "correct the value; `vibrissa COMMAND --help` tells units and ranges"
            } else {
                "correct the file; docs/files.md tells columns, keys and units"
            };
            output::complain("error", &error.or_remedy(remedy));
            code
        }
    }
}
