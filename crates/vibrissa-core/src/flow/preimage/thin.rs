//! Whether a whisker passes through a thin wall for certain.

use crate::plane::Vec2;
use crate::world::{Map, Role};

/// Largest distance between a wall and the chain that stands for it here (m).
const CHAIN_TOLERANCE: f64 = 1e-5;

/// One wall as a chain, and its open ends.
#[derive(Clone, Debug)]
struct Wall {
    chain: Vec<Vec2>,
    ends: Vec<Vec2>,
}

/// The thin walls of a map.
///
/// A whisker that is known up to `slack` passes through a wall for certain when it crosses it an odd number of times
/// between two of its points that are further away from the wall than that, and stays as far from the wall's ends: no
/// motion by less than the slack undoes such a crossing.
#[derive(Clone, Debug)]
pub(super) struct ThinWalls {
    walls: Vec<Wall>,
    slack: f64,
}

impl ThinWalls {
    /// The walls of `map` against whiskers that are known up to `slack` (m); none where there is no wall.
    pub(super) fn new(map: &Map, slack: f64) -> Option<Self> {
        let of_wall = |boundary: &crate::world::Boundary| {
            let chain = boundary.curve().flatten(CHAIN_TOLERANCE);
            let ends = if boundary.curve().is_closed() { None } else { chain.first().zip(chain.last()) };
            Wall { ends: ends.map_or_else(Vec::new, |(a, b)| vec![*a, *b]), chain }
        };
        let walls: Vec<Wall> = map.boundaries().iter().filter(|b| b.role() == Role::Wall).map(of_wall).collect();
        (!walls.is_empty()).then_some(Self { walls, slack })
    }

    /// Whether the whisker with these points, seen from `place` (m), passes through a wall for certain.
    pub(super) fn stop(&self, place: Vec2, body: &[Vec2]) -> bool {
        self.walls.iter().any(|wall| wall.stops(place, body, self.slack))
    }
}

impl Wall {
    fn stops(&self, place: Vec2, body: &[Vec2], slack: f64) -> bool {
        let links = || body.windows(2).map(|link| [place + link[0], place + link[1]]);
        let crossed = |[a, b]: [Vec2; 2]| self.chain.windows(2).filter(|w| crosses(a, b, w[0], w[1])).count();
        // Hardly any whisker crosses; only then is it worth a closer look.
        if !links().any(|link| crossed(link) > 0) {
            return false;
        }
        let clear = |p: Vec2| self.chain.windows(2).all(|w| distance(p, w[0], w[1]) > slack);
        let (mut odd, mut near_end, mut from_clear) = (false, false, false);
        for [a, b] in links() {
            if clear(a) {
                (odd, near_end, from_clear) = (false, false, true);
            }
            odd ^= crossed([a, b]) % 2 == 1;
            near_end |= self.ends.iter().any(|&end| distance(end, a, b) <= slack);
            if from_clear && odd && !near_end && clear(b) {
                return true;
            }
        }
        false
    }
}

/// Whether the links `ab` and `cd` cross; of links that share a point one does.
fn crosses(a: Vec2, b: Vec2, c: Vec2, d: Vec2) -> bool {
    let left = |from: Vec2, to: Vec2, p: Vec2| (to - from).cross(p - from) >= 0.0;
    left(c, d, a) != left(c, d, b) && left(a, b, c) != left(a, b, d)
}

/// The distance of `p` from the link `ab` (m).
fn distance(p: Vec2, a: Vec2, b: Vec2) -> f64 {
    let along = b - a;
    let square = along.norm_squared();
    let share = if square > 0.0 { ((p - a).dot(along) / square).clamp(0.0, 1.0) } else { 0.0 };
    p.distance(a + along * share)
}
