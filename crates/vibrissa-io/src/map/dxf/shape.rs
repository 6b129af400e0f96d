//! The curve of one entity, in drawing units.

use super::groups::{Entity, number};
use super::spline::Spline;
use crate::config::budgets::MOST_PIECES;
use crate::math;
use crate::plane::{Segment, Vec2, arc_to_cubics};
use crate::{Error, Result};
use core::f64::consts::TAU;

/// Pieces that follow one another.
pub(super) struct Chain {
    pub(super) segments: Vec<Segment>,
    pub(super) closed: bool,
}

/// Whether a curve is read from entities of this kind.
pub(super) fn is_shape(kind: &str) -> bool {
    matches!(kind, "LINE" | "LWPOLYLINE" | "POLYLINE" | "ARC" | "CIRCLE" | "ELLIPSE" | "SPLINE")
}

/// The entity's curve; `vertices` follow a POLYLINE. Arcs and splines are within `tolerance` (drawing units).
pub(super) fn chain(entity: &Entity<'_>, vertices: &[Entity<'_>], tolerance: f64) -> Result<Chain> {
    let open = |segments| Chain { segments, closed: false };
    let mirrored = mirrored(entity)?;
    let found = match entity.kind {
        "LINE" => {
            let [a, b] = [[10, 20], [11, 21]].map(|codes| point(entity, codes));
            return Ok(open(vec![Segment::Line([a?, b?])]));
        }
        "ARC" => {
            let (from, to) = (entity.due(50)?.to_radians(), entity.due(51)?.to_radians());
            open(round(entity, from, (to - from).rem_euclid(TAU), tolerance)?)
        }
        "CIRCLE" => Chain { segments: round(entity, 0.0, TAU, tolerance)?, closed: true },
        "ELLIPSE" => return ellipse(entity, if mirrored { -1.0 } else { 1.0 }, tolerance),
        "SPLINE" => return spline(entity, tolerance),
        "LWPOLYLINE" => polyline(&light_vertices(entity)?, entity.flags()? & 1 == 1, tolerance),
        _ => heavy(entity, vertices, tolerance)?,
    };
    // Flat shapes seen from below the drawing plane have their own x axis turned round.
    Ok(if mirrored { Chain { segments: found.segments.iter().map(flipped).collect(), ..found } } else { found })
}

fn flipped(segment: &Segment) -> Segment {
    let flip = |p: Vec2| Vec2::new(-p.x, p.y);
    match *segment {
        Segment::Line(p) => Segment::Line(p.map(flip)),
        Segment::Quadratic(p) => Segment::Quadratic(p.map(flip)),
        Segment::Cubic(p) => Segment::Cubic(p.map(flip)),
    }
}

/// Whether the entity is seen from below; other directions are no map.
fn mirrored(entity: &Entity<'_>) -> Result<bool> {
    let axis = [210, 220, 230].map(|code| entity.number(code));
    let [x, y, z] = axis;
    let (x, y, z) = (x?.unwrap_or(0.0), y?.unwrap_or(0.0), z?.unwrap_or(1.0));
    if x.abs().max(y.abs()) > 1e-6 * z.abs() {
        return Err(Error::data("does not lie in the drawing plane")
            .at_line(entity.line)
            .value(format!("extrusion ({x}, {y}, {z})"))
            .remedy("draw the map as a plan view, z up"));
    }
    Ok(z < 0.0)
}

fn point(entity: &Entity<'_>, [x, y]: [i32; 2]) -> Result<Vec2> {
    Ok(Vec2::new(entity.due(x)?, entity.due(y)?))
}

fn round(entity: &Entity<'_>, from: f64, sweep: f64, tolerance: f64) -> Result<Vec<Segment>> {
    let (center, radius) = (point(entity, [10, 20])?, entity.due(40)?);
    if radius <= 0.0 {
        return Err(Error::data("the radius").at_line(entity.line).value(radius).allowed("above 0"));
    }
    Ok(arc_to_cubics(center, Vec2::new(radius, radius), 0.0, from, sweep, tolerance))
}

fn ellipse(entity: &Entity<'_>, side: f64, tolerance: f64) -> Result<Chain> {
    let (center, axis, ratio) = (point(entity, [10, 20])?, point(entity, [11, 21])?, entity.due(40)?);
    let (from, to) = (entity.number(41)?.unwrap_or(0.0), entity.number(42)?.unwrap_or(TAU));
    if !(ratio > 0.0 && axis.norm() > 0.0) {
        return Err(Error::data("the ellipse has no width").at_line(entity.line).value(ratio).allowed("above 0"));
    }
    let turn = (to - from).rem_euclid(TAU);
    let closed = turn < 1e-9 || TAU - turn < 1e-9;
    let sweep = if closed { TAU } else { turn };
    let radii = axis.norm() * Vec2::new(1.0, ratio);
    let segments = arc_to_cubics(center, radii, math::atan2(axis.y, axis.x), side * from, side * sweep, tolerance);
    Ok(Chain { segments, closed })
}

fn spline(entity: &Entity<'_>, tolerance: f64) -> Result<Chain> {
    let (x, y) = (entity.numbers(10)?, entity.numbers(20)?);
    let points: Vec<Vec2> = x.into_iter().zip(y).map(|(x, y)| Vec2::new(x, y)).collect();
    let spline = Spline::new(entity.due(71)?, entity.numbers(40)?, &points, &entity.numbers(41)?);
    let segments = spline.map_err(|error| error.at_line(entity.line))?.cubics(tolerance);
    Ok(Chain { segments, closed: false })
}

/// A corner and the bulge of the piece after it: the tangent of a quarter of the arc's angle.
type Vertex = (Vec2, f64);

fn light_vertices(entity: &Entity<'_>) -> Result<Vec<Vertex>> {
    let mut vertices: Vec<Vertex> = Vec::new();
    for group in entity.groups {
        if vertices.len() > MOST_PIECES + 1 {
            break;
        }
        match (group.code, vertices.last_mut()) {
            (10, _) => vertices.push((Vec2::new(number(group)?, 0.0), 0.0)),
            (20, Some(last)) => last.0.y = number(group)?,
            (42, Some(last)) => last.1 = number(group)?,
            _ => {}
        }
    }
    Ok(vertices)
}

fn heavy(entity: &Entity<'_>, vertices: &[Entity<'_>], tolerance: f64) -> Result<Chain> {
    let flags = entity.flags()?;
    if flags & (16 | 64) != 0 {
        return Err(Error::data("is a mesh, not a line").at_line(entity.line).remedy("draw the outline as a polyline"));
    }
    let mut corners = Vec::new();
    for vertex in vertices {
        // Control points of a fitted curve lie beside it.
        if vertex.flags()? & 16 == 0 {
            corners.push((point(vertex, [10, 20])?, vertex.number(42)?.unwrap_or(0.0)));
        }
    }
    Ok(polyline(&corners, flags & 1 == 1, tolerance))
}

fn polyline(vertices: &[Vertex], closed: bool, tolerance: f64) -> Chain {
    let mut segments = Vec::new();
    let back = vertices.first().filter(|_| closed);
    for (&(a, bulge), &(b, _)) in vertices.iter().zip(vertices.iter().skip(1).chain(back)) {
        bulged(a, b, bulge, tolerance, &mut segments);
        // More than a map may have is refused when the pieces are counted.
        if segments.len() > MOST_PIECES {
            break;
        }
    }
    Chain { segments, closed }
}

/// The line or arc from `a` to `b`; a positive bulge runs counter-clockwise.
fn bulged(a: Vec2, b: Vec2, bulge: f64, tolerance: f64, out: &mut Vec<Segment>) {
    let chord = b - a;
    let sagitta = 0.5 * bulge.abs() * chord.norm();
    if a == b {
        return;
    }
    if sagitta <= 1e-3 * tolerance {
        out.push(Segment::Line([a, b]));
        return;
    }
    let sweep = 4.0 * math::atan(bulge);
    // From the chord's middle to the centre: half the chord over the tangent of half the sweep.
    let center = 0.5 * (a + b) + chord.perp() * ((1.0 - bulge * bulge) / (4.0 * bulge));
    let radius = a.distance(center);
    let from = a - center;
    let mut arc = arc_to_cubics(center, Vec2::new(radius, radius), 0.0, math::atan2(from.y, from.x), sweep, tolerance);
    // The corners stay where they were drawn.
    if let Some(Segment::Cubic(first)) = arc.first_mut() {
        first[0] = a;
    }
    if let Some(Segment::Cubic(last)) = arc.last_mut() {
        last[3] = b;
    }
    out.append(&mut arc);
}
