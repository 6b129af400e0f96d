//! The forward model: the moment that a whisker feels at a pose, and its derivatives by that pose.
//!
//! The tip stands on a piece of the boundary, the frictionless force is normal there: three equations for force, tilt
//! and place, solved by Newton's method from the contact before. In a concave corner the place is given and the force
//! may have any direction between the two normals. Differentiating the equations gives `dh/d(x, y, theta)` for the
//! price of one more solution of the same linear system. Slightly negative forces, a whisker glued to the boundary, are
//! kept: they tell in which direction a contact that should be there is to be looked for.

use super::ground::Ground;
use crate::beam::{TipChart, TipModel, TipTable, tip_chart};
use crate::plane::{Pose2, Vec2, wrap_angle};
use crate::world::Map;
use core::f64::consts::FRAC_PI_2;

/// Newton steps before an equilibrium is given up.
const MOST_STEPS: usize = 12;
/// Largest change of the tilt in one Newton step (rad).
const LARGEST_TURN: f64 = 0.3;
/// Forces nearer than this to the whisker's own direction are not followed (rad): it buckles.
const HEAD_ON: f64 = 0.07;
/// Pieces that one step may pass.
const MOST_PIECES: usize = 40;
/// Newton steps that may lead from piece to piece without an equilibrium on those between.
const HOPS: usize = 2;
/// How far beyond its ends a piece still counts (share of the piece).
const END_SLACK: f64 = 1e-9;
/// Largest travel of the base (whisker lengths, rad) in one step of the continuation.
const LARGEST_STEP: f64 = 0.025;
/// Largest travel of the tip along the boundary in such a step, and of its slope.
const LARGEST_SLIDE: f64 = 0.08;
const LARGEST_BEND: f64 = 0.35;
/// A step is halved this often before the whisker is said to have snapped.
const MOST_HALVINGS: u32 = 6;
/// Below this force a corner is solved from the small-angle solution on.
const WEAK: f64 = 0.02;
/// Halvings that find where a free whisker began to touch.
const MEET_HALVINGS: usize = 12;
/// Over how large a gap a whisker is glued, over its length.
const GLUE: f64 = 0.02;
/// Pull (dimensionless force) at which a glued whisker lets go: a gap of about 2.5 mm for the paper's whisker.
const LET_GO: f64 = -0.1;

/// What holds the tip.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Hold {
    /// A place on a piece.
    Piece(u32, f64),
    /// The corner at the end of a piece.
    Corner(u32),
}

/// A tip on a boundary.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Touch {
    /// Dimensionless force; negative while the whisker is glued across a small gap.
    pub(super) q: f64,
    /// Tilt of the force from the whisker's normal at the tip (rad).
    pub(super) beta: f64,
    hold: Hold,
    /// The tip (m), map frame.
    pub(super) tip: Vec2,
    /// The slope of the whisker there (rad).
    pub(super) slope: f64,
}

/// The moment that a pose of the whisker makes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Felt {
    /// Dimensionless moment `M0 L / EI`; of a glued whisker the moment that its pull would make.
    pub(super) moment: f64,
    /// Its derivatives by the whisker base's x, y (1/m, map frame) and heading (1/rad).
    pub(super) gradient: [f64; 3],
}

/// How a whisker stands to the map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum State {
    /// Straight, touching nothing.
    Free,
    /// With its tip on a boundary.
    Touching(Touch),
    /// In a contact that is not of the tip: what it feels is not known.
    Unknown,
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
    /// From the table of a whisker that is not uniform.
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

    /// Residual (whisker lengths, rad) from which one more Newton step ends the search; the error left is about its
    /// square.
    fn near(&self) -> f64 {
        match self {
            Self::Exact | Self::Table(_) => 2e-5,
            Self::Quick(_) => 1e-2,
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

    /// The derivatives of the equations `gap`, `aslant` by the base, dotted with the adjoint `l`, negated.
    fn gradient(&self, l: [f64; 3], target: Vec2) -> [f64; 3] {
        let (a, b) = (l[0] * self.per_length, l[1] * self.per_length);
        let turned = target.perp();
        [-(a * self.cos - b * self.sin), -(a * self.sin + b * self.cos), -(l[0] * turned.x + l[1] * turned.y + l[2])]
    }
}

impl Forward<'_> {
    /// The tip just touching at a place of a piece, before any force.
    pub(super) fn untouched(&self, piece: u32, at: f64, heading: f64) -> Touch {
        let spot = self.ground.pieces[piece as usize].spot(at);
        let beta = wrap_angle(spot.normal - heading - FRAC_PI_2);
        Touch { q: 0.0, beta, hold: Hold::Piece(piece, at), tip: spot.position, slope: 0.0 }
    }

    /// The tip loaded at a place of a piece, as another computation found it.
    pub(super) fn loaded(&self, piece: u32, at: f64, q: f64, beta: f64, slope: f64) -> Touch {
        let tip = self.ground.pieces[piece as usize].spot(at).position;
        Touch { q, beta, hold: Hold::Piece(piece, at), tip, slope }
    }

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

    /// The free whisker at `to`: a tip contact if it crosses a boundary near its tip, an unknown one elsewhere.
    fn meet(&self, from: Pose2, to: Pose2) -> Option<(State, Felt)> {
        let tip = |pose: Pose2| pose.transform_point(Vec2::new(self.length, 0.0));
        let end = tip(to);
        if !self.map.crosses(to.position(), end) {
            return None;
        }
        let travel = tip(from).distance(end).max(from.position().distance(to.position()));
        let turn = wrap_angle(to.theta - from.theta);
        let at_share = |share: f64| {
            let place = from.position() + (to.position() - from.position()) * share;
            Pose2 { x: place.x, y: place.y, theta: from.theta + share * turn }
        };
        let (mut free, mut touching) = (0.0, 1.0);
        for _ in 0..MEET_HALVINGS {
            let middle = 0.5 * (free + touching);
            let pose = at_share(middle);
            if self.map.crosses(pose.position(), tip(pose)) { touching = middle } else { free = middle }
        }
        let pose = at_share(touching);
        let reach = 0.1 * travel + 0.02 * self.length;
        let onset = self.ground.nearest(self.map, tip(pose), pose.position(), reach);
        let slid = onset.and_then(|(piece, at, _)| self.slide(self.untouched(piece, at, pose.theta), pose, to));
        let met = slid.map(|(touch, felt)| (State::Touching(touch), felt));
        Some(met.unwrap_or((State::Unknown, Felt::default())))
    }

    /// The free whisker at `to` glued to the boundary that its tip almost reaches.
    fn glue(&self, to: Pose2) -> Option<(State, Felt)> {
        let tip = to.transform_point(Vec2::new(self.length, 0.0));
        let (piece, at, _) = self.ground.nearest(self.map, tip, to.position(), GLUE * self.length)?;
        match self.next(&self.untouched(piece, at, to.theta), to) {
            Next::Touching(touch, felt) => Some((State::Touching(touch), felt)),
            _ => None,
        }
    }

    /// The touching whisker moved in steps that the continuation can take; none when it let go or snapped.
    fn slide(&self, mut touch: Touch, from: Pose2, to: Pose2) -> Option<(Touch, Felt)> {
        let turn = wrap_angle(to.theta - from.theta);
        let way = ((to.position() - from.position()).norm_squared().sqrt() / self.length).max(turn.abs());
        let steps = (way / LARGEST_STEP).ceil().clamp(1.0, 1e4);
        let least = 1.0 / (steps * f64::from(1_u32 << MOST_HALVINGS));
        let (mut share, mut step) = (0.0, 1.0 / steps);
        let mut felt = Felt::default();
        while share < 1.0 {
            let target = if share + step > 1.0 - 1e-9 { 1.0 } else { share + step };
            let pose = if target >= 1.0 {
                to
            } else {
                let place = from.position() + (to.position() - from.position()) * target;
                Pose2 { x: place.x, y: place.y, theta: from.theta + target * turn }
            };
            match self.next(&touch, pose) {
                Next::Touching(next, now) => {
                    (touch, felt, share) = (next, now, target);
                    step = (2.0 * step).min(1.0 / steps);
                }
                Next::LetGo => return None,
                Next::None => {
                    step *= 0.5;
                    if step < least {
                        return None;
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
            Hold::Piece(piece, at) => self.along(&stance, touch, piece, at),
            Hold::Corner(piece) => self.caught(&stance, touch, piece),
        };
        match next {
            Next::Touching(next, _)
                if (next.tip - touch.tip).norm_squared() > (LARGEST_SLIDE * self.length).powi(2)
                    || (next.slope - touch.slope).abs() > LARGEST_BEND =>
            {
                Next::None
            }
            Next::Touching(next, _) if next.q < LET_GO => Next::LetGo,
            other => other,
        }
    }

    /// From piece to piece until one holds the tip.
    fn along(&self, stance: &Stance, start: &Touch, mut piece: u32, mut at: f64) -> Next {
        let mut came: Option<bool> = None;
        let mut load = (start.q, start.beta);
        for _ in 0..MOST_PIECES {
            let (end, found) = match self.on_piece(stance, load.0, load.1, piece, at, came.is_none()) {
                OnPiece::Found { piece: on, at, touch, felt } => {
                    load = (touch.q, touch.beta);
                    piece = on;
                    (at, Some((touch, felt)))
                }
                OnPiece::Lost(on, at) => {
                    piece = on;
                    (at, None)
                }
                OnPiece::Failed => return Next::None,
            };
            if (-END_SLACK..=1.0 + END_SLACK).contains(&end) {
                return found.map_or(Next::None, |(touch, felt)| Next::Touching(touch, felt));
            }
            let forward = end > 0.5;
            let here = &self.ground.pieces[piece as usize];
            let before = if forward { Some(piece) } else { here.before };
            let Some((before, joint)) = before.and_then(|b| Some((b, self.ground.pieces[b as usize].joint?))) else {
                return Next::LetGo;
            };
            if came.is_some_and(|came| came != forward) {
                return Next::None;
            }
            if joint.concave
                && let Some((touch, felt, lean)) = self.in_corner(stance, start, before)
            {
                match lean {
                    0.0..=1.0 => return Next::Touching(touch, felt),
                    _ if (lean > 1.0) != forward => return Next::None,
                    _ => {}
                }
            }
            came = Some(forward);
            (piece, at) = if forward { (joint.next, 0.0) } else { (before, 1.0) };
        }
        Next::None
    }

    /// In the corner, or out of it along one of its sides.
    fn caught(&self, stance: &Stance, touch: &Touch, before: u32) -> Next {
        match self.in_corner(stance, touch, before) {
            Some((.., lean)) if lean < 0.0 => self.along(stance, touch, before, 1.0),
            Some((.., lean)) if lean > 1.0 => match self.ground.pieces[before as usize].joint {
                Some(joint) => self.along(stance, touch, joint.next, 0.0),
                None => Next::None,
            },
            Some((touch, felt, _)) => Next::Touching(touch, felt),
            None => Next::None,
        }
    }

    /// The equilibrium with the tip on a piece, from this load and place on; where `hopping`, on the piece to which the
    /// first steps lead over slight corners.
    fn on_piece(
        &self,
        stance: &Stance,
        mut q: f64,
        mut beta: f64,
        mut piece: u32,
        mut at: f64,
        hopping: bool,
    ) -> OnPiece {
        let mut ground = &self.ground.pieces[piece as usize];
        for step in 0..MOST_STEPS {
            let Some(tip) = self.solver.chart(q, beta) else { return OnPiece::Failed };
            let spot = ground.spot(at);
            let target = stance.seen(spot.position - stance.base);
            let velocity = stance.seen(spot.velocity);
            let gap = tip.position - target;
            let aslant = wrap_angle(stance.theta + tip.slope + beta + FRAC_PI_2 - spot.normal);
            let system = System::new([
                [tip.by_force.position.x, tip.by_tilt.position.x, -velocity.x],
                [tip.by_force.position.y, tip.by_tilt.position.y, -velocity.y],
                [tip.by_force.slope, 1.0 + tip.by_tilt.slope, -spot.turning],
            ]);
            let Some([dq, dbeta, dat]) = system.solve([gap.x, gap.y, aslant]) else { return OnPiece::Failed };
            let damp = damping(q, dq, dbeta);
            (q, beta, at) = (q - damp * dq, beta - damp * dbeta, at - damp * dat);
            if hopping && step < HOPS && !(0.0..=1.0).contains(&at) && damp >= 1.0 {
                let (on, there) = self.ground.hop(piece, at);
                if on != piece {
                    (piece, at) = (on, there);
                    ground = &self.ground.pieces[piece as usize];
                    continue;
                }
            }
            if ground.is_lost(at) {
                return OnPiece::Lost(piece, at);
            }
            if !q.is_finite() || is_head_on(beta) {
                return OnPiece::Failed;
            }
            if gap.norm_squared().sqrt().max(aslant.abs()) < self.solver.near() && damp >= 1.0 {
                // Weak forces have a negative determinant and are stable; the sign changes where the branch folds.
                if system.determinant * ground.side >= 0.0 {
                    return OnPiece::Failed;
                }
                let adjoint = system.solve_transposed([tip.by_force.moment, tip.by_tilt.moment, 0.0]);
                let tip_now = spot.position - spot.velocity * dat;
                let touch = Touch { hold: Hold::Piece(piece, at), tip: tip_now, ..settled(&tip, q, beta, dq, dbeta) };
                let felt = Felt { moment: corrected(&tip, dq, dbeta), gradient: stance.gradient(adjoint, target) };
                return OnPiece::Found { piece, at, touch, felt };
            }
        }
        OnPiece::Failed
    }

    /// The equilibrium with the tip in the corner at the end of a piece, and where its force points within the corner:
    /// 0 along the normal before, 1 along the normal after.
    fn in_corner(&self, stance: &Stance, from: &Touch, before: u32) -> Option<(Touch, Felt, f64)> {
        let joint = self.ground.pieces[before as usize].joint?;
        let target = stance.seen(joint.position - stance.base);
        let (mut q, mut beta) = (from.q, from.beta);
        if q.abs() < WEAK {
            // A weak force can point anywhere without moving the tip much: start from the small-angle solution.
            beta = wrap_angle(joint.normal + 0.5 * joint.turn - stance.theta - FRAC_PI_2);
            q = 3.0 * target.y / beta.cos();
        }
        for _ in 0..MOST_STEPS {
            let tip = self.solver.chart(q, beta)?;
            let gap = tip.position - target;
            let (a, b) = (tip.by_force.position, tip.by_tilt.position);
            let det = a.cross(b);
            let (dq, dbeta) = (gap.cross(b) / det, a.cross(gap) / det);
            let damp = damping(q, dq, dbeta);
            (q, beta) = (q - damp * dq, beta - damp * dbeta);
            if !q.is_finite() || is_head_on(beta) {
                return None;
            }
            if gap.norm_squared().sqrt() < self.solver.near() && damp >= 1.0 {
                let (m, n) = (tip.by_force.moment, tip.by_tilt.moment);
                let adjoint = [(m * b.y - n * a.y) / det, (n * a.x - m * b.x) / det, 0.0];
                let settled = settled(&tip, q, beta, dq, dbeta);
                let direction = stance.theta + settled.slope + beta + FRAC_PI_2;
                let lean = wrap_angle(direction - joint.normal) / joint.turn;
                let touch = Touch { hold: Hold::Corner(before), tip: joint.position, ..settled };
                let felt = Felt { moment: corrected(&tip, dq, dbeta), gradient: stance.gradient(adjoint, target) };
                return Some((touch, felt, lean));
            }
        }
        None
    }
}

/// Where Newton's method on a piece ended.
enum OnPiece {
    /// An equilibrium, maybe on the continuation of the piece.
    Found { piece: u32, at: f64, touch: Touch, felt: Felt },
    /// The place left the piece before an equilibrium was found.
    Lost(u32, f64),
    /// No stable equilibrium near.
    Failed,
}

fn damping(q: f64, dq: f64, dbeta: f64) -> f64 {
    (LARGEST_TURN / dbeta.abs()).min((0.5 + 0.5 * q.abs()) / dq.abs()).min(1.0)
}

/// Whether the force all but runs along the whisker at its tip.
fn is_head_on(beta: f64) -> bool {
    let off = (wrap_angle(beta).abs() - FRAC_PI_2).abs();
    off.is_nan() || off <= HEAD_ON
}

/// The moment after the last Newton step.
fn corrected(tip: &TipChart, dq: f64, dbeta: f64) -> f64 {
    tip.moment - tip.by_force.moment * dq - tip.by_tilt.moment * dbeta
}

/// Load and slope after the last Newton step; the caller says what holds the tip.
fn settled(tip: &TipChart, q: f64, beta: f64, dq: f64, dbeta: f64) -> Touch {
    let slope = tip.slope - tip.by_force.slope * dq - tip.by_tilt.slope * dbeta;
    Touch { q, beta, hold: Hold::Piece(0, 0.0), tip: Vec2::ZERO, slope }
}

/// Three linear equations, by cofactors.
struct System {
    cofactors: [[f64; 3]; 3],
    determinant: f64,
}

impl System {
    fn new(m: [[f64; 3]; 3]) -> Self {
        let c = |i: usize, j: usize| {
            let (a, b) = ((i + 1) % 3, (i + 2) % 3);
            let (d, e) = ((j + 1) % 3, (j + 2) % 3);
            m[a][d] * m[b][e] - m[a][e] * m[b][d]
        };
        let cofactors = [[c(0, 0), c(0, 1), c(0, 2)], [c(1, 0), c(1, 1), c(1, 2)], [c(2, 0), c(2, 1), c(2, 2)]];
        let determinant = (0..3).map(|j| m[0][j] * cofactors[0][j]).sum();
        Self { cofactors, determinant }
    }

    /// `x` with `M x = r`; none when it is not finite.
    fn solve(&self, r: [f64; 3]) -> Option<[f64; 3]> {
        let per = 1.0 / self.determinant;
        let x = [0, 1, 2].map(|j| per * (0..3).map(|i| self.cofactors[i][j] * r[i]).sum::<f64>());
        x.iter().all(|v| v.is_finite()).then_some(x)
    }

    /// `l` with `Mᵀ l = r`.
    fn solve_transposed(&self, r: [f64; 3]) -> [f64; 3] {
        let per = 1.0 / self.determinant;
        [0, 1, 2].map(|i| per * (0..3).map(|j| self.cofactors[i][j] * r[j]).sum::<f64>())
    }
}
