//! `vibrissa beam`, run as people run it.

// A test helper that fails fails its test, and numbers that went through text unchanged are equal.
#![allow(clippy::unwrap_used, clippy::float_cmp)]

#[path = "common/mod.rs"]
mod common;

#[path = "../../vibrissa/tests/data/shared.rs"]
mod shared;

use common::{folder, vibrissa};
use shared::shared;
use std::fs;
use std::path::Path;

fn json(args: &[&str]) -> serde_json::Value {
    let outcome = vibrissa(args);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    serde_json::from_str(&outcome.stdout).unwrap()
}

/// The first solution's number under `key`.
fn number(value: &serde_json::Value, key: &str) -> f64 {
    value["solutions"][0][key].as_f64().unwrap()
}

#[test]
fn the_modes_answer_each_other_with_units_and_signs() {
    for sign in ["", "-"] {
        let force = json(&["beam", "force", "--force", &format!("{sign}50 mN"), "--s-a", "60 mm", "--json"]);
        assert_eq!(number(&force, "force").abs(), 0.05);
        assert_eq!(force["solutions"].as_array().unwrap().len(), 1);
        let [x, y, m] = ["x", "y", "moment"].map(|key| number(&force, key).to_string());
        let point = json(&["beam", "point", "--x", &x, "--y", &y, "--json"]);
        let moment = json(&["beam", "moment", "--moment", &m, "--s-a", "0.06", "--json"]);
        assert_eq!(moment["solutions"].as_array().unwrap().len(), 2);
        for other in [&point, &moment] {
            for key in ["force", "s_a", "phi_a", "x", "y", "moment"] {
                assert!((number(other, key) / number(&force, key) - 1.0).abs() < 1e-10, "{key}");
            }
        }
        assert!(number(&force, "y") * if sign == "-" { -1.0 } else { 1.0 } > 0.0);
    }
}

#[test]
fn tables_for_people_carry_units() {
    let outcome = vibrissa(&["beam", "moment", "--moment", "0.01", "--s-a", "0.05", "--load", "tilted:-10 deg"]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    assert_eq!(outcome.stdout.lines().count(), 4, "{}", outcome.stdout);
    assert!(outcome.stdout.contains("mN m") && outcome.stdout.contains(" -10.000 "), "{}", outcome.stdout);
}

#[test]
fn no_equilibrium_is_an_answer() {
    let outcome = vibrissa(&["beam", "moment", "--moment", "17 mN m", "--s-a", "75 mm"]);
    assert_eq!((outcome.code, outcome.stdout.as_str()), (Some(0), "no equilibrium\n"));
    assert!(outcome.stderr.contains("larger than any shape"), "{}", outcome.stderr);
}

#[test]
fn strain_is_reported_and_warned_of() {
    let call = ["beam", "force", "--force", "0.1", "--s-a", "0.06", "--json"];
    let solution = &json(&call)["solutions"][0];
    // Under a normal load the base is bent the most: strain M0 / EI times the radius.
    let strain = solution["moment"].as_f64().unwrap() / 2.8886e-4 * 0.29e-3;
    assert!((solution["largest_strain"]["strain"].as_f64().unwrap() / strain - 1.0).abs() < 1e-9);
    assert_eq!(solution["reaction"][2].as_f64().unwrap(), -solution["moment"].as_f64().unwrap());
    let outcome = vibrissa(&[&call[..], &["--diameter", "5 mm", "--strain-limit", "0.02"]].concat());
    assert!(outcome.stderr.contains("stay bent") && outcome.stderr.contains("limit of 2 %"), "{}", outcome.stderr);
    assert!(!vibrissa(&call).stderr.contains("stay bent"));
    assert_eq!(vibrissa(&[&call[..], &["--diameter", "0"]].concat()).code, Some(2));
}

#[test]
fn faults_of_the_call() {
    for (args, word) in [
        (vec!["--s-a", "0.05"], "--force"),
        (vec!["--s-a", "0.05", "--force", "strong"], "--force"),
        (vec!["--s-a", "0.05", "--force", "NaN"], "--force"),
        (vec!["--s-a", "0.08", "--force", "0.1"], "0.075"),
        (vec!["--s-a", "0.05", "--force", "0.1", "--load", "sideways"], "tilted:RAD"),
    ] {
        let outcome = vibrissa(&[vec!["beam", "force"], args].concat());
        assert_eq!(outcome.code, Some(2), "{}", outcome.stderr);
        assert!(outcome.stderr.contains(word), "{}", outcome.stderr);
    }
}

#[test]
fn files_of_one_whisker() {
    let out = folder("beam_files");
    let dir = out.to_str().unwrap();
    let outcome = vibrissa(&["beam", "moment", "--moment", "-0.01", "--s-a", "0.05", "--out", dir]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    let csv = fs::read_to_string(out.join("beam.csv")).unwrap();
    assert!(csv.starts_with("solution,s,x,y,slope,curvature\n0,0.0,0.0,0.0,0.0,"), "{}", &csv[..80]);
    assert_eq!(csv.lines().count(), 1 + 2 * 101);
    let svg = fs::read_to_string(out.join("beam.svg")).unwrap();
    assert_eq!((svg.matches("class=\"series hue").count(), svg.matches("class=\"force\"").count()), (4, 5));
    assert!(
        svg.contains("whisker frame, x to the right, y up, mm")
            && svg.trim_end().ends_with("</svg>")
            && !svg.contains("NaN")
    );
}

#[test]
fn the_reference_table_as_a_batch() {
    let Some(reference) = shared("vectors/elastica.csv") else { return };
    for mode in ["force", "point", "moment"] {
        let out = folder(&format!("beam_batch_{mode}"));
        let dir = out.to_str().unwrap();
        let outcome = vibrissa(&["beam", mode, "--batch", reference.to_str().unwrap(), "--out", dir]);
        assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
        let text = fs::read_to_string(out.join("beam.csv")).unwrap();
        let mut best = std::collections::BTreeMap::<String, f64>::new();
        for line in text.lines().skip(1) {
            let cells: Vec<&str> = line.split(',').collect();
            let n = |i: usize| cells[i].parse::<f64>().unwrap();
            // Columns 10 to 13 hold the truth, 14 to 17 what was computed.
            let error = (10..14).map(|i| ((n(i + 4) - n(i)) / n(i)).abs()).fold(0.0, f64::max);
            let slot = best.entry(cells[0].into()).or_insert(f64::INFINITY);
            *slot = slot.min(error);
        }
        assert_eq!(best.len(), 150);
        let worst = best.values().fold(0.0_f64, |a, b| a.max(*b));
        println!("{mode}: worst relative error {worst:.1e}");
        assert!(worst < 1e-8, "{mode}: {worst:e}");
        assert!(!outcome.stderr.contains("elastica.csv:"), "{}", outcome.stderr);
    }
}

#[test]
fn a_broken_batch_names_file_and_line() {
    let dir = folder("beam_broken");
    let file = dir.join("rows.csv");
    fs::write(&file, "F,s_a\n0.1,0.05\n0.1,NaN\n").unwrap();
    let outcome = vibrissa(&["beam", "force", "--batch", file.to_str().unwrap()]);
    assert_eq!(outcome.code, Some(1));
    assert!(outcome.stderr.contains("rows.csv:3: s_a: NaN"), "{}", outcome.stderr);
    let outcome = vibrissa(&["beam", "force", "--batch", dir.join("none.csv").to_str().unwrap()]);
    assert_eq!(outcome.code, Some(1));
    assert!(outcome.stderr.contains("none.csv"), "{}", outcome.stderr);
}

#[test]
fn bad_numbers_end_in_a_next_step_and_print_nothing() {
    let cases: &[&[&str]] = &[
        &["force", "--force", "abc", "--s-a", "0.05"],
        &["force", "--force", "inf", "--s-a", "0.05"],
        &["force", "--force", "1e400", "--s-a", "0.05"],
        &["force", "--force", "0.1", "--s-a", "3 furlong"],
        &["force", "--force", "0.1", "--s-a", "0"],
        &["point", "--x", "nan", "--y", "0.01"],
        // The force would be beyond the largest number.
        &["point", "--x", "1e-300", "--y=-1e-230"],
        &["moment", "--moment", "4e10", "--s-a", "5e-324"],
        &["force", "--batch", "no-such-file.csv"],
    ];
    for args in cases {
        let outcome = vibrissa(&[&["beam"], *args].concat());
        assert!(matches!(outcome.code, Some(1 | 2)), "{args:?}: {outcome:?}");
        assert_eq!(outcome.stderr.matches("\n  help: ").count(), 1, "{args:?}: {}", outcome.stderr);
        assert!(outcome.stdout.is_empty(), "{args:?}: {}", outcome.stdout);
    }
}

/// Robots of every kind that the library solves.
fn robots(folder: &Path) -> Vec<String> {
    let kinds = [
        ("uniform", ""),
        ("tapered", "tip_ratio = 0.1"),
        ("curved", "curvature = [3.0, -100.0]"),
        ("elastic", "base_stiffness = 0.3"),
        (
            "jointed",
            "segments = [{ length = 0.04, flexural_rigidity = 3e-4 }, { length = 0.035, flexural_rigidity = 1e-4, tip_ratio = 0.5 }]",
        ),
    ];
    let write = |(name, text): &(&str, &str)| {
        let path = folder.join(format!("{name}.toml"));
        fs::write(&path, format!("[[whisker]]\n{text}\n")).unwrap();
        path.to_string_lossy().into_owned()
    };
    kinds.iter().map(write).collect()
}

#[test]
fn every_beam_refuses_what_makes_no_sense_under_every_load() {
    let folder = folder("beam_refusals");
    let faults: [(&[&str], &str); 9] = [
        (&["force", "--force", "NaN", "--s-a", "0.05"], "--force"),
        (&["force", "--force", "inf", "--s-a", "0.05"], "force"),
        (&["force", "--force", "1e9", "--s-a", "0.05"], "force"),
        (&["force", "--force", "0.1", "--s-a", "0.08"], "s_a: 0.08"),
        (&["force", "--force", "0.1", "--s-a=-0.01"], "s_a: -0.01"),
        (&["moment", "--moment", "inf", "--s-a", "0.05"], "moment"),
        (&["moment", "--moment", "1e-3", "--s-a", "0"], "s_a: 0"),
        (&["point", "--x", "0", "--y", "0"], "contact point"),
        (&["point", "--x", "inf", "--y", "0.01"], "contact point"),
    ];
    for robot in robots(&folder) {
        for load in ["normal", "vertical", "tilted:-0.4", "directed:2"] {
            for (call, word) in faults {
                let args = [&["beam"][..], call, &["--robot", &robot, "--load", load]].concat();
                let outcome = vibrissa(&args);
                assert!(matches!(outcome.code, Some(1 | 2)) && outcome.stdout.is_empty(), "{args:?} {outcome:?}");
                assert!(outcome.stderr.contains(word) && !outcome.stderr.contains("panicked"), "{args:?} {outcome:?}");
            }
            // A push the other way is a push; what no shape reaches is an answer.
            let pull =
                vibrissa(&["beam", "force", "--force=-1e-4", "--s-a", "0.05", "--robot", &robot, "--load", load]);
            assert_eq!((pull.code, pull.stdout.lines().count()), (Some(0), 3), "{pull:?}");
            let far = vibrissa(&["beam", "point", "--x", "0.5", "--y", "0", "--robot", &robot, "--load", load]);
            assert_eq!((far.code, far.stdout.as_str()), (Some(0), "no equilibrium\n"), "{far:?}");
        }
    }
}

#[test]
fn batches_of_every_mode_and_beam_keep_their_good_rows() {
    let folder = folder("beam_batches");
    let tables = [
        ("force", "F,s_a\n1e-3,0.05\n1e-3,0.09\n1e9,0.05\n", 1),
        ("moment", "M0,s_a\n1e-5,0.05\n1e-5,-1\n1e-5,0.09\n", 1),
        ("point", "x,y\n0.05,0.02\n0.5,0.0\n0,0\n", 1),
    ];
    for robot in robots(&folder) {
        for (mode, table, good) in tables {
            let file = folder.join("rows.csv");
            fs::write(&file, table).unwrap();
            let outcome = vibrissa(&["beam", mode, "--batch", file.to_str().unwrap(), "--robot", &robot]);
            assert_eq!(outcome.code, Some(0), "{outcome:?}");
            let solved = outcome.stdout.lines().skip(1).filter(|line| !line.ends_with(',')).count();
            assert!(solved >= good, "{mode} {robot} {outcome:?}");
            assert_eq!(outcome.stderr.lines().filter(|line| line.contains("rows.csv:")).count(), 2, "{outcome:?}");
        }
    }
}

#[test]
fn a_batch_in_which_no_row_makes_sense_is_at_fault() {
    let folder = folder("beam_all_wrong");
    let file = folder.join("rows.csv");
    fs::write(&file, "F,s_a\n0.1,0.09\n0.1,-1\n").unwrap();
    let out = folder.join("out");
    let call = ["beam", "force", "--batch", file.to_str().unwrap(), "--out", out.to_str().unwrap()];
    let outcome = vibrissa(&call);
    assert_eq!(outcome.code, Some(1), "{outcome:?}");
    assert!(
        outcome.stderr.contains("no row of the batch makes sense") && outcome.stderr.contains("line 2"),
        "{outcome:?}"
    );
    assert!(!out.join("beam.csv").exists());
    // Rows that make sense but have no equilibrium are answers.
    fs::write(&file, "M0,s_a\n1,0.05\n").unwrap();
    assert_eq!(vibrissa(&["beam", "moment", "--batch", file.to_str().unwrap()]).code, Some(0));
}

#[test]
fn a_held_tip_tells_force_and_direction() {
    let call = ["beam", "force", "--force", "0.05", "--s-a", "0.075", "--load", "tilted:0.3", "--json"];
    let force = json(&call);
    let [x, y] = ["x", "y"].map(|key| number(&force, key).to_string());
    let tip = json(&["beam", "point", "--tip", "--x", &x, "--y", &y, "--json"]);
    for key in ["moment", "phi_a", "energy"] {
        assert!((number(&tip, key) / number(&force, key) - 1.0).abs() < 1e-7, "{key} {tip}");
    }
    for i in 0..2 {
        let part = |value: &serde_json::Value| value["solutions"][0]["force_vector"][i].as_f64().unwrap();
        assert!((part(&tip) - part(&force)).abs() < 1e-8);
    }
    let refused = vibrissa(&["beam", "point", "--tip", "--load", "normal", "--x", &x, "--y", &y]);
    assert_eq!(refused.code, Some(2), "{refused:?}");
    let file = folder("beam_tips").join("tips.csv");
    fs::write(&file, format!("x,y\n{x},{y}\n0.2,0.0\n")).unwrap();
    let batch = vibrissa(&["beam", "point", "--tip", "--batch", file.to_str().unwrap()]);
    let lines: Vec<&str> = batch.stdout.lines().collect();
    assert_eq!(lines[0], "x,y,phi_a,x,y,M0,F,s_a,beta,F_x,F_y");
    let cells: Vec<&str> = lines[1].split(',').collect();
    assert!((cells[5].parse::<f64>().unwrap() / number(&force, "moment") - 1.0).abs() < 1e-7, "{batch:?}");
    assert_eq!(lines.last(), Some(&"0.2,0.0,,,,,,,,,"));
}

#[test]
fn a_batch_of_many_faults_does_not_flood_the_terminal() {
    let folder = folder("beam-flood");
    let file = folder.join("batch.csv");
    // No shape has such a moment but the first row's.
    let rows: String = (0..500).map(|i| format!("{},0.05\n", if i == 0 { 0.01 } else { 0.1 + f64::from(i) })).collect();
    fs::write(&file, format!("M0,s_a\n{rows}")).unwrap();
    let outcome = vibrissa(&["beam", "moment", "--batch", file.to_str().unwrap()]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    assert_eq!(outcome.stderr.lines().filter(|line| line.starts_with("warning:")).count(), 21, "{}", outcome.stderr);
    assert!(outcome.stderr.contains("and 479 more rows like these"), "{}", outcome.stderr);
}
