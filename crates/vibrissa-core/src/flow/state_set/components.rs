//! The separate places of a set of candidates.

use super::Candidate;
use crate::plane::{Pose2, wrap_angle};
use crate::sets::StateBox;

/// States within one cell of each other are linked (m and rad): a few spacings of the boundary's samples.
const LINK_PLACE: f64 = 6e-3;
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
    let cells = Cells::of(&states);
    let roots = cells.linked();
    let mut number = vec![0; roots.len()];
    let mut components: Vec<Component> = Vec::new();
    for (cell, &root) in roots.iter().enumerate() {
        // The first cell of a component is its root.
        if root == cell {
            number[cell] = components.len();
            components.push(Component { members: Vec::new(), extent: StateBox::EMPTY });
        }
        components[number[root]].members.extend(cells.members(cell));
    }
    for Component { members, extent } in &mut components {
        members.sort_by(|&a, &b| candidates[a].rank().total_cmp(&candidates[b].rank()).then(a.cmp(&b)));
        *extent = members.iter().fold(StateBox::EMPTY, |b, &i| b.including(states[i]));
    }
    components
}

/// How many components the candidates' states have: faster than to list them.
pub(super) fn count(candidates: &[Candidate], odom_from_robot: Pose2) -> usize {
    let states: Vec<Pose2> = candidates.iter().map(|c| c.map_from_odom.compose(odom_from_robot)).collect();
    Cells::of(&states).linked().iter().enumerate().filter(|&(cell, &root)| cell == root).count()
}

/// The cells that states lie in, in order.
struct Cells {
    /// Each state's index by cell.
    keyed: Vec<([i64; 3], u32)>,
    /// Each cell, and where its states begin.
    cells: Vec<([i64; 3], usize)>,
}

impl Cells {
    fn of(states: &[Pose2]) -> Self {
        let mut keyed: Vec<_> = states.iter().enumerate().map(|(index, &state)| (cell(state), index as u32)).collect();
        keyed.sort_unstable();
        let mut cells: Vec<([i64; 3], usize)> = Vec::new();
        for (at, &(key, _)) in keyed.iter().enumerate() {
            if cells.last().is_none_or(|&(last, _)| last != key) {
                cells.push((key, at));
            }
        }
        Self { keyed, cells }
    }

    /// The states in a cell.
    fn members(&self, cell: usize) -> impl Iterator<Item = usize> {
        let end = self.cells.get(cell + 1).map_or(self.keyed.len(), |next| next.1);
        self.keyed[self.cells[cell].1..end].iter().map(|&(_, index)| index as usize)
    }

    /// For each cell the first cell of its component.
    fn linked(&self) -> Vec<usize> {
        let mut roots: Vec<usize> = (0..self.cells.len()).collect();
        for step in FORWARD {
            let mut next = 0;
            for (cell, &(key, _)) in self.cells.iter().enumerate() {
                let (there, round) = neighbour(key, step);
                // Neighbours come in the order of their cells, but for those round the circle.
                let found = if round {
                    self.cells.binary_search_by_key(&there, |c| c.0).ok()
                } else {
                    while self.cells.get(next).is_some_and(|c| c.0 < there) {
                        next += 1;
                    }
                    self.cells.get(next).filter(|c| c.0 == there).map(|_| next)
                };
                if let Some(other) = found {
                    let (a, b) = (root(&mut roots, cell), root(&mut roots, other));
                    roots[a.max(b)] = a.min(b);
                }
            }
        }
        (0..roots.len()).map(|cell| root(&mut roots, cell)).collect()
    }
}

/// The root of a cell, halving the way to it.
fn root(roots: &mut [usize], mut cell: usize) -> usize {
    while roots[cell] != cell {
        roots[cell] = roots[roots[cell]];
        cell = roots[cell];
    }
    cell
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

/// The steps to those of a cell's 26 neighbours that come after it in order, or would on a line instead of a circle.
const FORWARD: [[i64; 3]; 13] = [
    [0, 0, 1],
    [0, 1, -1],
    [0, 1, 0],
    [0, 1, 1],
    [1, -1, -1],
    [1, -1, 0],
    [1, -1, 1],
    [1, 0, -1],
    [1, 0, 0],
    [1, 0, 1],
    [1, 1, -1],
    [1, 1, 0],
    [1, 1, 1],
];

/// The neighbour one step away, and whether the step goes round the circle.
fn neighbour(at: [i64; 3], step: [i64; 3]) -> ([i64; 3], bool) {
    let turned = at[2] + step[2];
    let there = [at[0].saturating_add(step[0]), at[1].saturating_add(step[1]), turned.rem_euclid(headings())];
    (there, there[2] != turned)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_at_the_end_of_all_numbers_have_neighbours() {
        let state = Pose2::new(1e300, -1e300, 3.0);
        assert_eq!(cell(state)[..2], [i64::MAX, i64::MIN]);
        assert_eq!(Cells::of(&[state, state]).linked(), [0]);
    }

    /// Against a flood fill over every pair of cells.
    #[test]
    fn components_are_those_of_a_flood_fill() {
        let mut seed = 1_u64;
        let mut random = |below: u64| {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 33) % below
        };
        for round in 0..60 {
            let width = [4, 8, 12][round % 3];
            let turn = core::f64::consts::TAU / headings() as f64;
            // On both sides of the half turn, where the circle closes.
            let states: Vec<Pose2> = (0..60 + 4 * round)
                .map(|_| {
                    let theta = core::f64::consts::PI + turn * (random(8) as f64 - 3.5);
                    let place = |k: u64| (k as f64 - 5.5) * LINK_PLACE;
                    Pose2::new(place(random(width)), place(random(width)), theta)
                })
                .collect();
            let cells = Cells::of(&states);
            let count = cells.cells.len();
            let mut labels: Vec<usize> = (0..count).collect();
            let near = |a: usize, b: usize| {
                let (a, b) = (cells.cells[a].0, cells.cells[b].0);
                let round = (a[2] - b[2]).rem_euclid(headings());
                (a[0] - b[0]).abs() <= 1 && (a[1] - b[1]).abs() <= 1 && (round <= 1 || round == headings() - 1)
            };
            let mut changed = true;
            while changed {
                changed = false;
                for (a, b) in (0..count * count).map(|k| (k / count, k % count)).filter(|&(a, b)| near(a, b)) {
                    changed |= labels[b] < labels[a];
                    labels[a] = labels[a].min(labels[b]);
                }
            }
            assert_eq!(cells.linked(), labels, "round {round}");
        }
    }
}
