//! `vibrissa join`: readings and odometry that were recorded apart, as one log.

use crate::output::{print, warn, write_bytes};
use crate::quantity::option;
use serde_json::json;
use std::path::{Path, PathBuf};
use vibrissa::flow::sensor_log::SensorLog;
use vibrissa::io::Dimension;
use vibrissa::io::log::foreign::Format;
use vibrissa::io::log::{read_odometry, to_csv};
use vibrissa::tasks::join::{Delay, Joined, SEARCH, join, read_readings};
use vibrissa::{Error, Result};

/// Join readings and odometry that were recorded apart to one log.
///
/// The delay between the two, and the sensor's rate where its lines have no time, are estimated from the motion: over a short way a
/// reading is a smooth function of the robot's pose. Starts, stops and turns in contact tell the delay, uniform motion does not;
/// its error is told, and a delay that the motion does not tell is refused.
///
/// With --out LOG: a log .csv or .mcap for the other commands, its times on the odometry's clock.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The readings: serial output of the paper's sensor (.txt), columns with a header (.csv), or --format
    readings: PathBuf,
    /// The odometry: t,x,y,theta (.csv), a trajectory (.tum), or a recording that holds it (.mcap)
    odometry: PathBuf,
    /// The format of the readings: serial, serial2, ratatouille, openwhisker, csv [default: by the extension]
    #[arg(long, value_name = "FORMAT")]
    format: Option<Format>,
    /// The whisker whose readings they are [default: the only one]
    #[arg(long, value_name = "NAME", default_value = "", hide_default_value = true)]
    whisker: String,
    /// The first reading's time less that of the first pose, where it is known, such as "120 ms" [default: estimated]
    #[arg(long, value_name = "S", allow_hyphen_values = true)]
    delay: Option<String>,
    /// Look for delays up to this on either side
    #[arg(long, value_name = "S", conflicts_with = "delay",
          help = format!("Look for delays up to this on either side [default: {SEARCH} s]"))]
    search: Option<String>,
    /// Write the log to this file (.csv, .mcap); without it nothing is written
    #[arg(long, value_name = "LOG")]
    out: Option<PathBuf>,
    /// Print the result as JSON instead of words
    #[arg(long)]
    json: bool,
}

/// Longest search (s).
const LONGEST_SEARCH: f64 = 120.0;

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<()> {
    let delay = option("--delay", Dimension::Time, args.delay.as_deref())?;
    let search = option("--search", Dimension::Time, args.search.as_deref())?.unwrap_or(SEARCH);
    if !(search > 0.0 && search <= LONGEST_SEARCH) {
        return Err(Error::usage("--search").value(search).allowed(format!("above 0, up to {LONGEST_SEARCH} s")));
    }
    let readings = read_readings(&args.readings, args.format)?;
    let odometry = read_odometry(&args.odometry)?;
    let joined = join(&readings, &odometry, &args.whisker, delay.map_or(Delay::Estimated(search), Delay::Known))?;
    readings.repairs.words().iter().for_each(|word| warn(word));
    if let Some(path) = &args.out {
        write(path, &joined.log)?;
    }
    if args.json { print(&as_json(&joined)) } else { print(&words(&joined, args.out.as_deref())) }
}

fn write(path: &Path, log: &SensorLog) -> Result<()> {
    let folder = path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let name = path.file_name().and_then(|name| name.to_str());
    let name = name.ok_or_else(|| Error::usage("--out names no file").value(path.display()))?;
    write_bytes(folder, &[(name, &bytes(path, log)?)]).map(|_| ())
}

#[cfg(feature = "mcap")]
fn bytes(path: &Path, log: &SensorLog) -> Result<Vec<u8>> {
    use vibrissa::io::recording::parts::add_readings;
    use vibrissa::io::recording::{clock_origin, clock_warning, shifted_log};
    use vibrissa::io::ros::{BagWriter, Header, Kind, Stamp, encode_odometry};
    if path.extension().is_none_or(|extension| extension != "mcap") {
        return Ok(to_csv(log).into_bytes());
    }
    clock_warning(log).iter().for_each(|warning| warn(warning));
    let shifted = clock_origin(log).map(|origin| shifted_log(log, origin));
    let log = shifted.as_ref().unwrap_or(log);
    let mut bag = BagWriter::default();
    let odom = bag.topic("/odom", Kind::Odometry, false);
    for row in &log.rows {
        let header = Header { stamp: Stamp::from_seconds(row.t), frame: "odom" };
        bag.push(odom, header.stamp, encode_odometry(header, "base_link", row.odom_from_robot));
    }
    add_readings(&mut bag, log);
    bag.finish()
}

#[cfg(not(feature = "mcap"))]
fn bytes(_: &Path, log: &SensorLog) -> Result<Vec<u8>> {
    Ok(to_csv(log).into_bytes())
}

fn words(joined: &Joined, out: Option<&Path>) -> String {
    let mut text = match joined.estimate {
        Some(found) => {
            let mut text = format!(
                "the first reading lies {:.1} ms behind the first pose, +- {:.1} ms\n",
                1e3 * joined.delay,
                1e3 * found.delay_std
            );
            if found.rate_std > 0.0 {
                text.push_str(&format!(
                    "the sensor's second takes {:.4} s of the odometry's, +- {:.4} s\n",
                    found.rate, found.rate_std
                ));
            }
            text.push_str(&format!(
                "  declare what is left in the robot file: delay_error = \"{:.0} ms\"\n",
                3e3 * found.delay_std
            ));
            text
        }
        None => format!("the first reading lies {:.1} ms behind the first pose, as given\n", 1e3 * joined.delay),
    };
    text.push_str(&format!(
        "  rows: {}, {} readings without odometry at their time\n",
        joined.log.rows.len(),
        joined.outside
    ));
    text.push_str(&match out {
        Some(path) => format!("\nWrote {0}\nNext: vibrissa localize {0} --map MAP --robot ROBOT\n", path.display()),
        None => "\nNo file was written; add --out LOG.csv.\n".to_owned(),
    });
    text
}

fn as_json(joined: &Joined) -> String {
    let estimate = joined
        .estimate
        .map(|found| json!({ "delay_std": found.delay_std, "rate": found.rate, "rate_std": found.rate_std }));
    let value = json!({
        "delay": joined.delay, "estimate": estimate, "rows": joined.log.rows.len(), "outside": joined.outside,
    });
    format!("{value:#}\n")
}
