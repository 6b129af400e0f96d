//! Whether a projected state lies in an observation's preimage, within a tolerance.
//!
//! The preimage is not listed for this: with the heading given, the boundary's normal names the whisker's shape, the
//! shape puts the tip somewhere, and the state is in the preimage exactly if the tip lies on the boundary and the
//! boundary's slope there is the slope that the history shows.

use super::Candidate;
use crate::config::{DeterministicOptions, TipLoad};
use crate::flow::contact_set::TipContact;
use crate::flow::preimage::{Alignment, Branch, Observation};
use crate::math;
use crate::plane::{Pose2, Vec2, wrap_angle};
use crate::world::{Foot, Map};
use core::f64::consts::{FRAC_PI_2, PI};

/// Most rounds in which boundary point and force direction are brought into agreement, and when they agree (rad).
const ROUNDS: usize = 8;
const AGREED: f64 = 1e-3;
/// Furthest that a tip may lie beyond the end of a boundary's smooth piece (m): at corners the foot of the
/// perpendicular does not exist.
const ALONG: f64 = 3e-3;
/// How near to a concave corner the last contact must lie for the tip to be caught in it (m).
const CORNER: f64 = 8e-3;
/// How far outside free space the robot's origin may come to lie (m): candidates are off by as much.
const ON_BORDER: f64 = 3e-3;
/// Margin on a known distance within which the nearest boundary point is sought (m).
const NEARBY: f64 = 1e-5;
/// Share of the declared bound that is taken to be the same for all readings (gain, calibration), not averaged out.
const SYSTEMATIC: f64 = 0.25;
/// Least standard deviation of a contact's place (m) and of a slope (rad): interpolation and flattening.
const LEAST_PLACE: f64 = 0.2e-3;
const LEAST_SLOPE: f64 = 0.02;
/// What the paper's load, normal to the whisker instead of the boundary, adds to both tolerances (m, rad).
const WRONG_LOAD: (f64, f64) = (2e-3, 0.05);
/// A slope less certain than this says nothing about the heading (rad).
const WORST_SLOPE: f64 = 0.35;

/// A sweep is at least so many histories long: over that length an error of all readings may turn it.
const HISTORIES: f64 = 5.0;

/// How far a state may lie from the preimage.
pub(super) struct Tolerance {
    std_devs: f64,
    relative_std: f64,
    systematic: f64,
    position_floor: f64,
    heading_floor: f64,
    /// Over which length an error that all readings share may turn a candidate (m).
    pub(super) arm: f64,
    /// Histories overlap: successive observations share readings, so each counts for less.
    pub(super) dependence: f64,
}

impl Tolerance {
    pub(super) fn new(observation: &Observation, options: &DeterministicOptions) -> Self {
        let (place, heading) = match options.tip_load {
            TipLoad::BoundaryNormal => (0.0, 0.0),
            TipLoad::WhiskerNormal => WRONG_LOAD,
        };
        Self {
            std_devs: options.tolerance,
            relative_std: observation.relative_std,
            systematic: SYSTEMATIC * observation.relative_bound,
            position_floor: options.position_floor + place,
            heading_floor: options.heading_floor + heading,
            arm: HISTORIES * options.history_travel,
            dependence: (options.history_travel / options.update_travel).max(1.0).sqrt(),
        }
    }
}

/// The state of the preimage that is nearest to a candidate.
pub(super) struct Match {
    /// Squared distance in units of the tolerance.
    pub(super) cost: f64,
    /// Direction of the boundary's normal (rad), map frame.
    pub(super) normal: f64,
    /// The tip contact, whisker frame, and the touched point of the boundary, map frame (m).
    pub(super) contact: TipContact,
    pub(super) touched: Vec2,
    /// How far the tip must move along that normal (m), and how that depends on the candidate's (x, y, theta).
    pub(super) offset: f64,
    pub(super) gradient: [f64; 3],
    /// How far an error that all readings share may have moved the tip (m).
    pub(super) shared: f64,
    /// Standard deviation of the tip's place along the normal (m).
    pub(super) std: f64,
    /// How far the candidate must turn (rad), with its standard deviation, where the history bounds the heading.
    pub(super) turn: Option<(f64, f64)>,
}

/// The state of the preimage nearest to the candidate, on the best branch.
///
/// None within the tolerance, or the whisker's base or the robot's origin would stand in a wall.
pub(super) fn nearest_state(
    map: &Map,
    candidate: &Candidate,
    observation: &Observation,
    tolerance: &Tolerance,
) -> Option<Match> {
    let map_from_whisker = candidate.map_from_odom.compose(observation.odom_from_whisker);
    if !map.is_free(map_from_whisker.position()) || !stands(map, map_from_whisker, observation) {
        return None;
    }
    let base = BasePose::new(map_from_whisker);
    let touches_on = candidate.felt_with == Some(observation.robot_from_whisker);
    let on_branch = |branch| {
        let match_from = |start| on_branch(map, candidate, &base, branch, start, tolerance);
        let last = NewtonStart { normal: candidate.normal, near: candidate.touched };
        if touches_on {
            return match_from(last);
        }
        let starts = starts(map, map_from_whisker, branch);
        starts.into_iter().chain([last]).filter_map(match_from).min_by(|a, b| a.cost.total_cmp(&b.cost))
    };
    observation.branches.iter().filter_map(on_branch).min_by(|a, b| a.cost.total_cmp(&b.cost))
}

/// Whether the robot's origin, too, is in free space or on its border.
fn stands(map: &Map, map_from_whisker: Pose2, observation: &Observation) -> bool {
    if observation.robot_from_whisker.position().norm_squared() == 0.0 {
        return true;
    }
    let origin = map_from_whisker.compose(observation.robot_from_whisker.inverse()).position();
    map.is_free(origin) || map.nearest_within(origin, ON_BORDER).is_some()
}

/// A place on the boundary to look for the contact from.
#[derive(Clone, Copy)]
struct NewtonStart {
    /// Direction of the boundary's normal (rad), map frame.
    normal: f64,
    /// A point of the boundary (m), map frame.
    near: Vec2,
}

/// A whisker's base in the map, with the sine and cosine of its heading.
struct BasePose {
    pose: Pose2,
    sin: f64,
    cos: f64,
}

impl BasePose {
    fn new(pose: Pose2) -> Self {
        let (sin, cos) = math::sin_cos(pose.theta);
        Self { pose, sin, cos }
    }

    /// A point of the whisker in the map (m).
    fn place(&self, p: Vec2) -> Vec2 {
        self.pose.position() + Vec2::new(self.cos * p.x - self.sin * p.y, self.sin * p.x + self.cos * p.y)
    }
}

/// Where to look for the contact, too, when another whisker touched last, or this one was free or jumped in between:
/// wherever the history's alignments put it.
fn starts(map: &Map, pose: Pose2, branch: &Branch) -> Vec<NewtonStart> {
    let middle = || {
        let range = branch.contacts.directions();
        branch.contacts.at_direction(0.5 * (range.lo() + range.hi()))
    };
    let aligned: Vec<TipContact> = branch.alignments.iter().map(|a| a.contact).collect();
    let contacts = if aligned.is_empty() { middle().into_iter().collect() } else { aligned };
    let start = |contact: TipContact| {
        let near = map.nearest(pose.transform_point(contact.position))?.position;
        Some(NewtonStart { normal: pose.theta + contact.direction, near })
    };
    contacts.into_iter().filter_map(start).collect()
}

/// Where the tip lies and which boundary point it is held against, map frame.
struct TipTouch {
    tip: Vec2,
    boundary: Vec2,
    normal: f64,
    contact: TipContact,
}

/// The tip for the boundary's own normal: found by alternating between the two, from the start on.
fn touch(map: &Map, base: &BasePose, branch: &Branch, start: NewtonStart) -> Option<TipTouch> {
    let NewtonStart { mut normal, mut near } = start;
    let mut found = None;
    for _ in 0..ROUNDS {
        let direction = normal - base.pose.theta;
        let contact = branch.contacts.at_direction(direction)?;
        let tip = base.place(contact.position);
        // No nearest point is further away than a known one; the margin covers the flattening of curves.
        let point = map.foot(tip, (tip - near).norm_squared().sqrt() + NEARBY)?;
        near = point.position;
        let outward = outward(&point, base.pose.position());
        let agreed = wrap_angle(outward - normal).abs() < AGREED;
        normal = outward;
        found = Some(TipTouch { tip, boundary: point.position, normal, contact });
        if agreed {
            break;
        }
    }
    found
}

/// The boundary's normal towards free space; towards the whisker's base for walls, which are free on both sides.
fn outward(point: &Foot, base: Vec2) -> f64 {
    let left = point.tangent + FRAC_PI_2;
    let behind = || (base - point.position).dot(Vec2::from_angle(left)) < 0.0;
    if point.two_sided && behind() { left + PI } else { left }
}

fn on_branch(
    map: &Map,
    candidate: &Candidate,
    base: &BasePose,
    branch: &Branch,
    start: NewtonStart,
    tolerance: &Tolerance,
) -> Option<Match> {
    on_wall(map, candidate, base, branch, start, tolerance)
        .or_else(|| in_corner(map, candidate, base.pose, branch, start.near, tolerance))
}

/// The match with the tip on a smooth piece of the boundary.
fn on_wall(
    map: &Map,
    candidate: &Candidate,
    base: &BasePose,
    branch: &Branch,
    start: NewtonStart,
    tolerance: &Tolerance,
) -> Option<Match> {
    let touch = touch(map, base, branch, start)?;
    let across = Vec2::from_angle(touch.normal);
    if (touch.boundary - touch.tip).dot(across.perp()).abs() > ALONG {
        return None;
    }
    let found = tolerance.place(candidate, branch, &touch, across)?;
    let turn = turn(candidate, base.pose, branch, touch.normal, tolerance)?;
    Some(Match { cost: found.cost + turn.share * turn.share, turn: turn.wanted, ..found })
}

/// The match with the tip caught in a concave corner, where the force may have any direction between the two normals.
///
/// The history's slope is nobody's slope there and is not asked.
fn in_corner(
    map: &Map,
    candidate: &Candidate,
    pose: Pose2,
    branch: &Branch,
    near: Vec2,
    tolerance: &Tolerance,
) -> Option<Match> {
    let corner = map.concave_corner(near, CORNER)?;
    let seen = pose.inverse_transform_point(corner.position);
    let contact = branch.contacts.nearest(seen, corner.normal_before - pose.theta, corner.turn)?;
    let tip = pose.transform_point(contact.position);
    let gap = corner.position - tip;
    let normal = contact.direction + pose.theta;
    // Across the curve of possible tips; along it the direction of the force adapts.
    let across = if gap.norm() > 1e-9 { gap * (1.0 / gap.norm()) } else { Vec2::from_angle(normal) };
    tolerance.place(candidate, branch, &TipTouch { tip, boundary: corner.position, normal, contact }, across)
}

impl Tolerance {
    /// The match of a tip with the boundary along the direction `across`, if the gap is within the tolerance.
    fn place(&self, candidate: &Candidate, branch: &Branch, touch: &TipTouch, across: Vec2) -> Option<Match> {
        let offset = (touch.boundary - touch.tip).dot(across);
        let sensitivity = branch.sensitivity(&touch.contact);
        let own = sensitivity * self.relative_std;
        let std = (own * own + LEAST_PLACE * LEAST_PLACE).sqrt();
        let arm = (touch.tip - candidate.map_from_odom.position()).perp();
        let gradient = [across.x, across.y, across.dot(arm)];
        let shared = self.systematic * sensitivity + self.position_floor;
        let reach = self.std_devs * (std * std + candidate.variance(gradient)).sqrt() + shared;
        let share = offset.abs() / reach;
        (share <= 1.0).then_some(Match {
            cost: share * share,
            normal: touch.normal,
            contact: touch.contact,
            touched: touch.boundary,
            offset,
            gradient,
            shared,
            std,
            turn: None,
        })
    }
}

/// How a candidate's heading agrees with an observation.
struct HeadingShift {
    /// Distance from the nearest alignment, in units of the tolerance.
    share: f64,
    /// How far to turn (rad), with the standard deviation, where the history bounds the heading.
    wanted: Option<(f64, f64)>,
}

/// The turn to the nearest alignment; none if it is beyond the tolerance.
fn turn(
    candidate: &Candidate,
    pose: Pose2,
    branch: &Branch,
    normal: f64,
    tolerance: &Tolerance,
) -> Option<HeadingShift> {
    if !branch.determined {
        return Some(HeadingShift { share: 0.0, wanted: None });
    }
    let own = candidate.variance([0.0, 0.0, 1.0]);
    let reach = |std: f64| tolerance.std_devs * (std * std + own).sqrt() + tolerance.heading_floor;
    let heading = normal - FRAC_PI_2 - pose.theta;
    let to = |a: &Alignment| {
        let turn = wrap_angle(heading - a.boundary_slope);
        let telling = a.std <= WORST_SLOPE;
        HeadingShift {
            share: turn.abs() / reach(a.std),
            wanted: telling.then(|| (turn, math::hypot(a.std, LEAST_SLOPE))),
        }
    };
    let nearest = branch.alignments.iter().map(to).min_by(|a, b| a.share.total_cmp(&b.share))?;
    (nearest.share <= 1.0).then_some(nearest)
}
