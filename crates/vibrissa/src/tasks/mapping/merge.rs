//! Stretches of all passes as one outline: the weighted mean of those that run along each other, with corners and unknown stretches.

use super::front_end::FrontEnd;
use super::graph::Solution;
use crate::config::{MapAssemblyOptions, MappingOptions, ProfileOptions};
use crate::plane::{Pose2, Vec2};
use crate::tasks::profile::{AssembledMap, FeltLine, OutlinePoint, assemble, merged};
use crate::world::Band;
use crate::{Error, Result};

/// The outline with bands: what contacts leave open, and what the key poses do, relative to the first; without points that are left out, by
/// their stretch and number.
pub(super) fn outline(
    front: &FrontEnd,
    solution: &Solution,
    covariances: &[[[f64; 3]; 3]],
    options: &MappingOptions,
    is_left_out: &dyn Fn(usize, usize) -> bool,
) -> Result<AssembledMap> {
    let (mut runs, mut owners): (Vec<Vec<OutlinePoint>>, Vec<(Vec2, usize)>) = (Vec::new(), Vec::new());
    for (index, stretch) in front.stretches.iter().enumerate() {
        let numbered: Vec<usize> = (0..stretch.points.len()).filter(|&k| !is_left_out(index, k)).collect();
        let Some(&key) = solution.poses.get(stretch.key).filter(|_| !numbered.is_empty()) else { continue };
        let point = |p: &super::front_end::StretchPoint| OutlinePoint {
            position: key.transform_point(p.position),
            normal: p.normal.rotated(key.theta),
            std: p.std,
            runs: 1,
        };
        for part in numbered.chunk_by(|a, b| a + 1 == *b) {
            let run: Vec<OutlinePoint> = part.iter().map(|&k| point(&stretch.points[k])).collect();
            owners.extend(run.iter().step_by(8).map(|p| (p.position, stretch.key)));
            runs.push(run);
        }
    }
    let outlines = merged(&runs, &ProfileOptions { shortest: options.shortest, ..ProfileOptions::default() });
    let assembly = MapAssemblyOptions::default();
    let mut lines: Vec<FeltLine> = outlines.iter().map(|outline| outline.felt(&assembly)).collect();
    // What runs beside a wall for a few millimetres is the end of a trace that left it.
    let length = |line: &FeltLine| -> f64 {
        line.points.windows(2).map(|pair| pair[0].position.distance(pair[1].position)).sum()
    };
    lines.retain(|line| length(line) >= options.shortest);
    for line in &mut lines {
        let places: Vec<Vec2> = line.points.iter().map(|point| point.position).collect();
        for (k, point) in line.points.iter_mut().enumerate() {
            let [before, after] = [places[k.saturating_sub(1)], places[(k + 1).min(places.len() - 1)]];
            let normal = (after - before).perp() * (1.0 / (after - before).norm().max(1e-12));
            let near =
                owners.iter().min_by(|a, b| a.0.distance(point.position).total_cmp(&b.0.distance(point.position)));
            if let Some((_, key)) = near {
                let std = across(point.position, normal, solution.poses[*key], &covariances[*key]);
                point.drift = Band { std, bound: options.stds_in_bound * std };
            }
        }
    }
    if lines.is_empty() {
        return Err(Error::data("nothing was felt well enough to make an outline")
            .remedy("slide the whisker along walls; is the robot file that of this robot?"));
    }
    assemble(&lines, &assembly)
}

/// Standard deviation across a wall that a key pose leaves open (m).
pub(super) fn across(place: Vec2, normal: Vec2, key: Pose2, covariance: &[[f64; 3]; 3]) -> f64 {
    let j = [normal.x, normal.y, normal.dot((place - key.position()).perp())];
    let along = covariance.map(|row| (0..3).map(|k| row[k] * j[k]).sum::<f64>());
    (0..3).map(|k| j[k] * along[k]).sum::<f64>().max(0.0).sqrt()
}
