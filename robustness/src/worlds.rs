//! Rooms, motions in them, and the sweeps without any error that come of both.

use crate::random::Random;
use crate::random_arena;
use vibrissa::Result;
use vibrissa::io::map::from_svg;
use vibrissa::plane::{Curve, Pose2, Vec2};
use vibrissa::sim::{Pace, Sweep, SweepNoise, path_through, simulate_tip_sweep};
use vibrissa::world::{Boundary, Map, MapPoint, Robot, Role};

/// What is drawn from a seed.
pub(crate) struct World {
    pub(crate) room: &'static str,
    pub(crate) motion: &'static str,
    pub(crate) map: Map,
    /// The robot as it is.
    pub(crate) robot: Robot,
    /// The sweep without any error.
    pub(crate) sweep: Sweep,
}

/// Kinds of rooms and of motions; seeds go through all pairs in turn, by `TURNS` through the rooms.
pub(crate) const ROOMS: [&str; 4] = ["wavy", "right-angled", "shipped", "long walls"];
pub(crate) const MOTIONS: [&str; 4] = ["drag", "arc", "press", "along"];

const TURNS: [usize; 6] = [0, 1, 2, 0, 2, 3];

const SHIPPED: [(&str, &str); 6] = [
    ("paper_arena", include_str!("../../scenarios/maps/paper_arena.svg")),
    ("room", include_str!("../../scenarios/maps/room.svg")),
    ("corridor", include_str!("../../scenarios/maps/corridor.svg")),
    ("pipe", include_str!("../../scenarios/maps/pipe.svg")),
    ("canal", include_str!("../../scenarios/maps/canal.svg")),
    ("obstacle", include_str!("../../scenarios/maps/obstacle.svg")),
];

/// The whisker's length (m).
const LENGTH: f64 = 0.075;
/// Robots go no nearer to a wall than this (m).
const NEAREST: f64 = 0.015;
/// Fewest rows in contact, and most rows.
const FEWEST: usize = 120;
const MOST: usize = 1200;
/// No contact is nearer to the base than this (m).
const NEAREST_CONTACT: f64 = 0.05 * LENGTH;
/// How often a motion is drawn anew.
const ATTEMPTS: usize = 60;
const PACE: Pace = Pace { speed: 0.15, turn_rate: 1.0, rate: 300.0 };

/// The world of a seed; none where no motion was found that the robot can make.
pub(crate) fn world(seed: u64) -> Option<World> {
    let mut draw = Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15));
    let turn = seed as usize % TURNS.len();
    let kinds = [TURNS[turn], seed as usize / TURNS.len() % MOTIONS.len()];
    let map = room(kinds[0], &mut draw).ok()?;
    let robot = robot(&mut draw);
    let sweep = (0..ATTEMPTS).find_map(|_| sweep(&map, &robot, kinds[1], &mut draw))?;
    Some(World { room: ROOMS[kinds[0]], motion: MOTIONS[kinds[1]], map, robot, sweep })
}

/// A room of this kind.
pub(crate) fn room(kind: usize, draw: &mut Random) -> Result<Map> {
    match kind {
        0 => random_arena::arena(draw),
        1 => right_angled(draw),
        2 => {
            let (name, text) = SHIPPED[draw.between(0.0, SHIPPED.len() as f64) as usize];
            from_svg(text, name)
        }
        _ => long_walls(draw),
    }
}

fn outline(role: Role, corners: &[Vec2]) -> Result<Boundary> {
    let curve = Curve::polyline(corners, true).ok_or_else(|| vibrissa::Error::data("a room without area"))?;
    Boundary::new(role, curve, None)
}

/// A rectangle with niches in its walls, and columns.
fn right_angled(draw: &mut Random) -> Result<Map> {
    let [w, h] = [draw.between(0.5, 0.8), draw.between(0.4, 0.6)];
    let mut corners = Vec::new();
    for (from, to) in [((0.0, 0.0), (w, 0.0)), ((w, 0.0), (w, h)), ((w, h), (0.0, h)), ((0.0, h), (0.0, 0.0))] {
        let (from, to) = (Vec2::new(from.0, from.1), Vec2::new(to.0, to.1));
        let (along, length) = ((to - from) * (1.0 / from.distance(to)), from.distance(to));
        corners.push(from);
        if draw.unit() < 0.7 {
            let (start, wide) = (draw.between(0.15, 0.5) * length, draw.between(0.05, 0.15));
            // Into the wall or out of it.
            let deep = along.perp() * (draw.sign() * draw.between(0.01, 0.03));
            let (a, b) = (from + along * start, from + along * (start + wide));
            corners.extend([a, a + deep, b + deep, b]);
        }
    }
    let mut boundaries = vec![outline(Role::Arena, &corners)?];
    for k in 0..draw.between(1.0, 3.0) as usize {
        let center = Vec2::new((0.33 + 0.34 * k as f64) * w + draw.signed(0.04), 0.5 * h + draw.signed(0.03));
        let [x, y] = [draw.between(0.015, 0.05), draw.between(0.015, 0.05)];
        let sides = [(-x, -y), (x, -y), (x, y), (-x, y)].map(|(x, y)| center + Vec2::new(x, y));
        boundaries.push(outline(Role::Obstacle, &sides)?);
    }
    Map::new(boundaries)
}

/// Straight walls of 0.5 to 1.2 m in the shape of an L, with a post of three corners.
fn long_walls(draw: &mut Random) -> Result<Map> {
    let [x, y, u, v] = [(1.0, 1.4), (1.0, 1.3), (0.5, 0.7), (0.4, 0.6)].map(|(lo, hi)| draw.between(lo, hi));
    let walls = [(0.0, 0.0), (x, 0.0), (x, v), (u, v), (u, y), (0.0, y)].map(|(x, y)| Vec2::new(x, y));
    let at = Vec2::new(draw.between(0.12, 0.25), draw.between(0.12, 0.25));
    let post = [(0.0, 0.0), (0.12, 0.04), (0.07, 0.14)].map(|(x, y)| at + Vec2::new(x, y));
    Map::new(vec![outline(Role::Arena, &walls)?, outline(Role::Obstacle, &post)?])
}

/// The paper's whisker at the robot's origin, or at its edge.
fn robot(draw: &mut Random) -> Robot {
    let mut robot = Robot::default();
    if draw.unit() < 0.5 {
        robot.whiskers[0].robot_from_whisker =
            Pose2::new(draw.between(0.02, 0.06), draw.signed(0.03), draw.sign() * draw.between(0.5, 2.3));
    }
    robot
}

fn sweep(map: &Map, robot: &Robot, motion: usize, draw: &mut Random) -> Option<Sweep> {
    let way = match motion {
        0 => drag(map, draw, 0.0),
        1 => {
            let turn = draw.sign() * draw.between(0.3, 0.9);
            drag(map, draw, turn)
        }
        2 => press(map, draw),
        _ => along(map, draw)?,
    };
    let whisker_from_robot = robot.whiskers[0].robot_from_whisker.inverse();
    let way: Vec<Pose2> = way.into_iter().map(|base| base.compose(whisker_from_robot)).collect();
    let path = path_through(&way, &PACE).ok()?;
    let clear = |base: Vec2| {
        map.is_free(base) && map.nearest_within(base, NEAREST).is_none_or(|p: MapPoint| p.distance > NEAREST)
    };
    let base = |pose: Pose2| pose.compose(robot.whiskers[0].robot_from_whisker).position();
    // A robot whose origin is in a wall is no robot.
    let stands = |pose: Pose2| clear(base(pose)) && map.is_free(pose.position());
    if path.len() > MOST || path.iter().any(|pose| !stands(pose.map_from_robot)) {
        return None;
    }
    let sweep = simulate_tip_sweep(map, robot, &path, &SweepNoise::none()).ok()?;
    let stopped = sweep.events.iter().any(|event| matches!(event.kind, "lost" | "unsolved"));
    let too_near = sweep.contacts.iter().any(|touch| touch.s_a < NEAREST_CONTACT);
    (!stopped && !too_near && sweep.contacts.len() > FEWEST).then_some(sweep)
}

/// A stretch of wall, and how the base of a trailing whisker stands to it.
struct Wall {
    origin: Vec2,
    along: Vec2,
    inward: Vec2,
    forward: f64,
}

impl Wall {
    fn drawn(map: &Map, draw: &mut Random) -> Self {
        let samples = map.samples(1e-3);
        let start = samples[draw.between(0.0, samples.len() as f64) as usize];
        let along = Vec2::from_angle(start.tangent);
        Self { origin: start.position, along, inward: along.perp(), forward: draw.sign() }
    }

    /// The base so far along the wall, with the whisker leaning back by `lean` and pressed in by `press` (m).
    fn base(&self, s: f64, lean: f64, press: f64) -> Pose2 {
        let p = self.origin + self.along * (self.forward * s) + self.inward * (LENGTH * lean.cos() - press);
        Pose2::new(p.x, p.y, (-self.inward).angle() - self.forward * lean)
    }
}

/// From free air to the wall and along it; the robot turns by so much on the way (rad).
fn drag(map: &Map, draw: &mut Random, turn: f64) -> Vec<Pose2> {
    const PIECES: usize = 8;
    let wall = Wall::drawn(map, draw);
    let (lean, length) = (draw.between(0.5, 1.0), draw.between(0.12, 0.26));
    let lean_at = |share: f64| (lean + turn * (share - 0.5)).clamp(0.25, 1.25);
    let mut way = vec![wall.base(0.0, lean_at(0.0), -draw.between(0.012, 0.035)), wall.base(0.0, lean_at(0.0), -0.004)];
    let presses = [draw.between(0.006, 0.02), draw.between(0.006, 0.02), draw.between(0.006, 0.02)];
    for k in 0..=PIECES {
        let share = k as f64 / PIECES as f64;
        // From one pressure to the next in halves.
        let (from, to, part) = if share < 0.5 { (0, 1, 2.0 * share) } else { (1, 2, 2.0 * share - 1.0) };
        let press = presses[from] + (presses[to] - presses[from]) * part;
        way.push(wall.base(0.01 + share * (length - 0.01), lean_at(share), press));
    }
    way
}

/// Pressed and released again and again, with short ways between.
fn press(map: &Map, draw: &mut Random) -> Vec<Pose2> {
    let wall = Wall::drawn(map, draw);
    let lean = draw.between(0.4, 1.0);
    let mut way = vec![wall.base(0.0, lean, -draw.between(0.012, 0.03))];
    let mut s = 0.0;
    for k in 0..draw.between(3.0, 6.0) as usize {
        let lean = lean + if k > 0 { draw.signed(0.15) } else { 0.0 };
        way.push(wall.base(s, lean, -0.004));
        way.push(wall.base(s + 0.004, lean, draw.between(0.006, 0.02)));
        s += draw.between(0.015, 0.045);
        way.push(wall.base(s, lean, draw.between(0.004, 0.02)));
        s += 0.004;
        way.push(wall.base(s, lean, -0.004));
    }
    way
}

/// Along a boundary with its bends and corners.
fn along(map: &Map, draw: &mut Random) -> Option<Vec<Pose2>> {
    const SPACING: f64 = 1e-3;
    const STRIDE: usize = 30;
    let samples = map.samples(SPACING);
    let start = (draw.unit() * samples.len() as f64) as usize;
    let forward = draw.sign();
    let mut way = Vec::new();
    for k in 0..=draw.between(5.0, 11.0) as usize {
        let at = (start as i64 + forward as i64 * (STRIDE * k) as i64).rem_euclid(samples.len() as i64) as usize;
        let here = samples[at];
        if here.boundary != samples[start].boundary {
            return None;
        }
        let tangent = Vec2::from_angle(here.tangent);
        let wall = Wall { origin: here.position, along: tangent, inward: tangent.perp(), forward };
        let (lean, press) = (draw.between(0.4, 1.0), draw.between(0.005, 0.018));
        if k == 0 {
            way.push(wall.base(0.0, lean, -draw.between(0.012, 0.03)));
            way.push(wall.base(0.0, lean, -0.004));
        } else {
            way.push(wall.base(0.0, lean, press));
        }
    }
    Some(way)
}
