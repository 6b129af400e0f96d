//! A whisker as a function from force and arc length to a contact.

use super::small_beam::SmallBeam;
use super::{Contact, Limits, MomentRegime};
use crate::beam::elastica::bend;
use crate::beam::field::ContactSheet;
use crate::beam::normal::by_force;
use crate::beam::{Load, Rod, Whisker, force_mode};
use crate::math;
use crate::plane::Vec2;
use crate::{Error, Result};
use core::f64::consts::{FRAC_PI_2, PI};
use std::sync::{Arc, OnceLock};

/// Contacts nearer to the base than this share of the length are not told apart from the base.
pub(super) const BASE_SHARE: f64 = 1e-3;
/// The share of the length by which the tip may move before a whisker counts as strongly bent \[routray, section "Brief
/// Review of Beam Theory"\].
const SMALL_DISPLACEMENT: f64 = 0.1;
/// The first mode of a uniform whisker under a normal load ends at this `F s_a² / (2 EI)`: `2 K(1/2)²`.
pub(super) const LAST_NORMAL_LOAD: f64 = 6.875_185_818_020_372;
/// No first mode goes further in the same number, taper included.
const LAST_LOAD: f64 = 80.0;
/// Steps of the search for a tilt that brings a rod's force to the vertical.
const TILT_STEPS: usize = 60;

/// How a whisker bends.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Mechanics {
    /// Uniform, straight, clamped: closed form, with its flexural rigidity (N m²).
    Uniform(f64),
    /// Anything else: integrated.
    Rod(Rod),
    /// Small angles only.
    Small(SmallBeam),
}

/// A whisker, the direction of its load and its limits: the forward map from (force, arc length) to a contact.
///
/// Uniform, tapered, curved and jointed whiskers on clamped or elastic bases all take this form, which is why one contact of any
/// whisker is two numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactModel {
    length: f64,
    pub(super) mechanics: Mechanics,
    load: Load,
    limits: Limits,
    small: Option<SmallBeam>,
    sheet: Late,
}

/// The sheet of a model, made when it is first asked for and shared by the model's copies. It follows from the rest of the model.
#[derive(Clone, Default)]
struct Late(Arc<OnceLock<Option<ContactSheet>>>);

// A hundred thousand numbers help nobody.
impl core::fmt::Debug for Late {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(if self.0.get().is_some() { "made" } else { "to be made" })
    }
}

impl PartialEq for Late {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl ContactModel {
    /// The model of `whisker` under a normal, vertical or tilted load.
    ///
    /// # Errors
    /// Data: a whisker that makes no sense. Usage: a load directed in the plane, or tilted by a right angle or more.
    pub fn new(whisker: &Whisker, load: Load) -> Result<Self> {
        let rod = Rod::new(whisker)?;
        let mechanics =
            if whisker.is_uniform() { Mechanics::Uniform(whisker.flexural_rigidity) } else { Mechanics::Rod(rod) };
        let small = SmallBeam::new(whisker);
        Ok(Self {
            length: whisker.length,
            mechanics,
            load: checked(load)?,
            limits: Limits::default(),
            small,
            sheet: Late::default(),
        })
    }

    /// The model of a rod of any make; it has no small-angle regime.
    ///
    /// # Errors
    /// Usage: as [`ContactModel::new`].
    pub fn of_rod(rod: Rod, load: Load) -> Result<Self> {
        let length = rod.length();
        Ok(Self {
            length,
            mechanics: Mechanics::Rod(rod),
            load: checked(load)?,
            limits: Limits::default(),
            small: None,
            sheet: Late::default(),
        })
    }

    /// The same whisker with declared maxima.
    ///
    /// # Errors
    /// Usage: a limit that is not positive.
    pub fn with_limits(mut self, limits: Limits) -> Result<Self> {
        limits.check()?;
        self.limits = limits;
        Ok(self)
    }

    /// Arc length from base to tip (m).
    #[must_use]
    pub fn length(&self) -> f64 {
        self.length
    }

    /// The declared maxima.
    #[must_use]
    pub fn limits(&self) -> &Limits {
        &self.limits
    }

    /// Whether contacts follow the small-angle model.
    #[must_use]
    pub fn is_small_angle(&self) -> bool {
        matches!(self.mechanics, Mechanics::Small(_))
    }

    /// The model by which moments up to `moment` (N m) are read in a regime.
    ///
    /// # Errors
    /// Usage: the small-angle regime of a whisker that is curved at rest or jointed.
    pub fn in_regime(&self, regime: MomentRegime, moment: f64) -> Result<Self> {
        let small = match (regime, self.small) {
            (MomentRegime::LargeAngle, _) | (MomentRegime::Auto, None) => None,
            (MomentRegime::SmallAngle, None) => {
                return Err(Error::usage("the small-angle regime")
                    .allowed("whiskers that are straight at rest and in one piece")
                    .remedy("use the large-angle regime, which covers every whisker"));
            }
            (MomentRegime::SmallAngle, Some(small)) => Some(small),
            (MomentRegime::Auto, Some(small)) => {
                let displacement = small.tip_displacement(moment.abs());
                (displacement < SMALL_DISPLACEMENT * self.length).then_some(small)
            }
        };
        Ok(small.map_or_else(|| self.clone(), |beam| Self { mechanics: Mechanics::Small(beam), ..self.clone() }))
    }

    /// The contact under `force` (N) at arc length `s_a` (m); `None` beyond the first mode, off the whisker, and for numbers
    /// that are not finite. Limits are not asked.
    ///
    /// Under a vertical load this is the shape that grows from the whisker at rest.
    #[must_use]
    pub fn contact(&self, force: f64, s_a: f64) -> Option<Contact> {
        if !(s_a > 0.0 && s_a <= self.length * (1.0 + 1e-9) && force.is_finite()) {
            return None;
        }
        match (&self.mechanics, self.load) {
            (Mechanics::Small(beam), _) => Some(beam.contact(force, s_a)),
            (Mechanics::Uniform(ei), Load::Normal) => by_force(*ei, force, s_a).map(|b| Contact {
                force,
                s_a,
                phi_a: b.phi_a,
                position: b.contact,
                moment: b.moment,
                tilt: 0.0,
            }),
            (Mechanics::Uniform(ei), Load::Tilted(beta)) => bend(*ei, force, s_a, beta).map(|b| of_bend(&b)),
            (Mechanics::Uniform(ei), _) => {
                let whisker = Whisker { length: self.length, flexural_rigidity: *ei, ..Whisker::default() };
                force_mode(&whisker, force, s_a.min(self.length), self.load).ok()?.first().map(of_bend)
            }
            (Mechanics::Rod(rod), load) => on_rod(rod, load, force, s_a),
        }
    }

    /// The contact at the tip under `force` (N), tilted by `tilt` (rad) from the whisker's normal there, whatever the
    /// model's load; `None` beyond the first mode, for tilts beyond a right angle and for numbers that are not finite.
    ///
    /// A smooth wall without friction pushes along its own normal: it lies in the direction `phi_a + tilt`. The
    /// small-angle model counts the force across the whisker only.
    #[must_use]
    pub fn tip_contact(&self, force: f64, tilt: f64) -> Option<Contact> {
        if !(force.is_finite() && tilt.abs() <= FRAC_PI_2) {
            return None;
        }
        match &self.mechanics {
            Mechanics::Small(beam) => {
                Some(Contact { force, tilt, ..beam.contact(force * math::cos(tilt), self.length) })
            }
            Mechanics::Uniform(ei) => bend(*ei, force, self.length, tilt).map(|b| of_bend(&b)),
            Mechanics::Rod(rod) => {
                rod.touched(force, self.length, tilt).map(|t| of_touched(&t, force, self.length, tilt))
            }
        }
    }

    /// The contact under `force` at `s_a`, if it is within the limits.
    #[must_use]
    pub fn admitted(&self, force: f64, s_a: f64) -> Option<Contact> {
        self.contact(force, s_a).filter(|contact| self.limits.admit(contact))
    }

    /// `n` points of the whisker from base to tip for a contact of this model, whisker frame (m).
    #[must_use]
    pub fn shape(&self, contact: &Contact, n: usize) -> Vec<Vec2> {
        let s_a = contact.s_a.min(self.length);
        match &self.mechanics {
            Mechanics::Small(beam) => beam.shape(contact, n),
            Mechanics::Uniform(ei) => {
                bend(*ei, contact.force, s_a, contact.tilt).map_or_else(Vec::new, |b| b.shape(self.length, n))
            }
            Mechanics::Rod(rod) => {
                let bends = rod.force_mode(contact.force, s_a, Load::Tilted(contact.tilt)).unwrap_or_default();
                bends.first().map_or_else(Vec::new, |b| b.shape(self.length, n))
            }
        }
    }

    /// The contacts as a sheet, where it serves: anything but the closed family, small angles and vertical loads.
    ///
    /// The first call takes a tenth of a second.
    pub(super) fn sheet(&self) -> Option<&ContactSheet> {
        let uniform = |ei: f64| Whisker { length: self.length, flexural_rigidity: ei, ..Whisker::default() };
        if self.has_closed_family() || self.load == Load::Vertical {
            return None;
        }
        let made = || match &self.mechanics {
            Mechanics::Rod(rod) => ContactSheet::new(rod, self.sheet_tilt(), LAST_LOAD),
            Mechanics::Uniform(ei) => ContactSheet::new(&Rod::new(&uniform(*ei)).ok()?, self.sheet_tilt(), LAST_LOAD),
            Mechanics::Small(_) => None,
        };
        if self.is_small_angle() { None } else { self.sheet.0.get_or_init(made).as_ref() }
    }

    /// The tilt of a load that turns with the whisker (rad).
    pub(super) fn sheet_tilt(&self) -> f64 {
        match self.load {
            Load::Tilted(beta) => beta,
            _ => 0.0,
        }
    }

    /// Arc lengths that are told apart from the base: from this one on (m).
    pub(super) fn first_arc_length(&self) -> f64 {
        BASE_SHARE * self.length
    }

    /// The force that has load number `u` at `s_a` (N): for uniform whiskers `u = F s_a² / (2 EI)`.
    ///
    /// In small angles `u` is the slope at the contact; the shape of a uniform whisker depends on `u` alone.
    pub(super) fn force_of(&self, u: f64, s_a: f64) -> f64 {
        match &self.mechanics {
            Mechanics::Uniform(ei) => u * 2.0 * ei / (s_a * s_a),
            Mechanics::Rod(rod) => u / rod.slope_compliance(s_a),
            Mechanics::Small(beam) => u / beam.slope_compliance(s_a),
        }
    }

    /// The inverse of [`ContactModel::force_of`].
    pub(super) fn load_number(&self, force: f64, s_a: f64) -> f64 {
        force / self.force_of(1.0, s_a)
    }

    /// No shape has a larger load number.
    pub(super) fn last_load_number(&self) -> f64 {
        match (&self.mechanics, self.load) {
            (Mechanics::Uniform(_), Load::Normal) => LAST_NORMAL_LOAD,
            _ => LAST_LOAD,
        }
    }

    /// The force at which the first mode of a tilted load at the tip ends (N), where that is known in closed form:
    /// `EI (2 K(m) / L)²` with `m = (1 - sin |tilt|) / 2`, for tilts of the force's sign.
    pub(super) fn last_tip_force(&self, tilt: f64) -> Option<f64> {
        let Mechanics::Uniform(ei) = &self.mechanics else { return None };
        let (mut a, mut b) = (1.0, (0.5 * (1.0 + math::sin(tilt.abs()))).sqrt());
        // K = pi / (2 agm(1, sqrt(1 - m))); from 0.7 on, four rounds are exact.
        for _ in 0..4 {
            (a, b) = (0.5 * (a + b), (a * b).sqrt());
        }
        let end = PI / (a * self.length);
        Some(ei * end * end * (1.0 - 1e-14))
    }

    /// Whether exact readings have curves in closed form: uniform whiskers under a normal load.
    #[must_use]
    pub fn has_closed_family(&self) -> bool {
        self.normal_family().is_some()
    }

    /// The flexural rigidity, where the closed family of normal loads covers this model.
    pub(super) fn normal_family(&self) -> Option<f64> {
        match (&self.mechanics, self.load) {
            (Mechanics::Uniform(ei), Load::Normal) => Some(*ei),
            _ => None,
        }
    }
}

fn checked(load: Load) -> Result<Load> {
    match load {
        Load::Normal | Load::Vertical => Ok(load),
        Load::Tilted(beta) if beta.abs() < FRAC_PI_2 => Ok(load),
        _ => Err(Error::usage("the load")
            .value(format!("{load:?}"))
            .allowed("normal, vertical, tilted by less than a right angle")
            .remedy("a force along a wall's normal acts at the tip: see `flow::contact_set::tip`")),
    }
}

fn of_bend(b: &crate::beam::Bend) -> Contact {
    Contact { force: b.force, s_a: b.s_a, phi_a: b.phi_a, position: b.contact, moment: b.moment, tilt: b.beta }
}

fn on_rod(rod: &Rod, load: Load, force: f64, s_a: f64) -> Option<Contact> {
    let tilted = |beta: f64| rod.touched(force, s_a, beta);
    let touched = match load {
        Load::Tilted(beta) => tilted(beta),
        Load::Vertical => vertical(&tilted),
        _ => tilted(0.0),
    }?;
    let tilt = match load {
        Load::Tilted(beta) => beta,
        Load::Vertical => -touched.phi_a,
        _ => 0.0,
    };
    Some(of_touched(&touched, force, s_a, tilt))
}

fn of_touched(touched: &crate::beam::rod::Touched, force: f64, s_a: f64, tilt: f64) -> Contact {
    Contact { force, s_a, phi_a: touched.phi_a, position: touched.contact, moment: touched.moment, tilt }
}

/// The shape whose force is vertical: the tilt that undoes the slope, found between no tilt and a right angle.
fn vertical(tilted: &impl Fn(f64) -> Option<crate::beam::rod::Touched>) -> Option<crate::beam::rod::Touched> {
    let gap = |beta: f64| tilted(beta).map(|t| t.phi_a + beta);
    let start = gap(0.0).or_else(|| gap(0.5)).or_else(|| gap(-0.5))?;
    // The slope grows with the tilt's size against it; the vertical shape leans less than a right angle.
    let (mut a, mut b) = (0.0, -FRAC_PI_2.copysign(start));
    for _ in 0..TILT_STEPS {
        let middle = 0.5 * (a + b);
        match gap(middle) {
            Some(g) if g * start <= 0.0 => b = middle,
            _ => a = middle,
        }
        if (a - b).abs() < 1e-15 {
            break;
        }
    }
    tilted(0.5 * (a + b))
}
