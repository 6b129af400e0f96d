//! Normal equations in three unknowns: what readings say about a small move of the odometry frame.

/// A symmetric matrix over (x, y, theta).
pub(super) type Matrix = [[f64; 3]; 3];

/// Variances of a frame that does not move at all (m², rad²).
const STILL: [f64; 3] = [1e-14, 1e-14, 1e-12];

/// A quadratic cost around a point: `cost + gradient·d + d·curvature·d / 2`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Normal {
    pub(super) curvature: Matrix,
    pub(super) gradient: [f64; 3],
    pub(super) cost: f64,
    /// The same for a relative error that all readings share: mixed, own curvature, own gradient.
    pub(super) mixed: [f64; 3],
    pub(super) shared: [f64; 2],
}

/// One reading: its residual (times the root of its weight: in standard deviations), and its derivatives by a move and by a
/// relative error that all readings share.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line {
    pub(super) residual: f64,
    pub(super) by: [f64; 3],
    pub(super) by_shared: f64,
    pub(super) weight: f64,
}

impl Normal {
    /// Adds a reading.
    pub(super) fn add(&mut self, line: Line) {
        let Line { residual, by, by_shared, weight } = line;
        self.shared[0] += weight * by_shared * by_shared;
        self.shared[1] += weight * by_shared * residual;
        for i in 0..3 {
            let scaled = weight * by[i];
            self.mixed[i] += scaled * by_shared;
            self.gradient[i] += scaled * residual;
            (0..3).for_each(|j| self.curvature[i][j] += scaled * by[j]);
        }
    }

    /// The same cost around the point moved by `d`.
    pub(super) fn moved(&self, d: [f64; 3]) -> Self {
        let along = times(&self.curvature, d);
        let gradient = [0, 1, 2].map(|i| self.gradient[i] + along[i]);
        let cost = self.cost + dot(self.gradient, d) + 0.5 * dot(along, d);
        let shared = [self.shared[0], self.shared[1] + dot(self.mixed, d)];
        Self { gradient, cost, shared, ..*self }
    }

    /// The same in a map that is turned by this angle.
    pub(super) fn turned(&self, angle: f64) -> Self {
        let (sin, cos) = angle.sin_cos();
        let vector = |v: [f64; 3]| [cos * v[0] - sin * v[1], sin * v[0] + cos * v[1], v[2]];
        // Rows first, then columns.
        let rows = self.curvature.map(vector);
        let columns = [0, 1, 2].map(|j| vector([rows[0][j], rows[1][j], rows[2][j]]));
        let curvature = [0, 1, 2].map(|i: usize| [0, 1, 2].map(|j: usize| columns[j][i]));
        Self { curvature, gradient: vector(self.gradient), mixed: vector(self.mixed), ..*self }
    }

    /// The same knowledge with this share of its weight, where what it costs here stays.
    pub(super) fn faded(&self, share: f64) -> Self {
        Self {
            curvature: self.curvature.map(|row| row.map(|v| share * v)),
            gradient: self.gradient.map(|v| share * v),
            cost: self.cost,
            mixed: self.mixed.map(|v| share * v),
            shared: self.shared.map(|v| share * v),
        }
    }

    /// The same knowledge after the frame has made a random move of this covariance.
    pub(super) fn loosened(&self, covariance: &Matrix) -> Self {
        let Some(w) = self.leeway(covariance) else { return *self };
        let (wg, wm) = (times(&w, self.gradient), times(&w, self.mixed));
        let wa = [0, 1, 2].map(|j| times(&w, [self.curvature[0][j], self.curvature[1][j], self.curvature[2][j]]));
        let mut out = *self;
        for i in 0..3 {
            out.gradient[i] -= dot(self.curvature[i], wg);
            out.mixed[i] -= dot(self.curvature[i], wm);
            (0..3).for_each(|j| out.curvature[i][j] -= dot(self.curvature[i], wa[j]));
        }
        out.shared[0] -= dot(self.mixed, wm);
        out.shared[1] -= dot(self.mixed, wg);
        out.cost -= 0.5 * dot(self.gradient, wg);
        out
    }

    /// The covariance of a random move that had this one, once the readings are known: `(Q⁻¹ + A)⁻¹`, with something added to
    /// each for the sake of directions that are known too well or not at all.
    pub(super) fn leeway(&self, covariance: &Matrix) -> Option<Matrix> {
        let mut own = *covariance;
        (0..3).for_each(|i| own[i][i] += STILL[i]);
        let mut sum = inverse(&own)?;
        add(&mut sum, &self.curvature);
        inverse(&sum)
    }

    /// The cost with the shared error, of this standard deviation before any reading, at its best for every move: as if
    /// it were a correlated part of the noise.
    pub(super) fn marginal(&self, std: f64) -> Self {
        if std <= 0.0 {
            return Self { mixed: [0.0; 3], shared: [0.0; 2], ..*self };
        }
        let per = 1.0 / (self.shared[0] + 1.0 / (std * std));
        let mut out = Self { mixed: [0.0; 3], shared: [0.0; 2], ..*self };
        // Half the logarithm of the determinant that integrating over it leaves.
        out.cost += 0.5 * (1.0 + self.shared[0] * std * std).ln() - 0.5 * self.shared[1] * self.shared[1] * per;
        for i in 0..3 {
            out.gradient[i] -= self.mixed[i] * self.shared[1] * per;
            for j in 0..3 {
                out.curvature[i][j] -= self.mixed[i] * self.mixed[j] * per;
            }
        }
        out
    }

    /// The step to the least cost when `damping` is added to the diagonal.
    pub(super) fn step(&self, damping: [f64; 3]) -> Option<[f64; 3]> {
        let inverse = inverse(&self.damped(damping))?;
        Some(times(&inverse, self.gradient).map(|v| -v))
    }

    /// The least cost that it promises, and the step there, with `damping` and a shared error of this standard deviation.
    pub(super) fn best(&self, damping: [f64; 3], shared: f64) -> (f64, [f64; 3]) {
        let normal = self.marginal(shared);
        match normal.step(damping) {
            Some(d) => (normal.moved(d).cost, d),
            None => (normal.cost, [0.0; 3]),
        }
    }

    /// The curvature with `damping` added to its diagonal.
    pub(super) fn damped(&self, damping: [f64; 3]) -> Matrix {
        let mut matrix = self.curvature;
        (0..3).for_each(|i| matrix[i][i] += damping[i]);
        matrix
    }
}

pub(super) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn times(m: &Matrix, v: [f64; 3]) -> [f64; 3] {
    m.map(|row| dot(row, v))
}

/// The covariance of `t v` where `v` has this one.
pub(super) fn congruent(t: &Matrix, covariance: &Matrix) -> Matrix {
    let rows = t.map(|row| times(covariance, row));
    t.map(|left| rows.map(|right| dot(left, right)))
}

/// The lower triangular root of a symmetric positive matrix.
pub(super) fn root<const N: usize>(m: &[[f64; N]; N]) -> Option<[[f64; N]; N]> {
    let mut l = [[0.0; N]; N];
    for i in 0..N {
        for j in 0..=i {
            let rest = m[i][j] - (0..j).map(|k| l[i][k] * l[j][k]).sum::<f64>();
            l[i][j] = if i == j { rest.sqrt() } else { rest / l[j][j] };
            l[i][j].is_finite().then_some(())?;
        }
    }
    Some(l)
}

/// Adds a matrix to another.
pub(super) fn add(to: &mut Matrix, more: &Matrix) {
    (0..3).for_each(|i| (0..3).for_each(|j| to[i][j] += more[i][j]));
}

pub(super) fn determinant(m: &Matrix) -> f64 {
    m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
        + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])
}

/// The inverse of a symmetric positive matrix, scaled first so that metres and radians do not spoil it.
pub(super) fn inverse(m: &Matrix) -> Option<Matrix> {
    let scale = [0, 1, 2].map(|i: usize| m[i][i].sqrt().recip());
    if !scale.iter().all(|s| s.is_finite() && *s > 0.0) {
        return None;
    }
    let mut n = *m;
    (0..3).for_each(|i| (0..3).for_each(|j| n[i][j] *= scale[i] * scale[j]));
    let det = determinant(&n);
    if det.is_nan() || det <= 1e-15 {
        return None;
    }
    let cofactor = |i: usize, j: usize| {
        let (a, b, c, d) = ((i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3);
        n[a][c] * n[b][d] - n[a][d] * n[b][c]
    };
    let mut out = [[0.0; 3]; 3];
    for (i, row) in out.iter_mut().enumerate() {
        for (j, value) in row.iter_mut().enumerate() {
            *value = cofactor(j, i) / det * scale[i] * scale[j];
        }
    }
    Some(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_root_times_itself_is_the_matrix() {
        let m = [[4.0, 1.0, -0.5, 0.3], [1.0, 2.0, 0.3, 0.0], [-0.5, 0.3, 1.0, -0.2], [0.3, 0.0, -0.2, 0.7]];
        let l = root(&m).unwrap_or_default();
        for i in 0..4 {
            for j in 0..4 {
                let product: f64 = (0..4).map(|k| l[i][k] * l[j][k]).sum();
                assert!((product - m[i][j]).abs() < 1e-12 && (j <= i || l[i][j] == 0.0));
            }
        }
        assert!(root(&[[1.0, 2.0], [2.0, 1.0]]).is_none());
    }

    #[test]
    fn a_random_move_adds_to_the_covariance() {
        // Knowledge of x, y and heading with a shared error; by hand: covariance of the marginal plus that of the move,
        // least cost where it was.
        let mut normal = Normal::default();
        for (by, shared) in
            [([1e3, 2e2, 5.0], 0.3), ([0.0, 8e2, -9.0], -0.2), ([3e2, -5e2, 20.0], 0.5), ([5e2, 1e2, 1.0], 0.1)]
        {
            normal.add(Line { residual: 0.4 - shared, by, by_shared: shared, weight: 1.0 });
        }
        let q = [[4e-6, 1e-6, 0.0], [1e-6, 9e-6, 2e-5], [0.0, 2e-5, 4e-4]];
        let (before, after) = (normal.marginal(0.5), normal.loosened(&q).marginal(0.5));
        let (mut wanted, found) =
            (inverse(&before.curvature).unwrap_or_default(), inverse(&after.curvature).unwrap_or_default());
        add(&mut wanted, &q);
        (0..3).for_each(|i| {
            (0..3).for_each(|j| {
                let scale = (wanted[i][i] * wanted[j][j]).sqrt();
                assert!((found[i][j] - wanted[i][j]).abs() < 1e-6 * scale, "{found:?} {wanted:?}");
            })
        });
        let (a, b) = (before.step([0.0; 3]).unwrap_or_default(), after.step([0.0; 3]).unwrap_or_default());
        (0..3).for_each(|i| assert!((a[i] - b[i]).abs() < 1e-5 * wanted[i][i].sqrt(), "{a:?} {b:?}"));
    }

    #[test]
    fn the_step_goes_to_the_least_cost() {
        let mut normal = Normal::default();
        // Three planes meet at (1e-3, -2e-3, 0.5) by hand.
        let at = [1e-3, -2e-3, 0.5];
        for by in [[1e3, 0.0, 2.0], [0.0, 2e3, -1.0], [5e2, 5e2, 1.0]] {
            normal.add(Line { residual: -dot(by, at), by, by_shared: 0.0, weight: 1.0 });
            normal.cost += 0.5 * dot(by, at).powi(2);
        }
        let step = normal.step([0.0; 3]).unwrap_or_default();
        (0..3).for_each(|i| assert!((step[i] - at[i]).abs() < 1e-12, "{step:?}"));
        assert!(normal.moved(at).cost.abs() < 1e-12);
        assert!(Normal::default().step([0.0; 3]).is_none());
    }
}
