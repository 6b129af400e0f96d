//! One observation: what a short history of moments says about the contact, on every branch.

use super::alignment::{Alignment, BranchHistory, HistoryShape};
use crate::beam::{TipModel, TipReading};
use crate::config::TipLoad;
use crate::flow::contact_set::{TipContact, TipContactSet};
use crate::flow::moment::{MomentHistory, MomentReading};
use crate::plane::{Pose2, Vec2};
use crate::world::{Lean, MountedWhisker};
use core::cell::RefCell;

/// Relative step of the moment in the difference quotient of the contact's place.
const MOMENT_STEP: f64 = 0.01;
/// A whisker's body is checked against the map as this many straight links, up to this share of its length: the tip
/// itself touches.
const BODY_LINKS: usize = 6;
const BODY_END: f64 = 0.95;

/// One branch of whisker shapes that a moment allows.
#[derive(Clone, Debug)]
pub struct Branch {
    /// Where the tip can be.
    pub contacts: TipContactSet,
    /// Where it can be when the moment is a little larger.
    larger: Option<TipContactSet>,
    /// How the whisker can lie against the boundary.
    pub alignments: Vec<Alignment>,
    /// Whether the history could be aligned at all; if not, it does not bound the heading.
    pub determined: bool,
}

/// What the whisker felt at one time.
#[derive(Clone, Debug)]
pub struct Observation {
    /// When (s).
    pub t: f64,
    /// The smoothed moment (N m).
    pub moment: f64,
    /// The whisker base in the odometry frame.
    pub odom_from_whisker: Pose2,
    /// Where the whisker sits on the robot.
    pub robot_from_whisker: Pose2,
    /// Standard deviation of the moment relative to it.
    pub relative_std: f64,
    /// Bound on one reading's error relative to the moment.
    pub relative_bound: f64,
    /// Every branch of shapes.
    pub branches: Vec<Branch>,
    tip: TipModel,
    lean: Lean,
}

impl Observation {
    /// What this history says about the contact; `tip` is the whisker's model.
    ///
    /// Without branches when no tip load causes such a moment.
    #[must_use]
    pub fn new(whisker: &MountedWhisker, tip: &TipModel, history: &MomentHistory, load: TipLoad) -> Self {
        Self::with(whisker, tip, history, &mut |moment| {
            if whisker.lean.is_level() {
                TipContactSet::branches(tip, TipReading::Moment(moment), load)
            } else {
                whisker.lean.tip_contacts(tip.whisker(), moment)
            }
        })
    }

    /// As [`Observation::new`], with the branches of a moment's contact sets from elsewhere.
    #[must_use]
    pub(crate) fn with(
        whisker: &MountedWhisker,
        tip: &TipModel,
        history: &MomentHistory,
        branches_of: &mut dyn FnMut(f64) -> Vec<TipContactSet>,
    ) -> Self {
        let moment = history.center.moment;
        // The same moments come again: at the centre, and where nothing is tilted or bent.
        let known = RefCell::new((branches_of, Vec::<(u64, Vec<TipContactSet>)>::new()));
        let branches = |moment: f64| {
            let (branches_of, known) = &mut *known.borrow_mut();
            if let Some((_, sets)) = known.iter().find(|(bits, _)| *bits == moment.to_bits()) {
                return sets.clone();
            }
            let sets = branches_of(moment);
            known.push((moment.to_bits(), sets.clone()));
            sets
        };
        let center = branches(moment);
        let relative_std = history.center_std / moment.abs();
        let mut larger = branches(moment * (1.0 + MOMENT_STEP)).into_iter();
        let shapes = disturbances(history).map(|(tilt, bend)| shapes(history, &branches, tilt, bend));
        let branch = |(index, contacts): (usize, TipContactSet)| {
            let larger = larger.next();
            let on_branch = |k: usize| -> Option<Vec<HistoryShape>> {
                shapes[k]
                    .iter()
                    .map(|(pose, sets)| {
                        sets.get(index).map(|contacts| HistoryShape { center_from_whisker: *pose, contacts })
                    })
                    .collect()
            };
            let (alignments, determined) = match (on_branch(0), on_branch(1), on_branch(2)) {
                (Some(same), Some(tilted), Some(bent)) => {
                    let place_std = |c: &TipContact| relative_std * sensitivity(larger.as_ref(), c);
                    let disturbed = [tilted, bent];
                    let history = BranchHistory { center: &contacts, shapes: same, disturbed, place_std: &place_std };
                    (history.alignments(), true)
                }
                _ => (Vec::new(), false),
            };
            Branch { larger, contacts, alignments, determined }
        };
        Self {
            t: history.center.t,
            moment,
            odom_from_whisker: history.center.odom_from_whisker,
            robot_from_whisker: whisker.robot_from_whisker,
            relative_std,
            relative_bound: history.bound / moment.abs(),
            tip: tip.clone(),
            lean: whisker.lean,
            branches: center.into_iter().enumerate().map(branch).collect(),
        }
    }

    /// Points along the whisker from its base to just before the contact, whisker frame (m).
    pub(super) fn body(&self, contact: &TipContact) -> Vec<Vec2> {
        if !self.lean.is_level() {
            let shares: Vec<f64> = (0..=BODY_LINKS).map(|k| k as f64 / BODY_LINKS as f64 * BODY_END).collect();
            return self.lean.shape(self.tip.whisker(), contact, &shares);
        }
        let length = self.tip.whisker().length;
        let bend = self.tip.bend(contact.force, contact.tilt());
        let at = |k: usize| k as f64 / BODY_LINKS as f64 * BODY_END * length;
        bend.map_or_else(Vec::new, |bend| (0..=BODY_LINKS).map(|k| bend.point_at(at(k)).position).collect())
    }

    /// Points along the whole whisker, for drawing, whisker frame (m); none where no such shape is found.
    pub(crate) fn shape(&self, contact: &TipContact, points: usize) -> Option<Vec<Vec2>> {
        let whisker = self.tip.whisker();
        if self.lean.is_level() {
            return Some(self.tip.bend(contact.force, contact.tilt())?.shape(whisker.length, points));
        }
        let last = points.max(2) - 1;
        let shares: Vec<f64> = (0..=last).map(|k| k as f64 / last as f64).collect();
        let shape = self.lean.shape(whisker, contact, &shares);
        (!shape.is_empty()).then_some(shape)
    }

    /// How many slopes of the boundary the history leaves open on the least bent branch (rad); infinite if it could not
    /// be aligned.
    ///
    /// While a robot presses its whisker into a wall the contact hardly moves and every slope is admissible.
    #[must_use]
    pub fn open_slopes(&self) -> f64 {
        match self.branches.first() {
            Some(b) if b.determined && !b.alignments.is_empty() => b.alignments.iter().map(|a| a.offsets.width()).sum(),
            _ => f64::INFINITY,
        }
    }
}

impl Branch {
    /// How far the contact moves across the boundary when the moment grows by its own size (m), with the same
    /// direction of the force.
    #[must_use]
    pub fn sensitivity(&self, contact: &TipContact) -> f64 {
        sensitivity(self.larger.as_ref(), contact)
    }
}

/// As [`Branch::sensitivity`], from where the tip can be when the moment is a little larger.
fn sensitivity(larger: Option<&TipContactSet>, contact: &TipContact) -> f64 {
    let moved = larger.and_then(|set| set.at_direction(contact.direction));
    // Past the last moment that the branch can carry the contact is anywhere: as far as the whisker reaches.
    moved.map_or(1.0, |c| (c.position - contact.position).dot(Vec2::from_angle(contact.direction)).abs() / MOMENT_STEP)
}

/// Where the whisker was at each shape of the history, and every branch of its tip contacts, when the moments are tilted
/// (N m/m) and bent (N m/m²) along the travel.
fn shapes(
    history: &MomentHistory,
    branches: &impl Fn(f64) -> Vec<TipContactSet>,
    tilt: f64,
    bend: f64,
) -> Vec<(Pose2, Vec<TipContactSet>)> {
    let base = history.center.odom_from_whisker;
    let place = |shape: &MomentReading| base.between(shape.odom_from_whisker);
    let moments = moments(history, tilt, bend);
    history.shapes.iter().zip(moments).map(|(shape, moment)| (place(shape), branches(moment))).collect()
}

/// The moments of a history's shapes, tilted (N m/m) and bent (N m/m²) along the travel.
fn moments(history: &MomentHistory, tilt: f64, bend: f64) -> impl Iterator<Item = f64> {
    let at = move |(shape, travel): (&MomentReading, &f64)| shape.moment + travel * (tilt + travel * bend);
    history.shapes.iter().zip(&history.travel).map(at)
}

/// Tilt and bend of the readings as they are, tilted, and bent along the travel by one standard deviation.
fn disturbances(history: &MomentHistory) -> [(f64, f64); 3] {
    [(0.0, 0.0), (history.slope_std, 0.0), (0.0, history.bend_std)]
}

/// The moments whose contact sets an observation of this history asks for.
pub(crate) fn observed_moments(history: &MomentHistory) -> Vec<f64> {
    let moment = history.center.moment;
    let shapes = disturbances(history).into_iter().flat_map(|(tilt, bend)| moments(history, tilt, bend));
    [moment, moment * (1.0 + MOMENT_STEP)].into_iter().chain(shapes).collect()
}
