//! `vibrissa sensor head`: commands to a head over its serial port, and what it reads.

use crate::output::print;
use serde_json::json;
use std::path::PathBuf;
use std::time::Duration;
use vibrissa::{Error, Result};
use vibrissa_live::head::{ChipName, Command, Identity, Reading, State, head_calibration};
use vibrissa_live::source::HeadPort;

/// How long an answer is waited for.
const PATIENCE: Duration = Duration::from_secs(3);

/// Load a calibration into a sensor head, tare it, set its rate, ask who it is, or look what it reads.
///
/// The head is asked over its serial port, which no live run may read at the same time. What it is told it forgets when it is switched off. In
/// this order: --unload, --load, --rate, --tare; then the head says who it is. With --read N its flux is averaged over N readings, as for a row
/// of contacts to calibrate from; the scatter is what `sensor design` takes as --noise.
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
    /// Read N readings: mean and scatter of what the chip reads
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(2..))]
    read: Option<u16>,
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
    let mean = match args.read {
        Some(count) => Some(Averages::of(&head.readings(usize::from(count))?)),
        None => None,
    };
    if args.json {
        print(&(as_json(&identity, &done, mean.as_ref()) + "\n"))
    } else {
        print(&words(&identity, &done, mean.as_ref()))
    }
}

/// What some readings on end have in common.
#[derive(Clone, Debug)]
struct Averages {
    count: usize,
    /// Numbers that are missing between the first and the last.
    lost: u32,
    saturated: usize,
    /// Mean and standard deviation of the flux (T) along the chip's axes.
    flux: [(f64, f64); 3],
    /// Means (N m), where all of them have one.
    moment: Option<f64>,
    across: Option<f64>,
}

impl Averages {
    fn of(readings: &[Reading]) -> Self {
        let all = |of: fn(&Reading) -> Option<f64>| -> Option<f64> {
            let values: Option<Vec<f64>> = readings.iter().map(of).collect();
            Some(mean_and_deviation(&values?).0)
        };
        let first_and_last = readings.first().zip(readings.last());
        let span = first_and_last.map_or(0, |(first, last)| last.number.wrapping_sub(first.number) + 1);
        let axis = |k: usize| {
            let values: Vec<f64> = readings.iter().map(|reading| f64::from(reading.flux[k])).collect();
            mean_and_deviation(&values)
        };
        Self {
            count: readings.len(),
            lost: span.saturating_sub(readings.len() as u32),
            saturated: readings.iter().filter(|reading| reading.state.has(State::SATURATED)).count(),
            flux: [0, 1, 2].map(axis),
            moment: all(|reading| reading.moment),
            across: all(|reading| reading.across),
        }
    }

    fn as_json(&self) -> serde_json::Value {
        json!({
            "count": self.count, "lost": self.lost, "saturated": self.saturated,
            "flux": self.flux.map(|axis| axis.0), "flux_deviation": self.flux.map(|axis| axis.1),
            "moment": self.moment, "across": self.across,
        })
    }

    fn words(&self) -> String {
        let mut text = format!("readings      {}, {} lost between them", self.count, self.lost);
        if self.saturated > 0 {
            text += &format!("; {} at the end of the chip's range: the magnet is too near", self.saturated);
        }
        text.push('\n');
        for (name, (mean, deviation)) in ["bx", "by", "bz"].into_iter().zip(self.flux) {
            text += &format!("{name}            {:.4} mT, scatter {:.4} mT\n", 1e3 * mean, 1e3 * deviation);
        }
        let [x, y, z] = self.flux.map(|axis| axis.0);
        text += &format!("bx,by,bz      {x:.8},{y:.8},{z:.8}\n");
        for (name, moment) in [("moment", self.moment), ("across", self.across)] {
            text += &moment.map_or_else(String::new, |moment| format!("{name}        {:.4} mN m\n", 1e3 * moment));
        }
        text
    }
}

/// Mean and standard deviation of two values or more.
fn mean_and_deviation(values: &[f64]) -> (f64, f64) {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    (mean, (squares / (count - 1.0)).sqrt())
}

fn name(chip: ChipName) -> &'static str {
    match chip {
        ChipName::Mlx90393 => "mlx90393",
        ChipName::Tle493d => "tle493d",
    }
}

fn as_json(identity: &Identity, done: &[String], mean: Option<&Averages>) -> String {
    json!({
        "chip": name(identity.chip), "rate": identity.rate, "calibrated_axes": identity.calibrated_axes,
        "version": identity.version, "done": done, "readings": mean.map(Averages::as_json),
    })
    .to_string()
}

fn words(identity: &Identity, done: &[String], mean: Option<&Averages>) -> String {
    let axes = match identity.calibrated_axes {
        0 => "no calibration: flux alone".to_owned(),
        1 => "calibrated in one plane".to_owned(),
        n => format!("calibrated about {n} axes"),
    };
    let done: String = done.iter().map(|what| format!("done          {what}\n")).collect();
    format!(
        "{done}chip          {}\nrate          {} readings a second\ncalibration   {axes}\n{}",
        name(identity.chip),
        identity.rate,
        mean.map(Averages::words).unwrap_or_default()
    )
}
