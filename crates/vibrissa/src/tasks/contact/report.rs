//! The whole log: a contact for each step, and what happened.

use super::baseline::Baseline;
use super::fixed_point::FixedPoint;
use super::reading::ContactReading;
use super::refined::refined;
use super::region::contact_region;
use super::segment::{ReadingRange, side_from, still_from};
use super::stretch::{ContactStretch, stretches};
use super::trace::{Trace, TraceNode, TraceOptions, TracePoint, traces_until};
use crate::beam::{Bend, Load, moment_mode};
use crate::config::ContactOptions;
use crate::flow::pose::Event;
use crate::flow::sensor_log::SensorLog;
use crate::io::calibrated;
use crate::plane::{Pose2, Vec2};
use crate::sets::Interval;
use crate::world::Robot;
use crate::{Result, Stop};

/// Most readings whose bounds are intersected.
const MOST_BOUNDED: usize = 40;
/// Side of the boxes of a region (m).
const RESOLUTION: f64 = 2e-4;
/// Share of the whisker from which on a sliding contact is told as one of the tip: nearer, readings do not tell.
const AT_TIP: f64 = 0.99;
/// Share of the whisker from which on a corner that the side has slid along is taken to have come to the tip.
const ENDS: f64 = 0.96;
/// How far a trace may be from a point that stood still, beside its uncertainty, to be the same contact (m).
const AGREES: f64 = 1e-3;
/// How far other explanations are before they are told of (m).
const DOUBTFUL: f64 = 0.5e-3;

/// How the whisker touches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ContactKind {
    /// With its side: at a point that stands still, or, where the step has a normal, along a wall on which it slides.
    Side,
    /// With its tip, which slides.
    Tip,
    /// In contact, but no point is found.
    Unknown,
}

impl ContactKind {
    /// The word for it in files.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Side => "side",
            Self::Tip => "tip",
            Self::Unknown => "none",
        }
    }
}

/// One step of a contact.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactStep {
    /// When (s).
    pub t: f64,
    /// Index of the whisker.
    pub whisker: usize,
    /// How it touches.
    pub kind: ContactKind,
    /// The moment (N m), the mean of the readings of this step.
    pub moment: f64,
    /// The whisker's base, odometry frame.
    pub odom_from_whisker: Pose2,
    /// The contact, whisker frame (m).
    pub contact: Option<Vec2>,
    /// Arc length of the contact (m).
    pub s_a: Option<f64>,
    /// Standard deviation of the contact (m): of its distance from the base where it stands still, across the wall where it slides.
    pub std: Option<f64>,
    /// Direction of the surface's normal, on the whisker's side of it, odometry frame (rad), for what slides.
    pub normal: Option<f64>,
    /// Bounds of the distance from the base, if the declared error bounds hold and the contact stands still (m).
    pub bounds: Option<Interval>,
    /// The bent whisker, for what slides.
    pub bend: Option<Bend>,
    /// The closed forms of earlier work.
    pub baseline: Baseline,
    /// Number of the uninterrupted piece that this step belongs to.
    pub piece: usize,
}

impl ContactStep {
    /// The contact, odometry frame (m).
    #[must_use]
    pub fn position(&self) -> Option<Vec2> {
        self.contact.map(|contact| self.odom_from_whisker.transform_point(contact))
    }
}

/// What was touched.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ContactReport {
    /// One entry for each step in contact, by whisker and stretch in order of time.
    pub steps: Vec<ContactStep>,
    /// `contact`, `lift_off`, `tip_contact`, `side_contact`, `slip_whisker`, `slip_obstacle`, `jump`, `ambiguous`, `no_point`, in order
    /// of time.
    pub events: Vec<Event>,
    /// When the contact began in the search for which it was stopped (s): this contact and those after it are missing. None where the
    /// log was gone through.
    pub stopped_at: Option<f64>,
}

/// Finds the contact of every step of a log.
///
/// A contact that stands still is found from all the readings during which it does; where none does, tip or side are taken to
/// slide along a smooth wall.
///
/// # Errors
///
/// Options out of range, and a whisker of the robot without a moment column.
pub fn contacts(log: &SensorLog, robot: &Robot, options: &ContactOptions) -> Result<ContactReport> {
    contacts_until(log, robot, options, &Stop::default(), &mut |_, _| {})
}

/// As [`contacts`], until `stop` is asked for; `observer` is told how many of all readings in contact are gone through.
///
/// What a stopped search leaves are the contacts before; [`ContactReport::stopped_at`] says from when on they are missing.
///
/// # Errors
///
/// As [`contacts`].
pub fn contacts_until(
    log: &SensorLog,
    robot: &Robot,
    options: &ContactOptions,
    stop: &Stop,
    observer: &mut dyn FnMut(usize, usize),
) -> Result<ContactReport> {
    options.check()?;
    let (log, robot) = calibrated(log, robot)?;
    let mut report = ContactReport::default();
    let all = stretches(&log, &robot, [options.spacing, options.rod_spacing])?;
    let count: usize = all.iter().map(|stretch| stretch.readings.len()).sum();
    let mut done = 0;
    observer(done, count);
    for stretch in &all {
        let name = &robot.whiskers[stretch.whisker].name;
        report.stopped_at =
            report.add(stretch, name, ContactSearch { options, stop }, &mut |gone| observer(done + gone, count));
        if report.stopped_at.is_some() {
            break;
        }
        done += stretch.readings.len();
    }
    report.events.sort_by(|a, b| a.t.total_cmp(&b.t));
    Ok(report)
}

/// How contacts are looked for, and who may end it.
#[derive(Clone, Copy)]
struct ContactSearch<'a> {
    options: &'a ContactOptions,
    stop: &'a Stop,
}

impl ContactReport {
    fn tell(&mut self, t: f64, kind: &'static str, detail: String) {
        self.events.push(Event { t, kind, detail });
    }

    /// Adds the contacts of a stretch; when the contact begins in the search for which it was stopped (s).
    fn add(
        &mut self,
        stretch: &ContactStretch,
        name: &str,
        search: ContactSearch<'_>,
        observer: &mut dyn FnMut(usize),
    ) -> Option<f64> {
        let [first, ..] = stretch.readings.as_slice() else { return None };
        self.tell(first.t, "contact", format!("{name} touches"));
        let (mut from, mut before) = (0, None);
        if !is_of_whisker(&stretch.readings, search.stop) {
            from = stretch.readings.len();
            self.sliding(stretch, ReadingRange { from: 0, to: from, still: None }, &[]);
        }
        while from < stretch.readings.len() {
            let rest = ReadingRange { from, to: stretch.readings.len(), still: None };
            let still = still_from(&stretch.readings, from, stretch.onset, search.stop);
            let whole = still.is_some_and(|part| part.from == 0 && part.to == rest.to);
            let traces = if whole { Vec::new() } else { traces(stretch, rest, search) };
            // What was found while the end was asked for is none of it.
            let stopped_at = Some(stretch.readings[from].t);
            if search.stop.is_asked() {
                return stopped_at;
            }
            match still
                .filter(|part| whole || stands(stretch, part, &traces))
                .and_then(|part| Some((part, part.still?)))
            {
                Some((part, point)) => {
                    let point = refined(stretch, part, point, search.options, search.stop);
                    if search.stop.is_asked() {
                        return stopped_at;
                    }
                    self.side(stretch, part, &point, before);
                    before = Some(point.position);
                    from = part.to;
                }
                None => {
                    let Some(end) = self.slides(stretch, rest, &traces, search) else { return stopped_at };
                    from = end;
                    before = None;
                }
            }
            observer(from);
        }
        if let Some(t) = stretch.lift_off {
            self.tell(t, "lift_off", format!("{name} is free"));
        }
        None
    }

    fn next_piece(&self) -> usize {
        self.steps.iter().map(|step| step.piece + 1).max().unwrap_or(0)
    }

    /// A contact that stands still.
    fn side(&mut self, stretch: &ContactStretch, part: ReadingRange, point: &FixedPoint, before: Option<Vec2>) {
        let readings = &stretch.readings[part.from..part.to];
        let moved = before.map_or(0.0, |before| before.distance(point.position));
        if before.is_some() {
            let detail = format!("the contact moved by {:.2} mm along the obstacle", 1e3 * moved);
            self.tell(readings[0].t, "slip_obstacle", detail);
        }
        let slid = point.s_a[1] - point.s_a[0];
        if slid.abs() > 1e-3 {
            let [from, to] = point.s_a.map(|s| 1e3 * s);
            let detail = format!("the contact slid along the whisker from {from:.1} to {to:.1} mm");
            self.tell(readings[readings.len() - 1].t, "slip_whisker", detail);
        }
        let stride = readings.len().div_ceil(MOST_BOUNDED);
        let thinned: Vec<ContactReading> = readings.iter().step_by(stride).copied().collect();
        let region = contact_region(&thinned, RESOLUTION);
        let piece = self.next_piece();
        for reading in readings {
            let base = reading.odom_from_whisker;
            let contact = base.inverse_transform_point(point.position);
            let outward = (point.position - base.position()) * (1.0 / contact.norm().max(1e-12));
            let bounds = region.as_ref().map(|r| r.distances(base)).filter(|b| !b.is_empty());
            self.steps.push(ContactStep {
                contact: Some(contact),
                s_a: reading.touched(point.position).map(|touched| touched.s_a),
                std: Some(point.std_along(outward)),
                bounds,
                piece,
                ..step(stretch, reading, ContactKind::Side)
            });
        }
    }

    /// A sliding contact up to the end of a part, or to where a trace breaks off and the side meets a point that stands still:
    /// where it ends; none where the search was stopped.
    fn slides(
        &mut self,
        stretch: &ContactStretch,
        part: ReadingRange,
        traces: &[Trace],
        search: ContactSearch<'_>,
    ) -> Option<usize> {
        let next = side_after(stretch, part, traces, search.stop);
        if search.stop.is_asked() {
            return None;
        }
        let Some((side, point)) = next else {
            self.sliding(stretch, part, traces);
            return Some(part.to);
        };
        let before = ReadingRange { to: side.from, ..part };
        let again = self::traces(stretch, before, search);
        let point = refined(stretch, side, point, search.options, search.stop);
        if search.stop.is_asked() {
            return None;
        }
        self.sliding(stretch, before, &again);
        let t = stretch.readings[side.from].t;
        self.tell(t, "jump", "the slide ends; the side touches a point that stands still".to_owned());
        self.side(stretch, side, &point, None);
        Some(side.to)
    }

    /// What is known of a sliding contact, or nothing that is understood.
    fn sliding(&mut self, stretch: &ContactStretch, part: ReadingRange, traces: &[Trace]) {
        let readings = &stretch.readings[part.from..part.to];
        if readings.is_empty() {
            return;
        }
        let mut rest = readings.iter().peekable();
        for (index, trace) in traces.iter().enumerate() {
            let piece = self.next_piece();
            let (t, on_side) = trace.points.first().map_or((readings[0].t, false), |p| (p.t, on_side(stretch, p)));
            match (index, on_side) {
                (0, false) => self.tell(t, "tip_contact", "the tip slides".to_owned()),
                (0, true) => self.tell(t, "side_contact", "the side slides".to_owned()),
                _ => self.tell(t, "jump", "the contact jumps; a new trace begins".to_owned()),
            }
            if trace.doubt > DOUBTFUL {
                let detail =
                    format!("other ways of the contact explain the readings as well, {:.1} mm off", 1e3 * trace.doubt);
                self.tell(t, "ambiguous", detail);
            }
            let mut before = on_side;
            for point in &trace.points {
                self.tell_change(stretch, point, &mut before);
                while let Some(reading) = rest.next_if(|r| r.t < point.t) {
                    self.steps.push(ContactStep { piece, ..step(stretch, reading, ContactKind::Unknown) });
                }
                if let Some(reading) = rest.next() {
                    self.steps.push(sliding_step(stretch, reading, point, piece));
                }
            }
        }
        let piece = self.next_piece();
        if let Some(reading) = rest.peek() {
            self.tell(reading.t, "no_point", "in contact, but neither a point nor a slide explains it".to_owned());
        }
        let unknown = rest.map(|reading| ContactStep { piece, ..step(stretch, reading, ContactKind::Unknown) });
        self.steps.extend(unknown);
    }

    /// Tells where a slide goes from side to tip or back.
    fn tell_change(&mut self, stretch: &ContactStretch, point: &TracePoint, before: &mut bool) {
        let on_side = on_side(stretch, point);
        match (*before, on_side) {
            (true, false) => self.tell(point.t, "tip_contact", "the contact comes to the tip".to_owned()),
            (false, true) => self.tell(point.t, "side_contact", "the contact goes over to the side".to_owned()),
            _ => {}
        }
        *before = on_side;
    }
}

/// Shares of a whisker at which a contact is tried, from where moments are large to the tip.
const TRIED: [f64; 4] = [0.1, 0.3, 0.6, 1.0];
/// Fewest readings that have a shape before contacts are looked for.
const FEWEST: usize = 4;

/// Whether the whisker has shapes for some of the readings: those of another whisker may have none, and of one that is integrated every
/// look for them takes milliseconds.
fn is_of_whisker(readings: &[ContactReading], stop: &Stop) -> bool {
    let has_shape = |reading: &&ContactReading| {
        let ContactReading { whisker, moment, .. } = reading;
        let bends = |share: f64| moment_mode(whisker, *moment, share * whisker.length, Load::Normal);
        whisker.is_uniform()
            || stop.is_asked()
            || TRIED.into_iter().any(|share| bends(share).is_ok_and(|b| !b.is_empty()))
    };
    readings.len() < FEWEST || readings.iter().filter(has_shape).take(FEWEST).count() == FEWEST
}

/// Whether a sliding contact is with the side.
fn on_side(stretch: &ContactStretch, point: &TracePoint) -> bool {
    stretch.readings.first().is_some_and(|reading| point.bend.s_a < reading.whisker.length * AT_TIP)
}

/// Whether the contact with the side of a part stood still although traces may explain its readings as well: only what ends at
/// the tip, or with the log's stretch, or where every trace breaks off as well; or what the trace agrees with. A corner does not
/// leave the middle of a whisker otherwise.
fn stands(stretch: &ContactStretch, part: &ReadingRange, traces: &[Trace]) -> bool {
    let (Some(point), [first, .., last]) = (part.still, &stretch.readings[part.from..part.to]) else { return false };
    let length = last.whisker.length;
    let away = point.position - last.odom_from_whisker.position();
    let std = point.std_along(away * (1.0 / away.norm().max(1e-12)));
    let through = |trace: &&Trace| {
        let within = trace.points.iter().filter(|p| p.t >= first.t && p.t <= last.t).count();
        2 * within > part.to - part.from && trace.points.last().is_some_and(|p| p.t > last.t)
    };
    let Some(trace) = traces.iter().find(through) else { return true };
    let off =
        trace.points.iter().filter(|p| p.t >= first.t && p.t <= last.t).map(|p| p.position.distance(point.position));
    let agrees = off.fold(0.0, f64::max) <= AGREES + 3.0 * std;
    agrees || point.s_a[1] + 2.0 * std >= ENDS * length
}

/// The traces over a part.
fn traces(stretch: &ContactStretch, part: ReadingRange, search: ContactSearch<'_>) -> Vec<Trace> {
    let readings = &stretch.readings[part.from..part.to];
    let Some(first) = readings.first() else { return Vec::new() };
    let node = |r: &ContactReading| TraceNode {
        t: r.t,
        odom_from_whisker: r.odom_from_whisker,
        moment: r.moment,
        std: r.std(r.moment),
    };
    let nodes: Vec<TraceNode> = readings.iter().map(node).collect();
    let &ContactOptions { step_std, turn, curled, .. } = search.options;
    traces_until(&first.whisker, &nodes, TraceOptions { step_std, turn, curled }, search.stop)
}

/// The first contact with the side that begins where one of the traces ends.
fn side_after(
    stretch: &ContactStretch,
    part: ReadingRange,
    traces: &[Trace],
    stop: &Stop,
) -> Option<(ReadingRange, FixedPoint)> {
    let readings = &stretch.readings[..part.to];
    let end = |trace: &Trace| trace.points.last().map(|last| readings.partition_point(|r| r.t <= last.t));
    let breaks = traces.iter().filter_map(end).filter(|end| *end > part.from && *end < part.to);
    let mut sides =
        breaks.filter_map(|end| side_from(readings, end, stop)).filter(|side| stands(stretch, side, traces));
    sides.find_map(|side| side.still.map(|point| (side, point)))
}

fn sliding_step(stretch: &ContactStretch, reading: &ContactReading, point: &TracePoint, piece: usize) -> ContactStep {
    let kind = if on_side(stretch, point) { ContactKind::Side } else { ContactKind::Tip };
    ContactStep {
        contact: Some(point.bend.contact),
        s_a: Some(point.bend.s_a),
        std: Some(point.std),
        normal: Some(point.normal),
        bend: Some(point.bend.clone()),
        piece,
        ..step(stretch, reading, kind)
    }
}

/// What is known before any contact is found.
fn step(stretch: &ContactStretch, reading: &ContactReading, kind: ContactKind) -> ContactStep {
    ContactStep {
        t: reading.t,
        whisker: stretch.whisker,
        kind,
        moment: reading.moment,
        odom_from_whisker: reading.odom_from_whisker,
        contact: None,
        s_a: None,
        std: None,
        normal: None,
        bounds: None,
        bend: None,
        baseline: stretch.onset.map(|onset| Baseline::since(onset, reading)).unwrap_or_default(),
        piece: 0,
    }
}
