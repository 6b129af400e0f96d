//! Memoised runs: cells on straight walls that touch at the same angle share one result.
//!
//! As long as the tip stays on one straight piece it does not matter where along it, or which. One cell of each heading is run
//! through the readings, and what it comes to is moved to the others whose tip stays on their piece, too.

use super::grid_search::Cell;
use crate::contact::follow::WhiskerState;
use crate::contact::{Boundaries, Spot};
use crate::plane::{Pose2, wrap_angle};

/// How far from the ends of a piece its middle counts (m), and how equal two headings are (rad).
const END: f64 = 1e-6;
const EQUAL: f64 = 1e-9;

/// Where on a straight piece a tip is when a contact begins.
#[derive(Clone, Copy)]
pub(super) struct WallContact {
    piece: u32,
    /// From the start of the piece, and its length (m).
    along: f64,
    length: f64,
    spot: Spot,
}

impl WallContact {
    /// Where the tip is; none if that is not on a straight piece.
    pub(super) fn of(ground: &Boundaries, state: &WhiskerState) -> Option<Self> {
        let (piece, at) = state.on_piece()?;
        let here = &ground.pieces[piece as usize];
        let straight = Self { piece, along: at * here.length(), length: here.length(), spot: here.spot(at) };
        here.is_straight().then_some(straight)
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
    /// Whether that was not known at times: what such a cell dies of is not the wall's alone.
    has_buckled: bool,
}

impl ContactExtent {
    pub(super) fn new(from: WallContact) -> Self {
        Self { from, reach: Some([0.0; 2]), has_buckled: false }
    }

    /// Takes in where the tip is now, if that is known.
    pub(super) fn add(&mut self, state: &WhiskerState) {
        if matches!(state, WhiskerState::Unknown) {
            self.has_buckled = true;
            return;
        }
        let now = state.on_piece().filter(|on| on.0 == self.from.piece);
        self.reach = self.reach.zip(now).map(|([low, high], (_, at))| {
            let off = at * self.from.length - self.from.along;
            [low.min(off), high.max(off)]
        });
    }
}

/// What a cell has come to.
#[derive(Clone)]
pub(super) struct SharedRun {
    from: WallContact,
    reach: [f64; 2],
    /// Its heading from the boundary's normal (rad).
    heading: f64,
    outcome: Option<Cell>,
}

impl SharedRun {
    /// What is kept of a cell with this heading that has never left its piece.
    pub(super) fn new(extent: Option<ContactExtent>, heading: f64, outcome: Option<&Cell>) -> Option<Self> {
        let ContactExtent { from, reach, .. } = extent.filter(|extent| outcome.is_some() || !extent.has_buckled)?;
        let heading = wrap_angle(heading - from.spot.normal);
        Some(Self { from, reach: reach?, heading, outcome: outcome.cloned() })
    }

    /// What a cell comes to that begins there with this heading (map frame); none if that is not the same.
    pub(super) fn at(&self, to: &WallContact, heading: f64) -> Option<Option<Cell>> {
        let stays = to.along + self.reach[0] > END && to.along + self.reach[1] < to.length - END;
        let equal = wrap_angle(heading - to.spot.normal - self.heading).abs() < EQUAL;
        (stays && equal).then(|| {
            let motion = to.frame().compose(self.from.frame().inverse());
            let moved =
                |(_, at): (u32, f64)| (to.piece, (at * self.from.length - self.from.along + to.along) / to.length);
            self.outcome.as_ref().map(|cell| cell.moved(motion, &moved))
        })
    }
}
