//! Help and usage errors of the real binary.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must fail")]

#[path = "common/mod.rs"]
mod common;

use common::{folder, vibrissa};

#[test]
fn help_names_every_command_and_the_exit_codes() {
    let help = vibrissa(&["--help"]);
    assert_eq!(help.code, Some(0));
    for word in ["demo", "localize", "Exit codes", "SI units"] {
        assert!(help.stdout.contains(word), "{word}:\n{}", help.stdout);
    }
    assert!(help.stderr.is_empty());
    assert!(help.stdout.lines().count() <= 40, "help fits a screen");
}

#[test]
fn help_of_localize_names_files_units_and_options() {
    let help = vibrissa(&["localize", "--help"]);
    assert_eq!(help.code, Some(0));
    for word in ["--map", "--robot", "--truth", "--method", "--out", "--json", ".geojson", ".svg", "rad", "result.json"]
    {
        assert!(help.stdout.contains(word), "{word}:\n{}", help.stdout);
    }
}

#[test]
fn version_is_the_packages() {
    let version = vibrissa(&["--version"]);
    assert_eq!((version.code, version.stdout.trim()), (Some(0), concat!("vibrissa ", env!("CARGO_PKG_VERSION"))));
}

#[test]
fn usage_errors_exit_2_and_say_what_is_wrong() {
    let cases: &[(&[&str], &str)] = &[
        (&[], "Usage"),
        (&["locaize"], "localize"),
        (&["localize"], "--map"),
        (&["localize", "log.csv"], "--map"),
        (&["localize", "log.csv", "--map"], "--map"),
        (&["localize", "log.csv", "--map", "m.svg", "--methd", "x"], "--method"),
        (&["localize", "log.csv", "--map", "m.svg", "--method", "magic"], "deterministic"),
        (&["localize", "a.csv", "b.csv", "--map", "m.svg"], "b.csv"),
        (&["demo", "extra"], "extra"),
    ];
    for (args, word) in cases {
        let outcome = vibrissa(args);
        assert_eq!(outcome.code, Some(2), "{args:?}: {outcome:?}");
        assert!(outcome.stderr.contains(word), "{args:?}: {}", outcome.stderr);
        assert!(outcome.stdout.is_empty(), "{args:?}: {}", outcome.stdout);
    }
}

#[test]
fn an_unknown_method_is_refused_with_what_is_there() {
    let outcome = vibrissa(&["localize", "no.csv", "--map", "no.svg", "--method", "guess"]);
    assert_eq!(outcome.code, Some(2), "{outcome:?}");
    for word in ["guess", "deterministic", "possibilistic", "probabilistic"] {
        assert!(outcome.stderr.contains(word), "{word}: {}", outcome.stderr);
    }
}

#[test]
fn a_failed_call_leaves_no_folder() {
    let out = folder("failed-call").join("results");
    let outcome = vibrissa(&["localize", "no.csv", "--map", "no.geojson", "--out", out.to_str().unwrap()]);
    assert_eq!(outcome.code, Some(1), "{outcome:?}");
    assert!(outcome.stderr.starts_with("error: ") && outcome.stderr.contains("help: "), "{}", outcome.stderr);
    assert!(!out.exists());
}

#[test]
fn a_region_takes_commas_or_spaces() {
    let region = |words: &[&str]| {
        let mut args = vec!["localize", "--map", "no.svg", "--within"];
        args.extend(words);
        args.push("no.csv");
        vibrissa(&args)
    };
    let good: &[&[&str]] = &[
        &["-1,1,0,2.5,-0.1,1e-1"],
        &["-1", "1", "0", "2.5", "-0.1", "1e-1"],
        &["-1,", "1,", "0,", "2.5,", "-0.1,", "1e-1"],
        &["-1 1 0 2.5 -0.1 1e-1"],
        &["-1,1", "0,2.5", "-0.1,1e-1"],
    ];
    for words in good {
        let outcome = region(words);
        // The call is right; the files are not there.
        assert_eq!(outcome.code, Some(1), "{words:?}: {}", outcome.stderr);
        assert!(outcome.stderr.contains("no.svg"), "{words:?}: {}", outcome.stderr);
    }
    let bad: &[(&[&str], &str)] = &[
        (&["1,2,3,4,5"], "got 5"),
        (&["1,2,3,4,5,6,7"], "got 7"),
        (&["1,2,3,4,5,x"], "six numbers"),
        (&["2,1,0,1,0,1"], "region is empty"),
    ];
    for (words, told) in bad {
        let outcome = region(words);
        assert_eq!(outcome.code, Some(2), "{words:?}: {}", outcome.stderr);
        assert!(outcome.stderr.contains(told), "{words:?}: {}", outcome.stderr);
    }
}

#[test]
fn commands_tell_each_file_that_they_wrote() {
    let out = folder("usage-wrote");
    let (map, to) = (out.join("map.svg"), out.join("out"));
    std::fs::write(&map, vibrissa::tasks::demo::ARENA_SVG).unwrap();
    let [map, to] = [&map, &to].map(|path| path.to_str().unwrap());
    let reading = ["--sensor", "load", "--value", "0.1 N"];
    let cases: [&[&str]; 4] = [
        &["beam", "force", "--s-a", "60 mm", "--force", "0.1 N"],
        &["contact-set"],
        &["preimage", "--map", map, "--cell", "20 mm", "--heading-step", "30 deg"],
        &["reproduce", "--only", "beam"],
    ];
    for case in cases {
        let readings: &[&str] = if case[0].contains("set") || case[0] == "preimage" { &reading } else { &[] };
        let outcome = vibrissa(&[case, readings, &["--out", to, "--pictures", "png"]].concat());
        assert_eq!(outcome.code, Some(0), "{case:?}: {}", outcome.stderr);
        let told: Vec<&str> = outcome.stdout.lines().filter_map(|line| line.strip_prefix("  wrote ")).collect();
        assert!(told.len() >= 2 && told.iter().all(|path| std::path::Path::new(path).exists()), "{case:?}: {told:?}");
        let json = vibrissa(&[case, readings, &["--out", to, "--json"]].concat());
        assert!(serde_json::from_str::<serde_json::Value>(&json.stdout).is_ok(), "{case:?}: {}", json.stdout);
    }
}
