//! Whole runs: pseudo-terminals fed by the simulator, files, cables that are pulled out.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::float_cmp,
    reason = "a test that cannot go on must fail"
)]
#![cfg(unix)]

mod common;

use common::{checked, demo_world, folder};
use core::ops::ControlFlow;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};
use vibrissa::flow::pose::Status;
use vibrissa::flow::sensor_log::LogRow;
use vibrissa::io::log::to_csv;
use vibrissa::localizer::{Method, ProbabilisticEstimator};
use vibrissa::plane::Pose2;
use vibrissa::sim::{Scenario, SweepNoise, simulate_tip_sweep};
use vibrissa::tasks::demo;
use vibrissa::world::{MountedWhisker, Odometry, Robot};
use vibrissa::{Localizer, Map};
use vibrissa_live::estimate::LiveEstimator;
use vibrissa_live::join::JoinedRow;
use vibrissa_live::journal::{self, Journal};
use vibrissa_live::record::FileStorage;
use vibrissa_live::replay::{Pace, Played, replay};
use vibrissa_live::robot::SimulatedRobot;
use vibrissa_live::run::{Finished, Update, run};
use vibrissa_live::setup::{Setup, from_toml, read};
use vibrissa_live::source::{Arrived, PseudoTerminal};

/// Runs a setup into a recording until `is_over`; the lines that it told and how it ended.
fn recorded(
    setup: &Setup,
    map: &Map,
    robot: &Robot,
    out: &Path,
    mut is_over: impl FnMut(&Update<'_>) -> bool,
) -> (Vec<String>, Finished) {
    let (storage, _) = FileStorage::create(out, "recording").unwrap();
    let journal = Journal::begin(storage, setup, out, 1.7e9);
    let mut lines = Vec::new();
    let finished = run(setup, Some(map), robot, Some(&journal), &mut |update| {
        if let Update::Estimate(told, _) = &update {
            lines.push(told.line.clone());
        }
        if is_over(&update) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    })
    .unwrap();
    journal.finish().unwrap();
    (lines, finished)
}

/// The lines of a recording that is run again.
fn again(out: &Path, map: &Map, robot: &Robot) -> (Vec<String>, u64) {
    let recorded = journal::read(out).unwrap();
    let mut lines = Vec::new();
    let replayed = replay(&recorded, &recorded.setup, map, robot, Pace::default(), &mut |played| {
        if let Played::Estimate(told) = played {
            lines.push(told.line.clone());
        }
        ControlFlow::Continue(())
    })
    .unwrap();
    assert_eq!(recorded.lines.len(), lines.len());
    (lines, replayed.missing)
}

/// A row as it comes from the join.
fn joined(row: &LogRow) -> JoinedRow {
    JoinedRow { row: row.clone(), arrival: 0.0, travel: [0.0; 2] }
}

#[test]
fn a_log_through_a_pipe_gives_the_bytes_of_the_same_rows_offline() {
    let (map, log) = demo_world();
    let out = folder("pipe");
    std::fs::write(out.join("log.csv"), to_csv(&log)).unwrap();
    for method in Method::all() {
        let text = format!("map = \"none.svg\"\nmethod = \"{}\"\n[[source]]\npipe = \"log.csv\"\n", method.name());
        let mut setup = from_toml(&text, "live.toml").unwrap();
        setup.based_on(&out);
        let (robot, here) = (Robot::default(), out.join(method.name()));
        let (lines, finished) = recorded(&setup, &map, &robot, &here, |_| false);
        assert_eq!((finished.health.rows, finished.health.merged), (log.rows.len() as u64, 0));
        let mut offline = LiveEstimator::new(&map, &robot, &log.channels, &method, setup.estimate_rate).unwrap();
        let want: Vec<String> =
            log.rows.iter().filter_map(|row| offline.step(&joined(row)).unwrap()).map(|told| told.line).collect();
        assert_eq!(lines, want, "{method}");
        assert_eq!(again(&here, &map, &robot), (want, 0), "{method}");
        // The recording is a log, too, with the rows as they were taken.
        let read = vibrissa::read_log(here.join("recording.mcap")).unwrap();
        assert_eq!(read.channels, log.channels);
        for (read, row) in read.rows.iter().zip(&log.rows) {
            assert_eq!((read.t, read.odom_from_robot, &read.readings), (row.t, row.odom_from_robot, &row.readings));
        }
        let answer = match method {
            Method::Probabilistic(options) => {
                let estimator = ProbabilisticEstimator::new(&map, &robot, &log.channels, options).unwrap();
                let mut localizer = Localizer::by(estimator.without_record());
                log.rows.iter().for_each(|row| localizer.step(row).unwrap());
                localizer.finish()
            }
            other => vibrissa::localize(&log, &map, &robot, &other, &mut |_| {}).unwrap(),
        };
        let live = finished.answer.unwrap();
        assert_eq!((live.status, live.estimate), (answer.status, answer.estimate), "{method}");
    }
}

/// A log, and the log that a scenario makes: played at a speed they bring the bytes that they are, and their run can be run again.
#[test]
fn logs_and_scenarios_are_played_at_a_speed() {
    let (map, log) = demo_world();
    let out = folder("played");
    std::fs::write(out.join("map.svg"), demo::ARENA_SVG).unwrap();
    std::fs::write(out.join("log.csv"), to_csv(&log)).unwrap();
    let scenario = "map = \"map.svg\"\n[[whisker]]\nmount = [0, 0, \"128 deg\"]\n[path]\nstart = [\"160 mm\", \"172 mm\", 0]\n\
                    [[path.leg]]\nkind = \"line\"\nto = [\"200 mm\", \"192 mm\"]\nheading = 0\n";
    std::fs::write(out.join("drive.toml"), scenario).unwrap();
    let driven = Scenario::read(out.join("drive.toml")).unwrap().simulate().unwrap().recording.log;
    let robot = Robot {
        whiskers: vec![MountedWhisker { robot_from_whisker: Pose2::new(0.0, 0.0, 2.2), ..MountedWhisker::default() }],
        ..Robot::default()
    };
    for (key, file, log, robot) in
        [("recording", "log.csv", &log, &Robot::default()), ("simulated", "drive.toml", &driven, &robot)]
    {
        let path = out.join("live.toml");
        std::fs::write(&path, format!("map = \"map.svg\"\n[[source]]\n{key} = \"{file}\"\nspeed = 4\n")).unwrap();
        let setup = read(&path).unwrap();
        let began = Instant::now();
        let here = out.join(key);
        let (lines, finished) = recorded(&setup, &map, robot, &here, |_| false);
        let long = log.rows[log.rows.len() - 1].t - log.rows[0].t;
        assert!(began.elapsed().as_secs_f64() >= long / 4.0, "{key}: {:?} for {long} s", began.elapsed());
        assert_eq!(finished.health.rows + finished.health.merged, log.rows.len() as u64, "{key}");
        let mut bytes = Vec::new();
        journal::chunks(&journal::read(&here).unwrap(), |chunk| {
            if let Arrived::Bytes(raw) = chunk.what {
                bytes.extend(raw);
            }
            Ok(())
        })
        .unwrap();
        assert_eq!(String::from_utf8(bytes).unwrap(), to_csv(log), "{key}");
        assert_eq!(again(&here, &map, robot), (lines, 0), "{key}");
    }
}

#[test]
fn a_simulated_robot_behind_pseudo_terminals_is_found_and_found_again() {
    let (map, _) = demo_world();
    // A third of the sweep's own speed: five seconds.
    let sweep = demo::sweep_at(1, 0.05).unwrap();
    let out = folder("robot");
    let robot_file = SimulatedRobot::write_files(&out).unwrap();
    let robot = vibrissa::read_robot(&robot_file).unwrap();
    let device = SimulatedRobot::new().unwrap();
    let setup = from_toml(&device.setup(Some(Path::new("none.svg")), &robot_file), "live.toml").unwrap();
    let driving = device.drive(sweep.log.clone()).unwrap();
    let (lines, finished) = recorded(&setup, &map, &robot, &out.join("live"), |update| {
        driving.is_finished() && matches!(update, Update::Idle(_))
    });
    assert_eq!(finished.estimate.status, Status::Localized);
    let truth = sweep.truth.last().unwrap().map_from_robot;
    let off = finished.estimate.pose().unwrap().position().distance(truth.position());
    assert!(off < 5e-3, "off by {off} m");
    let (again, missing) = again(&out.join("live"), &map, &robot);
    assert_eq!((again == lines, missing), (true, 0), "{} lines then, {} now", lines.len(), again.len());
}

/// Four whiskers at 300 Hz from the first touch on: the search of the map takes longer than rows wait. What was told meanwhile, and
/// from which estimate odometry carried it on, comes out of the recording again.
#[test]
fn what_was_carried_on_while_the_map_was_searched_comes_out_again() {
    let map = demo::arena().unwrap();
    let out = folder("carried");
    let whisker = |i: u32| MountedWhisker {
        name: format!("w{i}"),
        robot_from_whisker: Pose2::new(0.0, 0.0, 0.03 * f64::from(i)),
        ..MountedWhisker::default()
    };
    let odometry = Odometry { translation_relative: 0.02, ..Odometry::default() };
    let robot = Robot { whiskers: (0..4).map(whisker).collect(), odometry, ..Robot::default() };
    let log = simulate_tip_sweep(&map, &robot, &demo::path().unwrap(), &SweepNoise::seeded(3)).unwrap().log;
    let mut terminal = PseudoTerminal::new().unwrap();
    let columns: Vec<String> = log.channels.iter().map(|channel| format!("\"{}\"", channel.column())).collect();
    let text = format!(
        "map = \"none.svg\"\n[[source]]\nserial = \"{}\"\ntime = \"own\"\ncolumns = [\"t\", \"x\", \"y\", \"theta\", {}]\n",
        terminal.port().display(),
        columns.join(", ")
    );
    let setup = from_toml(&text, "live.toml").unwrap();
    let (rows, done) = (log.rows.clone(), AtomicU64::new(0));
    let (lines, finished) = std::thread::scope(|scope| {
        scope.spawn(|| {
            for row in &rows {
                let pose = row.odom_from_robot;
                let readings: Vec<String> = row.readings.iter().map(|moment| format!("{moment:e}")).collect();
                let line = format!("{},{},{},{},{}\n", row.t, pose.x, pose.y, pose.theta, readings.join(","));
                terminal.send(line.as_bytes()).unwrap();
                std::thread::sleep(Duration::from_millis(3));
            }
            std::thread::sleep(Duration::from_millis(500));
            done.store(1, Ordering::SeqCst);
        });
        recorded(&setup, &map, &robot, &out, |update| {
            done.load(Ordering::SeqCst) > 0 && matches!(update, Update::Idle(_))
        })
    });
    let health = &finished.health;
    // The line during which the port was opened counts as torn.
    let torn = health.sources[0].1.torn;
    assert!(torn <= 1 && health.rows + health.merged + torn >= rows.len() as u64, "{health:?}");
    assert_eq!(health.latency.count(), health.rows + health.merged);
    let told = journal::read(&out).unwrap().told;
    assert!(told.windows(2).all(|pair| pair[0].0 < pair[1].0 && pair[0].1 <= pair[1].1), "{told:?}");
    assert!(told.iter().all(|(row, from)| from <= row));
    let carried = told.iter().filter(|(row, from)| from < row).count();
    assert_eq!(lines.iter().filter(|line| line.contains("\"carried\":")).count(), carried);
    let (again, missing) = again(&out, &map, &robot);
    assert_eq!((again == lines, missing), (true, 0), "{carried} of {} carried on", lines.len());
}

#[test]
fn a_cable_that_is_pulled_out_is_waited_for() {
    let (map, log) = demo_world();
    let out = folder("cable");
    let port = out.join("port");
    let text = "map = \"none.svg\"\n[[source]]\nname = \"both\"\nserial = \"port\"\n\
                columns = [\"seq16\", \"t\", \"x\", \"y\", \"theta\", \"moment\"]\n";
    let mut setup = from_toml(text, "live.toml").unwrap();
    setup.based_on(&out);
    let (opened, read) = (AtomicU64::new(0), AtomicU64::new(0));
    let rows: Vec<String> = log
        .rows
        .iter()
        .enumerate()
        .map(|(i, row)| {
            let pose = row.odom_from_robot;
            checked(&format!("{},{},{},{},{},{}", i + 65_400, row.t, pose.x, pose.y, pose.theta, row.readings[0]))
        })
        .collect();
    let parts = rows.len() / 3;
    let is_done = std::sync::atomic::AtomicBool::new(false);
    let finished = std::thread::scope(|scope| {
        scope.spawn(|| {
            let mut sent = 0;
            for part in rows.chunks(parts) {
                let before = opened.load(Ordering::SeqCst);
                let mut terminal = PseudoTerminal::new().unwrap();
                let _ = std::fs::remove_file(&port);
                std::os::unix::fs::symlink(terminal.port(), &port).unwrap();
                while opened.load(Ordering::SeqCst) == before {
                    std::thread::sleep(Duration::from_millis(5));
                }
                // The first line of a port that is opened may be torn.
                terminal.send(b"9,4,2\r\n").unwrap();
                for line in part {
                    terminal.send(line.as_bytes()).unwrap();
                    std::thread::sleep(Duration::from_micros(500));
                }
                // In the middle of a line; and not before the rest was read, however long this machine takes.
                terminal.send(b"65,0.1").unwrap();
                sent += part.len() as u64;
                for _ in 0..6000 {
                    if read.load(Ordering::SeqCst) < sent {
                        std::thread::sleep(Duration::from_millis(10));
                    }
                }
                std::thread::sleep(Duration::from_millis(300));
            }
            is_done.store(true, Ordering::SeqCst);
        });
        let mut gone = 0;
        recorded(&setup, &map, &Robot::default(), &out.join("live"), |update| {
            if let Update::Estimate(_, health) | Update::Idle(health) = update {
                read.store(health.sources.first().map_or(0, |(_, counts)| counts.frames), Ordering::SeqCst);
            }
            if let Update::Notice(notice) = update {
                opened.fetch_add(u64::from(notice.text == "open"), Ordering::SeqCst);
                gone += u64::from(!notice.text.starts_with("open") && !notice.text.starts_with("cannot"));
            }
            is_done.load(Ordering::SeqCst) && gone >= 3
        })
    });
    let (lines, finished) = finished;
    let counts = finished.health.sources[0].1;
    assert!(counts.gone >= 3 && counts.torn >= 3, "{counts:?}");
    assert_eq!((counts.frames, counts.lost, counts.damaged), (rows.len() as u64, 0, 0), "{counts:?}");
    assert_eq!(finished.health.rows + finished.health.merged, rows.len() as u64);
    assert!(!matches!(finished.estimate.status, Status::Inconsistent | Status::NoContact));
    assert_eq!(again(&out.join("live"), &map, &Robot::default()), (lines, 0));
}

#[test]
fn devices_that_talk_nonsense_are_told_of_and_nothing_ends() {
    let (map, _) = demo_world();
    let out = folder("nonsense");
    let mut noise = Vec::new();
    for i in 0..4000_u32 {
        noise.extend([(i * 37 % 251) as u8, b'\n']);
    }
    std::fs::write(out.join("noise"), noise).unwrap();
    std::fs::write(out.join("zeros"), "0.00,0.00,0.00\r\n".repeat(400)).unwrap();
    let base: String = (0..50).map(|i| format!("{},0,0,0\n", 0.01 * f64::from(i))).collect();
    std::fs::write(out.join("base"), base).unwrap();
    let text = "map = \"none.svg\"\n[[source]]\nname = \"noise\"\npipe = \"noise\"\nformat = \"serial\"\nwhisker = \"a\"\n\
                [[source]]\nname = \"zeros\"\npipe = \"zeros\"\nformat = \"serial\"\nwhisker = \"b\"\n\
                [[source]]\nname = \"base\"\npipe = \"base\"\ncolumns = [\"t\", \"x\", \"y\", \"theta\"]\n";
    let mut setup = from_toml(text, "live.toml").unwrap();
    setup.based_on(&out);
    let robot_text = "[[whisker]]\nname = \"a\"\ncalibration = \"cal.json\"\n[[whisker]]\nname = \"b\"\ncalibration = \"cal.json\"\n";
    std::fs::write(out.join("cal.json"), SimulatedRobot::calibration()).unwrap();
    std::fs::write(out.join("robot.toml"), robot_text).unwrap();
    let robot = vibrissa::read_robot(out.join("robot.toml")).unwrap();
    let mut notices = Vec::new();
    recorded(&setup, &map, &robot, &out.join("live"), |update| {
        if let Update::Notice(notice) = update {
            notices.push(format!("{}: {}", notice.source, notice.text));
        }
        false
    });
    let said = notices.join("\n");
    assert!(said.contains("noise: ") && said.contains("check baud rate and format"), "{said}");
    assert!(said.contains("zeros: 300 readings on end are all zero"), "{said}");
}
