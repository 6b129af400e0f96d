//! `vibrissa sensor`: where the chip belongs and what it then tells, and what a sensor head on a port is told.

#[cfg(all(unix, feature = "live"))]
mod head;

use crate::output::{OutputArgs, print, write_all, wrote};
use crate::quantity::option;
use clap::ValueEnum;
use serde_json::json;
use std::path::PathBuf;
use vibrissa::beam::Whisker;
use vibrissa::figure::{Plot, plots_figure};
use vibrissa::io::Dimension;
use vibrissa::sensing::{Chip, Mlx90393, SensingChain, Tle493d};
use vibrissa::tasks::sensor_design::{LARGEST_SHARE, SensorDesign, best_sensor_design, sensor_design};
use vibrissa::world::Robot;
use vibrissa::{Error, Result, read_robot};

/// Design a sensor, and set up a sensor head on its port.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    #[command(subcommand)]
    command: SensorCommand,
}

#[derive(Debug, clap::Subcommand)]
enum SensorCommand {
    Design(DesignArgs),
    #[cfg(all(unix, feature = "live"))]
    Head(head::HeadArgs),
}

/// Where the chip of a sensor belongs, and what it then tells: field, resolution, noise at the tip.
///
/// The magnet is a point dipole at the compliant element, the chip stands below it along the whisker. All numbers are computed, none is
/// measured; a sensor that was built needs `vibrissa calibrate`.
///
/// The best distance is the one with the least noise at which no moment takes more than 80 % of the chip's range.
///
/// With --out DIR: the figure sensor-design.svg, noise and range over the distance.
#[derive(Debug, clap::Args)]
pub(crate) struct DesignArgs {
    /// The magnetometer: mlx90393 at its finest gain, or tle493d
    #[arg(long, value_name = "CHIP", default_value = "mlx90393")]
    chip: ChipName,
    /// The robot file whose first whisker it is [default: the paper's whisker]
    #[arg(long, value_name = "FILE")]
    robot: Option<PathBuf>,
    /// From the magnet's centre to the chip, such as "5 mm" [default: the best distance]
    #[arg(long, value_name = "M")]
    distance: Option<String>,
    /// The least distance that may be the best one: two lengths of the magnet [default: 4 mm]
    #[arg(long, value_name = "M", conflicts_with = "distance")]
    nearest: Option<String>,
    /// The largest moment, such as "20 mNm" [default: 20 mNm]
    #[arg(long, value_name = "NM")]
    largest: Option<String>,
    /// The magnet's dipole moment (A m²) [default: 0.0036, a neodymium disc of 2 mm diameter and 1 mm height]
    #[arg(long, value_name = "AM2")]
    magnet: Option<f64>,
    /// Rotational stiffness of the compliant element (N m/rad) [default: 0.05]
    #[arg(long, value_name = "NM/RAD")]
    stiffness: Option<f64>,
    /// Standard deviation of the chip's flux on each axis (T), beside that of rounding
    #[arg(long, value_name = "T", default_value_t = 0.0)]
    noise: f64,
    #[command(flatten)]
    output: OutputArgs,
}

/// A chip by its name.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum ChipName {
    Mlx90393,
    Tle493d,
}

/// Least distance where the call does not say (m): twice the diameter of the default magnet.
const NEAREST: f64 = 4e-3;
/// Largest moment where the call does not say (N m): the paper's whisker, bent by half of its length.
const LARGEST: f64 = 20e-3;

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<()> {
    match &args.command {
        SensorCommand::Design(args) => design(args),
        #[cfg(all(unix, feature = "live"))]
        SensorCommand::Head(args) => head::run(args),
    }
}

/// Computes where the chip belongs.
fn design(args: &DesignArgs) -> Result<()> {
    let robot = match &args.robot {
        Some(path) => read_robot(path)?,
        None => Robot::default(),
    };
    let whisker = robot.whiskers.first().ok_or_else(|| Error::data("the robot has no whisker"))?.beam;
    let chip = match args.chip {
        ChipName::Mlx90393 => Chip::Mlx90393(Mlx90393::default()),
        ChipName::Tle493d => Chip::Tle493d(Tle493d::default()),
    };
    let mut chain = SensingChain { chip, ..SensingChain::default() };
    for (name, value, place) in
        [("--magnet", args.magnet, &mut chain.magnet_moment[0]), ("--stiffness", args.stiffness, &mut chain.stiffness)]
    {
        let Some(value) = value else { continue };
        if !(value > 0.0 && value.is_finite()) {
            return Err(Error::usage(name).value(value).allowed("above 0"));
        }
        *place = value;
    }
    let largest = option("--largest", Dimension::Moment, args.largest.as_deref())?.unwrap_or(LARGEST);
    let design = match option("--distance", Dimension::Length, args.distance.as_deref())? {
        Some(distance) => sensor_design(&chain, &whisker, distance, largest, args.noise)?,
        None => {
            let nearest = option("--nearest", Dimension::Length, args.nearest.as_deref())?.unwrap_or(NEAREST);
            best_sensor_design(&chain, &whisker, nearest, largest, args.noise)?.ok_or_else(|| {
                Error::data("the field is too strong for the chip at every distance")
                    .remedy("take a weaker magnet, or --chip tle493d")
            })?
        }
    };
    let mut text = if args.output.json { as_json(&design) } else { words(&design, args.noise) } + "\n";
    if let Some(to) = args.output.destination() {
        let figure = figure(&chain, &whisker, &design, largest, args.noise)?;
        let written = write_all(to, &[("sensor-design.svg", figure)])?;
        if !args.output.json {
            text.push_str(&wrote(&written));
        }
    }
    print(&text)
}

/// Distances in the figure (m), and that of the design.
const SHOWN: [f64; 2] = [3e-3, 8e-3];
/// Distances that are drawn.
const DRAWN: i32 = 96;

/// Range and noise over the distance, and the design as a dot.
fn figure(chain: &SensingChain, whisker: &Whisker, design: &SensorDesign, largest: f64, noise: f64) -> Result<String> {
    let [from, to] = [SHOWN[0].min(design.distance), SHOWN[1].max(design.distance)];
    let at =
        |k: i32| sensor_design(chain, whisker, from + (to - from) * f64::from(k) / f64::from(DRAWN), largest, noise);
    let designs: Vec<SensorDesign> = (0..=DRAWN).map(at).collect::<Result<_>>()?;
    let plot = |y_label: &str, of: fn(&SensorDesign) -> f64, level: Option<f64>| {
        let point = |d: &SensorDesign| (1e3 * d.distance, of(d));
        Plot {
            x_label: "from the magnet's centre to the chip (mm); the dot is the design".to_owned(),
            y_label: y_label.to_owned(),
            points: vec![point(design)],
            curve: designs.iter().map(point).collect(),
            levels: level.into_iter().collect(),
            ..Plot::default()
        }
    };
    let plots = [
        plot("noise as a travel of the tip (mm)", |d| 1e3 * d.tip_noise, None),
        plot(
            "share of the chip's range (%), dashed the most for a design",
            |d| 100.0 * d.share,
            Some(100.0 * LARGEST_SHARE),
        ),
        plot("field without contact (mT)", |d| 1e3 * d.rest.iter().map(|b| b * b).sum::<f64>().sqrt(), None),
    ];
    let notes = format!(
        "{:.1} mm: {:.0} % of the range, {:.2} uN m a count, {:.4} mm of noise at the tip",
        1e3 * design.distance,
        100.0 * design.share,
        1e6 * design.resolution[0],
        1e3 * design.tip_noise
    );
    let description = "Noise at the tip, share of the chip's range and field over the distance from magnet to chip.";
    Ok(plots_figure("Where the chip belongs", &notes, description, &plots))
}

fn as_json(design: &SensorDesign) -> String {
    json!({
        "distance": design.distance, "rest": design.rest, "share": design.share, "resolution": design.resolution,
        "noise": design.noise, "tip_noise": design.tip_noise,
    })
    .to_string()
}

/// Of what the noise is, where the chip's own is not told.
fn of_rounding(noise: f64) -> &'static str {
    if noise > 0.0 { "" } else { ", by rounding alone: --noise adds the chip's" }
}

fn words(design: &SensorDesign, noise: f64) -> String {
    let [x, y, z] = design.rest.map(|flux| 1e3 * flux);
    let beyond = if design.share > LARGEST_SHARE { ": too much" } else { "" };
    format!(
        "chip          {:.1} mm from the magnet's centre\n\
         field at rest {x:.3}, {y:.3}, {z:.3} mT along the chip's axes\n\
         range         {:.0} % of the chip's, at the largest moment{beyond}\n\
         resolution    {:.2} uN m a count, {:.2} at the largest moment\n\
         noise         {:.2} uN m, {:.4} mm of travel at the tip{}",
        1e3 * design.distance,
        100.0 * design.share,
        1e6 * design.resolution[0],
        1e6 * design.resolution[1],
        1e6 * design.noise,
        1e3 * design.tip_noise,
        of_rounding(noise),
    )
}
