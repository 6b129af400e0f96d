//! Robots that follow walls which nobody told them, by touch: laps, moments within the band, strain and collisions.

use crate::exploring::{KINDS, room};
use crate::random_sweep::random::Random;
use core::f64::consts::PI;
use std::process::ExitCode;
use vibrissa::control::{FollowOptions, FollowState, WallFollower};
use vibrissa::flow::pose::StampedPose;
use vibrissa::plane::{Pose2, Twist2, Vec2};
use vibrissa::sim::recorder::TrueErrors;
use vibrissa::sim::{Drive, SimulateOptions, Stage, SweepNoise};
use vibrissa::world::{Map, MountedWhisker, Robot};

/// Links of the simulator's discrete rod.
const LINKS: usize = 30;
/// A lap takes so many times the boundary's length at full speed; after more a robot gives up.
const PATIENCE: f64 = 5.0;
/// The share of a boundary that is a lap: the last of it overlaps the first.
const LAP: f64 = 0.98;
/// Robots by their whiskers.
const ROBOTS: [&str; 3] = ["one whisker", "two whiskers", "three whiskers"];

/// A robot on its way.
struct World {
    kind: usize,
    whiskers: usize,
    stage: Stage,
    begin: Pose2,
    options: FollowOptions,
    errors: TrueErrors,
    /// What is moved over what is told, and turned besides (rad/m).
    moved: f64,
    veer: f64,
    rate: f64,
}

/// What became of it.
#[derive(Clone, Debug)]
pub(crate) struct Followed {
    kind: usize,
    whiskers: usize,
    sideways: bool,
    lap: bool,
    /// Way until the lap was done, over the boundary's length.
    way: f64,
    blocked: bool,
    collided: bool,
    /// Share of the rows that follow in which the moment is within the band.
    kept: f64,
    /// The largest moment over what is gentle.
    hardest: f64,
}

/// The robot of a seed, if it has a place to begin.
pub(crate) fn follow(seed: u64, verbose: bool) -> Option<(u64, Followed)> {
    let world = (0..20).find_map(|trial| world(seed, trial))?;
    match run(&world, seed, verbose) {
        Ok(found) => Some((seed, found)),
        Err(error) => {
            println!("seed {seed}: {error}");
            None
        }
    }
}

fn world(seed: u64, trial: u64) -> Option<World> {
    let mut draw = Random(seed.wrapping_mul(0xd6e8_feb8_6659_fd93) ^ 0x00f0_1104);
    let kind = (seed % 4) as usize;
    let map = room(kind, &mut draw)?;
    let length = draw.between(0.06, 0.09);
    let (side, lean) = (draw.sign(), draw.between(0.5, 1.1));
    let whiskers = 1 + ((seed / 4) % 3) as usize;
    let rigidity = 10f64.powf(draw.between(-4.0, -3.0));
    let mounts = [side * lean, -side * lean, 0.0];
    let whisker = |k: usize| {
        let mut whisker = MountedWhisker { name: format!("w{k}"), ..MountedWhisker::default() };
        (whisker.beam.length, whisker.beam.flexural_rigidity) = (length, rigidity);
        whisker.noise.moment_absolute = 5e-3 * rigidity / length;
        whisker.robot_from_whisker =
            Pose2::new(0.005, 0.006 * mounts[k].signum() * mounts[k].abs().min(1.0), mounts[k]);
        whisker
    };
    let robot = Robot { whiskers: (0..whiskers).map(whisker).collect(), ..Robot::default() };
    let options = FollowOptions {
        sideways: (seed / 12).is_multiple_of(2),
        footprint: 0.015,
        speed: draw.between(0.05, 0.15),
        ..FollowOptions::default()
    };
    let unit = rigidity / length;
    let errors = TrueErrors { zero: draw.signed(0.05) * unit, gain: draw.signed(0.1), ..TrueErrors::default() };
    let (moved, veer) = (1.0 + draw.signed(0.03), draw.signed(0.5));
    let rate = draw.between(50.0, 300.0);
    let mut draw = Random(draw.0 ^ trial.wrapping_mul(0xd1b5_4a32_d192_ed03));
    let begin = begin(&map, &robot, &mut draw)?;
    let stage = Stage::new(map, robot, SimulateOptions { links: LINKS, ..SimulateOptions::default() }).ok()?;
    Some(World { kind, whiskers, stage, begin, options, errors, moved, veer, rate })
}

/// A pose at which whiskers are free. One whisker feels one side alone, and begins beside the wall.
fn begin(map: &Map, robot: &Robot, draw: &mut Random) -> Option<Pose2> {
    let samples = map.samples(2e-3);
    let on = samples[((draw.unit() * samples.len() as f64) as usize).min(samples.len() - 1)];
    let inward = Vec2::from_angle(on.tangent).perp();
    let first = &robot.whiskers[0];
    let side = first.robot_from_whisker.theta.signum();
    let along = if side < 0.0 { on.tangent } else { on.tangent + PI };
    let reach = first.beam.length * first.robot_from_whisker.theta.sin().abs() + 0.006;
    let (off, turn) = if robot.whiskers.len() > 1 {
        (draw.between(1.0, 2.5) * reach, draw.signed(PI))
    } else {
        (reach + draw.between(2e-3, 6e-3), -draw.between(-0.2, 0.2))
    };
    let p = on.position + inward * off;
    let pose = Pose2::new(p.x, p.y, along + turn);
    let is_clear = |k: i32, w: &MountedWhisker| {
        let along = Vec2::new(w.beam.length * f64::from(k) / 20.0, 0.0);
        let p = pose.compose(w.robot_from_whisker).transform_point(along);
        map.is_free(p) && map.nearest_within(p, 1e-3).is_none()
    };
    let ahead = if robot.whiskers.len() > 1 { 0.0 } else { 0.12 };
    let clear = (0..=10).all(|k| {
        let p = pose.transform_point(Vec2::new(ahead * f64::from(k) / 10.0, 0.0));
        map.is_free(p) && map.nearest_within(p, 0.03).is_none()
    });
    (clear && robot.whiskers.iter().all(|w| (0..=20).all(|k| is_clear(k, w)))).then_some(pose)
}

fn run(world: &World, seed: u64, verbose: bool) -> vibrissa::Result<Followed> {
    let (map, robot) = (world.stage.map(), world.stage.robot());
    let mut follower = WallFollower::new(robot, &world.options)?;
    let mut drive =
        Drive::start(&world.stage, StampedPose { t: 0.0, map_from_robot: world.begin }, &SweepNoise::seeded(seed))?;
    let lengths: Vec<f64> = map.boundaries().iter().map(|b| b.curve().length()).collect();
    let mut gone = vec![0.0_f64; lengths.len()];
    let mut last = None;
    let dt = 1.0 / world.rate;
    let mut found = Followed {
        kind: world.kind,
        whiskers: world.whiskers,
        sideways: world.options.sideways,
        lap: false,
        way: 0.0,
        blocked: false,
        collided: false,
        kept: 0.0,
        hardest: 0.0,
    };
    let (mut rows, mut kept, mut t) = (0_usize, 0_usize, 0.0);
    let mut readings = drive.advance(drive.pose(), &world.errors, 0.0)?.readings;
    let mut state = None;
    let longest = lengths.iter().copied().fold(0.0, f64::max);
    while found.way < PATIENCE * longest && t < 4.0 * PATIENCE * longest / world.options.speed {
        let told = follower.step(t, &readings);
        if verbose && state != Some(told.state) {
            let pose = drive.pose().map_from_robot;
            println!("{t:.2} s {:?} at {pose:.3?} readings {readings:.5?}", told.state);
            state = Some(told.state);
        }
        let Twist2 { x, y, theta } = told.twist;
        let twist = Twist2 { x: world.moved * x * dt, y: world.moved * y * dt, theta: (theta + world.veer * x) * dt };
        let from = drive.pose().map_from_robot;
        let to = from.compose(Pose2::exp(twist));
        t += dt;
        readings = drive.advance(StampedPose { t, map_from_robot: to }, &world.errors, 0.0)?.readings;
        found.way += from.position().distance(to.position());
        let before = found.hardest;
        for (moment, whisker) in drive.moments().iter().zip(&robot.whiskers) {
            found.hardest = found.hardest.max(moment.abs() / world.options.most_of(whisker));
        }
        if verbose && found.hardest > 1.0 && found.hardest > before {
            println!("{t:.2} s bent too far at {to:.3?}: {:.2}", found.hardest);
        }
        let now_collided = collides(map, robot, from, to, world.options.footprint);
        if verbose && now_collided && !found.collided {
            println!("{t:.2} s collided at {to:.3?}");
        }
        found.collided |= now_collided;
        if told.state == FollowState::Following {
            rows += 1;
            let within = drive.moments().iter().zip(&robot.whiskers).take(1).all(|(moment, whisker)| {
                let [low, high] = world.options.band_of(whisker);
                (low..=high).contains(&moment.abs())
            });
            kept += usize::from(within);
        }
        if told.state == FollowState::Blocked {
            found.blocked = true;
            break;
        }
        let beside = 1.5 * (robot.whiskers[0].beam.length + 0.01);
        if let Some(near) = map.nearest_within(to.position(), beside) {
            if let Some((boundary, at)) = last.replace((near.boundary, near.arc_length))
                && boundary == near.boundary
            {
                let length = lengths[boundary];
                let step = near.arc_length - at;
                gone[boundary] += step - length * (step / length).round();
            }
            if gone.iter().zip(&lengths).any(|(gone, length)| gone.abs() >= LAP * length) {
                found.lap = true;
                break;
            }
        } else {
            last = None;
        }
    }
    found.kept = kept as f64 / rows.max(1) as f64;
    found.way /= longest;
    println!(
        "{seed} {}, {}, sideways={}: lap {} way {:.2} kept {:.2} hardest {:.2}{}{}",
        KINDS[world.kind],
        ROBOTS[world.whiskers - 1],
        world.options.sideways,
        found.lap,
        found.way,
        found.kept,
        found.hardest,
        if found.collided { " COLLIDED" } else { "" },
        if found.blocked { " BLOCKED" } else { "" },
    );
    Ok(found)
}

/// Whether footprint or a whisker's base comes to a boundary.
fn collides(map: &Map, robot: &Robot, from: Pose2, to: Pose2, footprint: f64) -> bool {
    let base = |p: Pose2, w: &MountedWhisker| p.compose(w.robot_from_whisker).position();
    let hits = |a: Vec2, b: Vec2| !map.is_free(b) || (a.distance(b) > 0.0 && map.crosses(a, b));
    map.nearest_within(to.position(), footprint).is_some()
        || hits(from.position(), to.position())
        || robot.whiskers.iter().any(|w| hits(base(from, w), base(to, w)))
}

/// Counts of all robots; fails where one with several whiskers collides or a whisker is bent too far.
pub(crate) fn report(all: &[Followed]) -> ExitCode {
    println!("| rooms | robots | runs | laps | blocked | collided | within the band | largest moment |");
    println!("| --- | --- | --- | --- | --- | --- | --- | --- |");
    for (kind, name) in KINDS.iter().enumerate() {
        row(name, "all", all, &|one| one.kind == kind);
    }
    for (k, name) in ROBOTS.iter().enumerate() {
        row("all", name, all, &|one| one.whiskers == k + 1);
    }
    row("all", "differential drive", all, &|one| !one.sideways);
    row("all", "omnidirectional", all, &|one| one.sideways);
    row("all", "all", all, &|_| true);
    let bad = all.iter().any(|one| one.hardest > 1.0 || (one.whiskers > 1 && one.collided));
    if bad { ExitCode::FAILURE } else { ExitCode::SUCCESS }
}

fn row(rooms: &str, robots: &str, all: &[Followed], of: &dyn Fn(&Followed) -> bool) {
    let some: Vec<&Followed> = all.iter().filter(|one| of(one)).collect();
    let count = |of: fn(&Followed) -> bool| some.iter().filter(|one| of(one)).count();
    let kept = some.iter().map(|one| one.kept).sum::<f64>() / some.len().max(1) as f64;
    let hardest = some.iter().map(|one| one.hardest).fold(0.0, f64::max);
    println!(
        "| {rooms} | {robots} | {} | {} | {} | {} | {:.0} % | {hardest:.2} |",
        some.len(),
        count(|one| one.lap),
        count(|one| one.blocked),
        count(|one| one.collided),
        100.0 * kept,
    );
}
