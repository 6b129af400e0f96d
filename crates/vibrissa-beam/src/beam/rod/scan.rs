//! All roots of a function of one variable on a grid, folds between grid points included.

use super::super::root::{highest, root};
use alloc::vec::Vec;

/// The roots of `f` that the grid `at` reveals, rising; `f` is not a number where it has no value.
///
/// Found are: changes of sign between neighbours; pairs of roots around an extremum that a grid point comes near; roots
/// between the last grid point with a value and the end of the domain.
pub(super) fn roots(f: impl Fn(f64) -> f64, at: &[f64]) -> Vec<f64> {
    let values: Vec<f64> = at.iter().map(|&x| f(x)).collect();
    let mut nodes: Vec<(f64, f64)> = Vec::with_capacity(at.len() + 8);
    for (i, (&x, &v)) in at.iter().zip(&values).enumerate() {
        if i > 0 && v.is_nan() != values[i - 1].is_nan() {
            let (inside, outside) = if v.is_nan() { (at[i - 1], x) } else { (x, at[i - 1]) };
            let edge = edge(&f, inside, outside);
            nodes.push((edge, f(edge)));
        }
        nodes.push((x, v));
    }
    let mut found = Vec::new();
    for (i, &(x, v)) in nodes.iter().enumerate() {
        if v.abs() <= 0.0 {
            found.push(x);
        }
        let Some(&(x1, v1)) = nodes.get(i + 1) else { break };
        if v * v1 < 0.0 {
            found.extend(root(&f, x, x1));
        }
        if let Some(&(x2, v2)) = nodes.get(i + 2) {
            let dip = v * v1 > 0.0 && v1 * v2 > 0.0 && v1.abs() <= v.abs() && v1.abs() <= v2.abs();
            if dip {
                let sign = v1.signum();
                let top = highest(|x| -sign * f(x), x, x2);
                if sign * f(top) < 0.0 {
                    found.extend(root(&f, x, top));
                    found.extend(root(&f, top, x2));
                }
            }
        }
    }
    found
}

/// The points of the grid `at` where `|f|` is smaller than at both neighbours; next to where `f` is not a number, too.
pub(super) fn dips(f: impl Fn(f64) -> f64, at: &[f64]) -> Vec<f64> {
    let sizes: Vec<f64> = at.iter().map(|&x| f(x).abs()).collect();
    let size = |i: usize| sizes.get(i).filter(|v| !v.is_nan()).copied().unwrap_or(f64::INFINITY);
    let is_dip = |i: &usize| size(*i).is_finite() && size(*i) <= size(i.wrapping_sub(1)) && size(*i) <= size(i + 1);
    (0..at.len()).filter(is_dip).map(|i| at[i]).collect()
}

/// The last argument with a value on the way from `inside` to `outside`.
fn edge(f: &impl Fn(f64) -> f64, inside: f64, outside: f64) -> f64 {
    let (mut good, mut bad) = (inside, outside);
    for _ in 0..45 {
        let middle = 0.5 * (good + bad);
        if f(middle).is_nan() { bad = middle } else { good = middle }
    }
    good
}

/// `n` numbers from `first` on, each `factor` times the one before.
pub(super) fn geometric(first: f64, factor: f64, last: f64) -> Vec<f64> {
    let mut list = Vec::new();
    let mut x = first;
    while x < last {
        list.push(x);
        x *= factor;
    }
    list.push(last);
    list
}
