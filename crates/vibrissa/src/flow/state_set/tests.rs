//! The intersection against a brute-force search over the boundary, which lists the preimage point by point.

use super::candidate::Candidate;
use super::membership::{Tolerance, nearest_state};
use crate::config::{DeterministicOptions, TipLoad};
use crate::flow::moment::{MomentHistory, MomentReading};
use crate::flow::preimage::{AlignedState, Observation, aligned_states};
use crate::plane::{Curve, Pose2, Vec2, wrap_angle};
use crate::world::{Boundary, Map, MountedWhisker, Role};
use core::f64::consts::{FRAC_PI_2, PI};

/// Numbers in [0, 1) that are the same in every run.
struct Draw(u64);

impl Draw {
    fn between(&mut self, lo: f64, hi: f64) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        lo + (hi - lo) * (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
}

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
/// 0.1 mm, each with its own normal and so its own shape.
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
    least
}

#[test]
fn the_nearest_state_is_the_nearest_of_all() {
    let (map, mut draw) = (room(), Draw(5));
    let whisker = MountedWhisker::default();
    let options = DeterministicOptions { tolerance: 2.0, ..DeterministicOptions::default() };
    let samples = map.samples(5e-3);
    let (mut accepted, mut refused) = (0, 0);
    for _ in 0..25 {
        let moment = draw.between(0.5e-3, 6e-3) * if draw.between(0.0, 1.0) < 0.5 { -1.0 } else { 1.0 };
        let odom = Pose2::new(draw.between(-1.0, 1.0), draw.between(-1.0, 1.0), draw.between(-PI, PI));
        let mut observation = Observation::new(&whisker, &history(moment, odom), TipLoad::BoundaryNormal);
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
                    // Near the straight walls' ends the foot of the perpendicular may lie beside the nearest point.
                    let wrong = (found.offset.abs() - least).abs();
                    assert!(wrong < 0.2e-3 + 0.1 * least, "{} mm, brute force {} mm", found.offset * 1e3, least * 1e3);
                }
                None => {
                    refused += 1;
                    let standing = !map.is_free(pose.position());
                    assert!(standing || least > options.position_floor, "refused at {least} m: {near:?}");
                }
            }
        }
    }
    assert!(accepted > 200 && refused > 100, "{accepted} {refused}");
}

#[test]
fn aligned_states_touch_the_boundary_at_the_right_angle() {
    let (map, mut draw) = (room(), Draw(11));
    let mount = Pose2::new(0.02, -0.01, 0.3);
    let whisker = MountedWhisker { robot_from_whisker: mount, ..MountedWhisker::default() };
    let samples = map.samples(20e-3);
    let mut checked = 0;
    for _ in 0..20 {
        let moment = draw.between(-6e-3, 6e-3);
        let odom = Pose2::new(draw.between(-1.0, 1.0), draw.between(-1.0, 1.0), draw.between(-PI, PI));
        let observation = Observation::new(&whisker, &history(moment, odom), TipLoad::BoundaryNormal);
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

#[test]
#[ignore = "diagnosis"]
fn diagnose() {
    use crate::flow::moment::MomentTrack;
    let seed: u64 = std::env::var("SEED").unwrap().parse().unwrap();
    let sweep = crate::tasks::demo::sweep(seed).unwrap();
    let map = crate::tasks::demo::arena().unwrap();
    let options = DeterministicOptions::default();
    let whisker = MountedWhisker::default();
    let mut track = MomentTrack::new(&whisker, &options);
    let samples = map.samples(1e-3);
    let mut n = 0;
    let a0 = sweep.truth[0].map_from_robot.compose(sweep.log.rows[0].odom_from_robot.inverse());
    for row in &sweep.log.rows {
        let m = row.readings[0];
        if !track.is_contact(m) {
            track.end();
            continue;
        }
        let Some(h) = track.push(MomentReading { t: row.t, odom_from_whisker: row.odom_from_robot, moment: m }) else {
            continue;
        };
        if !h.smooth {
            println!("{:.3} rough", h.center.t);
            continue;
        }
        let o = Observation::new(&whisker, &h, TipLoad::BoundaryNormal);
        let i = sweep.truth.iter().position(|p| (p.t - o.t).abs() < 1e-9).unwrap();
        let truth = sweep.truth[i].map_from_robot;
        let touch = sweep.contacts.iter().find(|c| c.row == i).unwrap();
        let near = map.nearest(touch.position).unwrap();
        let st = AlignedState {
            map_from_robot: truth,
            contact: touch.position,
            normal: near.tangent + FRAC_PI_2,
            heading_std: 1e-3,
        };
        let mut c = Candidate::at(&st, &o, 1e-4, 0);
        c.map_from_odom = a0;
        let tol = Tolerance::new(&o, &options);
        let f = nearest_state(&map, &c, &o, &tol);
        let slope_true = near.tangent - truth.theta;
        let al: Vec<String> = o
            .branches
            .iter()
            .map(|b| {
                format!(
                    "det {} [{}]",
                    b.determined,
                    b.alignments
                        .iter()
                        .map(|a| format!(
                            "{:+.1}±{:.1}",
                            wrap_angle(a.boundary_slope - slope_true).to_degrees(),
                            a.std.to_degrees()
                        ))
                        .collect::<Vec<_>>()
                        .join(" ")
                )
            })
            .collect();
        let entry = if n < 3 || o.can_start() && n < 14 {
            let s = aligned_states(&map, &samples, &o);
            let d = s
                .iter()
                .map(|s| {
                    s.map_from_robot.position().distance(truth.position())
                        + 0.05 * wrap_angle(s.map_from_robot.theta - truth.theta).abs()
                })
                .fold(f64::INFINITY, f64::min);
            format!("start {} entry {} nearest {:.2} mm", o.can_start(), s.len(), d * 1e3)
        } else {
            String::new()
        };
        println!(
            "{:.3} M {:+.2e} err {:+.1}% {} {} {}",
            o.t,
            o.moment,
            100.0 * (o.moment / sweep.exact_moments[i][0] - 1.0),
            f.map_or("MISS".into(), |f| format!("ok {:.2} off {:.2}mm", f.cost, f.offset * 1e3)),
            al.join(" | "),
            entry
        );
        n += 1;
    }
}
