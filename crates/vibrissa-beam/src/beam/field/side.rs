//! The side field: the whisker as a table over the place of a frictionless contact and the force there.
use super::cells::TargetSearch;
use super::chart::{BendKind, Bunched, reach};
use super::errors::{self, ErrorBounds};
use super::image::Image;
use super::index::Index;
use super::panels::{Layout, Samples};
use super::state::{FieldErrors, Quantities};
use super::table::{ENERGY, MOMENT, SLOPE, Table, X, Y};
use super::unit::{TERMS, log_slope, scale, unit};
use crate::beam::rod::Rod;
use crate::beam::whisker::Whisker;
use crate::error::{Error, Result};
use crate::plane::Vec2;
use alloc::vec::Vec;
use core::f64::consts::{FRAC_PI_2, PI};

/// Contacts nearer to the base than this share of the length are left out: they hardly bend the whisker.
const NEAREST: f64 = 0.1;
/// Largest load, in those that bend the whisker at the contact by a radian in small-angle theory; the first mode of a uniform
/// whisker ends at 6.9.
const MOST_LOAD: f64 = 7.0;
/// Panels thinner than this share of the length are joined to a neighbour.
const THINNEST: f64 = 0.02;
/// Stretches at whose ends the largest loads are found.
const PLACES: usize = 32;
/// Panels along the whisker and over the load on one side; cells of a panel along each side.
const PANELS: [usize; 2] = [4, 4];
const CELLS: [usize; 2] = [24, 24];

/// Most Newton steps along a branch, and the largest step, as a share of the length and of the largest force.
const MOST_STEPS: usize = 24;
const LONGEST: f64 = 0.15;

/// All first-mode equilibria of a whisker with one frictionless contact at its side, by the contact's arc length and the force.
///
/// Covered are contacts from a tenth of the length on, and loads until the whisker has turned by pi at the contact or leaves the first
/// mode. For a uniform whisker [`normal`](super::super::normal) is as fast and exact; this is for the others.
#[derive(Clone, Debug)]
pub struct SideField {
    pub(super) rod: Rod,
    mirrored: bool,
    /// `ln(unit force * s_a²)` as a polynomial in `2 s_a / L - 1`.
    scale: [f64; TERMS],
    load: Bunched,
    /// Largest positive and negative load over places that are equally spaced, in the load's unit.
    pub(super) limits: Vec<[f64; 2]>,
    pub(super) samples: Samples,
    table: Table,
    pub(super) errors: ErrorBounds,
    index: Index,
}

/// A whisker in equilibrium with its side in frictionless contact, and how it changes.
///
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SideState {
    /// Arc length from the base to the contact (m).
    pub s_a: f64,
    /// The force (N), along the whisker's normal at the contact.
    pub force: f64,
    /// Slope at the contact (rad).
    pub slope: f64,
    /// The contact, whisker frame (m).
    pub position: Vec2,
    /// Base moment (N m).
    pub moment: f64,
    /// Elastic energy (J).
    pub energy: f64,
    /// Derivatives by the contact's arc length (per m), the force held.
    pub by_arc_length: Quantities,
    /// Derivatives by the force (per N), the contact held.
    pub by_force: Quantities,
}

impl SideState {
    /// The direction in which the force pushes the whisker, whisker frame (rad), not wrapped.
    #[must_use]
    pub fn direction(&self) -> f64 {
        self.slope + FRAC_PI_2.copysign(self.force)
    }

    fn mirrored(&self) -> Self {
        let flip = |v: Vec2| Vec2::new(v.x, -v.y);
        let by_arc_length = Quantities {
            slope: -self.by_arc_length.slope,
            position: flip(self.by_arc_length.position),
            moment: -self.by_arc_length.moment,
            ..self.by_arc_length
        };
        Self {
            force: -self.force,
            slope: -self.slope,
            position: flip(self.position),
            moment: -self.moment,
            by_arc_length,
            by_force: self.by_force.of_mirrored(),
            ..*self
        }
    }
}

impl SideField {
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
        let (scale, length) = (scale(rod), rod.length());
        let layout = layout(rod);
        let limits: Vec<[f64; 2]> =
            (0..=PLACES).map(|i| largest_loads(rod, &scale, place(i as f64 / PLACES as f64))).collect();
        let load = largest(&limits);
        let exact = |u: f64, v: f64| {
            let loaded = rod.loaded(load.at(v) * unit(&scale, u, length), u * length, 0.0)?;
            Some([loaded.slope, loaded.contact.x, loaded.contact.y, loaded.moment, loaded.energy])
        };
        let too_soft = || Error::data("the whisker is too soft to be tabulated").remedy("check its rigidities");
        let samples = layout.sample(exact).filter(|_| load.to > 0.0).ok_or_else(too_soft)?;
        let mut field = Self::from_measured(rod.clone(), limits, samples);
        let held = |i: usize, j: usize| is_held(&field.table, &field.limits, &field.load, i, j);
        field.errors = errors::measured(&layout, &field.samples, &field.table, held, exact);
        Ok(field)
    }

    /// The field of what was measured on a rod, its errors still unknown.
    pub(super) fn from_measured(rod: Rod, limits: Vec<[f64; 2]>, samples: Samples) -> Self {
        let (scale, mirrored) = (scale(&rod), rod.is_straight());
        let load = largest(&limits);
        let table = layout(&rod).table(&samples);
        let index = Index::new(Image::Position, &table, |i, j| is_held(&table, &limits, &load, i, j));
        Self { rod, mirrored, scale, load, limits, samples, table, errors: ErrorBounds::default(), index }
    }

    /// Bounds on the distance of every tabulated quantity from the beam, everywhere in the field.
    ///
    /// Panels end at a rod's joints, so that joints cost no accuracy; two that are closer than 2 % of the length do.
    #[must_use]
    pub fn errors(&self) -> FieldErrors {
        self.errors.value
    }

    /// The whisker's length (m).
    #[must_use]
    pub fn length(&self) -> f64 {
        self.rod.length()
    }

    /// The largest force on the side of `sign` with the contact at `s_a` (m) (N); 0 where the field holds no contact.
    #[must_use]
    pub fn largest_force(&self, s_a: f64, sign: f64) -> f64 {
        let u = s_a / self.rod.length();
        let k = usize::from(sign < 0.0 && !self.mirrored);
        limit(&self.limits, u, k) * unit(&self.scale, u, self.rod.length())
    }

    /// Whether the field holds this load.
    #[must_use]
    pub fn holds(&self, s_a: f64, force: f64) -> bool {
        let u = s_a / self.rod.length();
        (NEAREST..=1.0).contains(&u) && force.abs() <= self.largest_force(s_a, force)
    }

    /// The equilibrium under a normal force of `force` (N) at arc length `s_a` (m); `None` beyond the field.
    #[must_use]
    pub fn at(&self, s_a: f64, force: f64) -> Option<SideState> {
        let u = s_a / self.rod.length();
        let unit = unit(&self.scale, u, self.rod.length());
        self.holds(s_a, force).then(|| self.state(u, self.load.inverse(force / unit)))
    }

    /// Every equilibrium of the field whose contact is at `position` (m, whisker frame), least energy first.
    #[must_use]
    pub fn by_position(&self, position: Vec2) -> Vec<SideState> {
        let length = self.rod.length();
        let scale = [length, self.load.to * unit(&self.scale, 1.0, length) * length];
        let mut states = Vec::new();
        for side in if self.mirrored { &[1.0, -1.0][..] } else { &[1.0] } {
            let target = [position.x, side * position.y];
            let search = TargetSearch { table: &self.table, image: Image::Position, target, scale };
            let mut kept: Vec<[f64; 2]> = Vec::new();
            for [u, v] in search.all(&self.index, |_| true) {
                if !kept.iter().any(|[a, b]| (a - u).abs() < 1e-8 && (b - v).abs() < 1e-8) {
                    kept.push([u, v]);
                    states.push(self.state(u, side * v));
                }
            }
        }
        states.retain(|state| self.holds(state.s_a, state.force));
        states.sort_by(|a, b| a.energy.total_cmp(&b.energy));
        states
    }

    /// The equilibrium whose contact is at `position` (m) on the branch of `hint`, a state of this field nearby.
    ///
    /// `None` when the branch ends on the way: at a fold, or at the limits of the field.
    #[must_use]
    pub fn by_position_from(&self, position: Vec2, hint: &SideState) -> Option<SideState> {
        let mut at = *hint;
        let det = |state: &SideState| state.by_arc_length.position.cross(state.by_force.position);
        for _ in 0..MOST_STEPS {
            let off = position - at.position;
            let det_here = det(&at);
            let along = off.cross(at.by_force.position) / det_here;
            let more = at.by_arc_length.position.cross(off) / det_here;
            if !(along.is_finite() && more.is_finite()) {
                return None;
            }
            let most = self.largest_force(at.s_a, at.force);
            let size = (along / self.rod.length()).abs().max((more / most).abs());
            let share = if size > LONGEST { LONGEST / size } else { 1.0 };
            // A step beyond the field's edge goes to the edge, from where the next may lead back.
            let s_a = (at.s_a + share * along).clamp(NEAREST * self.rod.length(), self.rod.length());
            let limit = 1.0_f64.copysign(at.force + share * more);
            let force = limit * (at.force + share * more).abs().min(self.largest_force(s_a, limit));
            at = self.at(s_a, force)?;
            if size < 1e-6 {
                // Convergence is quadratic: the step just taken was the last that matters.
                let arrived = position.distance(at.position) < 1e-9 * self.rod.length();
                return (arrived && (det(&at) > 0.0) == (det(hint) > 0.0)).then_some(at);
            }
        }
        None
    }

    /// Every equilibrium of the field with the contact at `s_a` (m) and the base moment `moment` (N m), least energy first.
    ///
    /// Over `s_a` they are the contact set of a moment sensor.
    #[must_use]
    pub fn by_moment(&self, s_a: f64, moment: f64) -> Vec<SideState> {
        let u = s_a / self.rod.length();
        let mut states = Vec::new();
        for side in if self.mirrored { &[1.0, -1.0][..] } else { &[1.0] } {
            let off = |v: f64| self.table.jet(u, v).row(0)[MOMENT] - side * moment;
            let slope = |v: f64| self.table.jet(u, v).row(2)[MOMENT];
            for cell in self.table.v.knots.windows(2) {
                let (a, b) = (cell[0], cell[1]);
                // A cubic that turns within the cell is cut where it turns.
                let turn = if slope(a) * slope(b) < 0.0 { halved(slope, a, b) } else { b };
                for (lo, hi) in [(a, turn), (turn, b)] {
                    if lo < hi && (off(lo) < 0.0) != (off(hi) < 0.0) {
                        states.push(self.state(u, side * halved(off, lo, hi)));
                    }
                }
            }
        }
        states.retain(|state| self.holds(state.s_a, state.force));
        states.sort_by(|a, b| a.energy.total_cmp(&b.energy));
        states
    }

    fn state(&self, u: f64, v: f64) -> SideState {
        if self.mirrored && v < 0.0 {
            return self.state(u, -v).mirrored();
        }
        let length = self.rod.length();
        let (unit, load, rate) = (unit(&self.scale, u, length), self.load.at(v), self.load.rate(v));
        let jet = self.table.jet(u, v);
        // At constant force the load falls as its unit rises.
        let stretch = load * log_slope(&self.scale, u) / rate;
        let [value, mut by_arc_length, by_v] = [0, 1, 2].map(|kind| jet.row(kind));
        for (x, y) in by_arc_length.iter_mut().zip(by_v) {
            *x -= y * stretch;
        }
        SideState {
            s_a: u * length,
            force: load * unit,
            slope: value[SLOPE],
            position: Vec2::new(value[X], value[Y]),
            moment: value[MOMENT],
            energy: value[ENERGY],
            by_arc_length: Quantities::new(&by_arc_length, 1.0 / length),
            by_force: Quantities::new(&by_v, 1.0 / (rate * unit)),
        }
    }
}

/// The root of `f` between `a` and `b`, by halving.
fn halved(f: impl Fn(f64) -> f64, a: f64, b: f64) -> f64 {
    let (mut lo, mut hi) = (a, b);
    let below = f(lo) < 0.0;
    for _ in 0..60 {
        let middle = 0.5 * (lo + hi);
        if (f(middle) < 0.0) == below { lo = middle } else { hi = middle }
    }
    0.5 * (lo + hi)
}

/// The place, as a share of the length, at a share of the field.
fn place(share: f64) -> f64 {
    NEAREST + (1.0 - NEAREST) * share
}

/// The load's coordinate up to the largest of `limits`.
fn largest(limits: &[[f64; 2]]) -> Bunched {
    Bunched::new(1.0, limits.iter().flatten().fold(0.0, |a, b| a.max(*b)))
}

/// Whether the cell `(i, j)` holds loads within the limits.
fn is_held(table: &Table, limits: &[[f64; 2]], load: &Bunched, i: usize, j: usize) -> bool {
    let (a, b) = (table.v.knots[j], table.v.knots[j + 1]);
    let k = usize::from(a + b < 0.0);
    let nearest = load.at(a.abs().min(b.abs()));
    // Limits are linear between places: the ends of a cell and the places within it bound them.
    let (u0, u1) = (table.u.knots[i], table.u.knots[i + 1]);
    let places = (limits.len() - 1) as f64;
    let within = limits.iter().enumerate().filter(|(n, _)| {
        let u = place(*n as f64 / places);
        u > u0 && u < u1
    });
    nearest <= within.map(|(_, pair)| pair[k]).fold(limit(limits, u0, k).max(limit(limits, u1, k)), f64::max)
}

/// The limit at `u`, linear between places.
fn limit(limits: &[[f64; 2]], u: f64, k: usize) -> f64 {
    let cells = limits.len() - 1;
    let x = ((u - NEAREST) / (1.0 - NEAREST)).clamp(0.0, 1.0) * cells as f64;
    let i = (x as usize).min(cells - 1);
    limits[i][k] + (limits[i + 1][k] - limits[i][k]) * (x - i as f64)
}

/// The largest loads with the contact at `u` lengths, in the load's unit there.
fn largest_loads(rod: &Rod, scale: &[f64; TERMS], u: f64) -> [f64; 2] {
    let (s_a, unit) = (u * rod.length(), unit(scale, u, rod.length()));
    let side = |sign: f64| {
        let force = |q: f64| sign * q * unit;
        // A rod so curved that it is in no first mode even at rest is not asked for one.
        let mode = rod.keeps_first_mode(force(1e-6), s_a, 0.0);
        let Some((rest, _)) = rod.bent_under(0.0, s_a, 0.0) else { return 0.0 };
        reach(MOST_LOAD, |q| {
            let slope = rod.bent_under(force(q), s_a, 0.0).map(|bent| bent.0);
            let turned = slope.is_some_and(|slope| (slope - rest).abs() <= PI);
            turned && (!mode || rod.keeps_first_mode(force(q), s_a, 0.0))
        })
    };
    [side(1.0), if rod.is_straight() { 0.0 } else { side(-1.0) }]
}

/// How the chart of a rod is cut. What is tabulated has a jump in a second derivative where the contact passes a joint: there a
/// panel ends.
pub(super) fn layout(rod: &Rod) -> Layout {
    let even = |lo: f64, hi: f64, n: usize| (0..=n).map(|i| lo + (hi - lo) * (i as f64 / n as f64)).collect::<Vec<_>>();
    let mut u_breaks = even(NEAREST, 1.0, PANELS[0]);
    for joint in rod.joints().map(|s| s / rod.length()).filter(|u| *u > NEAREST + THINNEST && *u < 1.0 - THINNEST) {
        u_breaks.retain(|u| *u <= NEAREST || *u >= 1.0 || (u - joint).abs() > THINNEST);
        u_breaks.push(joint);
    }
    u_breaks.sort_by(f64::total_cmp);
    Layout {
        u_breaks,
        v_breaks: if rod.is_straight() { even(0.0, 1.0, PANELS[1]) } else { even(-1.0, 1.0, 2 * PANELS[1]) },
        u_cells: CELLS[0],
        v_cells: CELLS[1],
        bends: [BendKind::Same; 2],
    }
}
