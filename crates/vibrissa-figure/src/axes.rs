//! Scale bars and axis ticks in round numbers.

use super::canvas::{Canvas, Frame};
use super::document::Document;
use crate::plane::Vec2;

/// The largest of 1, 2, 5 times a power of ten that is at most `limit`; 1 when `limit` is not a positive number.
pub(crate) fn round_length(limit: f64) -> f64 {
    if !(limit.is_finite() && limit > 0.0) {
        return 1.0;
    }
    let decade = 10f64.powi(limit.log10().floor() as i32);
    // The slack admits limits that fall one rounding error short of a round number.
    [10.0, 5.0, 2.0].into_iter().map(|step| step * decade).find(|&step| step <= limit * (1.0 + 1e-12)).unwrap_or(decade)
}

/// A length for people: metres from 1 m on, millimetres below, micrometres below 1 mm.
pub(crate) fn length_label(metres: f64) -> String {
    let (value, unit) = match metres.abs() {
        size if size >= 0.9999 => (metres, "m"),
        size if size >= 0.99e-3 => (metres * 1e3, "mm"),
        _ => (metres * 1e6, "µm"),
    };
    format!("{} {unit}", short(value))
}

fn short(value: f64) -> String {
    let text = format!("{value:.3}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".into() } else { text.into() }
}

/// Draws a scale bar below a panel, its right end under the panel's right edge.
pub(crate) fn scale_bar(document: &mut Document, canvas: &Canvas, drop: f64) {
    let Frame { x, y, width, height } = canvas.frame();
    let length = round_length(0.3 * width / canvas.scale());
    let (right, base) = (x + width, y + height + drop);
    let left = right - length * canvas.scale();
    document.line((left, base), (right, base), "bar");
    for end in [left, right] {
        document.line((end, base - 4.0), (end, base + 4.0), "bar");
    }
    document.text(left - 8.0, base + 4.0, "small end", &length_label(length));
}

/// Draws ticks with the coordinates of a frame, of this name, in millimetres or metres along the lower and the left edge
/// of a panel.
pub(crate) fn ticks(document: &mut Document, canvas: &Canvas, name: &str) {
    let (frame, world) = (canvas.frame(), canvas.world());
    let step = round_length(90.0 / canvas.scale());
    let in_metres = world.min.norm().max(world.max.norm()) >= 10.0;
    let (factor, unit) = if in_metres { (1.0, "m") } else { (1e3, "mm") };
    let bottom = frame.y + frame.height;
    for value in multiples(world.min.x, world.max.x, step) {
        let x = canvas.page(Vec2::new(value, 0.0)).x;
        document.line((x, bottom), (x, bottom + 4.0), "tick");
        document.text(x, bottom + 16.0, "small middle", &short(value * factor));
    }
    for value in multiples(world.min.y, world.max.y, step) {
        let y = canvas.page(Vec2::new(0.0, value)).y;
        document.line((frame.x - 4.0, y), (frame.x, y), "tick");
        document.text(frame.x - 7.0, y + 4.0, "small end", &short(value * factor));
    }
    document.text(frame.x, bottom + 34.0, "small", &format!("{name}, x to the right, y up, {unit}"));
}

fn multiples(min: f64, max: f64, step: f64) -> impl Iterator<Item = f64> {
    let (first, last) = ((min / step).ceil(), (max / step).floor());
    // A panel holds a handful; the limit keeps absurd worlds from running on.
    let count = if last >= first { (last - first).min(50.0) as usize + 1 } else { 0 };
    (0..count).map(move |index| (first + index as f64) * step)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn round_lengths_are_one_two_five_and_never_too_long() {
        for (limit, expected) in
            [(1.0, 1.0), (1.99, 1.0), (2.0, 2.0), (4.99, 2.0), (9.9, 5.0), (0.03, 0.02), (730.0, 500.0)]
        {
            let length = round_length(limit);
            assert!((length - expected).abs() < 1e-12 * expected, "{limit}: {length}");
        }
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(round_length(bad) > 0.0);
        }
    }

    #[test]
    fn labels_carry_the_unit_that_reads_best() {
        let cases = [(2.0, "2 m"), (1.0, "1 m"), (0.05, "50 mm"), (0.001, "1 mm"), (2e-5, "20 µm")];
        for (metres, label) in cases {
            assert_eq!(length_label(metres), label);
        }
    }
}
