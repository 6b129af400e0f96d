//! The command `vibrissa`.

use std::process::ExitCode;
use vibrissa_cli::{interrupt, run};

fn main() -> ExitCode {
    // Where no handler can be had, an interrupt ends the program at once, which leaves earlier results whole, too.
    let _ = ctrlc::set_handler(interrupt);
    ExitCode::from(run(std::env::args_os()))
}
