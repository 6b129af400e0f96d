//! The way in the file: start, legs, pace.

use super::LegStart;
use super::points::{ANGLE, Place, place, places, point};
use super::route::{Heading, Leg, LegKind, Walk};
use crate::config::scenario::{RATE, SPEED, TURN_RATE};
use crate::flow::pose::StampedPose;
use crate::io::Dimension;
use crate::io::text::did_you_mean;
use crate::io::toml_section::{Allowed, LENGTH, POSITIVE, Section};
use crate::plane::{Pose2, Vec2, wrap_angle};
use crate::simulate::{Pace, sampled};
use crate::world::Map;
use crate::{Error, Result};
use toml::Spanned;

const KINDS: [&str; 6] = ["line", "arc", "spline", "wall", "turn", "wait"];
const HEADINGS: [&str; 3] = ["along", "interpolate", "keep"];
const WAY: Allowed = Allowed { holds: |v| v > 0.0 && v <= 1e5, text: "above 0, up to 1e5 m", remedy: "" };

/// The way of a scenario.
pub(super) struct Way {
    pub(super) poses: Vec<StampedPose>,
    pub(super) legs: Vec<LegStart>,
    /// Rows a second (Hz).
    pub(super) rate: f64,
}

/// Reads the section and goes the way on `map`.
pub(super) fn way(section: &Section<'_>, map: &Map) -> Result<Way> {
    section.only(&["speed", "turn_rate", "rate", "start", "waypoints", "heading", "heading_offset", "leg"])?;
    let pace = Pace {
        speed: section.number("speed", Dimension::Speed, &POSITIVE)?.unwrap_or(SPEED),
        turn_rate: section.number("turn_rate", Dimension::TurnRate, &POSITIVE)?.unwrap_or(TURN_RATE),
        rate: section.number("rate", Dimension::Frequency, &POSITIVE)?.unwrap_or(RATE),
    };
    let (start, legs) = legs(section, pace.speed)?;
    if !map.is_free(start.position()) {
        let key = if section.get("start").is_some() { "start" } else { "waypoints" };
        return Err(section
            .source
            .fault(&section.span_of(key), "the path does not start in free space")
            .value(format!("({}, {}) m", start.x, start.y))
            .allowed("inside an arena, outside every obstacle")
            .remedy("move the start; the map frame has x to the right, y up, in metres"));
    }
    let go = |start: Pose2, legs: &[Leg]| -> Result<(Walk, Vec<LegStart>)> {
        let mut walk = Walk::new(start, pace);
        let mut starts = Vec::new();
        for leg in legs {
            starts.push(LegStart { t: walk.time(), line: leg.line });
            leg.go(map, &mut walk).map_err(|e| e.in_file(section.source.name).at_line(leg.line))?;
        }
        Ok((walk, starts))
    };
    let start = match (start.theta.is_nan(), legs.first()) {
        // Without a heading the robot starts as its first leg goes on.
        (true, Some(first)) => {
            let level = Pose2 { theta: 0.0, ..start };
            let (walk, _) = go(level, core::slice::from_ref(first))?;
            Pose2 { theta: walk.first_heading(), ..start }
        }
        _ => start,
    };
    let (walk, starts) = go(start, &legs)?;
    if walk.time() * pace.rate < 1.0 {
        return Err(section
            .source
            .fault(&section.span, "the path has no length, or ends within one row")
            .value(format!("{} s at {} Hz", walk.time(), pace.rate))
            .remedy("give at least two different waypoints, or a higher rate"));
    }
    Ok(Way { poses: sampled(&walk.nodes, pace.rate), legs: starts, rate: pace.rate })
}

/// The start and the legs; `waypoints` stand for a start and one leg.
fn legs(section: &Section<'_>, speed: f64) -> Result<(Pose2, Vec<Leg>)> {
    let entries = section.entries("leg")?;
    let Some(points) = places(section, "waypoints", true)? else {
        if entries.is_empty() {
            return Err(section.source.fault(&section.span, "the path goes nowhere").remedy(
                "add waypoints = [[0.1, 0.2], [0.3, 0.2]], or start = [0.1, 0.2, 0] and [[path.leg]] sections",
            ));
        }
        let legs = entries.iter().map(|entry| leg(entry, speed)).collect::<Result<_>>()?;
        let (point, theta) = start(section)?;
        return Ok((Pose2::new(point.x, point.y, theta.unwrap_or(f64::NAN)), legs));
    };
    if let Some(other) = ["start", "leg"].into_iter().find(|key| section.get(key).is_some()) {
        return Err(section
            .source
            .fault(&section.span_of(other), format!("both waypoints and {other}"))
            .remedy("waypoints are a whole path; for several legs give start and [[path.leg]] sections"));
    }
    let [first, rest @ ..] = points.as_slice() else {
        return Err(section.source.fault(&section.span_of("waypoints"), "waypoints is empty"));
    };
    if rest.is_empty() {
        let what = "a path needs at least two waypoints";
        return Err(section.source.fault(&section.span_of("waypoints"), what));
    }
    let heading = heading(section, default_heading(&points))?;
    let theta = match heading {
        Heading::Fixed(theta) => theta,
        Heading::Along(offset) => (rest[0].0 - first.0).angle() + offset,
        Heading::Interpolate | Heading::Keep => first.1.unwrap_or(0.0),
    };
    let line = section.line_of("waypoints");
    let leg = Leg { kind: LegKind::Line(rest.to_vec()), speed, heading, line };
    Ok((Pose2::new(first.0.x, first.0.y, theta), vec![leg]))
}

fn start(section: &Section<'_>) -> Result<Place> {
    let Some(value) = section.get("start") else {
        return Err(section
            .source
            .fault(&section.span, "the path has no start")
            .remedy("add start = [x, y, theta] to [path], in the map frame"));
    };
    place(section, "start", value, true)
}

/// Points with headings are interpolated; others are driven along.
fn default_heading(points: &[Place]) -> Heading {
    if points.iter().any(|(_, theta)| theta.is_some()) { Heading::Interpolate } else { Heading::Along(0.0) }
}

fn heading(section: &Section<'_>, default: Heading) -> Result<Heading> {
    let offset = section.number("heading_offset", Dimension::Angle, &ANGLE)?;
    let word = section.get("heading").and_then(|value| value.get_ref().as_str()).map(str::trim);
    let chosen = match word {
        Some("along") => Heading::Along(offset.unwrap_or(0.0)),
        Some("interpolate") => Heading::Interpolate,
        Some("keep") => Heading::Keep,
        Some(word) if word.starts_with(char::is_alphabetic) => {
            return Err(section
                .source
                .fault(&section.span_of("heading"), format!("{}: unknown word", section.key("heading")))
                .value(format!("\"{word}\""))
                .allowed(format!("{}, or an angle", HEADINGS.join(", ")))
                .remedy(did_you_mean(word, &HEADINGS)));
        }
        _ => match (section.number("heading", Dimension::Angle, &ANGLE)?, default) {
            (Some(theta), _) => Heading::Fixed(wrap_angle(theta)),
            (None, Heading::Along(_)) => Heading::Along(offset.unwrap_or(0.0)),
            (None, default) => default,
        },
    };
    if let (Some(_), Heading::Interpolate | Heading::Keep | Heading::Fixed(_)) = (offset, chosen) {
        return Err(section
            .source
            .fault(&section.span_of("heading_offset"), "heading_offset goes with heading = \"along\" only"));
    }
    Ok(chosen)
}

fn leg(section: &Section<'_>, speed: f64) -> Result<Leg> {
    let Some(word) = section.text("kind")? else {
        return Err(section
            .source
            .fault(&section.span, "a leg without a kind")
            .allowed(KINDS.join(", "))
            .remedy("add kind = \"line\" to the leg"));
    };
    let own: &[&str] = match word {
        "line" => &["to"],
        "arc" => &["centre", "angle"],
        "spline" => &["through"],
        "wall" => &["side", "standoff", "length"],
        "turn" => &["by"],
        "wait" => &["time"],
        _ => {
            return Err(section
                .source
                .fault(&section.span_of("kind"), "unknown kind of leg")
                .value(format!("\"{word}\""))
                .allowed(KINDS.join(", "))
                .remedy(did_you_mean(word, &KINDS)));
        }
    };
    let known: Vec<&str> = ["kind", "speed", "heading", "heading_offset"].iter().chain(own).copied().collect();
    section.only(&known)?;
    let kind = kind(section, word)?;
    let default = match &kind {
        LegKind::Line(points) => default_heading(points),
        LegKind::Turn(_) | LegKind::Wait(_) => Heading::Keep,
        _ => Heading::Along(0.0),
    };
    Ok(Leg {
        kind,
        speed: section.number("speed", Dimension::Speed, &POSITIVE)?.unwrap_or(speed),
        heading: heading(section, default)?,
        line: section.source.line(&section.span),
    })
}

fn kind(section: &Section<'_>, word: &str) -> Result<LegKind> {
    let needs = |key: &str| {
        section
            .source
            .fault(&section.span, format!("a leg of the kind {word} needs {key}"))
            .remedy(format!("add {key} to the leg"))
    };
    let only_points = |points: Vec<Place>| points.into_iter().map(|(point, _)| point).collect::<Vec<Vec2>>();
    Ok(match word {
        "line" => LegKind::Line(places(section, "to", true)?.ok_or_else(|| needs("to"))?),
        "arc" => LegKind::Arc {
            centre: point(section, "centre")?.ok_or_else(|| needs("centre"))?,
            angle: section.number("angle", Dimension::Angle, &ANGLE)?.ok_or_else(|| needs("angle"))?,
        },
        "spline" => LegKind::Spline(only_points(places(section, "through", false)?.ok_or_else(|| needs("through"))?)),
        "wall" => LegKind::Wall {
            on_left: side(section)?.ok_or_else(|| needs("side"))?,
            standoff: section.number("standoff", Dimension::Length, &LENGTH)?.ok_or_else(|| needs("standoff"))?,
            length: section.number("length", Dimension::Length, &WAY)?.ok_or_else(|| needs("length"))?,
        },
        "turn" => LegKind::Turn(section.number("by", Dimension::Angle, &ANGLE)?.ok_or_else(|| needs("by"))?),
        _ => LegKind::Wait(section.number("time", Dimension::Time, &POSITIVE)?.ok_or_else(|| needs("time"))?),
    })
}

/// Whether the wall is on the left.
fn side(section: &Section<'_>) -> Result<Option<bool>> {
    match section.text("side")? {
        None => Ok(None),
        Some("left") => Ok(Some(true)),
        Some("right") => Ok(Some(false)),
        Some(word) => {
            let span = section.get("side").map_or(section.span.clone(), Spanned::span);
            let error: Error = section.source.fault(&span, format!("{}: unknown word", section.key("side")));
            Err(error.value(format!("\"{word}\"")).allowed("left, right"))
        }
    }
}
