//! Contact sets, contacts, outlines and preimages of robots and maps of any kind, for readings of any kind.

use super::world::World;
use super::{Verdict, promise, read, refused, size};
use crate::random::Random;
use vibrissa::beam::Load;
use vibrissa::config::{ContactOptions, ProfileOptions};
use vibrissa::flow::contact_set::{ContactModel, ContactRegion, ContactSet, Limits, Parts, Reading, VirtualSensor};
use vibrissa::flow::preimage::{Construction, PreimageOptions, region_preimage};
use vibrissa::io::robot;
use vibrissa::plane::Vec2;
use vibrissa::sets::Interval;
use vibrissa::tasks::contact::contacts_until;
use vibrissa::tasks::profile::profile_until;
use vibrissa::{Error, Result, Robot, Stop};

/// Readings after which a search is asked to stop: of uniform whiskers, and of others, which are integrated.
const MOST_READINGS: [usize; 2] = [200, 20];
/// Cells of a preimage (m), and its headings: finer ones take longer than a try may.
const CELL: f64 = 0.01;
const HEADINGS: usize = 16;

/// Where and how a world's whiskers touched.
pub(crate) fn contact(bytes: &[u8]) -> Verdict {
    let found = World::read(bytes).and_then(|world| {
        let stop = Stop::default();
        let most = most_readings(&world.robot);
        contacts_until(&world.log, &world.robot, &ContactOptions::default(), &stop, &mut |done, _| {
            if done >= most {
                stop.ask();
            }
        })
    });
    match found {
        Err(error) => refused(&error),
        Ok(report) => {
            let whole = report.steps.iter().filter_map(|s| s.position()).all(Vec2::is_finite);
            promise(whole, || "a contact that is no numbers".into())?;
            read((size(report.steps.len()), size(report.events.len()), report.stopped_at.is_some()))
        }
    }
}

/// The outline that a world's whiskers felt.
pub(crate) fn outline(bytes: &[u8]) -> Verdict {
    let found = World::read(bytes).and_then(|world| {
        let stop = Stop::default();
        let most = most_readings(&world.robot);
        let (contact, options) = (ContactOptions::default(), ProfileOptions::default());
        profile_until(&[world.log], &world.robot, &contact, &options, &stop, &mut |_, done, _| {
            if done >= most {
                stop.ask();
            }
        })
    });
    match found {
        Err(error) => refused(&error),
        Ok(found) => {
            let mut points = found.outlines.iter().flat_map(|o| &o.points);
            promise(points.all(|p| p.position.is_finite() && p.std >= 0.0), || "an outline of no numbers".into())?;
            read((size(found.outlines.len()), size(found.pegs.len()), size(found.left_out), found.stopped_at.is_some()))
        }
    }
}

fn most_readings(robot: &Robot) -> usize {
    MOST_READINGS[usize::from(!robot.whiskers.iter().all(|w| w.beam.is_uniform()))]
}

/// Words that stand in the readings of contact sets.
pub(crate) const WORDS: &[&str] = &[
    "tip_ratio = 0.3\n",
    "curvature = [4.0]\n",
    "base_stiffness = 0.002\n",
    "segments = [{ length = 0.02, flexural_rigidity = 2e-4 }, { length = 0.03, flexural_rigidity = 1e-4 }]\n",
    "strain_limit = 0.06\n",
    "moment 1e-3 1e-3\n",
    "load 0.1 0.2\n",
    "strip 0.03 0.05\n",
    "slope 0.2 0.2\n",
    "part side\n",
    "part tip\n",
    "limits 0.5 2e-3 1.2\n",
    "tilt 0.3\n",
    "vertical\n",
    "distance\n",
    "inside\n",
    "nan",
    "inf",
];

/// A robot, a line `%%`, then a line for each reading (`moment LO HI`) and each choice.
pub(crate) fn draw(random: &mut Random) -> Vec<u8> {
    let mut whisker = vibrissa::world::MountedWhisker::default();
    whisker.beam.length *= 1.0 + 0.9 * random.signed();
    whisker.beam.flexural_rigidity *= 10f64.powf(2.0 * random.signed());
    if random.one_in(6) {
        whisker.beam.tip_ratio = 0.52 + 0.47 * random.signed();
    }
    if random.one_in(6) {
        whisker.beam.base_stiffness = 10f64.powf(-2.0 + random.signed());
    }
    let (length, rigidity) = (whisker.beam.length, whisker.beam.flexural_rigidity);
    let robot = Robot { whiskers: vec![whisker], ..Robot::default() };
    let mut text = robot::to_toml(&robot) + BETWEEN;
    for _ in 0..1 + random.below(2) {
        let (word, scale) =
            [("moment", rigidity / length), ("load", rigidity / (length * length)), ("strip", length), ("slope", 1.0)]
                [random.below(4)];
        let value = scale * 2.0 * random.signed() * random.signed().abs();
        let width = if random.one_in(2) { 0.0 } else { 0.1 * scale * random.signed().abs() };
        text += &format!("{word} {value:e} {:e}\n", value + width);
    }
    for _ in 0..random.below(3) {
        text += random.pick(&WORDS[WORDS.len() - 9..WORDS.len() - 2]).copied().unwrap_or_default();
    }
    text.into_bytes()
}

const BETWEEN: &str = "\n%%\n";

/// What is asked of a contact set.
struct Question {
    model: ContactModel,
    readings: Vec<Reading>,
    parts: Parts,
    construction: Construction,
    collision_free: bool,
    robot: Robot,
}

impl Question {
    fn read(bytes: &[u8]) -> Result<Self> {
        let text = String::from_utf8_lossy(bytes);
        let (robot, rest) = text.split_once(BETWEEN).unwrap_or((&text, ""));
        let robot = robot::from_toml(robot, "robot.toml")?;
        let Some(whisker) = robot.whiskers.first() else { return Err(Error::data("no whisker")) };
        let (mut load, mut limits, mut readings) = (Load::Normal, Limits::default(), Vec::new());
        let (mut parts, mut construction, mut collision_free) = (Parts::All, Construction::Alignment, true);
        for line in rest.lines() {
            let (word, numbers) = line.split_once(' ').unwrap_or((line, ""));
            let number = |k: usize| numbers.split(' ').nth(k).map_or(f64::NAN, |n| n.parse().unwrap_or(f64::NAN));
            match (word, numbers) {
                ("part", "side") => parts = Parts::Side,
                ("part", "tip") => parts = Parts::Tip,
                ("limits", _) => limits = Limits { force: number(0), moment: number(1), slope: number(2) },
                ("tilt", _) => load = Load::Tilted(number(0)),
                ("vertical", _) => load = Load::Vertical,
                ("distance", _) => construction = Construction::Distance,
                ("inside", _) => collision_free = false,
                _ => {
                    if let Ok(sensor) = VirtualSensor::from_word(word) {
                        readings.push(Reading { sensor, value: Interval::new(number(0), number(1)) });
                    }
                }
            }
        }
        let model = ContactModel::new(&whisker.beam, load)?.with_limits(limits)?;
        Ok(Self { model, readings, parts, construction, collision_free, robot })
    }
}

/// The set of a reading, the region of all of them, and where they may have been taken.
pub(crate) fn contact_sets(bytes: &[u8]) -> Verdict {
    match Question::read(bytes).and_then(|question| asked(&question)) {
        Ok(verdict) => verdict,
        Err(error) => refused(&error),
    }
}

fn asked(question: &Question) -> Result<Verdict> {
    let Question { model, readings, parts, .. } = question;
    let mut curves = 0;
    for reading in readings {
        reading.check()?;
        let set = ContactSet::new(model, reading.sensor, reading.value.lo(), 60)?;
        for contact in set.curves.iter().flat_map(|curve| curve.contacts()) {
            if !(contact.position.is_finite() && contact.phi_a.is_finite() && contact.moment.is_finite()) {
                return Ok(Err(format!("a contact that is no numbers: {contact:?}")));
            }
        }
        curves += set.curves.len();
    }
    let options = PreimageOptions {
        cell: CELL,
        headings: HEADINGS,
        construction: question.construction,
        contacts: *parts,
        collision_free: question.collision_free,
    };
    let mount = question.robot.whiskers[0].robot_from_whisker;
    let resolution = options.resolution(model.length() + mount.position().norm());
    let region = ContactRegion::of_parts(model, readings, *parts, &resolution)?;
    let area = region.area();
    if !(area.is_finite() && area >= 0.0) {
        return Ok(Err(format!("a region of {area} m²")));
    }
    let map = vibrissa::io::map::from_geojson(MAP, "map.geojson")?;
    let found = region_preimage(&map, &region, mount, &options)?;
    let sound = found.sampled_area >= 0.0 && found.deviation >= 0.0 && found.deviation.is_finite();
    Ok(promise(sound, || format!("an area of {} m² with {} m", found.sampled_area, found.deviation))
        .and_then(|()| read((size(curves), size(region.cells.len()), region.is_empty(), found.sampled_area > 0.0))))
}

/// A small room with a wall in it.
const MAP: &str = r#"{"type": "FeatureCollection", "features": [
{"type": "Feature", "properties": {"role": "arena"}, "geometry": {"type": "Polygon", "coordinates": [[[0, 0], [0.2, 0], [0.2, 0.15], [0, 0.15], [0, 0]]]}},
{"type": "Feature", "properties": {"role": "wall"}, "geometry": {"type": "LineString", "coordinates": [[0.05, 0.05], [0.1, 0.06]]}}]}"#;
