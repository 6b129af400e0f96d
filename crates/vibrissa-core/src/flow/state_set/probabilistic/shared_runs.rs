//! Memoised runs: cells on straight walls that touch at the same angle share one result.
//!
//! As long as the tip stays on one straight piece it does not matter where along it, or which. One cell of each heading is run
//! through the readings, and what it comes to is moved to the others whose tip stays on their piece, too. The same holds later
//! for hypotheses along one wall that wait to be relinearised by the same step.

use super::hypothesis::{GaussianHypothesis, MeasurementModel};
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
pub(super) struct WallContact {
    piece: u32,
    /// From the start of the piece, and its length (m).
    along: f64,
    length: f64,
    spot: Spot,
}

impl WallContact {
    /// The place of a piece; none if it is not straight.
    pub(super) fn new(ground: &Boundaries, piece: u32, at: f64) -> Option<Self> {
        let here = &ground.pieces[piece as usize];
        let straight = Self { piece, along: at * here.length(), length: here.length(), spot: here.spot(at) };
        here.is_straight().then_some(straight)
    }

    /// The same for the place from which a hypothesis is followed.
    pub(super) fn of(ground: &Boundaries, h: &GaussianHypothesis) -> Option<Self> {
        let (piece, at) = h.start_piece()?;
        Self::new(ground, piece, at)
    }

    fn frame(&self) -> Pose2 {
        Pose2 { x: self.spot.position.x, y: self.spot.position.y, theta: self.spot.normal }
    }
}

/// How far along its piece a tip has been (m, from where it began), as long as it stays there.
#[derive(Clone, Copy)]
pub(super) struct ContactExtent {
    from: WallContact,
    reach: Option<[f64; 2]>,
}

impl ContactExtent {
    /// Nothing yet; only robots with a single sense are followed so.
    pub(super) fn new(from: Option<WallContact>, model: &MeasurementModel<'_>) -> Option<Self> {
        from.filter(|_| model.sensors.len() == 1).map(|from| Self { from, reach: Some([0.0; 2]) })
    }

    /// Takes in where the tip is now.
    pub(super) fn add(&mut self, h: &GaussianHypothesis) {
        let now = h.states.first().and_then(|state| state.on_piece()).filter(|on| on.0 == self.from.piece);
        self.reach = self.reach.zip(now).map(|([low, high], (_, at))| {
            let off = at * self.from.length - self.from.along;
            [low.min(off), high.max(off)]
        });
    }
}

/// What a cell has come to.
pub(super) struct SharedRun {
    from: WallContact,
    reach: [f64; 2],
    /// Its heading from the boundary's normal (rad).
    heading: f64,
    outcome: Option<GaussianHypothesis>,
}

impl SharedRun {
    /// What is kept of a cell that has never left its piece.
    pub(super) fn new(span: Option<ContactExtent>, heading: f64, outcome: Option<&GaussianHypothesis>) -> Option<Self> {
        let ContactExtent { from, reach } = span?;
        let heading = wrap_angle(heading - from.spot.normal);
        Some(Self { from, reach: reach?, heading, outcome: outcome.cloned() })
    }

    /// What a cell comes to that begins there with this heading (map frame); none if that is not the same.
    pub(super) fn at(&self, to: &WallContact, heading: f64) -> Option<Option<GaussianHypothesis>> {
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
pub(super) enum ContactTrack {
    Nowhere,
    On(u32, [f64; 2]),
    Elsewhere,
}

impl ContactTrack {
    /// Takes in where the whiskers of a hypothesis are now.
    pub(super) fn add(&mut self, model: &MeasurementModel<'_>, h: &GaussianHypothesis) {
        let [state] = h.states.as_slice() else {
            *self = Self::Elsewhere;
            return;
        };
        *self = match (*self, state.on_piece()) {
            (was, None) if *state == WhiskerState::Free => was,
            (Self::Nowhere, Some((piece, at))) if model.ground.pieces[piece as usize].is_straight() => {
                Self::On(piece, [at; 2])
            }
            (Self::On(piece, [low, high]), Some((now, at))) if now == piece => {
                Self::On(piece, [low.min(at), high.max(at)])
            }
            _ => Self::Elsewhere,
        };
    }
}

/// A hypothesis before it was relinearised.
#[derive(Clone, Copy)]
pub(super) struct RunKey {
    frame: Pose2,
    predicted: (f64, [f64; 3]),
}

impl RunKey {
    pub(super) fn of(h: &GaussianHypothesis) -> Self {
        Self { frame: h.map_from_odom, predicted: h.predicted }
    }

    /// What another comes to that was to be relinearised by the same step, where `outcome` is what this one has come to; none where that is not
    /// the same along its wall.
    pub(super) fn at(
        &self,
        ground: &Boundaries,
        track: ContactTrack,
        outcome: &GaussianHypothesis,
        other: &GaussianHypothesis,
    ) -> Option<GaussianHypothesis> {
        let ContactTrack::On(piece, [low, high]) = track else { return None };
        let (cost, d) = self.predicted;
        let (to, step) = other.predicted;
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
