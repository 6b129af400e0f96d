//! Draws `docs/figures/tip-field.svg`. Usage: `cargo run --release --example tip_field_figure [-- FOLDER]`

use std::fmt::Write;
use std::path::Path;
use vibrissa::beam::Whisker;
use vibrissa::beam::field::{SideField, TipField};
use vibrissa::plane::Vec2;

const STABLE: &str = "#0072b2";
const UNSTABLE: &str = "#d55e00";
/// Base moments that are drawn (mN m).
const LEVELS: [f64; 7] = [0.5, 1.0, 2.0, 4.0, 6.0, 8.0, 10.0];
/// Nodes of the chart along each side.
const N: usize = 400;

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
    body: String,
}

impl Panel {
    fn page(&self, p: Vec2) -> (f64, f64) {
        (self.left + 5.0 * (p.x + 22.0), 36.0 + 5.0 * (80.0 - p.y))
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
        for i in -2..=7 {
            let x = 10.0 * f64::from(i);
            self.line(Vec2::new(x, -10.0), Vec2::new(x, 80.0), "stroke=\"#e4e4e4\"");
            self.text(Vec2::new(x, -10.0), &format!("{x:.0}"), "dy=\"15\" text-anchor=\"middle\"");
        }
        for i in -1..=8 {
            let y = 10.0 * f64::from(i);
            self.line(Vec2::new(-20.0, y), Vec2::new(78.0, y), "stroke=\"#e4e4e4\"");
            self.text(Vec2::new(-20.0, y), &format!("{y:.0}"), "dx=\"-5\" dy=\"4\" text-anchor=\"end\"");
        }
        self.text(Vec2::new(29.0, -10.0), "x (mm)", "dy=\"31\" text-anchor=\"middle\"");
        self.text(Vec2::new(-20.0, 80.0), "y (mm)", "dx=\"-16\" dy=\"-8\"");
        self.text(Vec2::new(29.0, 80.0), title, "dy=\"-12\" text-anchor=\"middle\" font-weight=\"bold\"");
        self.line(Vec2::ZERO, Vec2::new(75.0, 0.0), "stroke=\"#222\" stroke-width=\"3\"");
    }

    /// The level curve `of(node) = 0` over a chart; returns its points.
    fn level(&mut self, chart: &[Vec<Node>], of: impl Fn(&Node) -> f64, style: impl Fn(&Node) -> String) -> Vec<Node> {
        let mut seen = Vec::new();
        for i in 1..chart.len() {
            for j in 1..chart[i].len() {
                for corners in [[(i - 1, j - 1), (i, j - 1), (i, j)], [(i - 1, j - 1), (i, j), (i - 1, j)]] {
                    let nodes = corners.map(|(p, q)| chart[p][q]);
                    let ends: Vec<Vec2> = (0..3)
                        .filter_map(|k| {
                            let (a, b) = (nodes[k], nodes[(k + 1) % 3]);
                            let (x, y) = (of(&a), of(&b));
                            ((x < 0.0) != (y < 0.0)).then(|| a.at + x / (x - y) * (b.at - a.at))
                        })
                        .collect();
                    // Neighbours far apart belong to different parts of the chart.
                    if let [a, b] = ends[..]
                        && a.distance(b) < 3.0
                    {
                        self.line(a, b, &style(&nodes[0]));
                        seen.push(Node { at: a, ..nodes[0] });
                    }
                }
            }
        }
        seen
    }

    fn moments(&mut self, chart: &[Vec<Node>]) {
        for level in LEVELS {
            let style = |n: &Node| {
                let colour = if n.stable > 0.0 { STABLE } else { UNSTABLE };
                format!("stroke=\"{colour}\" stroke-width=\"1.4\"")
            };
            let seen = self.level(chart, |n| n.moment - level, style);
            let stable = seen.iter().filter(|n| n.stable > 0.0);
            if let Some(top) = stable.max_by(|a, b| (a.at.x + 0.3 * a.at.y).total_cmp(&(b.at.x + 0.3 * b.at.y))) {
                self.text(top.at, &format!("{level}"), &format!("dx=\"5\" dy=\"4\" fill=\"{STABLE}\""));
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
        for pair in nodes.windows(2).filter(|pair| pair[0].at.distance(pair[1].at) < 3.0) {
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
    let mut panel = Panel { left: 50.0, body: String::new() };
    panel.axes("contact at the tip");
    panel.moments(&chart);
    panel.level(&chart, |n| n.stable, |_| "stroke=\"#222\" stroke-width=\"1.6\" stroke-dasharray=\"3 2\"".into());
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
    let mut panel = Panel { left: 610.0, body: String::new() };
    panel.axes("contact at the side, frictionless");
    panel.moments(&chart);
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
        (STABLE, "", "base moment (mN m), first fold not yet passed"),
        (UNSTABLE, "", "beyond the fold"),
        ("#222", "stroke-dasharray=\"3 2\"", "fold: the tip snaps"),
        ("#888", "", "limit of the field"),
    ];
    for (i, (colour, dash, text)) in words.into_iter().enumerate() {
        let x = [60.0, 400.0, 560.0, 740.0][i];
        let _ = writeln!(
            key,
            "<path d=\"M{x} 540h26\" stroke=\"{colour}\" stroke-width=\"2\" {dash}/><text x=\"{}\" y=\"544\">{text}</text>",
            x + 32.0
        );
    }
    let svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 1130 560\" font-family=\"sans-serif\" font-size=\"12\">\
         <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n{}{}{key}\
         <path d=\"M900 540h22m-5 -3l5 3l-5 3\" stroke=\"#222\" fill=\"none\"/><text x=\"928\" y=\"544\">force on the whisker</text></svg>\n",
        tip.body, side.body
    );
    std::fs::write(Path::new(&folder).join("tip-field.svg"), svg)?;
    Ok(())
}
