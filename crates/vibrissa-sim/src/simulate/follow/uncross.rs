//! A discrete rod begins on the right side of every boundary.
//!
//! The shape that it takes over may cross one: its chords cut the corner that the whisker bends around, and one contact is looked
//! at for others within a tolerance. The barrier of the rod keeps it on the side where it begins, so that a node on the
//! wrong one would be held there for good, as by a hook.

use crate::plane::{Bounds, Vec2, segment_contact};
use crate::world::Map;

/// How often all links are looked at.
const ROUNDS: usize = 40;

/// The nodes moved off all boundaries that a link crosses, until none does; from base to tip, so that each node comes to the side on
/// which the one before it is. None where that takes a move beyond `most` (m).
pub(super) fn uncrossed(map: &Map, mut nodes: Vec<Vec2>, apart: f64, most: f64) -> Option<Vec<Vec2>> {
    for round in 0..ROUNDS {
        let mut clear = true;
        // Moves of several links that meet in a corner may need more room each time.
        let apart = apart * (1 + round) as f64;
        for link in 0..nodes.len() - 1 {
            let ends = [nodes[link], nodes[link + 1]];
            let mut edges = Vec::new();
            map.for_each_edge_in(Bounds::of(&ends), |edge| {
                edges.push(edge);
                false
            });
            for edge in edges {
                let ends = [nodes[link], nodes[link + 1]];
                if segment_contact(ends[0], ends[1], edge[0], edge[1]).is_none() {
                    continue;
                }
                clear = false;
                let (first, second) = least_move(ends, edge, apart, link > 0)?;
                if !(first.norm() <= most && second.norm() <= most) {
                    return None;
                }
                nodes[link] += first;
                nodes[link + 1] += second;
            }
        }
        if clear {
            return Some(nodes);
        }
    }
    None
}

/// The smallest move of a link's two nodes after which it does not cross an edge: its outer node comes back over the edge, or
/// the whole link (unless it is the first) goes past one of the edge's ends.
fn least_move([a, b]: [Vec2; 2], [c, d]: [Vec2; 2], apart: f64, is_loose: bool) -> Option<(Vec2, Vec2)> {
    let (along, normal) = (unit(b - a)?, unit(d - c)?.perp());
    let side = if normal.dot(a - c) < 0.0 { -normal } else { normal };
    let back = side * (apart - side.dot(b - c));
    let mut best = (Vec2::ZERO, back);
    let across = along.perp();
    for end in [c, d] {
        let off = across.dot(end - a);
        let by = across * (off + apart.copysign(off));
        if is_loose && by.norm() < best.1.norm() {
            best = (by, by);
        }
    }
    Some(best)
}

fn unit(v: Vec2) -> Option<Vec2> {
    let norm = v.norm();
    (norm > 0.0).then(|| v * (1.0 / norm))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plane::Curve;
    use crate::world::{Boundary, Role};

    const APART: f64 = 1e-7;

    fn map(role: Role, points: &[[f64; 2]], closed: bool) -> Option<Map> {
        let points: Vec<Vec2> = points.iter().map(|p| Vec2::new(p[0], p[1])).collect();
        Map::new(vec![Boundary::new(role, Curve::polyline(&points, closed)?, None).ok()?]).ok()
    }

    fn crosses(map: &Map, nodes: &[Vec2]) -> bool {
        nodes.windows(2).any(|link| map.crosses(link[0], link[1]))
    }

    /// A rod along the first axis whose nodes are this far off it.
    fn rod(offsets: &[f64]) -> Vec<Vec2> {
        offsets.iter().enumerate().map(|(i, &y)| Vec2::new(1e-3 * i as f64, y)).collect()
    }

    #[test]
    fn nodes_come_back_to_the_side_of_the_base() {
        let wall = map(Role::Wall, &[[-1.0, 0.0], [1.0, 0.0]], false).unwrap();
        for side in [1.0, -1.0] {
            let given = rod(&[1e-3, 1e-4, -3e-6, -1e-6, 2e-6, 0.0].map(|y| side * y));
            assert!(crosses(&wall, &given));
            let nodes = uncrossed(&wall, given.clone(), APART, 1e-4).unwrap();
            assert!(!crosses(&wall, &nodes));
            assert!(nodes.iter().all(|p| side * p.y >= 0.9 * APART), "{nodes:?}");
            // What was clear stays where it was.
            assert_eq!((nodes[0], nodes[1], nodes[4]), (given[0], given[1], given[4]));
            assert!(nodes.iter().zip(&given).all(|(p, q)| p.distance(*q) < 4e-6));
        }
    }

    #[test]
    fn links_that_cut_a_corner_go_past_it() {
        // The corner reaches two micrometres over the second link.
        let post = map(Role::Obstacle, &[[1.5e-3, 2e-6], [2e-3, -5e-3], [1e-3, -5e-3]], true).unwrap();
        let nodes = uncrossed(&post, rod(&[0.0, 0.0, 0.0, 0.0]), APART, 1e-4).unwrap();
        assert!(!crosses(&post, &nodes));
        assert!(nodes.iter().all(|p| p.y >= 0.0 && p.y < 5e-6), "{nodes:?}");
    }

    #[test]
    fn a_rod_that_is_deep_in_a_wall_is_told() {
        let wall = map(Role::Wall, &[[-1.0, 0.0], [1.0, 0.0]], false).unwrap();
        assert_eq!(uncrossed(&wall, rod(&[1e-3, 1e-4, -3e-4]), APART, 1e-4), None);
    }
}
