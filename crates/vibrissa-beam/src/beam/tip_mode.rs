//! Tip mode: the tip's place is known.

use super::bend::Bend;
use super::rod::Rod;
use super::whisker::Whisker;
use crate::error::Result;
use crate::plane::Vec2;
use alloc::vec::Vec;

/// Every first-mode equilibrium whose tip is at `tip` (m, whisker frame) under a force there, least energy first.
///
/// The force's direction is part of the answer: [`Bend::force_vector`]. Where it is parallel to the normal of what the
/// tip touches, contact is frictionless. Forces up to forty times the one that bends the whisker by a radian are searched,
/// which leaves out tips that a pull has all but straightened.
///
/// # Errors
/// Usage: a tip that is not finite or at the base, or one so near to it that no number holds the force. Data: a whisker that makes no sense, see [`Rod::new`].
pub fn tip_mode(whisker: &Whisker, tip: Vec2) -> Result<Vec<Bend>> {
    Rod::new(whisker)?.tip_mode(tip)
}
