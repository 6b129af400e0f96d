//! Maps: free space, orientation, the shared sweeps, and random polygons against brute force.

#![allow(clippy::unwrap_used, reason = "helpers of tests may fail like tests")]

#[path = "data/random.rs"]
mod random;
#[path = "data/shared.rs"]
mod shared;

use random::Random;
use shared::shared;
use std::f64::consts::{PI, TAU};
use std::path::{Path, PathBuf};
use vibrissa::plane::{Curve, Pose2, Vec2};
use vibrissa::world::{Boundary, Map, Role, increments};

fn ring(points: &[Vec2], reversed: bool, repeat: bool) -> String {
    let mut p: Vec<Vec2> = points.to_vec();
    if reversed {
        p.reverse();
    }
    if repeat {
        p.push(p[0]);
    }
    let list: Vec<String> = p.iter().map(|q| format!("[{}, {}]", q.x, q.y)).collect();
    format!("[{}]", list.join(", "))
}

fn rectangle(x0: f64, y0: f64, x1: f64, y1: f64) -> Vec<Vec2> {
    vec![Vec2::new(x0, y0), Vec2::new(x1, y0), Vec2::new(x1, y1), Vec2::new(x0, y1)]
}

fn feature(role: &str, kind: &str, coordinates: &str) -> String {
    format!(
        "{{\"type\":\"Feature\",\"properties\":{{\"role\":\"{role}\"}},\"geometry\":{{\"type\":\"{kind}\",\"coordinates\":{coordinates}}}}}"
    )
}

fn collection(features: &[String]) -> String {
    format!("{{\"type\":\"FeatureCollection\",\"features\":[{}]}}", features.join(","))
}

/// Every sample has free space on its left, and none on its right unless it is a wall.
fn assert_sides(map: &Map, spacing: f64) {
    for s in map.samples(spacing) {
        let left = Vec2::from_angle(s.tangent).perp() * 1e-5;
        assert!(map.is_free(s.position + left), "{s:?}");
        let two_sided = map.boundaries()[s.boundary].is_two_sided();
        assert_eq!(map.is_free(s.position - left), two_sided, "{s:?}");
    }
}

#[test]
fn free_space_in_every_orientation() {
    let (outer, hole, block, court) = (
        rectangle(-1.0, -1.0, 1.0, 1.0),
        rectangle(-0.8, -0.8, -0.4, -0.4),
        rectangle(0.0, 0.0, 0.6, 0.6),
        rectangle(0.2, 0.2, 0.4, 0.4),
    );
    for bits in 0..32 {
        let on = |k: i32| bits >> k & 1 == 1;
        let r = |p: &[Vec2], k| ring(p, on(k), on(4));
        let text = collection(&[
            feature("arena", "Polygon", &format!("[{}, {}]", r(&outer, 0), r(&hole, 1))),
            feature("obstacle", "MultiPolygon", &format!("[[{}, {}]]", r(&block, 2), r(&court, 3))),
            feature("wall", "MultiLineString", "[[[-0.5, 0.2], [-0.5, 0.8], [-0.2, 0.8]]]"),
        ]);
        let map = vibrissa::io::map::from_geojson(&text, "map").unwrap();
        assert!(map.warnings.is_empty());
        for (x, y, free) in [
            (0.0, -0.5, true),
            (-0.6, -0.6, false),
            (0.1, 0.1, false),
            (0.3, 0.3, true),
            (2.0, 0.0, false),
            (-0.5, 0.5, true),
            (f64::NAN, 0.0, false),
        ] {
            assert_eq!(map.is_free(Vec2::new(x, y)), free, "{x} {y} {bits}");
        }
        assert_sides(&map, 0.013);
        assert!((map.total_length() - (8.0 + 1.6 + 2.4 + 0.8 + 0.9)).abs() < 1e-12);
        let wall_samples: Vec<_> =
            map.samples(0.1).into_iter().filter(|s| map.boundaries()[s.boundary].role() == Role::Wall).collect();
        assert_eq!(wall_samples.len(), 18);
        assert!(
            map.crosses(Vec2::new(-0.6, 0.5), Vec2::new(-0.4, 0.5))
                && !map.crosses(Vec2::new(-0.1, -0.1), Vec2::new(0.5, -0.5))
        );
    }
    let bare = vibrissa::io::map::from_geojson(
        &format!("{{\"type\":\"Polygon\",\"coordinates\":[{}]}}", ring(&outer, true, true)),
        "m",
    );
    assert!(bare.unwrap().is_free(Vec2::ZERO));
    let one = vibrissa::io::map::from_geojson(
        &feature("obstacle", "Polygon", &format!("[{}]", ring(&outer, false, true))),
        "m",
    )
    .unwrap();
    assert!(!one.is_free(Vec2::ZERO) && one.is_free(Vec2::new(5.0, 5.0)));
}

#[test]
fn random_outlines_and_their_nearest_points() {
    let mut random = Random(21);
    for round in 0..20 {
        let count = 3 + round * 7;
        let star: Vec<Vec2> =
            (0..count).map(|k| Vec2::from_angle(TAU * k as f64 / count as f64) * (0.5 + random.unit())).collect();
        let role = if round % 2 == 0 { "arena" } else { "obstacle" };
        let text = collection(&[feature(role, "Polygon", &format!("[{}]", ring(&star, round % 3 == 0, true)))]);
        let map = vibrissa::io::map::from_geojson(&text, "star").unwrap();
        assert_sides(&map, 0.05);
        let curve = map.boundaries()[0].curve();
        for _ in 0..100 {
            let p = Vec2::new(random.signed(2.0), random.signed(2.0));
            let hit = map.nearest(p).unwrap();
            assert!((hit.distance - curve.nearest(p).position.distance(p)).abs() < 1e-12);
            assert!(curve.at(hit.arc_length).position.distance(hit.position) < 1e-12);
        }
    }
}

#[test]
fn curves_stay_curves() {
    let circle = Boundary::new(Role::Obstacle, Curve::circle(Vec2::new(0.1, 0.0), 0.05).unwrap(), None).unwrap();
    let map = Map::new(vec![circle]).unwrap();
    assert_sides(&map, 0.002);
    let mut random = Random(2);
    for _ in 0..500 {
        let p = Vec2::new(random.signed(0.3), random.signed(0.3));
        let from_center = p - Vec2::new(0.1, 0.0);
        let hit = map.nearest(p).unwrap();
        assert!((hit.distance - (from_center.norm() - 0.05).abs()).abs() < 2e-9, "{hit:?}");
        assert!((hit.curvature + 20.0).abs() < 5e-3, "{hit:?}");
        if (from_center.norm() - 0.05).abs() > 2e-6 {
            assert_eq!(map.is_free(p), from_center.norm() > 0.05);
            assert_eq!(map.crosses(Vec2::new(0.1, 0.0), p), from_center.norm() > 0.05);
        }
    }
    assert!(map.nearest(Vec2::new(f64::INFINITY, 0.0)).is_none());
}

#[test]
fn far_and_small_maps() {
    for (offset, size) in [(9e4, 1e-2), (-9e4, 1.0), (0.0, 1e-5), (0.0, 9e4)] {
        let p: Vec<Vec2> = rectangle(offset, offset, offset + size, offset + size);
        let map = vibrissa::io::map::from_geojson(
            &collection(&[feature("arena", "Polygon", &format!("[{}]", ring(&p, true, false)))]),
            "m",
        )
        .unwrap();
        assert!(map.is_free(Vec2::new(offset + 0.5 * size, offset + 0.5 * size)));
        assert!(!map.is_free(Vec2::new(offset - 0.1 * size, offset + 0.5 * size)));
        assert_eq!(map.warnings.len(), usize::from(size > 200.0));
    }
    assert!(Map::new(Vec::new()).is_err());
}

#[test]
fn increments_compose_to_the_end() {
    let mut random = Random(6);
    let poses: Vec<Pose2> =
        (0..50).map(|_| Pose2::new(random.signed(2.0), random.signed(2.0), random.signed(PI))).collect();
    let moves: Vec<Pose2> = increments(poses.iter().copied()).collect();
    assert_eq!(moves.len(), 49);
    let end = moves.iter().fold(poses[0], |pose, step| pose.compose(*step));
    assert!(end.position().distance(poses[49].position()) < 1e-12);
    assert_eq!(increments([]).count() + increments([poses[0]]).count(), 0);
}

/// The files of a folder with this extension, sorted.
fn files(folder: &Path, extension: &str) -> Vec<PathBuf> {
    let mut all: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    all.retain(|p| p.to_string_lossy().ends_with(extension));
    all.sort();
    all
}

/// The poses of a trajectory file.
fn truth(path: &str) -> Vec<Pose2> {
    let text = std::fs::read_to_string(path).unwrap();
    let numbers = |line: &str| line.split_whitespace().map(|v| v.parse::<f64>().unwrap()).collect::<Vec<_>>();
    let lines = text.lines().filter(|l| !l.starts_with('#')).map(numbers);
    lines.map(|v| Pose2::new(v[1], v[2], 2.0 * v[6].atan2(v[7]))).collect()
}

#[test]
fn shared_sweeps_are_read() {
    let Some(folder) = shared("sweeps") else { return };
    for path in files(&folder, ".geojson") {
        let map = vibrissa::read_map(&path).unwrap();
        assert!(map.warnings.is_empty());
        assert_sides(&map, 0.002);
    }
    let mut count = 0;
    for path in files(&folder, ".csv") {
        let name = path.to_string_lossy().into_owned();
        if name.ends_with("contacts.csv") || name.ends_with("exact.csv") {
            continue;
        }
        let log = vibrissa::read_log(&path).unwrap();
        assert!(log.warnings.is_empty(), "{name} {:?}", log.warnings);
        assert_eq!(log.rows.len() + 1, std::fs::read_to_string(&path).unwrap().lines().count());
        // The truth, an independent file, moves as the odometry does, through the map's free space.
        let truth = truth(&name.replace(".csv", ".truth.tum"));
        assert_eq!(truth.len(), log.rows.len());
        let map_name = path.file_name().unwrap().to_string_lossy().split('-').next().unwrap().to_owned();
        let map = vibrissa::read_map(folder.join(format!("{map_name}.geojson"))).unwrap();
        assert!(truth.iter().all(|pose| map.is_free(pose.position())));
        if !name.contains("bias") {
            let odometry = increments(log.rows.iter().map(|r| r.odom_from_robot));
            for (a, b) in odometry.zip(increments(truth)) {
                assert!(
                    a.position().distance(b.position()) < 1e-6 && (a.theta - b.theta).abs() < 1e-5,
                    "{name} {a:?} {b:?}"
                );
            }
        }
        count += 1;
    }
    assert!(count >= 20, "{count}");
}
