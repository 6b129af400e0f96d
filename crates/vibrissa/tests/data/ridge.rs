//! How far a state is from a place's ridge.

use vibrissa::plane::{Pose2, wrap_angle};

/// What a radian counts for where the nearest point of a ridge is looked for (m).
const LEVER: f64 = 0.075;

/// Distance (m) and turn (rad) of a state from the point of a ridge that is nearest to it; none where there is no ridge.
pub(crate) fn off_ridge(ridge: &[Pose2], state: Pose2) -> Option<(f64, f64)> {
    let off = |w: &[Pose2]| {
        let way = difference(w[0], w[1]);
        let d = difference(w[0], state);
        let square = dot(way, way);
        let share = if square > 0.0 { (dot(d, way) / square).clamp(0.0, 1.0) } else { 0.0 };
        let rest = [0, 1, 2].map(|i| d[i] - share * way[i]);
        (dot(rest, rest), (rest[0].hypot(rest[1]), rest[2].abs()))
    };
    ridge.windows(2).map(off).min_by(|a, b| a.0.total_cmp(&b.0)).map(|nearest| nearest.1)
}

fn difference(a: Pose2, b: Pose2) -> [f64; 3] {
    [b.x - a.x, b.y - a.y, wrap_angle(b.theta - a.theta)]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + LEVER * LEVER * a[2] * b[2]
}
