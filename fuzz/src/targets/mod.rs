//! What is fed: a table with one row for each reader and each piece of geometry.

mod abi;
mod beam;
mod c;
mod corridor;
mod estimators;
mod geometry;
mod live;
mod readers;
mod ros;
mod sets;
mod world;

use crate::random::Random;
use std::hash::{DefaultHasher, Hash, Hasher};
use vibrissa::error::is_steering;

/// What one input came to: read or refused, and a mark that is new when the code did something new.
pub(crate) struct Outcome {
    /// Whether it was read.
    pub(crate) read: bool,
    /// Inputs with a mark that was not seen before are damaged further.
    pub(crate) mark: u64,
}

/// What a target says of one input; the error tells which promise is broken.
pub(crate) type Verdict = Result<Outcome, String>;

/// Where a target's inputs come from.
#[derive(Clone, Copy)]
pub(crate) enum Source {
    /// The files of these folders of the repository, damaged; the words are the format's own.
    Damaged(&'static [&'static str], &'static [&'static str]),
    /// Drawn from nothing.
    Drawn(fn(&mut Random) -> Vec<u8>),
    /// Drawn from nothing, and what did something new damaged; the words are the format's own.
    Grown(fn(&mut Random) -> Vec<u8>, &'static [&'static str]),
}

/// One thing to feed.
pub(crate) struct Target {
    pub(crate) name: &'static str,
    pub(crate) source: Source,
    pub(crate) check: fn(&[u8]) -> Verdict,
}

/// Every target; a new reader is a new row, with its seeds in a folder.
pub(crate) const ALL: &[Target] = &[
    Target { name: "log", source: Source::Damaged(&["fuzz/seeds/log"], readers::LOG_WORDS), check: readers::log },
    Target {
        name: "foreign",
        source: Source::Damaged(&["fuzz/seeds/foreign"], readers::FOREIGN_WORDS),
        check: readers::foreign,
    },
    Target {
        name: "geojson",
        source: Source::Damaged(&["fuzz/seeds/geojson"], readers::GEOJSON_WORDS),
        check: readers::geojson,
    },
    Target {
        name: "svg",
        source: Source::Damaged(&["fuzz/seeds/svg", "scenarios/maps", "crates/vibrissa/data"], readers::SVG_WORDS),
        check: readers::svg,
    },
    Target { name: "dxf", source: Source::Damaged(&["fuzz/seeds/dxf"], readers::DXF_WORDS), check: readers::dxf },
    Target {
        name: "map_server",
        source: Source::Damaged(&["fuzz/seeds/map_server"], ros::YAML_WORDS),
        check: ros::map_server,
    },
    Target { name: "grid", source: Source::Drawn(ros::draw_grid), check: ros::grid },
    Target { name: "mcap", source: Source::Damaged(&["fuzz/seeds/mcap"], ros::MCAP_WORDS), check: ros::mcap },
    Target {
        name: "robot",
        source: Source::Damaged(&["fuzz/seeds/robot"], readers::TOML_WORDS),
        check: readers::robot,
    },
    Target { name: "scenario", source: Source::Damaged(&["scenarios"], readers::TOML_WORDS), check: readers::scenario },
    Target {
        name: "calibration",
        source: Source::Damaged(&["fuzz/seeds/calibration"], &[]),
        check: readers::calibration,
    },
    Target { name: "tum", source: Source::Damaged(&["fuzz/seeds/tum"], &["# ", "nan", "-0"]), check: readers::tum },
    Target {
        name: "quantity",
        source: Source::Damaged(&["fuzz/seeds/quantity"], readers::UNIT_WORDS),
        check: readers::quantity,
    },
    Target {
        name: "live",
        source: Source::Damaged(&["fuzz/seeds/foreign"], readers::FOREIGN_WORDS),
        check: live::lines,
    },
    Target { name: "setup", source: Source::Damaged(&["fuzz/seeds/setup"], live::SETUP_WORDS), check: live::setup },
    Target {
        name: "pipeline",
        source: Source::Damaged(&["fuzz/seeds/pipeline"], live::SETUP_WORDS),
        check: live::pipeline,
    },
    Target { name: "command", source: Source::Grown(live::draw_commands, &[]), check: live::commands },
    Target { name: "journal", source: Source::Damaged(&["fuzz/seeds/journal"], ros::MCAP_WORDS), check: live::journal },
    Target { name: "abi", source: Source::Damaged(&["fuzz/seeds/abi"], abi::WORDS), check: abi::calls },
    Target { name: "outline", source: Source::Drawn(geometry::draw_points), check: geometry::outline },
    Target { name: "edges", source: Source::Drawn(geometry::draw_points), check: geometry::edges },
    Target { name: "curve", source: Source::Drawn(geometry::draw_points), check: geometry::curve },
    Target { name: "whisker", source: Source::Drawn(beam::draw), check: beam::modes },
    Target { name: "rod", source: Source::Drawn(beam::draw_rod), check: beam::rods },
    Target { name: "c", source: Source::Grown(c::draw, c::WORDS), check: c::calls },
    Target { name: "contact_set", source: Source::Grown(sets::draw, sets::WORDS), check: sets::contact_sets },
    on_worlds("world_deterministic", estimators::deterministic),
    on_worlds("world_possibilistic", estimators::possibilistic),
    on_worlds("world_probabilistic", estimators::probabilistic),
    on_worlds("world_contact", sets::contact),
    on_worlds("world_profile", sets::outline),
    on_logs("localize", corridor::deterministic),
    on_logs("possibilistic", corridor::possibilistic),
    on_logs("probabilistic", corridor::probabilistic),
    on_logs("contact", corridor::contact),
    on_logs("profile", corridor::outline),
];

impl Target {
    /// Whether a single try may take seconds: those of whole worlds, see [`on_worlds`].
    pub(crate) fn takes_seconds(&self) -> bool {
        self.name.starts_with("world_")
    }
}

/// A target that works on damaged logs.
const fn on_logs(name: &'static str, check: fn(&[u8]) -> Verdict) -> Target {
    Target { name, source: Source::Damaged(&["fuzz/seeds/log"], readers::LOG_WORDS), check }
}

/// A target that works on small worlds: robot, map, options and rows.
const fn on_worlds(name: &'static str, check: fn(&[u8]) -> Verdict) -> Target {
    Target { name, source: Source::Grown(world::draw, world::WORDS), check }
}

/// Longest message (bytes): four parts of six hundred characters and a file's name, in the longest script.
const LONGEST_MESSAGE: usize = 8192;

/// The outcome of a reader that refused: its message must help, and must neither flood nor steer the terminal.
fn refused(error: &vibrissa::Error) -> Verdict {
    let message = error.to_string();
    clean(&message)?;
    Ok(Outcome { read: false, mark: mark(&words(&message)) })
}

/// Breaks a promise where a message says nothing, or floods or steers the terminal.
fn clean(message: &str) -> Result<(), String> {
    promise(!message.is_empty() && message.len() < LONGEST_MESSAGE, || {
        format!("a message of {} bytes", message.len())
    })?;
    let steers = message.chars().any(|c| is_steering(c) && !matches!(c, '\n' | '\t'));
    promise(!steers, || format!("characters that steer a terminal in the message {message:?}"))
}

/// The first words of a message without what it quotes of the file: they tell which check spoke.
fn words(message: &str) -> String {
    let mut quoted = false;
    let told = message.chars().filter(|c| {
        quoted ^= matches!(c, '"' | '`');
        !quoted && (c.is_alphabetic() || *c == ' ')
    });
    told.collect::<String>().split_whitespace().take(7).collect()
}

/// The outcome of a reader that read something with these features.
fn read(features: impl Hash) -> Verdict {
    Ok(Outcome { read: true, mark: mark(&(true, features)) })
}

fn mark(what: &impl Hash) -> u64 {
    let mut hasher = DefaultHasher::new();
    what.hash(&mut hasher);
    hasher.finish()
}

/// A size as a feature: its number of binary digits.
fn size(n: usize) -> u32 {
    usize::BITS - n.leading_zeros()
}

/// Breaks the verdict with `what` unless `holds`.
fn promise(holds: bool, what: impl FnOnce() -> String) -> Result<(), String> {
    if holds { Ok(()) } else { Err(what()) }
}
