//! Whether a projected state lies in an observation's preimage, within a tolerance.
//!
//! The preimage is not listed for this: with the heading given, the boundary's normal names the whisker's shape, the
//! shape puts the tip somewhere, and the state is in the preimage exactly if the tip lies on the boundary and the
//! boundary's slope there is the slope that the history shows.

use super::Candidate;
use crate::config::DeterministicOptions;
use crate::flow::contact_set::TipContact;
use crate::flow::preimage::{Branch, Observation};
use crate::plane::{Pose2, Vec2, wrap_angle};
use crate::world::{Map, MapPoint};
use core::f64::consts::{FRAC_PI_2, PI};

/// Rounds in which boundary point and force direction are brought into agreement.
const ROUNDS: usize = 3;
/// Furthest that a tip may lie beyond the end of a boundary's smooth piece (m): at corners the foot of the
/// perpendicular does not exist.
const ALONG: f64 = 3e-3;
/// Share of the declared bound that is taken to be the same for all readings (gain, calibration), not averaged out.
const SYSTEMATIC: f64 = 0.25;
/// Least standard deviation of a contact's place (m) and of a slope (rad): interpolation and flattening.
const LEAST_PLACE: f64 = 0.2e-3;
const LEAST_SLOPE: f64 = 0.02;
/// A slope less certain than this says nothing about the heading (rad).
const WORST_SLOPE: f64 = 0.35;

/// How far a state may lie from the preimage.
pub(super) struct Tolerance {
    std_devs: f64,
    relative_std: f64,
    systematic: f64,
    position_floor: f64,
    heading_floor: f64,
    /// Histories overlap: successive observations share readings, so each counts for less.
    pub(super) dependence: f64,
}

impl Tolerance {
    pub(super) fn new(observation: &Observation, options: &DeterministicOptions) -> Self {
        Self {
            std_devs: options.tolerance,
            relative_std: observation.relative_std,
            systematic: SYSTEMATIC * observation.relative_bound,
            position_floor: options.position_floor,
            heading_floor: options.heading_floor,
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
    /// The tip contact, whisker frame.
    pub(super) contact: TipContact,
    /// How far the tip must move along that normal (m), and how that depends on the candidate's (x, y, theta).
    pub(super) offset: f64,
    pub(super) gradient: [f64; 3],
    /// Standard deviation of the tip's place along the normal (m).
    pub(super) std: f64,
    /// How far the candidate must turn (rad), with its standard deviation, where the history bounds the heading.
    pub(super) turn: Option<(f64, f64)>,
}

/// The state of the preimage nearest to the candidate, on the best branch; none within the tolerance.
pub(super) fn nearest_state(
    map: &Map,
    candidate: &Candidate,
    observation: &Observation,
    tolerance: &Tolerance,
) -> Option<Match> {
    let map_from_whisker = candidate.map_from_odom.compose(observation.odom_from_whisker);
    let on_branch = |branch| on_branch(map, candidate, map_from_whisker, branch, tolerance);
    observation.branches.iter().filter_map(on_branch).min_by(|a, b| a.cost.total_cmp(&b.cost))
}

/// Where the tip lies and which boundary point is nearest.
struct Touch {
    tip: Vec2,
    point: MapPoint,
    normal: f64,
    contact: TipContact,
}

/// The tip for the boundary's own normal: found by alternating between the two.
fn touch(map: &Map, pose: Pose2, branch: &Branch, mut normal: f64) -> Option<Touch> {
    let mut found = None;
    for _ in 0..ROUNDS {
        let direction = normal - pose.theta;
        let contact = branch.contacts.at_direction(direction)?;
        let tip = pose.transform_point(contact.position);
        let point = map.nearest(tip)?;
        normal = outward(map, &point, pose.position());
        found = Some(Touch { tip, point, normal, contact });
    }
    found
}

/// The boundary's normal towards free space; towards the whisker's base for walls, which are free on both sides.
fn outward(map: &Map, point: &MapPoint, base: Vec2) -> f64 {
    let left = point.tangent + FRAC_PI_2;
    let two_sided = map.boundaries()[point.boundary].is_two_sided();
    let behind = (base - point.position).dot(Vec2::from_angle(left)) < 0.0;
    if two_sided && behind { left + PI } else { left }
}

fn on_branch(map: &Map, candidate: &Candidate, pose: Pose2, branch: &Branch, tolerance: &Tolerance) -> Option<Match> {
    let touch = touch(map, pose, branch, candidate.normal)?;
    let normal = Vec2::from_angle(touch.normal);
    let gap = touch.point.position - touch.tip;
    let offset = gap.dot(normal);
    if gap.dot(normal.perp()).abs() > ALONG {
        return None;
    }
    let sensitivity = branch.sensitivity(&touch.contact);
    let std = (sensitivity * tolerance.relative_std).hypot(LEAST_PLACE);
    let arm = (touch.tip - candidate.map_from_odom.position()).perp();
    let gradient = [normal.x, normal.y, normal.dot(arm)];
    let reach = tolerance.std_devs * (std * std + candidate.variance(gradient)).sqrt()
        + tolerance.systematic * sensitivity
        + tolerance.position_floor;
    let share = offset.abs() / reach;
    if share > 1.0 {
        return None;
    }
    let (turn_share, turn) = turn(candidate, pose, branch, touch.normal, tolerance)?;
    let cost = share * share + turn_share * turn_share;
    Some(Match { cost, normal: touch.normal, contact: touch.contact, offset, gradient, std, turn })
}

/// How far the candidate's heading is from the nearest alignment, in units of the tolerance; none if beyond it.
#[allow(clippy::type_complexity, reason = "a share and an optional turn with its spread, used once")]
fn turn(
    candidate: &Candidate,
    pose: Pose2,
    branch: &Branch,
    normal: f64,
    tolerance: &Tolerance,
) -> Option<(f64, Option<(f64, f64)>)> {
    let own = candidate.variance([0.0, 0.0, 1.0]);
    let reach = |std: f64| tolerance.std_devs * (std * std + own).sqrt() + tolerance.heading_floor;
    let heading = normal - FRAC_PI_2 - pose.theta;
    let nearest = branch
        .alignments
        .iter()
        .map(|a| (wrap_angle(heading - a.boundary_slope), a.std))
        .min_by(|a, b| (a.0.abs() / reach(a.1)).total_cmp(&(b.0.abs() / reach(b.1))));
    let bounded = branch.determined && branch.alignments.iter().all(|a| a.std <= WORST_SLOPE);
    match nearest {
        Some((turn, std)) if turn.abs() <= reach(std) && std <= WORST_SLOPE => {
            Some((turn.abs() / reach(std), Some((turn, std.hypot(LEAST_SLOPE)))))
        }
        _ if bounded => None,
        _ => Some((0.0, None)),
    }
}
