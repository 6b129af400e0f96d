//! Cells on straight walls: what one of them comes to, all come to that touch at the same angle.
//!
//! As long as the tip stays on one straight piece it does not matter where along it, or which. One cell of each heading is run
//! through the readings, and what it comes to is moved to the others whose tip stays on their piece, too. The same holds later
//! for hypotheses along one wall that wait to be run anew by the same step.

use super::hypothesis::{Hypothesis, Scene};
use crate::contact::follow::WhiskerState;
use crate::contact::{Boundaries, Spot};
use crate::plane::{Pose2, wrap_angle};

/// How far from the ends of a piece its middle counts (m), and how equal two headings are (rad).
const END: f64 = 1e-6;
const EQUAL: f64 = 1e-9;
/// How equal what two cost is (nats).
const ALIKE: f64 = 1e-4;

/// Where on a straight piece the tip was when the contact began.
#[derive(Clone, Copy)]
pub(super) struct Straight {
    piece: u32,
    /// From the start of the piece, and its length (m).
    along: f64,
    length: f64,
    spot: Spot,
}

impl Straight {
    /// The place of a piece; none if it is not straight.
    pub(super) fn new(ground: &Boundaries, piece: u32, at: f64) -> Option<Self> {
        let here = &ground.pieces[piece as usize];
        let straight = Self { piece, along: at * here.length(), length: here.length(), spot: here.spot(at) };
        here.is_straight().then_some(straight)
    }

    /// The same for the place from which a hypothesis is followed.
    pub(super) fn of(ground: &Boundaries, h: &Hypothesis) -> Option<Self> {
        let (piece, at) = h.begins_on()?;
        Self::new(ground, piece, at)
    }

    fn frame(&self) -> Pose2 {
        Pose2 { x: self.spot.position.x, y: self.spot.position.y, theta: self.spot.normal }
    }
}

/// How far along its piece a tip has been (m, from where it began), as long as it stays there.
#[derive(Clone, Copy)]
pub(super) struct Span {
    from: Straight,
    reach: Option<[f64; 2]>,
}

impl Span {
    /// Nothing yet; only robots with a single sense are followed so.
    pub(super) fn new(from: Option<Straight>, scene: &Scene<'_>) -> Option<Self> {
        from.filter(|_| scene.feelers.len() == 1).map(|from| Self { from, reach: Some([0.0; 2]) })
    }

    /// Takes in where the tip is now.
    pub(super) fn add(&mut self, h: &Hypothesis) {
        let now = h.states.first().and_then(|state| state.on_piece()).filter(|on| on.0 == self.from.piece);
        self.reach = self.reach.zip(now).map(|([low, high], (_, at))| {
            let off = at * self.from.length - self.from.along;
            [low.min(off), high.max(off)]
        });
    }
}

/// What a cell has come to.
pub(super) struct Twin {
    from: Straight,
    reach: [f64; 2],
    /// Its heading from the boundary's normal (rad).
    heading: f64,
    outcome: Option<Hypothesis>,
}

impl Twin {
    /// What is kept of a cell that has never left its piece.
    pub(super) fn new(span: Option<Span>, heading: f64, outcome: Option<&Hypothesis>) -> Option<Self> {
        let Span { from, reach } = span?;
        let heading = wrap_angle(heading - from.spot.normal);
        Some(Self { from, reach: reach?, heading, outcome: outcome.cloned() })
    }

    /// What a cell comes to that begins there with this heading (map frame); none if that is not the same.
    pub(super) fn at(&self, to: &Straight, heading: f64) -> Option<Option<Hypothesis>> {
        let stays = to.along + self.reach[0] > END && to.along + self.reach[1] < to.length - END;
        let equal = wrap_angle(heading - to.spot.normal - self.heading).abs() < EQUAL;
        (stays && equal).then(|| {
            let motion = to.frame().compose(self.from.frame().inverse());
            let moved = |(piece, at): (u32, f64)| {
                debug_assert_eq!(piece, self.from.piece);
                (to.piece, (at * self.from.length - self.from.along + to.along) / to.length)
            };
            self.outcome.as_ref().map(|h| h.slid(motion, &moved))
        })
    }
}

/// Where a tip has been in a run, apart from rows without contact: on one straight piece between these parameters, or elsewhere, too.
#[derive(Clone, Copy, Debug)]
pub(super) enum Track {
    Nowhere,
    On(u32, [f64; 2]),
    Elsewhere,
}

impl Track {
    /// Takes in where the whiskers of a hypothesis are now.
    pub(super) fn add(&mut self, scene: &Scene<'_>, h: &Hypothesis) {
        let [state] = h.states.as_slice() else {
            *self = Self::Elsewhere;
            return;
        };
        *self = match (*self, state.on_piece()) {
            (was, None) if *state == WhiskerState::Free => was,
            (Self::Nowhere, Some((piece, at))) if scene.ground.pieces[piece as usize].is_straight() => {
                Self::On(piece, [at; 2])
            }
            (Self::On(piece, [low, high]), Some((now, at))) if now == piece => {
                Self::On(piece, [low.min(at), high.max(at)])
            }
            _ => Self::Elsewhere,
        };
    }
}

/// A hypothesis before it was run anew.
#[derive(Clone, Copy)]
pub(super) struct Before {
    frame: Pose2,
    promise: (f64, [f64; 3]),
}

impl Before {
    pub(super) fn of(h: &Hypothesis) -> Self {
        Self { frame: h.map_from_odom, promise: h.promise }
    }

    /// What another comes to that was to be run anew by the same step, where `outcome` is what this one has come to; none where that is not
    /// the same along its wall.
    pub(super) fn at(
        &self,
        ground: &Boundaries,
        track: Track,
        outcome: &Hypothesis,
        other: &Hypothesis,
    ) -> Option<Hypothesis> {
        let Track::On(piece, [low, high]) = track else { return None };
        let (cost, d) = self.promise;
        let (to, step) = other.promise;
        let equal = |a: f64, b: f64| (a - b).abs() <= EQUAL * (1.0 + a.abs());
        let same = wrap_angle(other.map_from_odom.theta - self.frame.theta).abs() < EQUAL
            && (cost - to).abs() < ALIKE
            && (0..3).all(|i| equal(d[i], step[i]));
        let shift = other.map_from_odom.position() - self.frame.position();
        let here = &ground.pieces[piece as usize];
        let spot = here.spot(0.0);
        let along = spot.velocity.dot(shift) / here.length();
        let stays = low * here.length() + along > END && high * here.length() + along < here.length() - END;
        if !same || !stays || (spot.velocity.cross(shift) / here.length()).abs() > END {
            return None;
        }
        let motion = Pose2 { x: shift.x, y: shift.y, theta: 0.0 };
        Some(outcome.slid(motion, &|(on, at)| (on, at + along / here.length())))
    }
}
