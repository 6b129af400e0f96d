//! Maps drawn in SVG, as Inkscape writes it.

mod budget;
mod page;
mod path;
mod role;
mod shape;

use crate::config::budgets::{LONGEST_NAME, MOST_OUTLINES, MOST_XML_NODES};
use crate::config::limits::FLATTEN_TOLERANCE;
use crate::plane::{Curve, SegmentTree};
use crate::text::{beyond, did_you_mean, listed, short};
use crate::world::{Boundary, CurveFault, Map, MapCost, Role};
use crate::{Error, Result};
use kurbo::Affine;
use roxmltree::{Document, Node, ParsingOptions};
use shape::Outline;

/// Elements whose content is not drawn where it stands.
const NOT_DRAWN: [&str; 11] =
    ["defs", "symbol", "clipPath", "mask", "pattern", "marker", "metadata", "namedview", "title", "desc", "style"];

/// How deep groups may be nested: far beyond any drawing, and far from the end of the stack.
const DEEPEST: usize = 200;

/// What the walk through the drawing has found.
struct Found<'a> {
    name: &'a str,
    boundaries: Vec<Boundary>,
    /// Shapes without a role.
    ignored: Vec<String>,
    /// How many groups deep the walk is.
    depth: usize,
    cost: MapCost,
}

/// The map drawn in an SVG text; `name` stands for the file in messages.
///
/// One user unit is 1 mm, unless `width`/`height` in mm, cm, in, pt or pc together with `viewBox` say otherwise.
/// The map looks as drawn: x runs right from the page's left edge, y up from its bottom edge (from y = 0 when the
/// page has no height). Read are path, polygon, polyline, line, rect, circle and ellipse, in groups with any
/// transforms. A shape's role comes from the first word `arena…`, `obstacle…` or `wall…` among its own class, id and
/// Inkscape label, then those of its groups and layers. Shapes without role are ignored with a warning; hidden ones
/// (`display: none`) silently. A path of several outlines is filled even-odd: the second level is a hole. Lines and
/// Béziers stay what they are; arcs become cubics within 1e-9 m.
///
/// # Errors
///
/// What is not SVG, no shape with a role, open or self-crossing outlines, shapes that cannot be read; the message
/// names line and element.
pub fn from_svg(text: &str, name: &str) -> Result<Map> {
    parse(text, name).map_err(|e| e.or_remedy("correct the shape in the drawing program and save it again"))
}

fn parse(text: &str, name: &str) -> Result<Map> {
    let options = ParsingOptions { allow_dtd: true, nodes_limit: MOST_XML_NODES as u32, ..ParsingOptions::default() };
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    if text.trim().is_empty() {
        return Err(Error::data("the map file is empty").in_file(name));
    }
    budget::check(text).map_err(|e| e.in_file(name))?;
    let document = Document::parse_with_options(text, options).map_err(|e| {
        let why = e.to_string();
        let why = why.rsplit_once(" at ").map_or(why.as_str(), |(why, _)| why);
        Error::data("not valid XML").in_file(name).at_line(e.pos().row as usize).value(why)
    })?;
    let root = document.root_element();
    if root.tag_name().name() != "svg" {
        return Err(fault(name, root, "not an SVG drawing").value(format!("<{}>", short(root.tag_name().name()))));
    }
    let page = page::page(root).map_err(|e| e.in_file(name))?;
    let mut found = Found { name, boundaries: Vec::new(), ignored: Vec::new(), depth: 0, cost: MapCost::default() };
    found.children(root, page.map_from_user, None)?;
    if found.boundaries.is_empty() {
        return Err(no_roles(name, &found.ignored));
    }
    let mut map = Map::new(found.boundaries).map_err(|e| e.in_file(name))?;
    map.warnings.extend(page.warnings);
    if !found.ignored.is_empty() {
        map.warnings.push(ignored_shapes(&found.ignored));
    }
    Ok(map)
}

/// An error at an element.
fn fault(name: &str, node: Node<'_, '_>, what: impl Into<String>) -> Error {
    let line = node.document().text_pos_at(node.range().start).row as usize;
    Error::data(what).in_file(name).at_line(line)
}

/// How messages call an element: `<path id="obstacle-3">`.
fn called(node: Node<'_, '_>) -> String {
    let tag = node.tag_name().name();
    match node.attribute("id").or_else(|| role::label(node)) {
        Some(id) => format!("<{} id=\"{}\">", short(tag), short(id)),
        None => format!("<{}>", short(tag)),
    }
}

impl Found<'_> {
    fn children(&mut self, parent: Node<'_, '_>, map_from_parent: Affine, inherited: Option<Role>) -> Result<()> {
        parent.children().filter(Node::is_element).try_for_each(|node| self.node(node, map_from_parent, inherited))
    }

    fn node(&mut self, node: Node<'_, '_>, map_from_parent: Affine, inherited: Option<Role>) -> Result<()> {
        let tag = node.tag_name().name();
        if NOT_DRAWN.contains(&tag) || is_hidden(node) {
            return Ok(());
        }
        let transform = shape::transform(node).map_err(|e| self.located(e, node))?;
        let map_from_user = map_from_parent * transform;
        let role = role::of(node).or(inherited);
        if matches!(tag, "g" | "a" | "switch") {
            if self.depth >= DEEPEST {
                return Err(self
                    .located(Error::data("groups are nested too deeply").allowed(format!("{DEEPEST} levels")), node));
            }
            self.depth += 1;
            let done = self.children(node, map_from_user, role);
            self.depth -= 1;
            return done;
        }
        let Some(role) = role else {
            if shape::is_shape(tag) || matches!(tag, "use" | "svg") {
                self.ignored.push(called(node));
            }
            return Ok(());
        };
        if !shape::is_shape(tag) {
            // A clone or an embedded drawing in a layer of obstacles would be lost; a caption there is not missed.
            let is_missed = role::of(node).is_some() || matches!(tag, "use" | "svg");
            return if is_missed { Err(self.not_a_shape(node)) } else { Ok(()) };
        }
        let outlines = shape::outlines(node, map_from_user).map_err(|e| self.located(e, node))?;
        if outlines.is_empty() {
            return Err(self.located(Error::data("has no length"), node));
        }
        let name = node.attribute("id").or_else(|| role::label(node));
        let name = name.filter(|name| name.len() <= LONGEST_NAME).map(str::to_owned);
        self.add(node, role, outlines, name.as_ref())
    }

    fn located(&self, error: Error, node: Node<'_, '_>) -> Error {
        let line = node.document().text_pos_at(node.range().start).row as usize;
        error.about(&called(node)).in_file(self.name).at_line(line)
    }

    fn not_a_shape(&self, node: Node<'_, '_>) -> Error {
        let remedy = match node.tag_name().name() {
            "use" => "in Inkscape: Edit > Clone > Unlink Clone",
            "svg" => "in Inkscape: Object > Ungroup the embedded drawing",
            "text" | "image" => "in Inkscape: Path > Object to Path, or trace it",
            _ => "draw it with paths, polygons, lines, rectangles, circles or ellipses",
        };
        self.located(Error::data("this element has a role but no outline that can be read").remedy(remedy), node)
    }

    fn add(&mut self, node: Node<'_, '_>, role: Role, outlines: Vec<Outline>, name: Option<&String>) -> Result<()> {
        if role != Role::Wall && outlines.iter().any(|o| !o.curve.is_closed()) {
            let error = Error::data(format!("an open line cannot be an {}", role.word()))
                .remedy("close it (in Inkscape: node tool, select both end nodes, Shift+J), or make it a wall");
            return Err(self.located(error, node));
        }
        if outlines.len() > MOST_OUTLINES {
            let remedy = "break it apart (in Inkscape: Path > Break Apart)";
            return Err(
                self.located(beyond("too many outlines of one path", outlines.len(), MOST_OUTLINES, remedy), node)
            );
        }
        for outline in &outlines {
            self.cost.add(outline.curve.segments()).map_err(|error| self.located(error, node))?;
        }
        let depths = depths(&outlines);
        for (outline, depth) in outlines.into_iter().zip(depths) {
            let (role, hole) = match (role, depth) {
                (Role::Wall, _) => (Role::Wall, false),
                (Role::Arena, 0) => (Role::Arena, false),
                (Role::Arena, depth) => (Role::Obstacle, depth % 2 == 0),
                (Role::Obstacle, depth) => (Role::Obstacle, depth % 2 == 1),
            };
            let boundary = Boundary::checked(role, outline.curve, hole, name.cloned());
            self.boundaries.push(boundary.map_err(|CurveFault { error, .. }| self.located(error, node))?);
        }
        Ok(())
    }
}

/// In how many of the other closed outlines each outline lies.
fn depths(outlines: &[Outline]) -> Vec<usize> {
    if outlines.len() == 1 {
        return vec![0];
    }
    let tree = |curve: &Curve| {
        let points = curve.flatten(FLATTEN_TOLERANCE);
        SegmentTree::new(&points.windows(2).map(|w| [w[0], w[1]]).collect::<Vec<_>>())
    };
    let trees: Vec<SegmentTree> = outlines.iter().map(|o| tree(&o.curve)).collect();
    let inside = |i: usize, j: usize| i != j && trees[j].ray_crossings(outlines[i].curve.at(0.0).position) % 2 == 1;
    (0..outlines.len()).map(|i| (0..outlines.len()).filter(|&j| inside(i, j)).count()).collect()
}

fn is_hidden(node: Node<'_, '_>) -> bool {
    let style = node.attribute("style").unwrap_or_default();
    let mut declarations = style.split(';').filter_map(|d| d.split_once(':'));
    node.attribute("display") == Some("none")
        || declarations.any(|(key, value)| key.trim() == "display" && value.trim() == "none")
}

fn no_roles(name: &str, shapes: &[String]) -> Error {
    let error = Error::data("no shape in the drawing has a role").in_file(name);
    if shapes.is_empty() {
        return error
            .value("there are no visible shapes at all")
            .remedy("draw the arena's outline with the class arena");
    }
    error.value(listed(shapes)).allowed("class or id arena, obstacle…, wall…").remedy(
        "in Inkscape: select the shape, Object > Object Properties, set its ID or Label to arena, obstacle-1 or wall-1 \
         (a layer's name works too)",
    )
}

/// How many shapes without a role are looked at for one that was misspelt.
const LOOKED_AT: usize = 1000;

fn ignored_shapes(shapes: &[String]) -> String {
    let near = shapes.iter().take(LOOKED_AT).find_map(|s| {
        let id = s.split('"').nth(1)?.trim_end_matches(|c: char| !c.is_alphabetic());
        let hint = did_you_mean(id, &Role::WORDS);
        hint.starts_with("did").then(|| format!("; {s}: {hint}"))
    });
    let count = shapes.len();
    let (noun, verb) = if count == 1 { ("shape", "was") } else { ("shapes", "were") };
    format!("{count} {noun} without a role {verb} ignored: {}{}", listed(shapes), near.unwrap_or_default())
}
