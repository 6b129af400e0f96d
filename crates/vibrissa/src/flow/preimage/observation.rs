//! One observation: what a short history of moments says about the contact, on every branch.

use super::WORST_SLOPE;
use super::alignment::{Alignment, History, HistoryShape};
use crate::beam::{Whisker, elastica};
use crate::config::TipLoad;
use crate::flow::contact_set::{TipContact, TipContactSet};
use crate::flow::moment::MomentHistory;
use crate::plane::{Pose2, Vec2, wrap_angle};
use crate::world::MountedWhisker;
use core::f64::consts::FRAC_PI_2;

/// Relative step of the moment in the difference quotient of the contact's place.
const MOMENT_STEP: f64 = 0.01;
/// A whisker's body is checked against the map as this many straight links, up to this share of its length: the tip
/// itself touches.
const BODY_LINKS: usize = 6;
const BODY_END: f64 = 0.95;
/// A root that moves further than this when the readings are shifted by a standard deviation (rad) is lost.
const LOST: f64 = 0.6;

/// One branch of whisker shapes that a moment allows.
#[derive(Clone, Debug)]
pub struct Branch {
    /// Where the tip can be.
    pub contacts: TipContactSet,
    /// Where it can be when the moment is a little larger.
    larger: Option<TipContactSet>,
    /// How the whisker can lie against the boundary.
    pub alignments: Vec<Alignment>,
    /// Whether the alignments are all there are; if not, the history does not bound the heading.
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
    beam: Whisker,
}

impl Observation {
    /// What this history says about the contact.
    ///
    /// Without branches when no tip load causes such a moment.
    #[must_use]
    pub fn new(whisker: &MountedWhisker, history: &MomentHistory, load: TipLoad) -> Self {
        let moment = history.center.moment;
        let branches = |moment: f64| TipContactSet::branches(&whisker.beam, moment, load);
        let center = branches(moment);
        let mut larger = branches(moment * (1.0 + MOMENT_STEP)).into_iter();
        // The readings as they are, tilted, and bent along the travel by one standard deviation.
        let slopes = [(0.0, 0.0), (history.slope_std, 0.0), (0.0, history.bend_std)]
            .map(|(tilt, bend)| slopes_of_all_branches(&whisker.beam, &center, history, load, tilt, bend));
        let branch = |(index, contacts): (usize, TipContactSet)| {
            let (alignments, determined) = align(&contacts, slopes.each_ref().map(|s| s.get(index)));
            Branch { larger: larger.next(), contacts, alignments, determined }
        };
        Self {
            t: history.center.t,
            moment,
            odom_from_whisker: history.center.odom_from_whisker,
            robot_from_whisker: whisker.robot_from_whisker,
            relative_std: history.center_std / moment.abs(),
            relative_bound: history.bound / moment.abs(),
            beam: whisker.beam,
            branches: center.into_iter().enumerate().map(branch).collect(),
        }
    }

    /// Points along the whisker from its base to just before the contact, whisker frame (m).
    pub(super) fn body(&self, contact: &TipContact) -> Vec<Vec2> {
        let length = self.beam.length;
        let bend = elastica::bend(self.beam.flexural_rigidity, contact.force, length, contact.tilt());
        let at = |k: usize| k as f64 / BODY_LINKS as f64 * BODY_END * length;
        bend.map_or_else(Vec::new, |bend| (0..=BODY_LINKS).map(|k| bend.point_at(at(k)).position).collect())
    }

    /// Whether anything can be aligned with a boundary: on some branch a slope is known well enough.
    #[must_use]
    pub fn is_aligned(&self) -> bool {
        self.branches.iter().any(|b| b.usable().next().is_some())
    }
}

impl Branch {
    /// The alignments whose slope is known well enough to lay the whisker against a boundary.
    pub(super) fn usable(&self) -> impl Iterator<Item = &Alignment> {
        self.alignments.iter().filter(|a| a.std <= WORST_SLOPE)
    }

    /// How far the contact moves across the boundary when the moment grows by its own size (m), with the same
    /// direction of the force.
    #[must_use]
    pub fn sensitivity(&self, contact: &TipContact) -> f64 {
        let (direction, position) = (contact.direction, contact.position);
        let moved = self.larger.as_ref().and_then(|set| set.at_direction(direction));
        // Past the last moment that the branch can carry the contact is anywhere: as far as the whisker reaches.
        moved.map_or(1.0, |c| (c.position - position).dot(Vec2::from_angle(direction)).abs() / MOMENT_STEP)
    }
}

/// The slopes on every branch when the moments are tilted (N m/m) and bent (N m/m²) along the travel.
fn slopes_of_all_branches(
    beam: &Whisker,
    center: &[TipContactSet],
    history: &MomentHistory,
    load: TipLoad,
    tilt: f64,
    bend: f64,
) -> Vec<Vec<f64>> {
    let base = history.center.odom_from_whisker;
    let shapes: Vec<(Pose2, Vec<TipContactSet>)> = history
        .shapes
        .iter()
        .zip(&history.travel)
        .map(|(shape, travel)| {
            let moment = shape.moment + travel * (tilt + travel * bend);
            (base.between(shape.odom_from_whisker), TipContactSet::branches(beam, moment, load))
        })
        .collect();
    let on_branch = |(index, center): (usize, &TipContactSet)| {
        let shapes: Option<Vec<HistoryShape>> = shapes
            .iter()
            .map(|(pose, sets)| sets.get(index).map(|contacts| HistoryShape { center_from_whisker: *pose, contacts }))
            .collect();
        shapes.map_or_else(Vec::new, |shapes| History::new(center, shapes).slopes())
    };
    center.iter().enumerate().map(on_branch).collect()
}

/// The alignments of one branch, and whether they bound the heading: from the slopes that the readings show as they
/// are, tilted, and bent.
fn align(contacts: &TipContactSet, slopes: [Option<&Vec<f64>>; 3]) -> (Vec<Alignment>, bool) {
    let [Some(same), Some(tilted), Some(bent)] = slopes else { return (Vec::new(), false) };
    let nearest = |roots: &[f64], to: f64| roots.iter().map(|r| wrap_angle(r - to).abs()).fold(f64::INFINITY, f64::min);
    let mut alignments = Vec::new();
    let mut determined = !same.is_empty() && tilted.len() == same.len() && bent.len() == same.len();
    for &slope in same {
        let std = nearest(tilted, slope).hypot(nearest(bent, slope));
        match contacts.at_direction(slope + FRAC_PI_2) {
            Some(contact) if std < LOST => alignments.push(Alignment { boundary_slope: slope, contact, std }),
            _ => determined = false,
        }
    }
    (alignments, determined)
}
