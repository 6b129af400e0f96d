// Gragg's extrapolation method, for tests that want an integrator of their own.

/// The right side of an ordinary differential equation.
pub(crate) type RightSide<'a> = &'a dyn Fn(f64, [f64; 3]) -> [f64; 3];

/// One step of `h` from `(s, y)`, extrapolated to order 16.
fn step(f: RightSide<'_>, s: f64, y: [f64; 3], h: f64) -> [f64; 3] {
    let add = |a: [f64; 3], c: f64, b: [f64; 3]| [0, 1, 2].map(|i| a[i] + c * b[i]);
    let mut table: Vec<[f64; 3]> = Vec::new();
    for k in 1..=8 {
        let n = 2 * k;
        let d = h / f64::from(n);
        let (mut before, mut now) = (y, add(y, d, f(s, y)));
        for i in 1..n {
            (before, now) = (now, add(before, 2.0 * d, f(s + d * f64::from(i), now)));
        }
        let mut column = add(add(before, 1.0, now), d, f(s + h, now)).map(|v| 0.5 * v);
        for (j, slot) in table.iter_mut().enumerate() {
            let ratio = f64::from(k) / f64::from(k - 1 - j as i32);
            let previous = *slot;
            *slot = column;
            column = add(column, 1.0 / (ratio * ratio - 1.0), add(column, -1.0, previous));
        }
        // Entry j is the newest of column j; the last is of highest order.
        table.push(column);
    }
    table[7]
}

/// The solution at `end` from `y` at `start`, in `steps` steps.
pub(crate) fn integrate(f: RightSide<'_>, y: [f64; 3], start: f64, end: f64, steps: usize) -> [f64; 3] {
    let h = (end - start) / steps as f64;
    (0..steps).fold(y, |v, i| step(f, start + h * i as f64, v, h))
}
