//! All contacts of one kind of a rod, tip or side, as trees of patches over the place of the force and its size.

use super::patch::{CORNERS, Fit, Patch, RodSample, Samples, Variant};
use crate::beam::rod::{Hold, Rod};
use crate::math;
use crate::platform::Shared;
use alloc::collections::BinaryHeap;
use alloc::vec::Vec;
use core::cmp::Reverse;
use core::f64::consts::FRAC_PI_2;
#[cfg(not(feature = "std"))]
use num_traits::Float as _;

/// Contacts nearer to the base than this share of the length are taken together.
pub(super) const NEAREST: f64 = 0.004;
/// The roots of loads between the rows of a first grid, in those that turn the contact by a radian in small-angle theory,
/// and how they grow; half of both between columns of tilts (rad) and of logarithms of arc lengths.
const ROW: f64 = 0.25;
const GROWTH: f64 = 0.08;
const TILT: f64 = 0.12;
const ARC: f64 = 0.25;
/// A table has enough rows when so many follow in which the whisker cannot be, and never more than these.
const BEYOND: usize = 4;
const MOST_ROWS: usize = 200;
/// The rod is kept straight up to this share of the contact's arc length where it is asked whether it can be observed:
/// a margin.
const KEPT: f64 = 0.04;
/// Boundaries that curve towards free space by less, over the whisker's length, are taken to be as straight as the
/// contractors take them.
const HOLDING: f64 = 0.28;
/// Slopes may exceed the largest by this before all samples of a patch are beyond it (rad).
const SLOPE_MARGIN: f64 = 0.1;
/// Patches in which only some samples can be are bisected so often, to leave out more.
const MIXED_DEPTH: u8 = 4;
/// What changes of a patch with the rod or the force is known of wholes bisected so often.
const VARIED_DEPTH: u8 = 3;
/// Patches whose dimensionless moments are all larger may be wider in proportion: a wire that is 1/150 of its length thick is
/// strained by 2.7 % there, and no sensor reads it.
const LARGE_MOMENT: f64 = 8.0;
/// Most patches of all forests of one side.
pub(super) const MOST_PATCHES: usize = 24_000;

/// Which contacts a forest has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum RodContact {
    /// The tip, by the force's tilt from the whisker's normal.
    Tip,
    /// The side, by the logarithm of the arc length, with the force tilted by this much (rad).
    Side(f64),
}

/// A rod of unit length and its neighbours: what is not known of it.
#[derive(Clone, Debug)]
pub(super) struct RodKind {
    pub(super) rod: Rod,
    /// Pairs of rods between which it may be.
    pub(super) neighbours: Vec<[Rod; 2]>,
    pub(super) contact: RodContact,
    /// Friction angle, and half of the range of tilts that a side forest takes together (rad).
    pub(super) slack: f64,
    pub(super) lean: f64,
    /// Largest slope against that at rest (rad).
    pub(super) steepest: f64,
}

/// A patch of a tree.
#[derive(Clone, Debug)]
struct Branch {
    /// From and to, of each coordinate.
    ends: [(f64, f64); 2],
    /// None where a march failed: then nothing is known.
    samples: Option<Samples>,
    patch: Patch,
    /// How wide it leaves what it tells, over how large its moments are.
    width: f64,
    /// The coordinate to bisect.
    split: usize,
    /// What changes of it with the rod or the force: its own, or that of the whole that it is a part of.
    variants: Shared<[Variant]>,
    depth: u8,
    /// Whether the whisker can be in some of its samples only, or needs no hold in some; and whether it can be in none.
    is_mixed: bool,
    is_gone: bool,
    /// The first of its two halves.
    halves: Option<usize>,
}

/// The trees.
#[derive(Clone, Debug)]
pub(super) struct Forest {
    kind: RodKind,
    branches: Vec<Branch>,
    roots: usize,
}

impl RodKind {
    /// The contact at a place and the root of a load of one of the rods.
    fn at(&self, rod: &Rod, [a, b]: [f64; 2], lean: f64) -> Option<RodSample> {
        let (s, tilt) = self.force_at(a);
        let (contact, slope, moment) = rod.contact_under(self.load(s, b), s, tilt + lean)?;
        let direction = slope + FRAC_PI_2 + if self.contact == RodContact::Tip { tilt } else { 0.0 };
        let finite = direction.is_finite() && moment.is_finite() && contact.x.is_finite() && contact.y.is_finite();
        finite.then_some(RodSample { direction, moment, contact })
    }

    fn force_at(&self, a: f64) -> (f64, f64) {
        match self.contact {
            RodContact::Tip => (1.0, a),
            RodContact::Side(tilt) => (math::exp(a).min(1.0), tilt),
        }
    }

    /// The force whose load has this root.
    fn load(&self, s: f64, root: f64) -> f64 {
        root * root / self.rod.slope_compliance(s)
    }

    /// What other rods and other tilts change of some samples.
    fn variants(&self, samples: &Samples, at: &dyn Fn(&Rod, f64) -> Option<Samples>) -> Option<Vec<Variant>> {
        let against = |others: &[Samples]| -> Variant {
            let pairs = others.iter().flat_map(|other| samples.iter().zip(other));
            let change = |(a, b): (&RodSample, &RodSample)| {
                let p = b.contact - a.contact;
                [b.direction - a.direction, b.moment - a.moment, p.x, p.y]
            };
            pairs.map(change).collect()
        };
        let mut all = Vec::new();
        for [a, b] in &self.neighbours {
            all.push(against(&[at(a, 0.0)?, at(b, 0.0)?]));
        }
        if self.lean > 0.0 {
            let [a, b, c, d] = [-1.0, -0.5, 0.5, 1.0].map(|share| at(&self.rod, share * self.lean));
            all.push(against(&[a?, b?, c?, d?]));
        }
        Some(all)
    }

    /// Whether the whisker cannot be there even where it is held, and whether it cannot be there on boundaries that do not
    /// hold it.
    fn cannot_be(&self, [a, b]: [f64; 2]) -> [bool; 2] {
        let (s, tilt) = self.force_at(a);
        let load = (self.load(s, b), s, tilt);
        let too_steep = || {
            let Some((_, rest, _)) = self.rod.contact_under(0.0, s, tilt) else { return false };
            let Some((_, slope, _)) = self.rod.contact_under(load.0, s, tilt) else { return false };
            (slope - rest).abs() > self.steepest + SLOPE_MARGIN
        };
        if load.0 <= 0.0 {
            return [false; 2];
        }
        if self.steepest.is_finite() && too_steep() {
            return [true; 2];
        }
        let kept = KEPT * s;
        let falls = |hold: Hold| self.rod.is_unstable(load, hold, kept);
        match self.contact {
            RodContact::Tip if falls(Hold::PinnedTip) => [true; 2],
            RodContact::Tip => [false, self.slack <= 0.0 && falls(Hold::SlidingTip(HOLDING))],
            RodContact::Side(_) if self.slack > 0.0 => [falls(Hold::ClampedSide); 2],
            RodContact::Side(_) => [falls(Hold::SlidingSide(self.rod.rest_curvature(s))); 2],
        }
    }

    /// The columns of the first grid.
    fn columns(&self) -> Vec<f64> {
        let between = |from: f64, to: f64, step: f64| {
            let count = ((to - from) / step).ceil().max(1.0) as usize;
            (0..count).map(move |k| from + (to - from) * k as f64 / count as f64)
        };
        match self.contact {
            RodContact::Tip => between(-self.slack, FRAC_PI_2, TILT).chain([FRAC_PI_2]).collect(),
            RodContact::Side(_) => {
                let mut ends: Vec<f64> = [math::ln(NEAREST), 0.0].to_vec();
                ends.extend(self.rod.joints().filter(|&s| s > NEAREST && s < 1.0).map(math::ln));
                ends.sort_by(f64::total_cmp);
                let mut all: Vec<f64> = ends.windows(2).flat_map(|w| between(w[0], w[1], ARC)).collect();
                all.push(0.0);
                all
            }
        }
    }
}

impl Forest {
    /// The trees as far as which whiskers can be there tells them apart.
    pub(super) fn new(kind: RodKind) -> Self {
        let columns = kind.columns();
        // Columns and their middles, row by row.
        let asked: Vec<f64> =
            (0..2 * columns.len() - 1).map(|k| 0.5 * (columns[k / 2] + columns[k.div_ceil(2)])).collect();
        let row = |root: f64| asked.iter().map(|&a| kind.cannot_be([a, root])).collect::<Vec<_>>();
        let mut forest = Self { kind: kind.clone(), branches: Vec::new(), roots: 0 };
        let (mut root, mut below, mut beyond) = (0.0, row(0.0), 0);
        for count in 0..MOST_ROWS {
            let next = root + ROW.max(GROWTH * root);
            let (middle, above) = (row(0.5 * (root + next)), row(next));
            beyond = if below.iter().chain(&middle).chain(&above).all(|cannot| cannot[0]) { beyond + 1 } else { 0 };
            if beyond == BEYOND {
                break;
            }
            // What comes after the last row is not known.
            let is_last = count + 1 == MOST_ROWS;
            for (k, ends) in columns.windows(2).enumerate() {
                let around = |which: usize| {
                    [&below, &middle, &above].iter().all(|row| row[2 * k..2 * k + 3].iter().all(|cannot| cannot[which]))
                };
                if is_last {
                    forest.branches.push(Branch::anywhere([(ends[0], ends[1]), (root, next)]));
                } else if !around(0) {
                    let some = |which: usize| {
                        [&below, &middle, &above]
                            .iter()
                            .any(|row| row[2 * k..2 * k + 3].iter().any(|cannot| cannot[which]))
                    };
                    let is_mixed = some(0) || (some(1) && !around(1));
                    forest.add([(ends[0], ends[1]), (root, next)], None, (None, 0), (around(1), is_mixed));
                }
            }
            (root, below) = (next, above);
        }
        forest.roots = forest.branches.len();
        forest
    }

    /// Bisects the patches until they leave no more than `width` or are `most`, the widest first: what is over then is alike. After so many
    /// bisections it pauses; how many it has done, which are fewer at the end.
    pub(super) fn refine_some(&mut self, width: f64, most: usize, at_once: usize) -> usize {
        // Widths are not negative: their bits grow with them.
        let key = |branches: &[Branch], index: usize| -> Option<(u64, Reverse<usize>)> {
            let branch = &branches[index];
            let is_wide = branch.width > width || (branch.is_mixed && branch.depth < MIXED_DEPTH);
            let can = branch.halves.is_none() && !branch.is_gone && branch.samples.is_some();
            (is_wide && can).then(|| (branch.width.to_bits(), Reverse(index)))
        };
        let mut waiting: BinaryHeap<_> = (0..self.branches.len()).filter_map(|at| key(&self.branches, at)).collect();
        let mut done = 0;
        while done < at_once
            && self.branches.len() < most
            && let Some((_, Reverse(index))) = waiting.pop()
        {
            let first = self.branches.len();
            self.bisect(index);
            waiting.extend((first..self.branches.len()).filter_map(|at| key(&self.branches, at)));
            done += 1;
        }
        done
    }

    /// The patches that leave no more than `width`, and where there are none the narrowest.
    pub(super) fn patches(&self, width: f64) -> impl Iterator<Item = &Patch> {
        let mut waiting: Vec<usize> = (0..self.roots).rev().collect();
        core::iter::from_fn(move || {
            loop {
                let branch = &self.branches[waiting.pop()?];
                match branch.halves {
                    Some(first) if branch.width > width || branch.is_mixed => waiting.extend([first + 1, first]),
                    _ if branch.is_gone => {}
                    _ => return Some(&branch.patch),
                }
            }
        })
    }

    fn bisect(&mut self, index: usize) {
        let branch = self.branches[index].clone();
        let Some(samples) = branch.samples else { return };
        self.branches[index].halves = Some(self.branches.len());
        let axis = branch.split;
        let inflected = branch.patch.inflected;
        let (from, to) = branch.ends[axis];
        let middle = 0.5 * (from + to);
        for (half, range) in [(0, (from, middle)), (1, (middle, to))] {
            let mut ends = branch.ends;
            ends[axis] = range;
            // What the whole knew: its own line and the one in the middle.
            let known = |i: usize, j: usize| {
                let at = [i, j][axis];
                let (old, is_known) = (half + at / 2, at.is_multiple_of(2));
                let cell = if axis == 0 { 3 * old + j } else { 3 * i + old };
                is_known.then(|| samples[cell])
            };
            let own = (branch.depth < VARIED_DEPTH).then_some(None);
            let variants = own.unwrap_or_else(|| Some(Shared::clone(&branch.variants)));
            // However deep: what can be nowhere may be folded so that no patch tells it well.
            let (gone, held, is_mixed) =
                if branch.is_mixed { self.who_can_be(ends) } else { (false, inflected, false) };
            self.add(ends, Some(&known), (variants, branch.depth + 1), (held, is_mixed));
            if let Some(half) = self.branches.last_mut() {
                half.is_gone = gone;
            }
        }
    }

    /// Whether the whisker can be nowhere in a range, whether it needs to be held in all of it, and whether that differs.
    fn who_can_be(&self, ends: [(f64, f64); 2]) -> (bool, bool, bool) {
        let at = |(from, to): (f64, f64), k: usize| [from, 0.5 * (from + to), to][k];
        let cannot: Vec<[bool; 2]> =
            (0..9).map(|k| self.kind.cannot_be([at(ends[0], k / 3), at(ends[1], k % 3)])).collect();
        let all = |which: usize| cannot.iter().all(|one| one[which]);
        let any = |which: usize| cannot.iter().any(|one| one[which]);
        (all(0), all(1), !all(0) && (any(0) || (any(1) && !all(1))))
    }

    /// Adds a patch; what is known of its samples and of what changes them is not computed anew.
    fn add(
        &mut self,
        ends: [(f64, f64); 2],
        known: Option<&dyn Fn(usize, usize) -> Option<RodSample>>,
        (variants, depth): (Option<Shared<[Variant]>>, u8),
        (inflected, is_mixed): (bool, bool),
    ) {
        let kind = &self.kind;
        let all =
            |rod: &Rod, lean: f64, known: Option<&dyn Fn(usize, usize) -> Option<RodSample>>| -> Option<Samples> {
                let at = |k: usize| {
                    let (i, j) = (k / 3, k % 3);
                    let place = [(0, i), (1, j)].map(|(axis, at): (usize, usize)| {
                        let (from, to) = ends[axis];
                        [from, 0.5 * (from + to), to][at]
                    });
                    known.and_then(|known| known(i, j)).or_else(|| kind.at(rod, place, lean))
                };
                let list = [0, 1, 2, 3, 4, 5, 6, 7, 8].map(at);
                let first = list[CORNERS[0]]?;
                list.iter().all(Option::is_some).then(|| list.map(|sample| sample.unwrap_or(first)))
            };
        let samples = all(&kind.rod, 0.0, known);
        let anew = |samples: Samples| kind.variants(&samples, &|rod, lean| all(rod, lean, None)).map(Shared::from);
        let variants = variants.or_else(|| samples.and_then(anew));
        let (Some(samples), Some(variants)) = (samples, variants) else {
            return self.branches.push(Branch::anywhere(ends));
        };
        let fit = Fit::new(&samples, &variants, inflected);
        let [first, second] = fit.bends;
        // A twist is gone with either coordinate: the one that has been bisected less.
        let share = |axis: usize| (ends[axis].1 - ends[axis].0) / [TILT.max(ARC), ROW.max(GROWTH * ends[1].1)][axis];
        let split = if fit.twist > 4.0 * first.max(second) {
            usize::from(share(1) > share(0))
        } else {
            usize::from(second > first)
        };
        let (least, largest) = fit.patch.moments;
        let weight = (least.max(-largest) / LARGE_MOMENT).max(1.0);
        let (patch, width) = (fit.patch, fit.width / weight);
        let samples = Some(samples);
        self.branches.push(Branch {
            ends,
            samples,
            patch,
            width,
            split,
            variants,
            depth,
            is_mixed,
            is_gone: false,
            halves: None,
        });
    }
}

impl Branch {
    fn anywhere(ends: [(f64, f64); 2]) -> Self {
        let patch = Patch::anywhere(false);
        let (is_mixed, is_gone) = (false, false);
        let variants: Shared<[Variant]> = Shared::new([]);
        Self { ends, samples: None, patch, width: 0.0, split: 0, variants, depth: 0, is_mixed, is_gone, halves: None }
    }
}
