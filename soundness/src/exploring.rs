//! Robots that find out where they are by their own motion, from the same starts: planned, planned in hindsight, random, straight on, and
//! along the wall by touch.

use crate::corners;
use crate::random_sweep::random::Random;
use core::f64::consts::PI;
use std::process::ExitCode;
use std::time::Instant;
use vibrissa::Method;
use vibrissa::plane::{Curve, Pose2, Vec2, wrap_angle};
use vibrissa::sim::{Pace, SimulateOptions, Stage, SweepNoise};
use vibrissa::tasks::explore::{Ended, Exploration, ExploreOptions, Strategy, explore_by};
use vibrissa::tasks::plan::{Motion, PlanOptions};
use vibrissa::world::{Boundary, Map, MountedWhisker, Robot, Role};

/// A localized pose further off than this is wrong (m).
const WRONG: f64 = 0.02;
/// Links of the simulator's discrete rod.
const LINKS: usize = 90;
/// Kinds of rooms.
pub(crate) const KINDS: [&str; 4] = ["right-angled", "rough", "cluttered", "symmetric"];
/// Ways to choose motions.
pub(crate) const POLICIES: [&str; 6] =
    ["planned", "hindsight", "random", "straight on", "wall following", "planned, walls by touch"];
/// Ways to give up after (m).
const MOST_WAY: f64 = 1.5;

/// Rows 4 mm apart: a localization for each motion is what the time goes into.
const PACE: Pace = Pace { speed: 0.1, turn_rate: 1.0, rate: 25.0 };
/// Motions between whole answers of the baselines.
const QUICK: usize = 4;
/// Motions to give up after.
const MOST_MOTIONS: usize = 40;

/// A room, a robot in it, and its first motion.
struct World {
    kind: usize,
    stage: Stage,
    begin: [Pose2; 2],
    options: ExploreOptions,
}

/// What became of a robot.
#[derive(Clone, Debug)]
pub(crate) struct Run {
    ended: Ended,
    way: f64,
    turn: f64,
    motions: usize,
    wrong: bool,
    collided: bool,
    hardest: f64,
    seconds: f64,
}

/// All policies in one world.
#[derive(Clone, Debug)]
pub(crate) struct Compared {
    seed: u64,
    kind: usize,
    sideways: bool,
    runs: Vec<Run>,
}

/// The world of a seed by all policies, if the first motion leaves places open.
pub(crate) fn compare(seed: u64, verbose: bool, policies: usize) -> Option<(u64, Compared)> {
    let world = (0..40).find_map(|k| world(seed, k))?;
    let mut runs = Vec::new();
    for policy in POLICIES.into_iter().take(policies) {
        let began = Instant::now();
        let found = match run(&world, policy, seed) {
            Ok(found) => found,
            Err(error) => {
                println!("seed {seed}, {policy}: {error}");
                return None;
            }
        };
        if matches!(found.ended, Ended::NoPlace) || (found.motions.is_empty() && found.ended != Ended::Symmetric) {
            // Known, lost or without a place before any motion: nothing to compare.
            return None;
        }
        let truth = found.truth.last()?.map_from_robot;
        let off = found.answer.estimate.map(|pose| pose.position().distance(truth.position()));
        let one = Run {
            ended: found.ended,
            way: found.way,
            turn: found.turn,
            motions: found.motions.len(),
            wrong: found.ended == Ended::Localized && off.is_some_and(|off| off > WRONG),
            collided: found.collided,
            hardest: found.hardest,
            seconds: began.elapsed().as_secs_f64(),
        };
        if verbose {
            tell(&found, &one, policy, &world);
        }
        runs.push(one);
    }
    let sideways = world.options.plan.sideways;
    let ends = |run: &Run| {
        let flag = if run.wrong {
            " WRONG"
        } else if run.collided {
            " COLLIDED"
        } else {
            ""
        };
        let Run { ended, way, turn, motions, hardest, seconds, .. } = run;
        format!("{ended:?} {:.0} mm {turn:.1} rad {motions}x hardest {hardest:.2} {seconds:.1}s{flag}", 1e3 * way)
    };
    let all: Vec<String> = runs.iter().map(ends).collect();
    println!("{seed} {} sideways={sideways}: {}", KINDS[world.kind], all.join(" | "));
    Some((seed, Compared { seed, kind: world.kind, sideways, runs }))
}

fn tell(found: &Exploration, one: &Run, policy: &str, world: &World) {
    let (map, footprint) = (world.stage.map(), world.options.plan.footprint);
    let inside = |p: Vec2, least: f64| !map.is_free(p) || map.nearest_within(p, least).is_some();
    let hit = found.truth.iter().position(|row| {
        let base = row.map_from_robot.compose(world.stage.robot().whiskers[0].robot_from_whisker).position();
        inside(row.map_from_robot.position(), footprint) || inside(base, 0.0)
    });
    println!("--- {policy}: {one:?}; collided at row {hit:?}");
    for made in &found.motions {
        let truth = found.truth.get(made.row).map(|pose| pose.map_from_robot);
        let words = made.plan.as_ref().map(|plan| {
            format!("{} | {:?} looked {:?} readings {}", plan.words(), plan.verdict, plan.looked_at, plan.readings)
        });
        let off = |place: &(Pose2, f64)| truth.map_or(f64::NAN, |truth| place.0.position().distance(truth.position()));
        let nearest = made.places.iter().min_by(|a, b| off(a).total_cmp(&off(b)));
        let nearest =
            nearest.map_or(String::new(), |place| format!("{:.1} mm off, weight {:.1e}", 1e3 * off(place), place.1));
        println!(
            "row {} places {} ({nearest}) stopped {} truth {truth:.3?} {}: {}",
            made.row,
            made.places.len(),
            made.stopped,
            made.name,
            words.unwrap_or_default()
        );
    }
    for event in &found.events {
        println!("   {:.2} {} {}", event.t, event.kind, event.detail);
    }
    println!("   {:?} {:?}", found.answer.status, found.answer.events.last());
}

fn run(world: &World, policy: &str, seed: u64) -> vibrissa::Result<Exploration> {
    let noise = SweepNoise::seeded(seed);
    let (stage, begin, method) = (&world.stage, &world.begin, Method::default());
    // Whole answers are slow, and baselines make many motions.
    let answer_each = if policy.starts_with("planned") || policy == "hindsight" { 1 } else { QUICK };
    let options = &ExploreOptions { answer_each, ..world.options };
    let mut draw = Random(seed ^ 0x5eed_0fa9_0011);
    match policy {
        "planned" => explore_by(stage, begin, &method, &noise, options, Strategy::Planned),
        "planned, walls by touch" => {
            let options = &ExploreOptions { by_touch: true, ..*options };
            explore_by(stage, begin, &method, &noise, options, Strategy::Planned)
        }
        "hindsight" => explore_by(stage, begin, &method, &noise, options, Strategy::Hindsight),
        "wall following" => explore_by(stage, begin, &method, &noise, options, Strategy::Following(options.follow())),
        "random" => {
            let mut choose = |all: &[Motion], _: f64| {
                let one = &all[((draw.unit() * all.len() as f64) as usize).min(all.len() - 1)];
                Some(one.share(draw.between(0.4, 1.0)))
            };
            explore_by(stage, begin, &method, &noise, options, Strategy::Chosen(&mut choose))
        }
        _ => {
            let mut choose = |all: &[Motion], ahead: f64| {
                let off = |motion: &Motion| {
                    let end = motion.end();
                    let goes = end.position().norm() >= 0.02;
                    if goes { wrap_angle(end.position().angle() - ahead).abs() } else { 10.0 - end.theta.abs() }
                };
                all.iter().min_by(|a, b| off(a).total_cmp(&off(b))).cloned()
            };
            explore_by(stage, begin, &method, &noise, options, Strategy::Chosen(&mut choose))
        }
    }
}

/// A world, if the robot can begin there.
fn world(seed: u64, trial: u64) -> Option<World> {
    let mut draw = Random(seed.wrapping_mul(0x9e6c_63d0_876a_46ad) ^ 0x00ac_717e);
    let kind = (seed % 4) as usize;
    let map = room(kind, &mut draw)?;
    let mut whisker = MountedWhisker::default();
    whisker.beam.length = draw.between(0.06, 0.09);
    let sideways = (seed / 4).is_multiple_of(2);
    let side = draw.sign();
    // The whisker points ahead to one side.
    whisker.robot_from_whisker =
        Pose2::new(draw.between(0.0, 0.012), side * draw.between(0.0, 0.012), side * draw.between(0.5, 1.1));
    let robot = Robot { whiskers: vec![whisker], ..Robot::default() };
    let plan = PlanOptions { sideways, footprint: 0.015, ..PlanOptions::default() };
    let options = ExploreOptions {
        plan,
        most_way: MOST_WAY,
        most_motions: MOST_MOTIONS,
        pace: PACE,
        ..ExploreOptions::default()
    };
    // Another place on the wall for each trial.
    let mut draw = Random(draw.0 ^ trial.wrapping_mul(0xd1b5_4a32_d192_ed03));
    let begin = begin(&map, &robot, side, plan.footprint, &mut draw)?;
    let simulate = SimulateOptions { links: LINKS, ..SimulateOptions::default() };
    Some(World { kind, stage: Stage::new(map, robot, simulate).ok()?, begin, options })
}

/// A straight way onto the wall, whisker ahead: free where it begins.
fn begin(map: &Map, robot: &Robot, side: f64, footprint: f64, draw: &mut Random) -> Option<[Pose2; 2]> {
    let whisker = &robot.whiskers[0];
    let samples = map.samples(2e-3);
    let on = samples[((draw.unit() * samples.len() as f64) as usize).min(samples.len() - 1)];
    let inward = Vec2::from_angle(on.tangent).perp();
    // The wall lies on the whisker's side of the way.
    let way = if side < 0.0 { on.tangent } else { on.tangent + PI };
    let tip = whisker.robot_from_whisker.transform_point(Vec2::new(whisker.beam.length, 0.0));
    let reach = -tip.rotated(way).dot(inward);
    let length = draw.between(0.06, 0.09);
    let press = draw.between(0.06, 0.14) * whisker.beam.length;
    let place = |s: f64, off: f64| {
        let p = on.position + Vec2::from_angle(way) * s + inward * (reach + off);
        Pose2::new(p.x, p.y, way)
    };
    let pair = [place(0.0, 3e-3), place(length, -press)];
    let clear = |k: i32| {
        let p = pair[0].position() + (pair[1].position() - pair[0].position()) * (f64::from(k) / 10.0);
        let base = Pose2::new(p.x, p.y, way).compose(whisker.robot_from_whisker).position();
        map.is_free(p)
            && map.is_free(base)
            && map.nearest_within(p, footprint + 0.01).is_none()
            && map.nearest_within(base, 5e-3).is_none()
    };
    let base = pair[0].compose(whisker.robot_from_whisker);
    let free = |k: i32| {
        let p = base.transform_point(Vec2::new(whisker.beam.length * f64::from(k) / 20.0, 0.0));
        map.is_free(p) && map.nearest_within(p, 1e-3).is_none()
    };
    ((0..=10).all(clear) && (0..=20).all(free)).then_some(pair)
}

pub(crate) fn room(kind: usize, draw: &mut Random) -> Option<Map> {
    match kind {
        0 => {
            // A plain rectangle is symmetric.
            let room = (0..50).map(|_| corners::room(draw)).find(|room| room[0].len() > 4)?;
            corners::map_of(&room, 1.0)
        }
        1 => rough(draw, 0.0, 0),
        2 => rough(draw, 0.6, 3),
        _ => symmetric(draw),
    }
}

fn polygon(role: Role, points: &[Vec2]) -> Option<Boundary> {
    Boundary::new(role, Curve::polyline(points, true)?, None).ok()
}

/// A room of many corners, whose walls are bumpy, with things in it.
fn rough(draw: &mut Random, even: f64, things: usize) -> Option<Map> {
    let corners = 5 + (draw.unit() * 4.0) as usize;
    let radius = draw.between(0.22, 0.36);
    let shift = draw.signed(PI);
    let points: Vec<Vec2> = (0..corners)
        .map(|k| {
            let angle = shift + (k as f64 + 0.6 * draw.signed(0.5)) / corners as f64 * 2.0 * PI;
            Vec2::from_angle(angle) * (radius * draw.between(0.75, 1.2))
        })
        .collect();
    let bump = (1.0 - even) * draw.between(1e-3, 4e-3);
    let mut outline = Vec::new();
    for k in 0..corners {
        let (a, b) = (points[k], points[(k + 1) % corners]);
        let count = ((a.distance(b) / 0.03).ceil() as usize).max(1);
        for j in 0..count {
            let off = if j == 0 { 0.0 } else { draw.signed(bump) };
            outline.push(a + (b - a) * (j as f64 / count as f64) + (b - a).perp() * (off / a.distance(b)));
        }
    }
    let mut boundaries = vec![polygon(Role::Arena, &outline)?];
    for _ in 0..things {
        let (middle, turn, size) =
            (Vec2::from_angle(draw.signed(PI)) * draw.between(0.0, 0.1), draw.signed(PI), draw.between(0.01, 0.03));
        let n = 3 + (draw.unit() * 3.0) as usize;
        let thing: Vec<Vec2> =
            (0..n).map(|k| middle + Vec2::from_angle(turn + k as f64 / n as f64 * 2.0 * PI) * size).collect();
        boundaries.push(polygon(Role::Obstacle, &thing)?);
    }
    Map::new(boundaries).ok()
}

/// A rectangle, a square, a regular hexagon, or a room with a bay on opposite sides.
fn symmetric(draw: &mut Random) -> Option<Map> {
    let (w, h) = (draw.between(0.2, 0.5), draw.between(0.2, 0.5));
    let turn = draw.signed(PI);
    let points: Vec<Vec2> = match (draw.unit() * 4.0) as usize {
        0 => [(0.0, 0.0), (w, 0.0), (w, h), (0.0, h)].map(|(x, y)| Vec2::new(x, y)).to_vec(),
        1 => [(0.0, 0.0), (w, 0.0), (w, w), (0.0, w)].map(|(x, y)| Vec2::new(x, y)).to_vec(),
        2 => (0..6).map(|k| Vec2::from_angle(f64::from(k) * PI / 3.0) * (0.6 * w)).collect(),
        _ => {
            let (a, b, d) = (0.25 * w, 0.6 * w, draw.between(0.02, 0.06));
            [
                (0.0, 0.0),
                (a, 0.0),
                (a, -d),
                (b, -d),
                (b, 0.0),
                (w, 0.0),
                (w, h),
                (w - a, h),
                (w - a, h + d),
                (w - b, h + d),
                (w - b, h),
                (0.0, h),
            ]
            .map(|(x, y)| Vec2::new(x, y))
            .to_vec()
        }
    };
    let points: Vec<Vec2> = points.into_iter().map(|p| p.rotated(turn)).collect();
    Map::new(vec![polygon(Role::Arena, &points)?]).ok()
}

/// Counts and ways of all worlds; fails where a robot is wrong, lost or collides, or where planned motions are not shorter.
pub(crate) fn report(all: &[Compared]) -> ExitCode {
    println!(
        "| rooms | motions | worlds | localized | symmetric | gave up | inconsistent | confined | wrong | collided | way, median | way, mean | motions, mean |"
    );
    println!("| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |");
    for (kind, name) in KINDS.iter().enumerate() {
        table(name, all, &|one| one.kind == kind);
    }
    table("all but symmetric, any direction", all, &|one| one.kind != 3 && one.sideways);
    table("all but symmetric, ahead only", all, &|one| one.kind != 3 && !one.sideways);
    let means = table("all but symmetric", all, &|one| one.kind != 3);
    let of = |policy: &str| POLICIES.iter().position(|p| *p == policy).and_then(|k| means.get(k)).copied();
    let share = of("random").map_or(0.0, |random| means[0] / random);
    if let (Some(random), Some(hindsight)) = (of("random"), of("hindsight")) {
        println!(
            "of the gap between random and hindsight: {:.0} %",
            100.0 * (random - means[0]) / (random - hindsight)
        );
    }
    let bad =
        all.iter().any(|one| one.runs[0].wrong || one.runs[0].collided || one.runs[0].ended == Ended::Inconsistent);
    println!("planned over random: {:.0} % of the way", 100.0 * share);
    let seconds: f64 = all.iter().flat_map(|one| one.runs.iter().map(|run| run.seconds)).sum();
    let last = all.iter().map(|one| one.seed).max().unwrap_or_default();
    println!("last seed {last}; {seconds:.0} s of one thread");
    if bad || share > 0.6 { ExitCode::FAILURE } else { ExitCode::SUCCESS }
}

/// Rows of one kind of rooms; the mean ways. A run that plans, in hindsight or not, and gives up counts as the longest way, any other as the way that it went, which is less than it would have needed.
fn table(name: &str, all: &[Compared], of: &dyn Fn(&Compared) -> bool) -> Vec<f64> {
    let some: Vec<&Compared> = all.iter().filter(|one| of(one)).collect();
    let mut means = Vec::new();
    for (index, policy) in POLICIES.iter().enumerate() {
        let runs: Vec<&Run> = some.iter().filter_map(|one| one.runs.get(index)).collect();
        if runs.is_empty() {
            continue;
        }
        let count = |ended: Ended| runs.iter().filter(|run| run.ended == ended).count();
        let is_short = |run: &Run| run.ended != Ended::Localized && (index < 2 || index == 5);
        let way = |run: &&Run| if is_short(run) { MOST_WAY } else { run.way };
        let mut ways: Vec<f64> = runs.iter().map(way).collect();
        ways.sort_by(f64::total_cmp);
        let mean = ways.iter().sum::<f64>() / ways.len().max(1) as f64;
        means.push(mean);
        println!(
            "| {name} | {policy} | {} | {} | {} | {} | {} | {} | {} | {} | {:.0} mm | {:.0} mm | {:.1} rad | {:.1} |",
            runs.len(),
            count(Ended::Localized),
            count(Ended::Symmetric),
            count(Ended::GaveUp),
            count(Ended::Inconsistent),
            count(Ended::Confined),
            runs.iter().filter(|run| run.wrong).count(),
            runs.iter().filter(|run| run.collided).count(),
            1e3 * ways.get(ways.len() / 2).copied().unwrap_or(f64::NAN),
            1e3 * mean,
            runs.iter().map(|run| run.turn).sum::<f64>() / runs.len().max(1) as f64,
            runs.iter().map(|run| run.motions).sum::<usize>() as f64 / runs.len().max(1) as f64,
        );
    }
    let worst = some.iter().map(|one| one.runs[0].hardest).fold(0.0, f64::max);
    println!("| {name} | largest moment over what is gentle: {worst:.2} |");
    means
}
