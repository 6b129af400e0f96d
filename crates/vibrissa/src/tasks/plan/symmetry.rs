//! Whether a symmetry of the map takes places onto each other.

use super::RemainingState;
use super::score::SMALL;
use crate::world::Map;

/// Points of the boundary (m apart) that are tried, and how far off they may come (m): places are known to millimetres.
const SPACING: f64 = 0.01;
const OFF: f64 = 5e-3;

/// Whether several places are left, each known well enough, that only the map's symmetry keeps apart: whatever is felt at one is felt at
/// the others.
pub(super) fn leaves_nothing(map: &Map, states: &[RemainingState]) -> bool {
    let near = |a: &RemainingState, b: &RemainingState| {
        a.place != b.place || a.pose.position().distance(b.pose.position()) <= SMALL
    };
    let several = states.iter().any(|state| state.place != states[0].place);
    several && states.iter().all(|a| states.iter().all(|b| near(a, b))) && takes_places(map, states)
}

/// Whether the motions that take the first place to each of the others take the map onto itself.
pub(super) fn takes_places(map: &Map, states: &[RemainingState]) -> bool {
    let places = states.iter().map(|s| s.place).max().map_or(0, |last| last + 1);
    let of = |place: usize| states.iter().filter(move |s| s.place == place);
    let samples = map.samples(SPACING);
    let Some(first) = states.first() else { return false };
    (0..places).filter(|&place| place != first.place && of(place).next().is_some()).all(|place| {
        of(place).any(|other| {
            let onto = other.pose.compose(first.pose.inverse());
            samples.iter().all(|s| map.nearest_within(onto.transform_point(s.position), OFF).is_some())
        })
    })
}
