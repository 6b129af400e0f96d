//! Distances: from taps of a turning base, or from a staircase of lateral travel.

use super::{Report, file_name, pretty, read_taps, repairs_json, say_repairs};
use crate::output::warn;
use crate::quantity::option;
use serde_json::json;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use vibrissa::config::{StaircaseOptions, shaft};
use vibrissa::figure::{Plot, calibration_figure};
use vibrissa::io::Dimension;
use vibrissa::io::log::foreign::{Format, Recording, Repairs};
use vibrissa::tasks::calibrate::{
    DistanceFit, DistanceSet, LeftOut, Shaft, TapSets, Taper, fit_distance, leave_one_out, staircase,
};
use vibrissa::world::Robot;
use vibrissa::world::calibration::{Calibration, Motion, Source};
use vibrissa::{Error, Result};

/// What is known of the shaft.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Options of distances")]
pub(super) struct DistanceArgs {
    #[arg(
        long,
        value_name = "LENGTH",
        help = format!(
            "Length of the shaft from base to tip [default: the robot's; for taps without --robot {} mm; for a staircase \
             without --robot {} mm]",
            1e3 * shaft::TAPPED_LENGTH,
            1e3 * shaft::STAIRCASE_LENGTH
        )
    )]
    length: Option<String>,
    #[arg(
        long,
        value_name = "RATIO",
        help = format!(
            "Tip radius over base radius, or `free` to fit it [default: the robot's; for taps without --robot 1/{}; for a \
             staircase without --robot free]",
            shaft::TAPPED_TIP_RATIO.recip()
        )
    )]
    tip_ratio: Option<String>,
    /// Whether the base is clamped; otherwise its compliance is fitted [default: clamped where the taper is free]
    #[arg(long)]
    clamped: bool,
    /// The column whose slope tells the distance [default: ax for taps, ay for a staircase]
    #[arg(long, value_name = "COLUMN")]
    channel: Option<String>,
    /// The sensor that feels the ambient field alone, subtracted from the channel's: `--channel 1.bx --reference 2`
    #[arg(long, value_name = "SENSOR")]
    reference: Option<String>,
}

impl DistanceArgs {
    fn shaft(&self, motion: Motion, robot: Option<&Robot>) -> Result<Shaft> {
        let beam = robot.and_then(|robot| robot.whiskers.first()).map(|whisker| whisker.beam);
        let length = option("--length", Dimension::Length, self.length.as_deref())?;
        let taper = match self.tip_ratio.as_deref() {
            Some("free") => Taper::Free,
            ratio => option("--tip-ratio", Dimension::Ratio, ratio)?.map_or(Taper::Usual, Taper::Given),
        };
        Shaft::described(motion, beam.as_ref(), length, taper, self.clamped)
    }
}

/// Taps at known distances.
pub(super) fn from_taps(
    taps: &[String],
    format: Option<Format>,
    robot: Option<&Robot>,
    args: &DistanceArgs,
) -> Result<Report> {
    let shaft = args.shaft(Motion::Turn, robot)?;
    let channel = args.channel.clone().unwrap_or_else(|| "ax".to_owned());
    let mut gathered = TapSets::default();
    for pair in taps {
        let (distance, path) = labelled(pair, shaft.length)?;
        let (recording, found) = read_taps(&path, format, &channel, args.reference.as_deref())?;
        if !gathered.add(&path, distance, &recording, &found) {
            let source = path.display();
            warn(&format!("{source}: no taps found, the file is left out; check --format and --channel"));
        }
    }
    report(&gathered.sets, shaft, channel, gathered.data, gathered.repairs)
}

/// A staircase at several distances.
pub(super) fn from_staircase(path: &Path, robot: Option<&Robot>, args: &DistanceArgs) -> Result<Report> {
    let shaft = args.shaft(Motion::Travel, robot)?;
    let channel = args.channel.clone().unwrap_or_else(|| "ay".to_owned());
    let recording = Recording::read(path, Format::Openwhisker)?;
    say_repairs(&recording);
    let sets = staircase(&recording, &channel, shaft.length, &StaircaseOptions::default())?;
    let used = sets.iter().map(|set| set.samples.len()).sum();
    let source = Source { file: file_name(path), rows: recording.lines.len(), used, distance: None };
    report(&sets, shaft, channel, vec![source], recording.repairs).map_err(|error| error.in_file(path))
}

/// `60mm=deflection_60.csv`.
fn labelled(pair: &str, length: f64) -> Result<(f64, PathBuf)> {
    let form = || Error::usage("--taps").value(format!("\"{pair}\"")).allowed("DISTANCE=FILE, such as 60mm=tap_60.csv");
    let (distance, path) = pair.split_once('=').ok_or_else(form)?;
    let distance = option("--taps", Dimension::Length, Some(distance))?.ok_or_else(form)?;
    if !(distance > 0.0 && distance <= length) {
        return Err(Error::usage("--taps: a distance off the shaft")
            .value(format!("{distance} m"))
            .allowed(format!("above 0, up to the length {length} m"))
            .remedy("a bare number is in metres; give --length if the shaft is longer"));
    }
    Ok((distance, PathBuf::from(path)))
}

fn report(sets: &[DistanceSet], shaft: Shaft, channel: String, data: Vec<Source>, repairs: Repairs) -> Result<Report> {
    let fit = fit_distance(sets, shaft)?;
    let left_out = leave_one_out(sets, shaft)?;
    let calibration = Calibration { data, channel, distance: Some(fit.model), ..Calibration::default() };
    let mut json = vibrissa::io::calibration::to_json(&calibration);
    let file = pretty(&json);
    json["report"] = json!({
        "free": fit.free, "covariance": fit.covariance, "repairs": repairs_json(repairs),
        "contacts": left_out.iter().map(|l| json!({ "truth": l.truth, "found": l.found })).collect::<Vec<_>>(),
        "leave_one_out": summary_json(&left_out),
    });
    let picture = figure(sets, &fit, &left_out, &calibration.channel);
    Ok(Report {
        text: text(sets, &fit, &left_out, &calibration.channel),
        json,
        files: vec![("cal.json", file), ("calibration.svg", picture)],
    })
}

/// Slopes over distance with the model, and the errors of distances left out.
fn figure(sets: &[DistanceSet], fit: &DistanceFit, left_out: &[LeftOut], channel: &str) -> String {
    let model = &fit.model;
    let (factor, unit) = match model.motion {
        Motion::Turn => (1e-3, format!("{channel}, thousands per s")),
        Motion::Travel => (1e-3, format!("{channel}, per mm")),
    };
    let [lo, hi] = model.fitted;
    let air = 0.15 * (hi - lo);
    let (from, to) = ((lo - air).max(0.05 * model.length), (hi + air).min(model.length));
    let sample = |i: usize| from + (to - from) * i as f64 / 200.0;
    let x_label = "distance from the base (mm)".to_owned();
    let valid = Some([lo * 1e3, hi * 1e3]);
    let slopes = sets.iter().flat_map(|set| &set.samples).map(|&(d, slope)| (d * 1e3, slope.abs() * factor)).collect();
    let curve = (0..=200).map(sample).filter_map(|d| Some((d * 1e3, model.slope(d).ok()? * factor))).collect();
    let errors = left_out.iter().filter_map(|l| Some((l.truth * 1e3, (l.found? - l.truth) * 1e3))).collect();
    let plots = [
        Plot {
            x_label: x_label.clone(),
            y_label: format!("slope of the reading ({unit}); calibrated distances are shaded"),
            points: slopes,
            curve,
            valid,
            ..Plot::default()
        },
        Plot {
            x_label,
            y_label: "error of the distance (mm), by a fit without it".to_owned(),
            points: errors,
            valid,
            span: Some([from * 1e3, to * 1e3]),
            ..Plot::default()
        },
    ];
    let shown = if left_out.is_empty() { 1 } else { 2 };
    let notes = format!(
        "tip ratio {:.3}, EI / k_base {:.2} mm, scatter of a slope {:.2} %",
        model.tip_ratio,
        model.base_compliance * 1e3,
        model.scatter * 100.0
    );
    calibration_figure("Distance from the slope of the reading", &notes, &plots[..shown])
}

/// Mean, root mean square and largest error (m), and how many contacts fitted no distance.
fn summary(left_out: &[LeftOut]) -> Option<([f64; 3], usize)> {
    let errors: Vec<f64> = left_out.iter().filter_map(|l| Some((l.found? - l.truth).abs())).collect();
    let n = errors.len() as f64;
    let mean = errors.iter().sum::<f64>() / n;
    let rms = (errors.iter().map(|e| e * e).sum::<f64>() / n).sqrt();
    let worst = errors.iter().copied().fold(0.0, f64::max);
    (!errors.is_empty()).then_some(([mean, rms, worst], left_out.len() - errors.len()))
}

fn summary_json(left_out: &[LeftOut]) -> serde_json::Value {
    match summary(left_out) {
        Some(([mean, rms, worst], lost)) => {
            json!({ "contacts": left_out.len(), "without_distance": lost, "mean": mean, "rms": rms, "max": worst })
        }
        None => serde_json::Value::Null,
    }
}

fn text(sets: &[DistanceSet], fit: &DistanceFit, left_out: &[LeftOut], channel: &str) -> String {
    let model = &fit.model;
    let (unit, what) = match model.motion {
        Motion::Turn => (format!("{channel} per s"), "taps of a turning base"),
        Motion::Travel => (format!("{channel} per m"), "steps of a travelling base"),
    };
    let contacts: usize = sets.iter().map(|set| set.samples.len()).sum();
    let mut text = format!("distance from {what}: {contacts} contacts at {} distances\n\n", sets.len());
    // Writing into a string cannot fail.
    let _ = writeln!(text, "  gain             {:>12.6e} {unit} m", model.gain);
    let free = |name: &str| if fit.free.contains(&name) { "fitted" } else { "given" };
    let base = if fit.free.contains(&"base_compliance") { "fitted" } else { "clamped" };
    let _ = writeln!(text, "  length           {:>12.2} mm, given", model.length * 1e3);
    let _ = writeln!(text, "  tip ratio        {:>12.4} {}", model.tip_ratio, free("tip_ratio"));
    let _ = writeln!(text, "  EI / k_base      {:>12.3} mm, {base}", model.base_compliance * 1e3);
    let _ = writeln!(text, "  scatter          {:>12.2} % of a slope", model.scatter * 100.0);
    if left_out.is_empty() {
        text.push_str("\ntoo few distances to leave one out\n");
        return text;
    }
    let _ = writeln!(text, "\neach distance by a fit without it   contacts    mean error   RMS error   largest");
    for (index, set) in sets.iter().enumerate() {
        let own: Vec<LeftOut> = left_out.iter().filter(|l| l.set == index).copied().collect();
        let distance = set.samples.iter().map(|s| s.0).sum::<f64>() / set.samples.len() as f64;
        row(&mut text, &format!("{:.2} mm", distance * 1e3), &own);
    }
    row(&mut text, "all", left_out);
    text
}

fn row(text: &mut String, name: &str, left_out: &[LeftOut]) {
    let Some((errors, lost)) = summary(left_out) else {
        let _ = writeln!(text, "  {name:<33} {:>8}    none fits a distance on the shaft", left_out.len());
        return;
    };
    let [mean, rms, worst] = errors.map(|e| e * 1e3);
    let lost = if lost > 0 { format!("   ({lost} fit no distance)") } else { String::new() };
    let _ = writeln!(text, "  {name:<33} {:>8}  {mean:>9.2} mm {rms:>8.2} mm {worst:>6.2} mm{lost}", left_out.len());
}
