//! A whisker with its tip in contact as estimators ask for it: the closed form where there is one, else a table.

use super::field::TipField;
use super::tip_curve::{STEEPEST_TILT, largest_root, largest_tip_moment, pieces, steepest_peak, table_curve};
use super::{Bend, TipChart, TipEquilibrium, TipRate, Whisker, elastica, tip_chart, tip_curve};
use crate::error::{Error, Result};
use crate::plane::wrap_angle;
use crate::platform::Shared;
use alloc::vec::Vec;
use core::f64::consts::{FRAC_PI_2, PI};
#[cfg(not(feature = "std"))]
use num_traits::Float as _;

/// Share of the largest force at which the tip's compliance is read off.
const SMALL: f64 = 1e-6;
/// A table's largest moment is looked for at so many tilts and forces.
const GRID: [usize; 2] = [60, 120];
/// It is taken to be larger than what they show by this share.
const BETWEEN: f64 = 1e-3;
/// Tilts at which a force or slope is followed, and halvings that find the force of a slope.
const TILTS: usize = 150;
const HALVINGS: usize = 48;

/// One reading of a whisker with its tip in contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TipReading {
    /// Moment at the base (N m), counter-clockwise positive.
    Moment(f64),
    /// Contact force (N), negative when it pushes towards -y.
    Force(f64),
    /// Slope at the tip (rad), counter-clockwise.
    Slope(f64),
}

impl TipReading {
    /// The reading of the mirrored whisker, where that is positive; and +1, or -1 where it is mirrored.
    #[must_use]
    pub fn mirrored(self) -> (Self, f64) {
        let (Self::Moment(value) | Self::Force(value) | Self::Slope(value)) = self;
        let of = |value: f64| match self {
            Self::Moment(_) => Self::Moment(value),
            Self::Force(_) => Self::Force(value),
            Self::Slope(_) => Self::Slope(value),
        };
        (of(value.abs()), 1.0_f64.copysign(value))
    }
}

/// A whisker that is straight at rest, with its tip in contact.
///
/// Dimensionless numbers are those of the uniform whisker whose tip yields alike to a small side load: force
/// `q = F L² / B`, moment `mu = M0 L / B`, with `B` its flexural rigidity, [`TipModel::rigidity`]. Small loads then make
/// the deflection `q cos(beta) / 3` of the length, whatever the taper, the joints and the base.
#[derive(Clone, Debug)]
pub struct TipModel {
    whisker: Whisker,
    rigidity: f64,
    table: Option<Shared<Tabulated>>,
}

/// A table and the load at which its moment is the largest when the tilt is the steepest.
#[derive(Debug)]
struct Tabulated {
    field: TipField,
    /// `L sqrt(F / B)` and dimensionless moment.
    peak: (f64, f64),
}

impl TipModel {
    /// The model of a whisker; takes 0.1 s for one that is tapered, jointed or on an elastic base.
    ///
    /// # Errors
    /// Data: a whisker that is curved at rest or makes no sense; the message names the property.
    pub fn new(whisker: &Whisker) -> Result<Self> {
        whisker.require_straight()?;
        if whisker.is_uniform() {
            whisker.require_uniform()?;
            return Ok(Self { whisker: *whisker, rigidity: whisker.flexural_rigidity, table: None });
        }
        let field = TipField::new(whisker)?;
        let length = whisker.length;
        // Bent by a force so small that the deflection is proportional to it.
        let force = SMALL * field.largest_force(0.0, 1.0);
        let yields = field.at(0.0, force).map(|state| state.by_force.position.y).filter(|y| *y > 0.0);
        let rigidity = yields.map(|y| length.powi(3) / (3.0 * y)).ok_or_else(|| {
            Error::data("the whisker is too soft or too stiff at its tip to be tabulated")
                .remedy("check tip_ratio, base_stiffness and the segments' rigidities")
        })?;
        let (unit, per_moment) = (rigidity / length.powi(2), length / rigidity);
        let most = (field.largest_force(-STEEPEST_TILT, 1.0) / unit).sqrt();
        let peak = steepest_peak(most, &|t| {
            field.at(-STEEPEST_TILT, t * t * unit).map_or(0.0, |state| state.moment * per_moment)
        });
        Ok(Self { whisker: *whisker, rigidity, table: Some(Shared::new(Tabulated { field, peak })) })
    }

    /// The whisker.
    #[must_use]
    pub fn whisker(&self) -> &Whisker {
        &self.whisker
    }

    /// Whether the closed form covers it.
    #[must_use]
    pub fn is_uniform(&self) -> bool {
        self.table.is_none()
    }

    /// Flexural rigidity of the uniform whisker of this length whose tip yields alike to a small side load (N m²).
    #[must_use]
    pub fn rigidity(&self) -> f64 {
        self.rigidity
    }

    /// The tip under the dimensionless force `q` tilted by `beta` (rad) from the whisker's normal there, as
    /// [`tip_chart`] has it for the uniform whisker; from a table its error is [`TipField::errors`].
    ///
    /// None beyond the first mode, beyond the table's loads, and for tilts within 0.12 rad of the whisker's own direction
    /// there.
    #[must_use]
    pub fn chart(&self, q: f64, beta: f64) -> Option<TipChart> {
        let Some(table) = &self.table else { return tip_chart(q, beta) };
        // A force from behind is a negative one from the front.
        let turned = wrap_angle(beta);
        let behind = turned.abs() > FRAC_PI_2;
        let (sign, tilt) = if behind { (-1.0, turned - PI.copysign(turned)) } else { (1.0, turned) };
        let unit = self.unit_force();
        let state = table.field.at(tilt, sign * q * unit)?;
        let (length, moment) = (1.0 / self.whisker.length, self.whisker.length / self.rigidity);
        let rate = |by: &super::field::Quantities, per: f64| TipRate {
            position: by.position * (length * per),
            slope: by.slope * per,
            moment: by.moment * (moment * per),
        };
        Some(TipChart {
            position: state.position * length,
            slope: state.slope,
            moment: state.moment * moment,
            by_force: rate(&state.by_force, sign * unit),
            by_tilt: rate(&state.by_tilt, 1.0),
        })
    }

    /// All tip contacts that cause a positive reading, on pieces along which the force's direction grows.
    ///
    /// Those of a moment are [`tip_curve`]'s. Those of a force or slope run over the tilts within ±1.45 rad.
    #[must_use]
    pub fn curve(&self, reading: TipReading) -> Vec<Vec<TipEquilibrium>> {
        let (length, rigidity) = (self.whisker.length, self.rigidity);
        match reading {
            TipReading::Moment(moment) => self.of_moment(moment * length / rigidity),
            TipReading::Force(force) => {
                let t = (force * length * length / rigidity).sqrt();
                self.over_tilts(&|_| (t > 0.0).then_some(t))
            }
            TipReading::Slope(slope) => self.over_tilts(&|beta| self.root_of_slope(beta, slope)),
        }
    }

    fn of_moment(&self, mu: f64) -> Vec<Vec<TipEquilibrium>> {
        match &self.table {
            None => tip_curve(mu),
            Some(table) => table_curve(mu, table.peak, &|q, beta| self.chart(q, beta), &|beta| self.most_root(beta)),
        }
    }

    /// The equilibria at each tilt where the root of the dimensionless force is `root`'s.
    fn over_tilts(&self, root: &dyn Fn(f64) -> Option<f64>) -> Vec<Vec<TipEquilibrium>> {
        let node = |k: usize| {
            let beta = STEEPEST_TILT * (2.0 * k as f64 / TILTS as f64 - 1.0);
            let t = root(beta)?;
            let tip = self.chart(t * t, beta)?;
            let direction = beta + tip.slope + FRAC_PI_2;
            let held = tip.slope.abs() <= PI;
            held.then_some(TipEquilibrium { direction, slope: tip.slope, x: tip.position.x, y: tip.position.y, t })
        };
        let nodes: Vec<Option<TipEquilibrium>> = (0..=TILTS).map(node).collect();
        let runs = nodes.split(Option::is_none).filter(|run| run.len() > 1);
        runs.flat_map(|run| pieces(&run.iter().flatten().copied().collect::<Vec<_>>())).collect()
    }

    /// The root of the force that turns the tip by `slope > 0` at a tilt; the slope grows with the force up to the end of the
    /// first mode.
    fn root_of_slope(&self, beta: f64, slope: f64) -> Option<f64> {
        let turned = |t: f64| self.chart(t * t, beta).map(|tip| tip.slope);
        let (mut lo, mut hi) = (0.0, self.most_root(beta));
        if !(slope > 0.0 && turned(hi)? >= slope) {
            return None;
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (lo + hi);
            if turned(middle)? < slope { lo = middle } else { hi = middle }
        }
        Some(hi)
    }

    /// The largest base moment (N m) that a load at the tip causes when its tilt is at most `steepest` (rad, at least 0).
    #[must_use]
    pub fn largest_moment(&self, steepest: f64) -> f64 {
        let Some(table) = &self.table else {
            return largest_tip_moment(steepest) * self.rigidity / self.whisker.length;
        };
        let steepest = steepest.min(STEEPEST_TILT);
        let share = |k: usize, of: usize| k as f64 / of as f64;
        let at = |i: usize| {
            let tilt = steepest * (2.0 * share(i, GRID[0]) - 1.0);
            let most = table.field.largest_force(tilt, 1.0);
            (0..=GRID[1]).filter_map(move |k| table.field.at(tilt, most * share(k, GRID[1]))).map(|state| state.moment)
        };
        (0..=GRID[0]).flat_map(at).fold(0.0, f64::max) * (1.0 + BETWEEN)
    }

    /// The whole whisker under `force` (N) at its tip, tilted by `tilt` (rad) from its normal there.
    ///
    /// None where [`elastica::bend`] or [`Rod::pushed`](super::Rod::pushed) has none.
    #[must_use]
    pub fn bend(&self, force: f64, tilt: f64) -> Option<Bend> {
        let length = self.whisker.length;
        match &self.table {
            None => elastica::bend(self.rigidity, force, length, tilt),
            Some(table) => table.field.rod().pushed(force, length, tilt),
        }
    }

    /// The force (N) that is 1 without dimension.
    fn unit_force(&self) -> f64 {
        self.rigidity / self.whisker.length.powi(2)
    }

    /// The root of the largest dimensionless force at a tilt.
    fn most_root(&self, tilt: f64) -> f64 {
        let of_table = |table: &Tabulated| (table.field.largest_force(tilt, 1.0) / self.unit_force()).sqrt();
        self.table.as_deref().map_or_else(|| largest_root(tilt), of_table)
    }
}
