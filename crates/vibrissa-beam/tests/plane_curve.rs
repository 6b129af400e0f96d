//! Curves against fine polylines, circles and quadrature.

#![allow(clippy::unwrap_used, reason = "helpers of tests may fail like tests")]

#[path = "../../vibrissa/tests/data/random.rs"]
mod random;

use random::Random;
use std::f64::consts::{PI, TAU};
use vibrissa_beam::plane::{Curve, Segment, Vec2, arc_to_cubics, wrap_angle};

fn points(random: &mut Random, count: usize) -> Vec<Vec2> {
    (0..count).map(|_| Vec2::new(random.signed(2.0), random.signed(2.0))).collect()
}

/// A chain of a line, a quadratic and a cubic.
fn chain(random: &mut Random) -> Curve {
    let p = points(random, 7);
    let segments = vec![
        Segment::Line([p[0], p[1]]),
        Segment::Quadratic([p[1], p[2], p[3]]),
        Segment::Cubic([p[3], p[4], p[5], p[6]]),
    ];
    Curve::from_segments(segments, false).unwrap()
}

/// De Casteljau's construction, for control points of any number.
fn bezier(p: &[Vec2], t: f64) -> Vec2 {
    let mut p = p.to_vec();
    while p.len() > 1 {
        p = p.windows(2).map(|w| w[0] * (1.0 - t) + w[1] * t).collect();
    }
    p[0]
}

#[test]
fn length_points_and_tangents() {
    let mut random = Random(4);
    for _ in 0..20 {
        let curve = chain(&mut random);
        let fine: Vec<Vec2> = curve
            .segments()
            .iter()
            .flat_map(|s| (0..20_000).map(|k| bezier(s.control_points(), f64::from(k) / 20_000.0)))
            .chain([curve.segments()[2].end()])
            .collect();
        let mut along = vec![0.0];
        for w in fine.windows(2) {
            along.push(along.last().unwrap() + w[0].distance(w[1]));
        }
        let total = *along.last().unwrap();
        assert!((curve.length() - total).abs() < 1e-6 * total, "{} {total}", curve.length());
        for k in [137, 9_999, 20_300, 31_000, 45_000, 59_990] {
            let at = curve.at(along[k]);
            assert!(at.position.distance(fine[k]) < 1e-5, "{k}");
            // Cusps turn too fast for differences; skip them.
            if at.curvature.abs() < 50.0 {
                let chord = (fine[k + 1] - fine[k - 1]).angle();
                assert!(wrap_angle(at.tangent - chord).abs() < 1e-2, "{} {chord}", at.tangent);
                let (before, after) = (curve.at(along[k] - 1e-4), curve.at(along[k] + 1e-4));
                let turn = wrap_angle(after.tangent - before.tangent) / 2e-4;
                assert!((turn - at.curvature).abs() < 0.05 + 0.01 * at.curvature.abs(), "{turn} {}", at.curvature);
            }
        }
        let p = points(&mut random, 1)[0];
        let best = fine.iter().map(|q| q.distance(p)).fold(f64::INFINITY, f64::min);
        assert!((curve.nearest(p).position.distance(p) - best).abs() < 1e-6);
        for tolerance in [1e-2, 1e-5] {
            let flat = Curve::polyline(&curve.flatten(tolerance), false).unwrap();
            let worst = fine.iter().step_by(501).map(|q| flat.nearest(*q).position.distance(*q)).fold(0.0, f64::max);
            assert!(worst <= tolerance, "{worst}");
        }
        let back = curve.reversed();
        let (a, b) = (curve.at(0.3 * total), back.at(curve.length() - 0.3 * total));
        assert!(a.position.distance(b.position) < 1e-9 && wrap_angle(a.tangent - b.tangent - PI).abs() < 1e-6);
        assert!((a.curvature + b.curvature).abs() < 1e-5 * (1.0 + a.curvature.abs()));
    }
}

#[test]
fn samples_avoid_corners() {
    let square = [(0.0, 0.0), (0.4, 0.0), (0.4, 0.4), (0.0, 0.4)].map(|(x, y)| Vec2::new(x, y));
    let curve = Curve::polyline(&square, true).unwrap();
    assert!((curve.length() - 1.6).abs() < 1e-15 && (curve.signed_area() - 0.16).abs() < 1e-15);
    assert!((curve.reversed().signed_area() + 0.16).abs() < 1e-15);
    let samples = curve.samples(0.03);
    assert_eq!(samples.len(), 4 * 14);
    for s in &samples {
        let corner = (s.arc_length / 0.4).round() * 0.4;
        assert!((s.arc_length - corner).abs() > 0.01);
        let side = (s.arc_length / 0.4).floor();
        assert!(wrap_angle(s.tangent - side * PI / 2.0).abs() < 1e-15);
        assert!(curve.at(s.arc_length).position.distance(s.position) < 1e-15);
    }
    assert!(samples.windows(2).all(|w| w[0].arc_length < w[1].arc_length));
    assert_eq!(curve.samples(f64::NAN).len(), 4);
    assert_eq!(curve.samples(-1.0).len(), 4);
    assert!(curve.at(-0.1).position.distance(Vec2::new(0.0, 0.1)) < 1e-15);
    assert!(curve.at(1.7).position.distance(Vec2::new(0.1, 0.0)) < 1e-12);
}

#[test]
fn arcs_are_within_their_tolerance() {
    let mut random = Random(8);
    for _ in 0..50 {
        let center = Vec2::new(random.signed(3.0), random.signed(3.0));
        let radii = Vec2::new(0.01 + random.unit(), 0.01 + random.unit());
        let (rotation, start, sweep) = (random.signed(PI), random.signed(TAU), random.signed(TAU));
        let cubics = arc_to_cubics(center, radii, rotation, start, sweep, 1e-9);
        for (k, cubic) in cubics.iter().enumerate() {
            for t in [0.0, 0.1, 0.25, 0.5, 0.7, 1.0] {
                let q = (bezier(cubic.control_points(), t) - center).rotated(-rotation);
                // Distance to an ellipse, to first order: its equation over its gradient.
                let f = (q.x / radii.x).powi(2) + (q.y / radii.y).powi(2) - 1.0;
                let gradient = Vec2::new(2.0 * q.x / radii.x.powi(2), 2.0 * q.y / radii.y.powi(2)).norm();
                assert!((f / gradient).abs() < 1e-9, "{}", f / gradient);
            }
            let angle = start + sweep * (k as f64 + 1.0) / cubics.len() as f64;
            let end = center + Vec2::new(radii.x * angle.cos(), radii.y * angle.sin()).rotated(rotation);
            assert!(cubic.end().distance(end) < 1e-12);
        }
    }
    let circle = Curve::circle(Vec2::new(1.0, -1.0), 0.25).unwrap();
    assert!((circle.length() - TAU * 0.25).abs() < 7e-9 && (circle.signed_area() - PI * 0.0625).abs() < 2e-9);
    for s in circle.samples(0.01) {
        assert!((s.curvature - 4.0).abs() < 1e-3, "{}", s.curvature);
        assert!(wrap_angle(s.tangent - (s.position - Vec2::new(1.0, -1.0)).angle() - PI / 2.0).abs() < 1e-6);
    }
}

#[test]
fn degenerate_input_is_refused() {
    let p = Vec2::new(1.0, 2.0);
    assert!(Curve::polyline(&[], true).is_none() && Curve::polyline(&[p, p, p], true).is_none());
    assert!(Curve::polyline(&[p, Vec2::new(f64::NAN, 0.0)], false).is_none());
    assert!(Curve::polyline(&[p, Vec2::new(f64::INFINITY, 0.0)], false).is_none());
    assert!(
        Curve::circle(p, 0.0).is_none() && Curve::circle(p, f64::NAN).is_none() && Curve::circle(p, -1.0).is_none()
    );
    let gap = vec![Segment::Line([p, Vec2::ZERO]), Segment::Line([p, Vec2::ZERO])];
    assert!(Curve::from_segments(gap, false).is_none());
    assert!(arc_to_cubics(p, p, f64::NAN, 0.0, 1.0, 1e-9).is_empty());
    assert!(!arc_to_cubics(p, p, 0.0, 0.0, 1e300, 0.0).is_empty());
    // Coinciding control points at an end: the tangent is the limit.
    let cubic = Segment::Cubic([Vec2::ZERO, Vec2::ZERO, Vec2::new(1.0, 1.0), Vec2::new(1.0, 1.0)]);
    assert!((cubic.tangent(0.0) - PI / 4.0).abs() < 1e-12 && (cubic.tangent(1.0) - PI / 4.0).abs() < 1e-12);
}

#[test]
fn a_small_curve_far_from_the_origin_is_measured_as_well_as_one_at_home() {
    // Powers of two, so that moving the curve rounds nothing.
    let unit = 2.0_f64.powi(-32);
    let shape = [(0.0, 0.0), (8.0, 3.0), (5.0, -7.0), (16.0, 2.0)];
    let at = |x: f64, y: f64| {
        let points = shape.map(|(a, b)| Vec2::new(x + a * unit, y + b * unit));
        Curve::from_segments(vec![Segment::Cubic(points)], false).unwrap()
    };
    let (home, far) = (at(0.0, 0.0), at(65536.0, -65536.0));
    assert!((far.length() - home.length()).abs() <= 1e-10 * home.length(), "{} {}", far.length(), home.length());
    for share in [0.1, 0.5, 0.8] {
        let (a, b) = (home.at(share * home.length()), far.at(share * home.length()));
        assert!((a.tangent - b.tangent).abs() < 1e-6, "{a:?} {b:?}");
        let near = far.nearest(b.position + Vec2::new(unit, -unit));
        let same = home.nearest(b.position - Vec2::new(65536.0, -65536.0) + Vec2::new(unit, -unit));
        assert!((near.arc_length - same.arc_length).abs() < 1e-6 * home.length(), "{near:?} {same:?}");
    }
}

#[test]
fn an_end_is_its_own_nearest_point() {
    let end = Vec2::new(200_000.0, -38_678.386_233_331_2);
    let points = [
        Vec2::new(100_000.0, 32_052.359_515_660_28),
        Vec2::new(400_000.0, 53_897.365_222_707_005),
        Vec2::new(0.0, 35_089.800_141_428_13),
        end,
    ];
    let curve = Curve::from_segments(vec![Segment::Cubic(points)], false).unwrap();
    assert_eq!(curve.nearest(end).position, end);
    assert_eq!(curve.nearest(points[0]).position, points[0]);
}

#[test]
fn curves_too_large_to_be_measured_are_none_at_once() {
    for size in [1e71, 1e200, f64::MAX] {
        let points = [Vec2::new(1.0, 5e-324), Vec2::new(size, 0.0), Vec2::new(1e-300, -0.0)];
        assert!(Curve::from_segments(vec![Segment::Quadratic(points)], false).is_none(), "{size:e}");
        assert!(Curve::polyline(&points, false).is_none(), "{size:e}");
    }
    let wide = [Vec2::new(0.0, 0.0), Vec2::new(1e69, 0.0), Vec2::new(1e69, 1e69)];
    let length = Curve::from_segments(vec![Segment::Quadratic(wide)], false).map_or(0.0, |curve| curve.length());
    assert!((1.62322e69..1.62323e69).contains(&length), "{length}");
}
