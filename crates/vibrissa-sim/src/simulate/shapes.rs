//! The shapes of touching whiskers from their contacts, for drawing.

use super::{Sweep, Touch};
use crate::beam::Whisker;
use crate::plane::Vec2;
use crate::world::Robot;

/// Steps of the march from base to tip.
const STEPS: usize = 64;

/// One whisker at one row.
#[derive(Clone, Debug, PartialEq)]
pub struct SweptShape {
    /// Index of the row.
    pub row: usize,
    /// Index of the whisker.
    pub whisker: usize,
    /// Points from base to tip at equal arc lengths, map frame (m).
    pub points: Vec<Vec2>,
}

/// The shapes of all whiskers at every `every`-th row, straight ones too; nothing for `every` = 0.
///
/// Each is marched from its base under the forces of its touches (Runge-Kutta, fourth order, 64 steps: within
/// micrometres), whatever taper, rest curvature and base it has.
#[must_use]
pub fn shapes(robot: &Robot, sweep: &Sweep, every: usize) -> Vec<SweptShape> {
    let mut shapes = Vec::new();
    if every == 0 {
        return shapes;
    }
    let mut touches = sweep.contacts.as_slice();
    for row in (0..sweep.truth.len()).step_by(every) {
        touches = &touches[touches.partition_point(|touch| touch.row < row)..];
        let here = &touches[..touches.partition_point(|touch| touch.row == row)];
        for (index, mounted) in robot.whiskers.iter().enumerate() {
            let map_from_whisker = sweep.truth[row].map_from_robot.compose(mounted.robot_from_whisker);
            let seen = |touch: &Touch| Push {
                place: map_from_whisker.inverse_transform_point(touch.position),
                force: touch.force.rotated(-map_from_whisker.theta),
            };
            let pushes: Vec<Push> = here.iter().filter(|touch| touch.whisker == index).map(seen).collect();
            let points = marched(&mounted.beam, &pushes);
            let points = points.into_iter().map(|p| map_from_whisker.transform_point(p)).collect();
            shapes.push(SweptShape { row, whisker: index, points });
        }
    }
    shapes
}

/// A force and where it acts, whisker frame.
#[derive(Clone, Copy, Debug)]
struct Push {
    place: Vec2,
    force: Vec2,
}

/// The whisker under these pushes, in its own frame.
fn marched(beam: &Whisker, pushes: &[Push]) -> Vec<Vec2> {
    let step = beam.length / STEPS as f64;
    let rate = |s: f64, [x, y, slope]: [f64; 3]| {
        let (here, along) = (Vec2::new(x, y), Vec2::from_angle(slope));
        // What lies behind bends no more: a push ends where the march has passed its place.
        let ahead = pushes.iter().filter(|push| (push.place - here).dot(along) > 0.0);
        let moment: f64 = ahead.map(|push| (push.place - here).cross(push.force)).sum();
        [along.x, along.y, moment / beam.rigidity_at(s) + beam.curvature_at(s)]
    };
    let add = |a: [f64; 3], b: [f64; 3], h: f64| [0, 1, 2].map(|k| a[k] + h * b[k]);
    let moment: f64 = pushes.iter().map(|push| push.place.cross(push.force)).sum();
    let mut state = [0.0, 0.0, moment / beam.base_stiffness];
    let mut points = vec![Vec2::ZERO];
    for index in 0..STEPS {
        let s = index as f64 * step;
        let k1 = rate(s, state);
        let k2 = rate(s + 0.5 * step, add(state, k1, 0.5 * step));
        let k3 = rate(s + 0.5 * step, add(state, k2, 0.5 * step));
        let k4 = rate(s + step, add(state, k3, step));
        state = add(add(add(add(state, k1, step / 6.0), k2, step / 3.0), k3, step / 3.0), k4, step / 6.0);
        points.push(Vec2::new(state[0], state[1]));
    }
    points
}
