//! `vibrissa beam`: one loaded whisker, or a file full of them.

mod batch;
mod figure;
mod input;
mod single;

use crate::output::OutputArgs;
use crate::output::{print, warn, write_all, wrote};
use clap::Subcommand;
use input::{Given, Known};
use std::path::PathBuf;
use vibrissa::beam::{Load, Whisker};
use vibrissa::config::defaults::{DIAMETER, STRAIN_LIMIT};
use vibrissa::io::Dimension;
use vibrissa::world::Robot;
use vibrissa::{Error, Result};

/// Bend a whisker: from a force, a contact point or a moment to every equilibrium.
///
/// Numbers are SI (N, m, N m, rad) or carry their unit ("75 mm", "17 mN m", "10 deg"). The whisker's base is at the origin, the undeflected whisker points along +x, and a push
/// towards +y is positive. Each equilibrium without an inflection between base and contact is one row.
///
/// With --out DIR: beam.csv (the shapes, or the solved batch) and, for one whisker, the figure beam.svg.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    #[command(subcommand)]
    mode: Mode,
}

#[derive(Debug, Subcommand)]
enum Mode {
    /// The force and where it acts are known
    Force(ForceArgs),
    /// The contact point is known
    Point(PointArgs),
    /// The moment about the base and the arc length to the contact are known
    Moment(MomentArgs),
}

#[derive(Debug, clap::Args)]
struct ForceArgs {
    /// Force, negative towards -y (N)
    #[arg(long, allow_hyphen_values = true, required_unless_present = "batch")]
    force: Option<String>,
    /// Arc length from the base to the contact (m)
    #[arg(long, allow_hyphen_values = true, required_unless_present = "batch")]
    s_a: Option<String>,
    #[command(flatten)]
    common: Common,
}

#[derive(Debug, clap::Args)]
struct PointArgs {
    /// Contact point, along the undeflected whisker (m)
    #[arg(long, allow_hyphen_values = true, required_unless_present = "batch")]
    x: Option<String>,
    /// Contact point, across the undeflected whisker (m)
    #[arg(long, allow_hyphen_values = true, required_unless_present = "batch")]
    y: Option<String>,
    /// The point is where the tip is held: solves for the force and its direction, least energy first
    #[arg(long, conflicts_with = "load")]
    tip: bool,
    #[command(flatten)]
    common: Common,
}

#[derive(Debug, clap::Args)]
struct MomentArgs {
    /// Moment about the base, negative for a push towards -y (N m)
    #[arg(long, allow_hyphen_values = true, required_unless_present = "batch")]
    moment: Option<String>,
    /// Arc length from the base to the contact (m)
    #[arg(long, allow_hyphen_values = true, required_unless_present = "batch")]
    s_a: Option<String>,
    #[command(flatten)]
    common: Common,
}

#[derive(Debug, clap::Args)]
struct Common {
    /// Direction of the force: `normal` to the whisker, `vertical` (across the undeflected whisker), `tilted:RAD` from the
    /// whisker's normal, `directed:RAD` from the undeflected whisker
    #[arg(long, default_value = "normal", value_parser = input::parse_load, allow_hyphen_values = true)]
    load: Load,
    /// The robot whose first whisker is bent (.toml) [default: the paper's whisker]
    #[arg(long, value_name = "ROBOT")]
    robot: Option<PathBuf>,
    /// Solve every row of a table with any of the columns `case,load,beta,r_tip,kappa0,k_base,EI,L,s_a,F` (or `x,y`;
    /// or `M0`; `kappa1`, `kappa2`, … for a curvature that changes along the whisker); what a row lacks comes from the
    /// options and the robot. Rows that make no sense are warned of; when no row does, nothing is written
    #[arg(long, value_name = "FILE")]
    batch: Option<PathBuf>,
    #[arg(
        long,
        value_name = "LENGTH",
        help = format!(
            "Diameter at the base, for the strain of the surface (m) [default: the robot's; the paper's {:.2} mm, for a whisker \
             of its rigidity]",
            1e3 * DIAMETER
        )
    )]
    diameter: Option<String>,
    #[arg(
        long,
        value_name = "RATIO",
        help = format!(
            "Strain beyond which the whisker would stay bent, for a warning [default: the robot's, or {STRAIN_LIMIT}, Nitinol's]"
        )
    )]
    strain_limit: Option<String>,
    #[command(flatten)]
    output: OutputArgs,
}

/// Rows of a batch that are warned of one by one.
const WARNED: usize = 20;

/// What the command has to say and to write.
#[derive(Debug, Default)]
struct Report {
    /// For standard output.
    text: String,
    /// For standard error, one each.
    warnings: Vec<String>,
    /// Result files by name, for the folder of `--out`.
    files: Vec<(&'static str, String)>,
}

impl Args {
    fn common(&self) -> &Common {
        match &self.mode {
            Mode::Force(args) => &args.common,
            Mode::Point(args) => &args.common,
            Mode::Moment(args) => &args.common,
        }
    }

    /// What is known according to the options alone.
    fn known(&self) -> Result<Known> {
        let mut known = Known { load: self.common().load, ..Known::default() };
        match &self.mode {
            Mode::Force(args) => {
                known.force = input::option("--force", Dimension::Force, args.force.as_deref())?;
                known.s_a = input::option("--s-a", Dimension::Length, args.s_a.as_deref())?;
            }
            Mode::Point(args) => {
                known.x = input::option("--x", Dimension::Length, args.x.as_deref())?;
                known.y = input::option("--y", Dimension::Length, args.y.as_deref())?;
            }
            Mode::Moment(args) => {
                known.moment = input::option("--moment", Dimension::Moment, args.moment.as_deref())?;
                known.s_a = input::option("--s-a", Dimension::Length, args.s_a.as_deref())?;
            }
        }
        Ok(known)
    }

    /// The robot's whisker with the wire and the limit that the options name.
    fn whisker(&self, robot: &Robot) -> Result<Whisker> {
        let Some(mounted) = robot.whiskers.first() else {
            return Err(Error::data("the robot has no whisker").remedy("add a [[whisker]] to the robot file"));
        };
        let positive = |name: &str, dimension: Dimension, text: Option<&str>| {
            let value = input::option(name, dimension, text)?;
            match value {
                Some(value) if value.is_nan() || value <= 0.0 => {
                    Err(Error::usage(name).value(value).allowed("above 0"))
                }
                _ => Ok(value),
            }
        };
        let (mut whisker, common) = (mounted.beam, self.common());
        if let Some(limit) = positive("--strain-limit", Dimension::Ratio, common.strain_limit.as_deref())? {
            whisker.strain_limit = limit;
        }
        if let Some(diameter) = positive("--diameter", Dimension::Length, common.diameter.as_deref())? {
            if !whisker.stretches.as_slice().is_empty() {
                return Err(Error::usage("--diameter")
                    .value(diameter)
                    .allowed("a whisker of one wire")
                    .remedy("give the diameter of each segment in the robot file"));
            }
            whisker.diameter = Some(diameter);
        }
        Ok(whisker)
    }

    fn given(&self) -> Given {
        match &self.mode {
            Mode::Force(_) => Given::Force,
            Mode::Point(args) if args.tip => Given::Tip,
            Mode::Point(_) => Given::Point,
            Mode::Moment(_) => Given::Moment,
        }
    }
}

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<()> {
    let common = args.common();
    let robot = common.robot.as_deref().map_or_else(|| Ok(Robot::default()), vibrissa::read_robot)?;
    let report = report(args, &robot)?;
    report.warnings.iter().take(WARNED).for_each(|warning| warn(warning));
    if report.warnings.len() > WARNED {
        warn(&format!("and {} more rows like these", report.warnings.len() - WARNED));
    }
    let mut text = report.text;
    if let Some(to) = common.output.destination() {
        let written = write_all(to, &report.files)?;
        if !common.output.json {
            text.push_str(&wrote(&written));
        }
    }
    print(&text)
}

/// Solves what was asked for; reads the batch file, writes nothing.
fn report(args: &Args, robot: &Robot) -> Result<Report> {
    let whisker = args.whisker(robot)?;
    let (known, given, common) = (args.known()?, args.given(), args.common());
    let output = &common.output;
    match &common.batch {
        Some(file) => batch::report(file, given, &known, &whisker, output.json, output.out.is_some()),
        None => single::report(given, &known, &whisker, output.json),
    }
}
