//! Maps as GeoJSON, which [`super::from_geojson`] reads back.

use crate::config::limits::FLATTEN_TOLERANCE;
use crate::plane::Vec2;
use crate::world::{Band, Boundary, Map, PieceCourse};
use std::fmt::Write;

/// The map as GeoJSON (m): curves as lines within a micrometre of them, bands and unknown stretches as the properties that
/// [`super::from_geojson`] reads.
#[must_use]
pub fn to_geojson(map: &Map) -> String {
    let features: Vec<String> = map.boundaries().iter().map(feature).collect();
    format!("{{\"type\": \"FeatureCollection\", \"features\": [\n{}\n]}}\n", features.join(",\n"))
}

fn feature(boundary: &Boundary) -> String {
    let closed = boundary.curve().is_closed();
    let Flattened { points, bands, unknown } = Flattened::new(boundary);
    let mut written: Vec<String> = points.iter().map(|p| format!("[{}, {}]", p.x, p.y)).collect();
    if closed {
        written.extend(written.first().cloned());
    }
    let mut properties = format!("\"role\": \"{}\"", boundary.role().word());
    if let Some(name) = boundary.name() {
        let _ = write!(properties, ", \"name\": {}", serde_json::Value::from(name));
    }
    if let Some(course) = boundary.course() {
        let list = |of: fn(&Band) -> f64| bands.iter().map(|b| of(b).to_string()).collect::<Vec<String>>().join(", ");
        let _ = write!(properties, ", \"band\": [{}]", list(|band| band.bound));
        let _ = write!(properties, ", \"band_std\": [{}]", list(|band| band.std));
        let _ = write!(properties, ", \"band_length\": {}", course.correlation_length());
        if let Some((_, depth)) = unknown.first() {
            let stretches: Vec<String> = unknown.iter().map(|([from, to], _)| format!("[{from}, {to}]")).collect();
            let deepest = unknown.iter().map(|(_, depth)| *depth).fold(*depth, f64::max);
            let _ = write!(properties, ", \"unknown\": [{}], \"unknown_depth\": {deepest}", stretches.join(", "));
        }
    }
    let (kind, open, close) = if closed { ("Polygon", "[[", "]]") } else { ("LineString", "[", "]") };
    format!(
        "{{\"type\": \"Feature\", \"properties\": {{{properties}}}, \"geometry\": {{\"type\": \"{kind}\", \"coordinates\":\n{open}{}{close}}}}}",
        written.join(", ")
    )
}

/// A boundary as lines: its points with their bands, and the pairs of points between which nothing is known, with depths (m).
struct Flattened {
    points: Vec<Vec2>,
    bands: Vec<Band>,
    unknown: Vec<([usize; 2], f64)>,
}

impl Flattened {
    fn new(boundary: &Boundary) -> Self {
        let segments = boundary.curve().segments();
        let (mut points, mut bands, mut unknown) = (Vec::new(), Vec::new(), Vec::<([usize; 2], f64)>::new());
        // The band at the end of the piece before, which holds where the next piece is unknown.
        let last = segments.len().checked_sub(1).filter(|_| boundary.curve().is_closed());
        let mut before = last.map_or(Band::default(), |last| ends(boundary, last).unwrap_or_default()[1]);
        for (index, segment) in segments.iter().enumerate() {
            let (parts, first) = (segment.flat_parts(FLATTEN_TOLERANCE), points.len());
            let own = ends(boundary, index);
            let [from, to] = own.unwrap_or([before, Band::default()]);
            // A point that two pieces share is known no better than either says.
            let from = Band { std: from.std.max(before.std), bound: from.bound.max(before.bound) };
            for k in 0..parts {
                let share = k as f64 / parts as f64;
                points.push(if k == 0 { segment.start() } else { segment.point(share) });
                let between = |a: f64, b: f64| if k == 0 { a } else { a + (b - a) * share };
                bands.push(Band { std: between(from.std, to.std), bound: between(from.bound, to.bound) });
            }
            before = to;
            if let Some(PieceCourse::Unknown(depth)) = boundary.piece_course(index) {
                match unknown.last_mut().filter(|([_, to], _)| *to == first) {
                    Some((stretch, deepest)) => (stretch[1], *deepest) = (points.len(), deepest.max(depth)),
                    None => unknown.push(([first, points.len()], depth)),
                }
            }
        }
        if let (false, Some(segment)) = (boundary.curve().is_closed(), segments.last()) {
            points.push(segment.end());
            bands.push(before);
        }
        Self { points, bands, unknown }
    }
}

/// The bands at the ends of a piece; none where it is unknown.
fn ends(boundary: &Boundary, segment: usize) -> Option<[Band; 2]> {
    match boundary.piece_course(segment) {
        Some(PieceCourse::Band(ends)) => Some(ends),
        Some(PieceCourse::Unknown(_)) => None,
        None => Some([Band::default(); 2]),
    }
}
