//! The command `vibrissa`.

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(vibrissa_cli::run(std::env::args_os()))
}
