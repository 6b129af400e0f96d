//! The figure of bent whiskers.

use std::fmt::Write;
use vibrissa::beam::Bend;
use vibrissa::figure::numbers::{fixed, significant};
use vibrissa::plane::Vec2;

/// Width of the drawing (px), without the margin.
const WIDTH: f64 = 640.0;
const MARGIN: f64 = 56.0;
/// Largest length of a force arrow (px), and as a share of the whisker's length.
const ARROW: f64 = 60.0;
const ARROW_SHARE: f64 = 0.12;
/// Height of a line of the legend (px).
const LINE: f64 = 18.0;
const COLOURS: [&str; 4] = ["#0072b2", "#d55e00", "#009e73", "#cc79a7"];

/// From metres in the whisker frame to pixels of the drawing.
struct View {
    lo: Vec2,
    hi: Vec2,
    scale: f64,
}

impl View {
    fn around(points: &[Vec2], length: f64) -> Self {
        let (mut lo, mut hi) = (Vec2::new(0.0, -0.15 * length), Vec2::new(length, 0.15 * length));
        for p in points {
            lo = Vec2::new(lo.x.min(p.x), lo.y.min(p.y));
            hi = Vec2::new(hi.x.max(p.x), hi.y.max(p.y));
        }
        let pad = 0.06 * (hi.x - lo.x).max(hi.y - lo.y);
        let (lo, hi) = (lo - Vec2::new(pad, pad), hi + Vec2::new(pad, pad));
        Self { lo, hi, scale: WIDTH / (hi.x - lo.x) }
    }

    fn px(&self, p: Vec2) -> (f64, f64) {
        (MARGIN + (p.x - self.lo.x) * self.scale, 16.0 + (self.hi.y - p.y) * self.scale)
    }

    fn height(&self) -> f64 {
        (self.hi.y - self.lo.y) * self.scale
    }
}

/// The whiskers of one problem from base to tip, with contact points, forces and axes in mm, as SVG.
pub(super) fn figure(solutions: &[Bend], length: f64) -> String {
    let shapes: Vec<Vec<Vec2>> = solutions.iter().map(|b| b.shape(length, 201)).collect();
    let tails = solutions.iter().filter_map(|b| Some(b.contact - direction(b)? * (ARROW_SHARE * length)));
    let view = View::around(&shapes.concat().into_iter().chain(tails).collect::<Vec<_>>(), length);
    let legend = view.height() + 16.0 + MARGIN;
    let (width, height) = (WIDTH + MARGIN + 16.0, legend + LINE * solutions.len() as f64);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width:.0}\" height=\"{height:.0}\" viewBox=\"0 0 {width:.0} {height:.0}\" \
         font-family=\"sans-serif\" font-size=\"12\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n"
    );
    axes(&mut svg, &view);
    let (from, to) = (view.px(Vec2::ZERO), view.px(Vec2::new(length, 0.0)));
    let _ = writeln!(
        svg,
        "<path d=\"M{:.2} {:.2}L{:.2} {:.2}\" stroke=\"#999\" stroke-dasharray=\"4 4\"/>",
        from.0, from.1, to.0, to.1
    );
    let arrow = ARROW.min(ARROW_SHARE * length * view.scale);
    for (i, (bend, shape)) in solutions.iter().zip(&shapes).enumerate() {
        let colour = COLOURS[i % COLOURS.len()];
        whisker(&mut svg, &view, (bend, shape), colour, arrow);
        // A line of its own for each: beside the arrows labels would cover each other.
        let y = legend + LINE * i as f64;
        let _ = writeln!(
            svg,
            "<path d=\"M{MARGIN} {:.2}h22\" stroke=\"{colour}\" stroke-width=\"2\"/>\n\
             <text x=\"{:.2}\" y=\"{y:.2}\">force {} N at ({}, {}) mm, moment at the base {} mN·m</text>",
            y - 4.0,
            MARGIN + 30.0,
            significant(bend.force, 4),
            fixed(bend.contact.x * 1e3, 3),
            fixed(bend.contact.y * 1e3, 3),
            significant(bend.moment * 1e3, 4)
        );
    }
    let _ = writeln!(
        svg,
        "<rect x=\"{:.2}\" y=\"{:.2}\" width=\"8\" height=\"24\" fill=\"#444\"/>\n</svg>",
        from.0 - 8.0,
        from.1 - 12.0
    );
    svg
}

/// Where the force points; none without a force.
fn direction(bend: &Bend) -> Option<Vec2> {
    let force = bend.force_vector();
    let size = force.norm();
    (size > 0.0).then(|| force * (1.0 / size))
}

fn whisker(svg: &mut String, view: &View, (bend, shape): (&Bend, &[Vec2]), colour: &str, arrow: f64) {
    let line: Vec<String> = shape.iter().map(|&p| view.px(p)).map(|(x, y)| format!("{x:.2},{y:.2}")).collect();
    let _ =
        writeln!(svg, "<polyline points=\"{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"2\"/>", line.join(" "));
    let (x, y) = view.px(bend.contact);
    let _ = writeln!(svg, "<circle cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"4\" fill=\"{colour}\"/>");
    let Some(d) = direction(bend) else { return };
    // The arrow ends at the contact, on the side from which the force pushes.
    let back = |along: f64, across: f64| (x - along * d.x + across * d.y, y + along * d.y + across * d.x);
    let (tail, left, right) = (back(arrow, 0.0), back(14.0, 4.0), back(14.0, -4.0));
    let tip = back(5.0, 0.0);
    let _ = writeln!(
        svg,
        "<path d=\"M{:.2} {:.2}L{:.2} {:.2}M{:.2} {:.2}L{:.2} {:.2}L{:.2} {:.2}\" fill=\"none\" stroke=\"#222\" stroke-width=\"1.5\"/>",
        tail.0, tail.1, tip.0, tip.1, left.0, left.1, tip.0, tip.1, right.0, right.1
    );
}

/// Ticks in mm at a step of 1, 2 or 5 times a power of ten.
fn axes(svg: &mut String, view: &View) {
    let rough = (view.hi.x - view.lo.x) * 1e3 / 8.0;
    let power = 10f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].iter().map(|f| f * power).find(|s| *s >= rough).unwrap_or(10.0 * power);
    let ticks = |lo: f64, hi: f64| {
        let (first, last) = ((lo * 1e3 / step).ceil() as i64, (hi * 1e3 / step).floor() as i64);
        (first..=last).map(move |i| i as f64 * step)
    };
    let (left, bottom) = view.px(view.lo);
    let (right, top) = view.px(view.hi);
    for mm in ticks(view.lo.x, view.hi.x) {
        let (x, _) = view.px(Vec2::new(mm * 1e-3, 0.0));
        let _ = writeln!(
            svg,
            "<path d=\"M{x:.2} {bottom:.2}V{top:.2}\" stroke=\"#eee\"/><text x=\"{x:.2}\" y=\"{:.2}\" text-anchor=\"middle\">{mm}</text>",
            bottom + 16.0
        );
    }
    for mm in ticks(view.lo.y, view.hi.y) {
        let (_, y) = view.px(Vec2::new(0.0, mm * 1e-3));
        let _ = writeln!(
            svg,
            "<path d=\"M{left:.2} {y:.2}H{right:.2}\" stroke=\"#eee\"/><text x=\"{:.2}\" y=\"{:.2}\" text-anchor=\"end\">{mm}</text>",
            left - 6.0,
            y + 4.0
        );
    }
    let _ = writeln!(
        svg,
        "<path d=\"M{left:.2} {top:.2}V{bottom:.2}H{right:.2}\" fill=\"none\" stroke=\"#444\"/>\n\
         <text x=\"{:.2}\" y=\"{:.2}\" text-anchor=\"middle\">x (mm)</text>\n\
         <text x=\"14\" y=\"{:.2}\" text-anchor=\"middle\" transform=\"rotate(-90 14 {:.2})\">y (mm)</text>",
        0.5 * (left + right),
        bottom + 36.0,
        0.5 * (top + bottom),
        0.5 * (top + bottom)
    );
}
