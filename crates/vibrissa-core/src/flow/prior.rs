//! What a region for the first pose leaves of a map.

use crate::plane::{Bounds, Vec2};

/// The rectangle around all places within `reach` (m) of a point that the robot carried to `arm` (m, its own frame at
/// the first row, up to `slack` m), with the robot at the first row in `region`: least and largest x, y (m) and heading
/// (rad).
pub(crate) fn around([x, y, heading]: [[f64; 2]; 3], arm: Vec2, slack: f64, reach: f64) -> Bounds {
    let (middle, half) = (0.5 * (heading[0] + heading[1]), 0.5 * (heading[1] - heading[0]));
    // A chord is no longer than its arc, nor than the circle is wide.
    let wide = Vec2::new(1.0, 1.0) * (arm.norm() * half.min(2.0) + slack + reach);
    let carried = arm.rotated(middle);
    let (least, most) = (Vec2::new(x[0], y[0]), Vec2::new(x[1], y[1]));
    Bounds { min: least + carried - wide, max: most + carried + wide }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plane::Pose2;

    /// Against poses all over the region, and points all round.
    #[test]
    fn nothing_in_reach_is_left_out() {
        let arm = Vec2::new(0.4, -0.7);
        for [from, to] in [[0.3, 0.3], [-0.2, 0.5], [2.0, 5.0], [-3.2, 3.2], [-9.0, 9.0]] {
            let bounds = around([[-0.1, 0.2], [0.4, 0.4], [from, to]], arm, 0.0, 0.1);
            let mut widest = Bounds::EMPTY;
            for k in 0..2000 {
                let share = f64::from(k) / 1999.0;
                let robot = Pose2::new(-0.1 + 0.3 * f64::from(k % 2), 0.4, from + (to - from) * share);
                let p = robot.transform_point(arm) + Vec2::from_angle(f64::from(k)) * 0.1;
                assert!(bounds.contains(p), "{from} to {to}: {p:?} outside {bounds:?}");
                widest = widest.including(p);
            }
            assert!(bounds.size().x < 1.5 * widest.size().x + 0.6, "{bounds:?} for {widest:?}");
        }
    }
}
