//! Least-squares parabolas: the smoother of readings and of short pieces of wall.

/// `value(x) = a + b x + c x²`, fitted by least squares.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Quadratic {
    pub(crate) a: f64,
    pub(crate) b: f64,
    pub(crate) c: f64,
    /// Variance of `a` for unit variance of each sample.
    pub(crate) variance_a: f64,
    /// Variance of `b` for unit variance of each sample.
    pub(crate) variance_b: f64,
    /// Variance of `c` for unit variance of each sample.
    pub(crate) variance_c: f64,
}

impl Quadratic {
    /// The parabola that fits `points` best; a line for two points, a constant for one.
    ///
    /// None when the abscissas do not determine it.
    pub(crate) fn fit(points: impl Iterator<Item = (f64, f64)> + Clone) -> Option<Self> {
        let scale = points.clone().map(|(x, _)| x.abs()).fold(0.0, f64::max);
        if !(scale > 0.0 && scale.is_finite()) {
            return None;
        }
        let terms = points.clone().count().min(3);
        // Normal equations in x / scale, as an augmented matrix with the unit matrix for the inverse.
        let mut rows = [[0.0; 7]; 3];
        for (x, y) in points {
            let u = x / scale;
            let powers = [1.0, u, u * u];
            for i in 0..terms {
                for j in 0..terms {
                    rows[i][j] += powers[i] * powers[j];
                }
                rows[i][3] += powers[i] * y;
            }
        }
        for (i, row) in rows.iter_mut().enumerate() {
            row[4 + i] = 1.0;
        }
        eliminate(&mut rows, terms)?;
        let [a, b, c] = [rows[0][3], rows[1][3] / scale, rows[2][3] / (scale * scale)];
        Some(Self {
            a,
            b,
            c,
            variance_a: rows[0][4],
            variance_b: rows[1][5] / scale.powi(2),
            variance_c: rows[2][6] / scale.powi(4),
        })
    }

    pub(crate) fn at(&self, x: f64) -> f64 {
        self.a + x * (self.b + x * self.c)
    }
}

/// Gauss-Jordan elimination with row pivoting on the leading `terms` unknowns: one to three, the solution and the inverse at once.
/// Not by a factorization, so that smoothed readings stay the same to the last bit.
fn eliminate(rows: &mut [[f64; 7]; 3], terms: usize) -> Option<()> {
    for i in 0..terms {
        let pivot = (i..terms).max_by(|&p, &q| rows[p][i].abs().total_cmp(&rows[q][i].abs()))?;
        if rows[pivot][i].abs() < 1e-12 {
            return None;
        }
        rows.swap(i, pivot);
        let lead = rows[i][i];
        rows[i].iter_mut().for_each(|v| *v /= lead);
        let source = rows[i];
        for (k, row) in rows.iter_mut().enumerate() {
            if k != i && k < terms {
                let factor = row[i];
                row.iter_mut().zip(source).for_each(|(v, s)| *v -= factor * s);
            }
        }
    }
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn recovers_parabolas_and_their_variances() {
        let truth = |x: f64| 2.0 - 3e3 * x + 7e5 * x * x;
        let xs: Vec<f64> = (0..21).map(|i| (f64::from(i) - 10.0) * 1e-3).collect();
        let fit = Quadratic::fit(xs.iter().map(|&x| (x, truth(x)))).expect("determined");
        assert!((fit.a - 2.0).abs() < 1e-9 && (fit.b + 3e3).abs() < 1e-6 && (fit.c - 7e5).abs() < 1e-3);
        // Textbook values for n equidistant points: 9/(4 n) for large n, and 1/sum(x²) for the slope.
        let sum: f64 = xs.iter().map(|x| x * x).sum();
        assert!((fit.variance_b - 1.0 / sum).abs() < 1e-9 / sum);
        let (m, n) = (10.0, 21.0);
        let exact = (3.0 * m * m + 3.0 * m - 1.0) / (n * (2.0 * m - 1.0) * (2.0 * m + 3.0)) * 3.0;
        assert!((fit.variance_a - exact).abs() < 1e-9, "{} {exact}", fit.variance_a);
    }

    #[test]
    fn falls_back_to_lines_and_refuses_what_is_undetermined() {
        let line = Quadratic::fit([(-1.0, 3.0), (1.0, 5.0)].into_iter()).expect("a line");
        assert!((line.a - 4.0).abs() < 1e-12 && (line.b - 1.0).abs() < 1e-12 && line.c.abs() < 1e-12);
        assert!(Quadratic::fit([(0.0, 3.0), (0.0, 5.0)].into_iter()).is_none());
        assert!(Quadratic::fit([(1.0, 1.0), (1.0, 2.0), (1.0, 3.0)].into_iter()).is_none());
        assert!(Quadratic::fit(core::iter::empty()).is_none());
    }
}
