//! `vibrissa sensor` through the real binary.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must fail")]

#[path = "common/mod.rs"]
mod common;

use common::{folder, vibrissa};

#[test]
fn a_design_is_told_in_words_as_json_and_drawn() {
    let out = folder("sensor-design");
    let ran = vibrissa(&["sensor", "design", "--distance", "5 mm", "--out", out.to_str().unwrap()]);
    assert_eq!(ran.code, Some(0), "{ran:?}");
    assert!(
        ran.stdout.contains("5.0 mm from the magnet") && ran.stdout.contains("sensor-design.svg"),
        "{}",
        ran.stdout
    );
    assert!(std::fs::read_to_string(out.join("sensor-design.svg")).unwrap().contains("1.86 uN m a count"));
    let json: serde_json::Value =
        serde_json::from_str(&vibrissa(&["sensor", "design", "--chip", "tle493d", "--json"]).stdout).unwrap();
    assert!(json["share"].as_f64().unwrap() < 0.1, "{json}");
}

/// A simulated head on a port, until `until` is set: it obeys, and sends what it reads under a moment of 3 mN m.
#[cfg(all(unix, feature = "live"))]
fn head_on(mut port: vibrissa_live::source::PseudoTerminal, until: &std::sync::atomic::AtomicBool) {
    let mut rehearsal = vibrissa_head::simulated::Rehearsal::new(300, 0.006);
    let (mut bytes, mut packet, mut slot) = ([0; 64], [0; vibrissa_head::LONGEST], 0);
    let mut send = |port: &mut vibrissa_live::source::PseudoTerminal, message: &vibrissa_head::frame::Message| {
        let length = message.write(&mut packet).unwrap();
        let _ = port.send(&packet[..length]);
    };
    while !until.load(std::sync::atomic::Ordering::Relaxed) {
        // Where nobody has the port open, what is sent would fill it, and the next one would wait.
        let Ok(count) = port.receive(&mut bytes, std::time::Duration::from_millis(2)) else {
            std::thread::sleep(std::time::Duration::from_millis(2));
            continue;
        };
        for byte in &bytes[..count] {
            if let Some(answer) = rehearsal.receive(*byte) {
                send(&mut port, &answer);
            }
        }
        if let Some(message) = rehearsal.slot(slot, 3e-3, false) {
            send(&mut port, &message);
        }
        slot += 1;
    }
}

#[cfg(all(unix, feature = "live"))]
#[test]
fn what_a_head_reads_is_told_with_its_scatter() {
    let terminal = vibrissa_live::source::PseudoTerminal::new().unwrap();
    let port = terminal.port().to_str().unwrap().to_owned();
    let until = std::sync::atomic::AtomicBool::new(false);
    let (words, json) = std::thread::scope(|scope| {
        scope.spawn(|| head_on(terminal, &until));
        let words = vibrissa(&["sensor", "head", &port, "--read", "200"]);
        let json = vibrissa(&["sensor", "head", &port, "--read", "200", "--unload", "--json"]);
        until.store(true, std::sync::atomic::Ordering::Relaxed);
        (words, json)
    });
    assert_eq!(words.code, Some(0), "{words:?}");
    assert!(
        words.stdout.contains("readings      200, 0 lost") && words.stdout.contains("bx,by,bz"),
        "{}",
        words.stdout
    );
    assert!(
        words.stdout.contains("moment        3.0") || words.stdout.contains("moment        2.9"),
        "{}",
        words.stdout
    );
    let json: serde_json::Value = serde_json::from_str(&json.stdout).unwrap();
    let chain = vibrissa::sensing::SensingChain::default();
    let readings = &json["readings"];
    for (axis, want) in chain.flux(3e-3).into_iter().enumerate() {
        let [mean, deviation] = ["flux", "flux_deviation"].map(|key| readings[key][axis].as_f64().unwrap());
        // The mean of 200 is known to a fourteenth of one, and a count is half a microtesla or less.
        let noise = vibrissa_head::simulated::NOISE;
        assert!((mean - want).abs() < 0.4 * noise, "{axis}: {mean} {want}");
        assert!((deviation / noise - 1.0).abs() < 0.25, "{axis}: {deviation}");
    }
    assert!(readings["moment"].is_null() && json["calibrated_axes"] == 0, "{json}");
}

/// The demo's sweep as a head sends it, with the faults of chip and bus; of an emulated processor where `HEAD_BYTES` names its file. On the wire
/// one packet in three hundred is gone and one in a hundred is garbled.
#[cfg(all(unix, feature = "live"))]
fn packets_with_losses(moments: &[f64]) -> Vec<Vec<u8>> {
    let mut rehearsal = vibrissa_head::simulated::Rehearsal::new(300, 0.006);
    let mut packet = [0; vibrissa_head::LONGEST];
    let mut told = Vec::new();
    for (slot, moment) in moments.iter().enumerate() {
        if let Some(message) = rehearsal.slot(slot, *moment, true) {
            let length = message.write(&mut packet).unwrap();
            told.extend_from_slice(&packet[..length]);
        }
    }
    let sent = std::env::var_os("HEAD_BYTES").map_or(told, |path| std::fs::read(path).unwrap());
    let mut packets: Vec<Vec<u8>> = sent.split_inclusive(|byte| *byte == 0).map(<[u8]>::to_vec).collect();
    for (k, packet) in packets.iter_mut().enumerate() {
        match k {
            k if k % 300 == 150 => packet.clear(),
            k if k % 100 == 50 => packet[k % 20] ^= 0x40,
            _ => {}
        }
    }
    packets
}

/// The command itself, from a serial port and a pipe to a pose, three times as fast as the robot was.
#[cfg(all(unix, feature = "live"))]
#[test]
fn packets_on_a_port_become_a_pose_of_a_live_run_and_losses_are_told() {
    use std::io::{BufRead, Write};
    let here = folder("sensor-live");
    let sweep = vibrissa::tasks::demo::sweep_at(1, 0.05).unwrap();
    let moment = sweep.log.channels.iter().position(|c| c.quantity.word() == "moment").unwrap();
    let rounded = |value: f64| (value * 1e9).round() * 1e-9;
    let moments: Vec<f64> = sweep.log.rows.iter().map(|row| rounded(row.readings[moment])).collect();
    let packets = packets_with_losses(&moments);
    let mut terminal = vibrissa_live::source::PseudoTerminal::new().unwrap();
    std::fs::write(here.join("map.svg"), vibrissa::tasks::demo::ARENA_SVG).unwrap();
    let noise = "noise = { moment_relative = 0.05, moment_absolute = \"0.11 mNm\" }";
    std::fs::write(here.join("robot.toml"), format!("[[whisker]]\n{noise}\n")).unwrap();
    let port = terminal.port().display();
    let setup = format!(
        "map = \"map.svg\"\nrobot = \"robot.toml\"\n[[source]]\nname = \"whisker\"\nserial = \"{port}\"\nformat = \"head\"\n\
         time = \"own\"\n[[source]]\nname = \"base\"\npipe = \"-\"\ntime = \"own\"\ncolumns = [\"t\", \"x\", \"y\", \"theta\"]\n"
    );
    std::fs::write(here.join("live.toml"), setup).unwrap();
    let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_vibrissa"))
        .arg("live")
        .arg(here.join("live.toml"))
        .arg("--out")
        .arg(here.join("out"))
        .stdin(std::process::Stdio::piped())
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::null())
        .spawn()
        .unwrap();
    let mut base = child.stdin.take().unwrap();
    let mut packets = packets.into_iter();
    for (slot, row) in sweep.log.rows.iter().enumerate() {
        let pose = row.odom_from_robot;
        writeln!(base, "{:.6},{:.7},{:.7},{:.8}", slot as f64 / 300.0, pose.x, pose.y, pose.theta).unwrap();
        if let Some(packet) = packets.next() {
            terminal.send(&packet).unwrap();
        }
        if slot % 30 == 0 {
            std::thread::sleep(std::time::Duration::from_millis(33));
        }
    }
    // What is under way arrives, and then a person ends the run.
    std::thread::sleep(std::time::Duration::from_millis(700));
    let id = child.id().to_string();
    assert!(std::process::Command::new("kill").args(["-INT", &id]).status().unwrap().success());
    let told: Vec<String> =
        std::io::BufReader::new(child.stdout.take().unwrap()).lines().map_while(Result::ok).collect();
    assert_eq!(child.wait().unwrap().code(), Some(0), "{told:?}");
    let words = told.join("\n");
    // A busy machine uses fewer of the rows, which leaves more open.
    assert!(words.starts_with("localized:") || words.starts_with("ambiguous"), "{words}");
    // Of 1541 slots, whatever the sum of what the head missed and what the wire lost.
    let count = |name: &str| -> u64 {
        let words: Vec<&str> = words.split_whitespace().collect();
        let at = words.iter().position(|word| word.trim_end_matches([',', '.', ';']) == name).unwrap();
        words[at - 1].parse().unwrap()
    };
    assert!(count("damaged") == 10 && count("lost") > 20 && count("saturated") > 0, "{words}");
    if let Some(place) = words.strip_prefix("localized: x ") {
        let numbers: Vec<f64> = place.split_whitespace().filter_map(|word| word.parse().ok()).collect();
        let truth = sweep.truth.last().unwrap().map_from_robot;
        let off = (1e-3 * numbers[0] - truth.x).hypot(1e-3 * numbers[1] - truth.y);
        println!("live run: off by {:.3} mm; {words}", 1e3 * off);
        assert!(off < 0.015, "off by {off} m: {words}");
    }
    let again = vibrissa(&["live", "--replay", here.join("out").to_str().unwrap()]);
    let verdict = |words: &str| words.split(|c: char| !c.is_alphabetic()).next().unwrap_or_default().to_owned();
    assert_eq!(verdict(&again.stdout), verdict(&words), "{}", again.stdout);
}

#[cfg(all(unix, feature = "live"))]
#[test]
fn heads_that_are_not_there_and_calibrations_that_do_not_fit_are_told() {
    let dir = folder("sensor-head");
    let file = dir.join("cal.json");
    std::fs::write(&file, r#"{"format": "vibrissa calibration", "version": 1}"#).unwrap();
    let cal = file.to_str().unwrap();
    let cases: [(&[&str], i32, &str); 6] = [
        (&["sensor", "head", "/dev/no-such-port"], 1, "cannot open the port"),
        (&["sensor", "head", "/dev/no-such-port", "--load", cal], 1, "does not turn readings into moments"),
        (&["sensor", "head", "/dev/no-such-port", "--load", "none.json"], 1, "none.json"),
        (&["sensor", "head", "/dev/no-such-port", "--tare", "0"], 2, "--tare"),
        (&["sensor", "head", "/dev/no-such-port", "--read", "1"], 2, "--read"),
        (&["sensor", "head", "/dev/no-such-port", "--load", cal, "--unload"], 2, "--unload"),
    ];
    for (args, code, words) in cases {
        let ran = vibrissa(args);
        assert_eq!(ran.code, Some(code), "{args:?}: {}", ran.stderr);
        assert!(ran.stderr.contains(words), "{args:?}: {}", ran.stderr);
    }
}
