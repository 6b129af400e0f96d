//! The whisker's shapes along the log as one place of the robot sees them, for drawing.

use crate::WorkBudget;
use crate::beam::{TipModel, TipReading};
use crate::config::TipLoad;
use crate::flow::contact_set::{TipContact, TipContactSet};
use crate::flow::pose::ShapeRecord;
use crate::flow::thinned::Thinned;
use crate::plane::{Pose2, Vec2, wrap_angle};
use crate::world::{Map, MountedWhisker};
use core::f64::consts::{FRAC_PI_2, PI};

/// How far a drawn tip may be from the boundary (m), and its force from the normal there (rad): place and reading have
/// errors, and a reading that the side felt is not drawn.
const NEAR: f64 = 2e-3;
const ASLANT: f64 = 0.25;
/// Points of a drawn whisker.
const POINTS: usize = 24;

/// What a whisker felt once.
#[derive(Clone, Copy, Debug)]
pub(super) struct DrawnReading {
    pub(super) t: f64,
    pub(super) odom_from_robot: Pose2,
    pub(super) whisker: usize,
    pub(super) moment: f64,
}

/// The readings that are kept for drawing: an even share of each whisker's, however long the log.
///
/// Of all whiskers together at most twice `LEAST` are drawn.
#[derive(Clone, Debug, Default)]
pub(super) struct DrawnReadings<const LEAST: usize> {
    /// For each whisker.
    kept: Vec<Thinned<DrawnReading, LEAST>>,
    /// The newest of each.
    newest: Vec<Option<DrawnReading>>,
}

impl<const LEAST: usize> DrawnReadings<LEAST> {
    /// Takes the next reading.
    pub(super) fn push(&mut self, reading: DrawnReading) {
        if self.kept.len() <= reading.whisker {
            self.kept.resize_with(reading.whisker + 1, Thinned::default);
            self.newest.resize(reading.whisker + 1, None);
        }
        self.newest[reading.whisker] = Some(reading);
        self.kept[reading.whisker].push(reading);
    }

    /// The drawing of the shapes, before any work.
    pub(super) fn drawing(&self, whiskers: &[MountedWhisker]) -> ShapeDrawing {
        let kept = self.kept.iter().map(|one| one.iter().count()).sum::<usize>();
        let stride = kept.div_ceil(2 * LEAST).max(1);
        let some = self.kept.iter().flat_map(|one| one.iter().step_by(stride));
        let newest = self.newest.iter().flatten();
        let is_kept = |new: &&DrawnReading| self.kept[new.whisker].iter().step_by(stride).any(|one| one.t >= new.t);
        ShapeDrawing {
            tips: whiskers.iter().map(|whisker| TipModel::new(&whisker.beam).ok()).collect(),
            readings: some.chain(newest.filter(|new| !is_kept(new))).copied().collect(),
            at: 0,
            shapes: Vec::new(),
        }
    }
}

/// What a shape costs: a third of a millisecond.
const SHAPE_COST: usize = 600;

/// Shapes in the making.
#[derive(Debug, Default)]
pub(super) struct ShapeDrawing {
    tips: Vec<Option<TipModel>>,
    readings: Vec<DrawnReading>,
    at: usize,
    /// The shapes so far; all of them, in order of time, at the end.
    pub(super) shapes: Vec<ShapeRecord>,
}

impl ShapeDrawing {
    /// Goes on; whether all shapes are there.
    pub(super) fn advance(
        &mut self,
        map: &Map,
        whiskers: &[MountedWhisker],
        frame: &impl Fn(&DrawnReading) -> Option<Pose2>,
        budget: &mut WorkBudget,
    ) -> bool {
        while let Some(felt) = self.readings.get(self.at) {
            if budget.is_spent() {
                return false;
            }
            self.at += 1;
            let tip = self.tips[felt.whisker].as_ref();
            let drawn =
                tip.zip(frame(felt)).and_then(|(tip, frame)| shape(map, (&whiskers[felt.whisker], tip), felt, frame));
            self.shapes.extend(drawn);
            budget.spend(SHAPE_COST);
        }
        self.shapes.sort_by(|a, b| a.t.total_cmp(&b.t));
        true
    }
}

/// The whisker with its tip on the boundary, robot frame; none where no tip contact agrees with the place.
fn shape(
    map: &Map,
    (whisker, tip): (&MountedWhisker, &TipModel),
    felt: &DrawnReading,
    map_from_odom: Pose2,
) -> Option<ShapeRecord> {
    let map_from_whisker = map_from_odom.compose(felt.odom_from_robot).compose(whisker.robot_from_whisker);
    let branches = TipContactSet::branches(tip, TipReading::Moment(felt.moment), TipLoad::BoundaryNormal);
    let agreeing = |contact: &TipContact| misfit(map, map_from_whisker, contact).map(|misfit| (misfit, *contact));
    let contacts = branches.iter().flat_map(TipContactSet::contacts);
    let (_, contact) = contacts.filter_map(agreeing).min_by(|a, b| a.0.total_cmp(&b.0))?;
    let points = tip.bend(contact.force, contact.tilt())?.shape(whisker.beam.length, POINTS).into_iter();
    let points = points.map(|p| whisker.robot_from_whisker.transform_point(p)).collect();
    Some(ShapeRecord { t: felt.t, whisker: felt.whisker, points })
}

/// How badly the boundary near the tip fits a contact; none beyond the limits.
fn misfit(map: &Map, map_from_whisker: Pose2, contact: &TipContact) -> Option<f64> {
    let tip = map_from_whisker.transform_point(contact.position);
    let foot = map.foot(tip, NEAR)?;
    let left = foot.tangent + FRAC_PI_2;
    let behind = (map_from_whisker.position() - foot.position).dot(Vec2::from_angle(left)) < 0.0;
    let normal = if foot.two_sided && behind { left + PI } else { left };
    let off = wrap_angle(contact.direction + map_from_whisker.theta - normal) / ASLANT;
    (off.abs() <= 1.0).then(|| off * off + (tip.distance(foot.position) / NEAR).powi(2))
}
