//! The same table for any rod: tapered, of several wires, curved at rest.
//!
//! A rod has no scaling law. All contacts of its tip are the image of the pairs (tilt of the force, its size), those of its
//! side that of (arc length, size of the force): one march of the equilibrium equations for each, without a search, so that no
//! branch is missed. Trees of patches cover the pairs; a patch tells its contacts by direction and moment with a bound on what
//! that leaves, from the deviation at its middle and at those of its edges, as [`PressTable`](super::PressTable) has it.
//! Loads under which the energy's second variation is negative, however the contact is held, are left out: there no whisker
//! stays. So are shapes that turn by more than a radian within the first 0.4 % of the length, which no wire stands. Those of the tip under which it is negative unless the contact is held count as shapes with an inflection do.

use super::forest::{Forest, MOST_PATCHES, NEAREST, RodContact, RodKind};
use super::patch::{Patch, PatchPart};
use super::slice::{PressEntry, PressSlice};
use crate::beam::Whisker;
use crate::beam::rod::Rod;
use crate::beam::stretch::{Stretch, Stretches};
use crate::error::Result;
use crate::plane::Vec2;
use alloc::vec::Vec;
use core::f64::consts::{FRAC_PI_2, PI, TAU};
#[cfg(not(feature = "std"))]
use num_traits::Float as _;

/// Half of the range of tilts that side contacts with friction take together (rad).
const LEAN: f64 = 0.14;
/// Contacts of one bucket are taken together up to this radius, over what the patches leave.
const JOINED: f64 = 1.0;
/// And, whatever their radius, where there are so many of them already.
const MOST_TOGETHER: usize = 10;
/// Then each is compared with so many of the last.
const COMPARED: usize = 4;
/// In tables of no more buckets than this contacts hardly move along the whisker with the direction: wide cells meet them.
const COARSE: usize = 64;
const STEEPEST: f64 = 1.5;
/// Patches whose range of moments is known together.
const BLOCK: usize = 16;
/// A slope or curvature near the base may be larger by this share than where it is reckoned from.
const NEAR_MARGIN: f64 = 1.2;

/// All contacts of a rod, as far as tables of it were asked for.
#[derive(Clone, Debug)]
pub struct RodContacts {
    slack: f64,
    /// Those that push the contact to the whisker's left, and to the right; of a straight rod these are alike.
    sides: Vec<Vec<Forest>>,
    near: NearBase,
}

/// What bends a rod near its base.
#[derive(Clone, Copy, Debug)]
struct NearBase {
    /// No less than its compliance and its curvature there.
    compliance: f64,
    curvature: f64,
}

/// One rod's contacts with walls of every direction.
#[derive(Clone, Debug)]
pub struct RodPressTable {
    slack: f64,
    buckets: usize,
    /// What its patches leave, but for the widest.
    width: f64,
    sides: Vec<Vec<Patch>>,
    blocks: Vec<Vec<(f64, f64)>>,
    near: NearBase,
}

impl RodContacts {
    /// The contacts of a whisker on a clamped base, whatever its own; with walls of this friction angle (rad, below 1) and slopes
    /// that differ by up to `steepest` from those at rest. Its length may be off by a share of `stretch`, which leaves its taper
    /// and the shares of its wires as they are, and its curvature at rest.
    ///
    /// No whisker exceeds half a turn without friction that gets no stiffer towards its tip and is straight at rest.
    ///
    /// # Errors
    /// Data: a whisker that makes no sense, see [`Rod::new`](crate::beam::Rod::new).
    pub fn new(whisker: &Whisker, friction_angle: f64, steepest: f64, stretch: f64) -> Result<Self> {
        let slack = friction_angle.clamp(0.0, 1.0);
        whisker.rod()?;
        let of = |scale: f64, sign: f64| Rod::clamped(&unit(whisker, scale, sign)?);
        let curved = curvature_bound(&unit(whisker, 1.0 + stretch, 1.0)?);
        let steepest = steepest.clamp(0.1, PI);
        let signs: &[f64] = if curved > 0.0 { &[1.0, -1.0] } else { &[1.0] };
        let mut sides = Vec::new();
        for &sign in signs {
            let rod = of(1.0, sign)?;
            let neighbours = if curved > 0.0 && stretch > 0.0 {
                [[of(1.0 - stretch, sign)?, of(1.0 + stretch, sign)?]].to_vec()
            } else {
                Vec::new()
            };
            let kind = |contact: RodContact, lean: f64| RodKind {
                rod: rod.clone(),
                neighbours: neighbours.clone(),
                contact,
                slack,
                lean,
                steepest,
            };
            let mut forests = [Forest::new(kind(RodContact::Tip, 0.0))].to_vec();
            let layers = (slack / LEAN).ceil().max(1.0) as usize;
            let lean = slack / layers as f64;
            for layer in 0..layers {
                let tilt = -slack + (2 * layer + 1) as f64 * lean;
                forests.push(Forest::new(kind(RodContact::Side(tilt), lean)));
            }
            sides.push(forests);
        }
        let straight = unit(whisker, 1.0, 1.0)?;
        let softest = (0..=64).map(|k| 1.0 / straight.rigidity_at(NEAREST * f64::from(k) / 64.0)).fold(0.0, f64::max);
        let near = NearBase { compliance: NEAR_MARGIN * softest, curvature: NEAR_MARGIN * curved };
        let mut all = Self { slack, sides, near };
        // Once for all tables: where the whisker can be.
        all.refine(f64::INFINITY);
        Ok(all)
    }

    /// Patches that leave no more than `width` of their contacts, over the length.
    pub fn refine(&mut self, width: f64) {
        self.refine_some(width, usize::MAX);
    }

    /// The same in pieces of so many bisections of patches, each of which takes some tenths of a millisecond; how many it has done, which
    /// are fewer at the end.
    pub fn refine_some(&mut self, width: f64, at_once: usize) -> usize {
        let mut done = 0;
        for forests in &mut self.sides {
            let most = MOST_PATCHES / forests.len();
            for forest in forests {
                done += forest.refine_some(width, most, at_once - done);
            }
        }
        done
    }

    /// A table with so many buckets of directions in a quarter turn, from patches that leave no more than `width`, where
    /// [`RodContacts::refine`] was asked for such, over the length.
    #[must_use]
    pub fn table(&self, buckets: usize, width: f64) -> RodPressTable {
        let of = |forests: &Vec<Forest>| -> Vec<Patch> {
            forests.iter().flat_map(|forest| forest.patches(width).copied()).collect()
        };
        let sides: Vec<Vec<Patch>> = self.sides.iter().map(of).collect();
        let hull = |block: &[Patch]| {
            let join = |all: (f64, f64), patch: &Patch| (all.0.min(patch.moments.0), all.1.max(patch.moments.1));
            block.iter().fold((f64::INFINITY, f64::NEG_INFINITY), join)
        };
        RodPressTable {
            slack: self.slack,
            buckets: 4 * buckets.max(1),
            width,
            blocks: sides.iter().map(|side| side.chunks(BLOCK).map(hull).collect()).collect(),
            sides,
            near: self.near,
        }
    }
}

/// The clamped whisker with unit length and unit rigidity at its base, curved as one that is longer by a factor, or as its
/// mirror image.
fn unit(whisker: &Whisker, scale: f64, sign: f64) -> Result<Whisker> {
    let (length, rigidity) = (whisker.length, whisker.flexural_rigidity);
    let stretches = whisker.stretches.as_slice();
    let one = |stretch: &Stretch| Stretch {
        length: stretch.length / length,
        flexural_rigidity: stretch.flexural_rigidity / rigidity,
        ..*stretch
    };
    let list: Vec<Stretch> = stretches.iter().map(one).collect();
    let [curvature, rise @ ..] = whisker.curvature_terms();
    let mut power = sign * length * scale;
    let curvature = curvature * power;
    let curvature_rise = rise.map(|term| {
        power *= length * scale;
        term * power
    });
    let stretches = if list.is_empty() { Stretches::default() } else { Stretches::new(&list)? };
    let length = if list.is_empty() { 1.0 } else { stretches.length() };
    Ok(Whisker {
        length,
        flexural_rigidity: 1.0,
        curvature,
        curvature_rise,
        base_stiffness: f64::INFINITY,
        stretches,
        ..*whisker
    })
}

/// No less than the curvature at rest anywhere, of a whisker of unit length.
fn curvature_bound(whisker: &Whisker) -> f64 {
    whisker.curvature_terms().iter().map(|term| term.abs()).sum()
}

impl RodPressTable {
    /// The friction angle (rad).
    #[must_use]
    pub fn friction_angle(&self) -> f64 {
        self.slack
    }

    /// How many patches it has.
    #[must_use]
    pub fn patches(&self) -> usize {
        self.sides.iter().map(Vec::len).sum()
    }

    /// The contacts that push to the left (`side` 1), or the mirror image of those that push to the right (-1), and cause a
    /// dimensionless moment between `lo` and `hi`, as that image has it.
    #[must_use]
    pub fn slice(&self, side: f64, lo: f64, hi: f64) -> PressSlice {
        let patches = if side > 0.0 { self.sides.first() } else { self.sides.last() };
        let width = TAU / self.buckets as f64;
        let of = |bucket: usize| ((bucket as f64 + 0.5) * width, 0.5 * width);
        let mut found: Vec<Vec<PatchPart>> = alloc::vec![Vec::new(); self.buckets];
        let blocks = if side > 0.0 { self.blocks.first() } else { self.blocks.last() };
        let blocks = patches.into_iter().flat_map(|all| all.chunks(BLOCK)).zip(blocks.into_iter().flatten());
        let meets = |(least, most): (f64, f64)| least <= hi && most >= lo;
        let near = blocks.filter(|(_, range)| meets(**range)).flat_map(|(block, _)| block);
        for patch in near.filter(|patch| meets(patch.moments)) {
            let Some(directions) = patch.directions((lo, hi)) else { continue };
            for_each_bucket(directions, self.buckets, |bucket, turned| {
                if let Some(part) = patch.part(of(bucket), turned, (lo, hi), directions) {
                    let part = if self.buckets <= COARSE { part.flattened(STEEPEST) } else { part };
                    self.join(&mut found[bucket], part);
                }
            });
        }
        if let Some(directions) = self.near.directions((lo, hi), self.slack) {
            for_each_bucket(directions, self.buckets, |bucket, _| found[bucket].push(NearBase::part(of(bucket))));
        }
        let entry = |part: &PatchPart| {
            let PatchPart { middle, half, center, by_direction, by_moment, radius, inflected } = *part;
            PressEntry { middle, half, center, by_direction, by_moment, radius, inflected }
        };
        PressSlice::of_buckets(self.buckets, found.iter().map(|parts| parts.iter().map(entry)))
    }

    /// Adds a part to those of a bucket, together with another where that takes no more room.
    fn join(&self, parts: &mut Vec<PatchPart>, part: PatchPart) {
        let alike = |other: &PatchPart| other.inflected == part.inflected;
        let is_full = parts.iter().filter(|other| alike(other)).count() >= MOST_TOGETHER;
        let limit = if is_full { f64::INFINITY } else { JOINED * self.width };
        // Neighbours follow each other.
        let first = if is_full { parts.len().saturating_sub(COMPARED) } else { 0 };
        let mut best: Option<(usize, PatchPart)> = None;
        for (k, other) in parts.iter().enumerate().skip(first).rev() {
            let limit = best.map_or(limit, |(_, best)| best.radius);
            if let Some(joined) = other.joined(&part, limit) {
                best = Some((k, joined));
                if joined.radius <= JOINED * self.width {
                    break;
                }
            }
        }
        if let Some((k, joined)) = best {
            parts[k] = joined;
            return;
        }
        parts.push(part);
    }
}

impl NearBase {
    /// The directions of walls that touch the side next to the base, with a moment in a range; none if there are none.
    fn directions(&self, (lo, hi): (f64, f64), slack: f64) -> Option<(f64, f64)> {
        // Where the whisker turns by less than a radian, the moment falls from the base to the contact.
        let bent = |moment: f64| NEAR_MARGIN * NEAREST * self.compliance * moment.max(0.0);
        let curved = NEAR_MARGIN * NEAREST * self.curvature;
        if bent(hi.max(-lo)) + curved + slack > 1.0 {
            return Some((0.0, TAU));
        }
        (hi >= 0.0).then(|| (FRAC_PI_2 - curved - slack, FRAC_PI_2 + bent(hi) + curved + slack))
    }

    fn part((middle, half): (f64, f64)) -> PatchPart {
        let none = Vec2::ZERO;
        let radius = NEAREST * NEAR_MARGIN;
        PatchPart { middle, half, center: none, by_direction: none, by_moment: none, radius, inflected: false }
    }
}

/// Calls `visit` for each bucket of a whole turn that meets a range of directions (rad), with the turns that the range is moved by.
fn for_each_bucket((least, most): (f64, f64), buckets: usize, mut visit: impl FnMut(usize, f64)) {
    let width = TAU / buckets as f64;
    let first = (least / width - 1e-9).floor();
    let last = (most / width + 1e-9).floor();
    let count = ((last - first) as usize + 1).min(2 * buckets);
    for k in 0..count {
        let at = first + k as f64;
        let turns = (at / buckets as f64).floor();
        visit((at - turns * buckets as f64) as usize, -turns * TAU);
    }
}
