//! Labelled contacts: raw readings to moments, moments to the tip's retreat, constants of the whisker.

use super::{Report, file_name, pretty, repairs_json, say_repairs};
use crate::output::warn;
use serde_json::json;
use std::fmt::Write;
use std::path::Path;
use vibrissa::beam::Whisker;
use vibrissa::figure::{Plot, calibration_figure};
use vibrissa::io::log::foreign::{Format, Recording};
use vibrissa::tasks::calibrate::{Constant, ContactCalibration, Explained, Labelled, calibrate_contacts};
use vibrissa::world::Robot;
use vibrissa::world::calibration::{Calibration, MomentCurve, MomentPlane, TipDeflection, WhiskerConstants};
use vibrissa::{Error, Result};

/// What is fitted beside the curves.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Options of labelled contacts")]
pub(super) struct ContactArgs {
    /// Constants of the whisker to fit, separated by commas: `flexural_rigidity`, `base_compliance`, `tip_ratio` [default: all
    /// as the robot says]
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    free: Vec<String>,
}

impl ContactArgs {
    fn constants(&self) -> Result<Vec<Constant>> {
        let known = Constant::ALL.map(Constant::as_str).join(", ");
        let one = |name: &String| {
            let found = Constant::ALL.into_iter().find(|constant| constant.as_str() == name.trim());
            found.ok_or_else(|| Error::usage("--free").value(format!("\"{name}\"")).allowed(known.clone()))
        };
        self.free.iter().map(one).collect()
    }
}

/// Calibrates from one log of labelled contacts.
pub(super) fn from_contacts(
    log: &Path,
    format: Option<Format>,
    robot: Option<&Robot>,
    args: &ContactArgs,
) -> Result<Report> {
    let free = args.constants()?;
    let recording = Recording::read(log, format.unwrap_or(Format::Csv))?;
    say_repairs(&recording);
    let whisker = robot.and_then(|r| r.whiskers.first()).map_or_else(Whisker::default, |w| w.beam);
    let found = calibrate_contacts(&recording, &file_name(log), &whisker, &free)?;
    let lost = found.out_of_reach();
    if lost > 0 {
        warn(&format!("{}: {lost} contacts are out of the whisker's reach and were left out", log.display()));
    }
    let ContactCalibration { calibration, labelled, explained } = found;
    let mut json = vibrissa::io::calibration::to_json(&calibration);
    let file = pretty(&json);
    json["report"] = json!({ "repairs": repairs_json(recording.repairs), "out_of_reach": lost });
    let plots = plots(&labelled, &explained, &calibration);
    let notes = format!("{} of {} labelled contacts", explained.len(), labelled.contacts.len());
    let figure = calibration_figure(&format!("Calibration from {}", file_name(log)), &notes, &plots);
    Ok(Report {
        text: text(&calibration, explained.len()),
        json,
        files: vec![("cal.json", file), ("calibration.svg", figure)],
    })
}

fn text(calibration: &Calibration, used: usize) -> String {
    let mut text = format!("calibrated from {used} labelled contacts\n");
    calibration.whisker.iter().for_each(|whisker| constants_text(&mut text, whisker));
    calibration.moment.iter().for_each(|curve| curve_text(&mut text, curve));
    calibration.plane.iter().for_each(|plane| plane_text(&mut text, plane));
    calibration.tip_deflection.iter().for_each(|tip| tip_text(&mut text, tip));
    text
}

// Writing into a string cannot fail, so the results of `writeln!` are dropped throughout.

fn constants_text(text: &mut String, whisker: &WhiskerConstants) {
    let _ = writeln!(text, "\nwhisker, fitted to {} contacts (residual {:.3e})", whisker.samples, whisker.residual_rms);
    for (index, name) in whisker.free.iter().enumerate() {
        let std = whisker.covariance.get(index).and_then(|row| row.get(index)).map_or(f64::NAN, |v| v.sqrt());
        let _ = match name.as_str() {
            "flexural_rigidity" => {
                writeln!(text, "  flexural rigidity  {:.5e} ± {std:.1e} N m²", whisker.flexural_rigidity)
            }
            "base_compliance" => {
                let compliance = 1.0 / whisker.base_stiffness;
                writeln!(
                    text,
                    "  base compliance    {compliance:.5e} ± {std:.1e} rad/(N m): {:.5e} N m/rad",
                    whisker.base_stiffness
                )
            }
            _ => writeln!(text, "  tip ratio          {:.5} ± {std:.1e}", whisker.tip_ratio),
        };
    }
}

fn curve_text(text: &mut String, curve: &MomentCurve) {
    let [lo, hi] = curve.valid();
    let _ = writeln!(
        text,
        "\nmoment from {}: polynomial of degree {}",
        curve.inputs.join(","),
        curve.coefficients.len() - 1
    );
    let (factor, unit) = signal_unit(curve);
    let _ = writeln!(
        text,
        "  valid              {:.2} to {:.2} {unit} along the direction of contact",
        lo * factor,
        hi * factor
    );
    let _ = writeln!(text, "  residual           {:.4} mN m RMS", curve.residual_rms * 1e3);
    let _ = writeln!(text, "  hysteresis         {:.4} mN m", curve.hysteresis * 1e3);
    let _ = writeln!(
        text,
        "  bound              {:.4} mN m, largest error of {} contacts left out in turn",
        curve.bound * 1e3,
        curve.samples
    );
}

fn plane_text(text: &mut String, plane: &MomentPlane) {
    let _ = writeln!(text, "\nmoments about both transverse axes from {}", plane.inputs.join(","));
    let degree = degree(plane);
    let _ = writeln!(text, "  surfaces           degree {degree}, cross-talk undone");
    for (name, k) in [("in the plane x-y", 0), ("across it", 1)] {
        let ([middle, half], rms, bound) = (plane.ranges[k], plane.residual_rms[k], plane.bound[k]);
        let [lo, hi] = [1e3 * (middle - half), 1e3 * (middle + half)];
        let _ = writeln!(
            text,
            "  {name:<17}  {lo:.2} to {hi:.2} mN m, residual {:.4} mN m RMS, bound {:.4} mN m",
            rms * 1e3,
            bound * 1e3
        );
    }
    let _ = writeln!(text, "  hysteresis         {:.4} mN m", plane.hysteresis * 1e3);
    let _ = writeln!(text, "  the bounds are the largest errors of {} contacts left out in turn", plane.samples);
}

/// The degree of the surfaces: the highest whose coefficients are not all zero.
fn degree(plane: &MomentPlane) -> usize {
    let some = |from: usize| plane.coefficients.iter().any(|c| c[from..].iter().any(|c| *c != 0.0));
    1 + usize::from(some(3)) + usize::from(some(6))
}

fn tip_text(text: &mut String, tip: &TipDeflection) {
    let _ = writeln!(text, "\ntip's retreat delta_x from the moment");
    let at = tip.at(tip.largest_moment).unwrap_or(f64::NAN);
    let _ = writeln!(
        text,
        "  valid              up to {:.4} mN m, where it is {:.3} mm",
        tip.largest_moment * 1e3,
        at * 1e3
    );
    let _ = writeln!(text, "  residual           {:.4} mm RMS", tip.residual_rms * 1e3);
}

/// How a signal is shown: flux in µT, counts as they are.
fn signal_unit(curve: &MomentCurve) -> (f64, &'static str) {
    if curve.inputs.iter().any(|name| name.starts_with('b')) { (1e6, "µT") } else { (1.0, "counts") }
}

fn plots(labelled: &Labelled, explained: &[Explained], calibration: &Calibration) -> Vec<Plot> {
    let mut plots = Vec::new();
    if let Some(curve) = &calibration.moment {
        let (factor, unit) = signal_unit(curve);
        let signal = |e: &Explained| curve.signal(&labelled.readings[e.row]);
        let [lo, hi] = curve.valid();
        let x_label = format!("reading along the direction of contact ({unit})");
        let valid = Some([lo * factor, hi * factor]);
        let sample = |i: usize| lo + (hi - lo) * i as f64 / 200.0;
        plots.push(Plot {
            x_label: x_label.clone(),
            y_label: "moment about the base (mN m); the valid range is shaded".to_owned(),
            points: explained.iter().map(|e| (signal(e) * factor, e.moment * 1e3)).collect(),
            curve: (0..=200).map(sample).map(|s| (s * factor, curve.at(s) * 1e3)).collect(),
            valid,
            ..Plot::default()
        });
        plots.push(Plot {
            x_label,
            y_label: "residual (mN m) and bound (dashed)".to_owned(),
            points: explained.iter().map(|e| (signal(e) * factor, (e.moment - curve.at(signal(e))) * 1e3)).collect(),
            curve: Vec::new(),
            valid,
            levels: vec![curve.bound * 1e3, -curve.bound * 1e3],
            span: None,
        });
    }
    if let Some(plane) = &calibration.plane {
        plane_plots(&mut plots, labelled, explained, plane);
    }
    if let Some(tip) = &calibration.tip_deflection {
        let most = tip.largest_moment;
        let both = (-100..=100).map(|i| f64::from(i) * 0.01 * most);
        plots.push(Plot {
            x_label: "moment about the base (mN m)".to_owned(),
            y_label: "retreat of the tip, delta_x (mm)".to_owned(),
            points: explained.iter().map(|e| (e.size() * sign(e) * 1e3, e.retreat * 1e3)).collect(),
            curve: both.filter_map(|m| Some((m * 1e3, tip.at(m)? * 1e3))).collect(),
            ..Plot::default()
        });
    }
    plots
}

/// The sign of the moment in the plane, for contacts in the plane; sizes have none.
fn sign(e: &Explained) -> f64 {
    if e.across == 0.0 { e.moment.signum() } else { 1.0 }
}

/// Each moment found over the one labelled, and below it what is left over.
fn plane_plots(plots: &mut Vec<Plot>, labelled: &Labelled, explained: &[Explained], plane: &MomentPlane) {
    let found = |e: &Explained| plane.at(plane.signals(&labelled.readings[e.row]));
    for (k, words) in ["in the whisker's plane x-y", "across it"].into_iter().enumerate() {
        let truth = |e: &Explained| [e.moment, e.across][k];
        let most = explained.iter().map(|e| truth(e).abs()).fold(0.0, f64::max) * 1e3;
        plots.push(Plot {
            x_label: format!("labelled moment {words} (mN m)"),
            y_label: "moment of the readings (mN m)".to_owned(),
            points: explained.iter().map(|e| (truth(e) * 1e3, found(e)[k] * 1e3)).collect(),
            curve: vec![(-most, -most), (most, most)],
            ..Plot::default()
        });
        plots.push(Plot {
            x_label: format!("labelled moment {words} (mN m)"),
            y_label: "residual (mN m) and bound (dashed)".to_owned(),
            points: explained.iter().map(|e| (truth(e) * 1e3, (truth(e) - found(e)[k]) * 1e3)).collect(),
            levels: vec![plane.bound[k] * 1e3, -plane.bound[k] * 1e3],
            ..Plot::default()
        });
    }
}
