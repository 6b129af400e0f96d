//! Bounded-error estimation \[jaulin2001applied, ch. 3\]: what is not known exactly of whisker, mount and map widens what a
//! reading allows.
//!
//! An error that is constant over the log may take another value in each reading here: the set of states that some constant
//! explains lies in the set of those that some sequence explains.

use crate::beam::Whisker;
use crate::beam::press::RodContacts;
use crate::math;
use crate::plane::{Pose2, Vec2};
use crate::world::{Lean, MountedWhisker, Robot};
use std::sync::Arc;

/// Chords of a whisker that is curved at rest.
const CHORDS: usize = 24;

/// Bounds on a place (m) and a turn (rad).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct PoseSlack {
    pub(super) place: f64,
    pub(super) turn: f64,
}

impl PoseSlack {
    pub(super) fn new(place: f64, turn: f64) -> Self {
        Self { place, turn }
    }

    pub(super) fn plus(self, other: Self) -> Self {
        Self { place: self.place + other.place, turn: self.turn + other.turn }
    }
}

/// A whisker with bounds on what is not known exactly of it, in the map's own metres: where the map is too large by a share
/// `s`, whiskers and ways are shorter on it by `1 + s`.
#[derive(Clone, Debug)]
pub(super) struct UncertainWhisker {
    mount: Pose2,
    base_stiffness: f64,
    pub(super) friction: f64,
    /// Its length as it is told, the shortest and the longest that it may have (m).
    pub(super) length: f64,
    pub(super) shortest: f64,
    pub(super) longest: f64,
    /// How far contacts may be from where the told length has them, relative to their distance from the base.
    pub(super) stretch: f64,
    /// Least and largest length over flexural rigidity (1/(N m)).
    per_moment: (f64, f64),
    /// How far the base may be from where it is told.
    mounted: PoseSlack,
    /// The contacts of a whisker that is not uniform.
    pub(super) rod: Option<Arc<RodContacts>>,
    /// How it leans out of the horizontal.
    pub(super) lean: Lean,
    /// The whisker at rest, whisker frame.
    rest: Arc<RestShape>,
}

/// A whisker at rest: a chain of chords, and how far it may be from them (m).
#[derive(Clone, Debug, PartialEq)]
pub(super) struct RestShape {
    pub(super) points: Vec<Vec2>,
    pub(super) off: f64,
    /// Whether it is straight.
    pub(super) is_straight: bool,
}

impl RestShape {
    /// Of a whisker, as told, that has a length from `shortest` to `longest` (m) on the map and of which `own` is off by its own.
    /// Seen from above it is as long as the cosine of its elevation says.
    pub(super) fn new(beam: &Whisker, (shortest, longest, own): (f64, f64, f64), lean: Lean) -> Self {
        let shortest = shortest * math::cos(lean.elevation);
        let straight = [Vec2::ZERO, Vec2::new(shortest, 0.0)].to_vec();
        let terms = beam.curvature_terms();
        let wound: f64 = terms.iter().rev().fold(0.0, |sum, term| (sum + term.abs()) * beam.length);
        if wound <= 0.0 {
            return Self { points: straight, off: 0.0, is_straight: true };
        }
        // The slope is a polynomial: each chord by Simpson's rule on short steps.
        let slope =
            |s: f64| terms.iter().enumerate().rev().fold(0.0, |sum, (k, term)| (sum + term / (k + 1) as f64) * s);
        let (parts, mut at, mut points) = (16, Vec2::ZERO, vec![Vec2::ZERO]);
        let step = beam.length / (CHORDS * parts) as f64;
        for k in 0..CHORDS {
            for i in 0..parts {
                let s = (k * parts + i) as f64 * step;
                let [a, b, c] = [s, s + 0.5 * step, s + step].map(|s| Vec2::from_angle(slope(s)));
                at += (a + b * 4.0 + c) * (step / 6.0);
            }
            points.push(at);
        }
        let chord = beam.length / CHORDS as f64;
        let sagitta =
            chord * (1.0 - math::cos((0.5 * wound / CHORDS as f64).min(1.0))).max(0.5 * wound / CHORDS as f64);
        let stretch = (longest / beam.length - 1.0).max(1.0 - shortest / beam.length);
        // How far the slope at any share of the length may be off.
        let turned = wound * ((1.0 + own / beam.length).powi(terms.len() as i32) - 1.0);
        Self { points, off: sagitta + longest * (stretch + turned), is_straight: false }
    }
}

/// How a whisker stands that reads some interval of moments: its base turns with the moment where it is elastic.
#[derive(Clone, Copy, Debug)]
pub(super) struct BaseStand {
    pub(super) robot_from_whisker: Pose2,
    pub(super) slack: PoseSlack,
}

impl UncertainWhisker {
    /// Of a whisker with slopes up to `steepest` (rad) against those at rest.
    pub(super) fn new(whisker: &MountedWhisker, map_scale: f64, steepest: f64) -> Self {
        let (errors, beam) = (&whisker.errors, &whisker.beam);
        let [x, y, theta] = errors.mount;
        let (larger, smaller) = (1.0 / (1.0 - map_scale), 1.0 / (1.0 + map_scale));
        let (least, most) = (beam.length - errors.length, beam.length + errors.length);
        let (shortest, longest) = (least * smaller, most * larger);
        let rigidity = |share: f64| beam.flexural_rigidity * (1.0 + share);
        let arm = whisker.robot_from_whisker.position().norm();
        let is_uniform = Whisker { base_stiffness: f64::INFINITY, ..*beam }.is_uniform();
        let contacts = || RodContacts::new(beam, math::atan(whisker.friction), steepest, errors.length / beam.length);
        Self {
            mount: whisker.robot_from_whisker,
            base_stiffness: beam.base_stiffness,
            friction: whisker.friction,
            length: beam.length,
            shortest,
            longest,
            stretch: (longest / beam.length - 1.0).max(1.0 - shortest / beam.length),
            per_moment: (least / rigidity(errors.rigidity), most / rigidity(-errors.rigidity)),
            mounted: PoseSlack::new(math::hypot(x, y) * larger + arm * (larger - 1.0), theta),
            rod: (!is_uniform).then(contacts).and_then(Result::ok).map(Arc::new),
            lean: whisker.lean,
            rest: Arc::new(RestShape::new(beam, (shortest, longest, errors.length), whisker.lean)),
        }
    }

    /// Where the base is told to be on the robot, and how far it may be from there.
    pub(super) fn mount(&self) -> Pose2 {
        self.mount
    }

    pub(super) fn mounted(&self) -> PoseSlack {
        self.mounted
    }

    /// The whisker at rest.
    pub(super) fn rest(&self) -> &Arc<RestShape> {
        &self.rest
    }

    /// The dimensionless moments of an interval (N m).
    pub(super) fn dimensionless(&self, lo: f64, hi: f64) -> (f64, f64) {
        let (least, most) = self.per_moment;
        (lo * if lo > 0.0 { least } else { most }, hi * if hi > 0.0 { most } else { least })
    }

    /// The curvatures at the base of an interval of moments (N m), in 1/m.
    pub(super) fn curvature(&self, lo: f64, hi: f64) -> (f64, f64) {
        let (lo, hi) = self.dimensionless(lo, hi);
        let over = |edge: f64, most: bool| edge / if most { self.shortest } else { self.longest };
        (over(lo, lo < 0.0), over(hi, hi > 0.0))
    }

    /// How the base stands while the moment is in an interval (N m).
    pub(super) fn stand(&self, lo: f64, hi: f64) -> BaseStand {
        if self.base_stiffness.is_infinite() {
            return BaseStand { robot_from_whisker: self.mount, slack: self.mounted };
        }
        let (turn, half) = (0.5 * (lo + hi) / self.base_stiffness, 0.5 * (hi - lo) / self.base_stiffness);
        BaseStand {
            robot_from_whisker: self.mount.compose(Pose2::new(0.0, 0.0, turn)),
            slack: self.mounted.plus(PoseSlack::new(0.0, half + 1e-12)),
        }
    }
}

/// Bounds of the odometry's increments, relative to what it says, in the map's own metres.
#[derive(Clone, Copy, Debug)]
pub(super) struct StepBounds {
    pub(super) translation: f64,
    pub(super) rotation: f64,
    /// The measured way over the true one, at least.
    pub(super) least: f64,
}

impl StepBounds {
    pub(super) fn new(robot: &Robot) -> Self {
        let (odometry, scale) = (&robot.odometry, robot.map_scale);
        let translation = relative_to_measured(odometry.translation_relative);
        Self {
            translation: translation + (1.0 + translation) * scale / (1.0 - scale),
            rotation: relative_to_measured(odometry.rotation_relative),
            least: (1.0 - odometry.translation_relative) * (1.0 - scale),
        }
    }

    /// The true way and turn where the odometry says `way` (m) and `turn` (rad).
    pub(super) fn at_most(&self, (way, turn): (f64, f64)) -> PoseSlack {
        PoseSlack::new(way / self.least, turn * (1.0 + self.rotation))
    }
}

/// A bound relative to the true increment, made one relative to the measured increment; never smaller.
fn relative_to_measured(relative: f64) -> f64 {
    if relative > 0.0 { relative / (1.0 - relative) } else { 0.0 }
}
