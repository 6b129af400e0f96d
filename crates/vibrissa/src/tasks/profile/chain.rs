//! A line through several runs.

use super::run::Sample;
use crate::plane::Vec2;

/// Shortest way around before a line may close (m).
const SHORTEST_RING: f64 = 20e-3;

/// A line of samples, and the runs that lie along it.
#[derive(Clone, Debug)]
pub(super) struct Chain {
    pub(super) line: Vec<Sample>,
    pub(super) runs: Vec<Vec<Sample>>,
    pub(super) closed: bool,
}

/// Where a point lies beside a line.
struct Beside {
    distance: f64,
    /// Before its first point (-1), beyond its last one (1), or between (0).
    end: i8,
    normal: Vec2,
}

/// Lines through runs: runs that pass within `reach` (m) of a line with the same normal belong to it and extend it.
pub(super) fn chains(mut runs: Vec<Vec<Sample>>, reach: f64) -> Vec<Chain> {
    runs.sort_by_key(|run| core::cmp::Reverse(run.len()));
    let mut found: Vec<Chain> = Vec::new();
    while !runs.is_empty() {
        let mut line = runs.remove(0);
        let mut own = vec![line.clone()];
        let mut closed = close(&mut line, reach);
        loop {
            let next = runs.iter().position(|run| touches(&line, run, reach));
            let Some(next) = next else { break };
            let run = runs.remove(next);
            if !closed {
                extend(&mut line, &run, reach);
                closed = close(&mut line, reach);
            }
            own.push(run);
        }
        found.push(Chain { line, runs: own, closed });
    }
    found
}

/// Cuts a line that comes back to its beginning.
fn close(line: &mut Vec<Sample>, reach: f64) -> bool {
    let Some(first) = line.first().copied() else { return false };
    let (mut along, mut last) = (0.0, first.position);
    let back = line.iter().position(|sample| {
        along += last.distance(sample.position);
        last = sample.position;
        along > SHORTEST_RING
            && sample.position.distance(first.position) < reach
            && sample.normal.dot(first.normal) > 0.5
    });
    if let Some(back) = back {
        line.truncate(back + 1);
    }
    back.is_some()
}

fn beside(line: &[Sample], point: Vec2) -> Option<Beside> {
    let (index, nearest) =
        line.iter().enumerate().min_by(|a, b| a.1.position.distance(point).total_cmp(&b.1.position.distance(point)))?;
    let ahead = |a: usize, b: usize| (point - line[a].position).dot(line[a].position - line[b].position) > 0.0;
    let last = line.len() - 1;
    let end = match index {
        0 if last > 0 && ahead(0, 1.min(last)) => -1,
        i if i == last && last > 0 && ahead(last, last - 1) => 1,
        _ => 0,
    };
    Some(Beside { distance: nearest.position.distance(point), end, normal: nearest.normal })
}

/// Whether a run passes along the line: near it and facing the same way.
fn touches(line: &[Sample], run: &[Sample], reach: f64) -> bool {
    let near =
        |s: &&Sample| beside(line, s.position).is_some_and(|b| b.distance < reach && b.normal.dot(s.normal) > 0.5);
    run.iter().filter(near).count() >= 3
}

/// Adds what of a run lies beyond the ends of a line.
fn extend(line: &mut Vec<Sample>, run: &[Sample], reach: f64) {
    for end in [1, -1] {
        let beyond = |s: &&Sample| beside(line, s.position).is_some_and(|b| b.end == end);
        let mut more: Vec<Sample> = run.iter().filter(beyond).copied().collect();
        let edge = if end > 0 { line.last() } else { line.first() };
        let Some(edge) = edge.copied() else { return };
        let far = |s: Option<&Sample>| s.map_or(f64::INFINITY, |s| s.position.distance(edge.position));
        if far(more.last()) < far(more.first()) {
            more.reverse();
        }
        if far(more.first()) > reach {
            continue;
        }
        if end > 0 {
            line.extend(more);
        } else {
            more.reverse();
            line.splice(0..0, more);
        }
    }
}
