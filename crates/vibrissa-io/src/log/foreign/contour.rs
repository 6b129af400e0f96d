//! Tip positions along a contour.

use super::lines::{lines, numbers};
use super::{Format, Recording, rostopic};

/// Farthest that an arm reaches (m); beyond it the file is not in metres.
const FARTHEST: f64 = 100.0;

/// Lines `x,y` in m after comment lines that start with `#`; or the echo of a twist whose linear part is the position.
pub(super) fn read(bytes: &[u8]) -> Recording {
    let echoed = lines(bytes).find(|line| !line.text.is_empty()).is_some_and(|line| line.text.starts_with("header:"));
    if echoed { from_echo(bytes) } else { from_text(bytes) }
}

fn from_text(bytes: &[u8]) -> Recording {
    let mut recording = Recording::new(Format::Contour, &[("x", "m"), ("y", "m")]);
    for line in lines(bytes) {
        if line.text.is_empty() || line.text.starts_with('#') {
            continue;
        }
        match numbers::<2>(line.text).filter(|p| p.iter().all(|v| v.abs() <= FARTHEST)) {
            Some(point) => recording.push(line.number, point),
            None => recording.repairs.drop_line(&line),
        }
    }
    recording
}

fn from_echo(bytes: &[u8]) -> Recording {
    let echo = rostopic::read(bytes);
    let mut recording = Recording::new(Format::Contour, &[("x", "m"), ("y", "m")]);
    recording.repairs = echo.repairs;
    let [Some(x), Some(y)] = ["twist_x", "twist_y"].map(|name| echo.column(name)) else { return recording };
    for (index, line) in echo.lines.iter().enumerate() {
        let point = [x[index], y[index]];
        if point.iter().all(|v| v.abs() <= FARTHEST) {
            recording.push(*line, point);
            recording.t.push(echo.t[index]);
        } else {
            recording.repairs.lines_dropped += 1;
        }
    }
    recording
}
