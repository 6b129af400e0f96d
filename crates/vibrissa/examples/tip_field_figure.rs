//! Draws `docs/figures/tip-field.svg`. Usage: `cargo run --release --example tip_field_figure [-- FOLDER]`

use std::fmt::Write;
use std::path::Path;
use vibrissa::beam::Whisker;
use vibrissa::beam::field::{SideField, TipField};
use vibrissa::plane::Vec2;

const STABLE: &str = "#0072b2";
const UNSTABLE: &str = "#d55e00";
/// Base moments that are drawn (mN m).
const LEVELS: [f64; 9] = [-6.0, -4.0, -2.0, 0.0, 2.0, 4.0, 6.0, 8.0, 10.0];
/// Nodes of the chart along each side.
const N: usize = 160;
/// Pixels of a millimetre.
const SCALE: f64 = 4.2;

/// A node of a chart: where the contact lies (mm), and numbers of which level curves are drawn.
#[derive(Clone, Copy)]
struct Node {
    at: Vec2,
    moment: f64,
    /// Positive where stable.
    stable: f64,
    force: Vec2,
}

struct Panel {
    left: f64,
    /// The least x that is shown (mm).
    start: f64,
    body: String,
}

impl Panel {
    fn page(&self, p: Vec2) -> (f64, f64) {
        (self.left + SCALE * (p.x - self.start), 36.0 + SCALE * (80.0 - p.y))
    }

    fn line(&mut self, a: Vec2, b: Vec2, style: &str) {
        let ((x0, y0), (x1, y1)) = (self.page(a), self.page(b));
        let _ = writeln!(self.body, "<path d=\"M{x0:.1} {y0:.1}L{x1:.1} {y1:.1}\" {style}/>");
    }

    fn text(&mut self, at: Vec2, text: &str, style: &str) {
        let (x, y) = self.page(at);
        let _ = writeln!(self.body, "<text x=\"{x:.1}\" y=\"{y:.1}\" {style}>{text}</text>");
    }

    fn axes(&mut self, title: &str) {
        for i in (self.start / 10.0) as i32..=8 {
            let x = 10.0 * f64::from(i);
            self.line(Vec2::new(x, -10.0), Vec2::new(x, 80.0), "stroke=\"#e4e4e4\"");
            self.text(Vec2::new(x, -10.0), &format!("{x:.0}"), "dy=\"15\" text-anchor=\"middle\"");
        }
        for i in -1..=8 {
            let y = 10.0 * f64::from(i);
            self.line(Vec2::new(self.start, y), Vec2::new(80.0, y), "stroke=\"#e4e4e4\"");
            self.text(Vec2::new(self.start, y), &format!("{y:.0}"), "dx=\"-5\" dy=\"4\" text-anchor=\"end\"");
        }
        self.text(Vec2::new(30.0, -10.0), "x (mm)", "dy=\"31\" text-anchor=\"middle\"");
        self.text(Vec2::new(self.start, 80.0), "y (mm)", "dx=\"-16\" dy=\"-8\"");
        self.text(Vec2::new(30.0, 80.0), title, "dy=\"-12\" text-anchor=\"middle\" font-weight=\"bold\"");
        self.line(Vec2::ZERO, Vec2::new(75.0, 0.0), "stroke=\"#222\" stroke-width=\"3\"");
    }

    /// The curve `of(node) = 0` over a chart, coloured by stability; returns its points.
    fn level(&mut self, chart: &[Vec<Node>], of: impl Fn(&Node) -> f64) -> Vec<Node> {
        let (mut seen, mut paths) = (Vec::new(), [String::new(), String::new()]);
        for i in 1..chart.len() {
            for j in 1..chart[i].len().min(chart[i - 1].len()) {
                for corners in [[(i - 1, j - 1), (i, j - 1), (i, j)], [(i - 1, j - 1), (i, j), (i - 1, j)]] {
                    let nodes = corners.map(|(p, q)| chart[p][q]);
                    let crossing = |k: usize| {
                        let (a, b) = (nodes[k], nodes[(k + 1) % 3]);
                        let (x, y) = (of(&a), of(&b));
                        ((x < 0.0) != (y < 0.0)).then(|| a.at + x / (x - y) * (b.at - a.at))
                    };
                    let ends: Vec<Vec2> = (0..3).filter_map(crossing).collect();
                    // Neighbours far apart belong to different parts of the chart.
                    if let [a, b] = ends[..]
                        && a.distance(b) < 4.0
                    {
                        let ((x0, y0), (x1, y1)) = (self.page(a), self.page(b));
                        let path = &mut paths[usize::from(nodes[0].stable < 0.0)];
                        let _ = write!(path, "M{x0:.1} {y0:.1}L{x1:.1} {y1:.1}");
                        seen.push(Node { at: a, ..nodes[0] });
                    }
                }
            }
        }
        for (path, colour) in paths.iter().zip([STABLE, UNSTABLE]).filter(|(path, _)| !path.is_empty()) {
            let _ = writeln!(self.body, "<path d=\"{path}\" stroke=\"{colour}\" stroke-width=\"1.4\"/>");
        }
        seen
    }

    /// The level curves of the moment, each labelled where `score` is the largest.
    fn moments(&mut self, chart: &[Vec<Node>], score: impl Fn(Vec2) -> f64, offset: &str) {
        for level in LEVELS {
            let seen = self.level(chart, |n| n.moment - level);
            let stable = seen.iter().filter(|n| n.stable > 0.0 && n.at.norm() > 8.0);
            if let Some(top) = stable.max_by(|a, b| score(a.at).total_cmp(&score(b.at))) {
                self.text(top.at, &format!("{level}"), &format!("{offset} fill=\"{STABLE}\""));
            }
        }
    }

    fn arrow(&mut self, node: &Node) {
        let (from, direction) = (node.at, node.force * (4.5 / node.force.norm()));
        let (to, side) = (from + direction, 0.35 * direction.perp());
        self.line(from, to, "stroke=\"#222\" stroke-width=\"0.9\"");
        self.line(to, to - 0.35 * direction + 0.5 * side, "stroke=\"#222\" stroke-width=\"0.9\"");
        self.line(to, to - 0.35 * direction - 0.5 * side, "stroke=\"#222\" stroke-width=\"0.9\"");
    }

    fn edge(&mut self, nodes: &[Node], style: &str) {
        for pair in nodes.windows(2).filter(|pair| pair[0].at.distance(pair[1].at) < 15.0) {
            self.line(pair[0].at, pair[1].at, style);
        }
    }
}

fn share(i: usize) -> f64 {
    i as f64 / N as f64
}

fn tip_panel(whisker: &Whisker) -> vibrissa::Result<Panel> {
    let field = TipField::new(whisker)?;
    let node = |tilt: f64, load: f64| {
        let s = field.at(tilt, load * load * field.largest_force(tilt, 1.0) * 0.9999)?;
        let stable = -s.by_tilt.position.cross(s.by_force.position);
        Some(Node { at: 1e3 * s.position, moment: 1e3 * s.moment, stable, force: s.force_vector() })
    };
    let column = |i: usize| {
        let tilt = 1.449 * (2.0 * share(i) - 1.0);
        (1..=N).filter_map(|j| node(tilt, share(j))).collect::<Vec<_>>()
    };
    let chart: Vec<Vec<Node>> = (0..=N).map(column).collect();
    let mut panel = Panel { left: 50.0, start: -50.0, body: String::new() };
    panel.axes("contact at the tip");
    panel.moments(&chart, |p| -p.x, "dx=\"-3\" dy=\"13\" text-anchor=\"end\"");
    let grey = "stroke=\"#888\" stroke-width=\"1.2\"";
    panel.edge(&chart[0], grey);
    panel.edge(&chart[N], grey);
    let last: Vec<Node> = chart.iter().filter_map(|column| column.last().copied()).collect();
    panel.edge(&last, grey);
    for tilt in [-1.2, -0.8, -0.4, 0.0, 0.4, 0.8, 1.2] {
        for load in [0.35, 0.5, 0.65, 0.8] {
            if let Some(n) = node(tilt, load).filter(|n| n.stable > 0.0) {
                panel.arrow(&n);
            }
        }
    }
    Ok(panel)
}

fn side_panel(whisker: &Whisker) -> vibrissa::Result<Panel> {
    let field = SideField::new(whisker)?;
    let node = |s_a: f64, load: f64| {
        let s = field.at(s_a, load * load * field.largest_force(s_a, 1.0) * 0.9999)?;
        let force = s.force * Vec2::from_angle(s.direction());
        // With the contact point held: nothing folds before its polar angle turns back.
        let stable = -s.by_arc_length.position.cross(s.by_force.position);
        Some(Node { at: 1e3 * s.position, moment: 1e3 * s.moment, stable: -stable, force })
    };
    let column = |i: usize| {
        let s_a = whisker.length * (0.1 + 0.9 * share(i));
        (1..=N).filter_map(|j| node(s_a, share(j))).collect::<Vec<_>>()
    };
    let chart: Vec<Vec<Node>> = (0..=N).map(column).collect();
    let mut panel = Panel { left: 650.0, start: -20.0, body: String::new() };
    panel.axes("contact at the side, frictionless");
    panel.moments(&chart, |p| p.x + 0.3 * p.y, "dx=\"5\" dy=\"4\"");
    let grey = "stroke=\"#888\" stroke-width=\"1.2\"";
    panel.edge(&chart[0], grey);
    panel.edge(&chart[N], grey);
    let last: Vec<Node> = chart.iter().filter_map(|column| column.last().copied()).collect();
    panel.edge(&last, grey);
    for s_a in [0.03, 0.045, 0.06, 0.074] {
        for load in [0.35, 0.5, 0.65, 0.8] {
            if let Some(n) = node(s_a, load) {
                panel.arrow(&n);
            }
        }
    }
    Ok(panel)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = std::env::args().nth(1).unwrap_or_else(|| "docs/figures".into());
    std::fs::create_dir_all(&folder)?;
    let whisker = Whisker::default();
    let (tip, side) = (tip_panel(&whisker)?, side_panel(&whisker)?);
    let mut key = String::new();
    let words = [
        (STABLE, 60.0, "base moment (mN m), stable while the contact is held"),
        (UNSTABLE, 430.0, "beyond the fold of the chart"),
        ("#888", 660.0, "limit of the field"),
    ];
    for (colour, x, text) in words {
        let _ = writeln!(
            key,
            "<path d=\"M{x} 478h26\" stroke=\"{colour}\" stroke-width=\"2\"/><text x=\"{}\" y=\"482\">{text}</text>",
            x + 32.0
        );
    }
    let svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 1090 496\" font-family=\"sans-serif\" font-size=\"12\">\
         <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n{}{}{key}\
         <path d=\"M840 478h22m-5 -3l5 3l-5 3\" stroke=\"#222\" fill=\"none\"/><text x=\"868\" y=\"482\">force on the whisker</text></svg>\n",
        tip.body, side.body
    );
    std::fs::write(Path::new(&folder).join("tip-field.svg"), svg)?;
    Ok(())
}
