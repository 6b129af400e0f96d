//! `vibrissa live` on topics of ROS 2, which come as lines of a program: a script stands for it here.

#![cfg(all(unix, feature = "live"))]
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must fail")]

#[path = "common/mod.rs"]
mod common;

use common::{folder, vibrissa};
use std::io::{BufRead, BufReader, Read, Write};
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;
use vibrissa::tasks::demo;

/// How long anything may take before the test fails instead of waiting.
const PATIENCE: Duration = Duration::from_secs(120);

/// A folder with the demo's map, and a program that tells what comes through two pipes, or says why not.
fn prepared(name: &str) -> std::path::PathBuf {
    let here = folder(name);
    std::fs::write(here.join("map.svg"), demo::ARENA_SVG).unwrap();
    for pipe in ["odom", "touch"] {
        let _ = std::fs::remove_file(here.join(pipe));
        assert!(Command::new("mkfifo").arg(here.join(pipe)).status().unwrap().success());
    }
    // It talks more than a pipe holds, and what it starts outlives it with its standard error in hand.
    let script = format!(
        "#!/bin/sh\ncase \"$*\" in\n\"--lines odometry /odom\") exec cat {0}/odom;;\n\"--lines joints touch\")\n  \
         i=0; while [ $i -lt 2000 ]; do echo \"a long warning that nobody asked for, number $i\" >&2; i=$((i+1)); done\n  \
         exec cat {0}/touch;;\n*) sleep 2 > /dev/null & echo \"no such topic: $*\" >&2; exit 1;;\nesac\n",
        here.display()
    );
    let program = here.join("vibrissa-ros2");
    std::fs::write(&program, script).unwrap();
    std::fs::set_permissions(&program, std::fs::Permissions::from_mode(0o755)).unwrap();
    here
}

/// Starts a run whose readings come from a topic, with a search path for the program.
fn start(here: &Path, topic: &str, path: &str) -> Child {
    let setup = format!(
        "map = \"map.svg\"\n[[source]]\nname = \"touch\"\nros2 = \"{topic}\"\nmessage = \"joints\"\n\
         [[source]]\nname = \"base\"\nros2 = \"/odom\"\nmessage = \"odometry\"\n"
    );
    std::fs::write(here.join("live.toml"), setup).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_vibrissa"));
    command.args(["live", "--json", "--out"]).arg(here.join("out")).arg(here.join("live.toml"));
    command.env("PATH", path).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
}

/// The lines of a stream, read on a thread of their own.
fn lines(stream: impl Read + Send + 'static) -> Receiver<String> {
    let (sender, receiver) = channel();
    std::thread::spawn(move || {
        BufReader::new(stream).lines().map_while(Result::ok).for_each(|line| sender.send(line).unwrap_or_default());
    });
    receiver
}

/// Interrupts a run; it ends with success.
fn end(mut child: Child) {
    Command::new("kill").arg("-INT").arg(child.id().to_string()).status().unwrap();
    for _ in 0..PATIENCE.as_millis() / 20 {
        if let Some(status) = child.try_wait().unwrap() {
            assert_eq!(status.code(), Some(0));
            return;
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    let _ = child.kill();
    panic!("the run did not end");
}

#[test]
fn topics_come_through_a_program_and_are_recorded_like_any_other_source() {
    let here = prepared("live-ros2");
    let path = format!("{}:{}", here.display(), std::env::var("PATH").unwrap());
    let mut child = start(&here, "touch", &path);
    let told = lines(child.stdout.take().unwrap());
    let said = lines(child.stderr.take().unwrap());
    let log = demo::sweep(1).unwrap().log;
    let folder = here.clone();
    let sending = std::thread::spawn(move || {
        // Opening waits for the reader.
        let open = |name: &str| std::fs::OpenOptions::new().write(true).open(folder.join(name)).unwrap();
        let (mut touch, mut odom) = (open("touch"), open("odom"));
        touch.write_all(b"t,w0.moment\n").unwrap();
        for (number, row) in log.rows.iter().enumerate() {
            let pose = row.odom_from_robot;
            odom.write_all(format!("{},{},{},{}\n", row.t, pose.x, pose.y, pose.theta).as_bytes()).unwrap();
            touch.write_all(format!("{},{}\n", row.t, row.readings[0]).as_bytes()).unwrap();
            // About as fast as the robot drove, so that no rows have to be merged.
            if number % 2 == 0 {
                std::thread::sleep(Duration::from_millis(6));
            }
        }
        // Open until the run has ended.
        (touch, odom)
    });
    let (mut last, mut status) = (f64::NEG_INFINITY, String::new());
    let end_of_log = demo::sweep(1).unwrap().log.rows.last().unwrap().t;
    while last < end_of_log - 0.2 {
        let line = told.recv_timeout(PATIENCE).unwrap_or_else(|_| {
            panic!("nothing after {last} s of {end_of_log} s; it said {:?}", said.try_iter().collect::<Vec<_>>())
        });
        let value: serde_json::Value = serde_json::from_str(&line).unwrap();
        last = value["t"].as_f64().unwrap();
        status = value["status"].as_str().unwrap().to_owned();
    }
    // On a busy machine the estimator may still have other places.
    assert!(["localized", "ambiguous"].contains(&status.as_str()), "{status}");
    let pipes = sending.join().unwrap();
    end(child);
    drop(pipes);
    let again = vibrissa(&["live", "--replay", here.join("out").to_str().unwrap()]);
    assert_eq!(again.code, Some(0), "{}", again.stderr);
    let counted = again.stdout.lines().find(|line| line.contains("the same to the byte")).unwrap_or_default();
    let numbers: Vec<&str> = counted.split_whitespace().filter(|word| word.parse::<u32>().is_ok()).collect();
    assert!(numbers.len() == 2 && numbers[0] == numbers[1] && numbers[0] != "0", "{} {}", again.stdout, again.stderr);
}

#[test]
fn faults_of_the_program_are_told_and_the_run_waits() {
    let here = prepared("live-ros2-faults");
    let path = format!("{}:{}", here.display(), std::env::var("PATH").unwrap());
    for (topic, path, words) in [
        ("other", path.as_str(), "vibrissa-ros2: no such topic: --lines joints other"),
        ("touch", "/nowhere", "cargo build --release --manifest-path ros2/Cargo.toml"),
    ] {
        let mut child = start(&here, topic, path);
        let said = lines(child.stderr.take().unwrap());
        loop {
            let line = said.recv_timeout(PATIENCE).unwrap_or_else(|_| panic!("{topic}: nobody said: {words}"));
            if line.starts_with("touch: ") && line.contains(words) {
                break;
            }
        }
        end(child);
    }
}
