//! What was felt and passed around a key pose, with bounds on every error \[jaulin2009robust\].

use super::closure::{PoseBounds, Submap};
use super::free_space::FreeSpace;
use super::front_end::FrontEnd;
use crate::config::MappingOptions;
use crate::plane::{Pose2, Vec2};
use crate::world::Robot;
use core::f64::consts::PI;

/// Odometry between two key poses, with bounds: how far place (m) and heading (rad) may be off.
pub(super) fn way_bounds(front: &FrontEnd, robot: &Robot, drift: f64, (from, to): (usize, usize)) -> PoseBounds {
    let (place, turn) = bounds_between(front, robot, drift, (from.min(to), from.max(to)));
    let middle = front.keys[from].odom_from_key.between(front.keys[to].odom_from_key);
    PoseBounds { middle, half: [place, place, turn] }
}

/// Sums of the bounds of all steps: a heading that is off by then carries the rest of the way along.
fn bounds_between(front: &FrontEnd, robot: &Robot, drift: f64, (from, to): (usize, usize)) -> (f64, f64) {
    let legs = front.keys[from + 1..=to].iter().map(|key| (key.leg.way, key.leg.turned));
    bounds_along(legs, robot, drift)
}

/// The same of legs by their ways (m) and turns (rad).
fn bounds_along(legs: impl Iterator<Item = (f64, f64)>, robot: &Robot, drift: f64) -> (f64, f64) {
    // Bounds are relative to what the odometry says or to the truth: the larger of both.
    let [per_way, per_turn] =
        [robot.odometry.translation_relative, robot.odometry.rotation_relative].map(|share| share / (1.0 - share));
    let (mut place, mut turn) = (0.0, 0.0_f64);
    for (way, turned) in legs {
        turn += per_turn * turned + drift * way;
        place += per_way * way + turn.min(PI) * way * (1.0 + per_way);
    }
    (place, turn.min(PI))
}

/// How far place (m) and heading (rad) of what was felt after a key pose may be off, seen from the middle one.
fn open_of(front: &FrontEnd, robot: &Robot, options: &MappingOptions, (middle, key): (usize, usize)) -> (f64, f64) {
    if key < middle {
        return bounds_between(front, robot, options.drift, (key, middle));
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
    let keys = &front.keys;
    let (first, last) = front.within(middle, reach);
    let (mut contacts, mut places, mut middles) = (Vec::new(), Vec::new(), Vec::new());
    for key in first..=last {
        let (place, turn) = open_of(front, robot, options, (middle, key));
        let here = keys[middle].odom_from_key.between(keys[key].odom_from_key);
        let off = |local: Vec2| place + turn * local.norm();
        add_contacts(front, (key, here), options, &off, &mut contacts);
        for local in &keys[key].passed {
            places.push((here.transform_point(*local), off(*local) + options.least_bound));
        }
        let stands = keys[key].stands_apart(options.contact_spacing);
        middles.extend(stands.map(|local| (here.transform_point(local), off(local))));
    }
    if contacts.len() < options.submap_contacts {
        return None;
    }
    Some(Submap { contacts, space: FreeSpace::new(&places, (&middles, options.body_radius), options.cell) })
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
