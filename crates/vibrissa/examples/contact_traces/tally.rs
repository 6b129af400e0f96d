//! Errors of contacts and what was told of them.

use vibrissa::plane::Vec2;
use vibrissa::tasks::contact::{ContactKind, ContactReport, ContactStep};

/// A true contact.
pub(crate) struct True {
    pub(crate) t: f64,
    pub(crate) whisker: usize,
    pub(crate) position: Vec2,
    pub(crate) side: bool,
}

/// The steps of one sweep or of many.
#[derive(Default)]
pub(crate) struct Tally {
    /// Distance from the truth, and whether two of the standard deviations told hold the part of it that they speak of.
    errors: Vec<(f64, bool)>,
    steps: usize,
    sides: usize,
    sweeps: usize,
    wrong_kind: usize,
}

/// Where a step is nearer in time than this to a contact, it is that contact (s).
const SAME: f64 = 0.02;

impl Tally {
    pub(crate) const HEAD: &str = "sweeps | steps | with the side | found | other kind | mean mm | 95 % mm | worst mm | over 2 mm | in 2 std | told sweep";

    pub(crate) fn add(&mut self, report: &ContactReport, truths: &[True], show: bool) {
        self.sweeps += 1;
        if show {
            report.events.iter().for_each(|e| println!("    {:.4} {} {}", e.t, e.kind, e.detail));
        }
        for step in &report.steps {
            let near = truths.iter().filter(|t| t.whisker == step.whisker);
            let Some(truth) = near.min_by(|a, b| (a.t - step.t).abs().total_cmp(&(b.t - step.t).abs())) else {
                continue;
            };
            if (truth.t - step.t).abs() > SAME {
                continue;
            }
            self.steps += 1;
            self.sides += usize::from(truth.side);
            let Some(position) = step.position() else {
                if show {
                    println!("    {:.4} none, true {}", step.t, if truth.side { "side" } else { "tip" });
                }
                continue;
            };
            let off = position - truth.position;
            self.wrong_kind += usize::from((step.kind == ContactKind::Side) != truth.side);
            let told = told(step, off);
            self.errors.push((off.norm(), told));
            if show {
                println!(
                    "    {:.4} {} true {} s_a {:.2} off {:.3} mm, std {:.3} mm, held {told}, moment {:.4e}, at ({:.2}, {:.2}) true ({:.2}, {:.2})",
                    step.t,
                    step.kind.word(),
                    if truth.side { "side" } else { "tip" },
                    1e3 * step.s_a.unwrap_or(0.0),
                    1e3 * off.norm(),
                    1e3 * step.std.unwrap_or(f64::NAN),
                    step.moment,
                    1e3 * position.x,
                    1e3 * position.y,
                    1e3 * truth.position.x,
                    1e3 * truth.position.y
                );
            }
        }
    }

    pub(crate) fn join(&mut self, other: Self) {
        self.errors.extend(other.errors);
        self.steps += other.steps;
        self.sides += other.sides;
        self.sweeps += other.sweeps;
        self.wrong_kind += other.wrong_kind;
    }

    pub(crate) fn worst(&self) -> f64 {
        self.errors.iter().map(|e| e.0).fold(0.0, f64::max)
    }

    pub(crate) fn row(&self, name: &str) -> String {
        let mut errors: Vec<f64> = self.errors.iter().map(|e| 1e3 * e.0).collect();
        errors.sort_by(f64::total_cmp);
        let count = errors.len().max(1) as f64;
        let mean = errors.iter().sum::<f64>() / count;
        let high = errors.get((0.95 * count) as usize).or(errors.last()).copied().unwrap_or(0.0);
        let far = errors.iter().filter(|e| **e > 2.0).count();
        let told = self.errors.iter().filter(|e| e.1).count() as f64 / count;
        format!(
            "{} | {} | {} | {} | {} | {mean:.3} | {high:.2} | {:.2} | {far} | {told:.3} | {name}",
            self.sweeps,
            self.steps,
            self.sides,
            self.errors.len(),
            self.wrong_kind,
            errors.last().copied().unwrap_or(0.0),
        )
    }
}

/// Whether the error, as far as it is told (along the distance for a side, across the wall for a tip), is within two standard
/// deviations and what a row's time leaves open.
fn told(step: &ContactStep, off: Vec2) -> bool {
    let outward = step.contact.map_or(0.0, |c| step.odom_from_whisker.theta + c.angle());
    let direction = Vec2::from_angle(step.normal.unwrap_or(outward));
    off.dot(direction).abs() <= 2.0 * step.std.unwrap_or(0.0) + 2e-5
}
