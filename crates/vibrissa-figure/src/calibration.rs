//! The figure of a calibration: curves through measured points, what is left over, and where the curve holds.

use super::axes::round_length;
use super::document::{Document, number};
use std::fmt::Write;

/// One plot of the figure; all points in the units of its labels.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Plot {
    /// What runs to the right, with its unit.
    pub x_label: String,
    /// What runs upwards, with its unit.
    pub y_label: String,
    /// Measured points.
    pub points: Vec<(f64, f64)>,
    /// The fitted curve; empty for residuals. A point that is not finite parts two pieces.
    pub curve: Vec<(f64, f64)>,
    /// Where the curve holds, along x; shaded.
    pub valid: Option<[f64; 2]>,
    /// A stretch of x that must be on the plot, so that plots below each other line up.
    pub span: Option<[f64; 2]>,
    /// Levels to mark across, such as a bound and its opposite.
    pub levels: Vec<f64>,
}

const WIDTH: f64 = 720.0;
const LEFT: f64 = 92.0;
const RIGHT: f64 = 28.0;
const TOP: f64 = 84.0;
/// Height of the first plot and of those below it (px).
const HEIGHTS: [f64; 2] = [260.0, 150.0];
const GAP: f64 = 62.0;

/// The figure of a calibration with these plots, one below the other; `notes` stand under the title.
#[must_use]
pub fn calibration_figure(title: &str, notes: &str, plots: &[Plot]) -> String {
    plots_figure(title, notes, "Measured points, the curve fitted to them, and what is left over.", plots)
}

/// A figure of plots, one below the other; `notes` stand under the title, `description` is for those who do not see it.
#[must_use]
pub fn plots_figure(title: &str, notes: &str, description: &str, plots: &[Plot]) -> String {
    let height_of = |index: usize| HEIGHTS[index.min(1)];
    let height = TOP + (0..plots.len()).map(|index| height_of(index) + GAP).sum::<f64>();
    let mut document = Document::new(WIDTH, height, title, description);
    document.text(LEFT, 32.0, "title", title);
    document.text(LEFT, 56.0, "caption", notes);
    let mut top = TOP;
    for (index, plot) in plots.iter().enumerate() {
        draw(&mut document, plot, top, height_of(index));
        top += height_of(index) + GAP;
    }
    document.finish()
}

/// From the plot's units to the page.
struct Scale {
    min: f64,
    max: f64,
    from: f64,
    to: f64,
}

impl Scale {
    /// Around all values, with a little air.
    fn around(values: impl Iterator<Item = f64>, from: f64, to: f64) -> Self {
        let finite = values.filter(|v| v.is_finite());
        let (lo, hi) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), v| (lo.min(v), hi.max(v)));
        let (lo, hi) = if lo > hi { (0.0, 1.0) } else { (lo, hi) };
        let air = if hi > lo { 0.06 * (hi - lo) } else { 0.5 * lo.abs().max(1e-12) };
        Self { min: lo - air, max: hi + air, from, to }
    }

    fn px(&self, value: f64) -> f64 {
        self.from + (value - self.min) / (self.max - self.min) * (self.to - self.from)
    }

    /// Round values about `spacing` px apart.
    fn ticks(&self, spacing: f64) -> Vec<f64> {
        let step = round_length((self.max - self.min) * spacing / (self.to - self.from).abs());
        let first = (self.min / step).ceil();
        let count = ((self.max / step).floor() - first).clamp(-1.0, 40.0) as i64 + 1;
        (0..count).map(|i| (first + i as f64) * step).collect()
    }
}

fn draw(document: &mut Document, plot: &Plot, top: f64, height: f64) {
    let (left, right, bottom) = (LEFT, WIDTH - RIGHT, top + height);
    let all = || plot.points.iter().chain(&plot.curve);
    let x = Scale::around(all().map(|p| p.0).chain(plot.span.into_iter().flatten()), left, right);
    let zero = plot.curve.is_empty().then_some(0.0);
    let y = Scale::around(all().map(|p| p.1).chain(plot.levels.iter().copied()).chain(zero), bottom, top);
    let mut body = String::new();
    if let Some([lo, hi]) = plot.valid {
        let (from, to) = (number(x.px(lo)), number(x.px(hi) - x.px(lo)));
        // Writing into a string cannot fail.
        let _ = writeln!(
            body,
            "<rect x=\"{from}\" y=\"{}\" width=\"{to}\" height=\"{}\" class=\"extent\"/>",
            number(top - 2.0),
            number(height + 4.0)
        );
    }
    let dots: String = plot.points.iter().map(|p| format!("M{} {}h0", number(x.px(p.0)), number(y.px(p.1)))).collect();
    let _ = writeln!(body, "<path d=\"{dots}\" class=\"survivor\"/>");
    for level in plot.levels.iter().copied().chain(zero) {
        let class = if level.abs() > 0.0 { "zoomed" } else { "tick" };
        let _ = writeln!(body, "<path d=\"M{left} {0}H{right}\" class=\"{class}\"/>", number(y.px(level)));
    }
    for piece in plot.curve.split(|p| !(p.0.is_finite() && p.1.is_finite())).filter(|piece| !piece.is_empty()) {
        let line: Vec<String> = piece.iter().map(|p| format!("{},{}", number(x.px(p.0)), number(y.px(p.1)))).collect();
        let _ = writeln!(body, "<polyline points=\"{}\" class=\"path\"/>", line.join(" "));
    }
    document.clipped((left, top), (right - left, height), &body);
    document.rectangle((left, top), (right - left, height), "panel");
    axes(document, plot, &x, &y, bottom);
}

fn axes(document: &mut Document, plot: &Plot, x: &Scale, y: &Scale, bottom: f64) {
    for value in x.ticks(90.0) {
        document.line((x.px(value), bottom), (x.px(value), bottom + 4.0), "tick");
        document.text(x.px(value), bottom + 17.0, "small middle", &short(value, x));
    }
    for value in y.ticks(45.0) {
        document.line((LEFT - 4.0, y.px(value)), (LEFT, y.px(value)), "tick");
        document.text(LEFT - 8.0, y.px(value) + 4.0, "small end", &short(value, y));
    }
    document.text(WIDTH - RIGHT, bottom + 34.0, "small end", &plot.x_label);
    document.text(LEFT, y.to - 6.0, "small", &plot.y_label);
}

/// Ticks that need more decimals have an exponent: there is no room for more beside the panel.
const MOST_DECIMALS: usize = 6;

/// A tick's value with the digits that its neighbours need.
fn short(value: f64, scale: &Scale) -> String {
    let range = scale.max - scale.min;
    let digits = (2.0 - range.log10()).ceil().clamp(0.0, 9.0) as usize;
    if digits > MOST_DECIMALS {
        // Rounding leaves a little of zero.
        let value = if value.abs() < 1e-6 * range { 0.0 } else { value };
        return format!("{value:.1e}").replace(".0e", "e").replace("0e0", "0");
    }
    let text = format!("{value:.digits$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if text == "-0" { "0".into() } else { text.into() }
}

#[cfg(test)]
mod tests {
    use super::{Plot, Scale, calibration_figure, short};

    #[test]
    fn ticks_of_any_size_are_short() {
        let scale = |size: f64| Scale { min: -size, max: size, from: 0.0, to: 1.0 };
        assert_eq!(short(0.0001, &scale(2e-4)), "0.0001");
        assert_eq!(short(-1e-6, &scale(2e-6)), "-1e-6");
        assert_eq!(short(1.5e-7, &scale(2e-7)), "1.5e-7");
        assert_eq!(short(1e-23, &scale(2e-7)), "0");
        assert_eq!(short(-0.5, &scale(1.0)), "-0.5");
        assert_eq!(short(1e-9, &scale(2e-9)), "1e-9");
    }

    #[test]
    fn a_curve_in_pieces_is_drawn_in_pieces() {
        let curve = vec![(0.0, 0.0), (1.0, 1.0), (f64::NAN, f64::NAN), (2.0, 1.0), (3.0, 0.0)];
        let svg = calibration_figure("", "", &[Plot { curve, ..Plot::default() }]);
        assert_eq!(svg.matches("<polyline").count(), 2);
        assert!(!svg.contains("NaN"));
    }
}
