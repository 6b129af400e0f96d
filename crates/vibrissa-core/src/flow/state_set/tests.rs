//! The intersection against a brute-force search over the boundary, which lists the preimage point by point.

#[path = "../../../../vibrissa/tests/data/random.rs"]
pub(super) mod random;

use super::candidate::Candidate;
use super::membership::{Tolerance, nearest_state};
use super::{Progress, Start, StateSet};
use crate::WorkBudget;
use crate::beam::TipModel;
use crate::config::{DeterministicOptions, TipLoad};
use crate::flow::moment::{MomentHistory, MomentReading};
use crate::flow::preimage::{AlignedState, Observation, aligned_states};
use crate::plane::{Curve, Pose2, Vec2, wrap_angle};
use crate::world::{Boundary, Map, MountedWhisker, Odometry, Role};
use core::f64::consts::{FRAC_PI_2, PI};
use random::Random;

/// A square room with a round pillar.
fn room() -> Map {
    let square = [(-0.3, -0.3), (0.3, -0.3), (0.3, 0.3), (-0.3, 0.3)].map(|(x, y)| Vec2::new(x, y));
    let arena = Boundary::new(Role::Arena, Curve::polyline(&square, true).unwrap(), None).unwrap();
    let pillar = Boundary::new(Role::Obstacle, Curve::circle(Vec2::new(0.05, 0.02), 0.06).unwrap(), None).unwrap();
    Map::new(vec![arena, pillar]).unwrap()
}

/// A history of a constant moment along a straight way; the slope that it shows does not matter here.
fn history(moment: f64, at: Pose2) -> MomentHistory {
    let reading = |k: i32| MomentReading {
        t: f64::from(k) * 1e-2,
        odom_from_whisker: at.compose(Pose2::new(f64::from(k) * 2.5e-3, 0.0, 0.0)),
        moment,
    };
    MomentHistory {
        center: reading(0),
        shapes: (-2..=2).map(reading).collect(),
        travel: (-2..=2).map(|k| f64::from(k) * 2.5e-3).collect(),
        center_std: 0.01 * moment.abs(),
        slope_std: 1.0 * moment.abs(),
        bend_std: 100.0 * moment.abs(),
        bound: 0.05 * moment.abs(),
        smooth: true,
    }
}

/// The least distance over which a state must be moved, heading kept, to lie in the preimage: boundary points every
/// 0.1 mm, each with its own normal and so its own shape, and the corners with every normal in between.
fn brute_force(map: &Map, pose: Pose2, observation: &Observation) -> f64 {
    let mut least = f64::INFINITY;
    for sample in map.samples(1e-4) {
        for branch in &observation.branches {
            let direction = sample.tangent + FRAC_PI_2 - pose.theta;
            if let Some(contact) = branch.contacts.at_direction(direction) {
                least = least.min(pose.transform_point(contact.position).distance(sample.position));
            }
        }
    }
    // In a corner of the room the force may have any direction between the two normals.
    for (x, y, normal) in [(-0.3, -0.3, 0.0), (0.3, -0.3, 0.5 * PI), (0.3, 0.3, PI), (-0.3, 0.3, -0.5 * PI)] {
        for k in 0..=900 {
            let direction = normal + f64::from(k) * 0.1_f64.to_radians() - pose.theta;
            for contact in observation.branches.iter().filter_map(|b| b.contacts.at_direction(direction)) {
                least = least.min(pose.transform_point(contact.position).distance(Vec2::new(x, y)));
            }
        }
    }
    least
}

#[test]
fn the_nearest_state_is_the_nearest_of_all() {
    let (map, mut draw) = (room(), Random(5));
    let whisker = MountedWhisker::default();
    let tip = TipModel::new(&whisker.beam).unwrap();
    let options = DeterministicOptions { tolerance: 2.0, ..DeterministicOptions::default() };
    let samples = map.samples(5e-3);
    let (mut accepted, mut refused, mut elsewhere) = (0, 0, 0);
    for _ in 0..25 {
        let moment = draw.between(0.5e-3, 6e-3) * if draw.between(0.0, 1.0) < 0.5 { -1.0 } else { 1.0 };
        let odom = Pose2::new(draw.between(-1.0, 1.0), draw.between(-1.0, 1.0), draw.between(-PI, PI));
        let mut observation = Observation::new(&whisker, &tip, &history(moment, odom), TipLoad::BoundaryNormal);
        let states = aligned_states(&map, &samples, &observation);
        // The alignments have done their part; from here on only the place counts.
        observation.branches.iter_mut().for_each(|b| b.determined = false);
        observation.branches.iter_mut().for_each(|b| b.alignments.clear());
        let tolerance = Tolerance::new(&observation, &options);
        for _ in 0..40.min(states.len()) {
            let state = states[draw.between(0.0, states.len() as f64) as usize];
            let near = AlignedState {
                map_from_robot: Pose2::new(
                    state.map_from_robot.x + draw.between(-6e-3, 6e-3),
                    state.map_from_robot.y + draw.between(-6e-3, 6e-3),
                    state.map_from_robot.theta + draw.between(-0.05, 0.05),
                ),
                ..state
            };
            let candidate = Candidate::at(&near, &observation, 1e-3);
            let pose = candidate.map_from_odom.compose(observation.odom_from_whisker);
            let least = brute_force(&map, pose, &observation);
            match nearest_state(&map, &candidate, &observation, &tolerance) {
                Some(found) => {
                    accepted += 1;
                    // Where a wall ends in a corner the tip may lie beyond its end, by 3 mm at most.
                    let corner = map.concave_corner(found.touched, 1e-6).is_some();
                    let beyond = if corner { 3e-3 } else { 0.0 };
                    let gap = found.offset.abs();
                    assert!(least < 1.1 * gap.hypot(beyond) + 0.2e-3, "{gap} m, brute force {least} m");
                    // A strongly bent whisker may touch nearby in two ways; the one that continues the last counts.
                    elsewhere += usize::from(gap > 1.1 * least + 0.2e-3);
                }
                None => {
                    refused += 1;
                    let standing = !map.is_free(pose.position());
                    assert!(standing || least > options.position_floor, "refused at {least} m: {near:?}");
                }
            }
        }
    }
    assert!(accepted > 200 && refused > 100 && elsewhere < accepted / 50, "{accepted} {refused} {elsewhere}");
}

#[test]
fn aligned_states_touch_the_boundary_at_the_right_angle() {
    let (map, mut draw) = (room(), Random(11));
    let mount = Pose2::new(0.02, -0.01, 0.3);
    let whisker = MountedWhisker { robot_from_whisker: mount, ..MountedWhisker::default() };
    let tip = TipModel::new(&whisker.beam).unwrap();
    let samples = map.samples(20e-3);
    let mut checked = 0;
    for _ in 0..20 {
        let moment = draw.between(-6e-3, 6e-3);
        let odom = Pose2::new(draw.between(-1.0, 1.0), draw.between(-1.0, 1.0), draw.between(-PI, PI));
        let observation = Observation::new(&whisker, &tip, &history(moment, odom), TipLoad::BoundaryNormal);
        for state in aligned_states(&map, &samples, &observation) {
            let base = state.map_from_robot.compose(mount);
            assert!(map.is_free(base.position()));
            // The state's own shape: the force is normal to the wall, and its tip is at the touched point.
            let touches = observation.branches.iter().any(|branch| {
                branch.contacts.at_direction(state.normal - base.theta).is_some_and(|contact| {
                    let tip = base.transform_point(contact.position);
                    let slope = wrap_angle(state.normal - FRAC_PI_2 - base.theta);
                    let aligned = branch.alignments.iter().any(|a| wrap_angle(slope - a.boundary_slope).abs() < 0.8);
                    tip.distance(state.contact) < 1e-9 && aligned
                })
            });
            assert!(touches, "{state:?}");
            checked += 1;
        }
    }
    assert!(checked > 500, "{checked}");
}

/// Two observations met in slices while the robot drives on leave what they leave when each is met at once.
#[test]
fn slices_leave_what_the_whole_leaves() {
    let (map, options) = (room(), DeterministicOptions::default());
    let whisker = MountedWhisker::default();
    let tip = TipModel::new(&whisker.beam).unwrap();
    let samples = map.samples(5e-3);
    let at = |x: f64| Pose2::new(x, 0.0, 0.0);
    let observed = |x: f64| Observation::new(&whisker, &tip, &history(2e-3, at(x)), TipLoad::BoundaryNormal);
    let odometry = Odometry { translation_relative: 0.02, rotation_relative: 0.02, ..Odometry::default() };
    let mut whole = StateSet::default();
    whole.start(&map, &samples, &[observed(0.0)], &options);
    let mut sliced = whole.clone();
    let first = whole.candidates().len();
    let mut due = std::collections::VecDeque::new();
    let mut slices = 0;
    for (row, x) in [0.002, 0.004, 0.006, 0.008, 0.010].into_iter().enumerate() {
        whole.project(at(x), &odometry);
        sliced.project(at(x), &odometry);
        if row % 2 == 1 {
            whole.intersect(&map, &observed(x), &options);
            due.push_back((observed(x), sliced.pass()));
        }
    }
    while let Some((observation, mut pass)) = due.pop_front() {
        let mut progress = Progress::Waits;
        while progress != Progress::Done {
            // By meetings, and by work.
            let mut budget = if slices % 2 == 0 { WorkBudget::new(1) } else { WorkBudget::unlimited() };
            let mut most = 7;
            progress = pass.advance(&mut sliced, &map, &observation, &options, &mut most, &mut budget);
            slices += 1;
        }
    }
    assert!(slices > 20 && whole.candidates().len() > 20, "{slices} slices, {first} -> {}", whole.candidates().len());
    assert!(
        sliced.candidates() == whole.candidates(),
        "{} and {}",
        sliced.candidates().len(),
        whole.candidates().len()
    );
}

#[test]
fn a_start_in_slices_is_the_start_at_once() {
    let (map, options) = (room(), DeterministicOptions::default());
    let whisker = MountedWhisker::default();
    let tip = TipModel::new(&whisker.beam).unwrap();
    let samples = map.samples(5e-3);
    let at = |x: f64| Pose2::new(x, 0.0, 0.0);
    let observations =
        [0.0, 0.002, 0.004].map(|x| Observation::new(&whisker, &tip, &history(2e-3, at(x)), TipLoad::BoundaryNormal));
    let (mut whole, mut sliced) = (StateSet::default(), StateSet::default());
    whole.start(&map, &samples, &observations, &options);
    assert!(whole.candidates().len() > 20, "{}", whole.candidates().len());
    for units in [1, 300] {
        let mut start = Start::new(&sliced, &samples, &observations, &options);
        let mut slices = 0;
        while !start.advance(&mut sliced, &map, &samples, &observations, &options, &mut WorkBudget::new(units)) {
            assert!(sliced.is_empty(), "a start that is under way tells nothing");
            slices += 1;
        }
        assert!(slices > 10, "{slices} slices");
        assert!(sliced.candidates() == whole.candidates(), "{units}");
        sliced = StateSet::default();
    }
}
