//! `vibrissa live --demo`: a simulated robot behind pseudo-terminals.

use super::{Args, Course, on_robot};
use crate::output::write_all;
use std::path::{Path, PathBuf};
use vibrissa::Result;
use vibrissa::config::defaults::SEED;
use vibrissa::tasks::demo;
use vibrissa_live::robot::SimulatedRobot;
use vibrissa_live::setup;

/// Speed of the robot (m/s): the sweep takes twelve seconds.
const SPEED: f64 = 0.02;

pub(super) fn run(args: &Args) -> Result<()> {
    let sweep = demo::sweep_at(SEED, SPEED)?;
    // The files that a setup names; without --out they are not kept.
    let temporary = std::env::temp_dir().join(format!("vibrissa-live-demo-{}", std::process::id()));
    let folder: PathBuf = args.out.clone().unwrap_or_else(|| temporary.clone());
    write_all(&folder, &[("map.svg", demo::ARENA_SVG.to_owned())])?;
    SimulatedRobot::write_files(&folder)?;
    let robot = SimulatedRobot::new()?;
    // Names beside the setup: the recording can be run again from anywhere.
    let text = robot.setup(Path::new("map.svg"), Path::new("robot.toml"));
    write_all(&folder, &[("live.toml", text.clone())])?;
    let folder = folder.canonicalize().unwrap_or(folder);
    let mut setup = setup::from_toml(&text, "the demo's setup")?;
    setup.based_on(&folder);
    let driving = robot.drive(sweep.log)?;
    let course = Course { truth: &sweep.truth, is_over: Some(&|| driving.is_finished()) };
    let result = on_robot(args, &setup, &folder, args.out.as_deref(), &course);
    if args.out.is_none() {
        // What cannot be removed is left to the system.
        let _ = std::fs::remove_dir_all(temporary);
    }
    result
}
