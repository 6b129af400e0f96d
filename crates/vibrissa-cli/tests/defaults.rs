//! The defaults that help prints are those of the library's `config`, all of them.

#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot go on must fail")]

#[path = "common/mod.rs"]
mod common;

use common::{folder, vibrissa};
use vibrissa::config::{defaults, shaft};
use vibrissa::localizer::Method;
use vibrissa::tasks::temporal_filter::TemporalFilterOptions;
use vibrissa_reproduce::ReproduceOptions;

const COMMANDS: [&[&str]; 14] = [
    &["demo"],
    &["beam", "force"],
    &["beam", "point"],
    &["beam", "moment"],
    &["calibrate"],
    &["contact"],
    &["profile"],
    &["localize"],
    &["join"],
    &["contact-set"],
    &["preimage"],
    &["simulate"],
    &["reproduce"],
    &["studio"],
];

/// Each option of a command with its part of the help.
fn options(command: &[&str]) -> Vec<(String, String)> {
    let help = vibrissa(&[command, &["--help"]].concat());
    assert_eq!(help.code, Some(0), "{command:?}: {}", help.stderr);
    let mut options: Vec<(String, String)> = Vec::new();
    for line in help.stdout.lines() {
        let words = line.trim_start();
        let flag = words.split_whitespace().find_map(|word| word.strip_prefix("--"));
        match flag.filter(|_| words.starts_with('-') && line.starts_with("  ")) {
            Some(flag) => options.push((flag.to_owned(), words.to_owned())),
            None => {
                if let Some((_, text)) = options.last_mut() {
                    text.push(' ');
                    text.push_str(words);
                }
            }
        }
    }
    options
}

/// Each option of a command with the default that its help prints, where it prints one.
fn printed(command: &[&str]) -> Vec<(String, String)> {
    let default = |text: &str| Some(text.split_once("[default: ")?.1.split_once(']')?.0.to_owned());
    options(command).into_iter().filter_map(|(flag, text)| Some((flag, default(&text)?))).collect()
}

#[test]
fn no_option_tells_its_default_twice() {
    const MORE: [&[&str]; 6] =
        [&["live"], &["map"], &["plan"], &["explore"], &["sensor", "design"], &["sensor", "head"]];
    for command in COMMANDS.into_iter().chain(MORE) {
        for (flag, text) in options(command) {
            assert!(text.matches("[default: ").count() < 2, "{command:?} --{flag}: {text}");
        }
    }
}

/// The numbers in a text.
fn numbers(text: &str) -> Vec<f64> {
    let pieces = text.split(|c: char| !(c.is_ascii_digit() || c == '.' || c == '-'));
    pieces.filter(|piece| piece.contains(|c: char| c.is_ascii_digit())).filter_map(|piece| piece.parse().ok()).collect()
}

/// What the library takes, in the units that help shows; the methods' options are compared word for word elsewhere.
fn expected(command: &str, option: &str) -> Vec<f64> {
    let reproduce = ReproduceOptions::default();
    match (command, option) {
        ("demo", "seed") => vec![defaults::SEED as f64],
        ("beam", "diameter") => vec![1e3 * defaults::DIAMETER],
        ("beam", "strain-limit") => vec![defaults::STRAIN_LIMIT],
        ("contact", "readings") => vec![TemporalFilterOptions::default().readings as f64],
        ("contact", "spacing") => vec![1e3 * TemporalFilterOptions::default().spacing],
        ("join", "search") => vec![vibrissa::tasks::join::SEARCH],
        ("calibrate", "length") => vec![1e3 * shaft::TAPPED_LENGTH, 1e3 * shaft::STAIRCASE_LENGTH],
        ("calibrate", "tip-ratio") => vec![1.0, shaft::TAPPED_TIP_RATIO.recip()],
        ("preimage", "cell") => vec![1e3 * defaults::PREIMAGE_CELL],
        ("preimage", "heading-step") => vec![360.0 / defaults::PREIMAGE_HEADINGS as f64],
        ("reproduce", "seeds") => vec![reproduce.seeds as f64],
        ("reproduce", "sweeps") => vec![reproduce.sweeps as f64],
        ("studio", "port") => vec![0.0],
        ("reproduce", "trials") => vec![reproduce.trials as f64],
        _ => Vec::new(),
    }
}

#[test]
fn every_number_that_help_calls_a_default_is_the_librarys() {
    let mut compared = 0;
    for command in COMMANDS.iter().filter(|command| command[0] != "localize") {
        for (option, default) in printed(command) {
            let (told, taken) = (numbers(&default), expected(command[0], &option));
            let same =
                told.len() == taken.len() && told.iter().zip(&taken).all(|(a, b)| (a - b).abs() <= 1e-9 * b.abs());
            assert!(same, "{command:?} --{option}: `{default}` is told, {taken:?} is taken");
            compared += taken.len();
        }
    }
    assert!(compared > 10, "{compared}");
}

#[test]
fn every_option_of_every_method_prints_the_default_that_is_taken() {
    let printed = printed(&["localize"]);
    let told = |name: &str| printed.iter().find(|(option, _)| *option == name).map(|(_, default)| default.as_str());
    assert_eq!(told("method"), Some(Method::default().name()));
    let mut known = vec!["method".to_owned(), "robot".to_owned(), "format".to_owned()];
    for mut method in Method::all() {
        for setting in method.settings() {
            let name = setting.name.replace('_', "-");
            assert_eq!(told(&name), setting.shown().as_deref(), "--{name}");
            known.push(name);
        }
    }
    let strangers: Vec<_> = printed.iter().filter(|(option, _)| !known.contains(option)).collect();
    assert!(strangers.is_empty() && known.len() > 20, "{strangers:?}");
}

#[test]
fn options_of_other_methods_are_told_to_be_unused_and_still_checked() {
    let call = |more: &[&str]| vibrissa(&[&["localize", "no.csv", "--map", "no.svg"], more].concat());
    let wrong = call(&["--tolerance", "99"]);
    assert!(wrong.code == Some(2) && wrong.stderr.contains("tolerance"), "{wrong:?}");
    let word = call(&["--method", "deterministic", "--tip-load", "sideways"]);
    assert!(word.code == Some(2) && word.stderr.contains("boundary-normal"), "{word:?}");
    let place = folder("unused-options");
    let put = |name: &str, text: &str| {
        std::fs::write(place.join(name), text).unwrap();
        place.join(name).to_str().unwrap().to_owned()
    };
    let log = put("log.csv", "t,x,y,theta,moment\n0,0,0,0,0\n0.01,0.001,0,0,0\n");
    let map = put(
        "map.geojson",
        r#"{"type":"FeatureCollection","features":[{"type":"Feature","properties":{"role":"arena"},
            "geometry":{"type":"Polygon","coordinates":[[[0,0],[0.4,0],[0.4,0.3],[0,0.3],[0,0]]]}}]}"#,
    );
    let unused = vibrissa(&["localize", &log, "--map", &map, "--tolerance", "3"]);
    assert_eq!(unused.code, Some(0), "{unused:?}");
    assert!(unused.stderr.contains("--tolerance is not used") && unused.stderr.contains("probabilistic"), "{unused:?}");
}
