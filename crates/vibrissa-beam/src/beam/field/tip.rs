//! The tip field: the whisker as a table over tilt and force at its tip.
use super::chart::{BendKind, Bunched, LoadLimits, reach};
use super::errors::{self, ErrorBounds};
use super::image::Image;
use super::index::Index;
use super::panels::{Layout, Samples};
use super::state::{FieldErrors, Quantities, TipState};
use super::table::{Jet, Row, Table};
use crate::beam::rod::{Loaded, Rod};
use crate::beam::whisker::Whisker;
use crate::error::{Error, Result};
use crate::plane::Vec2;
use alloc::vec;
use alloc::vec::Vec;
use core::f64::consts::PI;
use fearless_simd::dispatch;

/// Tilts beyond this are left out (rad): the force then all but pulls or pushes along the whisker.
pub(super) const STEEPEST_TILT: f64 = 1.45;
/// Slopes further from the slope at rest are left out (rad): a whisker that is wound up.
const STEEPEST_SLOPE: f64 = PI;
/// Loads beyond this many times the one that bends the whisker by a radian (small-angle theory) are left out: of straight
/// whiskers, and of those that are curved at rest, whose shapes soon depend on the tilt beyond all use.
const MOST_LOAD: f64 = 10.0;
const MOST_LOAD_CURVED: f64 = 7.0;
/// Tilts at which the largest load is found.
const LIMITS: usize = 41;
/// Panels over the tilt, and over the load on one side; cells of a panel along each side.
const PANELS: [usize; 2] = [6, 6];
const CELLS: [usize; 2] = [16, 16];
/// The same of a whisker that is curved at rest, whose shapes change faster with the tilt.
const CELLS_CURVED: [usize; 2] = [32, 16];

/// Cells are halved until the tip is known to this share of the length, and at most so often.
const COARSEST: f64 = 1e-5;
const MOST_REFINED: usize = 1;

/// What is kept of a rod: the largest forces and the samples.
pub(super) struct Measured {
    pub(super) forces: Vec<[f64; 2]>,
    pub(super) samples: Samples,
}

/// The tilt's coordinate for the samples and the knots, six times finer at the steepest tilts than at none: a force that all but pulls along the whisker
/// bends it by an amount that changes with the tilt like `exp(L sqrt(F / EI))`.
pub(super) const TILTS: Bunched = Bunched::new(STEEPEST_TILT, 1.0);

/// All equilibria of a whisker with its tip in contact, by tilt and force: every branch is a region of this one chart.
///
/// Covered are tilts within ±1.45 rad. At each tilt loads grow from rest on until the tip has turned by pi, or until the
/// shape is neither stable (see [`TipState::is_stable`]) nor, of a straight whisker, of the first mode, or to ten times the
/// load that bends the tip by a radian in small-angle theory (seven times for a whisker that is curved at rest).
///
/// Reading it takes no search. [`TipField::errors`] bounds the distance from the beam.
#[derive(Clone, Debug)]
pub struct TipField {
    pub(super) rod: Rod,
    pub(super) limits: LoadLimits,
    /// Of each cell of tilts: loads on both sides that are within the limits all over it (N).
    sure: Vec<[f64; 2]>,
    pub(super) load: Bunched,
    /// One over the largest load (1/N).
    pub(super) per_load: f64,
    /// Only positive loads are tabulated; the others are mirrored.
    pub(super) mirrored: bool,
    pub(super) samples: Samples,
    pub(super) table: Table,
    pub(super) errors: ErrorBounds,
    /// How often the cells were halved.
    pub(super) refinement: usize,
    pub(super) positions: Index,
    pub(super) readings: Index,
}

impl TipField {
    /// The field of a whisker.
    ///
    /// # Errors
    /// Data: a whisker that makes no sense, see [`Rod::new`], or one too soft to be integrated.
    pub fn new(whisker: &Whisker) -> Result<Self> {
        Self::of_rod(&Rod::new(whisker)?)
    }

    /// The field of a rod.
    ///
    /// # Errors
    /// Data: a rod too soft to be integrated.
    pub fn of_rod(rod: &Rod) -> Result<Self> {
        let forces = largest_forces(rod);
        let limits = LoadLimits::new(-STEEPEST_TILT, STEEPEST_TILT, forces);
        let load = Bunched::new(1.0, limits.largest());
        let exact = |tilt, force| rod.loaded(force, rod.length(), tilt).map(row);
        let samples = layout(rod, 0, load).sample(exact).filter(|_| load.to > 0.0).ok_or_else(too_soft)?;
        let mut measured = Measured { forces: limits.forces, samples };
        for refinement in 0..=MOST_REFINED {
            let mut field = Self::from_measured(rod.clone(), measured, refinement)?;
            let held = |i: usize, j: usize| is_held(&field.table, &field.limits, i, j);
            field.errors = errors::measured(&layout(rod, refinement, load), &field.samples, &field.table, held, exact);
            if field.errors.value.position <= COARSEST * rod.length() || refinement == MOST_REFINED {
                return Ok(field);
            }
            measured = Measured { forces: field.limits.forces, samples: field.samples };
        }
        Err(too_soft())
    }

    /// The field of what was measured on a rod, its errors still unknown, with `2^refinement` times as many cells along each side.
    pub(super) fn from_measured(rod: Rod, measured: Measured, refinement: usize) -> Result<Self> {
        let Measured { forces, samples } = measured;
        let limits = LoadLimits::new(-STEEPEST_TILT, STEEPEST_TILT, forces);
        let load = Bunched::new(1.0, limits.largest());
        let table = layout(&rod, refinement, load).table(&samples);
        let held = |i: usize, j: usize| is_held(&table, &limits, i, j);
        let positions = Index::new(Image::Position, &table, held);
        let readings = Index::new(Image::Reading, &table, held);
        let (mirrored, errors) = (rod.is_straight(), ErrorBounds::default());
        Ok(Self {
            rod,
            sure: limits.sure(&table.u.knots),
            limits,
            load,
            per_load: 1.0 / load.to,
            mirrored,
            samples,
            table,
            errors,
            refinement,
            positions,
            readings,
        })
    }

    /// The whisker's length (m).
    #[must_use]
    pub fn length(&self) -> f64 {
        self.rod.length()
    }

    /// The rod that was tabulated.
    #[must_use]
    pub fn rod(&self) -> &Rod {
        &self.rod
    }

    /// Bounds on the distance of every tabulated quantity from the beam, everywhere in the field.
    #[must_use]
    pub fn errors(&self) -> FieldErrors {
        self.errors.value
    }

    /// Bounds on the distance of every derivative from the beam's, everywhere in the field: by the tilt (per rad), by the force (per N).
    #[must_use]
    pub fn rate_errors(&self) -> [FieldErrors; 2] {
        [self.errors.by_u, self.errors.by_v]
    }

    /// The largest force on the side of `sign` that the field holds at `tilt` (N); 0 beyond the tilts it holds.
    #[must_use]
    #[inline]
    pub fn largest_force(&self, tilt: f64, sign: f64) -> f64 {
        if self.mirrored && sign < 0.0 { self.limits.at(-tilt, 1.0) } else { self.limits.at(tilt, sign) }
    }

    /// Whether the field holds this load: `tilt` (rad), `force` (N).
    #[must_use]
    #[inline]
    pub fn holds(&self, tilt: f64, force: f64) -> bool {
        tilt.abs() <= STEEPEST_TILT && force.abs() <= self.largest_force(tilt, force)
    }

    /// The equilibrium under a force of `force` (N) at the tip, tilted by `tilt` (rad) from the whisker's normal there.
    ///
    /// `None` beyond the field, see [`TipField::holds`].
    #[must_use]
    pub fn at(&self, tilt: f64, force: f64) -> Option<TipState> {
        let side = self.side(force);
        let ((u, s), v) = (self.table.u.along(side * tilt), side * force);
        // Far from the limits a cell knows that it is.
        let [most, least] = *self.sure.get(u)?;
        let within = v <= most && -v <= least && tilt.abs() <= STEEPEST_TILT;
        if !within && self.is_beyond(tilt, force) {
            return None;
        }
        let (v, t) = self.table.v.along(v);
        let patch = self.table.patch(u, v)?;
        dispatch!(self.table.level, simd => Some(TipState::new(tilt, force, &patch.jet(simd, s, t, side))))
    }

    /// As [`TipField::at`], by the beam itself: no table, no derivatives, twenty to a hundred times slower, any load.
    #[must_use]
    pub fn exact(&self, tilt: f64, force: f64) -> Option<Quantities> {
        let loaded = self.rod.loaded(force, self.rod.length(), tilt)?;
        Some(Quantities { slope: loaded.slope, position: loaded.contact, moment: loaded.moment, energy: loaded.energy })
    }

    /// Whether the field does not hold a load: apart from the look-up, which hardly asks.
    #[cold]
    #[inline(never)]
    fn is_beyond(&self, tilt: f64, force: f64) -> bool {
        !self.holds(tilt, force)
    }

    /// -1 where the mirrored whisker is looked up.
    #[inline(always)]
    fn side(&self, force: f64) -> f64 {
        if self.mirrored { 1.0_f64.copysign(force) } else { 1.0 }
    }

    /// The state under a load, whether held or not.
    pub(super) fn state(&self, tilt: f64, force: f64) -> TipState {
        let side = self.side(force);
        let ((u, s), (v, t)) = (self.table.u.along(side * tilt), self.table.v.along(side * force));
        let Some(patch) = self.table.patch(u, v) else { return TipState::new(tilt, force, &Jet::default()) };
        dispatch!(self.table.level, simd => TipState::new(tilt, force, &patch.jet(simd, s, t, side)))
    }
}

fn too_soft() -> Error {
    Error::data("the whisker is too soft at its tip to be tabulated")
        .remedy("check tip_ratio, base_stiffness and the segments' rigidities")
}

fn row(loaded: Loaded) -> Row {
    let Loaded { slope, contact, moment, energy } = loaded;
    [slope, contact.x, contact.y, moment, energy]
}

/// How the chart of a rod is cut, each cell halved `refinement` times along both sides.
pub(super) fn layout(rod: &Rod, refinement: usize, load: Bunched) -> Layout {
    let even = |lo: f64, hi: f64, n: usize| (0..=n).map(|i| lo + (hi - lo) * (i as f64 / n as f64)).collect::<Vec<_>>();
    let (start, panels, cells) =
        if rod.is_straight() { (0.0, PANELS[1], CELLS) } else { (-1.0, 2 * PANELS[1], CELLS_CURVED) };
    Layout {
        u_breaks: even(-1.0, 1.0, PANELS[0]),
        v_breaks: even(start, 1.0, panels),
        u_cells: cells[0] << refinement,
        v_cells: cells[1] << refinement,
        bends: [BendKind::Inverse(TILTS), BendKind::At(load)],
    }
}

/// Whether the cell `(i, j)` holds loads within the limits.
fn is_held(table: &Table, limits: &LoadLimits, i: usize, j: usize) -> bool {
    let (u, v) = (&table.u.knots, &table.v.knots);
    let (middle, nearest) = (v[j] + v[j + 1], v[j].abs().min(v[j + 1].abs()));
    nearest <= limits.largest_over(u[i], u[i + 1], middle)
}

/// The largest loads at each tilt.
fn largest_forces(rod: &Rod) -> Vec<[f64; 2]> {
    let unit = rod.unit_force(rod.length());
    let mut forces = vec![[0.0; 2]; LIMITS];
    for (i, pair) in forces.iter_mut().enumerate() {
        let tilt = STEEPEST_TILT * (2.0 * i as f64 / (LIMITS - 1) as f64 - 1.0);
        let sides: &[f64] = if rod.is_straight() { &[1.0] } else { &[1.0, -1.0] };
        for (k, sign) in sides.iter().enumerate() {
            pair[k] = unit
                * reach(if rod.is_straight() { MOST_LOAD } else { MOST_LOAD_CURVED }, |q| {
                    is_covered(rod, tilt, sign * q * unit)
                });
        }
    }
    forces
}

/// Whether a shape is within the turn that is covered, and stable or, of a straight rod, of the first mode.
fn is_covered(rod: &Rod, tilt: f64, force: f64) -> bool {
    const H: f64 = 1e-4;
    let length = rod.length();
    let bent = |tilt: f64, force: f64| rod.bent_under(force, length, tilt);
    let (Some((slope, _)), Some((rest, _))) = (bent(tilt, force), bent(tilt, 0.0)) else { return false };
    if (slope - rest).abs() > STEEPEST_SLOPE {
        return false;
    }
    if rod.is_straight() && rod.keeps_first_mode(force, length, tilt) {
        return true;
    }
    let difference = |a: Option<(f64, Vec2)>, b: Option<(f64, Vec2)>| Some(a?.1 - b?.1);
    let by_tilt = difference(bent(tilt + H, force), bent(tilt - H, force));
    let by_force = difference(bent(tilt, force * (1.0 + H)), bent(tilt, force * (1.0 - H)));
    // The sign that `TipState::is_stable` asks for.
    by_tilt.zip(by_force).is_some_and(|(a, b)| a.cross(b) < 0.0)
}
