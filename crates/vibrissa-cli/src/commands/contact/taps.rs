//! Taps: short contacts, one distance each.

use crate::commands::calibrate::{pretty, read_taps, repairs_json};
use crate::output::{OutputArgs, print, warn, write_all, wrote};
use serde_json::json;
use std::fmt::Write;
use std::path::Path;
use vibrissa::flow::taps::Tap;
use vibrissa::io::log::foreign::Format;
use vibrissa::world::calibration::{Calibration, Distance, DistanceModel, Motion};
use vibrissa::{Error, Result};

/// Finds the taps of a recording and their distances.
pub(super) fn run(
    log: &Path,
    calibration: &Path,
    format: Option<Format>,
    reference: Option<&str>,
    output: &OutputArgs,
) -> Result<()> {
    let calibrated = vibrissa::read_calibration(calibration)?;
    let model = turning(&calibrated, calibration)?;
    let (recording, found) = read_taps(log, format, &calibrated.channel, reference)?;
    let taps: Vec<(Tap, Option<Distance>)> = found.iter().map(|tap| (*tap, model.distance(tap.slope))).collect();
    let outside = taps.iter().filter(|(_, d)| d.is_none_or(|d| !fitted(&model, d.distance))).count();
    if outside > 0 {
        let [lo, hi] = model.fitted.map(|d| d * 1e3);
        warn(&format!("{outside} taps lie outside the calibrated distances, {lo:.1} to {hi:.1} mm"));
    }
    let written = match output.destination() {
        Some(to) => write_all(to, &[("taps.csv", csv(&taps))])?,
        None => Vec::new(),
    };
    if output.json {
        let list: Vec<serde_json::Value> = taps.iter().map(tap_json).collect();
        return print(&pretty(&json!({ "taps": list, "repairs": repairs_json(recording.repairs) })));
    }
    print(&(text(&taps) + &wrote(&written)))
}

fn turning(calibration: &Calibration, path: &Path) -> Result<DistanceModel> {
    let model = calibration.distance.filter(|model| model.motion == Motion::Turn);
    model.ok_or_else(|| {
        Error::data("the calibration does not tell distances from taps")
            .in_file(path)
            .remedy("make one with `vibrissa calibrate --taps DIST=FILE … --out DIR`")
    })
}

/// Within the calibrated distances and a tenth of their span.
fn fitted(model: &DistanceModel, distance: f64) -> bool {
    let [lo, hi] = model.fitted;
    let slack = 0.1 * (hi - lo);
    distance >= lo - slack && distance <= hi + slack
}

fn tap_json((tap, distance): &(Tap, Option<Distance>)) -> serde_json::Value {
    json!({
        "t": tap.t, "distance": distance.map(|d| d.distance), "distance_std": distance.map(|d| d.std),
        "slope": tap.slope,
    })
}

/// `t,distance,distance_std,slope` (s, m, m, reading per s); the cells are empty where no distance fits.
fn csv(taps: &[(Tap, Option<Distance>)]) -> String {
    let mut text = String::from("t,distance,distance_std,slope\n");
    for (tap, distance) in taps {
        let cells = distance.map_or(",".to_owned(), |d| format!("{},{}", d.distance, d.std));
        let _ = writeln!(text, "{},{cells},{}", tap.t, tap.slope);
    }
    text
}

fn text(taps: &[(Tap, Option<Distance>)]) -> String {
    let mut text = format!("{} taps\n", taps.len());
    if taps.is_empty() {
        return text + "no reading stands out from the noise; check --format and the calibration's channel\n";
    }
    let _ = writeln!(text, "\n       t s   distance mm   ± mm");
    for (tap, distance) in taps {
        let _ = match distance {
            Some(d) => writeln!(text, "{:>10.3}   {:>11.2}   {:>4.2}", tap.t, d.distance * 1e3, d.std * 1e3),
            None => writeln!(text, "{:>10.3}   steeper or flatter than any place on the shaft", tap.t),
        };
    }
    text
}
