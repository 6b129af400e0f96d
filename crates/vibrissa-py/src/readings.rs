//! Readings of virtual sensors: the contacts and the robot states that explain them.

use crate::arrays::{Table, column, points, table};
use crate::error::{OrRaise, warn};
use crate::inputs::RobotIn;
use crate::long::run;
use crate::world::PyMap;
use core::f64::consts::TAU;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::Arc;
use vibrissa::beam::Load;
use vibrissa::flow::contact_set::{
    Contact, ContactModel, ContactRegion, ContactSet, Limits, Meeting, MomentRegime, Parts, PlacedSet, Reading,
    Resolution, VirtualSensor, intersect_all,
};
use vibrissa::flow::preimage::{Construction, PreimageOptions, ReadingPreimage, fused_preimage, reading_preimage};
use vibrissa::plane::Pose2;
use vibrissa::sets::Interval;
use vibrissa::world::{Map, MountedWhisker, Robot};
use vibrissa::{Error, Result, config};

/// The attributes of `vibrissa.Reading`, the value as an interval.
#[derive(Debug, FromPyObject)]
pub(crate) struct ReadingIn {
    sensor: String,
    interval: (f64, f64),
    whisker: Option<String>,
}

/// The model that readings are explained by.
#[derive(Debug, FromPyObject)]
pub(crate) struct ModelIn {
    load: String,
    regime: String,
    max_force: f64,
    max_moment: f64,
    max_slope: f64,
}

/// The readings of one whisker.
struct Felt {
    model: ContactModel,
    robot_from_whisker: Pose2,
    readings: Vec<Reading>,
}

impl ModelIn {
    fn load(&self) -> Result<Load> {
        match self.load.as_str() {
            "normal" => Ok(Load::Normal),
            "vertical" => Ok(Load::Vertical),
            other => Err(Error::usage("the load").value(other).allowed("normal, vertical")),
        }
    }

    fn regime(&self) -> Result<MomentRegime> {
        match self.regime.as_str() {
            "auto" => Ok(MomentRegime::Auto),
            "small" => Ok(MomentRegime::SmallAngle),
            "large" => Ok(MomentRegime::LargeAngle),
            other => Err(Error::usage("the regime").value(other).allowed("auto, small, large")),
        }
    }

    fn reading(&self, given: &ReadingIn) -> Result<Reading> {
        let mut sensor = VirtualSensor::from_word(&given.sensor)?;
        if let VirtualSensor::Moment(regime) = &mut sensor {
            *regime = self.regime()?;
        }
        let (lo, hi) = given.interval;
        if lo > hi {
            let turned = Error::usage(format!("the {} reading", given.sensor)).value(format!("({lo}, {hi})"));
            return Err(turned.allowed("an interval (lo, hi) with lo not above hi"));
        }
        let reading = Reading { sensor, value: Interval::new(lo, hi) };
        reading.check()?;
        Ok(reading)
    }

    /// The readings whisker by whisker in the robot's order; those without any are left out.
    fn felt(&self, robot: &Robot, given: &[ReadingIn]) -> Result<Vec<Felt>> {
        if given.is_empty() {
            return Err(Error::usage("no reading").remedy("give one vibrissa.Reading or more"));
        }
        let mut owned: Vec<(usize, Reading)> = Vec::new();
        for reading in given {
            owned.push((owner(robot, reading.whisker.as_deref())?, self.reading(reading)?));
        }
        let limits = Limits { force: self.max_force, moment: self.max_moment, slope: self.max_slope };
        let one = |(index, mounted): (usize, &MountedWhisker)| {
            let readings: Vec<Reading> = owned.iter().filter(|(w, _)| *w == index).map(|(_, r)| *r).collect();
            (!readings.is_empty()).then(|| {
                let model = ContactModel::new(&mounted.beam, self.load()?)?.with_limits(limits)?;
                Ok(Felt { model, robot_from_whisker: mounted.robot_from_whisker, readings })
            })
        };
        robot.whiskers.iter().enumerate().filter_map(one).collect()
    }
}

fn owner(robot: &Robot, name: Option<&str>) -> Result<usize> {
    let Some(name) = name else { return Ok(0) };
    robot.whiskers.iter().position(|whisker| whisker.name == name).ok_or_else(|| {
        let names: Vec<&str> = robot.whiskers.iter().map(|whisker| whisker.name.as_str()).collect();
        Error::usage("whisker").value(name).allowed(names.join(", "))
    })
}

/// What readings leave of the contacts.
struct Found {
    curves: Vec<ContactSet>,
    meetings: Vec<Meeting>,
    region: ContactRegion,
}

impl Found {
    fn new(whiskers: &[Felt]) -> Result<Self> {
        let first = &whiskers[0];
        let mut curves = Vec::new();
        let mut frames = Vec::new();
        let mut region = ContactRegion::new(&first.model, &first.readings, &Resolution::default())?;
        for (index, whisker) in whiskers.iter().enumerate() {
            let frame = first.robot_from_whisker.between(whisker.robot_from_whisker);
            for reading in whisker.readings.iter().filter(|reading| reading.value.width() <= 0.0) {
                let nodes = config::contact_set::NODES;
                curves.push(ContactSet::new(&whisker.model, reading.sensor, reading.value.lo(), nodes)?);
                frames.push(frame);
            }
            if index > 0 {
                let there = ContactRegion::new(&whisker.model, &whisker.readings, &Resolution::default())?;
                region = region.shared_with(&there, frame);
            }
        }
        let readings: usize = whiskers.iter().map(|whisker| whisker.readings.len()).sum();
        let placed = |(set, frame)| PlacedSet { set, frame_from_whisker: frame };
        let placed: Vec<PlacedSet<'_>> = curves.iter().zip(frames).map(placed).collect();
        let all_exact = curves.len() == readings && readings > 1;
        let meetings = if all_exact { intersect_all(&placed, config::contact_set::MEETING) } else { Vec::new() };
        Ok(Self { curves, meetings, region })
    }
}

/// A contact: x, y, `s_a`, `phi_a`, force, moment.
fn numbers(c: &Contact) -> [f64; 6] {
    [c.position.x, c.position.y, c.s_a, c.phi_a, c.force, c.moment]
}

/// The contacts that explain readings; gives the fields of `vibrissa.ContactSets`.
#[pyfunction]
pub(crate) fn contact_set<'py>(
    py: Python<'py>,
    readings: Vec<ReadingIn>,
    robot: RobotIn,
    model: ModelIn,
) -> PyResult<Bound<'py, PyDict>> {
    let robot = robot.robot().or_raise(py)?;
    let found = run(py, None, 0, move |_| Found::new(&model.felt(&robot, &readings)?))?;
    let out = PyDict::new(py);
    let curve = |set: &ContactSet| -> PyResult<Bound<'py, PyDict>> {
        let one = PyDict::new(py);
        one.set_item("sensor", set.sensor.word())?;
        one.set_item("value", set.value)?;
        one.set_item("tolerance", set.tolerance)?;
        one.set_item("small_angle", set.model().is_small_angle())?;
        let branches = set.curves.iter().map(|curve| table(py, curve.contacts(), numbers));
        one.set_item("branches", branches.collect::<PyResult<Vec<_>>>()?)?;
        Ok(one)
    };
    out.set_item("curves", found.curves.iter().map(curve).collect::<PyResult<Vec<_>>>()?)?;
    let meeting = |m: &Meeting| {
        let contacts = (numbers(&m.first).to_vec(), numbers(&m.second).to_vec());
        (m.position.x, m.position.y, m.extent, m.is_crossing, m.is_one_shape(), contacts.0, contacts.1)
    };
    out.set_item("meetings", found.meetings.iter().map(meeting).collect::<Vec<_>>())?;
    let cells = &found.region.cells;
    out.set_item("region", table(py, cells, |cell| numbers(&cell.contact))?)?;
    out.set_item("radius", column(py, cells, |cell| cell.radius))?;
    let covers: PyResult<Vec<Table<'_>>> = cells.iter().map(|cell| points(py, cell.cover.corners())).collect();
    out.set_item("covers", covers?)?;
    out.set_item("components", found.region.components())?;
    out.set_item("area", found.region.area())?;
    Ok(out)
}

/// The robot states that explain readings; gives the fields of `vibrissa.Preimage`.
#[pyfunction]
#[allow(clippy::too_many_arguments)] // Called from one place, by name.
pub(crate) fn preimage<'py>(
    py: Python<'py>,
    map: &PyMap,
    readings: Vec<ReadingIn>,
    robot: RobotIn,
    model: ModelIn,
    construction: &str,
    contacts: &str,
    collision_free: bool,
    cell: Option<f64>,
    heading_step: Option<f64>,
) -> PyResult<Bound<'py, PyDict>> {
    let options = options(construction, contacts, collision_free, cell, heading_step).or_raise(py)?;
    let (map, robot) = (Arc::clone(&map.0), robot.robot().or_raise(py)?);
    robot.require_level("a preimage").or_raise(py)?;
    let found = run(py, None, 0, move |_| solve(&map, &model.felt(&robot, &readings)?, &options))?;
    if found.states.is_empty() {
        let why = "no state explains the readings: they contradict each other, the whisker's limits or the map";
        warn(py, &[why.to_owned()])?;
    }
    let out = PyDict::new(py);
    out.set_item("states", table(py, found.states.boxes(), |state| state)?)?;
    out.set_item("area", found.states.area())?;
    out.set_item("sampled_area", found.sampled_area)?;
    out.set_item("volume", found.states.volume())?;
    out.set_item("deviation", found.deviation)?;
    out.set_item("cell", options.cell)?;
    out.set_item("headings", options.headings)?;
    Ok(out)
}

fn options(
    construction: &str,
    contacts: &str,
    collision_free: bool,
    cell: Option<f64>,
    heading_step: Option<f64>,
) -> Result<PreimageOptions> {
    let default = PreimageOptions::default();
    let construction = match construction {
        "alignment" => Construction::Alignment,
        "distance" => Construction::Distance,
        other => return Err(Error::usage("construction").value(other).allowed("alignment, distance")),
    };
    let contacts = match contacts {
        "side" => Parts::Side,
        "tip" => Parts::Tip,
        "all" => Parts::All,
        other => return Err(Error::usage("contacts").value(other).allowed("side, tip, all")),
    };
    let headings = match heading_step {
        None => default.headings,
        Some(step) if step > 0.0 && step.is_finite() => (TAU / step).round().clamp(0.0, 1e6) as usize,
        Some(step) => return Err(Error::usage("heading_step").value(step).allowed("above 0 rad")),
    };
    let options =
        PreimageOptions { cell: cell.unwrap_or(default.cell), headings, construction, contacts, collision_free };
    options.check()?;
    Ok(options)
}

fn solve(map: &Map, whiskers: &[Felt], options: &PreimageOptions) -> Result<ReadingPreimage> {
    if let [only] = whiskers {
        return reading_preimage(map, &only.model, only.robot_from_whisker, &only.readings, options);
    }
    let region = |felt: &Felt| {
        let reach = felt.model.length() + felt.robot_from_whisker.position().norm();
        let region =
            ContactRegion::of_parts(&felt.model, &felt.readings, options.contacts, &options.resolution(reach))?;
        Ok((region, felt.robot_from_whisker))
    };
    fused_preimage(map, &whiskers.iter().map(region).collect::<Result<Vec<_>>>()?, options)
}
