//! `vibrissa sensor head`: commands to a head over its serial port.

use crate::output::print;
use serde_json::json;
use std::path::PathBuf;
use std::time::Duration;
use vibrissa::{Error, Result};
use vibrissa_live::head::{ChipName, Command, Identity, head_calibration};
use vibrissa_live::source::HeadPort;

/// How long an answer is waited for.
const PATIENCE: Duration = Duration::from_secs(3);

/// Load a calibration into a sensor head, tare it, set its rate, or ask who it is.
///
/// The head is asked over its serial port, which no live run may read at the same time. What it is told it forgets when it is switched off. In
/// this order: --unload, --load, --rate, --tare; then the head says who it is.
#[derive(Debug, clap::Args)]
pub(super) struct HeadArgs {
    /// The serial port, such as /dev/serial/by-id/usb-vibrissa_whisker_sensor_head-if00
    port: PathBuf,
    /// Load this calibration (cal.json): of one axis or of both
    #[arg(long, value_name = "CAL", conflicts_with = "unload")]
    load: Option<PathBuf>,
    /// Forget the calibration: packets have flux alone
    #[arg(long)]
    unload: bool,
    /// The whisker is free: the mean of the next N readings is the flux at rest
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    tare: Option<u16>,
    /// Readings a second
    #[arg(long, value_name = "HZ")]
    rate: Option<u16>,
    /// Speed of the port, where it has one; USB has none
    #[arg(long, value_name = "BAUD", default_value_t = 115_200)]
    baud: u32,
    /// Print the result as JSON instead of words
    #[arg(long)]
    json: bool,
}

/// Tells and asks.
pub(super) fn run(args: &HeadArgs) -> Result<()> {
    // What is wrong with the file is told before the head is touched.
    let load = match &args.load {
        Some(path) => {
            let calibration = vibrissa::read_calibration(path)?;
            Some(head_calibration(&calibration).map_err(|error| error.in_file(path))?)
        }
        None => None,
    };
    let mut head = HeadPort::open(&args.port, args.baud, PATIENCE)?;
    let before = head.identify()?;
    if before.version != vibrissa_live::head::VERSION {
        return Err(Error::data("the head speaks another version")
            .in_file(&args.port)
            .value(before.version)
            .allowed(vibrissa_live::head::VERSION.to_string())
            .remedy("flash it with firmware of this release"));
    }
    let mut done: Vec<String> = Vec::new();
    if args.unload {
        head.tell(&Command::Unload)?;
        done.push("unloaded its calibration".to_owned());
    }
    if let Some(calibration) = load {
        head.tell(&Command::Load(calibration))?;
        done.push(format!("loaded a calibration of {} axes", calibration.axes()));
    }
    if let Some(rate) = args.rate {
        head.tell(&Command::Rate(rate))?;
        done.push(format!("takes {rate} readings a second"));
    }
    if let Some(count) = args.tare {
        head.tell(&Command::Tare(count))?;
        done.push(format!("takes the next {count} readings for the flux at rest"));
    }
    let identity = head.identify()?;
    if args.json { print(&(as_json(&identity, &done) + "\n")) } else { print(&words(&identity, &done)) }
}

fn name(chip: ChipName) -> &'static str {
    match chip {
        ChipName::Mlx90393 => "mlx90393",
        ChipName::Tle493d => "tle493d",
    }
}

fn as_json(identity: &Identity, done: &[String]) -> String {
    json!({
        "chip": name(identity.chip), "rate": identity.rate, "calibrated_axes": identity.calibrated_axes,
        "version": identity.version, "done": done,
    })
    .to_string()
}

fn words(identity: &Identity, done: &[String]) -> String {
    let axes = match identity.calibrated_axes {
        0 => "no calibration: flux alone".to_owned(),
        1 => "calibrated in one plane".to_owned(),
        n => format!("calibrated about {n} axes"),
    };
    let done: String = done.iter().map(|what| format!("done          {what}\n")).collect();
    format!(
        "{done}chip          {}\nrate          {} readings a second\ncalibration   {axes}\n",
        name(identity.chip),
        identity.rate
    )
}
