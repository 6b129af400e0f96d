//! Contact that slips from step to step, and the outline that five sweeps feel.

use super::Section;
use super::ground::{self, layer};
use vibrissa::config::{ContactOptions, ProfileOptions};
use vibrissa::figure::{Geometry, Layer, MapPlate, WorldBounds, map_plate};
use vibrissa::flow::pose::StampedPose;
use vibrissa::plane::{Curve, Pose2, Vec2};
use vibrissa::sim::{Pace, Sweep, SweepNoise, Touch, path_through, shapes, simulate_tip_sweep};
use vibrissa::tasks::contact::contacts;
use vibrissa::tasks::profile::{Profile, compare, profile};
use vibrissa::world::{Boundary, Map, Robot, Role};
use vibrissa::{Error, Result};

/// The paper's step of the base (m), and its count of sweeps.
const STEP: f64 = 4.2e-3;
const SWEEPS: u64 = 5;
/// A post that the whisker meets with its side (m), and the base's way along -y (m).
const POST: Vec2 = Vec2::new(0.058, 0.0);
const RADIUS: f64 = 0.010;
const DOWN: [f64; 2] = [0.012, -0.075];
/// The stage's way over the obstacle (mm).
const WAY: [[f64; 2]; 8] = [
    [110.0, 268.0],
    [150.0, 251.0],
    [190.0, 248.0],
    [225.0, 240.0],
    [265.0, 231.0],
    [300.0, 233.0],
    [340.0, 237.0],
    [380.0, 232.0],
];

pub(super) fn section() -> Result<Section> {
    let mut section = Section::new("profile", "Sweeping an obstacle: slip and profile");
    let slip = slip(&mut section)?;
    let (shapes, outline) = outline(&mut section)?;
    section.show(
        "slip",
        [
            "Figure “objectShape” (a): contact points and slip, the base moved by 4.2 mm in each step.",
            "The same on a post of 20 mm: the contact slips along the whisker and along the post towards the tip.",
            "The paper's object is not told, and its slip is read off the figure. Of ours the simulator's truth is shown, and beside it what `contact` finds from readings with errors.",
        ],
        vec![slip],
    );
    section.show(
        "outline",
        [
            "Figures “expSetup” (b) and “objectShape” (b): the whisker's shapes along an obstacle, and the profile from five \
             sweeps, which “closely matches” the CAD model.",
            "Five simulated sweeps over an obstacle with readings off by up to 5 % and 20 µN m, and the outline with its true shape.",
            "Tip contact throughout. The paper prints no error of its profile.",
        ],
        vec![shapes, outline],
    );
    Ok(section)
}

/// The contact on a post, step by step.
fn slip(section: &mut Section) -> Result<String> {
    let curve = Curve::circle(POST, RADIUS).ok_or_else(|| Error::data("a post without a size"))?;
    let map = Map::new(vec![Boundary::new(Role::Obstacle, curve, None)?])?;
    let way = DOWN.map(|y| Pose2::new(0.0, y, 0.0));
    let path = path_through(&way, &Pace { speed: 0.021, turn_rate: 1.0, rate: 300.0 })?;
    let robot = Robot::default();
    let sweep = simulate_tip_sweep(&map, &robot, &path, &SweepNoise::none())?;
    let stepped = stepped(&sweep);
    let all = shapes(&robot, &sweep, 1);
    let drawn: Vec<Vec<Vec2>> = stepped.iter().filter_map(|t| all.get(t.row)).map(|s| s.points.clone()).collect();
    let slips: Vec<(f64, f64)> =
        stepped.windows(2).map(|w| (w[0].position.distance(w[1].position), w[1].s_a - w[0].s_a)).collect();
    let largest = |pick: fn(&(f64, f64)) -> f64| slips.iter().map(pick).fold(0.0, f64::max);
    section.tell("steps", stepped.len() as f64, 0, "");
    section.tell("slip.first_arc", stepped.first().map_or(f64::NAN, |t| 1e3 * t.s_a), 1, "mm");
    section.tell("slip.last_arc", stepped.last().map_or(f64::NAN, |t| 1e3 * t.s_a), 1, "mm");
    section.say(
        "On the post the contact is followed over {profile.steps} steps of 4.2 mm; it goes from {profile.slip.first_arc} mm to \
         {profile.slip.last_arc} mm along the whisker before the whisker snaps free.",
    );
    section.find(
        "Largest slip along the object in one step",
        "slip.object",
        "marked in the figure",
        (1e3 * largest(|s| s.0), 2, "mm"),
        "A round object: the contact wanders as the whisker bends.",
    );
    section.find(
        "Largest slip along the whisker in one step",
        "slip.whisker",
        "marked in the figure",
        (1e3 * largest(|s| s.1), 2, "mm"),
        "“Contact often shifts toward the whisker tip”: so it does here.",
    );
    let felt = felt_contacts(&map, &robot, &path, &stepped)?;
    let felt_slips: Vec<(f64, f64)> = felt.windows(2).map(|w| (w[0].0.distance(w[1].0), w[1].1 - w[0].1)).collect();
    let felt_most = |pick: fn(&(f64, f64)) -> f64| 1e3 * felt_slips.iter().map(pick).fold(0.0, f64::max);
    section.find(
        "Largest slip along the object in one step, from readings",
        "slip.object_felt",
        "marked in the figure",
        (felt_most(|s| s.0), 2, "mm"),
        "What `contact` finds from moments off by up to 5 % and 20 µN m; the rows above are the simulator's truth.",
    );
    section.find(
        "Largest slip along the whisker in one step, from readings",
        "slip.whisker_felt",
        "marked in the figure",
        (felt_most(|s| s.1), 2, "mm"),
        "As above.",
    );
    let touched = stepped.iter().map(|touch| touch.position).collect();
    let layers = [
        layer(Geometry::Lines(drawn), "shape", "whisker every 4.2 mm"),
        layer(Geometry::Circles(touched), "meeting", "contact points"),
        layer(Geometry::Dots(felt.iter().map(|(at, _)| *at).collect()), "side-contact", "as readings tell them"),
    ];
    let outlines = ground::outlines(&map);
    let title = "A post met with the side: the contact slips";
    Ok(map_plate(&MapPlate { title, map: &outlines, layers: &layers, window: None, frame: "stage frame" }))
}

/// The contacts at the same steps as readings tell them: place (m, stage frame) and arc length (m).
fn felt_contacts(map: &Map, robot: &Robot, path: &[StampedPose], stepped: &[Touch]) -> Result<Vec<(Vec2, f64)>> {
    let sweep = simulate_tip_sweep(map, robot, path, &SweepNoise::seeded(1))?;
    let report = contacts(&sweep.log, robot, &ContactOptions::default())?;
    let nearest = |touch: &Touch| {
        let known = report.steps.iter().filter(|step| step.contact.is_some());
        let step = known.min_by(|a, b| (a.t - touch.t).abs().total_cmp(&(b.t - touch.t).abs()))?;
        let start = path.first().map_or(Pose2::IDENTITY, |row| row.map_from_robot);
        Some((start.transform_point(step.position()?), step.s_a?))
    };
    Ok(stepped.iter().filter_map(nearest).collect())
}

/// The touch at every step of the base.
fn stepped(sweep: &Sweep) -> Vec<Touch> {
    let touched = sweep.contacts.iter().map(|touch| touch.row);
    let rows = ground::rows_by_step(&sweep.truth, touched, STEP);
    rows.iter().filter_map(|row| sweep.contacts.iter().find(|touch| touch.row == *row)).copied().collect()
}

/// The outline from five sweeps.
fn outline(section: &mut Section) -> Result<(String, String)> {
    let (map, robot) = (ground::obstacle()?, ground::robot(-1.0));
    let path = ground::path(&WAY)?;
    let sweeps = (1..=SWEEPS)
        .map(|seed| simulate_tip_sweep(&map, &robot, &path, &SweepNoise::seeded(seed)))
        .collect::<Result<Vec<_>>>()?;
    let logs: Vec<_> = sweeps.iter().map(|sweep| sweep.log.clone()).collect();
    let felt = |logs: &[_]| profile(logs, &robot, &ContactOptions::default(), &ProfileOptions::default());
    let (all, one) = (felt(&logs)?, felt(&logs[..1])?);
    let start = path.first().map_or(Pose2::IDENTITY, |row| row.map_from_robot);
    let points = |found: &Profile| -> Vec<Vec2> {
        found.outlines.iter().flat_map(|o| &o.points).map(|p| start.transform_point(p.position)).collect()
    };
    let error = |found: &Profile| compare(&points(found), &map, false).map_or(f64::NAN, |c| 1e3 * c.absolute.mean);
    let misfit = compare(&points(&all), &map, false);
    section.find(
        "Mean error of the profile, five sweeps",
        "error",
        "“closely matches the actual profile”",
        (error(&all), 3, "mm"),
        "Absolute, against the true shape, without any alignment.",
    );
    section.find(
        "95 % of the profile's points are nearer than",
        "error_95",
        "no number",
        (misfit.map_or(f64::NAN, |c| 1e3 * c.absolute.p95), 3, "mm"),
        "As above.",
    );
    section.find(
        "Mean error of the profile, one sweep",
        "error_single",
        "no number",
        (error(&one), 3, "mm"),
        "The first of the five.",
    );
    let length: f64 = points(&all).windows(2).map(|w| w[0].distance(w[1])).sum();
    section.tell("length", 1e3 * length, 0, "mm");
    section.say("Five sweeps over the obstacle feel {profile.length} mm of its outline.");
    let title = "The whisker along the obstacle";
    let shown = along(&map, &robot, &sweeps[0], &path, title);
    let band = layer(Geometry::Dots(points(&all)), "tip-contact", "outline felt in five sweeps");
    let outlines = ground::outlines(&map);
    let title = "The profile on the true outline";
    let window = WorldBounds::of(points(&all)).map(|bounds| bounds.grown(0.012));
    let plate = map_plate(&MapPlate { title, map: &outlines, layers: &[band], window, frame: "map frame" });
    Ok((shown, plate))
}

fn along(map: &Map, robot: &Robot, sweep: &Sweep, path: &[StampedPose], title: &str) -> String {
    let all = shapes(robot, sweep, 1);
    let touched = sweep.contacts.iter().map(|touch| touch.row);
    let rows = ground::rows_by_step(path, touched, STEP);
    let drawn: Vec<Vec<Vec2>> = rows.iter().filter_map(|row| all.get(*row)).map(|shape| shape.points.clone()).collect();
    let layers: [Layer; 2] = [
        layer(Geometry::Lines(drawn), "whisker", "whisker every 4.2 mm"),
        layer(Geometry::Lines(vec![ground::positions(path)]), "path", "the base's way"),
    ];
    let outlines = ground::outlines(map);
    map_plate(&MapPlate { title, map: &outlines, layers: &layers, window: None, frame: "map frame" })
}
