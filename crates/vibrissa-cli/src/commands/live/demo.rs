//! `vibrissa live --demo`: a simulated robot behind pseudo-terminals, which drives along a path or explores.

use super::{Args, Course, on_robot};
use crate::output::write_all;
use std::path::{Path, PathBuf};
use std::sync::mpsc::channel;
use vibrissa::Result;
use vibrissa::config::defaults::SEED;
use vibrissa::sim::{Pace, SimulateOptions, Stage, SweepNoise};
use vibrissa::tasks::demo;
use vibrissa::tasks::explore::beginning;
use vibrissa::world::Robot;
use vibrissa_live::robot::{SimulatedRobot, TrueCourse};
use vibrissa_live::setup;

/// Speed of the robot (m/s): the sweep takes twelve seconds.
const SPEED: f64 = 0.02;
/// How far a robot that explores goes before it is told where to (m), and how fast it goes.
const FIRST: f64 = 0.08;
const EXPLORING: Pace = Pace { speed: 0.04, turn_rate: 0.5, rate: SimulatedRobot::RATE };

pub(super) fn run(args: &Args) -> Result<()> {
    // The files that a setup names; without --out they are not kept.
    let temporary = std::env::temp_dir().join(format!("vibrissa-live-demo-{}", std::process::id()));
    let folder: PathBuf = args.out.clone().unwrap_or_else(|| temporary.clone());
    write_all(&folder, &[("map.svg", demo::ARENA_SVG.to_owned())])?;
    SimulatedRobot::write_files(&folder)?;
    let robot = SimulatedRobot::new()?;
    // Names beside the setup: the recording can be run again from anywhere.
    let text = robot.setup((!args.mapping).then_some(Path::new("map.svg")), Path::new("robot.toml"));
    write_all(&folder, &[("live.toml", text.clone())])?;
    let folder = folder.canonicalize().unwrap_or(folder);
    let mut setup = setup::from_toml(&text, "the demo's setup")?;
    setup.based_on(&folder);
    let result = if args.explore {
        let (errands, theirs) = channel();
        let driven = TrueCourse::default();
        let stage = Stage::new(demo::arena()?, Robot::default(), SimulateOptions::default())?;
        let begin = beginning(&demo::path()?, FIRST);
        let noise = SweepNoise::seeded(SEED);
        let driving = robot.obey(stage, &begin, EXPLORING, noise, theirs, driven.clone())?;
        let (truth, is_over) = (|| driven.last(), || driving.is_finished());
        let course = Course { truth: Some(&truth), is_over: Some(&is_over), errands: Some(errands) };
        on_robot(args, &setup, &folder, args.out.as_deref(), course)
    } else {
        let sweep = demo::sweep_at(SEED, SPEED)?;
        let driving = robot.drive(sweep.log)?;
        let (truth, is_over) = (|| sweep.truth.last().copied(), || driving.is_finished());
        let course = Course { truth: Some(&truth), is_over: Some(&is_over), errands: None };
        on_robot(args, &setup, &folder, args.out.as_deref(), course)
    };
    if args.out.is_none() {
        // What cannot be removed is left to the system.
        let _ = std::fs::remove_dir_all(temporary);
    }
    result
}
