//! The outlines of one element, in metres.

use super::path::{Builder, path};
use crate::plane::{Curve, Segment, Vec2};
use crate::world::{beyond_maps, out_of_range};
use crate::{Error, Result};
use kurbo::Affine;
use roxmltree::Node;
use std::str::FromStr;
use svgtypes::{Length, LengthUnit, PointsParser, Transform};

/// One subpath of an element.
pub(super) struct Outline {
    pub(super) curve: Curve,
}

/// Whether an element of this name draws an outline that can be read.
pub(super) fn is_shape(tag: &str) -> bool {
    matches!(tag, "path" | "polygon" | "polyline" | "line" | "rect" | "circle" | "ellipse")
}

/// The element's own transform.
pub(super) fn transform(node: Node<'_, '_>) -> Result<Affine> {
    let Some(text) = node.attribute("transform") else { return Ok(Affine::IDENTITY) };
    let read = Transform::from_str(text).ok().map(|t| [t.a, t.b, t.c, t.d, t.e, t.f]);
    match read.filter(|t| t.iter().all(|v| v.is_finite())) {
        Some(coefficients) => Ok(Affine::new(coefficients)),
        None => Err(Error::data("the transform cannot be read").value(text)),
    }
}

/// The element's subpaths that have a length.
pub(super) fn outlines(node: Node<'_, '_>, map_from_user: Affine) -> Result<Vec<Outline>> {
    let mut builder = Builder::new(map_from_user);
    match node.tag_name().name() {
        "path" => path(node.attribute("d").unwrap_or_default(), &mut builder)?,
        "polygon" => points(node, &mut builder, true)?,
        "polyline" => points(node, &mut builder, false)?,
        "line" => {
            let n = |key| number(node, key);
            builder.move_to(Vec2::new(n("x1")?, n("y1")?));
            builder.line_to(Vec2::new(n("x2")?, n("y2")?));
        }
        "rect" => rect(node, &mut builder)?,
        "circle" => {
            let r = positive(node, "r")?;
            builder.ellipse(Vec2::new(number(node, "cx")?, number(node, "cy")?), Vec2::new(r, r));
        }
        _ => {
            let radii = Vec2::new(positive(node, "rx")?, positive(node, "ry")?);
            builder.ellipse(Vec2::new(number(node, "cx")?, number(node, "cy")?), radii);
        }
    }
    let subpaths = builder.finish();
    let all_finite = |s: &[Segment]| s.iter().flat_map(Segment::control_points).all(|p| p.is_finite());
    if !subpaths.iter().all(|(segments, _)| all_finite(segments)) {
        return Err(Error::data("has a coordinate that is not a finite number"));
    }
    // Lengths of curves far beyond any map are slow to find and mean nothing.
    if let Some(p) = subpaths.iter().find_map(|(segments, _)| beyond_maps(segments)) {
        return Err(out_of_range(p));
    }
    let curves = subpaths.into_iter().filter_map(|(segments, closed)| Curve::from_segments(segments, closed));
    Ok(curves.map(|curve| Outline { curve }).collect())
}

fn points(node: Node<'_, '_>, builder: &mut Builder, closed: bool) -> Result<()> {
    let mut points = PointsParser::from(node.attribute("points").unwrap_or_default()).map(|(x, y)| Vec2::new(x, y));
    if let Some(first) = points.next() {
        builder.move_to(first);
        for p in points {
            builder.line_to(p);
            builder.check()?;
        }
        if closed {
            builder.close();
        }
    }
    Ok(())
}

fn rect(node: Node<'_, '_>, builder: &mut Builder) -> Result<()> {
    let (x, y) = (number(node, "x")?, number(node, "y")?);
    let (w, h) = (positive(node, "width")?, positive(node, "height")?);
    // One missing radius is as large as the other; neither exceeds half the side (SVG 2, section 10.2).
    let given = |key| if node.has_attribute(key) { number(node, key).map(Some) } else { Ok(None) };
    let (rx, ry) = (given("rx")?, given("ry")?);
    let rx_used = rx.or(ry).unwrap_or(0.0).clamp(0.0, 0.5 * w);
    let ry_used = ry.or(rx).unwrap_or(0.0).clamp(0.0, 0.5 * h);
    let at = |px: f64, py: f64| Vec2::new(x + px, y + py);
    if rx_used <= 0.0 || ry_used <= 0.0 {
        builder.move_to(at(0.0, 0.0));
        [at(w, 0.0), at(w, h), at(0.0, h)].into_iter().for_each(|p| builder.line_to(p));
        builder.close();
        return Ok(());
    }
    let radii = Vec2::new(rx_used, ry_used);
    let quarter = core::f64::consts::FRAC_PI_2;
    let corners = [
        (at(w - rx_used, ry_used), -quarter),
        (at(w - rx_used, h - ry_used), 0.0),
        (at(rx_used, h - ry_used), quarter),
        (at(rx_used, ry_used), 2.0 * quarter),
    ];
    builder.move_to(at(rx_used, 0.0));
    for (center, start) in corners {
        builder.arc(center, radii, 0.0, start, quarter);
    }
    builder.close();
    Ok(())
}

/// A number in user units; 0 when missing.
fn number(node: Node<'_, '_>, attribute: &str) -> Result<f64> {
    let Some(text) = node.attribute(attribute) else { return Ok(0.0) };
    match Length::from_str(text.trim()) {
        Ok(Length { number, unit: LengthUnit::None | LengthUnit::Px }) if number.is_finite() => Ok(number),
        Ok(_) => Err(Error::data(format!("{attribute} has a unit")).value(format!("\"{text}\"")).remedy(
            "shapes are read in plain user units; give the unit once, in the drawing's width, height and viewBox",
        )),
        Err(_) => Err(Error::data(format!("{attribute} is not a number")).value(format!("\"{text}\""))),
    }
}

fn positive(node: Node<'_, '_>, attribute: &str) -> Result<f64> {
    let value = number(node, attribute)?;
    if value > 0.0 {
        return Ok(value);
    }
    Err(Error::data(format!("{attribute} is missing or not positive")).value(value).allowed("above 0"))
}
