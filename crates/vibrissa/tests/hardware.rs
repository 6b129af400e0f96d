//! The hardware's parameters and the page's numbers against the design of the sensor, and against a plate worked out another way.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on must fail")]

use std::collections::BTreeMap;
use vibrissa::beam::{Load, Whisker, point_mode};
use vibrissa::plane::Vec2;
use vibrissa::sensing::{Chip, SensingChain, Tle493d};
use vibrissa::tasks::sensor_design::{SensorDesign, sensor_design};

const SCAD: &str = include_str!("../../../hardware/sensor.scad");
const PAGE: &str = include_str!("../../../docs/build-a-sensor.md");
const PARTS: &str = include_str!("../../../hardware/bill-of-materials.csv");

/// The plain numbers of the `OpenSCAD` source (mm).
fn parameters() -> BTreeMap<&'static str, f64> {
    let one = |line: &'static str| {
        let (name, rest) = line.split_once(" = ")?;
        Some((name, rest.split_once(';')?.0.parse().ok()?))
    };
    SCAD.lines().filter_map(one).collect()
}

fn design(chain: &SensingChain, mm: f64) -> SensorDesign {
    sensor_design(chain, &Whisker::default(), 1e-3 * mm, 20e-3, 0.0).unwrap()
}

/// The moment for each radian (N m) of a rigid hub in a clamped plate, by Ritz's method: the energy of the best of some shapes, which is an
/// upper bound that comes down to the truth.
fn plate(outer: f64, inner: f64, thickness: f64, young: f64) -> f64 {
    let rigidity = young * thickness.powi(3) / (12.0 * (1.0 - 0.25));
    let steps = 4000;
    let width = (outer - inner) / f64::from(steps);
    // Deflections f(r) cos: at the hub f = r, f' = 1; at the rim both 0. A cubic in s that does that, and bumps that change neither.
    let gap = outer - inner;
    let base = |r: f64| {
        let s = (r - inner) / gap;
        let (f, d, dd) = (
            inner * (1.0 - 3.0 * s * s + 2.0 * s * s * s) + gap * (s - 2.0 * s * s + s * s * s),
            (inner * (-6.0 * s + 6.0 * s * s) + gap * (1.0 - 4.0 * s + 3.0 * s * s)) / gap,
            (inner * (-6.0 + 12.0 * s) + gap * (-4.0 + 6.0 * s)) / (gap * gap),
        );
        dd + d / r - f / (r * r)
    };
    let bump = |k: i32, r: f64| {
        let s = (r - inner) / gap;
        // s² (1 - s)² s^k
        let n = [f64::from(k) + 2.0, f64::from(k) + 3.0, f64::from(k) + 4.0];
        let c = [1.0, -2.0, 1.0];
        let sum = |p: fn(f64, f64) -> f64| (0..3).map(|i| c[i] * p(n[i], s)).sum::<f64>();
        let f = sum(|n, s| s.powf(n));
        let d = sum(|n, s| n * s.powf(n - 1.0)) / gap;
        let dd = sum(|n, s| n * (n - 1.0) * s.powf(n - 2.0)) / (gap * gap);
        dd + d / r - f / (r * r)
    };
    const BUMPS: usize = 4;
    let product = |a: &dyn Fn(f64) -> f64, b: &dyn Fn(f64) -> f64| -> f64 {
        (0..steps).map(|i| inner + (f64::from(i) + 0.5) * width).map(|r| a(r) * b(r) * r * width).sum()
    };
    let shapes: Vec<Box<dyn Fn(f64) -> f64>> =
        (0..BUMPS as i32).map(|k| Box::new(move |r| bump(k, r)) as Box<dyn Fn(f64) -> f64>).collect();
    let mut rows: Vec<Vec<f64>> =
        shapes.iter().map(|a| shapes.iter().map(|b| product(a, b)).chain([-product(a, &base)]).collect()).collect();
    for i in 0..BUMPS {
        for j in 0..BUMPS {
            if j != i {
                let share = rows[j][i] / rows[i][i];
                let pivot = rows[i].clone();
                rows[j].iter_mut().zip(&pivot).for_each(|(v, p)| *v -= share * p);
            }
        }
    }
    let best = |r: f64| base(r) + (0..BUMPS).map(|k| rows[k][BUMPS] / rows[k][k] * shapes[k](r)).sum::<f64>();
    rigidity * core::f64::consts::PI * product(&best, &best)
}

#[test]
fn the_drawn_sensor_is_the_one_that_is_designed() {
    let mm = parameters();
    let chain = SensingChain::default();
    assert!((1e-3 * mm["magnet_depth"] + chain.magnet_offset[0]).abs() < 1e-12);
    assert!((1e-3 * mm["magnet_to_chip"] - (chain.magnet_offset[0] - chain.chip_offset[0])).abs() < 1e-12);
    assert!((1e-3 * mm["whisker_length"] - Whisker::default().length).abs() < 1e-12);
    let volume = core::f64::consts::FRAC_PI_4 * mm["magnet_diameter"].powi(2) * mm["magnet_height"] * 1e-9;
    let moment = 1.44 * volume / (4e-7 * core::f64::consts::PI);
    assert!((moment / chain.magnet_moment[0] - 1.0).abs() < 0.01, "{moment}");
    // Gent's relation at Shore 50A.
    let young = 0.0981e6 * (56.0 + 7.62336 * 50.0) / (0.137505 * (254.0 - 2.54 * 50.0));
    let stiffness =
        |thickness: f64| plate(0.5e-3 * mm["rubber_diameter"], 0.5e-3 * mm["hub_diameter"], 1e-3 * thickness, young);
    let drawn = stiffness(mm["rubber_thickness"]);
    assert!((drawn / chain.stiffness - 1.0).abs() < 0.02, "{drawn}");
    for thickness in [1.5, mm["rubber_thickness"], 2.0] {
        let k = stiffness(thickness);
        let count = 1e6 * design(&SensingChain { stiffness: (k * 1e4).round() / 1e4, ..chain }, 5.0).resolution[0];
        let row = PAGE.lines().find(|line| line.starts_with(&format!("| {thickness:.1} mm"))).unwrap();
        assert!(row.contains(&format!("{k:.3} N m/rad")), "{k}: {row}");
        let told: f64 = row.rsplit('|').nth(1).unwrap().trim().trim_end_matches(" µN m").parse().unwrap();
        assert!((told / count - 1.0).abs() < 0.012, "{count}: {row}");
    }
}

#[test]
fn the_pages_numbers_are_computed() {
    let chain = SensingChain::default();
    for mm in [4.5, 5.0, 5.5] {
        let design = design(&chain, mm);
        let rest = design.rest.iter().map(|b| b * b).sum::<f64>().sqrt();
        let row = format!(
            "| {:.2} mT | {:.0} % | {:.2} µN m | {:.4} mm |",
            1e3 * rest,
            100.0 * design.share,
            1e6 * design.resolution[0],
            1e3 * design.tip_noise
        );
        assert!(PAGE.contains(&row), "{mm} mm: {row}");
        let noisy = sensor_design(&chain, &Whisker::default(), 1e-3 * mm, 20e-3, 5e-6).unwrap();
        let row = format!("{row} {:.3} mm |", 1e3 * noisy.tip_noise);
        assert!(PAGE.contains(&row), "{mm} mm with noise: {row}");
    }
    let whisker = Whisker { base_stiffness: chain.stiffness, ..Whisker::default() };
    let pressed = point_mode(&whisker, Vec2::new(0.040, 0.018), Load::Normal).unwrap().remove(0);
    assert!(PAGE.contains(&format!("They reach {:.1} mN m.", 1e3 * pressed.moment)), "{}", pressed.moment);
    let tle = design(&SensingChain { chip: Chip::Tle493d(Tle493d::default()), ..chain }, 5.0);
    assert!(PAGE.contains(&format!("a count is {:.0} µN m", 1e6 * tle.resolution[0])));
}

#[test]
fn every_part_has_its_source() {
    let mut reader = csv_rows(PARTS);
    assert_eq!(reader.remove(0), ["part", "quantity", "what", "source"]);
    assert!(
        reader.len() > 10 && reader.iter().all(|row| row.len() == 4 && row[1].parse::<u32>().is_ok()),
        "{reader:?}"
    );
    for figure in ["section", "parts", "wiring", "axes", "calibration"] {
        assert!(PAGE.contains(&format!("figures/build-{figure}.svg")), "{figure}");
    }
}

/// Rows of a CSV file with quotes.
fn csv_rows(text: &str) -> Vec<Vec<String>> {
    let row = |line: &str| {
        let (mut cells, mut quoted) = (vec![String::new()], false);
        for c in line.chars() {
            match c {
                '"' => quoted = !quoted,
                ',' if !quoted => cells.push(String::new()),
                _ => cells.last_mut().unwrap().push(c),
            }
        }
        cells
    };
    text.lines().map(row).collect()
}
