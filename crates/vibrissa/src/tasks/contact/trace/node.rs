//! One reading's contact for given unknowns, with its derivatives.

use super::TraceNode;
use crate::beam::{Bend, Load, Whisker, force_mode};
use crate::plane::Vec2;

/// Unknowns of a node: the force over its unit, the lean.
pub(super) const UNKNOWNS: usize = 2;
/// Largest tilt of the force (rad): beyond, it all but pulls or pushes along the whisker.
pub(super) const STEEPEST_TILT: f64 = 1.5;
/// Least lean: nearer to the base sides are told from others as fixed points alone.
const NEAREST: f64 = -0.7;

/// The state of a node while it is solved.
#[derive(Clone)]
pub(super) struct NodePrediction {
    pub(super) bend: Bend,
    pub(super) position: Vec2,
    /// Direction along the wall: the force's direction less a quarter turn (rad), not wrapped.
    pub(super) along: f64,
    /// Derivatives by the unknowns: moment, place, direction.
    pub(super) moment_by: [f64; UNKNOWNS],
    pub(super) position_by: [Vec2; UNKNOWNS],
    pub(super) along_by: [f64; UNKNOWNS],
}

/// What bends: the whisker to one side.
#[derive(Clone, Copy)]
pub(super) struct Bender<'a> {
    pub(super) whisker: &'a Whisker,
    /// The unit of the force: EI / L² (N).
    pub(super) unit: f64,
    /// The sign of the moment.
    pub(super) side: f64,
}

impl Bender<'_> {
    /// Arc length of the contact and its load for a lean; none beyond its range.
    pub(super) fn contact(&self, lean: f64) -> Option<(f64, Load)> {
        if lean >= 0.0 {
            return (lean <= STEEPEST_TILT).then_some((self.whisker.length, Load::Tilted(self.side * lean)));
        }
        (lean >= NEAREST).then_some((self.whisker.length * (1.0 + lean), Load::Normal))
    }

    /// The unknowns of a bent whisker; none where the force would come from inside the wall.
    pub(super) fn unknowns(&self, bend: &Bend) -> Option<[f64; UNKNOWNS]> {
        let behind = 1.0 - bend.s_a / self.whisker.length;
        let tilt = self.side * bend.beta;
        let lean = if behind > 0.0 { -behind } else { tilt };
        (behind > 0.0 || (0.0..=STEEPEST_TILT).contains(&tilt)).then_some([bend.force / self.unit, lean])
    }

    fn bend(&self, force: f64, lean: f64, largest_slope: f64) -> Option<Bend> {
        let (s_a, load) = self.contact(lean)?;
        let bends = force_mode(self.whisker, force * self.unit, s_a, load).ok()?;
        bends.into_iter().next().filter(|bend| bend.phi_a.abs() <= largest_slope)
    }

    /// The contact of a node; none where there is none, or the slope is beyond the largest (rad).
    pub(super) fn felt(&self, node: &TraceNode, unknowns: &[f64], largest_slope: f64) -> Option<NodePrediction> {
        let (force, lean) = (unknowns[0], unknowns[1]);
        let bend = self.bend(force, lean, largest_slope)?;
        let steps = [1e-6 * (force.abs() + 1e-3), 1e-6];
        let mut felt = NodePrediction {
            position: node.odom_from_whisker.transform_point(bend.contact),
            along: node.odom_from_whisker.theta + bend.phi_a + bend.beta,
            bend,
            moment_by: [0.0; UNKNOWNS],
            position_by: [Vec2::ZERO; UNKNOWNS],
            along_by: [0.0; UNKNOWNS],
        };
        let at = |k: usize, h: f64| match k {
            0 => self.bend(force + h, lean, largest_slope),
            _ => self.bend(force, lean + h, largest_slope),
        };
        for (k, step) in steps.into_iter().enumerate() {
            let (plus, minus) = (at(k, step)?, at(k, -step)?);
            let rate = 0.5 / step;
            felt.moment_by[k] = (plus.moment - minus.moment) * rate;
            felt.position_by[k] = ((plus.contact - minus.contact) * rate).rotated(node.odom_from_whisker.theta);
            felt.along_by[k] = (plus.phi_a + plus.beta - minus.phi_a - minus.beta) * rate;
        }
        Some(felt)
    }
}
