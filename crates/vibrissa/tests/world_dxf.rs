//! CAD drawings: units, curves against closed forms, pieces joined to outlines, roles, holes, faults.

#![allow(clippy::unwrap_used, reason = "helpers of tests may fail like tests")]

#[path = "data/random.rs"]
#[allow(dead_code, reason = "not every test draws all kinds")]
mod random;

use random::Random;
use std::f64::consts::{PI, TAU};
use std::fmt::Write as _;
use vibrissa::plane::{Curve, Vec2};
use vibrissa::world::{Map, Role};

/// A drawing of these entities, each a list of codes and values.
fn drawing(units: Option<u32>, entities: &[&str]) -> String {
    let mut text = String::from("999\nby hand\n  0\nSECTION\n  2\nHEADER\n  9\n$ACADVER\n  1\nAC1015\n");
    if let Some(units) = units {
        write!(text, "  9\n$INSUNITS\n 70\n     {units}\n").unwrap();
    }
    text.push_str("  0\nENDSEC\n  0\nSECTION\n  2\nENTITIES\n");
    for entity in entities {
        for word in entity.split_whitespace() {
            let (code, value) = word.split_once('=').unwrap();
            write!(text, "{code:>3}\n{value}\n").unwrap();
        }
    }
    text + "  0\nENDSEC\n  0\nEOF\n"
}

fn draw(entities: &[&str]) -> Map {
    vibrissa::io::map::from_dxf(&drawing(Some(4), entities), "map.dxf").unwrap()
}

fn refused(entities: &[&str]) -> String {
    vibrissa::io::map::from_dxf(&drawing(Some(4), entities), "map.dxf").unwrap_err().to_string()
}

fn curve(map: &Map) -> &Curve {
    map.boundaries()[0].curve()
}

const SQUARE: &str = "0=LWPOLYLINE 8=arena 90=4 70=1 10=0 20=0 10=40 20=0 10=40 20=40 10=0 20=40";

#[test]
fn units_scale_the_map() {
    for (units, size) in
        [(Some(4), 0.04), (Some(1), 1.016), (Some(2), 12.192), (Some(5), 0.4), (Some(6), 40.0), (Some(14), 4.0)]
    {
        let map = vibrissa::io::map::from_dxf(&drawing(units, &[SQUARE]), "map.dxf").unwrap();
        assert!((map.bounds().size().x - size).abs() < 1e-12 * size.max(1.0), "{units:?}");
        assert!(map.warnings.is_empty(), "{units:?} {:?}", map.warnings);
    }
    for units in [None, Some(0)] {
        let map = vibrissa::io::map::from_dxf(&drawing(units, &[SQUARE]), "map.dxf").unwrap();
        assert!((map.bounds().size().x - 0.04).abs() < 1e-15);
        assert!(map.warnings[0].contains("millimetres are assumed"), "{:?}", map.warnings);
    }
    let error = vibrissa::io::map::from_dxf(&drawing(Some(19), &[SQUARE]), "map.dxf").unwrap_err();
    assert_eq!(error.line(), Some(14));
}

#[test]
fn lengths_and_areas_are_those_of_the_closed_forms() {
    let spline = "0=SPLINE 8=obstacle 70=8 71=2";
    let quarter_turns = format!(
        "{spline} 40=0 40=0 40=0 40=1 40=1 40=2 40=2 40=3 40=3 40=4 40=4 40=4 \
         10=20 20=0 41=1 10=20 20=20 41=H 10=0 20=20 41=1 10=-20 20=20 41=H 10=-20 20=0 41=1 10=-20 20=-20 41=H \
         10=0 20=-20 41=1 10=20 20=-20 41=H 10=20 20=0 41=1"
    )
    .replace("=H", &format!("={}", 0.5_f64.sqrt()));
    let parabola = format!("{spline} 40=0 40=0 40=0 40=7 40=7 40=7 10=0 20=0 10=15 20=40 10=30 20=0");
    let cases: [(&[&str], f64, f64); 8] = [
        (&["0=CIRCLE 8=obstacle 10=5 20=-3 40=20"], TAU * 0.02, PI * 4e-4),
        // The same circle as two bulges, then as two bulges the other way round.
        (&["0=LWPOLYLINE 8=obstacle 70=1 10=-20 20=0 42=1 10=20 20=0 42=1"], TAU * 0.02, PI * 4e-4),
        (&["0=LWPOLYLINE 8=obstacle 70=1 10=-20 20=0 42=-1 10=20 20=0 42=-1"], TAU * 0.02, PI * 4e-4),
        // Three quarters of a disc: an arc of 270 degrees has the bulge tan 67.5 degrees.
        (
            &["0=LWPOLYLINE 8=obstacle 70=1 10=20 20=0 42=2.414213562373095 10=0 20=-20 10=0 20=0"],
            0.04 + 1.5 * PI * 0.02,
            0.75 * PI * 4e-4,
        ),
        // Two half discs of an arc and a line each, drawn as pieces.
        (
            &["0=ARC 8=obstacle 10=0 20=0 40=20 50=90 51=270", "0=LINE 8=obstacle 10=0 20=20 11=0 21=-20"],
            0.04 + PI * 0.02,
            0.5 * PI * 4e-4,
        ),
        (&["0=ELLIPSE 8=obstacle 10=1 20=2 11=0 21=20 40=0.5 41=0 42=6.283185307179586"], f64::NAN, PI * 2e-4),
        (&[&quarter_turns], TAU * 0.02, PI * 4e-4),
        (&[&parabola, "0=LINE 8=obstacle 10=30 20=0 11=0 21=0"], f64::NAN, 4e-4),
    ];
    for (entities, length, area) in cases {
        let map = draw(entities);
        assert_eq!(map.boundaries().len(), 1, "{entities:?}");
        let found = curve(&map);
        assert!((found.signed_area().abs() - area).abs() < 2e-7 * area, "{entities:?} {}", found.signed_area());
        if !length.is_nan() {
            assert!((found.length() - length).abs() < 1e-7 * length, "{entities:?} {}", found.length());
        }
    }
}

#[test]
fn old_polylines_are_light_ones() {
    let vertices = [[0.0, 0.0, 0.3], [40.0, 0.0, -0.7], [40.0, 30.0, 0.0], [0.0, 30.0, 2.0]];
    let (mut light, mut heavy) =
        (String::from("0=LWPOLYLINE 8=arena 70=1"), vec!["0=POLYLINE 8=arena 66=1 70=1".to_owned()]);
    for [x, y, bulge] in vertices {
        write!(light, " 10={x} 20={y} 42={bulge}").unwrap();
        heavy.push(format!("0=VERTEX 8=arena 10={x} 20={y} 30=0 42={bulge}"));
    }
    heavy.push("0=SEQEND 8=arena".into());
    let heavy: Vec<&str> = heavy.iter().map(String::as_str).collect();
    assert_eq!(curve(&draw(&[&light])), curve(&draw(&heavy)));
}

/// The B-spline by its basis functions: the recursion of Cox and de Boor, from the definition.
fn basis(knots: &[f64], i: usize, degree: usize, u: f64) -> f64 {
    if degree == 0 {
        return f64::from(knots[i] <= u && u < knots[i + 1]);
    }
    let part = |num: f64, den: f64| if den > 0.0 { num / den } else { 0.0 };
    part(u - knots[i], knots[i + degree] - knots[i]) * basis(knots, i, degree - 1, u)
        + part(knots[i + degree + 1] - u, knots[i + degree + 1] - knots[i + 1]) * basis(knots, i + 1, degree - 1, u)
}

#[test]
fn splines_lie_on_their_definition() {
    let mut random = Random(11);
    for degree in 1..=5 {
        for weighted in [false, true] {
            let n = degree + 5;
            let mut knots: Vec<f64> = (0..=n + degree).map(|_| random.between(0.0, 9.0)).collect();
            knots.sort_by(f64::total_cmp);
            let points: Vec<Vec2> = (0..n).map(|i| Vec2::new(20.0 * i as f64, random.between(-30.0, 30.0))).collect();
            let weights: Vec<f64> = (0..n).map(|_| if weighted { random.between(0.5, 2.0) } else { 1.0 }).collect();
            let mut text = format!("0=SPLINE 8=wall 70=8 71={degree}");
            knots.iter().for_each(|k| write!(text, " 40={k}").unwrap());
            points.iter().zip(&weights).for_each(|(p, w)| {
                let weight = if weighted { format!(" 41={w}") } else { String::new() };
                write!(text, " 10={} 20={}{weight}", p.x, p.y).unwrap();
            });
            let map = draw(&[&text]);
            for k in 0..200 {
                let u = knots[degree] + (knots[n] - knots[degree]) * (f64::from(k) + 0.5) / 200.0;
                let mut sum = (Vec2::ZERO, 0.0);
                for i in 0..n {
                    let b = basis(&knots, i, degree, u) * weights[i];
                    sum = (sum.0 + points[i] * b, sum.1 + b);
                }
                let true_point = sum.0 * (1e-3 / sum.1);
                let miss = map.nearest(true_point).unwrap().distance;
                assert!(miss < 2e-9, "degree {degree}, weighted {weighted}, u {u}: {miss:e}");
            }
        }
    }
}

#[test]
fn pieces_in_any_order_and_direction_are_one_outline() {
    let mut random = Random(3);
    let corners: Vec<Vec2> = (0..12).map(|k| Vec2::from_angle(f64::from(k) * TAU / 12.0) * 50.0).collect();
    let whole: f64 = (0..12).map(|k| corners[k].cross(corners[(k + 1) % 12])).sum::<f64>() * 0.5e-6;
    for _ in 0..20 {
        let mut lines: Vec<(f64, String)> = (0..12)
            .map(|k| {
                let (mut a, mut b) = (corners[k], corners[(k + 1) % 12]);
                if random.between(0.0, 1.0) < 0.5 {
                    std::mem::swap(&mut a, &mut b);
                }
                // Coordinates as programs round them.
                (
                    random.between(0.0, 1.0),
                    format!("0=LINE 8=Arena_outline 10={:.5} 20={:.5} 11={:.5} 21={:.5}", a.x, a.y, b.x, b.y),
                )
            })
            .collect();
        lines.sort_by(|a, b| a.0.total_cmp(&b.0));
        let lines: Vec<&str> = lines.iter().map(|(_, line)| line.as_str()).collect();
        let map = draw(&lines);
        assert_eq!(map.boundaries().len(), 1);
        assert!((curve(&map).signed_area() - whole).abs() < 1e-9);
    }
    let gap = refused(&["0=LINE 8=arena 10=0 20=0 11=9 21=0", "0=LINE 8=arena 10=9 20=0.5 11=0 21=0"]);
    assert!(gap.contains("the outline is open") && gap.contains("layer \"arena\""), "{gap}");
}

#[test]
fn layers_give_roles_and_nesting_gives_holes() {
    let ring = |layer: &str, r: f64| format!("0=CIRCLE 8={layer} 10=0 20=0 40={r}");
    let entities = [
        ring("arena", 100.0),
        ring("OBSTACLES", 40.0),
        ring("OBSTACLES", 20.0),
        "0=LINE 8=wall-3 10=50 20=0 11=60 21=0".into(),
        ring("Bemassung", 9.0),
    ];
    let entities: Vec<&str> = entities.iter().map(String::as_str).collect();
    let map = draw(&entities);
    let roles: Vec<Role> = map.boundaries().iter().map(|b| b.role()).collect();
    assert_eq!(roles, [Role::Arena, Role::Obstacle, Role::Obstacle, Role::Wall]);
    for (x, free) in [(0.01, true), (0.03, false), (0.07, true), (0.11, false)] {
        assert_eq!(map.is_free(Vec2::new(x, 1e-4)), free, "{x}");
    }
    assert_eq!(map.warnings, ["layers without a role were ignored: Bemassung"]);
    // Seen from below, x runs the other way; paper space is another sheet.
    let below = draw(&["0=CIRCLE 8=arena 10=30 20=5 40=10 230=-1", "0=CIRCLE 8=arena 67=1 10=500 20=0 40=10"]);
    let middle = (below.bounds().min + below.bounds().max) * 0.5;
    assert!((middle - Vec2::new(-0.03, 0.005)).norm() < 1e-6);
    assert_eq!(below.boundaries().len(), 1);
}

#[test]
fn faults_name_line_and_remedy() {
    let line_of = |text: &str| vibrissa::io::map::from_dxf(text, "map.dxf").unwrap_err();
    for (entities, told) in [
        (
            vec!["0=CIRCLE 8=arena 10=0 20=0 40=-1"],
            "map.dxf:22: CIRCLE on layer \"arena\": the radius: -1 (allowed: above 0)",
        ),
        (
            vec!["0=CIRCLE 8=arena 10=0 20=zero 40=1"],
            "map.dxf:28: CIRCLE on layer \"arena\": the group 20 cannot be read",
        ),
        (vec!["0=CIRCLE 8=arena 10=0 40=1"], "the group 20 is missing"),
        (vec!["0=CIRCLE 8=arena 10=0 20=1e9 40=1"], "coordinate out of range"),
        (vec!["0=CIRCLE 8=arena 10=0 20=0 40=1 210=1 230=0"], "does not lie in the drawing plane"),
        (vec!["0=INSERT 8=arena 2=room 10=0 20=0"], "explode the block"),
        (vec!["0=HATCH 8=obstacles 10=0 20=0"], "draw its outline as a polyline"),
        (vec!["0=SPLINE 8=wall 71=3 11=0 21=0 11=1 21=1"], "no control points"),
        (vec!["0=SPLINE 8=wall 71=3 40=0 10=0 20=0 10=1 20=1"], "knots"),
        (vec!["0=CIRCLE 8=0 10=0 20=0 40=1", "0=CIRCLE 8=Aren 10=0 20=0 40=1"], "did you mean `arena`?"),
        (vec!["0=LWPOLYLINE 8=arena 70=1 10=0 20=0 10=9 20=9 10=9 20=0 10=0 20=9"], "crosses itself"),
        (vec![], "nothing is drawn"),
    ] {
        let error = refused(&entities);
        assert!(error.contains(told), "{error}");
    }
    let whole = drawing(Some(4), &[SQUARE]);
    assert!(line_of(&whole.replace("  0\nEOF\n", "")).to_string().contains("ends too early"));
    assert_eq!(line_of(&whole.replace(" 90\n4", "x90\n4")).line(), Some(25));
    assert!(line_of("").to_string().contains("the map file is empty"));
    let folder = std::env::temp_dir().join(format!("vibrissa_dxf_{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("bin.dxf"), b"AutoCAD Binary DXF\r\n\x1a\0\xff").unwrap();
    let binary = vibrissa::read_map(folder.join("bin.dxf")).unwrap_err().to_string();
    assert!(binary.contains("save it as ASCII DXF"), "{binary}");
    // Layer names in an old code page do not stand in the way.
    let mut old = drawing(Some(6), &[SQUARE]).into_bytes();
    let at = old.windows(5).position(|w| w == b"arena").unwrap() + 5;
    old.insert(at, 0xe4);
    std::fs::write(folder.join("old.dxf"), old).unwrap();
    assert_eq!(vibrissa::read_map(folder.join("old.dxf")).unwrap().boundaries().len(), 1);
    std::fs::remove_dir_all(folder).unwrap();
}
