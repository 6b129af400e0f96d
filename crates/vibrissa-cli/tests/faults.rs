//! What goes wrong in the field and at the desk, through the real binary: cut logs, full disks, interruptions, dead sensors.

#![cfg(unix)]
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must fail")]

#[path = "common/mod.rs"]
mod common;

use common::{Outcome, folder, vibrissa};
use std::collections::BTreeMap;
use std::fs;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::LazyLock;
use std::time::Duration;

/// The demo's log, map and results, made once.
static DEMO: LazyLock<PathBuf> = LazyLock::new(|| {
    let folder = folder("faults-demo");
    let outcome = vibrissa(&["demo", "--out", folder.to_str().unwrap()]);
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    folder
});

fn demo(name: &str) -> String {
    DEMO.join(name).to_str().unwrap().to_owned()
}

fn demo_log() -> Vec<String> {
    fs::read_to_string(DEMO.join("log.csv")).unwrap().lines().map(str::to_owned).collect()
}

/// The demo's log with each reading changed by `reading(row, moment)`.
fn changed(reading: impl Fn(usize, f64) -> String) -> String {
    let mut lines = demo_log();
    for (index, line) in lines.iter_mut().enumerate().skip(1) {
        let (rest, moment) = line.rsplit_once(',').unwrap();
        *line = format!("{rest},{}", reading(index, moment.parse().unwrap()));
    }
    lines.join("\n") + "\n"
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// Localizes `log` on the demo's map.
fn localize(name: &str, log: &str) -> Outcome {
    let path = folder(&format!("faults-{name}")).join("log.csv");
    fs::write(&path, log).unwrap();
    vibrissa(&["localize", text(&path), "--map", &demo("map.svg"), "--json"])
}

/// The word behind `"status":` of a JSON answer.
fn status(outcome: &Outcome) -> String {
    let rest = outcome.stdout.split("\"status\":").nth(1).unwrap_or_else(|| panic!("no status: {outcome:?}"));
    rest.split('"').nth(1).unwrap().to_owned()
}

fn estimate(outcome: &Outcome) -> String {
    let rest = outcome.stdout.split("\"estimate\":").nth(1).unwrap_or_else(|| panic!("no estimate: {outcome:?}"));
    rest.split('}').next().unwrap().to_owned()
}

/// The numbers of such an estimate.
fn numbers(estimate: &str) -> impl Iterator<Item = f64> {
    estimate.split(['{', ',', ':', '\n']).filter_map(|word| word.trim().parse().ok())
}

/// The files of a folder with their content, hidden ones too.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entry = |e: fs::DirEntry| (e.file_name().into_string().unwrap(), fs::read(e.path()).unwrap());
    fs::read_dir(folder).unwrap().map(|e| entry(e.unwrap())).collect()
}

/// A folder with results of an earlier run.
fn with_results(name: &str) -> PathBuf {
    let folder = folder(&format!("faults-{name}"));
    for file in ["trajectory.tum", "result.json", "states.csv", "steps.csv", "localization.svg"] {
        fs::write(folder.join(file), format!("the earlier {file}\n")).unwrap();
    }
    folder
}

/// A run of the shell line `script`, in which `$1` is the program and `$2 …` are `args`.
fn shell(script: &str, args: &[&str]) -> Outcome {
    let mut command = Command::new("sh");
    command.args(["-c", script, "sh", env!("CARGO_BIN_EXE_vibrissa")]).args(args);
    let output = command.output().unwrap();
    Outcome {
        code: output.status.code(),
        stdout: String::from_utf8(output.stdout).unwrap(),
        stderr: String::from_utf8(output.stderr).unwrap(),
    }
}

/// A localization that waits for its log at a pipe and has read its map.
fn waiting(map: &str, out: &Path) -> (Child, ChildStdin) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_vibrissa"));
    command.args(["localize", "/dev/stdin", "--map", map, "--out", text(out)]);
    let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut pipe = child.stdin.take().unwrap();
    // A pipe takes 64 kB: all of these empty lines are taken once somebody reads the log.
    pipe.write_all(&[b'\n'; 1 << 17]).unwrap();
    (child, pipe)
}

#[test]
fn a_log_that_ends_in_mid_line_is_used_up_to_there() {
    let whole = demo_log();
    let cut = whole[..400].join("\n") + "\n" + &whole[400][..whole[400].len() / 2];
    let outcome = localize("mid-line", &cut);
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    assert!(outcome.stderr.contains("the last line is cut off"), "{}", outcome.stderr);
    let shorter = localize("before-mid-line", &(whole[..400].join("\n") + "\n"));
    assert_eq!(estimate(&outcome), estimate(&shorter));
}

#[test]
fn a_full_disk_leaves_earlier_results_whole_and_no_litter() {
    let out = with_results("disk-full");
    let before = files(&out);
    // A limit on the size of files is a disk that fills up in the middle of a file.
    let script = "trap '' XFSZ; ulimit -f 8; exec \"$@\"";
    let outcome = shell(script, &["localize", &demo("log.csv"), "--map", &demo("map.svg"), "--out", text(&out)]);
    assert_eq!(outcome.code, Some(1), "{outcome:?}");
    assert!(outcome.stderr.contains("cannot write") && outcome.stderr.contains("help: "), "{}", outcome.stderr);
    assert_eq!(files(&out), before);
}

#[test]
fn a_full_standard_output_is_an_error() {
    if !Path::new("/dev/full").exists() {
        return println!("skipped: no /dev/full");
    }
    let outcome = shell("exec \"$@\" > /dev/full", &["localize", &demo("log.csv"), "--map", &demo("map.svg")]);
    assert_eq!(outcome.code, Some(1), "{outcome:?}");
    assert!(outcome.stderr.contains("cannot write to standard output"), "{}", outcome.stderr);
}

#[test]
fn an_interrupt_leaves_earlier_results_whole() {
    let out = with_results("interrupt");
    let before = files(&out);
    let (mut child, mut pipe) = waiting(&demo("map.svg"), &out);
    pipe.write_all(demo_log()[..200].join("\n").as_bytes()).unwrap();
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let status = child.wait().unwrap();
    // As shells tell the signal: 128 + 2.
    assert_eq!(status.code(), Some(130), "{status:?}");
    assert_eq!(files(&out), before);
}

/// Sends SIGINT to a localization once it works on its rows; its exit code and what it wrote.
fn interrupted(name: &str, method: &str) -> (Option<i32>, PathBuf, String) {
    let (here, out) = (folder(&format!("faults-{name}-log")), with_results(name));
    // A column that no whisker has is warned of when the log is read and the work begins.
    let long = there_and_back(10);
    let widened: Vec<String> = long.iter().enumerate().map(|(row, line)| widen(row, line)).collect();
    let log = here.join("log.csv");
    fs::write(&log, widened.join("\n") + "\n").unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_vibrissa"));
    command.args(["localize", text(&log), "--map", &demo("map.svg"), "--method", method, "--out", text(&out)]);
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let mut stderr = BufReader::new(child.stderr.take().unwrap());
    let mut told = String::new();
    stderr.read_line(&mut told).unwrap();
    assert!(told.contains("other.moment"), "{told}");
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    for line in stderr.lines() {
        told += &line.unwrap();
    }
    (child.wait().unwrap().code(), out, told)
}

/// The demo's log so many times, every second one backwards: a run that lasts until the interrupt on a busy machine too.
fn there_and_back(times: usize) -> Vec<String> {
    let log = demo_log();
    let (header, rows) = log.split_first().unwrap();
    let way = (0..times).flat_map(|n| (0..rows.len()).map(move |k| if n % 2 == 0 { k } else { rows.len() - 1 - k }));
    let timed =
        way.enumerate().map(|(k, row)| format!("{:.6},{}", k as f64 / 300.0, rows[row].split_once(',').unwrap().1));
    core::iter::once(header.to_string()).chain(timed).collect()
}

/// A line of a log with one more column.
fn widen(row: usize, line: &str) -> String {
    format!("{line},{}", if row == 0 { "other.moment" } else { "0" })
}

#[test]
fn an_interrupt_in_mid_run_keeps_what_is_known_and_marks_it() {
    for method in ["deterministic", "possibilistic", "probabilistic"] {
        let (code, out, told) = interrupted(&format!("stopped-{method}"), method);
        assert_eq!(code, Some(130), "{method}: {told}");
        assert!(told.contains("interrupted after"), "{method}: {told}");
        let found = files(&out);
        assert_eq!(found.len(), 5, "{:?}", found.keys());
        let result = String::from_utf8_lossy(&found["result.json"]);
        assert!(result.contains("\"interrupted\": true"), "{result}");
        assert!(found.values().all(|content| !content.starts_with(b"the earlier")), "{method}: a mixture of two runs");
    }
    assert!(
        !fs::read_to_string(DEMO.join("result.json")).unwrap().contains("interrupted"),
        "a whole run is not marked"
    );
}

#[test]
fn a_run_that_is_killed_at_any_time_leaves_whole_files() {
    let good = files(&DEMO);
    for delay in [0, 300, 900, 1600] {
        let out = with_results("killed");
        let mut command = Command::new(env!("CARGO_BIN_EXE_vibrissa"));
        command.args(["demo", "--out", text(&out)]).stdout(Stdio::null()).stderr(Stdio::null());
        let mut child = command.spawn().unwrap();
        std::thread::sleep(Duration::from_millis(delay));
        let _ = child.kill();
        child.wait().unwrap();
        for (name, content) in files(&out).iter().filter(|(name, _)| !name.starts_with('.') && *name != "result.json") {
            let earlier = format!("the earlier {name}\n");
            assert!(content == earlier.as_bytes() || content == &good[name], "{name} is torn after {delay} ms");
        }
    }
}

#[test]
fn two_runs_into_one_folder_leave_the_results_of_one() {
    let other = folder("faults-two-log").join("log.csv");
    // Half of the log ends elsewhere.
    fs::write(&other, demo_log()[..350].join("\n") + "\n").unwrap();
    let alone = |name: &str, log: &str| {
        let out = folder(name);
        let outcome = vibrissa(&["localize", log, "--map", &demo("map.svg"), "--out", text(&out)]);
        assert_eq!(outcome.code, Some(0), "{outcome:?}");
        files(&out)
    };
    let logs = [demo("log.csv"), text(&other).to_owned()];
    let single = [alone("faults-two-a", &logs[0]), alone("faults-two-b", &logs[1])];
    for round in 0..2 {
        let out = folder("faults-two");
        let start = |log: &String| {
            let mut command = Command::new(env!("CARGO_BIN_EXE_vibrissa"));
            command.args(["localize", log, "--map", &demo("map.svg"), "--out", text(&out)]);
            command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap()
        };
        for child in logs.iter().map(start).collect::<Vec<_>>() {
            let output = child.wait_with_output().unwrap();
            assert_eq!(output.status.code(), Some(0), "{output:?}");
        }
        let mut found = files(&out);
        found.remove("result.json").expect("results");
        let same = |alone: &BTreeMap<String, Vec<u8>>| {
            alone.len() == found.len() + 1 && found.iter().all(|(name, content)| &alone[name] == content)
        };
        assert!(single.iter().any(same), "a mixture of two runs in round {round}");
    }
}

#[test]
fn a_map_that_is_replaced_in_mid_run_changes_nothing() {
    let here = folder("faults-map");
    let (map, out) = (here.join("map.svg"), here.join("out"));
    fs::copy(DEMO.join("map.svg"), &map).unwrap();
    let (child, mut pipe) = waiting(text(&map), &out);
    fs::write(&map, "<svg").unwrap();
    pipe.write_all((demo_log().join("\n") + "\n").as_bytes()).unwrap();
    drop(pipe);
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    assert_eq!(fs::read(out.join("states.csv")).unwrap(), fs::read(DEMO.join("states.csv")).unwrap());
}

#[test]
fn a_clock_that_jumps_forward_moves_no_place() {
    let mut lines = demo_log();
    for line in lines.iter_mut().skip(250) {
        let (t, rest) = line.split_once(',').unwrap();
        *line = format!("{},{rest}", t.parse::<f64>().unwrap() + 3600.0);
    }
    let outcome = localize("clock-forward", &(lines.join("\n") + "\n"));
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    let steady = localize("clock-steady", &(demo_log().join("\n") + "\n"));
    // What an error that stays alike explains depends on time, by some hundredths of a millimetre.
    for (jumped, steady) in numbers(&estimate(&outcome)).zip(numbers(&estimate(&steady))) {
        assert!((jumped - steady).abs() < 1e-4, "{jumped} {steady}");
    }
}

#[test]
fn a_clock_that_jumps_back_is_told_with_its_line() {
    let mut lines = demo_log();
    lines.swap(250, 260);
    let outcome = localize("clock-back", &(lines.join("\n") + "\n"));
    assert_eq!(outcome.code, Some(1), "{outcome:?}");
    assert!(outcome.stderr.contains("log.csv:252") && outcome.stderr.contains("help: "), "{}", outcome.stderr);
}

#[test]
fn a_dead_sensor_localizes_nothing() {
    let zero = localize("dead-zero", &changed(|_, _| "0".into()));
    assert_eq!((zero.code, status(&zero).as_str()), (Some(0), "no_contact"), "{zero:?}");
    for stuck in ["0.002", "-0.004"] {
        let outcome = localize("dead-stuck", &changed(|_, _| stuck.into()));
        assert_eq!(outcome.code, Some(0), "{outcome:?}");
        assert_ne!(status(&outcome), "localized", "{outcome:?}");
        assert!(outcome.stderr.contains("w0 reads the same in all 514 rows"), "{outcome:?}");
    }
}

#[test]
fn a_sensor_that_dies_on_the_way_ends_nothing() {
    let died = localize("died", &changed(|row, moment| if row > 150 { "0".into() } else { moment.to_string() }));
    assert_eq!(died.code, Some(0), "{died:?}");
}

#[test]
fn a_saturated_sensor_never_makes_a_wrong_place_certain() {
    let truth = fs::read_to_string(DEMO.join("truth.tum")).unwrap();
    let last: Vec<f64> = truth.lines().last().unwrap().split(' ').map(|v| v.parse().unwrap()).collect();
    let limit = 1e-3;
    let outcome = localize("saturated", &changed(|_, moment| moment.clamp(-limit, limit).to_string()));
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    assert!(outcome.stderr.contains("is the sensor saturated?"), "{outcome:?}");
    if status(&outcome) == "localized" {
        let number = |key: &str| -> f64 {
            let text = estimate(&outcome);
            let rest = text.split(&format!("\"{key}\":")).nth(1).unwrap().to_owned();
            rest.split(',').next().unwrap().trim().parse().unwrap()
        };
        let distance = (number("x") - last[1]).hypot(number("y") - last[2]);
        assert!(distance < 0.02, "limit {limit} N m: {distance} m off, {outcome:?}");
    }
}

#[test]
fn a_burst_of_not_a_number_is_told_with_its_first_line() {
    let burst = |row: usize, moment: f64| if (200..240).contains(&row) { "NaN".into() } else { moment.to_string() };
    let outcome = localize("burst", &changed(burst));
    assert_eq!(outcome.code, Some(1), "{outcome:?}");
    assert!(outcome.stderr.contains("log.csv:201") && outcome.stderr.contains("moment"), "{}", outcome.stderr);
}

#[test]
fn a_million_identical_readings_fit_into_a_gigabyte() {
    let here = folder("faults-million");
    let path = here.join("log.csv");
    let mut log = String::from("t,x,y,theta,moment\n");
    for row in 0..1_000_000 {
        log += &format!("{row},0,0,0,0.001\n");
    }
    fs::write(&path, log).unwrap();
    let args = ["localize", text(&path), "--map", &demo("map.svg"), "--json"];
    let outcome = shell("ulimit -v 1000000; exec \"$@\"", &args);
    assert_eq!(outcome.code, Some(0), "{} {}", outcome.stderr, outcome.stdout.len());
    assert_eq!(status(&outcome), "ambiguous");
    assert!(outcome.stdout.len() < 100_000, "{} bytes", outcome.stdout.len());
    fs::remove_file(&path).unwrap();
}

#[test]
fn a_stray_quote_is_told_with_its_line() {
    let lines = demo_log();
    let whole = lines.join("\n") + "\n";
    let quoted = whole.replacen(&lines[401], &format!("\"{}", lines[401]), 1);
    let outcome = localize("quote", &quoted);
    assert_eq!(outcome.code, Some(1), "{outcome:?}");
    assert!(outcome.stderr.contains("log.csv:402: a quote that does not end in its line"), "{}", outcome.stderr);
    // In a column that nobody reads it would swallow rows without a word.
    let with = |row: usize, word: &str| format!("{},{}", lines[row], if row == 0 { "note" } else { word });
    let noted = |row: usize| with(row, if row == 100 || row == 300 { "\"half" } else { "\"a, b\"" });
    let log: String = (0..lines.len()).map(|row| noted(row) + "\n").collect();
    let outcome = localize("quote-note", &log);
    assert!(outcome.code == Some(1) && outcome.stderr.contains("log.csv:101"), "{outcome:?}");
    let sound: String = (0..lines.len()).map(|row| with(row, "\"a, b\"") + "\n").collect();
    assert_eq!(estimate(&localize("quotes", &sound)), estimate(&localize("no-quotes", &whole)));
}

#[test]
fn a_last_line_without_its_end_is_dropped_whatever_it_holds() {
    // Columns t,moment,theta,y,x: what is cut off in mid number is a number still.
    let order = |line: &String| {
        let f: Vec<&str> = line.split(',').collect();
        [f[0], f[4], f[3], f[2], f[1]].join(",")
    };
    let lines: Vec<String> = demo_log().iter().map(order).collect();
    assert_eq!(lines[0], "t,moment,theta,y,x");
    let mut cut = lines[..401].join("\n");
    cut.truncate(cut.rfind(',').unwrap() + 2);
    let outcome = localize("last-number", &cut);
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    assert!(outcome.stderr.contains("line 401: the last line is cut off"), "{}", outcome.stderr);
    let before = localize("before-last-number", &(lines[..400].join("\n") + "\n"));
    assert_eq!(estimate(&outcome), estimate(&before));
}

#[test]
fn a_moment_that_may_be_of_several_whiskers_is_refused_by_every_command() {
    let here = folder("faults-whose");
    let (two, one, log) = (here.join("two.toml"), here.join("one.toml"), here.join("log.csv"));
    fs::write(&two, "[[whisker]]\nname = \"a\"\n[[whisker]]\nname = \"b\"\nmount = [0, 0, 1]\n").unwrap();
    fs::write(&one, "[[whisker]]\nname = \"w0\"\n").unwrap();
    let refused = |robot: &Path, word: &str| {
        for command in ["contact", "profile", "localize"] {
            let mut args = vec![command, text(&log), "--robot", text(robot)];
            let map = demo("map.svg");
            if command == "localize" {
                args.extend(["--map", &map]);
            }
            let outcome = vibrissa(&args);
            assert_eq!(outcome.code, Some(1), "{command}: {outcome:?}");
            assert!(
                outcome.stderr.contains(word) && outcome.stderr.contains("help: "),
                "{command}: {}",
                outcome.stderr
            );
        }
    };
    fs::write(&log, demo_log().join("\n") + "\n").unwrap();
    refused(&two, "does not say whose it is");
    let both = |(row, line): (usize, &String)| format!("{line},{}\n", if row == 0 { "w0.moment" } else { "0" });
    fs::write(&log, demo_log().iter().enumerate().map(both).collect::<String>()).unwrap();
    refused(&one, "`moment` beside `w0.moment`");
}

#[cfg(feature = "mcap")]
#[test]
fn times_that_no_recording_holds_are_told_and_kept_apart() {
    let here = folder("faults-clock");
    for (name, change) in [("ms", (|t| 1.7e12 + 1e3 * t) as fn(f64) -> f64), ("negative", |t| t - 100.0)] {
        let shifted = |(row, line): (usize, &String)| match line.split_once(',') {
            Some((t, rest)) if row > 0 => format!("{},{rest}\n", change(t.parse().unwrap())),
            _ => format!("{line}\n"),
        };
        let (log, out) = (here.join(format!("{name}.csv")), here.join(name));
        fs::write(&log, demo_log().iter().enumerate().map(shifted).collect::<String>()).unwrap();
        let map = demo("map.svg");
        let outcome = vibrissa(&["localize", text(&log), "--map", &map, "--mcap", "--out", text(&out)]);
        assert_eq!(outcome.code, Some(0), "{outcome:?}");
        assert!(outcome.stderr.contains("do not fit the clock of a recording"), "{}", outcome.stderr);
        let bytes = fs::read(out.join("localization.mcap")).unwrap();
        let mut times = std::collections::BTreeSet::new();
        vibrissa::io::ros::read_bag(&bytes[..], name, |_, time, _| {
            times.insert(time);
            Ok(())
        })
        .unwrap();
        assert!(times.len() > 500, "{name}: {} times", times.len());
    }
}

#[test]
fn the_demo_replaces_all_of_its_files_or_none() {
    let out = with_results("demo-once");
    fs::write(out.join("log.csv"), "the earlier log\n").unwrap();
    // One of the results cannot be replaced, and the log before them must not be either.
    fs::remove_file(out.join("states.csv")).unwrap();
    fs::create_dir(out.join("states.csv")).unwrap();
    let outcome = vibrissa(&["demo", "--out", text(&out)]);
    assert!(outcome.code == Some(1) && outcome.stderr.contains("a folder has the name of a result"), "{outcome:?}");
    assert_eq!(fs::read_to_string(out.join("log.csv")).unwrap(), "the earlier log\n");
    assert_eq!(fs::read_to_string(out.join("result.json")).unwrap(), "the earlier result.json\n");
    assert!(!fs::read_dir(&out).unwrap().any(|e| e.unwrap().file_name().to_string_lossy().ends_with(".part")));
}

/// Sends SIGINT after `delay` to a command; how long it went on (s), its exit code and its words.
fn stopped_after(args: &[&str], delay: Duration) -> (f64, Option<i32>, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_vibrissa"));
    let child = command.args(args).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    std::thread::sleep(delay);
    let asked = std::time::Instant::now();
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let output = child.wait_with_output().unwrap();
    (asked.elapsed().as_secs_f64(), output.status.code(), String::from_utf8(output.stderr).unwrap())
}

#[test]
fn an_interrupt_in_a_long_step_leaves_what_was_known_before_and_marks_it() {
    // A ring of 60 m of wall with many corners: its first contact and the end of its log take seconds.
    let here = folder("faults-long-step");
    let (map, log, out) = (here.join("map.geojson"), here.join("log.csv"), here.join("out"));
    let turn = core::f64::consts::TAU / 60_000.0;
    let point = |i: i32| format!("[{},{}]", 9.0 * (turn * f64::from(i)).cos(), 9.0 * (turn * f64::from(i)).sin());
    let ring: Vec<String> = (0..60_000).map(point).collect();
    let feature = format!(
        "{{\"type\":\"Feature\",\"properties\":{{\"role\":\"arena\"}},\"geometry\":{{\"type\":\"Polygon\",\"coordinates\":[[{}]]}}}}",
        ring.join(",")
    );
    fs::write(&map, feature).unwrap();
    fs::write(&log, demo_log().join("\n") + "\n").unwrap();
    let args = ["localize", text(&log), "--map", text(&map), "--out", text(&out), "--method", "possibilistic"];
    let (_, code, told) = stopped_after(&args, Duration::from_millis(2500));
    if code == Some(0) {
        return println!("skipped: this machine was done before the interrupt");
    }
    assert_eq!(code, Some(130), "{told}");
    // The step in which the signal arrives depends on the machine: each has its words, and its files.
    let (partial, whole) = (told.contains("interrupted after"), told.contains("interrupted: the results are whole"));
    if partial || whole {
        let found = files(&out);
        assert_eq!(found.len(), 5, "{:?}", found.keys());
        let marked = String::from_utf8_lossy(&found["result.json"]).contains("\"interrupted\": true");
        assert_eq!(marked, partial, "{told}");
    } else {
        assert!(told.is_empty() || told.contains("before anything was known"), "{told}");
    }
}

#[test]
fn an_interrupt_keeps_the_contacts_that_are_found_and_marks_them() {
    // The readings of the demo belong to a stiff whisker; on a soft base each contact of them takes long.
    let here = folder("faults-contacts");
    let (robot, log) = (here.join("robot.toml"), here.join("log.csv"));
    fs::write(&robot, "[[whisker]]\nbase_stiffness = 0.002\n").unwrap();
    // Touched again and again, so that there is more to do than any machine does in the time.
    let lines = demo_log();
    let mut content = lines[0].clone() + "\n";
    for turn in 0..40 {
        for line in &lines[1..] {
            let (t, rest) = line.split_once(',').unwrap();
            content += &format!("{:.6},{rest}\n", t.parse::<f64>().unwrap() + 3.0 * f64::from(turn));
        }
    }
    fs::write(&log, content).unwrap();
    for (command, result) in [("contact", "contacts.svg"), ("profile", "profile.svg")] {
        let out = here.join(command);
        let args = [command, text(&log), "--robot", text(&robot), "--out", text(&out)];
        let (_, code, told) = stopped_after(&args, Duration::from_millis(1500));
        assert_eq!(code, Some(130), "{command}: {told}");
        assert!(told.contains("interrupted: the contacts") && told.contains("are missing"), "{command}: {told}");
        assert!(fs::read_to_string(out.join(result)).unwrap().contains("interrupted"), "{command}");
    }
}
