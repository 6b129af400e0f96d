//! Points near a place, by a grid of cells as wide as what counts as near: fixed-radius near neighbours \[bentley1975survey\].

use crate::plane::Vec2;
use std::collections::HashMap;

/// Points in cells, each with what it stands for.
#[derive(Clone, Debug)]
pub(crate) struct NearPoints<T> {
    radius: f64,
    cells: HashMap<(i64, i64), Vec<(Vec2, T)>>,
}

impl<T: Copy> NearPoints<T> {
    /// Of these points; what is no farther from a place than `radius` (m, above zero) is near.
    pub(crate) fn new(radius: f64, points: impl IntoIterator<Item = (Vec2, T)>) -> Self {
        let mut all = Self { radius, cells: HashMap::new() };
        for (point, what) in points {
            all.cells.entry(all.cell(point)).or_default().push((point, what));
        }
        all
    }

    /// All points near a place, and some that are farther away.
    pub(crate) fn around(&self, place: Vec2) -> impl Iterator<Item = (Vec2, T)> {
        let (i, j) = self.cell(place);
        let cells = (-1..=1).flat_map(move |di| (-1..=1).map(move |dj| (i.saturating_add(di), j.saturating_add(dj))));
        cells.filter_map(|cell| self.cells.get(&cell)).flatten().copied()
    }

    /// The point nearest to a place, if one is near.
    pub(crate) fn nearest(&self, place: Vec2) -> Option<(f64, T)> {
        let distances = self.around(place).map(|(point, what)| (point.distance(place), what));
        distances.filter(|(distance, _)| *distance <= self.radius).min_by(|a, b| a.0.total_cmp(&b.0))
    }

    fn cell(&self, point: Vec2) -> (i64, i64) {
        ((point.x / self.radius).floor() as i64, (point.y / self.radius).floor() as i64)
    }
}

#[cfg(test)]
mod tests {
    use super::NearPoints;
    use crate::plane::Vec2;

    #[test]
    fn the_nearest_point_is_that_of_all_pairs() {
        let mut state = 7_u64;
        let mut draw = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        let points: Vec<Vec2> = (0..500).map(|_| Vec2::new(draw(), draw())).collect();
        let near = NearPoints::new(0.03, points.iter().enumerate().map(|(k, p)| (*p, k)));
        let mut found = 0;
        for _ in 0..2000 {
            let place = Vec2::new(1.2 * draw(), 1.2 * draw());
            let distances = points.iter().map(|p| p.distance(place)).enumerate();
            let all = distances.min_by(|a, b| a.1.total_cmp(&b.1)).filter(|(_, distance)| *distance <= 0.03);
            assert_eq!(near.nearest(place).map(|(_, k)| k), all.map(|(k, _)| k));
            found += usize::from(all.is_some());
        }
        assert!((200..1800).contains(&found), "{found} of 2000 places have a point near");
    }

    #[test]
    fn places_beyond_all_numbers_of_cells_have_no_point_near() {
        let near = NearPoints::new(1e-3, [(Vec2::new(1e300, -1e300), ()), (Vec2::ZERO, ())]);
        assert!(near.nearest(Vec2::new(f64::NAN, f64::INFINITY)).is_none());
        assert!(near.nearest(Vec2::new(1e300, -1e300)).is_some());
    }
}
