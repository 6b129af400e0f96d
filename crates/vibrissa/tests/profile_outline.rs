//! Outlines against the shapes that were swept: sweeps of an independent discrete rod, and shapes of known size.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must fail")]

#[path = "data/random.rs"]
mod random;
#[path = "data/shared.rs"]
mod shared;

use core::f64::consts::PI;
use random::Random;
use shared::shared;
use std::path::{Path, PathBuf};
use vibrissa::config::{ContactOptions, ProfileOptions};
use vibrissa::flow::sensor_log::SensorLog;
use vibrissa::io::read_tum;
use vibrissa::plane::{Pose2, Vec2};
use vibrissa::tasks::profile::*;
use vibrissa::world::{MomentNoise, MountedWhisker, Robot};

fn sweeps() -> Option<PathBuf> {
    std::env::var_os("VIBRISSA_SWEEPS").map_or_else(|| shared("sweeps"), |folder| Some(PathBuf::from(folder)))
}

/// A sweep whose odometry is the truth, so that its outline is in the map's frame.
fn sweep(folder: &Path, name: &str) -> SensorLog {
    let mut log = vibrissa::read_log(folder.join(format!("{name}.csv"))).unwrap();
    let truth = read_tum(folder.join(format!("{name}.truth.tum"))).unwrap();
    for (row, pose) in log.rows.iter_mut().zip(&truth) {
        row.odom_from_robot = pose.map_from_robot;
    }
    log
}

/// Readings are off by up to 5 %, as in the sweeps' own description.
fn robot() -> Robot {
    let noise = MomentNoise { moment_relative: 0.05, moment_absolute: 1e-6 };
    Robot { whiskers: vec![MountedWhisker { noise, ..MountedWhisker::default() }], ..Robot::default() }
}

fn check(names: &[&str], map: &str, most_mean: f64) {
    let Some(folder) = sweeps() else { return };
    let map = vibrissa::read_map(folder.join(format!("{map}.geojson"))).unwrap();
    let logs: Vec<SensorLog> = names.iter().map(|name| sweep(&folder, name)).collect();
    let found = profile(&logs, &robot(), &ContactOptions::default(), &ProfileOptions::default()).unwrap();
    let points: Vec<Vec2> = found.outlines.iter().flat_map(|o| o.points.iter().map(|p| p.position)).collect();
    assert!(points.len() > 20, "{names:?}: {} points, {} of {} left out", points.len(), found.left_out, found.contacts);
    let compared = compare(&points, &map, true).unwrap();
    let (absolute, shape) = (compared.absolute, compared.shape);
    println!(
        "{names:?}: {} outlines, {} points, {} of {} left out, {} pegs, absolute {:.3} p95 {:.3} max {:.3} mm, shape {:.3} mm, scale {:?}",
        found.outlines.len(),
        points.len(),
        found.left_out,
        found.contacts,
        found.pegs.len(),
        1e3 * absolute.mean,
        1e3 * absolute.p95,
        1e3 * absolute.max,
        1e3 * shape.mean,
        compared.scaled
    );
    let shortest = names.len() as f64 * 0.03;
    let total: f64 =
        found.outlines.iter().flat_map(|o| o.points.windows(2)).map(|p| p[0].position.distance(p[1].position)).sum();
    println!("   {:.1} mm, closed {:?}", 1e3 * total, found.outlines.iter().map(|o| o.closed).collect::<Vec<bool>>());
    assert!(total > shortest && found.outlines.iter().all(|o| !o.closed), "{names:?}: {total}");
    assert!(absolute.mean < most_mean, "{names:?}: {absolute:?}");
    assert!(shape.rms <= absolute.rms * 1.0001, "a rigid motion cannot make it worse");
    assert!(compared.scaled.unwrap().0.rms <= shape.rms * 1.0001);
}

#[test]
fn the_papers_obstacle_from_each_sweep() {
    for name in ["obstacle-00", "obstacle-01", "obstacle-02"] {
        check(&[name], "obstacle", 0.3e-3);
    }
}

/// Fresh noise on the exact readings: the mean error does not hang on one draw.
#[test]
fn the_papers_obstacle_with_other_noise() {
    let Some(folder) = sweeps() else { return };
    let map = vibrissa::read_map(folder.join("obstacle.geojson")).unwrap();
    let mut means = Vec::new();
    for (name, seed) in ["obstacle-00", "obstacle-01", "obstacle-02"].into_iter().flat_map(|n| [(n, 1), (n, 2), (n, 3)])
    {
        let mut log = sweep(&folder, name);
        let exact = std::fs::read_to_string(folder.join(format!("{name}.exact.csv"))).unwrap();
        let mut random = Random(seed);
        for (row, line) in log.rows.iter_mut().zip(exact.lines().skip(1)) {
            let moment: f64 = line.split(',').nth(1).unwrap().parse().unwrap();
            // |h - z| <= 0.05 |z|
            row.readings[0] = moment * (1.0 + random.signed(0.0476));
        }
        let found = profile(&[log], &robot(), &ContactOptions::default(), &ProfileOptions::default()).unwrap();
        let points: Vec<Vec2> = found.outlines.iter().flat_map(|o| o.points.iter().map(|p| p.position)).collect();
        means.push(compare(&points, &map, false).unwrap().absolute.mean);
    }
    println!("mean errors (mm): {:?}", means.iter().map(|m| (1e6 * m).round() / 1e3).collect::<Vec<f64>>());
    let mean = means.iter().sum::<f64>() / means.len() as f64;
    assert!(mean < 0.3e-3, "{means:?}");
}

#[test]
fn the_papers_obstacle_from_all_sweeps() {
    check(&["obstacle-00", "obstacle-01", "obstacle-02"], "obstacle", 0.25e-3);
}

#[test]
fn rounded_polygons_and_circles_are_found_again() {
    let mut random = Random(21);
    for sides in [0, 3, 4, 8] {
        let apothem = 0.08;
        let shape = if sides == 0 {
            RoundedPolygon::circle(apothem)
        } else {
            RoundedPolygon { sides, apothem, corner_radius: random.between(0.02, 0.05) }
        };
        let place = Pose2::new(random.signed(1.0), random.signed(1.0), random.signed(0.3));
        // Points of the outline by bisection along rays: only the sign of the distance is used.
        let ray = |angle: f64| {
            let (mut lo, mut hi) = (0.0, 0.4);
            for _ in 0..60 {
                let middle = 0.5 * (lo + hi);
                if shape.distance(Vec2::from_angle(angle) * middle) < 0.0 { lo = middle } else { hi = middle }
            }
            place.transform_point(Vec2::from_angle(angle) * lo)
        };
        let points: Vec<Vec2> = (0..300).map(|i| ray(f64::from(i) * 0.021)).collect();
        let known = fit_shape(&points, shape, FreeSize::None).unwrap();
        assert!(
            known.place.position().distance(place.position()) < 1e-6 && known.misfit.max < 1e-6,
            "{sides}: {known:?}"
        );
        let wrong = RoundedPolygon { apothem: 0.076, corner_radius: if sides == 0 { 0.076 } else { 0.03 }, ..shape };
        let free = fit_shape(&points, wrong, FreeSize::All).unwrap();
        assert!((free.shape.apothem - apothem).abs() < 1e-6, "{sides}: {free:?}");
        assert!((free.shape.corner_radius - shape.corner_radius).abs() < 1e-5, "{sides}: {free:?}");
    }
}

/// What felt an outline is not a point: the outline grown by its size is one of the same family, by hand.
#[test]
fn an_offset_and_far_corners_are_found_again() {
    let (shape, offset) = (RoundedPolygon { sides: 4, apothem: 0.08, corner_radius: 0.04 }, 0.025);
    let place = Pose2::new(0.3, -0.2, 0.4);
    let outline = |grown: f64, corner: f64| -> Vec<Vec2> {
        // Faces and arcs of a square with rounded corners, from their definition.
        let inner = grown - corner;
        let one = |k: u32| {
            let (quarter, u) = (k / 50, f64::from(k % 50) / 50.0);
            let p = if u < 0.5 {
                Vec2::new(grown, inner * (4.0 * u - 1.0))
            } else {
                Vec2::new(inner, inner) + Vec2::from_angle(PI * (u - 0.5)) * corner
            };
            place.transform_point(p.rotated(f64::from(quarter) * 0.5 * PI))
        };
        (0..200).map(one).collect()
    };
    let grown = fit_shape(&outline(0.08 + offset, 0.04 + offset), shape, FreeSize::Offset).unwrap();
    assert!((grown.shape.apothem - 0.105).abs() < 1e-6 && grown.misfit.max < 1e-6, "{grown:?}");
    assert!((grown.shape.corner_radius - 0.065).abs() < 1e-6, "{grown:?}");
    let scaled = fit_shape(&outline(0.08 + offset, 0.04 + offset), shape, FreeSize::Scale).unwrap();
    assert!(scaled.misfit.mean > 1e-4, "a scale is no offset: {scaled:?}");
    for corner in [0.01, 0.03, 0.082, 0.1] {
        let free = fit_shape(&outline(0.1077, corner), shape, FreeSize::All).unwrap();
        assert!((free.shape.corner_radius - corner).abs() < 1e-5 && free.misfit.max < 1e-5, "{corner}: {free:?}");
    }
}

/// The distance to a rounded square, by hand: a face, a corner's arc, the centre.
#[test]
fn distances_to_a_rounded_square_by_hand() {
    let shape = RoundedPolygon { sides: 4, apothem: 0.08, corner_radius: 0.04 };
    let corner = 0.04 + 0.04 / 2f64.sqrt();
    for (point, distance) in [
        (Vec2::new(0.09, 0.01), 0.01),
        (Vec2::new(-0.02, -0.07), -0.01),
        (Vec2::new(corner, corner), 0.0),
        (Vec2::new(-0.08, 0.08), 0.04 * (2f64.sqrt() - 1.0)),
        (Vec2::ZERO, -0.08),
    ] {
        assert!((shape.distance(point) - distance).abs() < 1e-12, "{point:?}");
    }
}

/// A map's own boundary, moved: no shape error, and the motion as absolute error.
#[test]
fn shape_error_and_absolute_error_are_apart() {
    let text = r#"{"type":"FeatureCollection","features":[{"type":"Feature","properties":{"role":"obstacle"},
        "geometry":{"type":"Polygon","coordinates":[[[0,0],[0.1,0],[0.1,0.06],[0,0.06],[0,0]]]}}]}"#;
    let map = vibrissa::io::map::from_geojson(text, "map").unwrap();
    let moved = Pose2::new(0.002, 0.001, 0.01);
    let points: Vec<Vec2> = map.samples(1e-3).iter().map(|s| moved.transform_point(s.position)).collect();
    let compared = compare(&points, &map, true).unwrap();
    assert!(compared.shape.max < 1e-6, "{compared:?}");
    assert!(compared.absolute.mean > 0.5e-3);
    let back = compared.map_from_outline.compose(moved);
    assert!(back.position().norm() < 1e-6 && back.theta.abs() < 1e-6, "{back:?}");
    assert!((compared.scaled.unwrap().1 - 1.0).abs() < 1e-4);
    assert!(compare(&[], &map, false).is_none());
}

/// A stretch of a boundary in a frame of its own, turned and far away: the shape error does not depend on frames.
#[test]
fn shapes_are_found_from_any_frame() {
    let text = r#"{"type":"FeatureCollection","features":[{"type":"Feature","properties":{"role":"obstacle"},
        "geometry":{"type":"Polygon","coordinates":[[[0,0],[0.2,0],[0.2,0.05],[0.12,0.09],[0.07,0.07],[0,0.16],[0,0]]]}}]}"#;
    let map = vibrissa::io::map::from_geojson(text, "map").unwrap();
    for (from, moved) in
        [(20, Pose2::new(0.3, -0.2, 2.0)), (230, Pose2::new(-1.0, 0.4, -2.6)), (330, Pose2::new(0.0, 5.0, 0.4))]
    {
        let stretch = map.samples(1e-3);
        let points: Vec<Vec2> = stretch[from..from + 180].iter().map(|s| moved.transform_point(s.position)).collect();
        let compared = compare(&points, &map, false).unwrap();
        assert!(compared.shape.max < 1e-5, "{from}: {compared:?}");
        let back = compared.map_from_outline.compose(moved);
        assert!(back.position().norm() < 1e-4 && back.theta.abs() < 1e-3, "{from}: {back:?}");
        assert!(compared.absolute.mean > 0.05, "{from}: {compared:?}");
    }
}

/// A straight wall felt in pieces from `from` on, free space on its left.
fn pieces(from: Vec2, along: Vec2, length: f64, draw: &mut Random) -> Vec<FeltLine> {
    const PIECE: f64 = 40e-3;
    let band = vibrissa::world::Band { std: 0.05e-3, bound: 0.2e-3 };
    let count = (length / PIECE) as usize;
    let mut piece = |k: usize| {
        let point = |j: usize| FeltPoint {
            position: from + along * (PIECE * k as f64 + 0.5e-3 * j as f64) + along.perp() * draw.signed(0.05e-3),
            band,
            drift: vibrissa::world::Band::default(),
        };
        FeltLine { points: (0..79).map(point).collect(), closed: false }
    };
    (0..count).map(&mut piece).collect()
}

#[test]
fn walls_that_were_felt_in_pieces_meet_in_a_corner_farther_ahead_than_a_piece_is_long() {
    use vibrissa::config::MapAssemblyOptions;
    for seed in 0..20 {
        let mut draw = Random(seed);
        let (corner, turn) = (Vec2::new(draw.signed(1.0), draw.signed(1.0)), draw.between(0.6, 2.2) * draw.sign());
        let (first, second) = (Vec2::from_angle(draw.signed(PI)), draw.between(0.05, 0.075));
        let after = first.rotated(turn);
        let mut lines = pieces(corner - first * (0.28 + second), first, 0.281, &mut draw);
        lines.extend(pieces(corner + after * second, after, 0.281, &mut draw));
        // In any order.
        for k in (1..lines.len()).rev() {
            lines.swap(k, draw.between(0.0, k as f64 + 1.0) as usize);
        }
        let found = assemble(&lines, &MapAssemblyOptions::default()).unwrap();
        assert_eq!((found.map.boundaries().len(), found.corners.len()), (1, 1), "{seed}");
        let off = found.corners[0].position.distance(corner);
        assert!(off <= found.corners[0].band.bound && off < 0.5e-3, "{seed}: {off}");
    }
}
