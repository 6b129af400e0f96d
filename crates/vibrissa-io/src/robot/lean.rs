//! Whiskers that are mounted out of the horizontal, on a body that may be tilted.

use crate::math;
use crate::plane::Pose2;
use crate::toml_section::{Allowed, HEADING, MOUNT, Section};
use crate::units::Dimension;
use crate::world::{Lean, Robot};
use crate::{Error, Result};

const ELEVATION: Allowed = Allowed {
    holds: |v| v.abs() <= STEEPEST,
    text: "-80 deg to 80 deg",
    remedy: "a bare number is in radians; write \"20 deg\" for degrees; a whisker that points up or down has no heading",
};
const TILT: Allowed = Allowed {
    holds: |v| v.abs() <= STEEPEST,
    text: "-80 deg to 80 deg",
    remedy: "a bare number is in radians; write \"5 deg\" for degrees",
};
/// How steeply a whisker may lean (rad): 80 deg.
const STEEPEST: f64 = 80.0 / 360.0 * core::f64::consts::TAU;

type Vec3 = [f64; 3];
/// Columns: where x, y and z go.
type Turn = [Vec3; 3];

/// How a `[[whisker]]` is mounted out of the horizontal: as its keys say, on a body that is level.
pub(super) fn lean(section: &Section<'_>) -> Result<Lean> {
    let level = Lean::default();
    Ok(Lean {
        elevation: section.number("elevation", Dimension::Angle, &ELEVATION)?.unwrap_or(level.elevation),
        roll: section.number("roll", Dimension::Angle, &HEADING)?.unwrap_or(level.roll),
    })
}

/// The robot with its whiskers as they stand in the world, on the body of a `[body]` section.
pub(super) fn leaning(top: &Section<'_>, mut robot: Robot) -> Result<Robot> {
    let body = top.section("body")?;
    let (mut height, mut turn, mut is_tilted) = (None, about(1, 0.0), false);
    if let Some(body) = &body {
        body.only(&["height", "pitch", "roll"])?;
        height = body.number("height", Dimension::Length, &MOUNT)?;
        let angle = |key| -> Result<f64> { Ok(body.number(key, Dimension::Angle, &TILT)?.unwrap_or(0.0)) };
        let (pitch, roll) = (angle("pitch")?, angle("roll")?);
        turn = times(&about(1, pitch), &about(0, roll));
        is_tilted = pitch.abs() > 0.0 || roll.abs() > 0.0;
    }
    let heights = mount_heights(top)?;
    for (index, whisker) in robot.whiskers.iter_mut().enumerate() {
        let (mount, lean) = (whisker.robot_from_whisker, whisker.lean);
        let up = heights.get(index).copied().flatten();
        let base = moved(&turn, [mount.x, mount.y, up.unwrap_or(0.0)]);
        let mounted = times(&times(&about(2, mount.theta), &about(1, -lean.elevation)), &about(0, lean.roll));
        let standing = if is_tilted { stands(&times(&turn, &mounted)) } else { (mount.theta, lean) };
        let span = top.span_of("whisker");
        if standing.1.elevation.abs() > STEEPEST {
            return Err(top
                .source
                .fault(&span, format!("the whisker \"{}\" points too steeply on its tilted body", whisker.name))
                .value(format!("{:.1} deg", standing.1.elevation.to_degrees()))
                .allowed(ELEVATION.text)
                .remedy("a whisker that points up or down has no heading"));
        }
        if let Some(height) = height {
            let tip = height + base[2] + whisker.beam.length * math::sin(standing.1.elevation);
            if tip < 0.0 || height + base[2] < 0.0 {
                return Err(Error::data(format!("the whisker \"{}\" reaches below the floor", whisker.name))
                    .in_file(top.source.name)
                    .at_line(top.source.line(&span))
                    .value(format!("{tip:.4} m at its tip, {:.4} m at its base", height + base[2]))
                    .allowed("0 m or more")
                    .remedy("check body.height, mount_height and the angles; elevation is positive upwards"));
            }
        }
        if is_tilted {
            whisker.robot_from_whisker = Pose2::new(base[0], base[1], standing.0);
            whisker.lean = standing.1;
        }
    }
    Ok(robot)
}

/// The heights of the mounts above the robot's origin, where they are given.
fn mount_heights(top: &Section<'_>) -> Result<Vec<Option<f64>>> {
    let list = top.get("whisker").and_then(|value| value.get_ref().as_array());
    let Some(list) = list else { return Ok(Vec::new()) };
    let of = |(index, entry): (usize, &toml::Spanned<toml::de::DeValue<'_>>)| {
        let Some(table) = entry.get_ref().as_table() else { return Ok(None) };
        let path = if list.len() == 1 { "whisker".to_owned() } else { format!("whisker[{index}]") };
        Section { source: top.source, table, path, span: entry.span() }.number(
            "mount_height",
            Dimension::Length,
            &MOUNT,
        )
    };
    list.iter().enumerate().map(of).collect()
}

/// Heading of a frame's x axis, how it leans, and how the frame is turned about it.
fn stands([a, left, _]: &Turn) -> (f64, Lean) {
    let heading = math::atan2(a[1], a[0]);
    let elevation = math::asin(a[2].clamp(-1.0, 1.0));
    let ((sin_h, cos_h), (sin_e, cos_e)) = (math::sin_cos(heading), math::sin_cos(elevation));
    let dot = |v: Vec3| (0..3).map(|k| v[k] * left[k]).sum::<f64>();
    let roll = math::atan2(dot([-sin_e * cos_h, -sin_e * sin_h, cos_e]), dot([-sin_h, cos_h, 0.0]));
    (heading, Lean { elevation, roll })
}

/// The turn about an axis, right-handed (rad).
fn about(axis: usize, angle: f64) -> Turn {
    let ((sin, cos), (i, j)) = (math::sin_cos(angle), ((axis + 1) % 3, (axis + 2) % 3));
    let mut turn = [[0.0; 3]; 3];
    (turn[axis][axis], turn[i][i], turn[j][j], turn[i][j], turn[j][i]) = (1.0, cos, cos, sin, -sin);
    turn
}

fn moved(turn: &Turn, [x, y, z]: Vec3) -> Vec3 {
    [0, 1, 2].map(|k| turn[0][k] * x + turn[1][k] * y + turn[2][k] * z)
}

/// First the second turn, then the first.
fn times(first: &Turn, second: &Turn) -> Turn {
    second.map(|column| moved(first, column))
}
