//! A robot that is steered: what its whiskers read.

use crate::host::Host;
use core::fmt::Write;
use self_cell::self_cell;
use vibrissa::flow::pose::StampedPose;
use vibrissa::plane::Pose2;
use vibrissa::sim::recorder::TrueErrors;
use vibrissa::sim::{Drive, Part, SimulateOptions, Stage, SweepNoise};
use vibrissa::{Error, Result, SensorLog};

/// Links of the discrete rod where one contact does not say it all: coarse, so that the page stays smooth.
const LINKS: usize = 24;
/// Points of a drawn whisker.
const POINTS: usize = 32;
/// Numbers of a pose in the input.
const POSE: usize = 7;

self_cell! {
    /// A stage and the robot that drives on it.
    pub(crate) struct Driving {
        owner: Stage,
        #[not_covariant]
        dependent: Drive,
    }
}

pub(crate) fn drive(host: &mut Host, op: u32) -> Result<()> {
    match op {
        0 => start(host),
        1 => advance(host),
        other => Err(Error::usage("op").value(other).allowed("0 or 1")),
    }
}

fn start(host: &mut Host) -> Result<()> {
    let [t, x, y, theta, seed, noisy] = host.input_numbers()[..] else {
        return Err(Error::usage("six numbers start a drive"));
    };
    let at = StampedPose { t, map_from_robot: Pose2::new(x, y, theta) };
    let noise = if noisy > 0.0 { SweepNoise::seeded(seed.max(0.0) as u64) } else { SweepNoise::none() };
    let options = SimulateOptions { links: LINKS, ..SimulateOptions::default() };
    let stage = Stage::new(host.map()?.clone(), host.robot.clone(), options)?;
    host.log = SensorLog { channels: stage.channels(), ..SensorLog::default() };
    host.driving = Some(Driving::try_new(stage, |stage| Drive::start(stage, at, &noise))?);
    move_on(host, &[t, x, y, theta, 0.0, 0.0, 0.0])
}

fn advance(host: &mut Host) -> Result<()> {
    let poses = host.input_numbers();
    move_on(host, &poses)
}

fn move_on(host: &mut Host, poses: &[f64]) -> Result<()> {
    let Some(mut driving) = host.driving.take() else { return Err(Error::usage("no drive was started yet")) };
    let moved = driving.with_dependent_mut(|_, drive| along(host, drive, poses));
    host.driving = Some(driving);
    moved
}

fn along(host: &mut Host, drive: &mut Drive<'_>, poses: &[f64]) -> Result<()> {
    host.count(poses.len() / POSE);
    host.count(drive.moments().len());
    for pose in poses.chunks_exact(POSE) {
        let &[t, x, y, theta, zero, gain, slip] = pose else { continue };
        let errors = TrueErrors { zero, gain, ..TrueErrors::default() };
        let row = drive.advance(StampedPose { t, map_from_robot: Pose2::new(x, y, theta) }, &errors, slip)?;
        host.row(&row);
        host.push(drive.moments());
        host.log.rows.push(row);
    }
    let touches = drive.touches();
    host.count(touches.len());
    for touch in touches {
        host.count(touch.whisker);
        host.point(touch.position);
        host.point(touch.force);
        host.push([f64::from(u8::from(touch.part == Part::Side))]);
    }
    drive.shapes(POINTS).iter().for_each(|points| host.points(points));
    for event in drive.events() {
        let _ = writeln!(host.text, "{}\t{}\t{}", event.t, event.kind, event.detail);
    }
    Ok(())
}
