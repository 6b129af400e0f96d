//! The line at a standoff from the map's boundary.

use crate::config::scenario::{CHORD, MOST_CHORDS};
use crate::plane::Vec2;
use crate::world::Map;
use crate::{Error, Result};

/// How far a point may be from the standoff (m): Bézier walls are looked up to about this.
const LEVEL: f64 = 1e-8;
/// Projections away from one wall after another before there is no room.
const MOST_PROJECTIONS: usize = 100;
/// Steps in a row that may gain less than a hundredth of a chord before the way counts as blocked.
const PATIENCE: usize = 200;

/// The points at `standoff` (m) from the nearest boundary, for `length` (m) of way, with the directions of travel; the
/// wall is on the left or on the right.
///
/// The line is a level of the distance to all boundaries: it goes round convex corners in arcs and turns sharply in
/// concave ones.
///
/// # Errors
///
/// A passage narrower than twice the standoff, a way that gets stuck, or more chords than anybody needs.
pub(super) fn at_standoff(
    map: &Map,
    from: Vec2,
    on_left: bool,
    standoff: f64,
    length: f64,
) -> Result<Vec<(Vec2, f64)>> {
    if length / CHORD > MOST_CHORDS {
        return Err(Error::data("the way along the wall is too long")
            .value(format!("{length} m"))
            .allowed(format!("up to {} m", CHORD * MOST_CHORDS)));
    }
    let mut here = level(map, from, standoff)?;
    let mut chain = vec![(here.0, direction(here.1, on_left))];
    let (mut gone, mut stuck) = (0.0, 0);
    while gone < length {
        let step = CHORD.min(length - gone);
        let ahead = Vec2::from_angle(direction(here.1, on_left));
        let next = level(map, here.0 + ahead * step, standoff)?;
        let gained = next.0.distance(here.0);
        stuck = if gained < 0.01 * step { stuck + 1 } else { 0 };
        if stuck > PATIENCE {
            return Err(Error::data("the way along the wall ends")
                .value(format!("at ({:.4}, {:.4}) m, after {gone:.3} m", next.0.x, next.0.y))
                .remedy("shorten the leg or choose a smaller standoff: the passage is too narrow there"));
        }
        if stuck == 0 {
            gone += gained.min(2.0 * step).max(0.01 * step);
            chain.push((next.0, direction(next.1, on_left)));
        }
        here = next;
        if length - gone < 1e-9 {
            break;
        }
    }
    Ok(chain)
}

/// The point near `p` at the standoff from the nearest boundary, and the normal there (rad), from the boundary to the
/// robot.
fn level(map: &Map, p: Vec2, standoff: f64) -> Result<(Vec2, f64)> {
    // In a concave corner two walls are equally near; the one that pushed last is the one to go on along.
    let (mut here, mut pushed) = (p, None);
    for _ in 0..MOST_PROJECTIONS {
        let near = map.nearest(here).filter(|near| near.distance > 0.0).ok_or_else(|| {
            Error::data("the robot stands on a boundary").value(format!("({:.4}, {:.4}) m", p.x, p.y))
        })?;
        let normal = (here - near.position).angle();
        if (near.distance - standoff).abs() < LEVEL {
            return Ok((here, pushed.unwrap_or(normal)));
        }
        here = near.position + Vec2::from_angle(normal) * standoff;
        pushed = Some(normal);
    }
    // Away from one wall it comes too near to another.
    Err(Error::data("there is no room for this standoff")
        .value(format!("{standoff} m near ({:.4}, {:.4}) m", p.x, p.y))
        .remedy("choose a standoff below half the width of the passage, or end the leg before it narrows"))
}

/// The direction of travel with the wall on this side (rad).
fn direction(normal: f64, on_left: bool) -> f64 {
    if on_left { normal + core::f64::consts::FRAC_PI_2 } else { normal - core::f64::consts::FRAC_PI_2 }
}
