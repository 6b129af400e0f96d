//! What a command leaves: words or JSON on standard output, files under `--out`, complaints on standard error.

mod args;
mod csv;
mod files;
mod fit;
mod json;
mod picture;
mod plain;
pub(crate) mod progress;
mod runtime;
mod summary;

use std::borrow::Cow;
use std::io::Write;
use std::path::PathBuf;
use vibrissa::error::printable;
use vibrissa::figure::{FilmFrame, LocalizationScene, Outline, localization_figure, localization_film};
use vibrissa::flow::pose::{Localization, StampedPose, Status};
use vibrissa::flow::trajectory::trajectory_error;
use vibrissa::io::format_tum_with_doubts;
pub(crate) use vibrissa::io::text::counted;
use vibrissa::{Error, Result};

pub(crate) use args::OutputArgs;
use files::{Content, write_each};
pub(crate) use files::{write_all, write_bytes};
pub(crate) use plain::plain;
pub(crate) use runtime::{Runtime, Stopwatch};

/// The files that were written, as lines of a report.
pub(crate) fn wrote(paths: &[PathBuf]) -> String {
    paths.iter().map(|path| format!("  wrote {}\n", path.display())).collect()
}

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
    /// The states along the way, where a film is asked for.
    pub(crate) film: Option<Vec<FilmFrame>>,
    /// Files that are written with the results: what a simulated log is made of.
    pub(crate) inputs: Vec<(&'static str, String)>,
}

/// Writes the files, if a folder is given, then prints the answer.
pub(crate) fn deliver(run: &Run, output: &OutputArgs) -> Result<()> {
    // Where nothing explains the log there is no answer that could be off.
    let inconsistent = run.answer.status == Status::Inconsistent;
    let truth = run.truth.as_deref().filter(|_| !inconsistent);
    let error = truth.and_then(|truth| trajectory_error(&run.answer.trajectory, truth));
    if truth.is_some() && error.is_none() && !run.answer.trajectory.is_empty() {
        warn("the truth and the log share no time: no error is reported");
    }
    let written = match output.destination() {
        Some(to) => {
            let json = json::result(run, None)?;
            Some(write_each(to, &result_files(run, &json))?)
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
    let truth = run.truth.as_deref();
    let scene = LocalizationScene { title: &run.title, map: &run.map, answer, truth, robot: &[] };
    let figure = move || localization_figure(&scene);
    let mut files = vec![
        ("trajectory.tum", made(|| format_tum_with_doubts(&answer.trajectory, &answer.unsure))),
        ("result.json", Box::new(|| Cow::Borrowed(json.as_bytes())) as Content<'_>),
        ("states.csv", made(|| csv::states(answer))),
        ("steps.csv", made(|| csv::steps(answer))),
        ("localization.svg", made(figure)),
    ];
    files.extend(
        run.inputs
            .iter()
            .map(|(name, text)| -> (&str, Content<'_>) { (*name, Box::new(|| Cow::Borrowed(text.as_bytes()))) }),
    );
    if let Some(bytes) = &run.recording {
        files.push(("localization.mcap", Box::new(|| Cow::Borrowed(bytes.as_slice()))));
    }
    if let Some(frames) = &run.film {
        files.push(("localization.html", made(move || localization_film(&scene, frames))));
    }
    files
}

fn made<'a>(text: impl Fn() -> String + 'a) -> Content<'a> {
    Box::new(move || Cow::Owned(text().into_bytes()))
}

/// Prints to standard output; a reader that closed the pipe has seen enough.
pub(crate) fn print(text: &str) -> Result<()> {
    progress::clear();
    let mut stdout = std::io::stdout().lock();
    match stdout.write_all(plain(text).as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Error::data(format!("cannot write to standard output ({error})")))
        }
        _ => Ok(()),
    }
}

/// Longest warning (characters); what is longer quotes a damaged file.
const LONGEST_WARNING: usize = 1000;

/// Tells the person at the terminal something that does not stop the work.
pub(crate) fn warn(message: &str) {
    complain("warning", &printable(message, LONGEST_WARNING));
}

/// Writes `KIND: MESSAGE` to standard error; if that is closed, nobody listens.
pub(crate) fn complain(kind: &str, message: &dyn std::fmt::Display) {
    progress::clear();
    let _ = writeln!(std::io::stderr(), "{kind}: {}", plain(&message.to_string()));
}

/// An answer that says nothing, to be filled in.
pub(crate) fn no_answer() -> Localization {
    Localization {
        method: "probabilistic",
        status: Status::NoContact,
        estimate: None,
        hypotheses: Vec::new(),
        trajectory: Vec::new(),
        odometry: None,
        states: Vec::new(),
        encloses: false,
        first_states: Vec::new(),
        steps: Vec::new(),
        events: Vec::new(),
        shapes: Vec::new(),
        nuisances: Vec::new(),
        consistency: None,
        unsure: Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::{Run, Runtime, json, no_answer, summary};
    use serde_json::json;
    use vibrissa::flow::pose::{
        ConsistencyReport, Hypothesis, Localization, Nuisance, NuisanceQuantity, Remedy, StampedPose, Status, Stretch,
    };
    use vibrissa::io::{format_tum_with_doubts, parse_tum};
    use vibrissa::plane::Pose2;
    use vibrissa::sets::StateBox;

    fn run(answer: Localization) -> Run {
        Run {
            title: "test".into(),
            answer,
            runtime: Runtime { updates: 0, total_s: 0.0, p50_us: 0.0, p99_us: 0.0 },
            rows: 3,
            interrupted: false,
            map: Vec::new(),
            truth: None,
            recording: None,
            film: None,
            inputs: Vec::new(),
        }
    }

    #[test]
    fn the_result_holds_what_is_said_of_errors_fit_and_doubts() {
        let nuisance = |quantity, whisker: Option<&str>| Nuisance {
            quantity,
            whisker: whisker.map(str::to_owned),
            estimate: 2e-4,
            std: 2e-5,
            bound: 3e-4,
        };
        let answer = Localization {
            nuisances: vec![nuisance(NuisanceQuantity::Zero, Some("left")), nuisance(NuisanceQuantity::MapScale, None)],
            consistency: Some(ConsistencyReport {
                statistic: 8.5,
                most: 1.25,
                correlation_time: 0.5,
                worst: Some((Stretch { from: 1.0, to: 2.0 }, f64::INFINITY)),
                remedies: vec![Remedy { change: "x".into(), statistic: 1.0, status: Status::Ambiguous }],
            }),
            unsure: vec![Stretch { from: 0.5, to: 1.5 }],
            ..no_answer()
        };
        let found: serde_json::Value = serde_json::from_str(&json::result(&run(answer), None).unwrap()).unwrap();
        let (zero, scale) = (&found["nuisances"][0], &found["nuisances"][1]);
        assert_eq!(
            *zero,
            json!({"quantity": "zero", "whisker": "left", "unit": "N m", "estimate": 2e-4, "std": 2e-5, "bound": 3e-4})
        );
        assert!(scale["whisker"].is_null() && scale["unit"] == "" && scale["quantity"] == "map_scale");
        assert_eq!(
            found["consistency"],
            json!({"statistic": 8.5, "most": 1.25, "correlation_time": 0.5, "worst": {"from": 1.0, "to": 2.0, "statistic": null},
                   "remedies": [{"change": "x", "statistic": 1.0, "status": "ambiguous"}]})
        );
        assert_eq!(found["unsure"], json!([{"from": 0.5, "to": 1.5}]));
        let plain: serde_json::Value = serde_json::from_str(&json::result(&run(no_answer()), None).unwrap()).unwrap();
        assert_eq!(plain["nuisances"], json!([]));
        assert!(plain["consistency"].is_null() && plain["unsure"] == json!([]));
    }

    #[test]
    fn an_inconsistent_answer_shows_no_pose() {
        let pose = Pose2::new(0.123, 0.456, 0.5);
        let place =
            Hypothesis { pose, weight: 1.0, extent: StateBox::point(pose), covariance: None, ridge: Vec::new() };
        let of = |status| Localization { status, estimate: Some(pose), hypotheses: vec![place.clone()], ..no_answer() };
        let shown = |status| {
            let run = run(of(status));
            summary::text(&run, None, None) + &json::result(&run, None).unwrap()
        };
        assert!(shown(Status::Localized).contains("123.00") && shown(Status::Localized).contains("0.123"));
        let text = shown(Status::Inconsistent);
        assert!(!text.contains("123.00") && !text.contains("0.123") && !text.contains("estimate at"), "{text}");
    }

    #[test]
    fn doubts_stand_at_the_head_of_the_trajectory_and_are_skipped_by_readers() {
        let poses = [0.0, 1.0].map(|t| StampedPose { t, map_from_robot: Pose2::new(t, 0.0, 0.0) });
        let text = format_tum_with_doubts(&poses, &[Stretch { from: 0.25, to: 0.5 }, Stretch { from: 1.0, to: 1.0 }]);
        assert!(text.starts_with("# unsure from 0.250000 to 0.500000\n# unsure from 1.000000 to 1.000000\n0.000000 "));
        assert_eq!(parse_tum(&text).unwrap().len(), 2);
    }
}
