//! Drawings: units, transforms, curves, roles, holes.

#![allow(clippy::unwrap_used, reason = "helpers of tests may fail like tests")]

use std::f64::consts::{PI, TAU};
use vibrissa::plane::Vec2;
use vibrissa::world::{Map, Role};

const NAMESPACES: &str =
    "xmlns=\"http://www.w3.org/2000/svg\" xmlns:inkscape=\"http://www.inkscape.org/namespaces/inkscape\"";

fn draw(head: &str, inside: &str) -> Map {
    vibrissa::io::map::from_svg(&format!("<svg {NAMESPACES} {head}>{inside}</svg>"), "map.svg").unwrap()
}

fn assert_bounds(map: &Map, expected: [f64; 4]) {
    let b = map.bounds();
    for (found, expected) in [b.min.x, b.min.y, b.max.x, b.max.y].into_iter().zip(expected) {
        assert!((found - expected).abs() < 2e-6, "{b:?} {expected}");
    }
}

#[test]
fn units_and_flip() {
    let rect = "<rect id=\"arena\" x=\"10\" y=\"20\" width=\"30\" height=\"5\"/>";
    assert_bounds(&draw("", rect), [0.01, -0.025, 0.04, -0.02]);
    assert_bounds(&draw("height=\"100\"", rect), [0.01, 0.075, 0.04, 0.08]);
    assert_bounds(&draw("viewBox=\"0 0 200 100\"", rect), [0.01, 0.075, 0.04, 0.08]);
    assert_bounds(&draw("width=\"200mm\" height=\"100mm\" viewBox=\"0 0 200 100\"", rect), [0.01, 0.075, 0.04, 0.08]);
    assert_bounds(&draw("width=\"20cm\" height=\"10cm\" viewBox=\"0 0 200 100\"", rect), [0.01, 0.075, 0.04, 0.08]);
    assert_bounds(
        &draw("width=\"2in\" height=\"1in\" viewBox=\"0 0 200 100\"", rect),
        [0.00254, 0.01905, 0.01016, 0.02032],
    );
    assert_bounds(&draw("width=\"400mm\" viewBox=\"10 20 200 100\"", rect), [0.0, 0.19, 0.06, 0.2]);
}

#[test]
fn shapes_keep_their_size() {
    let head = "viewBox=\"0 0 100 100\"";
    for (inside, length, area) in [
        ("<circle id=\"obstacle\" cx=\"50\" cy=\"50\" r=\"20\"/>", TAU * 0.02, PI * 4e-4),
        ("<ellipse id=\"obstacle\" cx=\"50\" cy=\"50\" rx=\"20\" ry=\"20\"/>", TAU * 0.02, PI * 4e-4),
        ("<path id=\"obstacle\" d=\"M70 50 A20 20 0 0 1 30 50 a20,20 0 0 1 40,0 z\"/>", TAU * 0.02, PI * 4e-4),
        ("<path id=\"obstacle\" d=\"M70 50 A20 20 0 1 1 50 30\nV 50 Z\"/>", 0.04 + 1.5 * PI * 0.02, 0.75 * PI * 4e-4),
        ("<rect id=\"obstacle\" width=\"40\" height=\"20\" rx=\"5\"/>", 0.08 + TAU * 0.005, 8e-4 - (4.0 - PI) * 2.5e-5),
        ("<rect id=\"obstacle\" width=\"40\" height=\"20\" rx=\"50\" ry=\"10\"/>", f64::NAN, PI * 2e-4),
        ("<polygon id=\"obstacle\" points=\"0,0 30,0 30,40\"/>", 0.12, 6e-4),
        ("<path id=\"obstacle\" d=\"m 0 0 h 30 v 40 l -30 -40\"/>", 0.12, 6e-4),
        // A parabola: area under it is two thirds of its box.
        ("<path id=\"obstacle\" d=\"M0 0 Q 15 40 30 0 Z\"/>", f64::NAN, 4e-4),
        ("<path id=\"obstacle\" d=\"M0 0 q 15 40 30 0 t 30 0 L 60 60 L 0 60 Z\"/>", f64::NAN, 3.6e-3),
        ("<path id=\"obstacle\" d=\"M0 0 C 10 20 20 20 30 0 S 50 -20 60 0 V 60 H 0 Z\"/>", f64::NAN, 3.6e-3),
    ] {
        for (transform, scale) in
            [("", 1.0), ("translate(3,-7) rotate(33)", 1.0), ("scale(-2,2)", 2.0), ("matrix(0 3 3 0 5 6)", 3.0)]
        {
            let map = draw(head, &format!("<g transform=\"{transform}\"><g>{inside}</g></g>"));
            let curve = map.boundaries()[0].curve();
            if !length.is_nan() {
                assert!((curve.length() - scale * length).abs() < 1e-8, "{inside} {}", curve.length());
            }
            // Obstacles run clockwise whatever the transform mirrors.
            assert!((curve.signed_area() + scale * scale * area).abs() < 1e-9, "{inside} {}", curve.signed_area());
        }
    }
}

#[test]
fn a_circle_is_round_to_a_nanometre() {
    let map = draw("viewBox=\"0 0 300 300\"", "<circle class=\"x arena\" cx=\"150\" cy=\"150\" r=\"140\"/>");
    let center = Vec2::new(0.15, 0.15);
    for s in map.samples(1e-3) {
        assert!((s.position.distance(center) - 0.14).abs() < 1e-9);
        assert!((s.tangent - ((s.position - center).angle() + PI / 2.0)).sin().abs() < 1e-6);
    }
    assert!(map.is_free(center));
}

#[test]
fn roles_come_from_the_nearest_name() {
    let map = draw(
        "viewBox=\"0 0 100 100\"",
        "<defs><rect id=\"arena-in-defs\" width=\"9\" height=\"9\"/></defs>\
         <g style=\"opacity:1; display : none\"><rect id=\"arena-hidden\" width=\"9\" height=\"9\"/></g>\
         <rect display=\"none\" id=\"arena-hidden2\" width=\"9\" height=\"9\"/>\
         <rect inkscape:label=\"Arena\" width=\"100\" height=\"100\"/>\
         <g inkscape:label=\"obstacles\"><rect id=\"rect3\" x=\"10\" y=\"10\" width=\"9\" height=\"9\"/>\
           <path class=\"thin wall\" d=\"M40 40 L 50 50 M 60 60 L 70 60\"/></g>\
         <line id=\"line1\" x1=\"0\" y1=\"0\" x2=\"10\" y2=\"10\"/>",
    );
    let roles: Vec<Role> = map.boundaries().iter().map(|b| b.role()).collect();
    assert_eq!(roles, [Role::Arena, Role::Obstacle, Role::Wall, Role::Wall]);
    assert_eq!(map.boundaries()[1].name(), Some("rect3"));
    assert_eq!(map.warnings.len(), 1);
    assert!(map.warnings[0].contains("line1"), "{}", map.warnings[0]);
}

#[test]
fn holes_alternate() {
    let nested = "M0 0 H100 V100 H0 Z M10 10 V90 H90 V10 Z M20 20 H80 V80 H20 Z";
    for (role, expected) in [("arena", [true, false, true]), ("obstacle", [false, true, false])] {
        let map = draw("viewBox=\"0 0 100 100\"", &format!("<path id=\"{role}\" d=\"{nested}\"/>"));
        let found = [0.005, 0.015, 0.05].map(|v| map.is_free(Vec2::new(v, v)));
        assert_eq!(found, expected, "{role}");
    }
}

#[test]
fn hostile_input_gives_errors() {
    let nested = format!("<svg><g>{}{}</g></svg>", "<g>".repeat(20_000), "</g>".repeat(20_000));
    assert!(vibrissa::io::map::from_svg(&nested, "deep").is_err());
    let lists = format!("{}{}", "[".repeat(100_000), "]".repeat(100_000));
    assert!(vibrissa::io::map::from_geojson(&lists, "deep").is_err());
    let features = "{\"type\":\"FeatureCollection\",\"features\":[".repeat(100_000);
    assert!(vibrissa::io::map::from_geojson(&format!("{features}{}", "]}".repeat(100_000)), "deep").is_err());
    for d in ["M0 0 A1e308 1e308 0 0 1 1e308 0Z", "M1e308 1e308 L -1e308 2 3 4 Z", "M0 0 C 1e9 0 0 1e9 1e9 1e9 Z"] {
        let text = format!("<svg><path id=\"arena\" d=\"{d}\"/></svg>");
        assert!(vibrissa::io::map::from_svg(&text, "huge").is_err(), "{d}");
    }
    let text = "<svg><path id=\"obstacle\" transform=\"scale(1e-300)\" d=\"M0 0 H4 V4 Z\"/></svg>";
    let _ = vibrissa::io::map::from_svg(text, "tiny");
}
