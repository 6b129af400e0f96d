//! The map, the robot and its outline.

use super::points::{Value, is_nested, list};
use crate::config::scenario::MOUNT_SLACK;
use crate::io::Dimension;
use crate::io::robot::{map_scale, odometry_section, whisker_entries};
use crate::io::toml_section::{LENGTH, Section};
use crate::plane::{Curve, Vec2};
use crate::world::{Boundary, Map, Robot, Role};
use crate::{Error, Result};
use core::f64::consts::TAU;
use std::path::{Path, PathBuf};

/// Corners of the polygon that stands for a round robot.
const ROUND: usize = 48;

/// The map: a file, or polygons and walls right here. A table may name the file too, beside its `scale_error`.
pub(super) fn map(top: &Section<'_>, folder: &Path) -> Result<Map> {
    let Some(value) = top.get("map") else {
        return Err(Error::data("the scenario has no map")
            .in_file(top.source.name)
            .remedy("add map = \"FILE.svg\" at the top, or a [map] section with polygons"));
    };
    if let Some(file) = map_file(top, folder)? {
        return crate::io::read_map(file);
    }
    let neither = || {
        top.source
            .fault(&value.span(), "map must be a file or a table")
            .allowed("\"FILE.svg\", or a table with file, or with arena, obstacle and wall with points")
    };
    let section = if value.get_ref().is_table() { top.section("map")? } else { None }.ok_or_else(neither)?;
    let keys: Vec<&str> = Role::WORDS.into_iter().chain(["scale_error"]).collect();
    section.only(&keys)?;
    let mut boundaries = Vec::new();
    for role in [Role::Arena, Role::Obstacle, Role::Wall] {
        let Some(value) = section.get(role.word()) else { continue };
        let lines: Vec<&Value<'_>> = match value.get_ref().as_array() {
            Some(lines) if lines.iter().next().is_some_and(is_nested) => lines.iter().collect(),
            _ => vec![value],
        };
        for line in lines {
            boundaries.push(boundary(&section, role, line)?);
        }
    }
    Map::new(boundaries).map_err(|e| e.in_file(top.source.name).at_line(top.line_of("map")))
}

/// The file of the map; none when it is written right here.
pub(super) fn map_file(top: &Section<'_>, folder: &Path) -> Result<Option<PathBuf>> {
    match top.get("map") {
        Some(value) if value.get_ref().is_str() => Ok(top.text("map")?.map(|file| folder.join(file))),
        Some(value) if value.get_ref().is_table() => {
            let Some(section) = top.section("map")? else { return Ok(None) };
            let file = section.text("file")?.map(|file| folder.join(file));
            if file.is_some() {
                section.only(&["file", "scale_error"])?;
            }
            Ok(file)
        }
        _ => Ok(None),
    }
}

fn boundary(section: &Section<'_>, role: Role, value: &Value<'_>) -> Result<Boundary> {
    let points: Vec<Vec2> = list(section, role.word(), value, false)?.into_iter().map(|(point, _)| point).collect();
    let at = |error: Error| error.in_file(section.source.name).at_line(section.source.line(&value.span()));
    let curve = Curve::polyline(&points, role != Role::Wall).ok_or_else(|| {
        at(Error::data(format!("{}: a line needs at least two different points", section.key(role.word())))
            .value(format!("{} points", points.len())))
    })?;
    Boundary::new(role, curve, None).map_err(at)
}

/// The robot: a file, or whiskers and odometry right here.
pub(super) fn robot(top: &Section<'_>, folder: &Path) -> Result<Robot> {
    let map = match top.get("map") {
        Some(value) if value.get_ref().is_table() => top.section("map")?.filter(|map| map.get("scale_error").is_some()),
        _ => None,
    };
    if let Some(file) = top.text("robot")? {
        if let Some(both) = ["whisker", "odometry"].into_iter().find(|key| top.get(key).is_some()) {
            return Err(top
                .source
                .fault(&top.span_of(both), format!("both a robot file and {both}"))
                .remedy(format!("remove the robot file, or move {both} into it")));
        }
        if let Some(map) = map {
            return Err(top
                .source
                .fault(&map.span_of("scale_error"), "both a robot file and map.scale_error")
                .remedy("remove the robot file, or move it into that file as [map] scale_error"));
        }
        let robot = crate::io::read_robot(folder.join(file))?;
        robot.require_level("the simulator")?;
        return Ok(robot);
    }
    let odometry = match top.section("odometry")? {
        Some(section) => odometry_section(&section)?,
        None => Robot::default().odometry,
    };
    let map_scale = map.map_or(Ok(Robot::default().map_scale), |map| map_scale(&map))?;
    let robot = Robot { whiskers: whisker_entries(top)?, odometry, map_scale };
    robot.require_level("the simulator").map_err(|e| e.in_file(top.source.name).at_line(top.line_of("whisker")))?;
    Ok(robot)
}

/// The robot's outline: `{ radius = … }` or a polygon. Every whisker is mounted inside or on it.
pub(super) fn outline(top: &Section<'_>, robot: &Robot) -> Result<Vec<Vec2>> {
    let Some(value) = top.get("outline") else { return Ok(Vec::new()) };
    let points: Vec<Vec2> = if value.get_ref().is_table() {
        let section = top.section("outline")?.ok_or_else(|| top.source.fault(&value.span(), "outline is no table"))?;
        section.only(&["radius"])?;
        let radius = section.number("radius", Dimension::Length, &LENGTH)?.ok_or_else(|| {
            top.source
                .fault(&value.span(), "a round outline needs a radius")
                .remedy("write outline = { radius = \"60 mm\" }")
        })?;
        (0..ROUND).map(|k| Vec2::from_angle(TAU * k as f64 / ROUND as f64) * radius).collect()
    } else {
        list(top, "outline", value, false)?.into_iter().map(|(point, _)| point).collect()
    };
    let polygon = Curve::polyline(&points, true)
        .and_then(|curve| Boundary::new(Role::Arena, curve, None).ok())
        .and_then(|boundary| Map::new(vec![boundary]).ok());
    let Some(inside) = polygon else {
        return Err(top
            .source
            .fault(&value.span(), "the robot's outline is no simple polygon")
            .remedy("give at least three points that go round once"));
    };
    for (index, whisker) in robot.whiskers.iter().enumerate() {
        let mount = whisker.robot_from_whisker.position();
        let outside = inside.nearest(mount).map_or(0.0, |near| near.distance);
        if !inside.is_free(mount) && outside > MOUNT_SLACK {
            let here =
                top.entries("whisker")?.get(index).map_or(top.line_of("outline"), |entry| entry.line_of("mount"));
            return Err(Error::data(format!(
                "the mount of the whisker {} is outside the robot's outline",
                whisker.name
            ))
            .in_file(top.source.name)
            .at_line(here)
            .value(format!("({}, {}) m, {:.1} mm outside", mount.x, mount.y, outside * 1e3))
            .allowed("inside or on it, to 1 mm")
            .remedy("move the mount or widen the outline"));
        }
    }
    Ok(points)
}
