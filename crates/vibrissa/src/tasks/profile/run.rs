//! Contact points in a row, good enough to be drawn.

use crate::config::ProfileOptions;
use crate::plane::Vec2;
use crate::tasks::contact::{ContactKind, ContactReport, ContactStep};

/// How far a tip goes back along the wall before it is taken to have turned (m).
const BACK: f64 = 1e-3;

/// A sliding contact, of the tip or of the side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sample {
    /// Odometry frame (m).
    pub(super) position: Vec2,
    /// The unit normal of the wall, away from it.
    pub(super) normal: Vec2,
    /// Standard deviation across the wall (m).
    pub(super) std: f64,
}

/// The runs of sliding contact of one log: pieces cut where the contact is not well known; short ones are dropped.
pub(super) fn runs(report: &ContactReport, options: &ProfileOptions) -> Vec<Vec<Sample>> {
    let mut found: Vec<Vec<Sample>> = Vec::new();
    let mut last: Option<(usize, Vec2)> = None;
    for step in &report.steps {
        let Some(sample) = sample(step).filter(|s| s.std <= options.largest_std) else {
            last = None;
            continue;
        };
        let follows = |(piece, position): (usize, Vec2)| {
            piece == step.piece && position.distance(sample.position) <= options.largest_gap
        };
        match found.last_mut().filter(|_| last.is_some_and(follows)) {
            Some(run) => run.push(sample),
            None => found.push(vec![sample]),
        }
        last = Some((step.piece, sample.position));
    }
    let mut found: Vec<Vec<Sample>> = found.into_iter().flat_map(one_way).collect();
    found.retain(|run| run.len() >= options.fewest && length(run) >= options.shortest);
    found
}

/// A run cut where the tip turns back along the wall.
fn one_way(run: Vec<Sample>) -> Vec<Vec<Sample>> {
    let mut along = vec![0.0; run.len()];
    for (i, pair) in run.windows(2).enumerate() {
        let tangent = (pair[0].normal + pair[1].normal).perp();
        along[i + 1] = along[i] + 0.5 * (pair[1].position - pair[0].position).dot(tangent);
    }
    // The farthest point so far either way; the cut is where the tip has come back from one of them.
    let (mut cuts, mut lowest, mut highest, mut way) = (vec![0], 0, 0, 0);
    for (i, s) in along.iter().enumerate() {
        if *s > along[highest] {
            highest = i;
        }
        if *s < along[lowest] {
            lowest = i;
        }
        if way >= 0 && along[highest] - s > BACK {
            if way > 0 || along[highest] > BACK {
                cuts.push(highest);
            }
            (way, lowest) = (-1, i);
        } else if way <= 0 && s - along[lowest] > BACK {
            if way < 0 || along[lowest] < -BACK {
                cuts.push(lowest);
            }
            (way, highest) = (1, i);
        }
    }
    cuts.push(run.len());
    cuts.windows(2).map(|cut| run[cut[0]..cut[1]].to_vec()).collect()
}

fn sample(step: &ContactStep) -> Option<Sample> {
    Some(Sample { position: step.position()?, normal: Vec2::from_angle(step.normal?), std: step.std? })
}

fn length(run: &[Sample]) -> f64 {
    run.windows(2).map(|pair| pair[0].position.distance(pair[1].position)).sum()
}

/// Contacts that stood still: each with its standard deviation (m).
pub(super) fn pegs(report: &ContactReport) -> Vec<(Vec2, f64)> {
    let mut found: Vec<(usize, Vec2, f64)> = Vec::new();
    for step in report.steps.iter().filter(|step| step.kind == ContactKind::Side && step.normal.is_none()) {
        if let (Some(position), Some(std)) = (step.position(), step.std)
            && found.last().is_none_or(|(piece, ..)| *piece != step.piece)
        {
            found.push((step.piece, position, std));
        }
    }
    found.into_iter().map(|(_, position, std)| (position, std)).collect()
}
