//! The table of a whisker that leans against upright walls, against the closed form that is turned into space by vectors.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must fail")]

#[path = "../../vibrissa/tests/data/random.rs"]
mod random;
#[path = "../../vibrissa/tests/data/space.rs"]
mod space;

use core::f64::consts::{FRAC_PI_2, PI, TAU};
use random::Random;
use space::{cross, dot, plus};
use vibrissa_beam::beam::elastica;
use vibrissa_beam::beam::press::{LeaningPressTable, PressEntry, PressSlice, PressTable};
use vibrissa_beam::plane::Vec2;

fn holds(entry: &PressEntry, direction: f64, p: Vec2) -> bool {
    let rest = p - entry.center - entry.by_direction * (direction - entry.middle);
    let square = entry.by_moment.norm_squared();
    let share = if square > 0.0 { (rest.dot(entry.by_moment) / square).clamp(-1.0, 1.0) } else { 0.0 };
    (direction - entry.middle).abs() <= entry.half + 1e-9 && (rest - entry.by_moment * share).norm() <= entry.radius
}

fn known(slice: &PressSlice, direction: f64, p: Vec2) -> bool {
    slice.between(direction, direction).iter().any(|entry| holds(entry, direction, p))
}

/// A contact in space: the direction of the wall's normal from the axis (rad), the place as the map sees it, the reading.
struct Contact {
    direction: f64,
    seen: Vec2,
    reading: f64,
    /// Whether the whisker is bent away from the force.
    curled: bool,
}

/// A whisker of unit length and rigidity, elevation and roll as told, held by an upright wall at its tip or side.
fn contact(draw: &mut Random, (elevation, roll): (f64, f64)) -> Option<Contact> {
    let is_tip = draw.unit() < 0.6;
    let (s_a, beta) = if is_tip { (1.0, draw.between(0.0, FRAC_PI_2)) } else { (draw.between(0.05, 1.0), 0.0) };
    let force = draw.between(0.05, 4.0).powi(2);
    let bend = elastica::bend(1.0, force, s_a, beta)?;
    // The direction of the force in the plane, and what the wall's normal makes with the axis.
    let psi = bend.phi_a + beta + FRAC_PI_2;
    let cosine = psi.cos() / elevation.cos();
    if bend.moment <= 0.0 || bend.phi_a > PI || cosine.abs() > 1.0 {
        return None;
    }
    let direction = if draw.unit() < 0.5 { cosine.acos() } else { TAU - cosine.acos() };
    let axis = [elevation.cos(), 0.0, elevation.sin()];
    let normal = [direction.cos(), direction.sin(), 0.0];
    let across = plus(normal, axis, -dot(normal, axis));
    let size = dot(across, across).sqrt();
    if size < 1e-9 {
        return None;
    }
    // Towards the force, or away from it where the whisker is curled.
    let across = across.map(|v| v * psi.sin().signum() / size);
    let place = plus(axis.map(|v| v * bend.contact.x), across, bend.contact.y);
    let pushed = normal.map(|v| v * force);
    let level = [0.0, 1.0, 0.0];
    let left = plus(level.map(|v| v * roll.cos()), cross(axis, level), roll.sin());
    let moment = cross(place, pushed);
    assert!(
        (dot(moment, moment).sqrt() - bend.moment).abs() < 1e-6 * bend.moment,
        "the plane is not that of axis and force"
    );
    let reading = dot(moment, cross(axis, left));
    Some(Contact { direction, seen: Vec2::new(place[0], place[1]), reading, curled: psi > PI })
}

#[test]
fn no_contact_of_a_leaning_whisker_is_left_out() {
    let mut draw = Random(5);
    let fine = PressTable::new(32, 32, 0.0, PI);
    let tables = [(fine.coarser(), 16), (fine, 32)];
    let (mut tried, mut curled, mut zero) = (0, 0, 0);
    for round in 0..28 {
        let (elevation, roll) = match round {
            0 => (80.0 / 360.0 * TAU, 0.0),
            1 => (-80.0 / 360.0 * TAU, 3.0),
            2 => (0.0, FRAC_PI_2 - 0.01),
            3 => (1e-9, 0.0),
            4 => (0.0, 0.0),
            5 => (0.01, -0.4),
            _ => (draw.signed(1.2), draw.signed(PI)),
        };
        let leaning = tables.clone().map(|(table, buckets)| LeaningPressTable::new(table, elevation, roll, buckets));
        for _ in 0..40 {
            let Some(contact) = contact(&mut draw, (elevation, roll)) else { continue };
            let (below, above) = (draw.between(0.0, 0.05), draw.between(0.0, 0.05));
            let size = contact.reading.abs();
            let (mut lo, mut hi) =
                (contact.reading - below * size - 1e-9, contact.reading + above * size + 1e-3 * draw.unit());
            // Small readings may be none.
            if size < 0.1 {
                (lo, hi) = (lo.min(0.0), hi.max(0.0));
            }
            for table in &leaning {
                let slice = table.slice(1.0, lo, hi);
                assert!(
                    known(&slice, contact.direction, contact.seen),
                    "elevation {elevation}, roll {roll}, direction {}: {:?} reads {}",
                    contact.direction,
                    contact.seen,
                    contact.reading
                );
                assert!(table.slice(-1.0, lo, hi).entries().is_empty());
            }
            tried += 1;
            curled += usize::from(contact.curled);
            zero += usize::from(lo <= 0.0 && hi >= 0.0);
        }
    }
    println!("{tried} contacts, {curled} of them curled, {zero} with a reading that may be none");
    assert!(tried > 600 && curled > 50 && zero > 10, "{tried} {curled} {zero}");
}

/// What the turned plane adds to the bounds of the planar table is small where the whisker stands well to the wall.
#[test]
fn a_level_whiskers_contacts_are_those_of_the_plane() {
    let table = PressTable::new(64, 64, 0.0, PI);
    let leaning = LeaningPressTable::new(table.clone(), 0.3, 0.0, 64);
    let level = LeaningPressTable::new(table.clone(), 0.0, 0.0, 64);
    let typical = |slice: &PressSlice| {
        let mut radii: Vec<f64> = slice.entries().iter().map(|entry| entry.radius).collect();
        radii.sort_by(f64::total_cmp);
        radii[radii.len() / 2]
    };
    let (planar, same, other) = (table.slice(0.9, 0.95), level.slice(1.0, 0.9, 0.95), leaning.slice(1.0, 0.9, 0.95));
    println!(
        "typical radius: planar {:.2e}, level {:.2e}, leaning {:.2e}",
        typical(&planar),
        typical(&same),
        typical(&other)
    );
    assert!(typical(&same) < 1.5 * typical(&planar) + 1e-5 && typical(&other) < 3.0 * typical(&planar) + 1e-4);
}
