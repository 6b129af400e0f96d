//! The Cramer-Rao bound of the position \[barshalom2001estimation, sec. 2.7\], for errors of the readings with known covariance.

use crate::worlds::World;
use vibrissa::beam::TipModel;
use vibrissa::flow::state_set::probabilistic::{PredictedMoment, predicted_moments};
use vibrissa::plane::Pose2;
use vibrissa::sim::recorder::NoiseLaw;

/// Share of the rows on which forward model and simulator may differ by more than a tenth of the bound.
const ODD: f64 = 0.02;
/// Bounds beyond this are of places that the readings leave open (m).
const OPEN: f64 = 0.02;

/// Row by row of the contact: time (s), half width of the reading's bound (N m) and its derivatives by the last pose.
pub(crate) struct Sensitivity {
    rows: Vec<(f64, f64, [f64; 3])>,
}

impl Sensitivity {
    /// Along the true path; none where the forward model does not know what the whisker feels.
    pub(crate) fn of(world: &World) -> Option<Self> {
        let whisker = &world.robot.whiskers[0];
        let path: Vec<Pose2> =
            world.sweep.truth.iter().map(|p| p.map_from_robot.compose(whisker.robot_from_whisker)).collect();
        let felt = predicted_moments(&world.map, &TipModel::new(&whisker.beam).ok()?, &path);
        let bound = |h: f64| whisker.noise.moment_relative * h.abs() + whisker.noise.moment_absolute;
        let exact = || world.sweep.exact_moments.iter().map(|row| row[0]);
        let odd = felt.iter().zip(exact()).filter(|(ours, h)| (ours.moment - h).abs() > 0.1 * bound(*h)).count();
        if odd as f64 > ODD * path.len() as f64 {
            return None;
        }
        let last = world.sweep.truth.last()?.map_from_robot.position();
        let row = |(index, (ours, base)): (usize, (&PredictedMoment, &Pose2))| {
            let [gx, gy, turn] = ours.gradient;
            // The path turns about the last pose.
            let arm = base.position() - last;
            (world.sweep.truth[index].t, bound(ours.moment), [gx, gy, turn + gy * arm.x - gx * arm.y])
        };
        let rows = felt.iter().zip(&path).enumerate().filter(|(_, (ours, _))| ours.touching).map(row).collect();
        Some(Self { rows })
    }

    /// The least root mean square error of the position (m) under this law; none where its errors are no random process, or where
    /// the readings leave the place open.
    pub(crate) fn least_error(&self, law: NoiseLaw) -> Option<f64> {
        law.moments(0.0)?;
        let n = self.rows.len();
        // Gradients over the standard deviation, whitened by the factor of the correlation.
        let mut white: Vec<[f64; 3]> = Vec::with_capacity(n);
        let independent = law.moments(1e-9).is_some_and(|(_, correlation)| correlation.abs() < 1e-12);
        let mut factor: Vec<Vec<f64>> = Vec::new();
        for (i, (t, bound, gradient)) in self.rows.iter().enumerate() {
            let std = law.moments(0.0)?.0 * bound;
            let mut row = gradient.map(|g| g / std);
            if !independent {
                let mut line: Vec<f64> = Vec::with_capacity(i + 1);
                for (j, (before, other)) in factor.iter().zip(&self.rows).enumerate() {
                    let known: f64 = line.iter().zip(before).map(|(a, b)| a * b).sum();
                    line.push((law.moments(t - other.0)?.1 - known) / before[j]);
                }
                let pivot = (1.0 - line.iter().map(|v| v * v).sum::<f64>()).max(1e-12).sqrt();
                for (value, before) in line.iter().zip(&white) {
                    (0..3).for_each(|a| row[a] -= value * before[a]);
                }
                row = row.map(|v| v / pivot);
                line.push(pivot);
                factor.push(line);
            }
            white.push(row);
        }
        let entry = |a: usize, b: usize| white.iter().map(|row| row[a] * row[b]).sum::<f64>();
        let [xx, xy, xt, yy, yt, tt] = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)].map(|(a, b)| entry(a, b));
        // The position's information without the heading.
        let (a, b, c) = (xx - xt * xt / tt, xy - xt * yt / tt, yy - yt * yt / tt);
        let least = ((a + c) / (a * c - b * b)).sqrt();
        (least < OPEN).then_some(least)
    }
}
