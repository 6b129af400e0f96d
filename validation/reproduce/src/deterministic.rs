//! Deterministic localization, stage by stage.

use super::ground::{self, SWEEPS, layer};
use super::{Section, paper_method};
use vibrissa::beam::TipModel;
use vibrissa::config::{DeterministicOptions, TipLoad};
use vibrissa::figure::{Geometry, Layer, MapPlate, Outline, map_plate};
use vibrissa::flow::moment::{MomentReading, MomentTrack};
use vibrissa::flow::preimage::Observation;
use vibrissa::flow::state_set::{StateSet, components};
use vibrissa::flow::trajectory::pose_at;
use vibrissa::plane::Pose2;
use vibrissa::sim::{Sweep, SweepNoise};
use vibrissa::world::{Map, Robot};
use vibrissa::{Error, Result};

/// Travel between two observations (m): each has readings of its own.
const BETWEEN: f64 = 10e-3;
/// At most this many states are drawn.
const DRAWN: usize = 1500;
/// What the paper counts after the second observation and after the fourth.
const PAPER: [f64; 2] = [19.0, 6.0];

/// One observation, and where the odometry had the robot.
struct Felt {
    observation: Observation,
    odom_from_robot: Pose2,
}

pub(super) fn section() -> Result<Section> {
    let mut section = Section::new("deterministic", "Deterministic localization in four stages");
    let (map, robot) = (ground::arena()?, ground::robot(1.0));
    let sweep = ground::arena_sweep(&map, SWEEPS[0].way, &SweepNoise::seeded(1))?;
    // The plain intersection, with the paper's spacing of the boundary.
    let options = DeterministicOptions {
        missed_share: 0.0,
        boundary_spacing: SPACING,
        update_travel: BETWEEN,
        history_travel: BETWEEN,
        tip_load: TipLoad::BoundaryNormal,
        ..DeterministicOptions::default()
    };
    let felt = observations(&sweep, &robot, &options)?;
    let [first, second, third, fourth, ..] = felt.as_slice() else {
        return Err(Error::data("the built-in sweep is too short for four observations"));
    };
    let samples = map.samples(options.boundary_spacing);
    let mut set = StateSet::default();
    set.project(first.odom_from_robot, &robot.odometry);
    set.start(&map, &samples, core::slice::from_ref(&first.observation), &options);
    let one: Vec<Pose2> = set.states(first.odom_from_robot).collect();
    set.project(second.odom_from_robot, &robot.odometry);
    let projected: Vec<Pose2> = set.states(second.odom_from_robot).collect();
    set.intersect(&map, &second.observation, &options);
    let two: Vec<Pose2> = set.states(second.odom_from_robot).collect();
    let places_two = set.components(second.odom_from_robot).len();
    let (area_two, _) = set.size(second.odom_from_robot, options.boundary_spacing);
    for later in [third, fourth] {
        set.project(later.odom_from_robot, &robot.odometry);
        set.intersect(&map, &later.observation, &options);
    }
    let four: Vec<Pose2> = set.states(fourth.odom_from_robot).collect();
    let (area_four, _) = set.size(fourth.odom_from_robot, options.boundary_spacing);
    let places_four = components(set.candidates(), fourth.odom_from_robot).len();
    let outlines = ground::outlines(&map);
    let picture = |title: &str, states: &[Pose2], class: &'static str, when: &Felt| {
        stage(title, &outlines, states, class, pose_at(&sweep.truth, when.observation.t))
    };
    section.show(
        "stages",
        [
            "Figure “deterministicLocalization”: (a) states after one observation, (b) moved along by the known motion, (c) \
             those that a second observation leaves (19 points), (d) after four observations (6 points).",
            "The same four stages in the arena, observations 10 mm apart, from the first simulated sweep.",
            "Ours are states in place and heading with a tolerance for readings off by up to 5 % and 20 µN m; the paper's are crossings of \
             curves in the plane. Its map is not dimensioned.",
        ],
        vec![
            picture("(a) One observation", &one, "candidate", first),
            picture("(b) The same, moved along", &projected, "candidate", second),
            picture("(c) After the second observation", &two, "survivor", second),
            picture("(d) After the fourth observation", &four, "survivor", fourth),
        ],
    );
    for (name, count) in [("first", one.len()), ("second", two.len()), ("fourth", four.len())] {
        section.tell(name, count as f64, 0, "");
    }
    section.say(
        "One observation leaves {deterministic.first} states on the boundary's 1 mm grid, two leave {deterministic.second}, \
         four leave {deterministic.fourth}; they form the separate places below.",
    );
    let reason = "The paper counts crossings of curves. Ours counts separate places: a strip along a straight wall is one \
                  place until it falls apart. Map, start and noise differ.";
    section.compare(
        "Separate places after the second observation",
        "places_second",
        (PAPER[0], places_two as f64),
        (0, ""),
        reason,
    );
    section.compare(
        "Separate places after the fourth observation",
        "places_fourth",
        (PAPER[1], places_four as f64),
        (0, ""),
        reason,
    );
    as_written(&mut section, &map, &robot)?;
    section.compare(
        "Observations for the first set of states",
        "first_needs",
        (3.0, options.history_shapes as f64),
        (0, ""),
        "“A minimum of three”; ours takes shapes over 10 mm of travel, smoothed.",
    );
    section.find(
        "Area of the places, after the fourth over after the second",
        "area_share",
        "fewer states",
        (area_four / area_two, 3, ""),
        "What counts: the set shrinks.",
    );
    let truth = pose_at(&sweep.truth, fourth.observation.t);
    let nearest = truth.map_or(f64::NAN, |truth| {
        four.iter().map(|state| state.position().distance(truth.position())).fold(f64::INFINITY, f64::min)
    });
    section.find(
        "The true state after four observations: distance to the nearest one left",
        "nearest",
        "not told",
        (1e3 * nearest, 2, "mm"),
        "The truth must survive the intersection.",
    );
    Ok(section)
}

/// The paper's own count: crossings of the curve of states with the next observation's, in the plane.
fn as_written(section: &mut Section, map: &Map, robot: &Robot) -> Result<()> {
    let whisker = &robot.whiskers[0];
    let samples = paper_method::samples(map);
    for (name, words, noise) in [
        ("exact", "readings without errors", SweepNoise::none()),
        ("noisy", "readings off by up to 5 % and 20 µN m", SweepNoise::seeded(1)),
    ] {
        let sweep = ground::arena_sweep(map, SWEEPS[0].way, &noise)?;
        let shapes = paper_method::shapes(&sweep.log, whisker, paper_method::SHAPES, ROWS)?;
        let [first, second, third, fourth, ..] = shapes.as_slice() else {
            return Err(Error::data("the built-in sweep is too short for four observations"));
        };
        let curves = [first, second, third, fourth].map(|shape| paper_method::curve(map, &samples, shape));
        let mut states = paper_method::crossings(&paper_method::projected(&curves[0], first, second), &curves[1]);
        section.compare(
            &format!("Crossings of curves after the second observation, as the paper counts them, {words}"),
            &format!("crossings_second.{name}"),
            (PAPER[0], states.len() as f64),
            (0, ""),
            "The boundary's slope from shapes t and t + 2, the shape laid at points 1 mm apart. Along a straight wall the curves are \
             parallel and do not cross.",
        );
        for (pair, curve) in [[second, third], [third, fourth]].iter().zip(&curves[2..]) {
            let moved = paper_method::projected(&vec![states], pair[0], pair[1]);
            states = paper_method::passed(&moved.concat(), curve);
        }
        section.compare(
            &format!("States left after the fourth observation, as the paper counts them, {words}"),
            &format!("crossings_fourth.{name}"),
            (PAPER[1], states.len() as f64),
            (0, ""),
            "Those that the third and the fourth curve pass within 1 mm.",
        );
    }
    Ok(())
}

/// Rows between two of the paper's observations: 10 mm of travel.
const ROWS: usize = 20;
/// The paper's spacing of the points along the boundary (m).
const SPACING: f64 = 1e-3;

/// The observations of the sweep's first contact.
fn observations(sweep: &Sweep, robot: &Robot, options: &DeterministicOptions) -> Result<Vec<Felt>> {
    let whisker = &robot.whiskers[0];
    let tip = TipModel::new(&whisker.beam)?;
    let mut track = MomentTrack::new(whisker, options);
    let mut felt = Vec::new();
    for row in &sweep.log.rows {
        let moment = row.readings.first().copied().unwrap_or(0.0);
        if !track.is_contact(moment) {
            continue;
        }
        let odom_from_whisker = row.odom_from_robot.compose(whisker.robot_from_whisker);
        let history = track.push(MomentReading { t: row.t, odom_from_whisker, moment });
        if let Some(history) = history.filter(|history| history.smooth) {
            let observation = Observation::new(whisker, &tip, &history, options.tip_load);
            let odom_from_robot = observation.odom_from_whisker.compose(whisker.robot_from_whisker.inverse());
            felt.push(Felt { observation, odom_from_robot });
        }
    }
    // While the whisker is pressed into the wall nothing is known of the wall's slope.
    Ok(felt.into_iter().skip_while(|felt| felt.observation.open_slopes() > 0.5).collect())
}

fn stage(title: &str, map: &[Outline], states: &[Pose2], class: &'static str, truth: Option<Pose2>) -> String {
    let words = if class == "candidate" { "possible states" } else { "states left" };
    let mut layers: Vec<Layer> = vec![layer(Geometry::States(ground::thinned(states, DRAWN)), class, words)];
    layers.extend(truth.map(|pose| layer(Geometry::Circles(vec![pose.position()]), "truth-mark", "true state")));
    map_plate(&MapPlate { title, map, layers: &layers, window: None, frame: "map frame" })
}
