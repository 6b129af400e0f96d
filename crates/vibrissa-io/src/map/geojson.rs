//! Maps in GeoJSON (RFC 7946), metres, with `properties.role`.

mod course;
mod write;

pub use write::to_geojson;

use crate::config::budgets::{LONGEST_NAME, MOST_PIECES};
use crate::config::limits::LARGEST_COORDINATE;
use crate::plane::{Curve, Vec2};
use crate::text::{beyond, did_you_mean, line_at};
use crate::world::{Boundary, CurveFault, Map, MapCost, Role, out_of_range};
use crate::{Error, Result};
use course::CourseLabel;
use serde_json::value::RawValue;
use std::cell::Cell;
use std::collections::BTreeMap;

type Object<'a> = BTreeMap<String, &'a RawValue>;
type Points = Vec<Vec<f64>>;

/// A file's text and name; knows the line of any part of it.
struct Source<'a> {
    text: &'a str,
    name: &'a str,
    cost: Cell<MapCost>,
}

/// What a feature says about itself.
#[derive(Clone)]
struct Label {
    role: Option<Role>,
    name: Option<String>,
    course: CourseLabel,
}

/// Roles of features that other commands write beside the boundaries, and that bound nothing.
const NOTES: [&str; 3] = ["band", "peg", "trajectory"];

/// The map in a GeoJSON text; `name` stands for the file in messages.
///
/// A `FeatureCollection`, a `Feature`, or a bare geometry, of polygons and lines with `properties.role` one of
/// `arena`, `obstacle`, `wall`. Coordinates are metres; rings come in either orientation, closed or not. Holes of
/// arenas are obstacles, holes of obstacles are free. A bare geometry has no role: a polygon is then an arena and
/// a line a wall. Features with the roles `band`, `peg` and `trajectory` are passed over.
///
/// | property | says |
/// | --- | --- |
/// | `band` | how far the wall may be from where it is drawn (m): one number, or one for each point |
/// | `band_std` | the standard deviation of that (m), likewise; else the band over √3, and alone a third of the band |
/// | `band_length` | over which length of wall the error is alike (m), else 0.05 |
/// | `unknown` | `true`, or stretches of which nothing is known as pairs of points `[[from, to], …]`, counted from 0 |
/// | `unknown_depth` | how far from such a stretch anything may be (m), else its length |
///
/// # Errors
///
/// What is not JSON or not such a map; the message names the line.
pub fn from_geojson(text: &str, name: &str) -> Result<Map> {
    parse(text, name).map_err(|e| e.or_remedy("correct it there, or export the map again"))
}

fn parse(text: &str, name: &str) -> Result<Map> {
    let source = Source { text: text.strip_prefix('\u{feff}').unwrap_or(text), name, cost: Cell::default() };
    let root: &RawValue = serde_json::from_str(source.text).map_err(|e| source.not_json(&e))?;
    let mut boundaries = Vec::new();
    source.root(root, &mut boundaries)?;
    if boundaries.is_empty() {
        return Err(Error::data("the map has no features")
            .in_file(name)
            .remedy("add at least one Polygon with \"properties\": {\"role\": \"arena\"}"));
    }
    Map::new(boundaries).map_err(|error| error.in_file(name))
}

impl<'a> Source<'a> {
    /// The line on which a part of the text starts.
    fn line(&self, part: &str) -> usize {
        let offset = (part.as_ptr() as usize).saturating_sub(self.text.as_ptr() as usize);
        line_at(self.text.as_bytes(), offset)
    }

    fn fault(&self, part: &str, what: impl Into<String>) -> Error {
        Error::data(what).in_file(self.name).at_line(self.line(part))
    }

    fn not_json(&self, e: &serde_json::Error) -> Error {
        if self.text.trim().is_empty() {
            return Error::data("the map file is empty").in_file(self.name);
        }
        let what = format!("not valid JSON at column {}", e.column());
        let why = e.to_string();
        let why = why.rsplit_once(" at line ").map_or(why.as_str(), |(why, _)| why).to_owned();
        let error = Error::data(what).in_file(self.name).at_line(e.line().max(1)).value(why);
        if e.is_eof() { error.remedy("the file ends too early; was it cut off?") } else { error }
    }

    fn object(&self, raw: &'a RawValue, what: &str) -> Result<Object<'a>> {
        serde_json::from_str(raw.get()).map_err(|_| {
            self.fault(raw.get(), format!("{what} is not an object")).value(excerpt(raw.get())).allowed("{…}")
        })
    }

    fn kind(&self, raw: &'a RawValue, object: &Object<'a>) -> Result<String> {
        let kind = object.get("type").and_then(|k| serde_json::from_str::<String>(k.get()).ok());
        kind.ok_or_else(|| {
            self.fault(raw.get(), "not GeoJSON: an object without \"type\"")
                .allowed("FeatureCollection, Feature, Polygon, MultiPolygon, LineString, MultiLineString")
        })
    }

    /// A collection, a feature or a bare geometry.
    fn root(&self, raw: &'a RawValue, out: &mut Vec<Boundary>) -> Result<()> {
        let object = self.object(raw, "the map")?;
        match self.kind(raw, &object)?.as_str() {
            "FeatureCollection" => {
                let list = object.get("features").copied().unwrap_or(raw);
                let features: Vec<&RawValue> = serde_json::from_str(list.get())
                    .map_err(|_| self.fault(list.get(), "\"features\" is missing or not a list"))?;
                features.into_iter().try_for_each(|feature| self.member(feature, out))
            }
            "Feature" => self.feature(raw, &object, out),
            _ => self.geometry(raw, &Label { role: None, name: None, course: CourseLabel::default() }, out),
        }
    }

    /// One entry of a collection.
    fn member(&self, raw: &'a RawValue, out: &mut Vec<Boundary>) -> Result<()> {
        let object = self.object(raw, "the feature")?;
        let kind = self.kind(raw, &object)?;
        if kind != "Feature" {
            let error = self.fault(raw.get(), "\"features\" holds something else than a feature");
            return Err(error.value(format!("\"{kind}\"")).allowed("Feature"));
        }
        self.feature(raw, &object, out)
    }

    fn feature(&self, raw: &'a RawValue, object: &Object<'a>, out: &mut Vec<Boundary>) -> Result<()> {
        let properties = match object.get("properties") {
            Some(p) if p.get() != "null" => self.object(p, "\"properties\"")?,
            _ => Object::new(),
        };
        let role = match properties.get("role") {
            Some(raw) if serde_json::from_str(raw.get()).is_ok_and(|word: String| NOTES.contains(&word.as_str())) => {
                return Ok(());
            }
            Some(raw) => self.role(raw)?,
            None => {
                return Err(self
                    .fault(raw.get(), "a feature without a role")
                    .allowed(Role::WORDS.join(", "))
                    .remedy("add \"properties\": {\"role\": \"arena\"} to the feature"));
            }
        };
        let word = |key: &str| properties.get(key).and_then(|v| serde_json::from_str::<String>(v.get()).ok());
        let name = word("name").or_else(|| object.get("id").map(|id| id.get().trim_matches('"').to_owned()));
        let name = name.filter(|name| name.len() <= LONGEST_NAME);
        let course = self.course_label(&properties)?;
        match object.get("geometry") {
            Some(geometry) if geometry.get() != "null" => {
                let before = out.len();
                let counts_points = course.counts_points();
                self.geometry(geometry, &Label { role: Some(role), name, course }, out)?;
                if counts_points && out.len() > before + 1 {
                    return Err(self
                        .fault(raw.get(), "a feature of several lines whose points are counted by its properties")
                        .remedy("give each line or ring a feature of its own"));
                }
                Ok(())
            }
            _ => Err(self.fault(raw.get(), "a feature without geometry").remedy("give it a geometry or remove it")),
        }
    }

    fn role(&self, raw: &'a RawValue) -> Result<Role> {
        let word: Option<String> = serde_json::from_str(raw.get()).ok();
        word.as_deref().and_then(Role::from_word).ok_or_else(|| {
            self.fault(raw.get(), "unknown role")
                .value(excerpt(raw.get()))
                .allowed(Role::WORDS.join(", "))
                .remedy(did_you_mean(word.as_deref().unwrap_or_default(), &Role::WORDS))
        })
    }

    fn geometry(&self, raw: &'a RawValue, label: &Label, out: &mut Vec<Boundary>) -> Result<()> {
        let object = self.object(raw, "the geometry")?;
        let kind = self.kind(raw, &object)?;
        if !["Polygon", "MultiPolygon", "LineString", "MultiLineString"].contains(&kind.as_str()) {
            return Err(self
                .fault(raw.get(), "this kind of geometry cannot bound a map")
                .value(format!("\"{kind}\""))
                .allowed("Polygon, MultiPolygon, LineString, MultiLineString"));
        }
        let coordinates = *object
            .get("coordinates")
            .ok_or_else(|| self.fault(raw.get(), format!("a {kind} without \"coordinates\"")))?;
        match kind.as_str() {
            "Polygon" => self.polygon(coordinates, label, out),
            "MultiPolygon" => self.list(coordinates)?.into_iter().try_for_each(|p| self.polygon(p, label, out)),
            "LineString" => self.line_string(coordinates, label, out),
            _ => self.list(coordinates)?.into_iter().try_for_each(|l| self.line_string(l, label, out)),
        }
    }

    fn list(&self, raw: &'a RawValue) -> Result<Vec<&'a RawValue>> {
        serde_json::from_str(raw.get())
            .map_err(|_| self.fault(raw.get(), "coordinates must be nested lists").value(excerpt(raw.get())))
    }

    fn polygon(&self, raw: &'a RawValue, label: &Label, out: &mut Vec<Boundary>) -> Result<()> {
        let role = label.role.unwrap_or(Role::Arena);
        for (index, ring) in self.list(raw)?.into_iter().enumerate() {
            let (ring_role, hole) = match (role, index) {
                (Role::Arena, 1..) => (Role::Obstacle, false),
                (role, index) => (role, index > 0),
            };
            let points = self.points(ring)?;
            if distinct(&points) < 3 {
                return Err(self
                    .fault(ring.get(), "a polygon with fewer than 3 distinct points")
                    .value(format!("{} distinct", distinct(&points)))
                    .allowed("3 or more"));
            }
            self.boundary(ring, &points, true, (ring_role, hole), label, out)?;
        }
        Ok(())
    }

    fn line_string(&self, raw: &'a RawValue, label: &Label, out: &mut Vec<Boundary>) -> Result<()> {
        let points = self.points(raw)?;
        let role = label.role.unwrap_or(Role::Wall);
        if distinct(&points) < 2 {
            return Err(self.fault(raw.get(), "a line with fewer than 2 distinct points").allowed("2 or more"));
        }
        let closed = points.len() > 3 && points.first() == points.last();
        if role != Role::Wall && !closed {
            return Err(self
                .fault(raw.get(), format!("an open line cannot be an {}", role.word()))
                .remedy("make it a Polygon, or give it the role \"wall\""));
        }
        self.boundary(raw, &points, closed, (role, false), label, out)
    }

    fn boundary(
        &self,
        raw: &'a RawValue,
        points: &[Vec2],
        closed: bool,
        (role, hole): (Role, bool),
        label: &Label,
        out: &mut Vec<Boundary>,
    ) -> Result<()> {
        let mut cost = self.cost.get();
        cost.add_lines(points.len()).map_err(|error| error.in_file(self.name).at_line(self.line(raw.get())))?;
        self.cost.set(cost);
        let fault = match Curve::polyline(points, closed) {
            Some(curve) => match Boundary::checked(role, curve, hole, label.name.clone()) {
                Ok(boundary) => {
                    let told = label.course.is_some().then(|| label.course.course(points, closed)).transpose();
                    let known = match told {
                        Ok(Some(course)) => boundary.with_course(course),
                        Ok(None) => Ok(boundary),
                        Err(error) => Err(error),
                    };
                    let at = |error: Error| error.in_file(self.name).at_line(self.line(raw.get()));
                    out.push(known.map_err(at)?);
                    return Ok(());
                }
                Err(fault) => fault,
            },
            None => CurveFault { place: None, error: Error::data("a line without length") },
        };
        let vertex = fault.place.and_then(|place| points.iter().position(|&p| p == place));
        Err(fault.error.in_file(self.name).at_line(self.vertex_line(raw, vertex)))
    }

    /// The points of a ring or line, each finite and in range.
    fn points(&self, raw: &'a RawValue) -> Result<Vec<Vec2>> {
        // Every point opens a list, so that their number is known before they are.
        let count = raw.get().bytes().filter(|byte| *byte == b'[').count().saturating_sub(1);
        if count > MOST_PIECES {
            let remedy = "simplify the outline, or cut out the part that the robot can be in";
            return Err(beyond("a line of too many points", count, MOST_PIECES, remedy)
                .in_file(self.name)
                .at_line(self.line(raw.get())));
        }
        let read: Points = serde_json::from_str(raw.get()).map_err(|e| {
            let line = self.line(raw.get()) + e.line().max(1) - 1;
            Error::data("a point is a list of two numbers in metres, [x, y]")
                .in_file(self.name)
                .at_line(line)
                .value(e.to_string().rsplit_once(" at line ").map_or(String::new(), |(why, _)| why.to_owned()))
        })?;
        let point = |(index, p): (usize, &Vec<f64>)| match p[..] {
            [x, y] | [x, y, _] => {
                // Adding zero turns -0 into 0, which compares and sorts like it.
                let p = Vec2::new(x + 0.0, y + 0.0);
                let far = x.abs().max(y.abs()) > LARGEST_COORDINATE;
                let line = || self.vertex_line(raw, Some(index));
                if far { Err(out_of_range(p).in_file(self.name).at_line(line())) } else { Ok(p) }
            }
            _ => Err(Error::data("a point is a list of two numbers in metres, [x, y]")
                .in_file(self.name)
                .at_line(self.vertex_line(raw, Some(index)))
                .value(format!("{p:?}"))),
        };
        read.iter().enumerate().map(point).collect()
    }

    /// The line of one point of a ring, or of the ring.
    fn vertex_line(&self, raw: &'a RawValue, vertex: Option<usize>) -> usize {
        let parts: Vec<&RawValue> = serde_json::from_str(raw.get()).unwrap_or_default();
        self.line(vertex.and_then(|i| parts.get(i)).map_or(raw.get(), |p| p.get()))
    }
}

/// How many different points there are.
fn distinct(points: &[Vec2]) -> usize {
    let mut sorted = points.to_vec();
    sorted.sort_unstable_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    sorted.dedup();
    sorted.len()
}

/// The start of a value, short enough for a message.
fn excerpt(text: &str) -> String {
    let short: String = text.chars().take(40).collect();
    if short.len() < text.len() { format!("{short}…") } else { short }
}
