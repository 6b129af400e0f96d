//! Every file format: damaged files are read or refused with a message, and what is read is sound.

use super::{Verdict, promise, read, refused, size};
use std::path::PathBuf;
use vibrissa::config::TapOptions;
use vibrissa::flow::taps::taps;
use vibrissa::flow::trajectory::pose_at;
use vibrissa::io::log::foreign::{Format, Recording};
use vibrissa::io::{Dimension, parse_quantity};
use vibrissa::io::{format_tum, parse_tum};
use vibrissa::sim::Scenario;
use vibrissa::world::Map;

pub(crate) const LOG_WORDS: &[&str] =
    &[",moment", "w0.moment", ",heading", ",bx", "w1.ax", "\"", "\r\n", "\u{feff}", ",", "t,x,y,theta,moment\n", "# "];

pub(crate) const FOREIGN_WORDS: &[&str] = &[
    "---\n",
    "header:\n",
    "  stamp:\n",
    "    secs: ",
    "    nsecs: ",
    "pose:\n",
    "      x: ",
    "wrench:\n",
    "twist:\n",
    "magnetic_field:\n",
    "orientation:\n",
    "w: 1\n",
    ",",
    ";",
    "\t",
    "\r\n",
    "\r",
    "time,",
    "x,y,z\n",
    "\u{feff}",
];

pub(crate) const GEOJSON_WORDS: &[&str] = &[
    "[",
    "]",
    "{",
    "}",
    "[[[",
    ",",
    "\"type\"",
    "\"Polygon\"",
    "\"LineString\"",
    "\"MultiPolygon\"",
    "\"Point\"",
    "\"role\"",
    "\"arena\"",
    "\"obstacle\"",
    "\"wall\"",
    "\"coordinates\"",
    "\"geometry\"",
    "null",
    "\\u0000",
    "\\ud800",
    "\"FeatureCollection\"",
    "\"features\"",
    "\"properties\"",
    "[0,0],",
    "[0,0,0]",
];

pub(crate) const SVG_WORDS: &[&str] = &[
    "<g>",
    "</g>",
    "<g transform=\"scale(0)\">",
    " transform=\"rotate(30) translate(1,2)\"",
    " transform=\"skewX(89.999)\"",
    " transform=\"matrix(1 0 0 0 0 0)\"",
    "<rect id=\"wall\" width=\"1\" height=\"1\" rx=\"9\"/>",
    "<circle r=\"1\"/>",
    "<ellipse id=\"obstacle\" rx=\"1\" ry=\"0\"/>",
    "<path id=\"wall\" d=\"M0 0 A 1 2 30 1 0 5 5 Z\"/>",
    "<use href=\"#a\"/>",
    "<polygon class=\"obstacle\" points=\"0,0 1,1 2,0\"/>",
    "<polyline id=\"wall\" points=\"0,0 1\"/>",
    "M",
    "m",
    "Z",
    "A",
    "C",
    "S",
    "Q",
    "T",
    "H",
    "V",
    "l",
    "a1,1 0 0 1 0,0",
    "viewBox=\"0 0 0 0\"",
    "preserveAspectRatio=\"none\"",
    "mm",
    "%",
    "em",
    "&amp;",
    "&#0;",
    "<!DOCTYPE svg [<!ENTITY a \"b\">]>",
    "<![CDATA[",
    "-->",
    "<!--",
    "display:none",
];

pub(crate) const TOML_WORDS: &[&str] = &[
    "[[whisker]]\n",
    "[odometry]\n",
    "[path]\n",
    "[[path.leg]]\n",
    "[noise]\n",
    "[[noise.odometry.slip]]\n",
    "[sensing]\n",
    "name = \"w\"\n",
    "length = ",
    "mount = [0, 0, 0]\n",
    "flexural_rigidity = ",
    "base_stiffness = inf\n",
    "curvature = [1, 2, 3]\n",
    "segments = [{ length = 0.02, flexural_rigidity = 1e-4 }]\n",
    "tip_ratio = 0.1\n",
    "friction = 0.3\n",
    "kind = \"arc\"\n",
    "kind = \"wall\"\n",
    "kind = \"spline\"\n",
    "to = [0.1, 0.2]\n",
    "speed = ",
    "standoff = ",
    "through = [[0, 0], [0.1, 0.1]]\n",
    "radius = ",
    "turn = ",
    "rate = ",
    "\"",
    "'''",
    "[",
    "]",
    "{",
    "}",
    "inf",
    "nan",
    "mm",
    "deg",
    "mN m",
    "%",
    "0x7fffffffffffffff",
    "1979-05-27",
    "a.b.c = ",
    "\\u0000",
];

pub(crate) const DXF_WORDS: &[&str] = &[
    "  0\n",
    "SECTION\n",
    "ENTITIES\n",
    "ENDSEC\n",
    "EOF\n",
    "  8\n",
    "arena\n",
    "obstacle\n",
    "wall\n",
    " 10\n",
    " 20\n",
    " 40\n",
    " 41\n",
    " 42\n",
    " 70\n",
    " 71\n",
    "230\n",
    "-1\n",
    "1e300\n",
    "0.0\n",
    "LINE\n",
    "ARC\n",
    "CIRCLE\n",
    "SPLINE\n",
    "LWPOLYLINE\n",
    "POLYLINE\n",
    "VERTEX\n",
    "ELLIPSE\n",
    "INSERT\n",
    "$INSUNITS\n",
];

pub(crate) const UNIT_WORDS: &[&str] = &[
    "mm", "µm", "GPa", "N m", "N·m", "m^2", "m²", "/", "deg", "°", "%", "1/", "rad", "s^-1", "k", " ", "·", "*", "e",
    "-", "inf",
];

pub(crate) fn log(bytes: &[u8]) -> Verdict {
    match vibrissa::io::log::from_csv(&text(bytes), "log.csv") {
        Err(error) => refused(&error),
        Ok(log) => {
            let increasing = log.rows.windows(2).all(|w| w[0].t < w[1].t);
            promise(increasing, || "a log whose clock does not increase was read".into())?;
            let whole = log.rows.iter().all(|row| {
                let pose = row.odom_from_robot;
                let numbers = [row.t, pose.x, pose.y, pose.theta, row.heading.unwrap_or(0.0)];
                numbers.iter().chain(&row.readings).all(|v| v.is_finite()) && row.readings.len() == log.channels.len()
            });
            promise(whole && !log.rows.is_empty(), || "a log with gaps was read".into())?;
            read((size(log.rows.len()), log.channels.len(), log.warnings.len(), log.rows[0].heading.is_some()))
        }
    }
}

/// The first byte chooses the format, so that one set of seeds serves all.
pub(crate) fn foreign(bytes: &[u8]) -> Verdict {
    let (choice, rest) = bytes.split_first().unwrap_or((&0, &[]));
    let format = Format::ALL[usize::from(*choice) % Format::ALL.len()];
    let mut recording = match Recording::from_bytes(rest, format, "log") {
        Err(error) => return refused(&error),
        Ok(recording) => recording,
    };
    let rows = recording.lines.len();
    let even = recording.series.iter().all(|s| s.values.len() == rows) && [0, rows].contains(&recording.t.len());
    promise(even && rows > 0, || format!("{}: columns of different lengths", format.as_str()))?;
    let columns = recording.series.len();
    let tapped = recording.series.iter().map(|s| taps(&recording.t, &s.values, &TapOptions::default()).len()).sum();
    let repaired = recording.repairs.words().len();
    let _ = recording.rate();
    let logged = recording.to_log().is_ok();
    let subtracted = recording.subtract_reference("1", "2").is_ok();
    read((format.as_str(), size(rows), size(columns), size(tapped), repaired, logged, subtracted))
}

pub(crate) fn geojson(bytes: &[u8]) -> Verdict {
    map(vibrissa::io::map::from_geojson(&text(bytes), "map.geojson"))
}

pub(crate) fn svg(bytes: &[u8]) -> Verdict {
    map(vibrissa::io::map::from_svg(&text(bytes), "map.svg"))
}

pub(crate) fn dxf(bytes: &[u8]) -> Verdict {
    map(vibrissa::io::map::from_dxf(&text(bytes), "map.dxf"))
}

/// A map that was read answers every question of the localizer.
pub(super) fn map(found: vibrissa::Result<Map>) -> Verdict {
    let map = match found {
        Err(error) => return refused(&error),
        Ok(map) => map,
    };
    let bounds = map.bounds();
    let extent = bounds.size().x.max(bounds.size().y);
    promise(extent.is_finite() && map.total_length().is_finite(), || format!("a map of {extent} m"))?;
    for share in [-0.1, 0.0, 0.31, 0.5, 1.0] {
        let place = bounds.min + bounds.size() * share;
        let near = map.nearest(place);
        promise(
            near.is_some_and(|n| n.position.is_finite() && n.tangent.is_finite() && n.distance.is_finite()),
            || format!("no nearest point of {place:?}: {near:?}"),
        )?;
        let _ = (map.is_free(place), map.crosses(place, bounds.max), map.concave_corner(place, extent));
    }
    let spacing = map.total_length() / 500.0;
    let samples = map.samples(spacing);
    let sound = samples.iter().all(|s| s.position.is_finite() && s.tangent.is_finite() && s.arc_length.is_finite());
    promise(sound && !samples.is_empty(), || "boundary samples that are no numbers".into())?;
    let pieces: usize = map.boundaries().iter().map(|b| b.curve().segments().len()).sum();
    let roles = map.boundaries().iter().fold(0, |all, b| all | (1 << b.role() as usize));
    read((size(map.boundaries().len()), size(pieces), roles, map.warnings.len()))
}

pub(crate) fn robot(bytes: &[u8]) -> Verdict {
    let robot = match vibrissa::io::robot::from_toml(&text(bytes), "robot.toml") {
        Err(error) => return refused(&error),
        Ok(robot) => robot,
    };
    let written = vibrissa::io::robot::to_toml(&robot);
    match vibrissa::io::robot::from_toml(&written, "written.toml") {
        Ok(again) => promise(again == robot, || format!("the robot changes when it is written:\n{written}"))?,
        Err(error) => return Err(format!("a written robot is refused: {error}\n{written}")),
    }
    let uniform = robot.whiskers.iter().filter(|w| w.beam.is_uniform()).count();
    read((robot.whiskers.len(), uniform, robot.whiskers.iter().filter(|w| w.calibration.is_some()).count()))
}

/// Files that a scenario names are looked for among the scenarios.
pub(crate) fn scenario(bytes: &[u8]) -> Verdict {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../scenarios");
    match Scenario::from_toml(&text(bytes), "scenario.toml", folder) {
        Err(error) => refused(&error),
        Ok(scenario) => {
            let sound = scenario.path.iter().all(|p| p.t.is_finite() && p.map_from_robot.position().is_finite());
            promise(sound && !scenario.path.is_empty(), || "a path that is no numbers".into())?;
            promise(scenario.path.windows(2).all(|w| w[0].t < w[1].t), || "time stands on the path".into())?;
            read((size(scenario.path.len()), scenario.robot.whiskers.len(), scenario.outline.len()))
        }
    }
}

pub(crate) fn calibration(bytes: &[u8]) -> Verdict {
    let calibration = match vibrissa::io::calibration::from_json(&text(bytes), "cal.json") {
        Err(error) => return refused(&error),
        Ok(calibration) => calibration,
    };
    let written = vibrissa::io::calibration::to_json(&calibration).to_string();
    match vibrissa::io::calibration::from_json(&written, "written.json") {
        Ok(again) => promise(again == calibration, || format!("the calibration changes when written:\n{written}"))?,
        Err(error) => return Err(format!("a written calibration is refused: {error}\n{written}")),
    }
    if let Some(curve) = &calibration.moment {
        let readings = vec![1e-6; curve.inputs.len()];
        let _ = (curve.moment(&readings).map(|m| m.abs()), curve.moment(&curve.rest), curve.moment(&[]), curve.valid());
    }
    if let Some(tip) = &calibration.tip_deflection {
        let _ = (tip.at(0.0), tip.at(tip.largest_moment), tip.at(f64::MAX));
    }
    if let Some(model) = &calibration.distance {
        for slope in [0.0, 1.0, -1e9, f64::MAX, model.gain] {
            let found = model.distance(slope).map(|d| d.distance);
            promise(found.is_none_or(f64::is_finite), || format!("a distance of {found:?} for a slope of {slope}"))?;
        }
        let _ = model.slope(0.5 * model.length);
    }
    read((
        calibration.moment.is_some(),
        calibration.tip_deflection.is_some(),
        calibration.whisker.is_some(),
        calibration.distance.is_some(),
        size(calibration.data.len()),
    ))
}

pub(crate) fn tum(bytes: &[u8]) -> Verdict {
    let poses = match parse_tum(&text(bytes)) {
        Err(error) => return refused(&error),
        Ok(poses) => poses,
    };
    let sound = poses.iter().all(|p| p.t.is_finite() && p.map_from_robot.position().is_finite());
    promise(sound && poses.iter().all(|p| p.map_from_robot.theta.is_finite()), || "a pose that is no numbers".into())?;
    let middle = 0.5 * poses[0].t + 0.5 * poses[poses.len() - 1].t;
    promise(pose_at(&poses, middle).is_some(), || format!("no pose at {middle} inside the trajectory"))?;
    promise(format_tum(&poses).lines().count() == poses.len(), || "a pose is lost in writing".into())?;
    read(size(poses.len()))
}

pub(crate) fn quantity(bytes: &[u8]) -> Verdict {
    let text = text(bytes);
    let dimensions = [
        Dimension::Length,
        Dimension::Angle,
        Dimension::Moment,
        Dimension::Pressure,
        Dimension::FlexuralRigidity,
        Dimension::Stiffness,
        Dimension::Curvature,
        Dimension::Ratio,
        Dimension::Time,
        Dimension::Speed,
    ];
    let values = dimensions.map(|dimension| parse_quantity(&text, dimension));
    let nan = values.iter().flatten().any(|v| v.is_nan());
    promise(!nan, || format!("{text:?} is read as no number"))?;
    if let Some(error) = values.iter().find_map(|v| v.as_ref().err()) {
        refused(error)?;
    }
    read(values.map(|v| v.is_ok()))
}

fn text(bytes: &[u8]) -> std::borrow::Cow<'_, str> {
    String::from_utf8_lossy(bytes)
}
