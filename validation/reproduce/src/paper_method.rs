//! The paper's deterministic method as we read it \[routray, section "Localization: Deterministic Method"\].
//!
//! One reading gives the shape, the force normal to the whisker at its tip. The shapes at `t` and `t + 2` give the boundary's
//! slope. The shape is laid at boundary points 1 mm apart: a curve of states. States that were there before are moved along by
//! the known motion, and those stay that the next curve passes, in the plane, headings not compared.

use vibrissa::beam::{TipModel, TipReading};
use vibrissa::config::{Region, TipLoad};
use vibrissa::flow::contact_set::{TipContact, TipContactSet};
use vibrissa::flow::sensor_log::{LogRow, SensorLog};
use vibrissa::plane::{Bounds, Pose2, Vec2, wrap_angle};
use vibrissa::world::{BoundarySample, Map, MountedWhisker, Robot};
use vibrissa::{Error, Result};

use core::f64::consts::{FRAC_PI_2, PI};

/// The paper's spacing of the points along the boundary (m), which is how near a curve must pass a state.
const SPACING: f64 = 1e-3;
/// Rows from one shape to the next: the base moves by half a millimetre a row, and by less than 1 mm a step in the paper.
const STEP: usize = 1;
/// Shapes that give the boundary's slope: those at t and t + 2, and the one between, which is laid along the boundary.
pub(super) const SHAPES: usize = 3;
/// Travel of the base in contact before the first observation (m): while the whisker is pressed into the wall the contact
/// hardly moves, and shows no slope.
const PRESSED: f64 = 10e-3;
/// Neighbouring states of a curve are farther apart than this where it is interrupted (m).
const INTERRUPTED: f64 = 4.0 * SPACING;

/// What one row shows: the shape, where the base was, and the boundary's slope (rad, whisker frame, free space on its left).
#[derive(Clone, Copy, Debug)]
pub(super) struct Shape {
    odom_from_whisker: Pose2,
    contact: TipContact,
    slope: f64,
}

/// The states of one observation: pieces of a curve, whisker bases in the map frame.
type StateCurve = Vec<Vec<Pose2>>;

impl Shape {
    /// The contact (m) and the boundary's direction (rad), odometry frame.
    pub(super) fn on_the_way(&self) -> (Vec2, f64) {
        let base = self.odom_from_whisker;
        (base.transform_point(self.contact.position), wrap_angle(base.theta + self.slope))
    }
}

/// Of the shapes of the log's first contact every `every`-th, the slope from `count` shapes that are [`STEP`] apart.
pub(super) fn shapes(log: &SensorLog, whisker: &MountedWhisker, count: usize, every: usize) -> Result<Vec<Shape>> {
    let tip = TipModel::new(&whisker.beam)?;
    let limit = whisker.noise.largest_free_reading();
    let touching = log.rows.iter().skip_while(|row| moment(row).abs() <= limit);
    let rows: Vec<&LogRow> = touching.take_while(|row| moment(row).abs() > limit).collect();
    let base = |row: &LogRow| row.odom_from_robot.compose(whisker.robot_from_whisker);
    let start = rows.first().map_or(Pose2::IDENTITY, |row| base(row));
    let bent = |row: &LogRow| {
        let sets = TipContactSet::branches(&tip, TipReading::Moment(moment(row)), TipLoad::WhiskerNormal);
        sets.first().and_then(|set| set.contacts().first().copied())
    };
    let shape = |window: &[&LogRow]| {
        let tips: Option<Vec<Vec2>> = window
            .iter()
            .step_by(STEP)
            .map(|row| bent(row).map(|contact| base(row).transform_point(contact.position)))
            .collect();
        let tips = tips?;
        let middle = window[window.len() / 2];
        let contact = bent(middle)?;
        let along = (*tips.last()? - *tips.first()?).angle() - base(middle).theta;
        // The wall pushes towards free space, which is on the left.
        let pushed = (contact.direction - (along + FRAC_PI_2)).cos() >= 0.0;
        let slope = wrap_angle(if pushed { along } else { along + PI });
        Some(Shape { odom_from_whisker: base(middle), contact, slope })
    };
    let long = STEP * (count.max(2) - 1) + 1;
    let sliding = rows.windows(long).filter(|w| base(w[0]).position().distance(start.position()) >= PRESSED);
    Ok(sliding.step_by(every.max(1)).filter_map(shape).collect())
}

fn moment(row: &LogRow) -> f64 {
    row.readings.first().copied().unwrap_or(0.0)
}

/// The shape laid at each of these boundary points, where the base is in free space.
pub(super) fn curve(map: &Map, samples: &[BoundarySample], shape: &Shape) -> StateCurve {
    let mut pieces: StateCurve = Vec::new();
    for sample in samples {
        let theta = wrap_angle(sample.tangent - shape.slope);
        let base = sample.position - shape.contact.position.rotated(theta);
        if !map.is_free(base) {
            continue;
        }
        let state = Pose2::new(base.x, base.y, theta);
        let joins = |piece: &&mut Vec<Pose2>| {
            piece.last().is_some_and(|last| last.position().distance(state.position()) < INTERRUPTED)
        };
        match pieces.last_mut().filter(joins) {
            Some(piece) => piece.push(state),
            None => pieces.push(vec![state]),
        }
    }
    pieces
}

/// The state of the curve that is nearest to a place, and how far it is (m).
fn nearest(curve: &StateCurve, place: Vec2) -> Option<(Pose2, f64)> {
    let segments = curve.iter().flat_map(|piece| piece.windows(2));
    let foot = |pair: &[Pose2]| {
        let (a, along) = (pair[0].position(), pair[1].position() - pair[0].position());
        let share = ((place - a).dot(along) / along.dot(along).max(1e-18)).clamp(0.0, 1.0);
        let at = a + along * share;
        let theta = pair[0].theta + share * wrap_angle(pair[1].theta - pair[0].theta);
        (Pose2::new(at.x, at.y, wrap_angle(theta)), at.distance(place))
    };
    segments.map(foot).min_by(|a, b| a.1.total_cmp(&b.1))
}

/// Where two curves cross in the plane: states of the second.
pub(super) fn crossings(first: &StateCurve, second: &StateCurve) -> Vec<Pose2> {
    let pairs = |curve: &StateCurve| -> Vec<[Pose2; 2]> {
        curve.iter().flat_map(|piece| piece.windows(2).map(|pair| [pair[0], pair[1]])).collect()
    };
    let (a, b) = (pairs(first), pairs(second));
    let meet = |s: &[Pose2; 2], t: &[Pose2; 2]| {
        let (p, r) = (s[0].position(), s[1].position() - s[0].position());
        let (q, d) = (t[0].position(), t[1].position() - t[0].position());
        let turn = r.cross(d);
        let (u, v) = ((q - p).cross(d) / turn, (q - p).cross(r) / turn);
        let theta = t[0].theta + v * wrap_angle(t[1].theta - t[0].theta);
        let at = q + d * v;
        ((0.0..1.0).contains(&u) && (0.0..1.0).contains(&v)).then(|| Pose2::new(at.x, at.y, wrap_angle(theta)))
    };
    a.iter().flat_map(|s| b.iter().filter_map(move |t| meet(s, t))).collect()
}

/// The states moved along by the motion between two observations.
pub(super) fn projected(curve: &StateCurve, from: &Shape, to: &Shape) -> StateCurve {
    let step = from.odom_from_whisker.between(to.odom_from_whisker);
    curve.iter().map(|piece| piece.iter().map(|state| state.compose(step)).collect()).collect()
}

/// Those of some states that the next observation's curve passes within the boundary's spacing, moved onto it.
pub(super) fn passed(states: &[Pose2], curve: &StateCurve) -> Vec<Pose2> {
    let on = |state: &Pose2| nearest(curve, state.position()).filter(|(_, far)| *far <= SPACING).map(|(on, _)| on);
    states.iter().filter_map(on).collect()
}

/// Points along all boundaries, 1 mm apart.
pub(super) fn samples(map: &Map) -> Vec<BoundarySample> {
    map.samples(SPACING)
}

/// What the intersection comes to.
pub(super) struct Intersection {
    /// The robot's states at the last row; none where the intersection is empty.
    pub(super) left: Vec<Pose2>,
    /// Share of the observations until it was empty; 1 where it never was.
    pub(super) lasted: f64,
}

/// The robot's states that are left at the last observation, of those that were in the region at the first row.
pub(super) fn localize(
    log: &SensorLog,
    map: &Map,
    robot: &Robot,
    region: Region,
    every: usize,
) -> Result<Intersection> {
    let whisker = robot.whiskers.first().ok_or_else(|| Error::data("the robot has no whisker"))?;
    let shapes = shapes(log, whisker, SHAPES, every)?;
    let robot_from_whisker = whisker.robot_from_whisker;
    let start = log.rows.first().map_or(Pose2::IDENTITY, |row| row.odom_from_robot.compose(robot_from_whisker));
    let mut states: Option<Vec<Pose2>> = None;
    let mut before = start;
    for (index, shape) in shapes.iter().enumerate() {
        let step = before.between(shape.odom_from_whisker);
        before = shape.odom_from_whisker;
        let curve = match &states {
            None => curve(map, &samples(map), shape),
            Some(left) => curve(map, &map.samples_in(around(left, whisker.beam.length), SPACING), shape),
        };
        let left: Vec<Pose2> = match states {
            None => {
                let from_region = |state: &Pose2| {
                    let first = state.compose(step.inverse()).compose(robot_from_whisker.inverse());
                    let within = |value: f64, [lo, hi]: [f64; 2]| (lo..=hi).contains(&value);
                    let middle = 0.5 * (region[2][0] + region[2][1]);
                    let turn = wrap_angle(first.theta - middle).abs();
                    within(first.x, region[0]) && within(first.y, region[1]) && turn <= region[2][1] - middle
                };
                curve.into_iter().flatten().filter(from_region).collect()
            }
            Some(left) => passed(&left.iter().map(|state| state.compose(step)).collect::<Vec<_>>(), &curve),
        };
        if left.is_empty() {
            return Ok(Intersection { left, lasted: index as f64 / shapes.len() as f64 });
        }
        states = Some(left);
    }
    let end = log.rows.last().map_or(before, |row| row.odom_from_robot.compose(robot_from_whisker));
    let rest = before.between(end).compose(robot_from_whisker.inverse());
    let left = states.unwrap_or_default().iter().map(|state| state.compose(rest)).collect();
    Ok(Intersection { left, lasted: 1.0 })
}

/// The boundaries that whiskers at these places can reach.
fn around(states: &[Pose2], length: f64) -> Bounds {
    let reach = Vec2::new(1.2 * length, 1.2 * length);
    let start = (Vec2::new(f64::INFINITY, f64::INFINITY), Vec2::new(f64::NEG_INFINITY, f64::NEG_INFINITY));
    let (min, max) = states.iter().fold(start, |(lo, hi), state| {
        (Vec2::new(lo.x.min(state.x), lo.y.min(state.y)), Vec2::new(hi.x.max(state.x), hi.y.max(state.y)))
    });
    Bounds { min: min - reach, max: max + reach }
}
