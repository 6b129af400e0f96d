//! Contact points by intersecting contact sets: four virtual sensors, two whiskers, two times.

use super::Section;
use super::contact_sets::contacts;
use vibrissa::Result;
use vibrissa::beam::normal::largest_moment;
use vibrissa::beam::{Bend, Load, Whisker, point_mode};
use vibrissa::figure::{ContactFigure, contact_plate};
use vibrissa::flow::contact_set::{
    ContactModel, ContactSet, Meeting, MomentRegime, PlacedSet, VirtualSensor, intersect,
};
use vibrissa::plane::{Pose2, Vec2};

/// Nodes of a curve: fine, since crossings are shallow.
const NODES: usize = 400;
/// Where the object is touched (m, whisker frame before the step), and the base's step along y (m): the paper's 1 mm.
const TOUCHED: Vec2 = Vec2::new(0.055, 0.006);
const STEP: f64 = 1e-3;
/// Relative error of the readings in the second try.
const OFF: f64 = 0.01;
/// The paper's base motion or spacing of sensors in its second figure (m), and its two moments (N m).
const APART: f64 = 4.2e-3;
const MOMENTS: [f64; 2] = [17e-3, 25e-3];
/// Where the object of our own figure is touched (m).
const PEG: Vec2 = Vec2::new(0.048, 0.010);

/// A reading of one sensor before and after the base moved away from the object by `step`, and where the curves cross.
struct Pair {
    sets: [ContactSet; 2],
    step: f64,
    meetings: Vec<Meeting>,
}

impl Pair {
    fn new(model: &ContactModel, sensor: VirtualSensor, values: [f64; 2], step: f64) -> Result<Self> {
        let set = |value| ContactSet::new(model, sensor, value, NODES);
        let sets = [set(values[0])?, set(values[1])?];
        let moved = PlacedSet { set: &sets[1], frame_from_whisker: Pose2::new(0.0, -step, 0.0) };
        let meetings = intersect(PlacedSet::at_home(&sets[0]), moved, 1e-9);
        Ok(Self { sets, step, meetings })
    }

    /// How far the crossing nearest to the object is from it (m); infinite when there is none.
    fn error(&self, object: Vec2) -> f64 {
        self.meetings.iter().map(|meeting| meeting.position.distance(object)).fold(f64::INFINITY, f64::min)
    }

    fn plate(&self, title: &str, words: [&str; 2]) -> String {
        let moved = |points: &mut Vec<Vec2>| points.iter_mut().for_each(|p| p.y -= self.step);
        let (mut figure, _) = contacts(title, &[(&self.sets[0], words[0])]);
        let (mut second, _) = contacts("", &[(&self.sets[1], words[1])]);
        second.shapes.iter_mut().for_each(moved);
        second.curves.iter_mut().for_each(|(_, points)| moved(points));
        figure.shapes = every(figure.shapes, 4).into_iter().chain(every(second.shapes, 4)).collect();
        figure.curves.extend(second.curves);
        figure.points = self.meetings.iter().map(|meeting| meeting.position).collect();
        contact_plate(&ContactFigure { title: title.to_owned(), ..figure })
    }
}

fn every<T>(all: Vec<T>, n: usize) -> Vec<T> {
    all.into_iter().step_by(n).collect()
}

/// The whisker against the object before and after the step, less bent shape.
fn bends(object: Vec2, step: f64) -> Result<Option<[Bend; 2]>> {
    let least = |point: Vec2| -> Result<Option<Bend>> {
        let bends = point_mode(&Whisker::default(), point, Load::Normal)?;
        Ok(bends.into_iter().min_by(|a, b| a.phi_a.abs().total_cmp(&b.phi_a.abs())))
    };
    Ok(least(object)?.zip(least(object + Vec2::new(0.0, step))?).map(|(a, b)| [a, b]))
}

pub(super) fn section() -> Result<Section> {
    let mut section = Section::new("filtering", "Contact points by filtering");
    let model = ContactModel::new(&Whisker::default(), Load::Normal)?;
    virtual_sensors(&mut section, &model)?;
    two_bases(&mut section, &model)?;
    Ok(section)
}

fn virtual_sensors(section: &mut Section, model: &ContactModel) -> Result<()> {
    let Some([first, second]) = bends(TOUCHED, STEP)? else { return Ok(()) };
    let small = VirtualSensor::Moment(MomentRegime::SmallAngle);
    let large = VirtualSensor::Moment(MomentRegime::LargeAngle);
    let of = |sensor: VirtualSensor, bend: &Bend| match sensor {
        VirtualSensor::Load => bend.force,
        VirtualSensor::Strip => bend.s_a,
        VirtualSensor::Slope => bend.phi_a,
        VirtualSensor::Moment(_) => bend.moment,
    };
    let mut pictures = Vec::new();
    for (letter, name, sensor) in [
        ("a", "Load sensor", VirtualSensor::Load),
        ("b", "Contact strip", VirtualSensor::Strip),
        ("c", "End-slope sensor", VirtualSensor::Slope),
        ("d", "Moment sensor, large angles", large),
        ("d, as the paper", "Moment sensor, small angles", small),
    ] {
        let values = [of(sensor, &first), of(sensor, &second)];
        let pair = Pair::new(model, sensor, values, STEP)?;
        pictures.push(pair.plate(&format!("({letter}) {name}"), ["before the step", "after 1 mm"]));
        let key = match sensor {
            VirtualSensor::Moment(MomentRegime::SmallAngle) => "moment_small_angle",
            _ => sensor.word(),
        };
        let reason = match sensor {
            VirtualSensor::Moment(MomentRegime::SmallAngle) => {
                "With exact readings it is {filtering.moment_small_angle.exact} mm off: small angles, at a deflection of 6 mm."
            }
            VirtualSensor::Strip => {
                "The arc length hardly changes in the step: with this error the true crossing is gone, a buckled shape far off is left."
            }
            _ => {
                "The first reading 1 % too high, the second 1 % too low. One millimetre tells little; the table uses 60 readings."
            }
        };
        let off = Pair::new(model, sensor, [values[0] * (1.0 + OFF), values[1] * (1.0 - OFF)], STEP)?;
        section.tell(&format!("{key}.exact"), 1e3 * pair.error(TOUCHED), 4, "mm");
        section.tell(&format!("{key}.crossings"), pair.meetings.len() as f64, 0, "");
        section.find(
            &format!("{name}: crossing against the true contact, readings off by ±1 %"),
            &format!("{key}.off"),
            "drawn, without a number",
            (1e3 * off.error(TOUCHED), 2, "mm"),
            reason,
        );
    }
    section.show(
        "virtual-sensors",
        [
            "Figure “contactFromVirtualSensor”: the contact as the crossing of two contact sets, the base moved by 1 mm along \
             y, for (a) load, (b) contact strip, (c) end slope, (d) moment at small angles.",
            "A point at 55 mm, 6 mm to the side, felt by all four, with the base moved by 1 mm.",
            "The paper shows a range of values; we show one. We add the moment at large angles.",
        ],
        pictures,
    );
    section.say(
        "With exact readings the four curves cross in the true contact, to {filtering.load.exact}, \
         {filtering.strip.exact}, {filtering.slope.exact} and {filtering.moment.exact} mm. Crossings found: load \
         {filtering.load.crossings}, strip {filtering.strip.crossings}, end slope {filtering.slope.crossings}, moment \
         {filtering.moment.crossings} (small angles {filtering.moment_small_angle.crossings}). All of them are kept.",
    );
    Ok(())
}

fn two_bases(section: &mut Section, model: &ContactModel) -> Result<()> {
    let large = VirtualSensor::Moment(MomentRegime::LargeAngle);
    let mut pictures = Vec::new();
    if let Some([near, far]) = bends(PEG, APART)? {
        let pair = Pair::new(model, large, [near.moment, far.moment], APART)?;
        pictures.push(pair.plate("(a) Spatial: two whiskers 4.2 mm apart", ["first whisker", "second whisker"]));
        pictures.push(pair.plate("(b) Temporal: one whisker, moved by 4.2 mm", ["before", "after"]));
        section.tell("first_moment", 1e3 * near.moment, 2, "mN m");
        section.tell("second_moment", 1e3 * far.moment, 2, "mN m");
        section.find(
            "Spatial and temporal filtering: crossing against the true contact",
            "spatial.error",
            "drawn, without a number",
            (1e3 * pair.error(PEG), 4, "mm"),
            "Exact readings; the geometry of both cases is the same.",
        );
    }
    let paper = Pair::new(model, large, MOMENTS, APART)?;
    pictures.push(paper.plate("(c) The paper's own moments, 4.2 mm apart", ["17 mN m", "25 mN m"]));
    let reach = |moment: f64| 1e3 * largest_moment() * Whisker::default().flexural_rigidity / moment;
    section.find(
        "Farthest contact that can cause 17 mN m",
        "reach_17",
        "a contact on a 75 mm whisker",
        (reach(MOMENTS[0]), 1, "mm"),
        "Under a load normal to the whisker M(0) sₐ / E I has a maximum, however strong the bending: see the errata.",
    );
    section.find(
        "Farthest contact that can cause 25 mN m",
        "reach_25",
        "a contact on a 75 mm whisker",
        (reach(MOMENTS[1]), 1, "mm"),
        "Under a load normal to the whisker. A force of fixed direction causes it at the tip: see the errata.",
    );
    let nearest = paper.meetings.iter().map(|m| 1e3 * m.position.norm()).fold(f64::INFINITY, f64::min);
    section.tell("paper_crossings", paper.meetings.len() as f64, 0, "");
    section.find(
        "Contact that explains 17 and then 25 mN m over 4.2 mm: its distance",
        "paper_contact",
        "drawn, without a number",
        (nearest, 1, "mm"),
        "Taken at its word on the paper's wire, the contact would lie this near to the base (an em dash: none does).",
    );
    section.say(
        "For the second figure we press a peg at 48 mm by 10 mm and by 4.2 mm more: {filtering.first_moment} mN m and \
         {filtering.second_moment} mN m. Taken as they stand and under a load normal to the whisker, the paper's 17 and 25 mN m \
         have this many contacts in common: {filtering.paper_crossings}.",
    );
    section.show(
        "two-bases",
        [
            "Figure “filtering”: (a) two whiskers 4.2 mm apart, (b) one whisker moved by 4.2 mm; moments of 17 and 25 mN m.",
            "(a) and (b) with the moments that a peg at 48 mm causes on the paper's wire; (c) with the paper's moments.",
            "See the errata for the paper's moments.",
        ],
        pictures,
    );
    Ok(())
}
