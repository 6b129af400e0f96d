//! The whole log: where the whisker is touched in space, step by step.

use super::still::{Still, arc_length, still_from, travel};
use super::{Reading, SpacePoint, tip};
use crate::beam::{BendingPlane, Whisker};
use crate::config::ContactOptions;
use crate::flow::pose::Event;
use crate::flow::sensor_log::{Channel, Quantity, SensorLog, one_owner_each};
use crate::io::calibrated;
use crate::plane::Pose2;
use crate::tasks::contact::ContactKind;
use crate::tasks::contact::free::FreeLevel;
use crate::world::{MountedWhisker, Robot};
use crate::{Error, Result, Stop};

/// Rows without contact that end a stretch: fewer are noise.
const PATIENCE: usize = 3;
/// Out of the plane x-y by more than this is told (rad): there a planar method reads 1.5 % too little.
const OUT_OF_PLANE: f64 = 10.0 / 360.0 * core::f64::consts::TAU;

/// One step of a contact in space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpaceStep {
    /// When (s).
    pub t: f64,
    /// Index of the whisker.
    pub whisker: usize,
    /// `Side` where a point stands still that explains the readings; `Tip` where none does and the contact is taken to be the tip's;
    /// `Unknown` where no tip explains them either.
    pub kind: ContactKind,
    /// The moments in the whisker's x-y plane and across it (N m), the means of the readings of this step.
    pub moments: [f64; 2],
    /// By how much each of them may be wrong (N m), as declared.
    pub errors: [f64; 2],
    /// The whisker's base, odometry frame.
    pub odom_from_whisker: Pose2,
    /// The contact.
    pub contact: Option<SpacePoint>,
    /// Arc length of the contact (m).
    pub s_a: Option<f64>,
}

impl SpaceStep {
    /// The plane in which the whisker bends, by this step's moments alone.
    #[must_use]
    pub fn plane(&self) -> BendingPlane {
        BendingPlane::of(self.moments)
    }

    /// The contact, odometry frame, z above the whisker's base (m).
    #[must_use]
    pub fn position(&self) -> Option<[f64; 3]> {
        let [x, y, z] = self.contact?.position();
        let at = self.odom_from_whisker.transform_point(crate::plane::Vec2::new(x, y));
        Some([at.x, at.y, z])
    }
}

/// What was touched in space.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SpaceReport {
    /// One entry for each step in contact, by whisker and in order of time.
    pub steps: Vec<SpaceStep>,
    /// `contact`, `lift_off`, `side_contact` (a point stands still), `out_of_plane`, `slides_around`, `no_point`, in order of time.
    pub events: Vec<Event>,
    /// When the stretch of contact began in which it was stopped (s); none where the log was gone through.
    pub stopped_at: Option<f64>,
}

/// Finds where straight round whiskers are touched in space, from logs with the moments about both transverse axes (`moment` and
/// `across`, or raw readings with a calibration of both axes).
///
/// Each step's moments give the angle about the whisker's axis. Where one point that stands still explains the readings over at least 6 mm
/// of the base's travel, the contact is there; else it is taken to be the tip's. Bands are from the declared errors of both moments: exact for
/// the angle and for tips, linear for points that stand still. The base moves in the plane, whose z is that of the whisker's base.
///
/// # Errors
///
/// Options out of range, a log without both moments, a whisker with a rest curvature, as [`calibrated()`].
pub fn contact_in_space(
    log: &SensorLog,
    robot: &Robot,
    options: &ContactOptions,
    stop: &Stop,
    observer: &mut dyn FnMut(usize, usize),
) -> Result<SpaceReport> {
    options.check()?;
    let (log, robot) = calibrated(log, robot)?;
    one_owner_each(&robot, &log.channels)?;
    robot.require_level("the search for contacts, whose angles count from the map's plane,")?;
    let mut report = SpaceReport::default();
    let mut all = Vec::new();
    for (index, whisker) in robot.whiskers.iter().enumerate() {
        straight(whisker)?;
        let channels = [log.moment_channel(&whisker.name)?, across(&log, whisker)?];
        all.extend(stretches(&log, channels, whisker, options).into_iter().map(|stretch| (index, whisker, stretch)));
    }
    let count = all.iter().map(|(.., stretch)| stretch.readings.len()).sum();
    let mut done = 0;
    observer(done, count);
    for (index, whisker, stretch) in &all {
        if stop.is_asked() {
            report.stopped_at = stretch.readings.first().map(|reading| reading.t);
            break;
        }
        report.add(*index, whisker, stretch);
        done += stretch.readings.len();
        observer(done, count);
    }
    report.events.sort_by(|a, b| a.t.total_cmp(&b.t));
    Ok(report)
}

fn straight(whisker: &MountedWhisker) -> Result<()> {
    let Some(curvature) = whisker.beam.curvature_terms().into_iter().find(|term| term.abs() > 0.0) else {
        return Ok(());
    };
    Err(Error::data(format!("the whisker \"{}\" is curved at rest", whisker.name))
        .value(curvature)
        .allowed("a curvature of 0 1/m: a straight round whisker bends in the plane of its moment")
        .remedy("leave out --space: the moment in the plane of its curvature alone"))
}

fn across(log: &SensorLog, whisker: &MountedWhisker) -> Result<usize> {
    log.channel(&whisker.name, Quantity::Across).ok_or_else(|| {
        let held: Vec<String> = log.channels.iter().take(12).map(Channel::column).collect();
        Error::data(format!("the log has no moment across the plane for the whisker \"{}\"", whisker.name))
            .value(format!("it holds {}", held.join(", ")))
            .allowed("moment and across (N m), or flux with a calibration of both axes")
            .remedy("calibrate from contacts x,y,z (docs/calibration.md), or take `across` from a sensor head")
    })
}

/// One whisker in contact.
struct Stretch {
    readings: Vec<Reading>,
    lift_off: Option<f64>,
}

fn errors_of(whisker: &MountedWhisker) -> impl Fn([f64; 2]) -> [f64; 2] + Copy {
    let (noise, zero) = (whisker.noise, whisker.errors.zero);
    move |moments| moments.map(|m| noise.moment_relative * m.abs() + (noise.moment_absolute + zero).max(1e-12))
}

fn stretches(
    log: &SensorLog,
    channels: [usize; 2],
    whisker: &MountedWhisker,
    options: &ContactOptions,
) -> Vec<Stretch> {
    let spacing = if whisker.beam.is_uniform() { options.spacing } else { options.rod_spacing };
    let (mut levels, errors) = ([FreeLevel::new(whisker); 2], errors_of(whisker));
    let mut found = Vec::new();
    let (mut open, mut quiet): (Option<Stretch>, usize) = (None, 0);
    for row in &log.rows {
        let mut touches = false;
        let moments = core::array::from_fn(|k| {
            let read = row.readings[channels[k]];
            touches |= levels[k].is_contact(row.t, read);
            levels[k].moment(read)
        });
        quiet = if touches { 0 } else { quiet + 1 };
        if quiet >= PATIENCE {
            found.extend(open.take().map(|stretch| Stretch { lift_off: Some(row.t), ..stretch }));
        }
        if touches {
            let base = row.odom_from_robot.compose(whisker.robot_from_whisker);
            let new = Reading { t: row.t, odom_from_whisker: base, moments, errors: errors(moments), count: 1 };
            let stretch = open.get_or_insert_with(|| Stretch { readings: Vec::new(), lift_off: None });
            add(&mut stretch.readings, new, &whisker.beam, spacing);
        }
    }
    found.extend(open);
    found
}

/// Adds a reading, or merges it into the last one while the base has not moved on.
fn add(readings: &mut Vec<Reading>, new: Reading, whisker: &Whisker, spacing: f64) {
    let near = |last: &&mut Reading| travel(whisker, last, &new) < spacing;
    let Some(last) = readings.last_mut().filter(near) else { return readings.push(new) };
    let share = 1.0 / (last.count + 1) as f64;
    let step = last.odom_from_whisker.between(new.odom_from_whisker);
    last.odom_from_whisker =
        last.odom_from_whisker.compose(Pose2::new(share * step.x, share * step.y, share * step.theta));
    for k in 0..2 {
        last.moments[k] += share * (new.moments[k] - last.moments[k]);
        last.errors[k] += share * (new.errors[k] - last.errors[k]);
    }
    last.t += share * (new.t - last.t);
    last.count += 1;
}

impl SpaceReport {
    fn tell(&mut self, t: f64, kind: &'static str, detail: String) {
        self.events.push(Event { t, kind, detail });
    }

    fn add(&mut self, index: usize, whisker: &MountedWhisker, stretch: &Stretch) {
        let (readings, beam, name) = (&stretch.readings, &whisker.beam, &whisker.name);
        let Some(first) = readings.first() else { return };
        self.tell(first.t, "contact", format!("{name} touches"));
        let begin = self.steps.len();
        let mut from = 0;
        while from < readings.len() {
            if let Some(still) = still_from(beam, readings, from, errors_of(whisker)) {
                self.still(index, beam, &readings[from..still.to], &still);
                from = still.to;
                continue;
            }
            // What slides is not tried again at every reading.
            let on = readings[from..].iter().position(|r| travel(beam, &readings[from], r) >= 1e-3);
            let to = on.map_or(readings.len(), |on| from + on.max(1));
            self.sliding(index, beam, &readings[from..to]);
            from = to;
        }
        self.warn(name, begin);
        if let Some(t) = stretch.lift_off {
            self.tell(t, "lift_off", format!("{name} is free"));
        }
    }

    fn still(&mut self, index: usize, beam: &Whisker, readings: &[Reading], still: &Still) {
        let [x, y, z] = still.point.map(|v| 1e3 * v);
        if let Some(first) = readings.first() {
            let detail = format!("a point at ({x:.2}, {y:.2}, {z:.2}) mm of the odometry frame stands still");
            self.tell(first.t, "side_contact", detail);
        }
        for reading in readings {
            let contact = still.seen_from(reading.odom_from_whisker);
            let s_a = arc_length(beam, contact.position());
            self.push(index, reading, ContactKind::Side, Some(contact), s_a);
        }
    }

    fn sliding(&mut self, index: usize, beam: &Whisker, readings: &[Reading]) {
        for reading in readings {
            let contact = tip(beam, reading);
            let kind = if contact.is_some() { ContactKind::Tip } else { ContactKind::Unknown };
            self.push(index, reading, kind, contact, contact.map(|_| beam.length));
        }
    }

    fn push(
        &mut self,
        whisker: usize,
        reading: &Reading,
        kind: ContactKind,
        contact: Option<SpacePoint>,
        s_a: Option<f64>,
    ) {
        let Reading { t, odom_from_whisker, moments, errors, .. } = *reading;
        self.steps.push(SpaceStep { t, whisker, kind, moments, errors, odom_from_whisker, contact, s_a });
    }

    /// Tells where a stretch's steps, from this one on, lie out of the plane or slide around.
    fn warn(&mut self, name: &str, begin: usize) {
        let degrees = |angle: f64| angle * 360.0 / core::f64::consts::TAU;
        let steps = self.steps[begin..].to_vec();
        let beyond = |step: &SpaceStep| {
            let plane = step.plane();
            plane.out_of_plane() - plane.bands(step.errors)[1] - OUT_OF_PLANE
        };
        if let Some(first) = steps.iter().find(|step| beyond(step) > 0.0) {
            let worst = steps.iter().max_by(|a, b| beyond(a).total_cmp(&beyond(b))).unwrap_or(first).plane();
            let lost = 100.0 * (1.0 - worst.out_of_plane().cos());
            let detail = format!(
                "{name} bends up to {:.0} deg out of the plane x-y: there planar methods read {lost:.0} % too little",
                degrees(worst.out_of_plane())
            );
            self.tell(first.t, "out_of_plane", detail);
        }
        // Angles as they go on from step to step; what stands still may be passed, what slides may not.
        let mut range: Option<(f64, f64, f64)> = None;
        for step in steps.iter().filter(|step| step.kind != ContactKind::Side) {
            let plane = step.plane();
            let band = plane.bands(step.errors)[1];
            if band >= core::f64::consts::FRAC_PI_2 {
                continue;
            }
            let (lo, hi, last) = range.unwrap_or((f64::NEG_INFINITY, f64::INFINITY, plane.angle));
            let angle = last + crate::plane::wrap_angle(plane.angle - last);
            let (lo, hi) = (lo.max(angle - band), hi.min(angle + band));
            if lo > hi {
                let least = degrees(lo - hi);
                let by_now = if least < 0.05 { String::new() } else { format!(", {least:.1} deg or more by now") };
                let detail = format!("the contact goes around {name} by more than the readings' errors{by_now}");
                self.tell(step.t, "slides_around", detail);
                break;
            }
            range = Some((lo, hi, angle));
        }
        if let Some(step) = steps.iter().find(|step| step.contact.is_none()) {
            self.tell(
                step.t,
                "no_point",
                format!("neither a point that stands still nor the tip of {name} explains the moments"),
            );
        }
    }
}
