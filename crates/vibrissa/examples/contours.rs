//! Tip positions along contours against the shapes that were followed.
//!
//! Usage: `contours FILE...`; the beginning of each file's name tells the object.

#![allow(clippy::print_stdout, reason = "an example prints")]

use core::f64::consts::PI;
use vibrissa::plane::Vec2;
use vibrissa::tasks::profile::{FreeSize, RoundedPolygon, fit_shape};

/// The objects: the beginning of the file's name, and the shape as its makers give it.
fn object(name: &str) -> Option<RoundedPolygon> {
    if name.starts_with("circle") {
        Some(RoundedPolygon::circle(0.080))
    } else if name.starts_with("rounded-square") {
        Some(RoundedPolygon { sides: 4, apothem: 0.080, corner_radius: 0.040 })
    } else if name.starts_with("octagon") {
        Some(RoundedPolygon { sides: 8, apothem: 0.035 / (PI / 8.0).tan(), corner_radius: 0.030 })
    } else {
        None
    }
}

/// `x,y` lines in m (or separated by blanks), or the echo of a twist whose linear part is the position; what is no number is counted.
fn points(text: &str) -> (Vec<Vec2>, usize) {
    if text.trim_start().starts_with("header:") {
        return (echoed(text), 0);
    }
    let (mut points, mut dropped) = (Vec::new(), 0);
    for line in text.lines().filter(|line| !line.trim().is_empty() && !line.starts_with('#')) {
        let cells = line.split([',', ';', ' ', '\t']).filter(|cell| !cell.trim().is_empty());
        // A third number is a height.
        let mut cells = cells.map(|cell| cell.trim().parse::<f64>());
        match (cells.next(), cells.next(), cells.next()) {
            (Some(Ok(x)), Some(Ok(y)), None | Some(Ok(_))) if x.abs() <= 100.0 && y.abs() <= 100.0 => {
                points.push(Vec2::new(x, y))
            }
            _ => dropped += 1,
        }
    }
    (points, dropped)
}

fn echoed(text: &str) -> Vec<Vec2> {
    let (mut points, mut linear, mut x) = (Vec::new(), false, None);
    for line in text.lines().map(str::trim) {
        match line.split_once(':') {
            Some(("linear", _)) => linear = true,
            Some(("angular", _)) => linear = false,
            Some(("x", value)) if linear => x = value.trim().parse().ok(),
            Some(("y", value)) if linear => {
                points.extend(x.zip(value.trim().parse().ok()).map(|(x, y)| Vec2::new(x, y)))
            }
            _ => {}
        }
    }
    points
}

fn main() {
    println!(
        "| file | points | mean residual, known size (mm) | free scale (mm) | scale | free offset (mm) | offset (mm) | free sizes (mm) | apothem, corner radius (mm; known) |"
    );
    println!("| --- | --- | --- | --- | --- | --- | --- | --- | --- |");
    let mut headline = Vec::new();
    for path in std::env::args().skip(1) {
        let name = std::path::Path::new(&path).file_name().unwrap_or_default().to_string_lossy().into_owned();
        let Some(shape) = object(&name) else {
            println!("| {name} | skipped: no object is known under this name | | | | | | | |");
            continue;
        };
        let Ok(text) = std::fs::read(&path).map(|bytes| String::from_utf8_lossy(&bytes).into_owned()) else {
            println!("| {name} | skipped: cannot be read | | | | | | | |");
            continue;
        };
        let (points, dropped) = points(&text);
        let fits = [FreeSize::None, FreeSize::Scale, FreeSize::Offset, FreeSize::All]
            .map(|free| fit_shape(&points, shape, free));
        let [Some(known), Some(scaled), Some(offset), Some(sized)] = fits else {
            println!("| {name} | skipped: {} points | | | | | | | |", points.len());
            continue;
        };
        let dropped = if dropped > 0 { format!(" ({dropped} lines dropped)") } else { String::new() };
        println!(
            "| {name} | {}{dropped} | {:.2} | {:.2} | {:.4} | {:.2} | {:.1} | {:.2} | {:.1}, {:.1} ({:.1}, {:.1}) |",
            points.len(),
            1e3 * known.misfit.mean,
            1e3 * scaled.misfit.mean,
            scaled.shape.apothem / shape.apothem,
            1e3 * offset.misfit.mean,
            1e3 * (offset.shape.apothem - shape.apothem),
            1e3 * sized.misfit.mean,
            1e3 * sized.shape.apothem,
            1e3 * sized.shape.corner_radius,
            1e3 * shape.apothem,
            1e3 * shape.corner_radius
        );
        let stem = name.split('.').next().unwrap_or_default().to_owned();
        headline.push(format!(
            "{stem} {:.2} / {:.2} / {:.2}",
            1e3 * known.misfit.mean,
            1e3 * scaled.misfit.mean,
            1e3 * offset.misfit.mean
        ));
    }
    println!("headline: mean residual (mm), known size / free scale / free offset: {}", headline.join(", "));
}
