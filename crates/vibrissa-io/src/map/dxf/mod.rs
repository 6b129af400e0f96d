//! Maps drawn in CAD programs: DXF, R12 to 2018, as text.

mod groups;
mod join;
mod shape;
mod spline;

use crate::config::budgets::{LONGEST_NAME, MOST_ENTITIES, MOST_LAYERS, MOST_OUTLINES};
use crate::config::limits::ARC_TOLERANCE;
use crate::plane::{Curve, Segment};
use crate::text::{beyond, did_you_mean, listed, short};
use crate::world::{Boundary, CurveFault, Map, MapCost, Role, beyond_maps, out_of_range};
use crate::{Error, Result};
use groups::{Entity, Group, entities, groups, section};
use join::{Piece, joined};
use std::path::Path;

/// What a drawing without a unit is taken to be in (m), as SVG maps are.
const MILLIMETRE: f64 = 1e-3;
/// The first bytes of the other kind of DXF.
const BINARY: &[u8] = b"AutoCAD Binary DXF";

/// What has been drawn with a role, and what has not.
#[derive(Default)]
struct Found<'a> {
    pieces: Vec<(Role, &'a str, Piece)>,
    /// Layers without a role that something readable is drawn on.
    ignored: Vec<&'a str>,
    cost: MapCost,
}

/// The map in the text of a DXF drawing (R12 to 2018); `name` stands for the file in messages.
///
/// The role of a line is the beginning of its layer's name: `arena…`, `obstacle…` or `wall…`; other layers are ignored
/// with a warning, and so is paper space. Read are LINE, ARC, CIRCLE, ELLIPSE, LWPOLYLINE and POLYLINE with bulges, and
/// SPLINE with control points. Pieces of an arena or an obstacle that meet end to end within a micrometre are one
/// outline; outlines within one another on a layer are holes by turns. `$INSUNITS` says the unit; a drawing without
/// one is in millimetres, with a warning. Lines stay lines; arcs and splines become cubics within 1e-9 m, and splines
/// up to degree three without weights are exact.
///
/// # Errors
///
/// What is not DXF, no layer with a role, open or self-crossing outlines, entities with a role that cannot be read
/// (blocks, hatches); the message names line and layer.
pub fn from_dxf(text: &str, name: &str) -> Result<Map> {
    parse(text).map_err(|error| error.in_file(name).or_remedy("correct it in the CAD program and export it again"))
}

fn parse(text: &str) -> Result<Map> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    if text.trim().is_empty() {
        return Err(Error::data("the map file is empty"));
    }
    let groups = groups(text)?;
    let (scale, doubt) = unit(section(&groups, "HEADER"))?;
    let drawn = section(&groups, "ENTITIES");
    if drawn.is_empty() {
        return Err(Error::data("nothing is drawn: the section ENTITIES is missing or empty"));
    }
    let count = drawn.iter().filter(|group| group.code == 0).count();
    if count > MOST_ENTITIES {
        return Err(beyond(
            "the drawing has too many entities",
            count,
            MOST_ENTITIES,
            "export the layers of the map alone",
        ));
    }
    let drawn = entities(drawn);
    let mut found = Found::default();
    found.collect(&drawn, scale)?;
    if found.pieces.is_empty() {
        return Err(no_roles(&found.ignored));
    }
    let mut map = Map::new(found.boundaries()?)?;
    map.warnings.extend(doubt);
    if !found.ignored.is_empty() {
        map.warnings.push(format!("layers without a role were ignored: {}", listed(&found.ignored)));
    }
    Ok(map)
}

/// The map in the bytes of a DXF file.
pub(super) fn from_bytes(bytes: &[u8], path: &Path) -> Result<Map> {
    if bytes.starts_with(BINARY) {
        return Err(Error::data("a binary DXF drawing")
            .in_file(path)
            .allowed("DXF as text (ASCII)")
            .remedy("save it as ASCII DXF"));
    }
    // Old drawings name layers in the code pages of their time; coordinates are plain digits in all of them.
    from_dxf(&String::from_utf8_lossy(bytes), &path.to_string_lossy())
}

/// The length of a drawing unit (m), and what is doubtful about it.
fn unit(header: &[Group<'_>]) -> Result<(f64, Option<String>)> {
    let named = header.iter().position(|group| group.code == 9 && group.value == "$INSUNITS");
    let Some(value) = named.and_then(|at| header.get(at + 1)) else {
        return Ok((MILLIMETRE, Some(assumed("does not name its unit"))));
    };
    let metres = match groups::parsed::<i32>(value, "a whole number")? {
        0 => return Ok((MILLIMETRE, Some(assumed("has no unit")))),
        1 => 0.0254,
        2 => 0.3048,
        4 => 1e-3,
        5 => 1e-2,
        6 => 1.0,
        9 => 0.0254e-3,
        10 => 0.9144,
        13 => 1e-6,
        14 => 0.1,
        other => {
            let due = "1 (in), 2 (ft), 4 (mm), 5 (cm), 6 (m), 9 (mil), 10 (yd), 13 (µm), 14 (dm)";
            let error = Error::data("$INSUNITS is no unit of a map").at_line(value.line).value(other);
            return Err(error.allowed(due));
        }
    };
    Ok((metres, None))
}

fn assumed(what: &str) -> String {
    format!(
        "the drawing {what} ($INSUNITS), so millimetres are assumed; set the unit in the CAD program if that is wrong"
    )
}

fn few_layers(count: usize, entity: &Entity<'_>) -> Result<()> {
    if count <= MOST_LAYERS { Ok(()) } else { Err(too_many_layers(count).at_line(entity.line)) }
}

fn too_many_layers(count: usize) -> Error {
    beyond(
        "the drawing has too many layers",
        format!("{count} or more"),
        MOST_LAYERS,
        "export the layers of the map alone",
    )
}

/// The role whose word the layer's name starts with, in any case.
fn role(layer: &str) -> Option<Role> {
    let lower = short(layer).to_lowercase();
    Role::WORDS.into_iter().find(|word| lower.starts_with(word)).and_then(Role::from_word)
}

impl<'a> Found<'a> {
    fn collect(&mut self, drawn: &[Entity<'a>], scale: f64) -> Result<()> {
        for (i, entity) in drawn.iter().enumerate() {
            let hidden = entity.word(60) == Some("1") || entity.word(67) == Some("1");
            if hidden || matches!(entity.kind, "VERTEX" | "SEQEND") {
                continue;
            }
            let Some(role) = role(entity.layer()) else {
                if (shape::is_shape(entity.kind) || entity.kind == "INSERT") && !self.ignored.contains(&entity.layer())
                {
                    self.ignored.push(entity.layer());
                    few_layers(self.ignored.len(), entity)?;
                }
                continue;
            };
            if !shape::is_shape(entity.kind) {
                unreadable(entity)?;
                continue;
            }
            let vertices = drawn[i + 1..].iter().take_while(|next| next.kind == "VERTEX").count();
            let vertices = &drawn[i + 1..=i + vertices];
            let chain = shape::chain(entity, vertices, ARC_TOLERANCE / scale).map_err(|error| about(error, entity))?;
            let segments: Vec<Segment> = chain.segments.iter().map(|segment| scaled(segment, scale)).collect();
            if let Some(p) = beyond_maps(&segments) {
                return Err(about(out_of_range(p).at_line(entity.line), entity));
            }
            if !segments.is_empty() {
                self.cost.add(&segments).map_err(|error| about(error.at_line(entity.line), entity))?;
                let piece = Piece { segments, closed: chain.closed, line: entity.line };
                self.pieces.push((role, entity.layer(), piece));
            }
        }
        Ok(())
    }

    /// The boundaries, layer by layer.
    fn boundaries(&mut self) -> Result<Vec<Boundary>> {
        let mut layers: Vec<(Role, &str)> = Vec::new();
        for &(role, layer, _) in &self.pieces {
            if !layers.contains(&(role, layer)) {
                layers.push((role, layer));
                if layers.len() > MOST_LAYERS {
                    return Err(too_many_layers(layers.len()));
                }
            }
        }
        let mut boundaries = Vec::new();
        for (role, layer) in layers {
            let (mine, others) = self.pieces.drain(..).partition(|(_, of, _)| *of == layer);
            self.pieces = others;
            let mine: Vec<(Role, &str, Piece)> = mine;
            let pieces = mine.into_iter().map(|(_, _, piece)| piece).collect();
            one_layer(role, layer, pieces, &mut boundaries)?;
        }
        Ok(boundaries)
    }
}

fn one_layer(role: Role, layer: &str, pieces: Vec<Piece>, out: &mut Vec<Boundary>) -> Result<()> {
    let called = format!("layer \"{}\"", short(layer));
    let mut curves = Vec::new();
    for piece in joined(pieces, role == Role::Wall).map_err(|error| error.about(&called))? {
        let line = piece.line;
        // A closed outline's last piece may end a rounding away from where its first begins.
        match Curve::from_segments(piece.segments, piece.closed) {
            Some(curve) => curves.push((curve, line)),
            None => return Err(Error::data("has no length, or a gap").about(&called).at_line(line)),
        }
    }
    if role != Role::Wall && curves.len() > MOST_OUTLINES {
        let remedy = "draw it on several layers: obstacle-1, obstacle-2, …";
        return Err(beyond("too many outlines on one layer", curves.len(), MOST_OUTLINES, remedy).about(&called));
    }
    let depths = if role == Role::Wall { vec![0; curves.len()] } else { join::depths(&curves) };
    for ((curve, line), depth) in curves.into_iter().zip(depths) {
        let (role, hole) = match (role, depth) {
            (Role::Wall, _) => (Role::Wall, false),
            (Role::Arena, 0) => (Role::Arena, false),
            (Role::Arena, depth) => (Role::Obstacle, depth % 2 == 0),
            (Role::Obstacle, depth) => (Role::Obstacle, depth % 2 == 1),
        };
        let name = Some(layer.to_owned()).filter(|name| name.len() <= LONGEST_NAME);
        let boundary = Boundary::checked(role, curve, hole, name);
        out.push(boundary.map_err(|CurveFault { error, .. }| error.about(&called).at_line(line))?);
    }
    Ok(())
}

fn scaled(segment: &Segment, scale: f64) -> Segment {
    match *segment {
        Segment::Line(p) => Segment::Line(p.map(|p| p * scale)),
        Segment::Quadratic(p) => Segment::Quadratic(p.map(|p| p * scale)),
        Segment::Cubic(p) => Segment::Cubic(p.map(|p| p * scale)),
    }
}

fn about(error: Error, entity: &Entity<'_>) -> Error {
    error.about(&format!("{} on layer \"{}\"", groups::excerpt(entity.kind).trim_matches('"'), short(entity.layer())))
}

/// Refuses what would be missed on the map; captions, dimensions and points are not.
fn unreadable(entity: &Entity<'_>) -> Result<()> {
    let remedy = match entity.kind {
        "INSERT" => "explode the block, or bind and explode the reference",
        "HATCH" | "SOLID" | "REGION" | "MLINE" | "3DFACE" | "TRACE" => "draw its outline as a polyline",
        _ => return Ok(()),
    };
    let error = Error::data("has a role, but no outline that can be read").at_line(entity.line).remedy(remedy);
    Err(about(error, entity))
}

fn no_roles(layers: &[&str]) -> Error {
    let error = Error::data("nothing is drawn on a layer with a role").allowed("layers arena…, obstacle…, wall…");
    if layers.is_empty() {
        return error.remedy("draw the arena's outline with lines, arcs, polylines or splines on a layer arena");
    }
    let near = layers.iter().map(|layer| did_you_mean(layer, &Role::WORDS)).find(|hint| hint.starts_with("did"));
    let hint = near.map_or_else(String::new, |hint| format!("; {hint}"));
    error.value(format!("layers {}", listed(layers))).remedy(format!("rename the layers by what they hold{hint}"))
}
