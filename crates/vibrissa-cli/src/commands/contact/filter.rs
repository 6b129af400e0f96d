//! Temporal filtering of a log: contact sets of several readings, intersected.

use crate::output::{OutputArgs, print, warn, write_all, wrote};
use serde_json::json;
use std::fmt::Write;
use std::path::Path;
use vibrissa::figure::{Geometry, Layer, scene_figure};
use vibrissa::flow::sensor_log::SensorLog;
use vibrissa::plane::Vec2;
use vibrissa::tasks::doubts;
use vibrissa::tasks::temporal_filter::{FilteredContact, TemporalFilterOptions, temporal_filter};
use vibrissa::world::Robot;
use vibrissa::{Error, Result};

/// Filters, writes and prints.
pub(super) fn run(
    log: &Path,
    read: &SensorLog,
    robot: Option<&Path>,
    options: &TemporalFilterOptions,
    output: &OutputArgs,
) -> Result<()> {
    let robot = robot.map_or_else(|| Ok(Robot::default()), vibrissa::read_robot)?;
    // Who uses columns of virtual sensors is said to the others.
    let told = read.warnings.iter().filter(|warning| !warning.contains("`contact --filter`"));
    told.chain(&doubts(Some(read), &robot, None)).for_each(|warning| warn(warning));
    let found = temporal_filter(read, &robot, options).map_err(|error| error.in_file(log))?;
    let written = match output.destination() {
        Some(to) => write_all(to, &[("filter.csv", csv(&found, &robot)), ("filter.svg", figure(&found, &robot, log))])?,
        None => Vec::new(),
    };
    if output.json {
        return print(&as_json(&found, &robot)?);
    }
    print(&(words(&found) + &wrote(&written)))
}

fn name<'a>(robot: &'a Robot, one: &FilteredContact) -> &'a str {
    robot.whiskers.get(one.whisker).map_or("", |whisker| &whisker.name)
}

fn words(found: &[FilteredContact]) -> String {
    if found.is_empty() {
        return "no contact: no reading rises above the declared noise\n".to_owned();
    }
    let area = |several: bool| {
        let mut areas: Vec<f64> =
            found.iter().filter(|one| (one.readings > 1) == several).map(|one| 1e6 * one.area).collect();
        areas.sort_by(f64::total_cmp);
        areas.get(areas.len() / 2).copied()
    };
    let filtered = found.iter().filter(|one| one.readings > 1).count();
    let mut text = format!("{} contact sets, {filtered} of them from several readings\n", found.len());
    for (several, what) in [(false, "one reading"), (true, "several readings")] {
        if let Some(area) = area(several) {
            let _ = writeln!(text, "  from {what}: {area:.2} mm² in the median");
        }
    }
    text
}

fn csv(found: &[FilteredContact], robot: &Robot) -> String {
    let mut text = String::from("t,whisker,readings,components,area_m2,x,y,x_min,x_max,y_min,y_max,x_odom,y_odom\n");
    for one in found {
        let ([x, y], at) = (one.extent, one.position());
        let numbers = [one.contact.x, one.contact.y, x.lo(), x.hi(), y.lo(), y.hi(), at.x, at.y];
        let numbers = numbers.map(|number| number.to_string()).join(",");
        let name = name(robot, one);
        let _ = writeln!(text, "{},{name},{},{},{},{numbers}", one.t, one.readings, one.components, one.area);
    }
    text
}

fn as_json(found: &[FilteredContact], robot: &Robot) -> Result<String> {
    let one = |one: &FilteredContact| {
        let ([x, y], at) = (one.extent, one.position());
        json!({
            "t": one.t, "whisker": name(robot, one), "readings": one.readings, "components": one.components,
            "area_m2": one.area, "x": one.contact.x, "y": one.contact.y, "x_min": x.lo(), "x_max": x.hi(),
            "y_min": y.lo(), "y_max": y.hi(), "x_odom": at.x, "y_odom": at.y,
        })
    };
    let text = serde_json::to_string_pretty(&json!({ "contacts": found.iter().map(one).collect::<Vec<_>>() }));
    text.map(|text| text + "\n").map_err(|error| Error::data(format!("cannot write the result as JSON ({error})")))
}

fn figure(found: &[FilteredContact], robot: &Robot, log: &Path) -> String {
    let layer = |geometry, class, label: &str| Layer { geometry, class, label: label.to_owned(), framed: true };
    let ring = |one: &FilteredContact| -> Vec<Vec2> {
        let [x, y] = one.extent;
        let corners = [(x.lo(), y.lo()), (x.hi(), y.lo()), (x.hi(), y.hi()), (x.lo(), y.hi())];
        corners.map(|(x, y)| one.odom_from_whisker.transform_point(Vec2::new(x, y))).to_vec()
    };
    let several = || found.iter().filter(|one| one.readings > 1);
    let base = |whisker| found.iter().filter(move |one| one.whisker == whisker);
    let bases = (0..robot.whiskers.len()).map(|w| base(w).map(|one| one.odom_from_whisker.position()).collect());
    let layers = [
        layer(Geometry::Rings(several().map(ring).collect()), "extent", "extent of what several readings leave"),
        layer(Geometry::Lines(bases.collect()), "path", "the whiskers' bases"),
        layer(Geometry::Dots(several().map(FilteredContact::position).collect()), "side-contact", "its middle"),
    ];
    let title = format!("Contacts of {}, filtered", log.file_name().unwrap_or(log.as_os_str()).to_string_lossy());
    scene_figure(&title, &[words(found).lines().next().unwrap_or_default().to_owned()], "odometry frame", &layers)
}
