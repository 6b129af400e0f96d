//! What localization costs over the size of the map, the length of the log and the number of whiskers: one case, one line of JSON.
//!
//!     vibrissa-scale METHOD OUTLINE_M VERTICES ROWS WHISKERS free|within
//!
//! `METHOD` is one of the library's or `live`, which is the path of a running robot: the probabilistic method without a record of
//! the way, its estimate told thirty times a second. `bench/scale/run` calls it for every case and draws the curves. Seconds
//! are those of the processor, where Linux tells them.

mod measure;
mod world;

use std::process::ExitCode;

/// One case.
pub(crate) struct Case {
    pub(crate) method: String,
    /// Length of the map's outline (m).
    pub(crate) outline: f64,
    /// Its vertices.
    pub(crate) vertices: usize,
    /// Rows of the log.
    pub(crate) rows: usize,
    pub(crate) whiskers: usize,
    /// Whether it is known where the robot starts.
    pub(crate) within: bool,
}

fn parse(words: &[String]) -> Option<Case> {
    let [method, outline, vertices, rows, whiskers, prior] = words else { return None };
    Some(Case {
        method: method.clone(),
        outline: outline.parse().ok().filter(|length| (0.5..=1e5).contains(length))?,
        vertices: vertices.parse().ok().filter(|count| *count > 2)?,
        rows: rows.parse().ok().filter(|count| *count > 0)?,
        whiskers: whiskers.parse().ok().filter(|count| *count > 0)?,
        within: match prior.as_str() {
            "free" => false,
            "within" => true,
            _ => return None,
        },
    })
}

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let Some(case) = parse(&words) else {
        eprintln!("error: METHOD OUTLINE_M VERTICES ROWS WHISKERS free|within are due");
        return ExitCode::from(2);
    };
    match measure::measured(&case) {
        Ok(line) => {
            println!("{line}");
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}
