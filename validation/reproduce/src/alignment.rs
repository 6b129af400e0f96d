//! The whisker into and out of a bay, and the boundary's slope from a short history of shapes.

use super::Section;
use super::ground::{self, SWEEPS, layer};
use super::paper_method::{self, Shape};
use core::f64::consts::FRAC_PI_2;
use vibrissa::Result;
use vibrissa::config::ContactOptions;
use vibrissa::figure::{Geometry, MapPlate, WorldBounds, map_plate};
use vibrissa::plane::{Pose2, Vec2, wrap_angle};
use vibrissa::sim::{SweepNoise, shapes};
use vibrissa::tasks::contact::{ContactKind, contacts};
use vibrissa::world::{Map, Robot};

/// Where the contact approaches the bay and where it leaves it (m, along x), and where the wall is regular.
const INTO: [f64; 2] = [0.205, 0.252];
const OUT: [f64; 2] = [0.268, 0.315];
/// Rows between the drawn shapes: 5 mm.
const EVERY: usize = 10;
/// Draws of the noise, and how far off the wall a contact counts as astray (m).
const DRAWS: u64 = 5;
const STRAY: f64 = 2e-3;
/// Rows between two estimates of the slope from neighbouring shapes.
const ROWS: usize = 4;

pub(super) fn section() -> Result<Section> {
    let mut section = Section::new("alignment", "The whisker's angle to the boundary");
    let (map, robot) = (ground::arena()?, ground::robot(1.0));
    let sweep = ground::arena_sweep(&map, SWEEPS[0].way, &SweepNoise::seeded(1))?;
    let all = shapes(&robot, &sweep, EVERY);
    let outlines = ground::outlines(&map);
    let picture = |title: &str, range: [f64; 2]| {
        let touched = |points: &Vec<Vec2>| points.last().is_some_and(|tip| (range[0]..=range[1]).contains(&tip.x));
        let drawn: Vec<Vec<Vec2>> = all.iter().map(|shape| shape.points.clone()).filter(touched).collect();
        let bounds = WorldBounds::of(drawn.iter().flatten().copied()).map(|bounds| bounds.grown(0.008));
        let layers = [layer(Geometry::Lines(drawn), "whisker-last", "whisker every 5 mm")];
        map_plate(&MapPlate { title, map: &outlines, layers: &layers, window: bounds, frame: "map frame" })
    };
    section.show(
        "bay",
        [
            "Figure “preimageFromObservation”: the contact (a) approaches a concave section, (b) moves away from it.",
            "The arena's bay, shapes from the first sweep.",
            "The paper's bay is not dimensioned.",
        ],
        vec![picture("(a) Into the bay", INTO), picture("(b) Out of the bay", OUT)],
    );
    let start = sweep.truth.first().map_or(Pose2::IDENTITY, |row| row.map_from_robot);
    let mut errors: Vec<(f64, f64)> = Vec::new();
    for seed in 1..=DRAWS {
        let drawn = ground::arena_sweep(&map, SWEEPS[0].way, &SweepNoise::seeded(seed))?;
        let report = contacts(&drawn.log, &robot, &ContactOptions::default())?;
        let tips = report.steps.iter().filter(|step| step.kind == ContactKind::Tip);
        errors.extend(tips.filter_map(|step| error(&map, start, step.position()?, step.normal?)));
    }
    let sorted = |pick: fn(&(f64, f64)) -> f64| {
        let mut all: Vec<f64> = errors.iter().map(pick).collect();
        all.sort_by(f64::total_cmp);
        all
    };
    let (places, slopes) = (sorted(|e| e.0), sorted(|e| e.1));
    let median = |all: &[f64]| all.get(all.len() / 2).copied().unwrap_or(f64::NAN);
    section.find(
        "Contact point along the sweep, median error",
        "place_error",
        "no number",
        (1e3 * median(&places), 3, "mm"),
        "Five draws of readings off by up to 5 % and 20 µN m; all shapes of a sweep are solved at once.",
    );
    section.find(
        "Boundary slope at the contact, median error",
        "slope_error",
        "“plays a critical role”, no number",
        (median(&slopes).to_degrees(), 3, "°"),
        "All readings of the sweep at once.",
    );
    for shapes in [2_usize, 3, 5] {
        let off = slopes_of_shapes(&map, &robot, shapes)?;
        section.find(
            &format!("The same from {shapes} shapes, 0.5 mm apart, as the paper takes it, median error"),
            &format!("slope_of_{shapes}"),
            "2 to 5 shapes, steps below 1 mm",
            (median(&off).to_degrees(), 1, "°"),
            "Neighbouring shapes alone, not smoothed: the tips of two shapes are off by more than they are apart.",
        );
    }
    let exact = slopes_of(&map, &robot, &SweepNoise::none(), 3)?;
    section.find(
        "The same from 3 shapes, readings without errors",
        "slope_exact",
        "steps t and t + 2",
        (median(&exact).to_degrees(), 2, "°"),
        "What the construction itself leaves: the force is taken normal to the whisker, not to the wall.",
    );
    let stray = places.iter().filter(|error| **error > STRAY).count() as f64 / places.len() as f64;
    section.find(
        "Share of contact points more than 2 mm off the wall",
        "stray",
        "no number",
        (1e2 * stray, 1, "%"),
        "Where readings leave two shapes open, a whole stretch of a draw can follow the wrong one.",
    );
    section.say(
        "The boundary's slope at the contact follows from the way of the tip. The paper's angle γ = π − (φₐ + φ_E) counts \
         slopes clockwise; in our frame the whisker meets the boundary at φₐ − φ_E.",
    );
    Ok(section)
}

/// Errors of the boundary's slope from so many neighbouring shapes, over all draws (rad), in order of size.
fn slopes_of_shapes(map: &Map, robot: &Robot, shapes: usize) -> Result<Vec<f64>> {
    let mut all = Vec::new();
    for seed in 1..=DRAWS {
        all.extend(slopes_of(map, robot, &SweepNoise::seeded(seed), shapes)?);
    }
    all.sort_by(f64::total_cmp);
    Ok(all)
}

/// Errors of the boundary's slope from so many neighbouring shapes of one sweep (rad), in order of size.
fn slopes_of(map: &Map, robot: &Robot, noise: &SweepNoise, shapes: usize) -> Result<Vec<f64>> {
    let sweep = ground::arena_sweep(map, SWEEPS[0].way, noise)?;
    let map_from_odom = sweep.truth.first().map_or(Pose2::IDENTITY, |row| row.map_from_robot);
    let found = paper_method::shapes(&sweep.log, &robot.whiskers[0], shapes, ROWS)?;
    let off = |shape: &Shape| {
        let (place, slope) = shape.on_the_way();
        error(map, map_from_odom, place, slope + FRAC_PI_2).map(|(_, turn)| turn)
    };
    let mut all: Vec<f64> = found.iter().filter_map(off).collect();
    all.sort_by(f64::total_cmp);
    Ok(all)
}

/// How far a contact is from the wall (m), and its normal from the wall's (rad).
fn error(map: &Map, map_from_odom: Pose2, contact: Vec2, normal: f64) -> Option<(f64, f64)> {
    let foot = map.nearest(map_from_odom.transform_point(contact))?;
    let turn = wrap_angle(normal + map_from_odom.theta - foot.tangent - FRAC_PI_2);
    Some((foot.distance, turn.abs()))
}
