//! Three linear equations.

/// Three linear equations, by cofactors.
pub(super) struct System {
    cofactors: [[f64; 3]; 3],
    pub(super) determinant: f64,
}

impl System {
    pub(super) fn new(m: [[f64; 3]; 3]) -> Self {
        let c = |i: usize, j: usize| {
            let (a, b) = ((i + 1) % 3, (i + 2) % 3);
            let (d, e) = ((j + 1) % 3, (j + 2) % 3);
            m[a][d] * m[b][e] - m[a][e] * m[b][d]
        };
        let cofactors = [[c(0, 0), c(0, 1), c(0, 2)], [c(1, 0), c(1, 1), c(1, 2)], [c(2, 0), c(2, 1), c(2, 2)]];
        let determinant = (0..3).map(|j| m[0][j] * cofactors[0][j]).sum();
        Self { cofactors, determinant }
    }

    /// `x` with `M x = r`; none when it is not finite.
    pub(super) fn solve(&self, r: [f64; 3]) -> Option<[f64; 3]> {
        let per = 1.0 / self.determinant;
        let x = [0, 1, 2].map(|j| per * (0..3).map(|i| self.cofactors[i][j] * r[i]).sum::<f64>());
        x.iter().all(|v| v.is_finite()).then_some(x)
    }

    /// `l` with `Mᵀ l = r`.
    pub(super) fn solve_transposed(&self, r: [f64; 3]) -> [f64; 3] {
        let per = 1.0 / self.determinant;
        [0, 1, 2].map(|i| per * (0..3).map(|j| self.cofactors[i][j] * r[j]).sum::<f64>())
    }
}
