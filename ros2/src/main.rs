//! The node as a program: `vibrissa-ros2 --ros-args -p map:=arena.svg`.

use std::process::ExitCode;
use vibrissa_ros2::node::start;
use vibrissa_ros2::parameters::{NAMES, Parameters};

fn main() -> ExitCode {
    let args: Vec<String> = std::env::args().skip(1).collect();
    if args.iter().any(|arg| arg == "--help" || arg == "-h") {
        println!(
            "Usage: vibrissa-ros2 --ros-args -p NAME:=VALUE ... --params-file FILE -r FROM:=TO ...\n\nParameters:"
        );
        NAMES.iter().for_each(|(name, what)| println!("  {name:<22}{what}"));
        return ExitCode::SUCCESS;
    }
    let parameters = Parameters::from_args(&args, &|name| std::env::var(name).ok());
    let started = parameters.and_then(|(parameters, left_out)| {
        left_out.iter().for_each(|words| eprintln!("left out: {words}"));
        start(&parameters)
    });
    match started {
        Ok(node) => {
            node.wait();
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("{error}");
            ExitCode::from(if error.is_usage() { 2 } else { 1 })
        }
    }
}
