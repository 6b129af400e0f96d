//! The numbers beside the map: the estimate with its extent, the rivals, the error.

use super::LocalizationScene;
use crate::document::Document;
use crate::flow::pose::{Hypothesis, Status};
use crate::flow::trajectory::trajectory_error;
use crate::legend::LINE;
use crate::numbers::fixed;
use crate::sets::Interval;

/// How many rivals are listed one by one.
const LISTED: usize = 6;

/// One line: its stylesheet class and its words.
type Line = (&'static str, String);

/// The lines of the read-out; empty when there is no estimate.
pub(super) fn lines(scene: &LocalizationScene<'_>) -> Vec<Line> {
    let answer = scene.answer;
    let mut lines = match answer.hypotheses.as_slice() {
        _ if answer.status == Status::Inconsistent => Vec::new(),
        [] => Vec::new(),
        [only] => estimate(only),
        many => rivals(many, answer.encloses),
    };
    let error = scene.truth.and_then(|truth| trajectory_error(&answer.trajectory, truth));
    if let Some(error) = error.filter(|_| !lines.is_empty()) {
        let (position, heading) = (fixed(error.final_position * 1e3, 2), fixed(error.final_heading.to_degrees(), 2));
        lines.push(("label", format!("off the truth by {position} mm, {heading}°")));
    }
    lines
}

/// Draws the lines with their upper left corner at `(x, y)`.
pub(super) fn draw(document: &mut Document, x: f64, y: f64, lines: &[Line]) {
    for (index, (class, words)) in lines.iter().enumerate() {
        document.text(x, y + LINE * (index as f64 + 0.7), class, words);
    }
}

fn estimate(only: &Hypothesis) -> Vec<Line> {
    let row = |name: &str, value: f64, range: Interval, factor: f64, unit: &str, digits: usize| {
        let [value, lo, hi] = [value, range.lo(), range.hi()].map(|number| fixed(number * factor, digits));
        ("label", format!("{name} = {value}{unit} [{lo}, {hi}]"))
    };
    let degrees = 1f64.to_degrees();
    vec![
        ("heading", "Estimate [extent of the place]".into()),
        row("x", only.pose.x, only.extent.x, 1e3, " mm", 2),
        row("y", only.pose.y, only.extent.y, 1e3, " mm", 2),
        row("heading", only.pose.theta, only.extent.theta, degrees, "°", 2),
    ]
}

fn rivals(hypotheses: &[Hypothesis], encloses: bool) -> Vec<Line> {
    let mut lines = vec![("heading", format!("{} places explain the log", hypotheses.len()))];
    for (index, hypothesis) in hypotheses.iter().take(LISTED).enumerate() {
        let number = index + 1;
        let share = if encloses { String::new() } else { format!("{} %, ", fixed(100.0 * hypothesis.weight, 0)) };
        let pose = hypothesis.pose;
        let [x, y, heading] = [pose.x * 1e3, pose.y * 1e3, pose.theta.to_degrees()].map(|value| fixed(value, 1));
        lines.push(("label", format!("{number}: {share}{x}, {y} mm, {heading}°")));
    }
    if hypotheses.len() > LISTED {
        lines.push(("small", format!("and {} more", hypotheses.len() - LISTED)));
    }
    lines
}
