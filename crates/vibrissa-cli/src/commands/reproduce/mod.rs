//! `vibrissa reproduce`: the paper on one page.

mod json;
mod page;

use crate::output::{OutputArgs, counted, print, write_all, wrote};
use std::fmt::Write as _;
use std::io::{IsTerminal, Write as _};
use std::time::Instant;
use vibrissa::Result;
use vibrissa_reproduce::ReproduceOptions;
use vibrissa_reproduce::{Cell, Progress, Reproduction, reproduce};

/// Make every figure and both tables of the paper anew, beside the paper's numbers.
///
/// Everything is simulated, with the paper's whisker and sweeps built after its description. It takes a minute or two on
/// two cores; the same call gives the same bytes.
///
/// With --out DIR: report.html, one page that needs nothing else, and reproduce.json, every number of it; with --pictures
/// also each picture of the page as a file.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Draws of the noise for each sweep of the localization table
    #[arg(long, value_name = "N", default_value_t = ReproduceOptions::default().seeds)]
    seeds: usize,
    /// How many of the five sweeps are run
    #[arg(long, value_name = "N", default_value_t = ReproduceOptions::default().sweeps)]
    sweeps: usize,
    /// Trials for each distance of the contact table
    #[arg(long, value_name = "N", default_value_t = ReproduceOptions::default().trials)]
    trials: usize,
    /// Make only these sections, such as contact-table (may be repeated) [default: all]
    #[arg(long, value_name = "SECTION")]
    only: Vec<String>,
    #[command(flatten)]
    output: OutputArgs,
}

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<()> {
    let options = ReproduceOptions {
        seeds: args.seeds,
        sweeps: args.sweeps,
        trials: args.trials,
        only: args.only.clone(),
        threads: None,
    };
    let begin = Instant::now();
    let mut bar = Bar::new();
    let answer = reproduce(&options, &mut |progress| bar.show(progress))?;
    drop(bar);
    let seconds = begin.elapsed().as_secs_f64();
    let json = json::text(&answer, &options, None)?;
    let mut written = Vec::new();
    if let Some(to) = args.output.destination() {
        let plates = if to.pictures.is_empty() { Vec::new() } else { plates(&answer) };
        let mut files = vec![("report.html", page::text(&answer)), ("reproduce.json", json)];
        files.extend(plates.iter().map(|(name, svg)| (name.as_str(), (*svg).clone())));
        written = write_all(to, &files)?;
    }
    if args.output.json {
        return print(&json::text(&answer, &options, Some(seconds))?);
    }
    let mut text = summary(&answer);
    let _ = writeln!(text, "{} in {seconds:.1} s", counted(pieces(&answer), "figure or table", "figures and tables"));
    match written.as_slice() {
        [] => text.push_str("give --out DIR for the page with the figures\n"),
        paths => text.push_str(&wrote(paths)),
    }
    print(&text)
}

fn pieces(answer: &Reproduction) -> usize {
    answer.sections.iter().map(|section| section.figures.len() + section.tables.len()).sum()
}

/// The pictures of the page, each as a file of its own.
fn plates(answer: &Reproduction) -> Vec<(String, &String)> {
    let figures = answer.sections.iter().flat_map(|section| &section.figures);
    figures.flat_map(|figure| &figure.panels).map(|panel| (format!("{}.svg", panel.key), &panel.svg)).collect()
}

/// What is compared, in words.
fn summary(answer: &Reproduction) -> String {
    let mut text = String::new();
    for section in answer.sections.iter().filter(|section| !section.comparisons.is_empty()) {
        let _ = writeln!(text, "{}", section.title);
        for comparison in &section.comparisons {
            let (paper, ours) = (words(&comparison.paper), words(&comparison.ours));
            let _ = writeln!(text, "  {}: paper {paper}, ours {ours}", comparison.what);
        }
        text.push('\n');
    }
    text
}

/// A field with its unit.
fn words(cell: &Cell) -> String {
    match cell {
        Cell::Words(words) => words.clone(),
        Cell::Number(number) => format!("{} {}", number.shown(), number.unit).trim_end().to_owned(),
    }
}

/// A bar on standard error that is written over, when somebody sits there.
struct Bar {
    shown: bool,
}

impl Bar {
    const WIDTH: usize = 30;

    fn new() -> Self {
        Self { shown: std::io::stderr().is_terminal() }
    }

    fn show(&mut self, progress: Progress) {
        if self.shown {
            let full = (progress.share.clamp(0.0, 1.0) * Self::WIDTH as f64).round() as usize;
            let bar = format!("{}{}", "█".repeat(full), "·".repeat(Self::WIDTH - full));
            // If standard error is closed, nobody watches.
            let _ = write!(std::io::stderr(), "\r\x1b[K{bar} {:3.0} % {}", 100.0 * progress.share, progress.what);
        }
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        if self.shown {
            let _ = write!(std::io::stderr(), "\r\x1b[K");
        }
    }
}
