//! Pictures of polygons, painted by counting: every cell is asked at many places whether it is inside.

use vibrissa::plane::Vec2;

/// A picture of a free polygon in solid surroundings.
pub(crate) struct Painter<'a> {
    pub(crate) width: usize,
    pub(crate) height: usize,
    /// Side of a cell (m).
    pub(crate) cell: f64,
    /// The corners of the free polygon (m), from the lower left corner of the picture.
    pub(crate) free: &'a [Vec2],
    /// Whether a cell is as grey as it is solid, or as its middle.
    pub(crate) smooth: bool,
}

/// Places along each side of a cell.
const FINE: usize = 16;

impl Painter<'_> {
    /// Whether a point is inside, by the crossings of a ray.
    pub(crate) fn is_free(&self, p: Vec2) -> bool {
        let mut inside = false;
        for i in 0..self.free.len() {
            let (a, b) = (self.free[i], self.free[(i + 1) % self.free.len()]);
            if (a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x) {
                inside = !inside;
            }
        }
        inside
    }

    /// The solid share of a cell, row 0 at the bottom.
    pub(crate) fn share(&self, x: usize, y: usize) -> f64 {
        let at = |i: f64, j: f64| self.is_free(Vec2::new((x as f64 + i) * self.cell, (y as f64 + j) * self.cell));
        if !self.smooth {
            return f64::from(u8::from(!at(0.5, 0.5)));
        }
        let corners = [at(0.0, 0.0), at(1.0, 0.0), at(0.0, 1.0), at(1.0, 1.0), at(0.5, 0.5)];
        if corners.iter().all(|c| *c == corners[0]) {
            return f64::from(u8::from(!corners[0]));
        }
        let middle = |k: usize| (k as f64 + 0.5) / FINE as f64;
        let free = (0..FINE * FINE).filter(|k| at(middle(k % FINE), middle(k / FINE))).count();
        1.0 - free as f64 / (FINE * FINE) as f64
    }
}

/// The picture as a PGM file: solid is black.
pub(crate) fn pgm(painter: &Painter) -> Vec<u8> {
    let mut bytes = format!("P5\n{} {}\n255\n", painter.width, painter.height).into_bytes();
    for y in (0..painter.height).rev() {
        bytes.extend((0..painter.width).map(|x| (255.0 * (1.0 - painter.share(x, y))).round() as u8));
    }
    bytes
}
