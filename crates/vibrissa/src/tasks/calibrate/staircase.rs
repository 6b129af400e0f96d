//! Staircases: the base travels sideways step by step against an edge at a known distance from the tip.

use super::distance::DistanceSet;
use crate::Result;
use crate::config::StaircaseOptions;
use crate::io::log::foreign::Recording;

/// One step: the rig stands still at one distance and one lateral travel.
struct Step {
    /// Distance from the tip (m).
    dist: f64,
    /// Lateral travel (m).
    bend: f64,
    /// The rows.
    rows: core::ops::Range<usize>,
}

/// The slope of `channel` at the first step of each climb (reading per m of travel), by distance from the base.
///
/// The elastic answer to a step is the reading just after it less the reading just before it: between, the mount creeps.
/// Later steps of a climb slide along the edge, and the last step of a climb holds the retreat, so only the first step
/// from a touch to a deeper touch counts.
///
/// # Errors
///
/// A recording without the columns `dist`, `bend`, `channel` or without time.
pub fn staircase(
    recording: &Recording,
    channel: &str,
    length: f64,
    options: &StaircaseOptions,
) -> Result<Vec<DistanceSet>> {
    let reading = recording.require(channel)?;
    let steps = steps(recording)?;
    let t = &recording.t;
    let mut durations: Vec<f64> = steps.iter().map(|s| t[s.rows.end - 1] - t[s.rows.start]).collect();
    durations.sort_by(f64::total_cmp);
    let Some(&dwell) = durations.get(durations.len() / 2) else { return Ok(Vec::new()) };
    let level = |step: &Step, window: [f64; 2]| {
        let since = |row: usize| (t[row] - t[step.rows.start]) / dwell;
        let inside = step.rows.clone().filter(|&row| (window[0]..=window[1]).contains(&since(row)));
        let mut values: Vec<f64> = inside.map(|row| reading[row]).collect();
        values.sort_by(f64::total_cmp);
        values.get(values.len() / 2).copied().filter(|_| values.len() >= options.fewest_rows)
    };
    let mut samples: Vec<(f64, f64)> = Vec::new();
    for climb in climbs(&steps, options) {
        let [first, second, _, ..] = climb else { continue };
        let levels = (level(first, options.before), level(second, options.after));
        if let (Some(before), Some(after)) = levels {
            let slope = (after - before) / (second.bend - first.bend);
            samples.push((length - 0.5 * (first.dist + second.dist), slope));
        }
    }
    Ok(sets(samples, &recording.source, options.same_distance))
}

/// Runs of rows with one label; a pause of the recording ends a run too.
fn steps(recording: &Recording) -> Result<Vec<Step>> {
    let (dist, bend) = (recording.require("dist")?, recording.require("bend")?);
    let t = &recording.t;
    let same = |a: f64, b: f64| (a - b).abs() < 1e-9;
    let mut steps: Vec<Step> = Vec::new();
    for row in 0..t.len() {
        match steps.last_mut() {
            Some(step) if same(step.dist, dist[row]) && same(step.bend, bend[row]) && t[row] - t[row - 1] < PAUSE => {
                step.rows.end = row + 1;
            }
            _ => steps.push(Step { dist: dist[row], bend: bend[row], rows: row..row + 1 }),
        }
    }
    Ok(steps)
}

/// A pause of the recording (s).
const PAUSE: f64 = 60.0;

/// Runs of steps at one distance with growing travel, from the first that touches on.
fn climbs<'a>(steps: &'a [Step], options: &StaircaseOptions) -> Vec<&'a [Step]> {
    let together =
        |a: &Step, b: &Step| (a.dist - b.dist).abs() < options.same_distance && b.bend > a.bend && a.bend >= 0.0;
    steps.chunk_by(together).collect()
}

/// The samples grouped by distance, nearest the base first.
fn sets(mut samples: Vec<(f64, f64)>, source: &str, same: f64) -> Vec<DistanceSet> {
    samples.sort_by(|a, b| a.0.total_cmp(&b.0));
    let groups = samples.chunk_by(|a, b| b.0 - a.0 < same);
    groups.map(|group| DistanceSet { source: source.to_owned(), samples: group.to_vec() }).collect()
}
