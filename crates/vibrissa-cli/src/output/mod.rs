//! What a command leaves: words or JSON on standard output, files under `--out`, complaints on standard error.

mod args;
mod csv;
mod files;
mod json;
mod runtime;
mod summary;

use std::borrow::Cow;
use std::io::Write;
use vibrissa::figure::{LocalizationScene, Outline, localization_figure};
use vibrissa::flow::pose::{Localization, StampedPose};
use vibrissa::flow::trajectory::trajectory_error;
use vibrissa::io::format_tum;
use vibrissa::{Error, Result};

pub(crate) use args::OutputArgs;
use files::{Content, write_each};
pub(crate) use files::{write_all, write_bytes};
pub(crate) use runtime::{Runtime, Stopwatch};

/// A localization that is done, with all that its reports need.
pub(crate) struct Run {
    /// The headline of the figure: the names of the log and the map.
    pub(crate) title: String,
    /// The answer.
    pub(crate) answer: Localization,
    /// How long it took.
    pub(crate) runtime: Runtime,
    /// How many rows of the log it is made of.
    pub(crate) rows: usize,
    /// Whether it was interrupted before the end of the log.
    pub(crate) interrupted: bool,
    /// The map as lines to draw.
    pub(crate) map: Vec<Outline>,
    /// The true trajectory, where known.
    pub(crate) truth: Option<Vec<StampedPose>>,
    /// The recording for viewers (MCAP), where it is asked for.
    pub(crate) recording: Option<Vec<u8>>,
}

/// Writes the files, if a folder is given, then prints the answer.
pub(crate) fn deliver(run: &Run, output: &OutputArgs) -> Result<()> {
    let error = run.truth.as_deref().and_then(|truth| trajectory_error(&run.answer.trajectory, truth));
    if run.truth.is_some() && error.is_none() && !run.answer.trajectory.is_empty() {
        warn("the truth and the log share no time: no error is reported");
    }
    let written = match &output.out {
        Some(folder) => {
            let json = json::result(run, None)?;
            Some(write_each(folder, &result_files(run, &json))?)
        }
        None => None,
    };
    if output.json {
        print(&json::result(run, error.as_ref())?)
    } else {
        print(&summary::text(run, error.as_ref(), written.as_deref()))
    }
}

fn result_files<'a>(run: &'a Run, json: &'a str) -> Vec<(&'static str, Content<'a>)> {
    let answer = &run.answer;
    let figure = move || {
        let truth = run.truth.as_deref();
        localization_figure(&LocalizationScene { title: &run.title, map: &run.map, answer, truth, robot: &[] })
    };
    let mut files = vec![
        ("trajectory.tum", made(|| format_tum(&answer.trajectory))),
        ("result.json", Box::new(|| Cow::Borrowed(json.as_bytes())) as Content<'_>),
        ("states.csv", made(|| csv::states(answer))),
        ("steps.csv", made(|| csv::steps(answer))),
        ("localization.svg", made(figure)),
    ];
    if let Some(bytes) = &run.recording {
        files.push(("localization.mcap", Box::new(|| Cow::Borrowed(bytes.as_slice()))));
    }
    files
}

fn made<'a>(text: impl Fn() -> String + 'a) -> Content<'a> {
    Box::new(move || Cow::Owned(text().into_bytes()))
}

/// Prints to standard output; a reader that closed the pipe has seen enough.
pub(crate) fn print(text: &str) -> Result<()> {
    let mut stdout = std::io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Error::data(format!("cannot write to standard output ({error})")))
        }
        _ => Ok(()),
    }
}

/// Tells the person at the terminal something that does not stop the work.
pub(crate) fn warn(message: &str) {
    complain("warning", &message);
}

/// Writes `KIND: MESSAGE` to standard error; if that is closed, nobody listens.
pub(crate) fn complain(kind: &str, message: &dyn std::fmt::Display) {
    let _ = writeln!(std::io::stderr(), "{kind}: {message}");
}
