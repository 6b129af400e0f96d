//! Grid maps: boundaries traced from pictures of known polygons, against those polygons.

#![cfg(feature = "ros-map")]
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must fail")]

#[path = "data/picture.rs"]
mod picture;
#[path = "data/random.rs"]
mod random;

use picture::{Painter, pgm};
use random::Random;
use vibrissa::config::GridOptions;
use vibrissa::io::grid::{Cell, MapServerFile, OccupancyGrid};
use vibrissa::plane::{Pose2, Vec2};
use vibrissa::world::{Map, Role};

const CELL: f64 = 0.01;

/// The largest distance of the map's boundary from the polygon, there and back (cells): along the walls, and within three
/// cells of the corners.
fn largest_errors(map: &Map, polygon: &[Vec2]) -> [f64; 2] {
    let ends = |i: usize| (polygon[i], polygon[(i + 1) % polygon.len()]);
    let to_polygon = |p: Vec2| {
        let distance = |(a, b): (Vec2, Vec2)| {
            let share = ((p - a).dot(b - a) / (b - a).norm_squared()).clamp(0.0, 1.0);
            p.distance(a + (b - a) * share)
        };
        (0..polygon.len()).map(|i| distance(ends(i))).fold(f64::INFINITY, f64::min)
    };
    let mut worst = [0.0f64; 2];
    let mut note = |p: Vec2, miss: f64| {
        let at_corner = polygon.len() < 50 && polygon.iter().any(|corner| corner.distance(p) < 3.0 * CELL);
        worst[usize::from(at_corner)] = worst[usize::from(at_corner)].max(miss / CELL);
    };
    map.samples(0.2 * CELL).iter().for_each(|s| note(s.position, to_polygon(s.position)));
    for i in 0..polygon.len() {
        let (a, b) = ends(i);
        let parts = (b - a).norm() / (0.3 * CELL);
        for k in 0..=parts as usize {
            let p = a + (b - a) * (k as f64 / parts.max(1.0));
            note(p, map.nearest(p).unwrap().distance);
        }
    }
    worst
}

fn yaml(mode: &str) -> MapServerFile {
    // In scale mode the thresholds stretch the grey: here they leave all of it.
    let (occupied, free) = if mode.is_empty() { (0.65, 0.196) } else { (1.0, 0.0) };
    let text = format!(
        "image: room.pgm\nresolution: {CELL}\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: {occupied}\nfree_thresh: \
         {free}\n{mode}"
    );
    MapServerFile::parse(&text, "room.yaml").unwrap()
}

fn traced(painter: &Painter, mode: &str) -> Map {
    let grid = yaml(mode).grid(&pgm(painter), "room.pgm").unwrap();
    vibrissa::io::map::from_grid(&grid, &GridOptions::default()).unwrap()
}

/// A rectangle of 0.9 m by 0.6 m about the middle of the picture, turned.
fn turned_room(angle: f64, shift: Vec2) -> Vec<Vec2> {
    let place = Pose2::new(0.75 + shift.x, 0.75 + shift.y, angle);
    [(-0.45, -0.3), (0.45, -0.3), (0.45, 0.3), (-0.45, 0.3)]
        .map(|(x, y)| place.transform_point(Vec2::new(x, y)))
        .to_vec()
}

#[test]
fn straight_walls_are_within_a_tenth_of_a_cell_by_grey_and_half_a_cell_without() {
    let mut random = Random(5);
    let mut worst = [[0.0f64; 2]; 2];
    for round in 0..24 {
        let angle = if round == 0 { 0.0 } else { random.between(-3.1, 3.1) };
        let room = turned_room(angle, Vec2::new(random.between(-0.01, 0.01), random.between(-0.01, 0.01)));
        for (keys, smooth) in [("", true), ("mode: scale", true), ("", false)] {
            let painter = Painter { width: 150, height: 150, cell: CELL, free: &room, smooth };
            let map = traced(&painter, keys);
            assert_eq!(map.boundaries().len(), 1, "{keys} {angle}");
            assert_eq!(map.boundaries()[0].role(), Role::Arena);
            let errors = largest_errors(&map, &room);
            let corners = map.boundaries()[0].curve().segments().len();
            println!("{angle:7.3} smooth {smooth} {keys:<12} {corners:3} corners: {errors:.4?} cells");
            (0..2).for_each(|k| worst[usize::from(smooth)][k] = worst[usize::from(smooth)][k].max(errors[k]));
        }
    }
    println!("walls and corners: sharp {:.4?}, grey {:.4?} cells", worst[0], worst[1]);
    assert!(worst[1][0] < 0.1 && worst[1][1] < 0.2, "grey: {:?} cells", worst[1]);
    assert!(worst[0][0] < 0.5 && worst[0][1] < 1.2, "sharp: {:?} cells", worst[0]);
}

#[test]
fn curved_walls_and_islands_keep_their_place() {
    let around = |radius: f64, turns: f64| -> Vec<Vec2> {
        (0..400)
            .map(|k| {
                Vec2::new(0.75, 0.75) + Vec2::from_angle(turns * f64::from(k) / 400.0 * core::f64::consts::TAU) * radius
            })
            .collect()
    };
    for radius in [0.08, 0.3, 0.6] {
        let circle = around(radius, 1.0);
        for (smooth, allowed) in [(true, 0.1), (false, 1.2)] {
            let map = traced(&Painter { width: 150, height: 150, cell: CELL, free: &circle, smooth }, "");
            let error = largest_errors(&map, &circle)[0];
            println!("radius {:4.0} cells, smooth {smooth}: {error:.3} cells", radius / CELL);
            assert!(error < allowed, "radius {radius}, smooth {smooth}: {error} cells");
        }
    }
}

#[test]
fn unknown_cells_are_solid_with_a_word_or_free_if_asked() {
    // A free field of 20 by 20 cells in the midst of unknown ones, with a wall on its right.
    let shade = |x: usize, y: usize| match (x, y) {
        (10..30, 10..30) => 254,
        (30, 10..30) => 0,
        _ => 205,
    };
    let shades: Vec<u8> = (0..40).flat_map(|y| (0..40).map(move |x| shade(x, y))).collect();
    let image = [b"P5\n40 40\n255\n", shades.as_slice()].concat();
    let grid = yaml("").grid(&image, "room.pgm").unwrap();
    let map = vibrissa::io::map::from_grid(&grid, &GridOptions::default()).unwrap();
    assert_eq!(map.boundaries().len(), 1);
    assert!(map.warnings.iter().any(|w| w.contains("unknown") && w.contains("0.6 m")), "{:?}", map.warnings);
    assert!(map.is_free(Vec2::new(0.2, 0.2)) && !map.is_free(Vec2::new(0.05, 0.2)));
    let open =
        vibrissa::io::map::from_grid(&grid, &GridOptions { unknown_is_free: true, ..GridOptions::default() }).unwrap();
    assert_eq!(open.boundaries()[0].role(), Role::Obstacle);
    assert!(open.is_free(Vec2::new(0.05, 0.2)) && !open.is_free(Vec2::new(0.305, 0.2)));
    assert!((open.total_length() / CELL - 42.0).abs() < 1.5, "{}", open.total_length());
}

#[test]
fn origin_yaw_and_resolution_place_the_map() {
    let place = Pose2::new(3.0, -2.0, 0.7);
    let cell = |i: usize| if (i % 20).abs_diff(10) < 5 && (i / 20).abs_diff(5) < 3 { 0.0 } else { 1.0 };
    let cells = (0..200).map(|i| Cell::Solid(cell(i))).collect();
    let grid = OccupancyGrid { width: 20, height: 10, resolution: 0.5, map_from_grid: place, cells };
    let map = vibrissa::io::map::from_grid(&grid, &GridOptions::default()).unwrap();
    // Free cells: 6 to 14 along x, 3 to 7 along y.
    for corner in [(3.0, 1.5), (7.5, 1.5), (7.5, 4.0), (3.0, 4.0)] {
        let corner = place.transform_point(Vec2::new(corner.0, corner.1));
        assert!(map.nearest(corner).unwrap().distance < 1e-9);
    }
    assert!((map.total_length() - 14.0).abs() < 1e-9, "{}", map.total_length());
    assert!(map.is_free(place.transform_point(Vec2::new(5.0, 2.5))));
}

#[test]
fn thresholds_negate_and_modes_are_those_of_map_server() {
    // By hand: occupancy = (255 - shade) / 255, or shade / 255 when negated.
    let shades = [0u8, 89, 90, 204, 206, 255, 100, 101];
    let image = [b"P5\n# a comment\n8 1\n255\n", shades.as_slice()].concat();
    let cells = |keys: &str| {
        let text = format!("image: a.pgm\nresolution: 1\norigin: [0, 0, 0]\n{keys}");
        MapServerFile::parse(&text, "a.yaml").unwrap().grid(&image, "a.pgm").unwrap().cells
    };
    let share = |cell: Cell| if let Cell::Solid(share) = cell { f64::from(share) } else { f64::NAN };
    let trinary = cells("occupied_thresh: 0.65\nfree_thresh: 0.196");
    // 89 is 0.651, 90 is 0.647 and 204 is 0.2: between; 206 is 0.192.
    assert!(share(trinary[0]) > 0.99 && share(trinary[1]) > 0.65);
    assert_eq!([trinary[2], trinary[3]], [Cell::Unknown; 2]);
    assert!(share(trinary[5]) < 0.01);
    let negated = cells("negate: 1\noccupied_thresh: 0.65\nfree_thresh: 0.196");
    assert!(share(negated[0]) < 0.01 && share(negated[5]) > 0.99);
    let scaled = cells("mode: scale\noccupied_thresh: 0.9\nfree_thresh: 0.1");
    assert!((share(scaled[1]) - ((166.0 / 255.0) - 0.1) / 0.8).abs() < 1e-6);
    assert_eq!((scaled[0], scaled[5]), (Cell::Solid(1.0), Cell::Solid(0.0)));
    let raw = cells("mode: raw");
    assert_eq!((raw[6], raw[7], raw[0]), (Cell::Solid(1.0), Cell::Unknown, Cell::Solid(0.0)));
}

#[test]
fn faults_name_the_key_and_the_next_step() {
    for (text, word) in [
        ("", "line 1"),
        ("image: a.pgm\norigin: [0, 0, 0]", "resolution"),
        ("image: a.pgm\nresolution: x\norigin: [0, 0, 0]", "a.yaml:2"),
        ("image: a.pgm\nresolution: 0\norigin: [0, 0, 0]", "resolution is out of range: 0"),
        ("image: a.pgm\nresolution: .nan\norigin: [0, 0, 0]", "resolution is out of range"),
        ("image: a.pgm\nresolution: 1\norigin: [0]", "origin"),
        ("image: a.pgm\nresolution: 1\norigin: [0, 0, 0]\nnegate: 2", "negate"),
        ("image: a.pgm\nresolution: 1\norigin: [0, 0, 0]\nfree_thresh: 0.7", "threshold"),
        ("image: a.pgm\nresolution: 1\norigin: [0, 0, 0]\nmode: binary", "trinary, scale or raw"),
    ] {
        let error = MapServerFile::parse(text, "a.yaml").unwrap_err().to_string();
        println!("{error}\n");
        assert!(error.contains("a.yaml") && error.contains("help:"), "{error}");
        assert!(error.contains(word) || word == "line 1", "{error}");
    }
    let file = yaml("");
    for (bytes, word) in [
        (&b""[..], "cannot read"),
        (b"P5 10 10 255 short", "cannot read"),
        (b"P5 900000 900000 255\n", "too large"),
        (b"not an image at all", "cannot read"),
    ] {
        let error = file.grid(bytes, "room.pgm").unwrap_err().to_string();
        println!("{error}\n");
        assert!(error.contains(word) && error.contains("room.pgm") && error.contains("help:"), "{error}");
    }
    let all = |share: f32| OccupancyGrid {
        width: 2,
        height: 1,
        resolution: 1.0,
        map_from_grid: Pose2::IDENTITY,
        cells: vec![Cell::Solid(share); 2],
    };
    assert!(
        vibrissa::io::map::from_grid(&all(1.0), &GridOptions::default())
            .unwrap_err()
            .to_string()
            .contains("no boundary")
    );
    let noise = OccupancyGrid {
        width: 2000,
        height: 2000,
        cells: (0..4_000_000).map(|i| Cell::Solid(f32::from((i % 2 + i / 2000 % 2) == 1))).collect(),
        ..all(0.0)
    };
    assert!(
        vibrissa::io::map::from_grid(&noise, &GridOptions::default())
            .unwrap_err()
            .to_string()
            .contains("too much boundary")
    );
}
