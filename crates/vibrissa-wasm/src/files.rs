//! Files in and out.

use crate::host::Host;
use serde_json::json;
use std::path::Path;
use vibrissa::figure::{LocalizationScene, OutlineRole, localization_figure};
use vibrissa::io::{format_tum, log, map, parse_tum, robot, text::text_of};
use vibrissa::tasks::outlines;
use vibrissa::world::Robot;
use vibrissa::{Error, Result};

/// How far a drawn boundary may be from the map's (m).
const DRAWING_TOLERANCE: f64 = 2e-5;

pub(crate) fn read(host: &mut Host, kind: u32) -> Result<()> {
    let bytes = core::mem::take(&mut host.input);
    let split = bytes.iter().position(|&b| b == 0).unwrap_or(bytes.len());
    let name = String::from_utf8_lossy(&bytes[..split]).into_owned();
    let content = bytes.get(split + 1..).unwrap_or_default().to_vec();
    match kind {
        0 => read_map(host, content, &name),
        1 => read_robot(host, content, &name),
        2 => read_log(host, &content, &name),
        3 => read_truth(host, content, &name),
        4 => {
            host.beside = Some((name, content));
            Ok(())
        }
        other => Err(Error::usage("kind").value(other).allowed("0 to 4")),
    }
}

fn read_map(host: &mut Host, content: Vec<u8>, name: &str) -> Result<()> {
    let beside = host.beside.take();
    let named =
        |image: &Path| beside.filter(|(name, _)| image.file_name().is_some_and(|wanted| wanted == name.as_str()));
    let map = map::from_bytes_beside(content, name, |image| named(image).map(|(_, bytes)| bytes))?;
    let drawn = outlines(&map, DRAWING_TOLERANCE);
    host.count(drawn.len());
    for outline in &drawn {
        let role = match outline.role {
            OutlineRole::Arena => 0.0,
            OutlineRole::Obstacle => 1.0,
            OutlineRole::Wall => 2.0,
        };
        host.push([role, f64::from(u8::from(outline.closed))]);
        host.points(&outline.points);
    }
    host.text = map.warnings.join("\n");
    host.map = Some(map);
    Ok(())
}

fn read_robot(host: &mut Host, content: Vec<u8>, name: &str) -> Result<()> {
    let robot = if name.is_empty() {
        Robot::default()
    } else {
        robot::from_toml(&text_of(content, name.as_ref(), "robot")?, name)?
    };
    host.count(robot.whiskers.len());
    for whisker in &robot.whiskers {
        host.push([whisker.beam.length]);
        host.pose(whisker.robot_from_whisker);
    }
    host.robot = robot;
    Ok(())
}

fn read_log(host: &mut Host, content: &[u8], name: &str) -> Result<()> {
    let log = log::from_bytes(content, name)?;
    host.count(log.rows.len());
    host.count(log.channels.len());
    log.rows.iter().for_each(|row| host.row(row));
    let columns: Vec<String> = log.channels.iter().map(|channel| channel.column()).collect();
    host.text = core::iter::once(columns.join(" ")).chain(log.warnings.iter().cloned()).collect::<Vec<_>>().join("\n");
    host.log = log;
    Ok(())
}

fn read_truth(host: &mut Host, content: Vec<u8>, name: &str) -> Result<()> {
    let poses = parse_tum(&text_of(content, name.as_ref(), "trajectory")?).map_err(|error| error.in_file(name))?;
    host.count(poses.len());
    for stamped in &poses {
        host.push([stamped.t]);
        host.pose(stamped.map_from_robot);
    }
    host.truth = poses;
    Ok(())
}

pub(crate) fn write(host: &mut Host, kind: u32) -> Result<()> {
    let no_answer = || Error::usage("no localization has ended yet");
    host.text = match kind {
        0 => log::to_csv(&host.log),
        1 => robot::to_toml(&host.robot),
        2 => {
            let title = host.input_text();
            let map = outlines(host.map()?, DRAWING_TOLERANCE);
            let answer = host.answer.as_ref().ok_or_else(no_answer)?;
            let truth = (!host.truth.is_empty()).then_some(host.truth.as_slice());
            localization_figure(&LocalizationScene { title: &title, map: &map, answer, truth, robot: &[] })
        }
        3 => format_tum(&host.answer.as_ref().ok_or_else(no_answer)?.trajectory),
        4 => geojson(host)?,
        other => return Err(Error::usage("kind").value(other).allowed("0 to 4")),
    };
    Ok(())
}

/// The map as polylines.
fn geojson(host: &Host) -> Result<String> {
    let feature = |outline: &vibrissa::figure::Outline| {
        let mut ring: Vec<[f64; 2]> = outline.points.iter().map(|p| [p.x, p.y]).collect();
        if outline.closed {
            ring.extend(ring.first().copied());
        }
        let (role, geometry) = match outline.role {
            OutlineRole::Arena => ("arena", json!({ "type": "Polygon", "coordinates": [ring] })),
            OutlineRole::Obstacle => ("obstacle", json!({ "type": "Polygon", "coordinates": [ring] })),
            OutlineRole::Wall => ("wall", json!({ "type": "LineString", "coordinates": ring })),
        };
        json!({ "type": "Feature", "properties": { "role": role }, "geometry": geometry })
    };
    let features: Vec<_> = outlines(host.map()?, DRAWING_TOLERANCE).iter().map(feature).collect();
    Ok(json!({ "type": "FeatureCollection", "features": features }).to_string())
}
