//! Places that are left, numbered, with what lies beneath them in sight.

use super::canvas::Canvas;
use crate::plane::{Pose2, Vec2};
use std::collections::HashSet;

/// At most this many places carry a number.
pub(crate) const NUMBERED: usize = 30;
/// Length of a place's arrow, and how far from the place its number stands (px).
const ARROW: f64 = 26.0;
const ASIDE: f64 = 20.0;
const BADGE: f64 = 8.5;
/// Distance of points along a line (px), and at most this many of one piece.
const CLOSE: f64 = 5.0;
const MOST_STEPS: f64 = 400.0;
/// Directions in which a number may stand.
const DIRECTIONS: usize = 16;

/// Draws each place as an arrow along its heading, and its number beside it, where it hides least of the lines and points
/// that are drawn already (map frame).
pub(crate) fn places(canvas: &mut Canvas, poses: &[Pose2], drawn: &[Vec<Vec2>]) {
    let shown: Vec<(usize, Pose2)> = poses.iter().copied().enumerate().take(NUMBERED).collect();
    let shown = || shown.iter().filter(|(_, pose)| canvas.world().contains(pose.position()));
    let mut hidden = on_page(canvas, drawn);
    for (_, pose) in shown() {
        let (from, along) = (canvas.page(pose.position()), Vec2::new(pose.theta.cos(), -pose.theta.sin()));
        hidden.extend([0.0, 0.5, 1.0].map(|part| from + along * (part * ARROW)));
    }
    let mut badges = Vec::new();
    for &(index, pose) in shown() {
        let at = aside(canvas, pose, &hidden);
        hidden.push(canvas.page(at));
        badges.push((index + 1, pose, at));
    }
    for &(number, pose, at) in badges.iter().rev() {
        canvas.polyline(&[pose.position(), at], "badge-line");
        canvas.arrow(pose, ARROW, "estimate-line", "estimate");
        canvas.circle(pose.position(), 3.0, "estimate");
        canvas.circle(at, BADGE, "badge");
        canvas.text(at, (0.0, 4.0), &number.to_string(), "badge-text");
    }
}

/// Points of the page along lines, close enough together for a number not to slip between them; one of those alike.
fn on_page(canvas: &Canvas, lines: &[Vec<Vec2>]) -> Vec<Vec2> {
    let whole = |p: Vec2| ((0.5 * p.x).round() as i64, (0.5 * p.y).round() as i64);
    let mut seen = HashSet::new();
    let mut points = Vec::new();
    for line in lines {
        let mut before = None;
        for end in line.iter().filter(|point| point.is_finite()).map(|&point| canvas.page(point)) {
            let from: Vec2 = before.replace(end).unwrap_or(end);
            let steps = (from.distance(end) / CLOSE).ceil().clamp(1.0, MOST_STEPS) as usize;
            let along = (1..=steps).map(|step| from + (end - from) * (step as f64 / steps as f64));
            points.extend(along.filter(|&point| seen.insert(whole(point))));
        }
    }
    points
}

/// Where a number stands: of the directions around the place, behind it first, the one that is farthest from all else.
fn aside(canvas: &Canvas, pose: Pose2, hidden: &[Vec2]) -> Vec2 {
    let candidate = |step: usize| {
        let turn = core::f64::consts::TAU * step as f64 / DIRECTIONS as f64;
        pose.position() - Vec2::from_angle(pose.theta + turn) * (ASIDE / canvas.scale())
    };
    let room = |at: Vec2| {
        let (page, frame) = (canvas.page(at), canvas.frame());
        let edge = (page.x - frame.x).min(frame.x + frame.width - page.x);
        let edge = edge.min(page.y - frame.y).min(frame.y + frame.height - page.y);
        // What is farther than the badge's own size is not hidden: more room is no better.
        hidden.iter().fold(edge, |room, &point| room.min(page.distance(point))).min(BADGE + 3.0)
    };
    let mut best = (candidate(0), room(candidate(0)));
    for at in (1..DIRECTIONS).map(candidate) {
        let room = room(at);
        if room > best.1 + 1e-9 {
            best = (at, room);
        }
    }
    best.0
}
