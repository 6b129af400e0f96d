//! `vibrissa profile`: the outline of what was swept.

use super::localize::outlines;
use super::logs::{Felt, OutlineArgs};
use crate::interrupt::{Heedful, stop};
use crate::output::{OutputArgs, counted, print, progress, warn, write_all, wrote};
use serde_json::{Value, json};
use std::path::PathBuf;
use vibrissa::config::{ContactOptions, MapAssemblyOptions, ProfileOptions};
use vibrissa::figure::{Geometry, Layer, scene_figure};
use vibrissa::plane::Vec2;
use vibrissa::tasks::profile::{Alignment, Misfit, Outline, Profile, compare, profile_until};
use vibrissa::world::Map;
use vibrissa::{Error, Result};

/// The band's half width, in standard deviations.
const BAND: f64 = 2.0;
/// An outline that lies so many times farther off than its shape is wrong is in another frame.
const ELSEWHERE: f64 = 20.0;

/// Find the outline of what one or more sweeps touched.
///
/// The logs are CSV files with the columns `t,x,y,theta,moment` (s, m, rad, N m), all in one odometry frame. With a truth
/// (.geojson in m, .svg in mm, in that frame) the absolute error and, after the best rigid motion, the shape error are told.
///
/// With --out DIR: profile.geojson (outlines, bands of two standard deviations, pegs), map.geojson (the outlines as one map with bands,
/// corners and unknown stretches, which `vibrissa localize` reads) and the figure profile.svg.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The sensor logs (.csv)
    #[arg(required = true)]
    logs: Vec<PathBuf>,
    /// Also fit a scale, and say how well the shape fits with it
    #[arg(long, requires = "truth")]
    free_scale: bool,
    #[command(flatten)]
    reading: OutlineArgs,
    #[command(flatten)]
    output: OutputArgs,
}

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<()> {
    let felt = args.reading.read(&args.logs)?;
    let (found, map) = (profile(args, &felt)?, felt.truth);
    let points: Vec<Vec2> = found.outlines.iter().flat_map(|o| o.points.iter().map(|p| p.position)).collect();
    let compared = map.as_ref().and_then(|map| compare(&points, map, args.free_scale));
    let mut written = Vec::new();
    if let Some(to) = args.output.destination() {
        let mut files = vec![
            ("profile.geojson", pretty(&geojson(&found))?),
            ("profile.svg", figure(&found, map.as_ref(), compared.as_ref(), &caption(&found, compared.as_ref()))),
        ];
        if !found.outlines.is_empty() {
            let assembled = found.map(&MapAssemblyOptions::default())?;
            files.insert(1, ("map.geojson", vibrissa::io::map::to_geojson(&assembled.map)));
        }
        written = write_all(to, &files)?;
    }
    if args.output.json {
        return print(&pretty(&summary(&found, compared.as_ref()))?);
    }
    let text: String = caption(&found, compared.as_ref()).iter().map(|line| format!("{line}\n")).collect();
    print(&(text + &wrote(&written)))
}

/// The outlines, as far as they come before an interrupt.
fn profile(args: &Args, Felt { robot, logs, .. }: &Felt) -> Result<Profile> {
    let _heeds = Heedful::hurried();
    let (contact, options) = (ContactOptions::default(), ProfileOptions::default());
    let mut tell = |log: usize, done, all| {
        if done == 0 && logs.len() > 1 {
            progress::phase(&format!("finding the outline, log {} of {}", log + 1, logs.len()));
        }
        progress::readings(done, all);
    };
    let found = profile_until(logs, robot, &contact, &options, &stop(), &mut tell)?;
    if let Some((log, t)) = found.stopped_at {
        let name = args.logs[log].display();
        warn(&format!("interrupted: the contacts of {name} from {t:.3} s on are missing, and those of logs after it"));
    }
    Ok(found)
}

fn pretty(value: &Value) -> Result<String> {
    let text = serde_json::to_string_pretty(value);
    text.map(|text| text + "\n").map_err(|error| Error::data(format!("cannot write the result as JSON ({error})")))
}

fn length(outline: &Outline) -> f64 {
    outline.points.windows(2).map(|pair| pair[0].position.distance(pair[1].position)).sum()
}

fn mean_std(outline: &Outline) -> f64 {
    outline.points.iter().map(|p| p.std).sum::<f64>() / outline.points.len().max(1) as f64
}

fn caption(found: &Profile, compared: Option<&Alignment>) -> Vec<String> {
    if found.contacts == 0 && found.stopped_at.is_none() {
        return vec!["no contact: no reading rises above the declared noise".to_owned()];
    }
    let total: f64 = found.outlines.iter().map(length).fold(0.0, |sum, l| sum + l);
    let mut lines = vec![format!(
        "{}, {:.1} mm in all; {} felt with the side; {} of {} steps on no outline",
        counted(found.outlines.len(), "outline", "outlines"),
        1e3 * total,
        counted(found.pegs.len(), "point", "points"),
        found.left_out,
        found.contacts
    )];
    if let Some((_, t)) = found.stopped_at {
        lines.push(format!("interrupted: contacts from {t:.3} s on are missing"));
    }
    let Some(compared) = compared else { return lines };
    let line = |name: &str, m: &Misfit| {
        format!("{name}: mean {:.3} mm, 95 % below {:.3} mm, largest {:.3} mm", 1e3 * m.mean, 1e3 * m.p95, 1e3 * m.max)
    };
    lines.push(line("absolute error", &compared.absolute));
    lines.push(line("shape error (best rigid motion)", &compared.shape));
    if compared.absolute.mean > ELSEWHERE * compared.shape.p95 {
        lines.push("the shape fits, but elsewhere: the odometry does not begin in the frame of the truth".to_owned());
    }
    if let Some((misfit, scale)) = &compared.scaled {
        lines.push(line(&format!("with a free scale of {scale:.4}"), misfit));
    }
    lines
}

fn misfit(m: &Misfit) -> Value {
    json!({ "mean_m": m.mean, "rms_m": m.rms, "p95_m": m.p95, "max_m": m.max })
}

fn summary(found: &Profile, compared: Option<&Alignment>) -> Value {
    let outline = |o: &Outline| {
        json!({
            "length_m": length(o), "points": o.points.len(), "closed": o.closed, "mean_std_m": mean_std(o),
        })
    };
    let events: Vec<Vec<Value>> = found
        .events
        .iter()
        .map(|log| log.iter().map(|e| json!({ "t": e.t, "kind": e.kind, "detail": e.detail })).collect())
        .collect();
    let mut answer = json!({
        "outlines": found.outlines.iter().map(outline).collect::<Vec<Value>>(),
        "pegs": found.pegs.iter().map(|(p, std)| json!({ "x": p.x, "y": p.y, "std_m": std })).collect::<Vec<Value>>(),
        "steps": found.contacts,
        "left_out": found.left_out,
        "events": events,
    });
    if found.stopped_at.is_some() {
        answer["interrupted"] = true.into();
    }
    if let Some(compared) = compared {
        let pose = compared.map_from_outline;
        answer["truth"] = json!({
            "absolute": misfit(&compared.absolute),
            "shape": misfit(&compared.shape),
            "map_from_outline": { "x": pose.x, "y": pose.y, "theta": pose.theta },
            "scaled": compared.scaled.as_ref().map(|(m, scale)| json!({ "scale": scale, "misfit": misfit(m) })),
        });
    }
    answer
}

fn geojson(found: &Profile) -> Value {
    let at = |p: &Vec2| json!([p.x, p.y]);
    let mut features = Vec::new();
    for (index, outline) in found.outlines.iter().enumerate() {
        let mut line: Vec<Value> = outline.points.iter().map(|p| at(&p.position)).collect();
        let geometry = if outline.closed {
            line.extend(line.first().cloned());
            json!({ "type": "Polygon", "coordinates": [line] })
        } else {
            json!({ "type": "LineString", "coordinates": line })
        };
        let role = if outline.closed { "obstacle" } else { "wall" };
        features.push(json!({
            "type": "Feature",
            "properties": {
                "role": role, "outline": index, "mean_std_m": mean_std(outline), "closed": outline.closed,
                "std_m": outline.points.iter().map(|p| p.std).collect::<Vec<f64>>(),
                "runs": outline.points.iter().map(|p| p.runs).collect::<Vec<usize>>(),
            },
            "geometry": geometry,
        }));
        features.push(json!({
            "type": "Feature",
            "properties": { "role": "band", "outline": index, "standard_deviations": BAND },
            "geometry": { "type": "Polygon", "coordinates": band(outline).iter().map(|r| r.iter().map(at).collect::<Vec<Value>>()).collect::<Vec<Vec<Value>>>() },
        }));
    }
    for (point, std) in &found.pegs {
        features.push(json!({
            "type": "Feature",
            "properties": { "role": "peg", "std_m": std },
            "geometry": { "type": "Point", "coordinates": at(point) },
        }));
    }
    json!({ "type": "FeatureCollection", "features": features })
}

/// The band as rings, each with its first point repeated at the end: one around a line, two around a ring.
fn band(outline: &Outline) -> Vec<Vec<Vec2>> {
    let [mut outer, mut inner] = outline.band(BAND);
    inner.reverse();
    let close = |mut ring: Vec<Vec2>| {
        ring.extend(ring.first().copied());
        ring
    };
    if outline.closed {
        return vec![close(outer), close(inner)];
    }
    outer.extend(inner);
    vec![close(outer)]
}

/// An absolute error (m) from which on the truth is drawn where the shapes fit best: odometry starts anywhere, and the truth
/// would be off the picture.
const FAR: f64 = 5e-3;

fn figure(found: &Profile, map: Option<&Map>, compared: Option<&Alignment>, captions: &[String]) -> String {
    let layer = |geometry, class, label: &str, framed| Layer { geometry, class, label: label.to_owned(), framed };
    let moved = compared.filter(|c| c.absolute.mean > FAR).map(|c| c.map_from_outline.inverse());
    let name = if moved.is_some() { "the true shape, moved to where it fits best" } else { "the true shape" };
    let place = |p: Vec2| moved.map_or(p, |outline_from_map| outline_from_map.transform_point(p));
    let truth = map.map(outlines).unwrap_or_default();
    let truth: Vec<Vec<Vec2>> = truth
        .into_iter()
        .map(|o| {
            let first = o.points.first().copied().filter(|_| o.closed);
            o.points.into_iter().chain(first).map(place).collect()
        })
        .collect();
    let lines = |o: &Outline| -> Vec<Vec2> {
        let first = o.points.first().filter(|_| o.closed);
        o.points.iter().chain(first).map(|p| p.position).collect()
    };
    let bands = found.outlines.iter().flat_map(band).collect();
    let layers = [
        layer(Geometry::Lines(truth), "truth", name, false),
        layer(Geometry::Rings(bands), "band", "two standard deviations", true),
        layer(Geometry::Lines(found.outlines.iter().map(lines).collect()), "outline", "the outline felt", true),
        layer(
            Geometry::Dots(found.pegs.iter().map(|(p, _)| *p).collect()),
            "side-contact",
            "points felt with the side",
            true,
        ),
    ];
    scene_figure("The outline that was felt", captions, "odometry frame", &layers)
}
