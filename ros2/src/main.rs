//! The node as a program: `vibrissa-ros2 --ros-args -p map:=arena.svg`.

use std::process::ExitCode;
use vibrissa_ros2::lines;
use vibrissa_ros2::node::{start, tell_lines};
use vibrissa_ros2::parameters::{NAMES, Parameters};

fn main() -> ExitCode {
    let args: Vec<String> = std::env::args().skip(1).collect();
    if args.iter().any(|arg| arg == "--help" || arg == "-h") {
        println!(
            "Usage: vibrissa-ros2 --ros-args -p NAME:=VALUE ... --params-file FILE -r FROM:=TO ...\n       \
             vibrissa-ros2 --lines KIND TOPIC    (for vibrissa live: odometry, joints, array or wrench as lines)\n\nParameters:"
        );
        NAMES.iter().for_each(|(name, what)| println!("  {name:<22}{what}"));
        return ExitCode::SUCCESS;
    }
    let variable = |name: &str| std::env::var(name).ok();
    if let Some(("--lines", asked)) = args.split_first().map(|(first, rest)| (first.as_str(), rest)) {
        let told = lines::asked(asked)
            .and_then(|(message, topic)| tell_lines(&Parameters::from_environment(&variable)?, message, &topic));
        return match told {
            Ok(()) => ExitCode::SUCCESS,
            Err(error) => {
                eprintln!("{error}");
                ExitCode::from(if error.is_usage() { 2 } else { 1 })
            }
        };
    }
    let parameters = Parameters::from_args(&args, &variable);
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
