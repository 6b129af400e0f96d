//! Vectors in space.

pub(crate) type Vec3 = [f64; 3];

pub(crate) fn cross(a: Vec3, b: Vec3) -> Vec3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// `a + by b`.
pub(crate) fn plus(a: Vec3, b: Vec3, by: f64) -> Vec3 {
    [0, 1, 2].map(|k| a[k] + by * b[k])
}

pub(crate) fn dot(a: Vec3, b: Vec3) -> f64 {
    (0..3).map(|k| a[k] * b[k]).sum()
}
