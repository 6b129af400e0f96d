//! The points of the boundary that whiskers are laid against, and maps that have too many of them.

use super::FIRST_POSE;
use crate::config::DeterministicOptions;
use crate::config::limits::{COARSEST_SPACING, MOST_SAMPLES};
use crate::flow::preimage::Observation;
use crate::flow::prior;
use crate::plane::{Bounds, Vec2};
use crate::world::{BoundarySample, Map, MountedWhisker, Robot};
use crate::{Error, Result};

/// Points along the map's boundaries for whiskers to be laid against; with a region for the first pose they are chosen
/// when the first candidates enter, and only counted here.
pub(super) fn samples(map: &Map, robot: &Robot, options: &DeterministicOptions) -> Result<Vec<BoundarySample>> {
    let reach = robot.whiskers.iter().map(reach).fold(0.0, f64::max);
    let bounds = options.prior.map_or(map.bounds(), |region| prior::around(region, Vec2::ZERO, 0.0, reach));
    let spacing = options.boundary_spacing;
    let (walked, points) = map.walk_in(bounds, spacing);
    if walked / spacing > MOST_SAMPLES {
        return Err(too_much(walked, options));
    }
    if options.prior.is_some() {
        return Ok(Vec::new());
    }
    let samples = map.samples(spacing);
    Ok(if points > MOST_SAMPLES { thinned(samples, spacing) } else { samples })
}

/// How far a whisker's tip can be from the robot's origin (m).
fn reach(whisker: &MountedWhisker) -> f64 {
    whisker.robot_from_whisker.position().norm() + whisker.beam.length
}

fn too_much(walked: f64, options: &DeterministicOptions) -> Error {
    let spacing = options.boundary_spacing;
    let coarser = (walked / MOST_SAMPLES * 1e4).ceil() / 1e4;
    let place = if options.prior.is_some() { "region" } else { "map" };
    let error = Error::data(format!("the {place} has too much boundary for this boundary spacing"))
        .value(format!("{walked:.1} m at {spacing} m"))
        .allowed(format!("up to {MOST_SAMPLES} points"));
    let smaller = if options.prior.is_some() {
        "give a smaller region".to_owned()
    } else {
        format!("{FIRST_POSE}, use the part of the map that it can be in")
    };
    if coarser <= COARSEST_SPACING {
        error.remedy(format!("{smaller}, or --boundary-spacing {coarser}"))
    } else {
        error.remedy(format!("{smaller}, and check that the map's unit is metres"))
    }
}

/// The points that the whiskers of these observations can touch with the first pose in the region.
pub(super) fn near(
    map: &Map,
    robot: &Robot,
    region: [[f64; 2]; 3],
    waiting: &[Observation],
    options: &DeterministicOptions,
) -> Vec<BoundarySample> {
    let longest = robot.whiskers.iter().map(|w| w.beam.length).fold(0.0, f64::max);
    let around = |o: &Observation| {
        prior::around(region, o.odom_from_whisker.position(), 0.0, longest + 2.0 * options.boundary_spacing)
    };
    let bounds = waiting.iter().map(around).fold(Bounds::EMPTY, Bounds::hull);
    let (walked, points) = map.walk_in(bounds, options.boundary_spacing);
    // A long way to the first contact with an open heading can end beside any wall: those far apart must do.
    let spacing = options.boundary_spacing.max(walked / MOST_SAMPLES);
    let samples = map.samples_in(bounds, spacing);
    if points > MOST_SAMPLES { thinned(samples, spacing) } else { samples }
}

/// The samples of boundaries of many short pieces, without those that are much nearer to the one before than `spacing` (m).
fn thinned(mut samples: Vec<BoundarySample>, spacing: f64) -> Vec<BoundarySample> {
    let mut last: Option<BoundarySample> = None;
    samples.retain(|sample| {
        let far = last.is_none_or(|last| {
            last.boundary != sample.boundary || (last.arc_length - sample.arc_length).abs() >= 0.5 * spacing
        });
        if far {
            last = Some(*sample);
        }
        far
    });
    samples
}
