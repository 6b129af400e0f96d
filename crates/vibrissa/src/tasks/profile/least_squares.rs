//! Small least-squares problems with numeric derivatives.

/// Most rounds.
const ROUNDS: usize = 60;

/// The unknowns that make the sum of the squared residuals smallest next to `start`, by Levenberg and Marquardt; `steps`
/// are the unknowns' natural sizes.
pub(super) fn least_squares(start: &[f64], steps: &[f64], residuals: &dyn Fn(&[f64]) -> Vec<f64>) -> Vec<f64> {
    let mut x = start.to_vec();
    let mut now = residuals(&x);
    let mut damping = 1e-4;
    for _ in 0..ROUNDS {
        let columns: Vec<Vec<f64>> = (0..x.len()).map(|k| column(&x, k, 1e-5 * steps[k], residuals)).collect();
        let before = square(&now);
        let moved = loop {
            let step = damped(&columns, &now, damping);
            let next: Vec<f64> = x.iter().zip(&step).map(|(x, s)| x - s).collect();
            let there = residuals(&next);
            if square(&there) <= before {
                break Some((next, there));
            }
            damping *= 8.0;
            if damping > 1e10 {
                break None;
            }
        };
        let Some((next, there)) = moved else { break };
        (x, now) = (next, there);
        damping *= 0.1;
        if before - square(&now) <= 1e-10 * before {
            break;
        }
    }
    x
}

fn square(values: &[f64]) -> f64 {
    let sum: f64 = values.iter().map(|v| v * v).sum();
    if sum.is_nan() { f64::INFINITY } else { sum }
}

fn column(x: &[f64], k: usize, step: f64, residuals: &dyn Fn(&[f64]) -> Vec<f64>) -> Vec<f64> {
    let at = |by: f64| {
        let mut moved = x.to_vec();
        moved[k] += by;
        residuals(&moved)
    };
    at(step).iter().zip(at(-step)).map(|(plus, minus)| (plus - minus) / (2.0 * step)).collect()
}

/// The step of the damped normal equations, by Gaussian elimination (they are positive definite).
fn damped(columns: &[Vec<f64>], residuals: &[f64], damping: f64) -> Vec<f64> {
    let n = columns.len();
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut rows: Vec<Vec<f64>> = (0..n)
        .map(|i| {
            let mut row: Vec<f64> = (0..n).map(|j| dot(&columns[i], &columns[j])).collect();
            row[i] = row[i] * (1.0 + damping) + 1e-30;
            row.push(dot(&columns[i], residuals));
            row
        })
        .collect();
    for i in 0..n {
        let pivot = rows[i].clone();
        for row in rows.iter_mut().skip(i + 1) {
            let factor = row[i] / pivot[i];
            row.iter_mut().zip(&pivot).for_each(|(value, p)| *value -= factor * p);
        }
    }
    let mut step = vec![0.0; n];
    for i in (0..n).rev() {
        let known: f64 = (i + 1..n).map(|j| rows[i][j] * step[j]).sum();
        step[i] = (rows[i][n] - known) / rows[i][i];
    }
    step
}
