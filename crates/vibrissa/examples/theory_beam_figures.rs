//! Draws the figures of `docs/theory-beam.md`. Usage: `cargo run --example theory_beam_figures [-- FOLDER]`

use std::fmt::Write;
use std::path::Path;
use vibrissa::beam::normal::{by_force, largest_moment};
use vibrissa::beam::{Load, Whisker, force_mode};
use vibrissa::plane::Vec2;

const COLOURS: [&str; 2] = ["#0072b2", "#d55e00"];

/// A plot with axes, in the units of its data.
struct Plot {
    lo: Vec2,
    hi: Vec2,
    size: Vec2,
    body: String,
}

impl Plot {
    fn new(lo: (f64, f64), hi: (f64, f64), size: (f64, f64)) -> Self {
        let v = |p: (f64, f64)| Vec2::new(p.0, p.1);
        Self { lo: v(lo), hi: v(hi), size: v(size), body: String::new() }
    }

    fn page(&self, p: Vec2) -> (f64, f64) {
        let share = Vec2::new((p.x - self.lo.x) / (self.hi.x - self.lo.x), (p.y - self.lo.y) / (self.hi.y - self.lo.y));
        (60.0 + share.x * self.size.x, 16.0 + (1.0 - share.y) * self.size.y)
    }

    fn line(&mut self, points: &[Vec2], style: &str) {
        let list: Vec<String> = points.iter().map(|&p| self.page(p)).map(|(x, y)| format!("{x:.1},{y:.1}")).collect();
        let _ = writeln!(self.body, "<polyline points=\"{}\" fill=\"none\" {style}/>", list.join(" "));
    }

    fn text(&mut self, at: Vec2, text: &str, style: &str) {
        let (x, y) = self.page(at);
        let _ = writeln!(self.body, "<text x=\"{x:.1}\" y=\"{y:.1}\" {style}>{text}</text>");
    }

    fn svg(mut self, x: &str, y: &str, step: (f64, f64)) -> String {
        let (lo, hi) = (self.lo, self.hi);
        let curves = std::mem::take(&mut self.body);
        for i in 0..=((hi.x - lo.x) / step.0).round() as i32 {
            let at = lo.x + f64::from(i) * step.0;
            self.line(&[Vec2::new(at, lo.y), Vec2::new(at, hi.y)], "stroke=\"#ddd\"");
            self.text(Vec2::new(at, lo.y), &format!("{at:.0}"), "dy=\"16\" text-anchor=\"middle\"");
        }
        for i in 0..=((hi.y - lo.y) / step.1).round() as i32 {
            let at = lo.y + f64::from(i) * step.1;
            self.line(&[Vec2::new(lo.x, at), Vec2::new(hi.x, at)], "stroke=\"#ddd\"");
            self.text(Vec2::new(lo.x, at), &format!("{at:.1}"), "dx=\"-6\" dy=\"4\" text-anchor=\"end\"");
        }
        self.text(Vec2::new(0.5 * (lo.x + hi.x), lo.y), x, "dy=\"36\" text-anchor=\"middle\"");
        self.text(Vec2::new(lo.x, hi.y), y, "dx=\"8\" dy=\"16\"");
        let (width, height) = (self.size.x + 80.0, self.size.y + 64.0);
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" font-family=\"sans-serif\" \
             font-size=\"12\"><rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n{}{curves}</svg>\n",
            self.body
        )
    }
}

/// The paper's whisker, pushed at 60 mm by 0.025 N to 0.4 N, by a normal and by a vertical load.
fn shapes() -> vibrissa::Result<String> {
    let whisker = Whisker::default();
    let mut plot = Plot::new((-20.0, 0.0), (80.0, 70.0), (600.0, 420.0));
    for (load, colour) in [Load::Normal, Load::Vertical].into_iter().zip(COLOURS) {
        for force in [0.025, 0.05, 0.1, 0.2, 0.4] {
            if let Some(bend) = force_mode(&whisker, force, 0.06, load)?.first() {
                let shape: Vec<Vec2> = bend.shape(0.075, 151).iter().map(|&p| 1e3 * p).collect();
                plot.line(&shape, &format!("stroke=\"{colour}\" stroke-width=\"2\""));
                let direction = bend.force_vector() * (5.0 / force);
                let contact = 1e3 * bend.contact;
                plot.line(&[contact - direction, contact], "stroke=\"#222\" stroke-width=\"1.5\"");
            }
        }
    }
    for (i, (name, colour)) in ["normal load", "vertical load"].into_iter().zip(COLOURS).enumerate() {
        plot.text(Vec2::new(-16.0, 62.0 - 4.0 * i as f64), name, &format!("fill=\"{colour}\""));
    }
    Ok(plot.svg("x (mm)", "y (mm)", (20.0, 10.0)))
}

/// The base moment over the slope at the contact: one moment, two shapes.
fn moments() -> String {
    let mut plot = Plot::new((0.0, 0.0), (180.0, 3.0), (600.0, 300.0));
    let shape = |i: i32| by_force(1.0, 2.0 * 6.875 * f64::from(i) / 600.0, 1.0);
    let points: Vec<_> = (0..=600).filter_map(shape).collect();
    let curve: Vec<Vec2> = points.iter().map(|b| Vec2::new(b.phi_a.to_degrees(), b.moment)).collect();
    let top = curve.iter().position(|p| p.y >= largest_moment() - 1e-4).unwrap_or(0);
    for (part, colour) in [&curve[..=top], &curve[top..]].into_iter().zip(COLOURS) {
        plot.line(part, &format!("stroke=\"{colour}\" stroke-width=\"2\""));
    }
    plot.line(&[Vec2::new(0.0, 2.0), Vec2::new(180.0, 2.0)], "stroke=\"#222\" stroke-dasharray=\"4 4\"");
    plot.text(Vec2::new(76.0, 2.05), "a reading of 2 EI / s_a has two shapes", "");
    plot.text(Vec2::new(curve[top].x, largest_moment()), "2.944", "dy=\"16\" text-anchor=\"middle\"");
    plot.svg("slope at the contact (deg)", "M0 s_a / EI", (30.0, 0.5))
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = std::env::args().nth(1).unwrap_or_else(|| "docs/figures".into());
    std::fs::create_dir_all(&folder)?;
    std::fs::write(Path::new(&folder).join("beam-shapes.svg"), shapes()?)?;
    std::fs::write(Path::new(&folder).join("beam-moment.svg"), moments())?;
    Ok(())
}
