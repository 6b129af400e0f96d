//! Whether the region of a place holds the truth.

use vibrissa::flow::pose::Hypothesis;
use vibrissa::plane::{Pose2, wrap_angle};

/// The 95 % point of chi² for three degrees of freedom.
pub(crate) const CHI2_95: f64 = 7.815;

/// The squared distance of the truth from a place in its own standard deviations; infinite without a covariance.
pub(crate) fn distance(place: &Hypothesis, truth: Pose2) -> f64 {
    let Some(c) = place.covariance else { return f64::INFINITY };
    let d = [truth.x - place.pose.x, truth.y - place.pose.y, wrap_angle(truth.theta - place.pose.theta)];
    let det = |m: [[f64; 3]; 3]| {
        m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
            + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])
    };
    let solved = |k: usize| {
        let mut replaced = c;
        (0..3).for_each(|i| replaced[i][k] = d[i]);
        det(replaced) / det(c)
    };
    (0..3).map(|k| d[k] * solved(k)).sum()
}
