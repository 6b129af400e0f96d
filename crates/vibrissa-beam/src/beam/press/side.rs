//! Side contacts by the wall's direction: up to scale there is one for each, but for friction.

use super::sheet::PressBend;
use super::{PressEntry, PressNode, ROUNDING, SAFETY, SheetError};
use crate::plane::Vec2;
use alloc::vec::Vec;
use core::f64::consts::{FRAC_PI_2, PI};
#[cfg(not(feature = "std"))]
use num_traits::Float as _;

/// What the friction's deviation may exceed that at the ends and halves of its range by.
const FRICTION_SAFETY: f64 = 1.2;

/// The side contacts for one direction of the wall: at the arc length `reach / mu` the contact is `scaled / mu`.
#[derive(Clone, Copy, Debug)]
struct SideTable {
    reach: f64,
    scaled: Vec2,
}

/// The side contacts of one column over their arc length: `center + along (psi - middle)` up to `gap`; smooth where the
/// moment vanishes, too.
#[derive(Clone, Copy, Debug)]
struct SideOutline {
    center: Vec2,
    along: Vec2,
    gap: f64,
}

/// The side contacts of every direction, bent one way or with an inflection.
#[derive(Clone, Debug)]
pub(super) struct Sides {
    sides: Vec<SideTable>,
    gaps: Vec<SheetError>,
    /// The largest deviation of a side contact by friction, for each column.
    slack: Vec<SheetError>,
    outlines: Vec<SideOutline>,
}

/// A column: the middle and half of its range of directions (rad).
pub(super) type Column = (f64, f64);

impl Sides {
    pub(super) fn new(directions: &[f64], bend: PressBend, slack: f64) -> Self {
        let gap = |d: &[f64]| {
            let (at, a, b) = (side(bend, 0.5 * (d[0] + d[1]), 0.0), side(bend, d[0], 0.0), side(bend, d[1], 0.0));
            SheetError {
                moment: SAFETY * (at.reach - 0.5 * (a.reach + b.reach)).abs() + ROUNDING,
                tip: SAFETY * (at.scaled - (a.scaled + b.scaled) * 0.5).norm() + ROUNDING,
            }
        };
        Self {
            sides: directions.iter().map(|&d| side(bend, d, 0.0)).collect(),
            gaps: directions.windows(2).map(gap).collect(),
            slack: directions.iter().map(|&d| friction_slack(bend, d, slack)).collect(),
            outlines: directions.windows(2).map(|d| outline(bend, d[0], d[1], slack)).collect(),
        }
    }

    /// The side contacts of one column that cause a moment between `lo` and `hi`.
    pub(super) fn entry(&self, column: usize, (lo, hi): (f64, f64), (middle, half): Column) -> Option<PressEntry> {
        let (a, b) = (self.sides[column], self.sides[column + 1]);
        let (gap, slack) = (self.gaps[column], [self.slack[column], self.slack[column + 1]]);
        let moment_slack = gap.moment + slack[0].moment.max(slack[1].moment);
        let tip_slack = gap.tip + slack[0].tip.max(slack[1].tip);
        // The contact is on the whisker: reach / mu <= 1.
        let least = (a.reach.min(b.reach) - moment_slack).max(0.0);
        if hi <= 0.0 || least > hi {
            return None;
        }
        let most = a.reach.max(b.reach) + moment_slack;
        let lo = lo.max(least).max(1e-12);
        if most > lo || moment_slack > 0.1 * lo {
            // Cut at the tip, or all but no moment at all: by arc length.
            return Some(self.short(column, (least / hi, (most / lo).min(1.0)), (middle, half)));
        }
        let (near, far) = (1.0 / hi, 1.0 / lo);
        let (inverse, spread) = (0.5 * (near + far), 0.5 * (far - near));
        let center = (a.scaled + b.scaled) * 0.5;
        let along = (b.scaled - a.scaled) * (0.5 / half);
        Some(PressEntry {
            middle,
            half,
            center: center * inverse,
            by_direction: along * inverse,
            by_moment: center * spread,
            radius: along.norm_squared().sqrt() * half * spread + tip_slack * far,
            inflected: false,
        })
    }

    /// Side contacts with arc lengths in a range, over the whisker's.
    fn short(&self, column: usize, (least, most): (f64, f64), (middle, half): Column) -> PressEntry {
        let SideOutline { center, along, gap } = self.outlines[column];
        let (arc, spread) = (0.5 * (least + most), 0.5 * (most - least).max(0.0));
        PressEntry {
            middle,
            half,
            center: center * arc,
            by_direction: along * arc,
            by_moment: center * spread,
            radius: along.norm_squared().sqrt() * half * spread + gap * most + ROUNDING,
            inflected: false,
        }
    }
}

/// The slope at the contact where the whisker's normal there has this direction (rad).
fn slope(direction: f64) -> f64 {
    (direction - FRAC_PI_2).clamp(0.0, PI)
}

/// The side contacts where the whisker's normal at the contact has this direction, and the force is tilted by `beta`.
fn side(bend: PressBend, direction: f64, beta: f64) -> SideTable {
    let PressNode { moment, tip } = bend.tip(beta, slope(direction));
    SideTable { reach: moment, scaled: tip * moment }
}

fn outline(bend: PressBend, left: f64, right: f64, slack: f64) -> SideOutline {
    let shape = |direction: f64, beta: f64| bend.tip(beta, slope(direction)).tip;
    let (middle, half) = (0.5 * (left + right), 0.5 * (right - left));
    let (a, b) = (shape(left, 0.0), shape(right, 0.0));
    let (center, along) = ((a + b) * 0.5, (b - a) * (0.5 / half));
    let off = [left, middle, right].into_iter().flat_map(|d| [-1.0, -0.5, 0.0, 0.5, 1.0].map(|s| (d, s * slack)));
    let gap = off.map(|(d, beta)| (shape(d, beta) - center - along * (d - middle)).norm()).fold(0.0, f64::max);
    SideOutline { center, along, gap: SAFETY * gap }
}

fn friction_slack(bend: PressBend, direction: f64, slack: f64) -> SheetError {
    let mut gap = SheetError { moment: 0.0, tip: 0.0 };
    if slack > 0.0 {
        let middle = side(bend, direction, 0.0);
        for share in [-1.0, -0.5, 0.5, 1.0] {
            let at = side(bend, direction, share * slack);
            gap.moment = gap.moment.max((at.reach - middle.reach).abs());
            gap.tip = gap.tip.max(at.scaled.distance(middle.scaled));
        }
        gap = SheetError { moment: FRICTION_SAFETY * gap.moment, tip: FRICTION_SAFETY * gap.tip };
    }
    gap
}
