//! Contact sets of the four virtual sensors, and the fusion of two of them.

use super::Section;
use vibrissa::Result;
use vibrissa::beam::{Load, Whisker};
use vibrissa::figure::{ContactFigure, contact_plate};
use vibrissa::flow::contact_set::{
    Contact, ContactModel, ContactSet, Limits, MomentRegime, PlacedSet, VirtualSensor, intersect,
};

/// The largest load that is believed (N): the paper has a largest one, without a value.
const LARGEST_FORCE: f64 = 0.5;
/// Nodes of a curve, and whisker shapes that are drawn along it.
const NODES: usize = 120;
const SHAPES: usize = 12;
/// The readings of the figures (N, m, rad, N m).
pub(super) const LOAD: f64 = 0.1;
pub(super) const STRIP: f64 = 0.06;
const SLOPE: f64 = 0.7;
const MOMENT: f64 = 1.1e-3;

/// The paper's whisker, loaded normal to itself by no more than half a newton.
pub(super) fn model() -> Result<ContactModel> {
    let limits = Limits { force: LARGEST_FORCE, ..Limits::default() };
    ContactModel::new(&Whisker::default(), Load::Normal)?.with_limits(limits)
}

/// The contacts of one or two readings, with whisker shapes along the curves and the crossings of two.
pub(super) fn contacts(title: &str, sets: &[(&ContactSet, &str)]) -> (ContactFigure, Vec<Contact>) {
    let mut figure = ContactFigure { title: title.to_owned(), ..ContactFigure::default() };
    for (set, words) in sets {
        figure.length = set.model().length();
        for curve in &set.curves {
            let step = curve.contacts().len().div_ceil(SHAPES).max(1);
            let shapes = curve.contacts().iter().step_by(step).chain(curve.contacts().last());
            figure.shapes.extend(shapes.map(|contact| set.model().shape(contact, 41)));
            figure.curves.push(((*words).to_owned(), curve.points()));
        }
    }
    let mut shared = Vec::new();
    if let [(a, _), (b, _)] = sets {
        let meetings = intersect(PlacedSet::at_home(a), PlacedSet::at_home(b), 1e-9);
        let same = meetings.iter().filter(|meeting| meeting.is_one_shape());
        shared.extend(same.map(|meeting| meeting.first));
        figure.points = shared.iter().map(|contact| contact.position).collect();
    }
    (figure, shared)
}

pub(super) fn section() -> Result<Section> {
    let mut section = Section::new("contact-sets", "Contact sets of the four virtual sensors");
    let model = model()?;
    let set = |sensor, value| ContactSet::new(&model, sensor, value, NODES);
    let (load, strip) = (set(VirtualSensor::Load, LOAD)?, set(VirtualSensor::Strip, STRIP)?);
    let slope = set(VirtualSensor::Slope, SLOPE)?;
    let moment = set(VirtualSensor::Moment(MomentRegime::SmallAngle), MOMENT)?;
    let one = |title: &str, set: &ContactSet, words: &str| contact_plate(&contacts(title, &[(set, words)]).0);
    section.show(
        "load-strip",
        [
            "Figure “fig_TwoA”: contacts (green) and shapes (red) for (a) a load, (b) a contact strip. No values are given.",
            "The same sets for 0.1 N and for 60 mm, the load limited to 0.5 N.",
            "The shapes agree. Ours are closed-form curves, and the strip's set is cut at the declared load.",
        ],
        vec![one("(a) Load sensor, 0.1 N", &load, "load 0.1 N"), one("(b) Contact strip, 60 mm", &strip, "strip 60 mm, up to 0.5 N")],
    );
    section.show(
        "slope-moment",
        [
            "Figure “fig_TwoB”: the same for (a) an end slope, (b) a moment at small angles.",
            "0.7 rad, and 1.1 mN m by the small-angle model.",
            "An end slope's contacts lie on a straight ray, as the paper's do. A moment has a second, strongly bent branch, \
             which the paper's small-angle figure leaves out.",
        ],
        vec![
            one("(a) End-slope sensor, 0.7 rad", &slope, "end slope 0.7 rad"),
            one("(b) Moment sensor, 1.1 mN m, small angles", &moment, "moment 1.1 mN m"),
        ],
    );
    numbers(&mut section, [&load, &strip, &slope, &moment]);
    Ok(section)
}

/// What follows from each model without any of our code.
fn numbers(section: &mut Section, [load, strip, slope, moment]: [&ContactSet; 4]) {
    let all = |set: &ContactSet| set.curves.iter().flat_map(|c| c.contacts().to_vec()).collect::<Vec<Contact>>();
    let worst = |set: &ContactSet, of: &dyn Fn(&Contact) -> f64| all(set).iter().map(of).fold(0.0, f64::max);
    let far = |contact: &Contact| contact.position.norm();
    let deflection = |contact: &Contact| contact.position.y.abs();
    section.find(
        "Load 0.1 N: deflection of the farthest contact",
        "load.deflection",
        "a curve to the tip",
        (1e3 * worst(load, &deflection), 2, "mm"),
        "A load beyond small angles leaves a long, bent curve.",
    );
    section.find(
        "Strip 60 mm: distance of the farthest contact from the base",
        "strip.reach",
        "the arc length bounds it",
        (1e3 * worst(strip, &far), 2, "mm"),
        "An unbent whisker reaches the arc length itself.",
    );
    // Every shape of one slope is the same shape at another scale, so that contacts lie on one ray from the base.
    let angle = |c: &Contact| c.position.y.atan2(c.position.x).to_degrees();
    let least = all(slope).iter().map(angle).fold(f64::INFINITY, f64::min);
    section.tell("slope.least", least, 4, "°");
    section.find(
        "End slope 0.7 rad: direction of the ray of contacts",
        "slope.ray",
        "drawn as a straight line",
        (worst(slope, &angle), 4, "°"),
        "All shapes of one slope are alike: every contact lies between {contact-sets.slope.least}° and this.",
    );
    section.find(
        "Moment 1.1 mN m: deflection of the farthest contact",
        "moment.deflection",
        "a curve to the tip",
        (1e3 * worst(moment, &deflection), 2, "mm"),
        "Small angles: M(0) L² / 3 E I, just below a tenth of the length.",
    );
}
