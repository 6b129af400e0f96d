//! The paper on one page: every figure with content and both tables, beside ours \[routray\].
//!
//! Everything is simulated by this library's own simulator, with the paper's whisker and an arena and sweeps built after
//! its description; no measurement of the paper's sensor is public. Words with numbers in them name the numbers by their
//! keys in braces, so that a page and a file of numbers cannot disagree.
//!
//! | file | the paper's |
//! | --- | --- |
//! | `beam` | large-angle deflection |
//! | `contact_sets` | contact sets of four sensors, fusion of two |
//! | `preimages` | map and strips |
//! | `calibration` | calibration curves |
//! | `filtering` | contact from four virtual sensors; spatial and temporal filtering |
//! | `contact_table` | table of contact points |
//! | `profile` | sweep with slip, profile |
//! | `alignment` | the whisker along a bay |
//! | `paper_method` | deterministic localization as it is written there |
//! | `deterministic` | deterministic localization in four stages |
//! | `possibilistic` | possibilistic localization in two stages |
//! | `localization_table` | table of localization errors, the methods on the same logs |
//! | `orientation` | orientation sensing, announced there |
//! | `errata` | where the paper is wrong or loose |
//! | `report`, `ground` | the shape of the answer; maps and sweeps |

mod alignment;
mod beam;
mod calibration;
mod contact_sets;
pub mod contact_table;
mod deterministic;
mod errata;
mod filtering;
mod ground;
mod localization_table;
mod options;
mod orientation;
mod paper_method;
mod possibilistic;
mod preimages;
mod profile;
mod report;

pub use ground::{ARENA_SVG, OBSTACLE_SVG, SWEEPS, SweepPlan};
pub use options::ReproduceOptions;
pub use report::{Cell, Comparison, Figure, Number, Panel, Reproduction, Section, Table};

use vibrissa::tasks::batch::all_cores;
use vibrissa::{Error, Result};

/// The sections by key, in the order of the page, and what a person at the terminal reads while each is made.
pub const SECTIONS: [(&str, &str); 13] = [
    ("beam", "bending the whisker"),
    ("contact-sets", "contact sets of four sensors"),
    ("preimages", "preimages on the map"),
    ("calibration", "calibrating the simulated sensor"),
    ("filtering", "contact points by filtering"),
    ("contact-table", "the table of contact points"),
    ("profile", "sweeping the obstacle"),
    ("alignment", "aligning the whisker along a bay"),
    ("deterministic", "deterministic localization in four stages"),
    ("possibilistic", "possibilistic localization in two stages"),
    ("localization-table", "the table of localization errors"),
    ("orientation", "localization with a compass"),
    ("errata", "errata"),
];

/// How far the work is: called before each section, and within the long ones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// What is being made.
    pub what: &'static str,
    /// The share of the whole that is done, 0 to 1.
    pub share: f64,
}

/// Makes the sections, all of them or those named in the options, in the order of the page.
///
/// Nothing is read but what is built in; the same options give the same answer, whatever the number of threads.
///
/// # Errors
///
/// Usage: options out of range, or a section that is not there.
pub fn reproduce(options: &ReproduceOptions, observer: &mut dyn FnMut(Progress)) -> Result<Reproduction> {
    options.check()?;
    let known = |key: &String| SECTIONS.iter().any(|(name, _)| name == key);
    if let Some(unknown) = options.only.iter().find(|key| !known(key)) {
        let names: Vec<&str> = SECTIONS.iter().map(|(name, _)| *name).collect();
        return Err(Error::usage("the section").value(unknown).allowed(names.join(", ")));
    }
    let chosen = |key: &str| options.only.is_empty() || options.only.iter().any(|name| name == key);
    let total: f64 = SECTIONS.iter().filter(|(key, _)| chosen(key)).map(|(key, _)| weight(key)).sum();
    let mut done = 0.0;
    let mut sections = Vec::new();
    for (key, what) in SECTIONS.into_iter().filter(|(key, _)| chosen(key)) {
        observer(Progress { what, share: done / total });
        let within = |share: f64| Progress { what, share: (done + share * weight(key)) / total };
        sections.push(section(key, options, &mut |share| observer(within(share)))?);
        done += weight(key);
    }
    observer(Progress { what: "done", share: 1.0 });
    Ok(Reproduction { sections })
}

/// About how long a section takes, relative to the others.
fn weight(key: &str) -> f64 {
    match key {
        "localization-table" => 60.0,
        "contact-table" => 5.0,
        "profile" | "preimages" | "orientation" => 2.0,
        _ => 0.5,
    }
}

fn section(key: &str, options: &ReproduceOptions, observer: &mut dyn FnMut(f64)) -> Result<Section> {
    let threads = options.threads.unwrap_or_else(all_cores);
    match key {
        "beam" => beam::section(),
        "contact-sets" => contact_sets::section(),
        "preimages" => preimages::section(),
        "calibration" => calibration::section(),
        "filtering" => filtering::section(),
        "contact-table" => contact_table::section(options.trials, threads),
        "profile" => profile::section(),
        "alignment" => alignment::section(),
        "deterministic" => deterministic::section(),
        "possibilistic" => possibilistic::section(),
        "localization-table" => localization_table::section(options.seeds, options.sweeps, threads, observer),
        "orientation" => orientation::section(),
        _ => errata::section(),
    }
}
