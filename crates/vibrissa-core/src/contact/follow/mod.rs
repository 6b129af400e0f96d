//! The moment of a whisker in contact and its derivatives by the pose of its base, for estimation.
//!
//! Without friction, and of uniform whiskers at the tip (`tip`), the side (`side`) or both, or the side at two places (`both`), on an elastic base too
//! (`elastic_base`); of others at the tip alone. A contact is followed from pose to pose; what a free whisker meets is in `meet`, what one runs into
//! besides its contact in `surroundings`, and where one that snaps comes to rest in `snap`. `equilibria` has all in which it may be at a pose. Differentiating the
//! equations of the equilibrium gives `dh/d(x, y, theta)` for the price of one more solution of the same linear system.
//! Slightly negative forces, a whisker glued to the boundary, are kept: they tell in which direction a contact that
//! should be there is to be looked for.

mod balance;
mod bent;
mod both;
mod both_snap;
mod elastic_base;
mod equilibria;
mod mechanics;
mod meet;
mod side;
mod snap;
mod span;
mod state;
mod surroundings;
mod system;
mod tip;

use super::{Boundaries, Hold, SensedQuantity, Stance, Support};
use crate::plane::{Pose2, wrap_angle};
use crate::world::Map;
pub use bent::{Bending, BentWhisker, FeltMoment, Followed};
pub(crate) use elastic_base::ElasticBase;
pub(crate) use mechanics::Mechanics;
pub(crate) use state::{Contact, Prediction, WhiskerState};
use surroundings::Surroundings;

/// Largest travel of the base (whisker lengths, rad) in one step of the continuation.
const LARGEST_STEP: f64 = 0.028;
/// Largest travel of the tip along the boundary in such a step, and of its slope.
const LARGEST_SLIDE: f64 = 0.08;
const LARGEST_BEND: f64 = 0.35;
/// Largest change of the place along the whisker, over its length.
const LARGEST_PASS: f64 = 0.2;
/// How far any place of a whisker moves at most, over how far its base does and turns it; beyond a contact of the side, which it turns about,
/// by the arc length over that of the contact further.
const MOTION: f64 = 1.5;
/// How far a whisker moves (whisker lengths) before a bump that does not touch it is tried again.
const RETRY: f64 = 4e-3;
/// A step is halved this often before the whisker is said to have snapped.
const MOST_HALVINGS: u32 = 6;
/// Snaps on the way from one pose to the next before it is given up.
const MOST_SNAPS: u32 = 2;
/// Pull (dimensionless force) at which a glued whisker lets go: a gap of about 2.5 mm for the paper's whisker.
const LET_GO: f64 = -0.1;

/// What one step of the continuation found.
enum Next {
    Touching(Contact, Prediction),
    LetGo,
    None,
}

/// A whisker of known length on a map.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ForwardModel<'a> {
    pub(crate) map: &'a Map,
    pub(crate) boundaries: &'a Boundaries,
    /// The whisker's length (m).
    pub(crate) length: f64,
    /// How its equilibria are solved.
    pub(crate) mechanics: Mechanics<'a>,
    /// Whether the whole whisker is looked at, not only its contact.
    pub(crate) whole: bool,
    /// What is read.
    pub(crate) quantity: SensedQuantity,
    /// What yields under a uniform whisker that is not clamped; `mechanics` are those of the clamped one then.
    pub(crate) base: Option<ElasticBase>,
}

impl ForwardModel<'_> {
    /// Moves a whisker from one base pose to another (`map_from_whisker`) and tells what it feels there.
    ///
    /// A free whisker that is `wanted` in contact is glued to a boundary just out of its reach.
    pub(crate) fn advance(&self, state: &mut WhiskerState, from: Pose2, to: Pose2, wanted: bool) -> Prediction {
        match self.base {
            Some(base) => self.advance_on(base, state, (from, to), wanted),
            None => self.advance_clamped(state, from, to, wanted),
        }
    }

    fn advance_clamped(&self, state: &mut WhiskerState, from: Pose2, to: Pose2, wanted: bool) -> Prediction {
        let predicted = match *state {
            WhiskerState::Touching(touch) => self.slide(touch, from, to),
            WhiskerState::Free | WhiskerState::Unknown => None,
        };
        if let Some((touch, predicted)) = predicted {
            *state = WhiskerState::Touching(touch);
            return predicted;
        }
        let met = self.meet(from, to).or_else(|| if wanted { self.glue(to) } else { None });
        *state = met.map_or(WhiskerState::Free, |(state, _)| state);
        met.map_or(Prediction::default(), |(_, predicted)| predicted)
    }

    /// The touching whisker moved in steps that the continuation can take; none when it let go or snapped.
    fn slide(&self, mut touch: Contact, from: Pose2, to: Pose2) -> Option<(Contact, Prediction)> {
        let turn = wrap_angle(to.theta - from.theta);
        let way = ((to.position() - from.position()).norm_squared().sqrt() / self.length).max(turn.abs());
        let steps = if way <= LARGEST_STEP { 1.0 } else { (way / LARGEST_STEP).ceil().min(1e4) };
        let least = 1.0 / (steps * f64::from(1_u32 << MOST_HALVINGS));
        let (mut share, mut step) = (0.0, 1.0 / steps);
        let mut predicted = Prediction::default();
        let mut snaps = 0;
        while share < 1.0 {
            let target = if share + step > 1.0 - 1e-9 { 1.0 } else { share + step };
            let pose = if target >= 1.0 {
                to
            } else {
                let place = from.position() + (to.position() - from.position()) * target;
                Pose2 { x: place.x, y: place.y, theta: from.theta + target * turn }
            };
            touch.clear -= MOTION / touch.s.min(1.0) * (target - share) * way * self.length;
            match self.next(&touch, pose) {
                Next::Touching(next, now) => {
                    (touch, predicted, share) = (next, now, target);
                    step = (2.0 * step).min(1.0 / steps);
                }
                Next::LetGo => return None,
                Next::None => {
                    step *= 0.5;
                    if step < least {
                        snaps += 1;
                        (touch, predicted) = self.snapped(&touch, pose).filter(|_| snaps <= MOST_SNAPS)?;
                        (share, step) = (target, 1.0 / steps);
                    }
                }
            }
        }
        Some((touch, predicted))
    }

    /// The equilibrium after a small motion to `map_from_whisker`, near enough to the one before to be its
    /// continuation.
    fn next(&self, touch: &Contact, map_from_whisker: Pose2) -> Next {
        let stance = Stance::new(map_from_whisker, self.length);
        let next = match touch.hold {
            Hold::Tip(Support::Piece(piece, at)) => self.along(&stance, touch, piece, at, false),
            Hold::Tip(Support::Corner(id)) => self.caught(&stance, touch, id),
            Hold::Side(..) => self.on_side(&stance, *touch),
            Hold::Both(both) => self.on_both(&stance, both),
        };
        let near = |next: &Contact| {
            let outer_ended =
                matches!(touch.hold, Hold::Both(_)) && !matches!(next.hold, Hold::Both(_)) && next.s < touch.s;
            outer_ended
                || (next.place - touch.place).norm_squared() <= (LARGEST_SLIDE * self.length).powi(2)
                    && (next.s - touch.s).abs() <= LARGEST_PASS
                    && (next.slope - touch.slope).abs() <= LARGEST_BEND
        };
        match next {
            Next::Touching(next, _) if !near(&next) => Next::None,
            Next::Touching(next, _) if next.q < LET_GO => Next::LetGo,
            Next::Touching(next, predicted) => {
                self.cleared(&stance, Contact { clear: touch.clear + next.clear, ..next }, predicted)
            }
            other => other,
        }
    }

    /// Whether two contacts are followed: with the moment of uniform whiskers.
    fn follows_two(&self) -> bool {
        self.whole && self.quantity == SensedQuantity::Moment && !matches!(self.mechanics, Mechanics::Model(_))
    }

    /// The contact, or two where the rest of the whisker has come to a boundary.
    fn cleared(&self, stance: &Stance, touch: Contact, predicted: Prediction) -> Next {
        let followed = self.follows_two();
        if followed && touch.q <= 0.0 {
            return self.beside(stance).unwrap_or(Next::Touching(touch, predicted));
        }
        if !followed || touch.clear > 0.0 || matches!(touch.hold, Hold::Both(_)) {
            return Next::Touching(touch, predicted);
        }
        let two = match self.surroundings(stance, &touch) {
            Surroundings::Clear(clear) => return Next::Touching(Contact { clear, ..touch }, predicted),
            Surroundings::Before(share, at) => self.propped(stance, &touch, share, at),
            Surroundings::Beyond(rest) => self.stopped(stance, &touch, rest),
        };
        match two {
            Next::Touching(next, predicted) => {
                Next::Touching(Contact { clear: next.clear.max(RETRY * self.length), ..next }, predicted)
            }
            // Tried again once it has moved on.
            _ => Next::Touching(Contact { clear: RETRY * self.length, ..touch }, predicted),
        }
    }
}
