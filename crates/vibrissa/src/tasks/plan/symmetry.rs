//! Whether a symmetry of the map takes places onto each other.

use super::RemainingState;
use super::score::SMALL;
use crate::plane::{Pose2, wrap_angle};
use crate::world::Map;

/// Points of the boundary (m apart) that are tried, and how far off they may come (m): places are known to millimetres.
const SPACING: f64 = 0.01;
const OFF: f64 = 5e-3;
/// A motion that moves no point of the boundary by more than this (m) is none.
const BESIDE: f64 = 0.02;

/// Whether several places are left, each known well enough, that only the map's symmetry keeps apart: whatever is felt at one is felt at
/// the others.
pub(super) fn leaves_nothing(map: &Map, states: &[RemainingState]) -> bool {
    let near = |a: &RemainingState, b: &RemainingState| {
        a.place != b.place || a.pose.position().distance(b.pose.position()) <= SMALL
    };
    let several = states.iter().any(|state| state.place != states[0].place);
    several && states.iter().all(|a| states.iter().all(|b| near(a, b))) && takes_places(map, states)
}

/// Whether motions that take the first place to each of the others, to somewhere on its ridge, take the map onto itself.
pub(super) fn takes_places(map: &Map, states: &[RemainingState]) -> bool {
    let places = states.iter().map(|s| s.place).max().map_or(0, |last| last + 1);
    let of = |place: usize| states.iter().filter(|s| s.place == place).map(|s| s.pose).collect::<Vec<Pose2>>();
    let samples = map.samples(SPACING);
    let Some(first) = states.first() else { return false };
    // The ends of ridges at two places need not be where the symmetry has them.
    let of_first = of(first.place);
    let middle = of_first[of_first.len() / 2];
    (0..places).filter(|&place| place != first.place).map(of).filter(|poses| !poses.is_empty()).all(|poses| {
        filled(&poses).into_iter().any(|other| {
            let onto = other.compose(middle.inverse());
            // Places beside each other are no images: any map comes near itself by so little.
            samples.iter().any(|s| onto.transform_point(s.position).distance(s.position) > BESIDE)
                && samples.iter().all(|s| map.nearest_within(onto.transform_point(s.position), OFF).is_some())
        })
    })
}

/// The poses along a ridge with others between them, none further from the next than `OFF`.
fn filled(ridge: &[Pose2]) -> Vec<Pose2> {
    let mut poses: Vec<Pose2> = ridge.first().copied().into_iter().collect();
    for pair in ridge.windows(2) {
        let (from, to) = (pair[0], pair[1]);
        let step = to.position() - from.position();
        let count = (step.norm() / OFF).ceil().max(1.0);
        poses.extend((1..=count as usize).map(|k| {
            let share = k as f64 / count;
            let place = from.position() + step * share;
            Pose2::new(place.x, place.y, from.theta + share * wrap_angle(to.theta - from.theta))
        }));
    }
    poses
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

    use super::*;
    use crate::plane::{Curve, Vec2};
    use crate::world::{Boundary, Role};
    use core::f64::consts::PI;

    #[test]
    fn ridges_are_images_of_each_other_whatever_their_samples_and_ends() {
        let corners = [(0.0, 0.0), (0.5, 0.0), (0.5, 0.3), (0.0, 0.3)].map(|(x, y)| Vec2::new(x, y));
        let outline = Boundary::new(Role::Arena, Curve::polyline(&corners, true).unwrap(), None).unwrap();
        let map = Map::new(vec![outline]).unwrap();
        let at = |place, x, y, theta| RemainingState {
            pose: Pose2::new(x, y, theta),
            weight: 0.1,
            place,
            covariance: [[0.0; 3]; 3],
        };
        let lower = [0.10, 0.13, 0.16].map(|x| at(0, x, 0.05, 0.2));
        // Turned about the middle, sampled elsewhere, and longer at one end.
        let upper = |y: f64| [0.40, 0.385, 0.35, 0.32].map(|x| at(1, x, y, 0.2 + PI));
        let of = |y: f64| lower.into_iter().chain(upper(y)).collect::<Vec<_>>();
        assert!(takes_places(&map, &of(0.25)));
        assert!(!takes_places(&map, &of(0.235)), "beside the image");
        let elsewhere = [at(1, 0.30, 0.25, 0.2 + PI), at(1, 0.25, 0.25, 0.2 + PI)];
        assert!(!takes_places(&map, &lower.into_iter().chain(elsewhere).collect::<Vec<_>>()), "beyond its end");
        // Two places a few millimetres from each other are not told apart by any symmetry.
        assert!(!takes_places(&map, &[at(0, 0.1, 0.05, 0.2), at(1, 0.103, 0.052, 0.21)]), "beside each other");
    }
}
