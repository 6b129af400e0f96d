//! The forward model: the moment that a whisker feels at a pose, and its derivatives by that pose.
//!
//! One contact without friction, at the tip (`tip.rs`) or at the side (`side.rs`), followed from pose to pose; what a
//! free whisker meets is in `meet.rs`, where one that snaps comes to rest in `spring.rs`. Differentiating the equations of the equilibrium gives `dh/d(x, y, theta)` for the
//! price of one more solution of the same linear system. Slightly negative forces, a whisker glued to the boundary, are
//! kept: they tell in which direction a contact that should be there is to be looked for.

mod balance;
mod body;
mod both;
mod meet;
mod packed;
mod side;
mod span;
mod spring;
mod system;
mod tip;

use super::feeler::Sense;
use super::ground::Ground;
use super::symmetry::Turn;
use crate::beam::{TipChart, TipModel, TipTable, tip_chart};
use crate::plane::{Pose2, Vec2, wrap_angle};
use crate::world::Map;
use body::Body;
use both::Both;
use core::f64::consts::PI;
pub(super) use packed::Packed;

/// Largest travel of the base (whisker lengths, rad) in one step of the continuation.
const LARGEST_STEP: f64 = 0.028;
/// Largest travel of the tip along the boundary in such a step, and of its slope.
const LARGEST_SLIDE: f64 = 0.08;
const LARGEST_BEND: f64 = 0.35;
/// Largest change of the place along the whisker, over its length.
const LARGEST_PASS: f64 = 0.2;
/// How far any place of a whisker moves at most, over how far its base does and turns it.
const MOTION: f64 = 1.5;
/// How far a whisker moves (whisker lengths) before a bump that does not touch it is tried again.
const RETRY: f64 = 4e-3;
/// A step is halved this often before the whisker is said to have snapped.
const MOST_HALVINGS: u32 = 6;
/// Snaps on the way from one pose to the next before it is given up.
const MOST_SNAPS: u32 = 2;
/// Pull (dimensionless force) at which a glued whisker lets go: a gap of about 2.5 mm for the paper's whisker.
const LET_GO: f64 = -0.1;

/// What holds the whisker.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Hold {
    /// The tip: a place on a piece.
    Piece(u32, f64),
    /// The tip: a concave corner.
    Corner(u32),
    /// The side: a convex corner.
    Vertex(u32),
    /// The side: a place on a piece, tangent to it.
    Flank(u32, f64),
    /// Tip and side.
    Both(Both),
}

/// A whisker on a boundary.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Touch {
    /// Dimensionless force `F s² / EI`; negative while the whisker is glued across a small gap.
    pub(super) q: f64,
    /// Tilt of the force from the whisker's normal at the contact (rad); at the side 0, or pi for a push from its left.
    beta: f64,
    /// Arc length of the contact over the whisker's length, 1 at the tip.
    s: f64,
    hold: Hold,
    /// The contact (m), map frame.
    place: Vec2,
    /// The slope of the whisker there (rad).
    slope: f64,
    /// How far it may still move (m) before the rest of the whisker can have come to a boundary.
    clear: f64,
}

impl Touch {
    /// The whisker lying down here: the force along its normal, on the side on which it is.
    fn laid(self, hold: Hold) -> Self {
        Self { beta: if self.beta.cos() > 0.0 { 0.0 } else { PI }, hold, ..self }
    }
}

/// The reading that a pose of the whisker makes, see [`Sense`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Felt {
    /// Without dimension; of a glued whisker what its pull would make.
    pub(super) value: f64,
    /// Its derivatives by the whisker base's x, y (1/m, map frame) and heading (1/rad).
    pub(super) gradient: [f64; 3],
}

/// How a whisker stands to the map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum State {
    /// Straight, touching nothing.
    Free,
    /// With its tip or its side on a boundary.
    Touching(Touch),
    /// In a contact that the model does not follow: what it feels is not known.
    Unknown,
}

impl State {
    /// Where the tip is pressed against a piece: piece and parameter.
    pub(super) fn tip_on(&self) -> Option<(u32, f64)> {
        match self {
            Self::Touching(Touch { hold: Hold::Piece(piece, at), q, .. }) if *q > 0.0 => Some((*piece, *at)),
            _ => None,
        }
    }
}

impl State {
    /// The piece that holds the tip, pressed or glued, and the parameter.
    pub(super) fn on_piece(&self) -> Option<(u32, f64)> {
        match self {
            Self::Touching(Touch { hold: Hold::Piece(piece, at), .. }) => Some((*piece, *at)),
            _ => None,
        }
    }

    /// The same moved to where its tip's piece and parameter go.
    pub(super) fn slid(&self, motion: Pose2, to: &dyn Fn((u32, f64)) -> (u32, f64)) -> Self {
        let Self::Touching(touch) = *self else { return *self };
        let hold = match touch.hold {
            Hold::Piece(piece, at) => {
                let (piece, at) = to((piece, at));
                Hold::Piece(piece, at)
            }
            other => other,
        };
        Self::Touching(Touch { hold, place: motion.transform_point(touch.place), ..touch })
    }

    /// The same on a map turned onto itself.
    pub(super) fn turned(&self, turn: &Turn) -> Self {
        let Self::Touching(touch) = *self else { return *self };
        let hold = match touch.hold {
            Hold::Piece(piece, at) => Hold::Piece(turn.piece(piece), at),
            Hold::Corner(id) => Hold::Corner(turn.piece(id)),
            Hold::Vertex(id) => Hold::Vertex(turn.piece(id)),
            Hold::Flank(piece, at) => Hold::Flank(turn.piece(piece), at),
            Hold::Both(both) => Hold::Both(both.turned(turn)),
        };
        Self::Touching(Touch { hold, place: turn.motion.transform_point(touch.place), ..touch })
    }
}

/// What one step of the continuation found.
enum Next {
    Touching(Touch, Felt),
    LetGo,
    None,
}

/// How exactly equilibria are solved.
#[derive(Clone, Copy, Debug)]
pub(super) enum Solver<'a> {
    /// In closed form, to rounding.
    Exact,
    /// From a table, to about 1e-4 of a moment.
    Quick(&'a TipTable),
    /// From the table of a whisker that is not uniform: its tip alone.
    Table(&'a TipModel),
}

impl Solver<'_> {
    fn chart(&self, q: f64, beta: f64) -> Option<TipChart> {
        match self {
            Self::Exact => tip_chart(q, beta),
            Self::Quick(table) => table.at(q, beta),
            Self::Table(tip) => tip.chart(q, beta),
        }
    }

    /// One of two tolerances.
    fn pick(&self, quick: f64, exact: f64) -> f64 {
        if matches!(self, Self::Exact) { exact } else { quick }
    }

    /// Residual (whisker lengths, rad) from which one more Newton step ends the search; the error left is about its
    /// square, and more where the branch is about to fold: with a hundredth of a length left there, whiskers snap a row too
    /// early or late and sweeps of a thousand rows end two standard deviations off.
    fn near(&self) -> f64 {
        match self {
            Self::Exact | Self::Table(_) => 2e-5,
            Self::Quick(_) => 1e-3,
        }
    }
}

/// A whisker of known length on a map.
#[derive(Clone, Copy, Debug)]
pub(super) struct Forward<'a> {
    pub(super) map: &'a Map,
    pub(super) ground: &'a Ground,
    /// The whisker's length (m).
    pub(super) length: f64,
    /// How exactly equilibria are solved.
    pub(super) solver: Solver<'a>,
    /// Whether the whole whisker is looked at, not only its contact.
    pub(super) whole: bool,
    /// What is read.
    pub(super) sense: Sense,
}

/// A base pose with its sine and cosine.
#[derive(Clone, Copy)]
struct Stance {
    base: Vec2,
    theta: f64,
    sin: f64,
    cos: f64,
    per_length: f64,
}

impl Stance {
    fn new(map_from_whisker: Pose2, length: f64) -> Self {
        let (sin, cos) = map_from_whisker.theta.sin_cos();
        Self { base: map_from_whisker.position(), theta: map_from_whisker.theta, sin, cos, per_length: 1.0 / length }
    }

    /// A vector of the map in the whisker's frame, over the length.
    fn seen(&self, v: Vec2) -> Vec2 {
        Vec2::new(self.cos * v.x + self.sin * v.y, self.cos * v.y - self.sin * v.x) * self.per_length
    }

    /// A place in the whisker's frame, over the length, in the map (m).
    fn placed(&self, p: Vec2) -> Vec2 {
        let length = 1.0 / self.per_length;
        self.base + Vec2::new(self.cos * p.x - self.sin * p.y, self.sin * p.x + self.cos * p.y) * length
    }

    /// The derivatives of the equations `gap`, `aslant` by the base, dotted with the adjoint `l`, negated.
    fn gradient(&self, l: [f64; 3], target: Vec2) -> [f64; 3] {
        let (a, b) = (l[0] * self.per_length, l[1] * self.per_length);
        let turned = target.perp();
        [-(a * self.cos - b * self.sin), -(a * self.sin + b * self.cos), -(l[0] * turned.x + l[1] * turned.y + l[2])]
    }
}

impl Forward<'_> {
    /// Moves a whisker from one base pose to another (`map_from_whisker`) and tells what it feels there.
    ///
    /// A free whisker that is `wanted` in contact is glued to a boundary just out of its reach.
    pub(super) fn advance(&self, state: &mut State, from: Pose2, to: Pose2, wanted: bool) -> Felt {
        let felt = match *state {
            State::Touching(touch) => self.slide(touch, from, to),
            State::Free | State::Unknown => None,
        };
        if let Some((touch, felt)) = felt {
            *state = State::Touching(touch);
            return felt;
        }
        let met = self.meet(from, to).or_else(|| if wanted { self.glue(to) } else { None });
        *state = met.map_or(State::Free, |(state, _)| state);
        met.map_or(Felt::default(), |(_, felt)| felt)
    }

    /// The touching whisker moved in steps that the continuation can take; none when it let go or snapped.
    fn slide(&self, mut touch: Touch, from: Pose2, to: Pose2) -> Option<(Touch, Felt)> {
        let turn = wrap_angle(to.theta - from.theta);
        let way = ((to.position() - from.position()).norm_squared().sqrt() / self.length).max(turn.abs());
        let steps = if way <= LARGEST_STEP { 1.0 } else { (way / LARGEST_STEP).ceil().min(1e4) };
        let least = 1.0 / (steps * f64::from(1_u32 << MOST_HALVINGS));
        let (mut share, mut step) = (0.0, 1.0 / steps);
        let mut felt = Felt::default();
        let mut snaps = 0;
        while share < 1.0 {
            let target = if share + step > 1.0 - 1e-9 { 1.0 } else { share + step };
            let pose = if target >= 1.0 {
                to
            } else {
                let place = from.position() + (to.position() - from.position()) * target;
                Pose2 { x: place.x, y: place.y, theta: from.theta + target * turn }
            };
            touch.clear -= MOTION * (target - share) * way * self.length;
            match self.next(&touch, pose) {
                Next::Touching(next, now) => {
                    (touch, felt, share) = (next, now, target);
                    step = (2.0 * step).min(1.0 / steps);
                }
                Next::LetGo => return None,
                Next::None => {
                    step *= 0.5;
                    if step < least {
                        snaps += 1;
                        (touch, felt) = self.spring(&touch, pose).filter(|_| snaps <= MOST_SNAPS)?;
                        (share, step) = (target, 1.0 / steps);
                    }
                }
            }
        }
        Some((touch, felt))
    }

    /// The equilibrium after a small motion to `map_from_whisker`, near enough to the one before to be its continuation.
    fn next(&self, touch: &Touch, map_from_whisker: Pose2) -> Next {
        let stance = Stance::new(map_from_whisker, self.length);
        let next = match touch.hold {
            Hold::Piece(piece, at) => self.along(&stance, touch, piece, at, false),
            Hold::Corner(piece) => self.caught(&stance, touch, piece),
            Hold::Vertex(_) | Hold::Flank(..) => self.on_side(&stance, *touch),
            Hold::Both(both) => match self.on_both(&stance, both) {
                Next::None => self.on_either(&stance, &both),
                other => other,
            },
        };
        let near = |next: &Touch| {
            let tip_let_go = matches!(touch.hold, Hold::Both(_)) && next.s < 1.0;
            tip_let_go
                || (next.place - touch.place).norm_squared() <= (LARGEST_SLIDE * self.length).powi(2)
                    && (next.s - touch.s).abs() <= LARGEST_PASS
                    && (next.slope - touch.slope).abs() <= LARGEST_BEND
        };
        match next {
            Next::Touching(next, _) if !near(&next) => Next::None,
            Next::Touching(next, _) if next.q < LET_GO => Next::LetGo,
            Next::Touching(next, felt) => {
                self.cleared(&stance, Touch { clear: touch.clear + next.clear, ..next }, felt)
            }
            other => other,
        }
    }

    /// The contact, or two where the rest of the whisker has come to a boundary.
    fn cleared(&self, stance: &Stance, touch: Touch, felt: Felt) -> Next {
        // Two contacts are followed with the moment of uniform whiskers.
        let followed = self.sense == Sense::Moment && !matches!(self.solver, Solver::Table(_));
        if !self.whole || !followed || touch.clear > 0.0 || touch.q <= 0.0 || matches!(touch.hold, Hold::Both(_)) {
            return Next::Touching(touch, felt);
        }
        let two = match self.body(stance, &touch) {
            Body::Clear(clear) => return Next::Touching(Touch { clear, ..touch }, felt),
            Body::Before(share, at) => self.propped(stance, &touch, share, at),
            Body::Beyond(at) => self.stopped(stance, &touch, at),
        };
        match two {
            Next::Touching(next, felt) => {
                Next::Touching(Touch { clear: next.clear.max(RETRY * self.length), ..next }, felt)
            }
            // Tried again once it has moved on.
            _ => Next::Touching(Touch { clear: RETRY * self.length, ..touch }, felt),
        }
    }
}
