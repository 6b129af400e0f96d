//! Every point that explains two readings: where two contact sets cross.

use super::reading::ContactReading;
use crate::beam::{Load, moment_mode};
use crate::plane::Vec2;

/// Steps along a contact curve in which crossings are looked for.
const STEPS: usize = 120;
/// Bisections of a crossing: from a step to a nanometre.
const HALVINGS: usize = 40;
/// How near two bases are one and the same (m).
const SAME_BASE: f64 = 1e-9;

/// What two contact sets have in common at one point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeetingKind {
    /// A contact.
    Contact,
    /// The common base of a whisker that only turned: every curve begins there, nothing touches there.
    Base,
}

/// A point in which two contact sets cross.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Meeting {
    /// Where, odometry frame (m).
    pub position: Vec2,
    /// What it is.
    pub kind: MeetingKind,
    /// Arc length of the contact on the first and on the second whisker (m); 0 at the base.
    pub s_a: [f64; 2],
}

/// A point of the first curve, and by how much the second reading misses it (N m).
#[derive(Clone, Copy)]
struct CurveTrial {
    position: Vec2,
    s_a: [f64; 2],
    miss: f64,
}

/// Every crossing of the contact sets of two readings, two moments of one whisker or one moment of two: side contact,
/// both branches, the nearest to the first base first.
///
/// The sets need not cross in one point only \[departs from routray, section "Contact Uncertainty Reduction via
/// Filtering"\]. Empty when no fixed point explains both: the tip is sliding, the contact slipped, or was lost.
#[must_use]
pub fn meetings(first: &ContactReading, second: &ContactReading) -> Vec<Meeting> {
    let mut found = Vec::new();
    let (a, b) = (first.odom_from_whisker.position(), second.odom_from_whisker.position());
    if a.distance(b) < SAME_BASE {
        found.push(Meeting { position: a, kind: MeetingKind::Base, s_a: [0.0, 0.0] });
    }
    for branch in 0..2 {
        let at = |s_a: f64| tried(first, second, s_a, branch);
        let length = first.whisker.length;
        let samples: Vec<(f64, Option<CurveTrial>)> =
            (1..=STEPS).map(|i| length * i as f64 / STEPS as f64).map(|s_a| (s_a, at(s_a))).collect();
        for pair in samples.windows(2) {
            if let (Some(lo), Some(hi)) = (pair[0].1, pair[1].1)
                && (lo.miss < 0.0) != (hi.miss < 0.0)
            {
                found.extend(crossing(&at, (pair[0].0, lo), (pair[1].0, hi), second.moment.abs()));
            }
        }
    }
    let reach = second.whisker.length * (1.0 + 1e-9);
    found.retain(|meeting| meeting.s_a[1] <= reach);
    found.sort_by(|p, q| p.s_a[0].total_cmp(&q.s_a[0]));
    found
}

fn tried(first: &ContactReading, second: &ContactReading, s_a: f64, branch: usize) -> Option<CurveTrial> {
    let bends = moment_mode(&first.whisker, first.moment, s_a, Load::Normal).ok()?;
    let position = first.odom_from_whisker.transform_point(bends.get(branch)?.contact);
    let touched = second.touched(position)?;
    Some(CurveTrial { position, s_a: [s_a, touched.s_a], miss: touched.moment - second.moment })
}

/// The crossing between two arc lengths; none where the second curve jumps there instead.
fn crossing(
    at: &impl Fn(f64) -> Option<CurveTrial>,
    (mut lo, mut low): (f64, CurveTrial),
    (mut hi, mut high): (f64, CurveTrial),
    scale: f64,
) -> Option<Meeting> {
    for _ in 0..HALVINGS {
        let middle = 0.5 * (lo + hi);
        let tried = at(middle)?;
        if (tried.miss < 0.0) == (low.miss < 0.0) {
            (lo, low) = (middle, tried);
        } else {
            (hi, high) = (middle, tried);
        }
    }
    let best = if low.miss.abs() < high.miss.abs() { low } else { high };
    (best.miss.abs() <= 1e-6 * scale.max(1e-9)).then_some(Meeting {
        position: best.position,
        kind: MeetingKind::Contact,
        s_a: best.s_a,
    })
}
