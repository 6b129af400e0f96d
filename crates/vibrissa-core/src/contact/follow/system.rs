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
        let determinant = dot(m[0], cofactors[0]);
        Self { cofactors, determinant }
    }

    /// `x` with `M x = r`; none when it is not finite.
    pub(super) fn solve(&self, r: [f64; 3]) -> Option<[f64; 3]> {
        let per = 1.0 / self.determinant;
        let c = &self.cofactors;
        let x = |j: usize| per * (c[0][j] * r[0] + c[1][j] * r[1] + c[2][j] * r[2]);
        let x = [x(0), x(1), x(2)];
        (x[0].is_finite() && x[1].is_finite() && x[2].is_finite()).then_some(x)
    }

    /// `l` with `Mᵀ l = r`.
    pub(super) fn solve_transposed(&self, r: [f64; 3]) -> [f64; 3] {
        let per = 1.0 / self.determinant;
        let x = |i: usize| per * dot(self.cofactors[i], r);
        [x(0), x(1), x(2)]
    }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
