//! What was felt and passed around a key pose, with bounds on every error \[jaulin2009robust\].

use super::closure::{PoseBounds, Submap};
use super::free_space::{FreeSpace, PassedSpace};
use super::front_end::{FrontEnd, Key};
use super::passed_cells::PassedCells;
use crate::config::MappingOptions;
use crate::plane::{Pose2, Vec2};
use crate::world::Robot;
use core::f64::consts::PI;

/// Odometry between two key poses, with bounds: how far place (m) and heading (rad) may be off.
pub(super) fn way_bounds(front: &FrontEnd, robot: &Robot, drift: f64, (from, to): (usize, usize)) -> PoseBounds {
    let (place, turn) = bounds_between(front, robot, drift, (from, to));
    let middle = front.keys[from].odom_from_key.between(front.keys[to].odom_from_key);
    PoseBounds { middle, half: [place, place, turn] }
}

/// Sums of the bounds of all steps, seen from the first key pose, forth or back: a heading that is off by then carries the rest of the way
/// along.
fn bounds_between(front: &FrontEnd, robot: &Robot, drift: f64, (from, to): (usize, usize)) -> (f64, f64) {
    let leg = |key: &Key| (key.leg.way, key.leg.turned);
    if from <= to {
        bounds_along(front.keys[from + 1..=to].iter().map(leg), robot, drift)
    } else {
        bounds_along(front.keys[to + 1..=from].iter().rev().map(leg), robot, drift)
    }
}

/// The same of legs by their ways (m) and turns (rad).
fn bounds_along(legs: impl Iterator<Item = (f64, f64)>, robot: &Robot, drift: f64) -> (f64, f64) {
    // Bounds are relative to what the odometry says or to the truth: the larger of both.
    let [per_way, per_turn] =
        [robot.odometry.translation_relative, robot.odometry.rotation_relative].map(|share| share / (1.0 - share));
    let (mut place, mut turn) = (0.0, 0.0_f64);
    for (way, turned) in legs {
        // The way that was gone may be longer than what is told.
        let longest = way * (1.0 + per_way);
        turn += per_turn * turned + drift * longest;
        place += per_way * way + turn.min(PI) * longest;
    }
    (place, turn.min(PI))
}

/// How far place (m) and heading (rad) of what was felt after a key pose may be off, seen from the middle one.
fn open_of(front: &FrontEnd, robot: &Robot, options: &MappingOptions, (middle, key): (usize, usize)) -> (f64, f64) {
    if key < middle {
        return bounds_between(front, robot, options.drift, (middle, key));
    }
    // What was felt after a key pose belongs to it, up to the next; at the end of a log that is not there yet.
    let next = front.keys.get(key + 1).filter(|next| next.visit == front.keys[key].visit);
    let after = next.map_or((options.key_spacing, options.key_turn), |next| (next.leg.way, next.leg.turned));
    let legs = front.keys[middle + 1..=key].iter().map(|key| (key.leg.way, key.leg.turned));
    bounds_along(legs.chain([after]), robot, options.drift)
}

/// The submap of the way before and after a key pose (m); none with too few contacts.
pub(super) fn submap(
    front: &FrontEnd,
    robot: &Robot,
    options: &MappingOptions,
    (middle, reach): (usize, f64),
) -> Option<Submap> {
    let (first, last) = front.within(middle, reach);
    let here = |key: usize| front.keys[middle].odom_from_key.between(front.keys[key].odom_from_key);
    let open = |key: usize| open_of(front, robot, options, (middle, key));
    let mut contacts = Vec::new();
    for key in first..=last {
        let (place, turn) = open(key);
        add_contacts(front, (key, here(key)), options, &|local| place + turn * local.norm(), &mut contacts);
    }
    if contacts.len() < options.submap_contacts {
        return None;
    }
    let passed = passed_space(front, first..last + 1, options, &|key, local| {
        let (place, turn) = open(key);
        (here(key).transform_point(local), place + turn * local.norm())
    });
    Some(Submap { contacts, passed })
}

/// The space that whiskers and robot passed over some key poses; `place` puts a place of a key pose into the frame, with its bound (m).
///
/// Parts of the way that come back beside others may have a wall between them that is thinner than what they may be off, so that only
/// what was passed in one go, without turning back, is one piece.
pub(super) fn passed_space(
    front: &FrontEnd,
    keys: core::ops::Range<usize>,
    options: &MappingOptions,
    place: &dyn Fn(usize, Vec2) -> (Vec2, f64),
) -> PassedSpace {
    let (mut pieces, mut first) = (Vec::new(), keys.start);
    while first < keys.end {
        let (mut last, mut way, mut turned, mut next) = (first, 0.0, 0.0, first + 1);
        while last + 1 < keys.end {
            let leg = &front.keys[last + 1].leg;
            (way, turned) = (way + leg.way, turned + leg.turned);
            if way > options.submap || turned > ONE_GO {
                break;
            }
            last += 1;
            // Half of a piece lies in the next one, too.
            if 2.0 * way <= options.submap && 2.0 * turned <= ONE_GO {
                next = last + 1;
            }
        }
        pieces.push(piece(front, first..=last, options, place));
        if last + 1 == keys.end {
            break;
        }
        first = next;
    }
    PassedSpace(pieces)
}

/// Most that a robot turns in a piece of its way (rad): around the end of a wall it would turn by half a round.
const ONE_GO: f64 = 2.0;

fn piece(
    front: &FrontEnd,
    keys: core::ops::RangeInclusive<usize>,
    options: &MappingOptions,
    place: &dyn Fn(usize, Vec2) -> (Vec2, f64),
) -> FreeSpace {
    let (mut places, mut middles) = (Vec::new(), Vec::new());
    for key in keys {
        let by_whiskers = front.keys[key].passed.middles(options.cell).map(|local| place(key, local));
        let least = options.least_bound + PassedCells::off(options.cell);
        places.extend(by_whiskers.map(|(place, off)| (place, off + least)));
        middles.extend(front.keys[key].stands.iter().map(|local| place(key, *local)));
    }
    FreeSpace::new(&places, (&middles, options.body_radius), options.cell)
}

/// The contacts of a key pose, thinned, with their bounds.
fn add_contacts(
    front: &FrontEnd,
    (key, here): (usize, Pose2),
    options: &MappingOptions,
    off: &dyn Fn(Vec2) -> f64,
    contacts: &mut Vec<(Vec2, f64)>,
) {
    for stretch in front.stretches.iter().filter(|stretch| stretch.key == key) {
        let mut last: Option<Vec2> = None;
        for point in &stretch.points {
            if last.is_some_and(|last| last.distance(point.position) < options.contact_spacing) {
                continue;
            }
            last = Some(point.position);
            let bound = (options.stds_in_bound * point.std).max(options.least_bound);
            contacts.push((here.transform_point(point.position), bound + off(point.position)));
        }
    }
}
