//! The separate places of a set of candidates.

use super::Candidate;
use crate::plane::{Pose2, wrap_angle};
use crate::sets::StateBox;
use std::collections::BTreeMap;

/// States within one cell of each other are linked (m and rad): a few spacings of the boundary's samples.
const LINK_PLACE: f64 = 3e-3;
const LINK_HEADING: f64 = 0.06;

/// One separate place: candidates that are linked to each other and to no others.
#[derive(Clone, Debug, PartialEq)]
pub struct Component {
    /// Indices of its candidates, the best first.
    pub members: Vec<usize>,
    /// The box around its states.
    pub extent: StateBox,
}

/// The components of the candidates' states, in no order that depends on anything but the candidates.
#[must_use]
pub fn components(candidates: &[Candidate], odom_from_robot: Pose2) -> Vec<Component> {
    let states: Vec<Pose2> = candidates.iter().map(|c| c.map_from_odom.compose(odom_from_robot)).collect();
    let mut cells: BTreeMap<[i64; 3], Vec<usize>> = BTreeMap::new();
    for (index, state) in states.iter().enumerate() {
        cells.entry(cell(*state)).or_default().push(index);
    }
    let mut components = Vec::new();
    while let Some((&start, _)) = cells.iter().next() {
        let mut members = Vec::new();
        let mut open = vec![start];
        while let Some(at) = open.pop() {
            let Some(found) = cells.remove(&at) else { continue };
            members.extend(found);
            open.extend(neighbours(at).filter(|n| cells.contains_key(n)));
        }
        members.sort_by(|&a, &b| candidates[a].rank().total_cmp(&candidates[b].rank()).then(a.cmp(&b)));
        let extent = members.iter().fold(StateBox::EMPTY, |b, &i| b.including(states[i]));
        components.push(Component { members, extent });
    }
    components
}

fn headings() -> i64 {
    (core::f64::consts::TAU / LINK_HEADING).floor() as i64
}

/// Cells of equal size that close up round the circle.
fn cell(state: Pose2) -> [i64; 3] {
    let width = core::f64::consts::TAU / headings() as f64;
    let floor = |v: f64, by: f64| (v / by).floor() as i64;
    [
        floor(state.x, LINK_PLACE),
        floor(state.y, LINK_PLACE),
        floor(wrap_angle(state.theta), width).rem_euclid(headings()),
    ]
}

fn neighbours(at: [i64; 3]) -> impl Iterator<Item = [i64; 3]> {
    let around = move |k: i64| [k % 3 - 1, (k / 3) % 3 - 1, k / 9 - 1];
    (0..27)
        .map(around)
        .map(move |d| [at[0].saturating_add(d[0]), at[1].saturating_add(d[1]), (at[2] + d[2]).rem_euclid(headings())])
}
