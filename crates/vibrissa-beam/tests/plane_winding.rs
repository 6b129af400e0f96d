//! Windings of outlines against the angle that they sweep, edge by edge.

#[path = "../../vibrissa/tests/data/random.rs"]
mod random;

use core::f64::consts::TAU;
use random::Random;
use vibrissa_beam::plane::{Vec2, WindingTree};

/// The sum of the angles under which the edges are seen, in turns.
fn swept(outlines: &[Vec<Vec2>], p: Vec2) -> f64 {
    let angle = |w: &[Vec2]| (w[0] - p).cross(w[1] - p).atan2((w[0] - p).dot(w[1] - p));
    outlines.iter().flat_map(|o| o.windows(2)).map(angle).sum::<f64>() / TAU
}

/// A closed chain of random corners, which crosses itself as it likes; on a grid, many corners lie at one height.
fn outline(random: &mut Random, corners: usize, on_grid: bool) -> Vec<Vec2> {
    let center = Vec2::new(random.signed(8.0), random.signed(8.0));
    let mut chain: Vec<Vec2> = (0..corners)
        .map(|_| {
            let p = center + Vec2::new(random.signed(3.0), random.signed(3.0));
            if on_grid { Vec2::new(p.x.round(), p.y.round()) } else { p }
        })
        .collect();
    chain.extend(chain.first().copied());
    chain
}

#[test]
fn windings_are_the_angles_swept() {
    let mut random = Random(5);
    for round in 0..60 {
        let on_grid = round % 2 == 0;
        let outlines: Vec<Vec<Vec2>> = (0..1 + round % 9).map(|k| outline(&mut random, 3 + 7 * k, on_grid)).collect();
        let tree = WindingTree::new(&outlines);
        let mut wound = 0;
        for _ in 0..200 {
            // Heights of corners, but never a point of an edge on the grid's lines.
            let p = Vec2::new(random.signed(12.0), random.signed(12.0));
            let p = if on_grid { Vec2::new(p.x.round() + 0.123_456_789, p.y.round()) } else { p };
            let turns = swept(&outlines, p);
            let on_edge = |w: &[Vec2]| (w[0] - p).cross(w[1] - p).abs() < 1e-9 && (w[0] - p).dot(w[1] - p) <= 0.0;
            if outlines.iter().flat_map(|o| o.windows(2)).any(on_edge) {
                continue;
            }
            assert!((f64::from(tree.winding(p)) - turns).abs() < 1e-6, "{p:?}: {turns} turns");
            wound += usize::from(turns.abs() > 0.5);
        }
        assert!(wound > 0 || outlines.len() < 3, "no point is inside");
    }
}

#[test]
fn no_outline_winds_around_nothing() {
    assert_eq!(WindingTree::new(&[]).winding(Vec2::ZERO), 0);
    assert_eq!(WindingTree::new(&[vec![], vec![Vec2::ZERO]]).winding(Vec2::ZERO), 0);
    assert_eq!(WindingTree::default().winding(Vec2::new(f64::NAN, f64::INFINITY)), 0);
}
