//! Recordings with ROS 2 messages: those that other programs wrote, and our own on the way back.

#![cfg(feature = "mcap")]
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must fail")]

use std::path::PathBuf;
use vibrissa::flow::pose::Status;
use vibrissa::flow::sensor_log::{Channel, Quantity};
use vibrissa::io::log::{ImuTopics, from_mcap_with};
use vibrissa::io::recording::{StatesWatch, localization_mcap};
use vibrissa::io::ros::{
    BagWriter, Header, ImuReading, Kind, Stamp, decode_field, decode_pose, encode_field, encode_imu, encode_odometry,
    encode_wrench, read_bag,
};
use vibrissa::plane::{Pose2, Twist2, Vec2, wrap_angle};
use vibrissa::sim::recording::sweep_mcap;
use vibrissa::tasks::{demo, localize_watched};
use vibrissa::world::Robot;
use vibrissa::{Method, localize};

fn file(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/data/mcap").join(name)
}

/// The four files hold the same messages, serialised by rosbags; see `validation/interchange`.
#[test]
fn recordings_of_other_programs_are_read_plain_and_compressed() {
    for name in ["none.mcap", "lz4.mcap", "zstd.mcap", "rosbags.mcap"] {
        let log = vibrissa::read_log(file(name)).unwrap();
        assert_eq!(log.warnings.iter().filter(|w| !w.starts_with("read but")).count(), 0, "{:?}", log.warnings);
        let columns: Vec<String> = log.channels.iter().map(Channel::column).collect();
        assert_eq!(columns, ["left.moment", "right.bx", "right.by", "right.bz"], "{name}");
        assert_eq!(log.rows.len(), 21);
        for (i, row) in log.rows.iter().enumerate() {
            let (t, k) = (0.01 * i as f64, i as f64);
            assert!((row.t - 1.7e9 - t).abs() < 3e-7, "{name} {i}: {}", row.t);
            let pose = row.odom_from_robot;
            let off = [pose.x - (0.1 + 0.05 * t), pose.y - (-0.2 + 0.02 * t), wrap_angle(pose.theta - 3.1 - 0.5 * t)];
            // Every other pose is between two messages of odometry.
            assert!(off.iter().all(|off| off.abs() < if i % 2 == 0 { 1e-12 } else { 2e-6 }), "{name} {i}: {off:?}");
            let want = [1e-3 * (7.0 * t).sin(), 1e-5 * k, -2e-5 * k, 4e-5];
            assert!(row.readings.iter().zip(want).all(|(got, want)| (got - want).abs() < 1e-15), "{:?}", row.readings);
        }
    }
}

#[test]
fn a_folder_around_one_recording_stands_for_it() {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("bag_folder");
    std::fs::create_dir_all(&folder).unwrap();
    let _ = std::fs::remove_file(folder.join("b.mcap"));
    std::fs::copy(file("lz4.mcap"), folder.join("a.mcap")).unwrap();
    std::fs::write(folder.join("metadata.yaml"), "rosbag2_bagfile_information:").unwrap();
    assert_eq!(vibrissa::read_log(&folder).unwrap().rows, vibrissa::read_log(file("lz4.mcap")).unwrap().rows);
    std::fs::copy(file("lz4.mcap"), folder.join("b.mcap")).unwrap();
    assert!(vibrissa::read_log(&folder).unwrap_err().to_string().contains("it is a folder"));
}

#[test]
fn a_cut_recording_is_read_up_to_the_cut_and_a_damaged_one_is_refused() {
    let whole = std::fs::read(file("none.mcap")).unwrap();
    let cut = vibrissa::io::log::from_mcap(&whole[..whole.len() / 2], "cut.mcap").unwrap();
    assert!(cut.rows.len() > 3 && cut.rows.len() < 21, "{}", cut.rows.len());
    assert!(cut.warnings.iter().any(|w| w.contains("ends in the middle")), "{:?}", cut.warnings);
    let mut damaged = std::fs::read(file("zstd.mcap")).unwrap();
    let middle = damaged.len() / 3;
    damaged[middle..middle + 40].fill(0x55);
    // One bit of a reading: only the checksum tells.
    let mut flipped = std::fs::read(file("none.mcap")).unwrap();
    let place = flipped.windows(8).position(|w| w == 4e-5f64.to_le_bytes()).unwrap();
    flipped[place] ^= 1;
    for (bytes, word) in [
        (damaged.as_slice(), "damaged"),
        (&flipped, "checksum"),
        (b"t,x,y,theta,moment\n", "not an MCAP recording"),
        (b"", "no topics"),
    ] {
        let error = vibrissa::io::log::from_mcap(bytes, "log.mcap").unwrap_err().to_string();
        println!("{error}\n");
        assert!(error.starts_with("log.mcap: ") && error.contains(word) && error.contains("help:"), "{error}");
    }
}

/// A recording made by hand.
fn made(odometry: &[(&str, f64, Pose2)], wrenches: &[(&str, f64, f64)]) -> Vec<u8> {
    let mut bag = BagWriter::default();
    let mut topics = std::collections::BTreeMap::new();
    for &(name, t, pose) in odometry {
        let topic = *topics.entry(name).or_insert_with(|| bag.topic(name, Kind::Odometry, false));
        let header = Header { stamp: Stamp::from_seconds(t), frame: "odom" };
        bag.push(topic, header.stamp, encode_odometry(header, "base_link", pose));
    }
    for &(name, t, moment) in wrenches {
        let topic = *topics.entry(name).or_insert_with(|| bag.topic(name, Kind::Wrench, false));
        let header = Header { stamp: Stamp::from_seconds(t), frame: "base" };
        bag.push(topic, header.stamp, encode_wrench(header, moment));
    }
    bag.finish().unwrap()
}

#[test]
fn readings_outside_the_odometry_are_left_out_and_gaps_are_told() {
    let pose = |x: f64| Pose2::new(x, 0.0, 0.0);
    let odometry = [("/odom", 1.0, pose(0.0)), ("/odom", 1.1, pose(0.1)), ("/odom", 2.1, pose(0.2))];
    let wrenches: Vec<_> = (0..30).map(|k| ("/whisker/wrench", 0.9 + 0.05 * f64::from(k), 1e-4)).collect();
    let log = vibrissa::io::log::from_mcap(made(&odometry, &wrenches).as_slice(), "log.mcap").unwrap();
    assert_eq!(log.channels, [Channel { whisker: String::new(), quantity: Quantity::Moment }]);
    // 0.9 and 0.95 are before the odometry, 2.15 to 2.35 after it.
    assert_eq!(log.rows.len(), 23);
    assert!(
        (log.rows[1].odom_from_robot.x - 0.05).abs() < 1e-6 && (log.rows[0].t - 1.0).abs() < 1e-12,
        "{:?}",
        log.rows[1]
    );
    let told = log.warnings.join("\n");
    println!("{told}");
    assert!(told.contains("7 readings left out") && told.contains("gaps of more than 0.25 s"), "{told}");
}

#[test]
fn what_is_missing_or_twofold_is_told_with_the_topics() {
    let still = Pose2::IDENTITY;
    let two = [("/a/odom", 1.0, still), ("/b/odom", 1.0, still), ("/a/odom", 2.0, still)];
    let wrench = [("/whisker/wrench", 1.5, 1e-4)];
    for (bytes, words) in [
        (made(&two, &wrench), vec!["several topics of odometry", "/a/odom, /b/odom"]),
        (made(&[], &wrench), vec!["no odometry", "/whisker/wrench (geometry_msgs/msg/WrenchStamped)"]),
        (made(&two[..1], &[]), vec!["no readings", "/a/odom (nav_msgs/msg/Odometry)"]),
        (made(&two[..1], &wrench), vec!["share no time", "odometry 1 to 1 s"]),
        (
            made(&[("/odom", 1.0, still)], &[("/x/wrench", 1.0, 0.0), ("/y/x/wrench", 1.0, 0.0)]),
            vec!["two topics tell of the same whisker", "x.moment"],
        ),
        (made(&[("/odom", 1.0, Pose2::new(1e9, 0.0, 0.0))], &[("/wrench", 1.0, 0.0)]), vec!["out of range", "1e9"]),
    ] {
        let error = vibrissa::io::log::from_mcap(bytes.as_slice(), "log.mcap").unwrap_err().to_string();
        println!("{error}\n");
        assert!(error.starts_with("log.mcap: ") && error.contains("help:"), "{error}");
        assert!(words.iter().all(|word| error.contains(word)), "{error}");
    }
}

#[test]
fn flux_and_stamps_go_there_and_back_whatever_their_sign() {
    for t in [0.0, 1e-9, 0.999_999_999_6, 12.345_678_912, 1_700_000_000.25, -3.5] {
        let stamp = Stamp::from_seconds(t);
        assert!(
            stamp.nanosec < 1_000_000_000 && (stamp.seconds() - t).abs() < 1e-9 + 3e-16 * t.abs(),
            "{t}: {stamp:?}"
        );
    }
    let header = Header { stamp: Stamp { sec: 5, nanosec: 7 }, frame: "chip" };
    let flux = [1e-6, -2e-5, f64::MIN_POSITIVE];
    let bytes = encode_field(header, flux);
    let (again, read) = decode_field(&bytes).unwrap();
    assert_eq!((again, read), (header, flux));
}

#[test]
fn the_demos_recording_localizes_as_its_log_does_on_its_map_and_on_its_cells() {
    let (map, robot, sweep) = (demo::arena().unwrap(), Robot::default(), demo::sweep(1).unwrap());
    let bytes = sweep_mcap(&map, &robot, &sweep, &sweep.log).unwrap();
    assert_eq!(bytes, sweep_mcap(&map, &robot, &sweep, &sweep.log).unwrap(), "the same bytes");
    println!("{} rows, {} bytes", sweep.log.rows.len(), bytes.len());
    let log = vibrissa::io::log::from_mcap(bytes.as_slice(), "log.mcap").unwrap();
    assert_eq!(log.rows.len(), sweep.log.rows.len());
    let worst = log.rows.iter().zip(&sweep.log.rows).map(|(a, b)| {
        let off = a.odom_from_robot.position().distance(b.odom_from_robot.position());
        off.max((a.t - b.t).abs()).max((a.readings[0] - b.readings[0]).abs())
    });
    assert!(worst.fold(0.0, f64::max) < 1e-9);

    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR"));
    let path = folder.join("demo.mcap");
    std::fs::write(&path, &bytes).unwrap();
    let cells = vibrissa::read_map(&path).unwrap();
    let misses: Vec<f64> = map.samples(1e-3).iter().map(|s| cells.nearest(s.position).unwrap().distance).collect();
    let (mean, largest) =
        (misses.iter().sum::<f64>() / misses.len() as f64, misses.iter().fold(0.0, |a: f64, &b| a.max(b)));
    println!("cells of 1 mm: the boundary is {:.4} mm off on average, {:.4} mm at most", mean * 1e3, largest * 1e3);
    assert!(mean < 0.05e-3 && largest < 1.0e-3);

    let truth = sweep.truth.last().unwrap().map_from_robot;
    let options = Method::Deterministic(Default::default());
    for map in [&map, &cells] {
        let answer = localize(&log, map, &robot, &options, &mut |_| {}).unwrap();
        let found = answer.estimate.unwrap();
        let error = found.position().distance(truth.position());
        println!(
            "{:?}: {:.3} mm, {:.3} deg",
            answer.status,
            error * 1e3,
            wrap_angle(found.theta - truth.theta).to_degrees()
        );
        assert!(answer.status == Status::Localized && error < 1e-3, "{error}");
    }
}

#[test]
fn a_localizations_recording_holds_its_poses_and_a_shrinking_set() {
    let (map, robot, sweep) = (demo::arena().unwrap(), Robot::default(), demo::sweep(1).unwrap());
    let mut watch = StatesWatch::new(sweep.log.rows.len());
    let options = Method::Deterministic(Default::default());
    let answer = localize_watched(&sweep.log, &map, &robot, &options, &mut |row, states| {
        watch.look(row, sweep.log.rows[row].t, states);
        core::ops::ControlFlow::Continue(())
    })
    .unwrap();
    let states = watch.finish();
    let counts: Vec<usize> = states.iter().map(|s| s.states.len()).collect();
    println!("{counts:?}");
    assert!(counts.len() > 30 && counts[0] > 20 * counts[counts.len() - 1]);
    let truth = sweep.truth.as_slice();
    let bytes = localization_mcap(&sweep.log, &map, &answer, &states, Some(truth)).unwrap();
    println!("{} bytes", bytes.len());
    assert!(bytes.len() < 4_000_000, "{}", bytes.len());
    std::fs::write(PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("localization.mcap"), &bytes).unwrap();
    let mut poses: Vec<(f64, Vec2)> = Vec::new();
    let mut logged = 0;
    let bag = read_bag(bytes.as_slice(), "localization.mcap", |topic, time, message| {
        assert!(time >= logged, "{}: time runs backwards", topic.name);
        logged = time;
        if topic.kind == Some(Kind::PoseWithCovariance) {
            let (header, pose) = decode_pose(message).unwrap();
            poses.push((header.stamp.seconds(), pose.position()));
        }
        Ok(())
    })
    .unwrap();
    assert!(bag.warnings.is_empty() && bag.topics.len() > 10, "{:?}", bag.topics);
    assert!(poses.len() > 100);
    for (t, position) in &poses {
        let near = answer.trajectory.iter().find(|p| (p.t - t).abs() < 1e-9).unwrap();
        assert!(near.map_from_robot.position().distance(*position) < 1e-12);
    }
}

/// A drive at constant speed with a turn that comes and goes, by Euler's steps of 0.1 ms, every hundredth of a second.
fn winding() -> Vec<(f64, Pose2, f64)> {
    let rate = |t: f64| 0.6 + 0.9 * (2.0 * t).sin();
    let (mut pose, mut rows) = (Pose2::new(0.3, -0.1, 3.0), Vec::new());
    for k in 0..=30_000 {
        let t = 1e-4 * f64::from(k);
        if k % 100 == 0 {
            rows.push((100.0 + t, pose, rate(t)));
        }
        let (sin, cos) = pose.theta.sin_cos();
        pose = Pose2::new(pose.x + 2e-5 * cos, pose.y + 2e-5 * sin, wrap_angle(pose.theta + 1e-4 * rate(t + 5e-5)));
    }
    rows
}

/// The recording of that drive: wheels that turn too little by a tenth, a unit that measures right.
fn winding_recording(measured: impl Fn(Pose2, f64) -> ImuReading) -> Vec<u8> {
    let rows = winding();
    let mut bag = BagWriter::default();
    let odom = bag.topic("/odom", Kind::Odometry, false);
    let wrench = bag.topic("/whisker/wrench", Kind::Wrench, false);
    let unit = bag.topic("/imu/data", Kind::Imu, false);
    let mut wheels = Pose2::IDENTITY;
    for (k, (t, pose, rate)) in rows.iter().enumerate() {
        let header = Header { stamp: Stamp::from_seconds(*t), frame: "base_link" };
        if k > 0 {
            let step = rows[k - 1].1.between(*pose).log();
            wheels = wheels.compose(Pose2::exp(Twist2 { theta: 0.9 * step.theta, ..step }));
        }
        bag.push(odom, header.stamp, encode_odometry(header, "base_link", wheels));
        bag.push(unit, header.stamp, encode_imu(header, measured(*pose, *rate)));
        if k % 3 == 0 {
            bag.push(wrench, header.stamp, encode_wrench(header, 1e-3));
        }
    }
    bag.finish().unwrap()
}

#[test]
fn a_unit_tells_headings_and_turns_where_its_topic_is_named() {
    let bytes = winding_recording(|pose, rate| ImuReading { heading: Some(pose.theta), yaw_rate: Some(rate) });
    let read = |headings: Option<&str>, yaw_rates: Option<&str>| {
        let topics = ImuTopics { headings: headings.map(Into::into), yaw_rates: yaw_rates.map(Into::into) };
        from_mcap_with(bytes.as_slice(), "log.mcap", &topics)
    };
    let unused = read(None, None).unwrap();
    assert!(unused.rows.iter().all(|row| row.heading.is_none()));
    assert!(
        unused.warnings.iter().any(|w| w.contains("/imu/data") && w.contains("--yaw-rates")),
        "{:?}",
        unused.warnings
    );
    let way = winding();
    let start = way[0].1;
    let log = read(Some("/imu/data"), Some("/imu/data")).unwrap();
    let last_off = |log: &vibrissa::flow::sensor_log::SensorLog| {
        let (told, known) = (log.rows.last().unwrap().odom_from_robot, start.between(way.last().unwrap().1));
        told.position().distance(known.position())
    };
    assert!(last_off(&unused) > 5e-3 && last_off(&log) < 2e-5, "{} {}", last_off(&unused), last_off(&log));
    assert!(!log.warnings.iter().any(|w| w.contains("/imu")), "{:?}", log.warnings);
    for (row, (_, pose, _)) in log.rows.iter().zip(way.iter().step_by(3)) {
        let turned = wrap_angle(row.odom_from_robot.theta - start.between(*pose).theta);
        // Trapezoids of 10 ms: a twelfth of their square times the change of the rate's slope, at most 3.6 rad/s².
        assert!(turned.abs() < 3.2e-5, "{}: {turned}", row.t);
        assert!(wrap_angle(row.heading.unwrap() - pose.theta).abs() < 1e-12);
    }
    for (headings, yaw_rates) in [(Some("/imu"), None), (None, Some("/odom"))] {
        let error = read(headings, yaw_rates).unwrap_err().to_string();
        println!("{error}\n");
        assert!(error.starts_with("log.mcap: ") && error.contains("/imu/data"), "{error}");
    }
}

#[test]
fn a_unit_without_orientation_gives_no_headings() {
    let bytes = winding_recording(|_, rate| ImuReading { heading: None, yaw_rate: Some(rate) });
    let topics = ImuTopics { headings: Some("/imu/data".into()), yaw_rates: None };
    let error = from_mcap_with(bytes.as_slice(), "log.mcap", &topics).unwrap_err().to_string();
    assert!(error.contains("no headings on the topic /imu/data"), "{error}");
    let csv = std::env::temp_dir().join("vibrissa_no_recording.csv");
    std::fs::write(&csv, "t,x,y,theta,moment\n0,0,0,0,0\n").unwrap();
    let error = vibrissa::io::log::read_with(&csv, &topics).unwrap_err().to_string();
    assert!(error.contains("`heading`"), "{error}");
}
