//! The figure of bent whiskers.

use vibrissa::beam::Bend;
use vibrissa::figure::numbers::{fixed, significant};
use vibrissa::figure::{Geometry, HUES, Layer, scene_figure};
use vibrissa::plane::Vec2;

/// Length of a force's arrow and of its head, as shares of the whisker's length.
const ARROW: f64 = 0.12;
const HEAD: f64 = 0.022;
/// From the contact to the arrow's tip, likewise.
const GAP: f64 = 0.012;

/// The whiskers of one problem from base to tip, with contact points and forces, as SVG.
pub(super) fn figure(solutions: &[Bend], length: f64) -> String {
    let layer = |geometry, class, label: String| Layer { geometry, class, label, framed: true };
    let rest = vec![vec![Vec2::ZERO, Vec2::new(length, 0.0)]];
    let mut layers = vec![layer(Geometry::Lines(rest), "undeflected", "the whisker at rest".into())];
    for (index, bend) in solutions.iter().enumerate() {
        let words = format!(
            "{} N at ({}, {}) mm, M(0) {} mN m",
            significant(bend.force, 4),
            fixed(bend.contact.x * 1e3, 3),
            fixed(bend.contact.y * 1e3, 3),
            significant(bend.moment * 1e3, 4)
        );
        layers.push(layer(Geometry::Lines(vec![bend.shape(length, 201)]), HUES[index % HUES.len()], words));
    }
    let arrows = solutions.iter().filter_map(|bend| arrow(bend, length)).flatten().collect();
    let contacts = solutions.iter().map(|bend| bend.contact).collect();
    layers.extend([
        layer(Geometry::Lines(arrows), "force", "force on the whisker".into()),
        layer(Geometry::Dots(contacts), "contact-point", "contact".into()),
        layer(Geometry::Circles(vec![Vec2::ZERO]), "base", "base".into()),
    ]);
    let title = if solutions.len() == 1 { "A bent whisker" } else { "The equilibria of a whisker" };
    scene_figure(title, &[], "whisker frame", &layers)
}

/// Shaft and head of a force's arrow, which ends at the contact on the side from which the force pushes; none without a force.
fn arrow(bend: &Bend, length: f64) -> Option<[Vec<Vec2>; 2]> {
    let force = bend.force_vector();
    let size = force.norm();
    let along = (size > 0.0).then(|| force * (1.0 / size))?;
    let at = |back: f64, across: f64| bend.contact - along * (back * length) + along.perp() * (across * length);
    let head = vec![at(GAP + HEAD, 0.35 * HEAD), at(GAP, 0.0), at(GAP + HEAD, -0.35 * HEAD)];
    Some([vec![at(ARROW, 0.0), at(GAP, 0.0)], head])
}
