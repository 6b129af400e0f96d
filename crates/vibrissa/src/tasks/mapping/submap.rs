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
    // Bounds are relative to what the odometry says or to the truth: the larger of both.
    let [per_way, per_turn] =
        [robot.odometry.translation_relative, robot.odometry.rotation_relative].map(|share| share / (1.0 - share));
    let (mut place, mut turn) = (0.0, 0.0_f64);
    for key in &front.keys[from + 1..=to] {
        turn += per_turn * key.leg.turned + drift * key.leg.way;
        place += per_way * key.leg.way + turn.min(PI) * key.leg.way * (1.0 + per_way);
    }
    (place, turn.min(PI))
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
        // What was felt after a key pose belongs to it, up to the next.
        let (lo, hi) = (key.min(middle), (key + 1).min(keys.len() - 1).max(middle));
        let (place, turn) = bounds_between(front, robot, options.drift, (lo, hi));
        let here = keys[middle].odom_from_key.between(keys[key].odom_from_key);
        let off = |local: Vec2| place + turn * local.norm();
        add_contacts(front, (key, here), options, &off, &mut contacts);
        for local in &keys[key].passed {
            places.push((here.transform_point(*local), off(*local) + options.least_bound));
        }
    }
    for_each_stand(front, (first, last), options.contact_spacing, |key, local| {
        let (lo, hi) = (key.min(middle), (key + 1).min(keys.len() - 1).max(middle));
        let (place, turn) = bounds_between(front, robot, options.drift, (lo, hi));
        let here = keys[middle].odom_from_key.between(keys[key].odom_from_key);
        middles.push((here.transform_point(local), place + turn * local.norm()));
    });
    if contacts.len() < options.submap_contacts {
        return None;
    }
    Some(Submap { contacts, space: FreeSpace::new(&places, (&middles, options.body_radius), options.cell) })
}

/// The robot's origin at places that are so far apart (m), in the frame of the key pose before.
fn for_each_stand(front: &FrontEnd, (first, last): (usize, usize), spacing: f64, mut visit: impl FnMut(usize, Vec2)) {
    for key in first..=last {
        let mut before: Option<Vec2> = None;
        for &stand in &front.keys[key].stands {
            if before.is_none_or(|before| before.distance(stand) >= spacing) {
                before = Some(stand);
                visit(key, stand);
            }
        }
    }
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
