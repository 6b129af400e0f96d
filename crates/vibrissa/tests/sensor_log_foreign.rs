//! Foreign logs: what each reader makes of a few lines, of damage, and of real recordings where they are at hand.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on must fail")]

#[path = "data/random.rs"]
mod random;
#[path = "data/shared.rs"]
mod shared;

use random::Random;
use shared::shared;
use std::path::PathBuf;
use vibrissa::io::log::foreign::{Format, Recording};

fn read(text: &str, format: Format) -> Recording {
    Recording::from_bytes(text.as_bytes(), format, "sample").unwrap()
}

fn near(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-9 * (1.0 + b.abs())
}

const SERIAL: &str = "MLX90393 ready\r\nrange 50 mT\r\n12.5,-3.0,40.0\r\n13.0,-3.5,41.0\r\nError: no reading\r\n14.0,-4.0,60000\r\n15.0,-4";

#[test]
fn serial_text_gets_time_from_its_rate_and_keeps_the_place_of_lost_lines() {
    let log = read(SERIAL, Format::Serial);
    assert_eq!(log.lines, [3, 4, 6]);
    // The error line took the place of a reading, so the third reading is three periods after the first.
    let expected = [0.0, 1.0 / 300.0, 3.0 / 300.0];
    assert!(log.t.iter().zip(expected).all(|(t, e)| near(*t, e)), "{:?}", log.t);
    assert!(near(log.column("bx").unwrap()[0], 12.5e-6) && near(log.column("bz").unwrap()[2], 60e-3));
    let repairs = log.repairs;
    assert_eq!((repairs.lines_dropped, repairs.last_line_cut, repairs.saturated, repairs.stamps_made), (4, 1, 1, 3));
    assert!(
        log.repairs.words().iter().any(|w| w == "lines without a reading, dropped: 4"),
        "{:?}",
        log.repairs.words()
    );
    assert!(log.to_log().unwrap_err().to_string().contains("odometry"));
}

#[test]
fn interleaved_sensors_are_told_apart_after_a_lost_line() {
    let mut text = String::from("two sensors\n");
    for i in 0..40 {
        let k = f64::from(i);
        // One line of the second sensor is swallowed whole: nothing stands in its place but a broken rest.
        text += &format!("{},{},{}\n", 100.0 + k, 5.0, 7.0);
        text += &if i == 20 { "-80\n".to_owned() } else { format!("{},{},{}\n", -80.0 - k, 1.0, 2.0) };
        if i == 30 {
            text += "overrun\n";
        }
    }
    let log = read(&text, Format::Serial2);
    assert!(log.column("1.bx").unwrap().iter().all(|b| *b >= 100e-6 - 1e-12));
    assert!(log.column("2.bx").unwrap().iter().all(|b| *b <= -80e-6 + 1e-12));
    assert_eq!(log.repairs.order_restored, 1);
    assert!(near(log.t[1] - log.t[0], 1.0 / 150.0));
    let mut quiet = log.clone();
    quiet.subtract_reference("1", "2").unwrap();
    assert!(near(quiet.column("1.bx").unwrap()[0], 180e-6));
    assert_eq!(quiet.repairs.reference_subtracted, log.lines.len());
    assert!(quiet.subtract_reference("1", "3").is_err());
}

#[test]
fn stamped_counts_lose_their_jitter_and_their_cut_line() {
    let mut text = String::from("timestamp,AX,AY\n");
    for i in 0..100u32 {
        let micros = 500_000 + i * 1250 + (i * 37 % 11) * 60;
        text += &format!("2024-04-17_11:48:11.{micros:06},{},32{:03}\n", 33_000 + i, i);
    }
    text += "2024-04-17_11:48:12.000000,330";
    let log = read(&text, Format::Ratatouille);
    assert_eq!((log.lines.len(), log.repairs.last_line_cut, log.repairs.stamps_smoothed), (100, 1, 100));
    let steps: Vec<f64> = log.t.windows(2).map(|w| w[1] - w[0]).collect();
    assert!(steps.iter().all(|s| (s - 1.25e-3).abs() < 2e-5 && (s - steps[0]).abs() < 1e-9), "{steps:?}");
    assert!(near(log.column("ay").unwrap()[99], 32_099.0));
    // Without the header the first line counts.
    let bare = read(text.split_once('\n').unwrap().1, Format::Ratatouille);
    assert_eq!(bare.lines.len(), 100);
}

#[test]
fn wrapped_counts_are_carried_on_in_both_directions() {
    let mut text = String::from("timestamp,ss.x,ss.y,ss.z,Dist,Bend\n");
    let path = [300.0, 100.0, -100.0, -300.0, -200.0, 50.0, 65_500.0, 65_900.0, 65_000.0];
    // A jump of half a turn or more cannot be told from a wrap, so the way up takes three steps.
    let path: Vec<f64> =
        path[..6].iter().copied().chain([20_000.0, 40_000.0, 60_000.0]).chain(path[6..].iter().copied()).collect();
    for (i, y) in path.iter().enumerate() {
        text += &format!("{}.5,25000,{},36000,5.96,2.15\n", 100 + i, y.rem_euclid(65_536.0));
    }
    let log = read(&text, Format::Openwhisker);
    assert_eq!(log.column("ay").unwrap(), path);
    assert_eq!(log.repairs.unwrapped, 4);
    assert!(near(log.column("dist").unwrap()[0], 5.96e-3) && near(log.column("bend").unwrap()[0], 2.15e-3));
    assert!(near(log.t[1], 1.0));
}

fn odometry(t: f64, x: f64, heading: f64) -> String {
    let (secs, nsecs) = (t.floor(), (t.fract() * 1e9).round());
    let (z, w) = ((0.5 * heading).sin(), (0.5 * heading).cos());
    format!(
        "header: \n  seq: 7\n  stamp: \n    secs: {secs}\n    nsecs: {nsecs:>9}\n  frame_id: \"odom\"\nchild_frame_id: ''\n\
         pose: \n  pose: \n    position: \n      x: {x}\n      y: -2.5\n      z: 0.0\n    orientation: \n      x: 0.0\n      y: 0.0\n      z: {z}\n      w: {w}\n\
         \x20 covariance: [0.1, 0.0,\n    0.0, 0.2]\ntwist: \n  twist: \n    linear: \n      x: 9.0\n      y: 9.0\n      z: 0.0\n---\n"
    )
}

fn wrench(t: f64, torque: f64) -> String {
    format!(
        "header:\n  stamp:\n    sec: {}\n    nanosec: {}\n  frame_id: base\nwrench:\n  force:\n    x: 0.0\n    y: 1.0\n    z: 0.0\n  torque:\n    x: 0.0\n    y: 0.0\n    z: {torque}\n---\n",
        t.floor(),
        (t.fract() * 1e9).round()
    )
}

#[test]
fn echoed_topics_are_merged_by_their_stamps() {
    let mut text = String::new();
    for i in 0..5 {
        text += &odometry(100.0 + f64::from(i), f64::from(i) * 0.1, 3.0 + 0.1 * f64::from(i));
    }
    for i in 0..9 {
        text += &wrench(100.25 + 0.5 * f64::from(i), 1e-3 * f64::from(i));
    }
    let recording = read(&text, Format::Rostopic);
    let log = recording.to_log().unwrap();
    // The last reading comes after the last odometry.
    assert_eq!(log.rows.len(), 8);
    assert_eq!(recording.repairs.interpolated, 8);
    for (i, row) in log.rows.iter().enumerate() {
        let t = 0.25 + 0.5 * i as f64;
        assert!((row.odom_from_robot.x - 0.1 * t).abs() < 1e-9 && (row.odom_from_robot.y + 2.5).abs() < 1e-12);
        let heading = 3.0 + 0.1 * t;
        assert!((vibrissa::plane::wrap_angle(row.odom_from_robot.theta - heading)).abs() < 1e-9);
        assert!((row.readings[0] - 1e-3 * i as f64).abs() < 1e-15 && (row.t - (t - 0.25)).abs() < 1e-6);
    }
    assert_eq!(log.channels[0].column(), "moment");
}

#[test]
fn magnetic_fields_are_tesla_and_an_unfinished_message_is_dropped() {
    let one = |t: u32, x: f64| {
        format!(
            "header: \n  stamp: \n    secs: {t}\n    nsecs: 0\nmagnetic_field: \n  x: {x}\n  y: 2.0e-05\n  z: 0.001\nmagnetic_field_covariance: [0.0, 0.0]\n---\n"
        )
    };
    let text = one(1, 1e-3) + &one(2, 2e-3) + &one(2, 9.0) + one(3, 3e-3).strip_suffix("---\n").unwrap();
    let recording = read(&text, Format::Rostopic);
    assert_eq!(recording.column("bx").unwrap(), [1e-3, 2e-3]);
    assert_eq!((recording.repairs.out_of_order, recording.repairs.last_line_cut), (1, 1));
}

#[test]
fn contours_are_read_from_text_and_from_echoes() {
    let text = read("# x, y\n0.53,0.05\n0.54, 0.06\nnonsense\n0.55,nan\n", Format::Contour);
    assert_eq!((text.column("x").unwrap(), text.column("y").unwrap()), (&[0.53, 0.54][..], &[0.05, 0.06][..]));
    assert_eq!(text.repairs.lines_dropped, 2);
    let echo = "header: \n  stamp: \n    secs: 5\n    nsecs: 0\ntwist: \n  linear: \n    x: 0.4\n    y: 0.1\n    z: 0.0\n---\n";
    let echoed = read(echo, Format::Contour);
    assert_eq!((echoed.column("x").unwrap(), echoed.column("y").unwrap()), (&[0.4][..], &[0.1][..]));
}

#[test]
fn a_wrong_format_is_told_and_not_guessed() {
    let error = Recording::from_bytes(SERIAL.as_bytes(), Format::Openwhisker, "serial.txt").unwrap_err();
    assert!(
        error.is_data() && error.to_string().contains("openwhisker") && error.to_string().contains("help:"),
        "{error}"
    );
    let error = "rostopik".parse::<Format>().unwrap_err();
    assert!(error.is_usage() && error.to_string().contains("did you mean `rostopic`?"), "{error}");
}

/// Cuts, flips, repeats and inserts bytes.
fn damaged(bytes: &[u8], random: &mut Random) -> Vec<u8> {
    let mut out = bytes.to_vec();
    let at = |random: &mut Random, n: usize| (random.unit() * n as f64) as usize;
    for _ in 0..=at(random, 6) {
        if out.is_empty() {
            break;
        }
        let place = at(random, out.len());
        match at(random, 6) {
            0 => out.truncate(place),
            1 => out[place] = at(random, 256) as u8,
            2 => drop(out.drain(place..(place + at(random, 60)).min(out.len()))),
            3 => drop(out.splice(place..place, vec![b"0123456789,.-:\n "[at(random, 16)]; at(random, 9000)])),
            4 => {
                let words: [&[u8]; 6] = [b"nan", b"inf,", b"1e999", b"\xff\xfe\n", b"---\n", b"65535,"];
                drop(out.splice(place..place, words[at(random, 6)].iter().copied()));
            }
            _ => {
                let end = (place + at(random, 80)).min(out.len());
                let piece = out[place..end].to_vec();
                drop(out.splice(place..place, piece));
            }
        }
    }
    out
}

#[test]
fn damage_never_makes_a_reader_panic_or_return_nonsense() {
    let mut two = String::new();
    let (mut stamped, mut counts) = (String::new(), String::from("timestamp,ss.x,ss.y,ss.z,Dist,Bend\n"));
    for i in 0..30 {
        two += &format!("{i},2,3\n-{i},5,6\n");
        stamped += &format!("2024-04-17_11:48:11.{:06},33000,32{i:03}\n", i * 1250);
        counts += &format!("{i}.5,25000,{},36000,5.96,2.15\n", (300 - 20 * i) & 0xffff);
    }
    let mixed: String = (0..4).map(|i| odometry(f64::from(i), 0.1, 0.2) + &wrench(f64::from(i), 1e-3)).collect();
    let samples = [
        (Format::Serial, SERIAL.to_owned()),
        (Format::Serial2, two),
        (Format::Ratatouille, stamped),
        (Format::Openwhisker, counts),
        (Format::Rostopic, mixed),
        (Format::Contour, "# x\n0.1,0.2\n0.3,0.4\n".to_owned()),
    ];
    let mut random = Random(20);
    for (format, text) in &samples {
        let mut read = 0;
        for _ in 0..400 {
            let bytes = damaged(text.as_bytes(), &mut random);
            let Ok(recording) = Recording::from_bytes(&bytes, *format, "damaged") else { continue };
            read += 1;
            let rows = recording.lines.len();
            assert!(rows > 0 && (recording.t.len() == rows || recording.t.is_empty()), "{format:?}");
            assert!(recording.series.iter().all(|s| s.values.len() == rows && s.values.iter().all(|v| v.is_finite())));
            assert!(recording.t.windows(2).all(|w| w[1] >= w[0]), "{format:?} {:?}", recording.t);
            let _ = recording.to_log();
        }
        assert!(read > 100, "{format:?}: only {read} of 400 were readable");
    }
}

fn data(path: &str) -> Option<PathBuf> {
    shared(&format!("data/{path}"))
}

#[test]
fn real_recordings_are_read_whole() {
    // Rows and dropped lines, counted with `wc` and `awk`.
    let cases = [
        ("ratatouille/deflection_165.csv", Format::Ratatouille, 35_454, 0),
        ("ratatouille/deflection_65.csv", Format::Ratatouille, 44_818, 1),
        ("openwhisker/staircase.csv", Format::Openwhisker, 55_257, 0),
        ("contours/circle-3.txt", Format::Contour, 5635, 0),
        ("contours/circle-0-8-tip.yaml", Format::Contour, 5391, 0),
    ];
    for (name, format, rows, dropped) in cases {
        let Some(path) = data(name) else { return };
        let recording = Recording::read(&path, format).unwrap();
        println!("{name}: {} rows, {:?} Hz, {:?}", recording.lines.len(), recording.rate(), recording.repairs);
        assert_eq!((recording.lines.len(), recording.repairs.lines_dropped), (rows, dropped), "{name}");
    }
    let Some(path) = data("openwhisker/staircase.csv") else { return };
    let rig = Recording::read(path, Format::Openwhisker).unwrap();
    let y = rig.column("ay").unwrap();
    assert!(rig.repairs.unwrapped == 5 && y.windows(2).all(|w| (w[1] - w[0]).abs() < 32_768.0));
}
