//! `vibrissa preimage`: which robot states explain readings.

use super::localize::outlines;
use super::readings::{ReadingArgs, WhiskerReadings, words};
use crate::output::{OutputArgs, print, warn, write_all, wrote};
use crate::quantity::of_option as quantity;
use clap::ValueEnum;
use core::f64::consts::TAU;
use serde_json::json;
use std::fmt::Write;
use std::path::PathBuf;
use vibrissa::config::defaults;
use vibrissa::figure::{PreimageFigure, preimage_figure};
use vibrissa::flow::contact_set::{ContactRegion, Parts};
use vibrissa::flow::preimage::{Construction, PreimageOptions, ReadingPreimage, fused_preimage, reading_preimage};
use vibrissa::io::Dimension;
use vibrissa::world::Map;
use vibrissa::{Error, Result};

/// Tell which robot states explain a reading of a virtual sensor, or several at once, on a map.
///
/// The heading is unknown: a state counts when some contact that explains the readings, seen from there, lies on the
/// boundary. The set is covered by cells of places and headings, never less than all.
///
/// With --out DIR: preimage.csv (boxes of states) and the figure preimage.svg.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The map (.geojson, .svg, .dxf, .yaml, .mcap)
    #[arg(long, value_name = "MAP")]
    map: PathBuf,
    #[command(flatten)]
    readings: ReadingArgs,
    /// Which states count: `alignment` lays the whisker against the boundary, `distance` takes every heading
    #[arg(long, value_enum, default_value_t)]
    construction: Word,
    /// Which parts of the whisker may touch: its side, its tip (pushed along the wall's normal) or all
    #[arg(long, value_enum, default_value_t)]
    contacts: PartsWord,
    /// Keep states whose whisker or base is inside something solid, as the paper does
    #[arg(long)]
    ignore_collisions: bool,
    /// Side of the cells of places (m)
    #[arg(long, value_name = "LENGTH", default_value = format!("{} mm", 1e3 * defaults::PREIMAGE_CELL))]
    cell: String,
    /// Width of the cells of headings (rad)
    #[arg(long, value_name = "ANGLE", default_value = format!("{} deg", 360.0 / defaults::PREIMAGE_HEADINGS as f64))]
    heading_step: String,
    /// Show the slice at this heading in the figure, too (rad)
    #[arg(long, value_name = "ANGLE", allow_hyphen_values = true)]
    heading: Option<String>,
    #[command(flatten)]
    output: OutputArgs,
}

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum Word {
    #[default]
    Alignment,
    Distance,
}

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum PartsWord {
    Side,
    Tip,
    #[default]
    All,
}

impl PartsWord {
    fn parts(self) -> Parts {
        match self {
            Self::Side => Parts::Side,
            Self::Tip => Parts::Tip,
            Self::All => Parts::All,
        }
    }
}

impl Args {
    fn options(&self) -> Result<PreimageOptions> {
        let step = quantity("--heading-step", &self.heading_step, Dimension::Angle)?;
        if !(step > 0.0 && step.is_finite()) {
            return Err(Error::usage("--heading-step").value(&self.heading_step).allowed("above 0 rad"));
        }
        let construction = match self.construction {
            Word::Alignment => Construction::Alignment,
            Word::Distance => Construction::Distance,
        };
        let options = PreimageOptions {
            cell: quantity("--cell", &self.cell, Dimension::Length)?,
            headings: (TAU / step).round().clamp(0.0, 1e6) as usize,
            construction,
            contacts: self.contacts.parts(),
            collision_free: !self.ignore_collisions,
        };
        options.check()?;
        Ok(options)
    }
}

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<()> {
    let (options, whiskers) = (args.options()?, args.readings.read()?);
    let heading = args.heading.as_deref().map(|text| quantity("--heading", text, Dimension::Angle)).transpose()?;
    let map = vibrissa::read_map(&args.map)?;
    map.warnings.iter().for_each(|warning| warn(warning));
    let robot = args.readings.robot()?;
    robot.require_level("a preimage")?;
    vibrissa::tasks::doubts(None, &robot, Some(&map)).iter().for_each(|warning| warn(warning));
    let found = solve(&map, &whiskers, &options)?;
    if found.states.is_empty() {
        warn("no state explains the readings: they contradict each other, the whisker's limits or the map");
    }
    let title = whiskers.iter().flat_map(|w| &w.readings).map(words).collect::<Vec<_>>().join(", ");
    let mut written = Vec::new();
    if let Some(to) = args.output.destination() {
        let figure = PreimageFigure {
            title: format!("Robot states that explain {title}"),
            map: &outlines(&map),
            states: &found.states,
            heading,
        };
        written = write_all(to, &[("preimage.csv", boxes(&found)), ("preimage.svg", preimage_figure(&figure))])?;
    }
    print(&if args.output.json { as_json(&found, &options) } else { text(&found, &title, &options) + &wrote(&written) })
}

/// The states that explain the readings of all whiskers.
fn solve(map: &Map, whiskers: &[WhiskerReadings], options: &PreimageOptions) -> Result<ReadingPreimage> {
    if let [only] = whiskers {
        return reading_preimage(map, &only.model, only.robot_from_whisker, &only.readings, options);
    }
    let region = |w: &WhiskerReadings| {
        let reach = w.model.length() + w.robot_from_whisker.position().norm();
        ContactRegion::of_parts(&w.model, &w.readings, options.contacts, &options.resolution(reach))
    };
    let regions: Result<Vec<_>> = whiskers.iter().map(|w| Ok((region(w)?, w.robot_from_whisker))).collect();
    fused_preimage(map, &regions?, options)
}

fn text(found: &ReadingPreimage, title: &str, options: &PreimageOptions) -> String {
    let states = &found.states;
    format!(
        "robot states that explain {title}\n\
         places    {:.2} to {:.2} cm² (sampled, covered)\n\
         volume    {:.3} cm² rad, at most\n\
         grid      {} mm, {:.3} deg; true states are up to {:.2} mm from sampled ones\n",
        found.sampled_area * 1e4,
        states.area() * 1e4,
        states.volume() * 1e4,
        options.cell * 1e3,
        360.0 / options.headings as f64,
        found.deviation * 1e3
    )
}

fn as_json(found: &ReadingPreimage, options: &PreimageOptions) -> String {
    let value = json!({
        "empty": found.states.is_empty(),
        "area": found.states.area(),
        "sampled_area": found.sampled_area,
        "volume": found.states.volume(),
        "deviation": found.deviation,
        "cell": options.cell,
        "headings": options.headings,
    });
    format!("{value:#}\n")
}

/// Boxes of states (m, m, rad).
fn boxes(found: &ReadingPreimage) -> String {
    let mut text = String::from("x_min,x_max,y_min,y_max,theta_min,theta_max\n");
    for state in found.states.boxes() {
        let _ = writeln!(text, "{}", state.map(|side| side.to_string()).join(","));
    }
    text
}
