//! Rotational symmetries of a map, and the share of it that represents all \[atallah1985symmetry\].
//!
//! In a square room no log tells four places apart. What one of them explains the others explain, row by row, so one is
//! followed for all, and at the end each is reported with the same weight.

use crate::contact::Boundaries;
use crate::plane::{Pose2, Vec2};
use core::f64::consts::TAU;

/// Boundaries that lie so near to a turned one (m) are the same: as exactly as the model is believed to know them.
const SAME: f64 = 5e-5;
/// The most often that a map is looked at for, per full turn.
const MOST: usize = 12;
/// Where the share of the boundary that is searched begins (rad): nowhere near an axis of a map that lies straight.
const BEGIN: f64 = 0.123_456_7;

/// A turn of the map onto itself.
#[derive(Clone, Debug)]
pub(super) struct MapSymmetry {
    pub(super) motion: Pose2,
    /// The piece that each piece comes to lie on.
    pieces: Vec<u32>,
}

impl MapSymmetry {
    /// The piece on which this one comes to lie; its corners go by the same number.
    pub(super) fn piece(&self, piece: u32) -> u32 {
        self.pieces.get(piece as usize).copied().unwrap_or(piece)
    }
}

/// All turns of a map onto itself but the one by nothing.
#[derive(Clone, Debug, Default)]
pub(super) struct MapSymmetries {
    pub(super) all: Vec<MapSymmetry>,
    center: Vec2,
}

impl MapSymmetries {
    /// The turns of a map of outlines; of one with thin walls, or known only within bands, none are looked for.
    pub(super) fn of(ground: &Boundaries) -> Self {
        let mut middle = (0.0, Vec2::ZERO);
        for piece in &ground.pieces {
            let (a, b) = (piece.spot(0.0).position, piece.spot(1.0).position);
            let chord = a.distance(b);
            middle = (middle.0 + chord, middle.1 + (a + b) * (0.5 * chord));
        }
        if ground.has_ends() || !ground.are_exact() || middle.0 <= 0.0 {
            return Self::default();
        }
        let center = middle.1 * (1.0 / middle.0);
        let ends = PieceStarts::of(ground);
        for order in (2..=MOST).rev() {
            let symmetries = (1..order).map(|k| ends.symmetry_by(ground, center, k as f64 * TAU / order as f64));
            if let Some(all) = symmetries.collect::<Option<Vec<MapSymmetry>>>() {
                return Self { all, center };
            }
        }
        Self::default()
    }

    /// How many places of the map look alike.
    pub(super) fn order(&self) -> usize {
        self.all.len() + 1
    }

    /// Whether a place is in the share of the map that stands for all.
    pub(super) fn is_representative(&self, place: Vec2) -> bool {
        (place - self.center).rotated(-BEGIN).angle().rem_euclid(TAU) * (self.order() as f64) < TAU
    }

    /// A frame and its images.
    pub(super) fn images(&self, frame: Pose2) -> impl Iterator<Item = Pose2> {
        core::iter::once(frame).chain(self.all.iter().map(move |turn| turn.motion.compose(frame)))
    }
}

/// The pieces in the order of where they start.
struct PieceStarts {
    by_x: Vec<(f64, u32)>,
}

impl PieceStarts {
    fn of(ground: &Boundaries) -> Self {
        let mut by_x: Vec<(f64, u32)> =
            ground.pieces.iter().enumerate().map(|(i, piece)| (piece.spot(0.0).position.x, i as u32)).collect();
        by_x.sort_by(|a, b| a.0.total_cmp(&b.0));
        Self { by_x }
    }

    /// The turn by this angle, if it takes every piece onto one.
    fn symmetry_by(&self, ground: &Boundaries, center: Vec2, angle: f64) -> Option<MapSymmetry> {
        let place = center - center.rotated(angle);
        let motion = Pose2::new(place.x, place.y, angle);
        let moved = |piece: u32| {
            let here = &ground.pieces[piece as usize];
            let three = [0.0, 0.5, 1.0].map(|at| motion.transform_point(here.spot(at).position));
            let from = self.by_x.partition_point(|&(x, _)| x < three[0].x - SAME);
            let near = self.by_x[from..].iter().take_while(|&&(x, _)| x <= three[0].x + SAME);
            let same = |&&(_, other): &&(f64, u32)| {
                let there = &ground.pieces[other as usize];
                let apart = |(at, place): (f64, Vec2)| there.spot(at).position.distance(place) <= SAME;
                there.side() * here.side() > 0.0 && [0.0, 0.5, 1.0].into_iter().zip(three).all(apart)
            };
            near.into_iter().find(same).map(|&(_, other)| other)
        };
        let pieces = (0..ground.pieces.len() as u32).map(moved).collect::<Option<Vec<u32>>>()?;
        Some(MapSymmetry { motion, pieces })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

    use super::*;
    use crate::plane::Curve;
    use crate::world::{Boundary, Map, Role};

    fn room(corners: &[(f64, f64)]) -> Boundaries {
        let corners: Vec<Vec2> = corners.iter().map(|&(x, y)| Vec2::new(x, y).rotated(0.3)).collect();
        let outline = Boundary::new(Role::Arena, Curve::polyline(&corners, true).unwrap(), None).unwrap();
        Boundaries::new(&Map::new(vec![outline]).unwrap())
    }

    #[test]
    fn squares_rectangles_and_others_are_told_apart() {
        let order = |corners: &[(f64, f64)]| MapSymmetries::of(&room(corners)).order();
        assert_eq!(order(&[(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]), 4);
        assert_eq!(order(&[(0.0, 0.0), (1.0, 0.0), (1.0, 0.7), (0.0, 0.7)]), 2);
        // A millimetre is enough to tell them apart, and so is one corner more.
        assert_eq!(order(&[(0.0, 0.0), (1.0, 0.0), (1.0, 0.701), (0.0, 0.7)]), 1);
        assert_eq!(order(&[(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.5, 1.01), (0.0, 1.0)]), 1);
        // A pinwheel turns, though it has no mirror image.
        let arm = [(0.5, 0.0), (0.5, 0.3), (0.3, 0.3)];
        let wheel: Vec<(f64, f64)> = (0..4)
            .flat_map(|k| arm.map(|(x, y)| Vec2::new(x, y).rotated(f64::from(k) * TAU / 4.0)))
            .map(|p| (p.x, p.y))
            .collect();
        assert_eq!(order(&wheel), 4);
    }

    #[test]
    fn one_share_of_the_places_stands_for_all() {
        let ground = room(&[(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]);
        let symmetries = MapSymmetries::of(&ground);
        for piece in 0..4 {
            for at in [0.01, 0.3, 0.62, 0.97] {
                let spot = ground.pieces[piece].spot(at).position;
                let standing = symmetries.images(Pose2::new(spot.x, spot.y, 0.0));
                assert_eq!(standing.filter(|image| symmetries.is_representative(image.position())).count(), 1);
                for turn in &symmetries.all {
                    let there = ground.pieces[turn.piece(piece as u32) as usize].spot(at).position;
                    assert!(there.distance(turn.motion.transform_point(spot)) < 1e-12);
                }
            }
        }
    }
}
