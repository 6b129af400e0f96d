//! The motions that are looked at, those along walls first.

use super::{Motion, PlanOptions, RemainingState};
use crate::plane::{Pose2, Vec2, wrap_angle};
use crate::world::{Map, Robot};
use core::f64::consts::{FRAC_PI_2, PI};

/// How much the way bends towards the wall and off it (rad).
const PRESS: f64 = 0.12;
/// How far the whisker leans back from the wall's normal against the way, or ahead where it leads (rad).
const LEAN: f64 = 0.7;
/// How far a whisker is pressed that is put down again (share of its length).
const PRESSED: f64 = 0.12;
/// How far it is lifted off (share of its length).
const LIFT: f64 = 0.3;
/// Curvatures of arcs (1/m), and turns (rad).
const CURVATURES: [f64; 4] = [3.0, -3.0, 8.0, -8.0];
const TURNS: [f64; 8] = [0.6, -0.6, 1.2, -1.2, FRAC_PI_2, -FRAC_PI_2, 2.4, -2.4];
/// Walls that are seen in directions no further apart (rad) are one.
const SAME: f64 = 0.15;
/// Most directions of walls.
const WALLS: usize = 3;

/// All motions.
pub(super) fn all(map: &Map, robot: &Robot, states: &[RemainingState], options: &PlanOptions) -> Vec<Motion> {
    let longest = options.longest;
    let mut motions = Vec::new();
    let walls = walls(map, states);
    for wall in &walls {
        for way in [wall.along, wall.along + PI] {
            if options.sideways {
                motions.push(Motion::leg("along the wall", Vec2::from_angle(way) * longest));
            } else if options.turns {
                motions.push(Motion::arc("along the wall", wrap_angle(way), longest, 0.0));
            }
        }
    }
    if options.sideways && options.turns {
        for wall in &walls {
            motions.extend([1.0, -1.0].into_iter().flat_map(|sign| put_down(robot, wall, sign, longest)));
        }
    }
    for wall in &walls {
        for way in [wall.along, wall.along + PI] {
            for press in [PRESS, -PRESS] {
                if options.sideways {
                    motions.push(Motion::leg("along the wall", Vec2::from_angle(way + press) * longest));
                } else if options.turns {
                    motions.push(Motion::arc("along the wall", wrap_angle(way + press), longest, 0.0));
                }
            }
        }
    }
    motions.push(Motion::arc("straight ahead", 0.0, longest, 0.0));
    motions.push(Motion::arc("straight back", 0.0, -longest, 0.0));
    if options.sideways {
        motions.extend((1..8).map(|k| Motion::leg("across", Vec2::from_angle(f64::from(k) * PI / 4.0) * longest)));
    }
    if options.turns {
        motions.extend(TURNS.map(|by| Motion::turned("a turn on the spot", by)));
        if !options.sideways {
            motions.extend(TURNS.map(|by| Motion::arc("a turn and straight on", by, longest, 0.0)));
        }
    }
    motions.extend(CURVATURES.map(|curvature| Motion::arc("an arc", 0.0, longest, curvature)));
    motions.extend(CURVATURES.map(|curvature| Motion::arc("an arc back", 0.0, -longest, curvature)));
    motions
}

/// A wall as the robot has it beside it.
struct Wall {
    /// Its direction in the robot's frame (rad), free space on its left.
    along: f64,
    /// How far it is (m).
    off: f64,
}

/// The walls nearest to the likeliest states, each direction once.
fn walls(map: &Map, states: &[RemainingState]) -> Vec<Wall> {
    let mut order: Vec<&RemainingState> = states.iter().collect();
    order.sort_by(|a, b| b.weight.total_cmp(&a.weight));
    let mut walls: Vec<Wall> = Vec::new();
    for state in order {
        if walls.len() >= WALLS {
            break;
        }
        let Some(near) = map.nearest(state.pose.position()) else { continue };
        // The foot's normal tells the side, for walls that are free on both.
        let inward = state.pose.position() - near.position;
        let along = wrap_angle(inward.angle() - FRAC_PI_2 - state.pose.theta);
        if walls.iter().all(|wall| wrap_angle(wall.along - along).abs() > SAME) {
            walls.push(Wall { along, off: near.distance });
        }
    }
    walls
}

/// Off the wall, turned so that the first whisker leads or trails on the way, down again and along.
fn put_down(robot: &Robot, wall: &Wall, sign: f64, longest: f64) -> Vec<Motion> {
    let Some(whisker) = robot.whiskers.first() else { return Vec::new() };
    let (inward, length) = (Vec2::from_angle(wall.along + FRAC_PI_2), whisker.beam.length);
    let way = Vec2::from_angle(wall.along) * sign;
    [1.0, -1.0]
        .map(|leads: f64| {
            // The whisker points at the wall, and so far ahead of that.
            let points = wall.along - FRAC_PI_2 + leads * sign * LEAN;
            let turn = wrap_angle(points - whisker.robot_from_whisker.theta);
            // Where the robot's origin is off the wall then.
            let mount = whisker.robot_from_whisker.position().rotated(turn);
            let tip = mount + Vec2::from_angle(points) * length;
            let reach = -tip.dot(inward);
            let down = reach - PRESSED * length - wall.off;
            let up = (reach - wall.off).max(0.0) + LIFT * length;
            let off = inward * up;
            let half = Pose2::new(off.x, off.y, 0.5 * turn);
            let turned = Pose2::new(off.x, off.y, turn);
            let on = inward * down + way * (up - down);
            let end = on + way * longest;
            let name = if leads > 0.0 { "along the wall, whisker ahead" } else { "along the wall, whisker behind" };
            Motion::new(
                name,
                &[
                    Pose2::new(off.x, off.y, 0.0),
                    half,
                    turned,
                    Pose2::new(on.x, on.y, turn),
                    Pose2::new(end.x, end.y, turn),
                ],
            )
        })
        .into()
}
