//! `live.toml`: what it takes, and what it says about mistakes.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::float_cmp,
    reason = "a test that cannot go on must fail"
)]

use vibrissa::Method;
use vibrissa::world::{Lean, MountedWhisker, Robot};
use vibrissa_live::decode::WireFormat;
use vibrissa_live::setup::from_toml;
use vibrissa_live::source::Wire;
use vibrissa_live::timing::TimeBase;

const WHOLE: &str = r#"
map = "arena.svg"
robot = "robot.toml"
method = "possibilistic"
estimates = "10 Hz"

[options]
within = [0, 1, 0, 1, -3.2, 3.2]

[[source]]
name = "whisker"
serial = "/dev/ttyACM0"
baud = 921600
format = "serial"
delay = "2 ms"

[[source]]
name = "base"
udp = "0.0.0.0:9000"
columns = ["seq16", "t_us", "x_mm", "y_mm", "theta_deg"]
"#;

#[test]
fn a_whole_setup_is_read() {
    let setup = from_toml(WHOLE, "live.toml").unwrap();
    assert_eq!(setup.estimate_rate, 10.0);
    assert!(matches!(setup.method, Method::Possibilistic(options) if options.prior.is_some()), "{:?}", setup.method);
    let [whisker, base] = &setup.sources[..] else { panic!() };
    assert_eq!(whisker.wire, Wire::Serial { port: "/dev/ttyACM0".into(), baud: 921_600 });
    assert_eq!((whisker.format, whisker.time, whisker.delay), (WireFormat::Serial, TimeBase::Counted(300.0), 2e-3));
    assert_eq!((base.format, base.time), (WireFormat::Csv, TimeBase::Stamps));
}

#[test]
fn mistakes_are_told_with_line_value_range_and_remedy() {
    let cases = [
        ("map = \"arena.svg\"", "maps = \"arena.svg\"", "live.toml:2: unknown key: maps", "did you mean `map`?"),
        ("serial = \"/dev/ttyACM0\"", "", "a source has one wire", "serial = \"/dev/ttyACM0\""),
        (
            "baud = 921600",
            "baud = 3",
            "live.toml:13: source[0].baud is out of range: 3 (allowed: 50 to 12000000)",
            "firmware",
        ),
        (
            "baud = 921600",
            "baud = \"fast\"",
            "baud must be a whole number: \"fast\" (allowed: 50 to 12000000)",
            "firmware",
        ),
        ("method = \"possibilistic\"", "method = \"posibilistic\"", "live.toml:4", "did you mean `possibilistic`?"),
        ("udp = \"0.0.0.0:9000\"", "udp = \"9000\"", "source[1].udp is no address: \"9000\" (allowed: host:port", ""),
        ("\"x_mm\"", "\"xx\"", "live.toml:20: unknown column: \"xx\"", "did you mean `x`"),
        ("\"x_mm\", ", "", "odometry has three columns: 2 of them", "x, y and theta"),
        ("format = \"serial\"", "format = \"seriell\"", "unknown format: seriell", "did you mean `serial`?"),
        ("delay = \"2 ms\"", "delay = 20", "delay is out of range: 20 s", "\"2 ms\""),
        ("name = \"base\"", "name = \"whisker\"", "two sources have the same name", "rename"),
        ("method = \"possibilistic\"", "method = \"magic\"", "live.toml:4: method: magic", "probabilistic"),
        ("within = [0, 1, 0, 1, -3.2, 3.2]", "within = [0, 1]", "options.within must be six numbers", "largest x"),
        ("estimates = \"10 Hz\"", "estimates = \"10 ms\"", "live.toml:5", "Hz"),
        ("udp = \"0.0.0.0:9000\"", "serial = \"/dev/ttyACM0\"\nbaud = 921600", "two sources read the same port", ""),
    ];
    for (from, to, message, remedy) in cases {
        let text = WHOLE.replacen(from, to, 1);
        assert_ne!(text, WHOLE, "{from}");
        let error = from_toml(&text, "live.toml").unwrap_err().to_string();
        assert!(error.contains(message) && error.contains(remedy) && error.contains("help:"), "{to}:\n{error}");
    }
    let alone = WHOLE.split("[[source]]\nname = \"base\"").next().unwrap();
    let error = from_toml(alone, "live.toml").unwrap_err().to_string();
    assert!(
        error.contains("no source gives odometry") && error.contains("a whisker's line holds no odometry"),
        "{error}"
    );
}

/// What is wrong with sources beside the wires of hardware.
#[test]
fn mistakes_about_played_logs_and_topics_are_told_alike() {
    let cases = [
        (
            "recording = \"log.csv\"\nspeed = 0",
            "live.toml:4: source.speed is out of range: 0 (allowed: 0.01 to 1000)",
            "as fast as it goes",
        ),
        ("recording = \"log.csv\"\nspeed = \"fast\"", "live.toml:4: source.speed", ""),
        (
            "recording = \"log.csv\"\nformat = \"serial\"",
            "live.toml:4: a log says itself what it holds: format = \"serial\"",
            "leave it out",
        ),
        ("recording = \"log.csv\"\nspeed = 2\ntime = \"stamps\"", "live.toml:4: at another speed", "leave `time` out"),
        ("pipe = \"-\"\nspeed = 2", "live.toml:4: only a recording or a simulated robot has a speed", "leave it out"),
        (
            "ros2 = \"/odom\"",
            "live.toml:2: a topic of ROS 2 needs the kind of its messages (allowed: odometry, joints",
            "nav_msgs/Odometry",
        ),
        (
            "ros2 = \"/odom\"\nmessage = \"odometrie\"",
            "live.toml:4: unknown kind of message: \"odometrie\"",
            "did you mean `odometry`?",
        ),
        ("ros2 = \"/od om\"\nmessage = \"odometry\"", "live.toml:3: no name of a topic: \"/od om\"", "/base/odom"),
        ("ros2 = \"/w\"\nmessage = \"array\"", "live.toml:2: an array does not say what its numbers are", "columns = "),
        (
            "ros2 = \"/w\"\nmessage = \"wrench\"\ncolumns = [\"moment\"]",
            "live.toml:5: a message of ROS 2 says itself",
            "leave it out",
        ),
        ("pipe = \"-\"\nmessage = \"wrench\"", "live.toml:4: only topics of ROS 2 have messages", "leave it out"),
    ];
    for (source, message, remedy) in cases {
        let error =
            from_toml(&format!("map = \"arena.svg\"\n[[source]]\n{source}\n"), "live.toml").unwrap_err().to_string();
        assert!(error.contains(message) && error.contains(remedy) && error.contains("help:"), "{source}:\n{error}");
    }
}

#[test]
fn topics_of_one_system_share_its_clock() {
    let topic = |name: &str, message: &str| format!("[[source]]\nros2 = \"{name}\"\nmessage = \"{message}\"\n");
    let both = format!("map = \"a.svg\"\n{}{}", topic("/odom", "odometry"), topic("/w", "wrench"));
    let setup = from_toml(&both, "live.toml").unwrap();
    assert!(setup.sources.iter().all(|source| source.time == TimeBase::Own));
    // Beside a sensor at a serial port both are mapped to the host's time.
    let mixed = format!(
        "map = \"a.svg\"\n{}[[source]]\nserial = \"/dev/ttyACM0\"\nformat = \"serial\"\n",
        topic("/odom", "odometry")
    );
    let setup = from_toml(&mixed, "live.toml").unwrap();
    assert_eq!(setup.sources[0].time, TimeBase::Stamps);
}

#[test]
fn readings_of_a_whisker_that_the_robot_does_not_have_are_refused_before_anything_begins() {
    let text = WHOLE.replace("baud = 921600", "whisker = \"lefft\"");
    let error = from_toml(&text, "live.toml").unwrap().fits(&Robot::default()).unwrap_err().to_string();
    assert!(error.contains("live.toml:10: the source \"whisker\" holds readings of a whisker"), "{error}");
    assert!(error.contains("lefft.bx (allowed: w0)") && error.contains("as in the robot file"), "{error}");
    assert!(from_toml(WHOLE, "live.toml").unwrap().fits(&Robot::default()).is_ok(), "the only whisker needs no name");
    let two = Robot { whiskers: vec![MountedWhisker::default(); 2], ..Robot::default() };
    let error = from_toml(WHOLE, "live.toml").unwrap().fits(&two).unwrap_err().to_string();
    assert!(error.contains("does not say whose readings it holds"), "{error}");
}

#[test]
fn whiskers_that_lean_are_for_the_methods_that_take_them() {
    let leaning = MountedWhisker { lean: Lean { elevation: 0.3, roll: 0.0 }, ..MountedWhisker::default() };
    let robot = Robot { whiskers: vec![leaning], ..Robot::default() };
    assert!(from_toml(WHOLE, "live.toml").unwrap().fits(&robot).is_ok(), "by the possibilistic method");
    let text = WHOLE.replace("method = \"possibilistic\"", "method = \"probabilistic\"");
    let error = from_toml(&text, "live.toml").unwrap().fits(&robot).unwrap_err().to_string();
    assert!(error.contains("leans out of the horizontal") && error.contains("possibilistic"), "{error}");
}

#[test]
fn a_map_that_is_not_there_is_told_with_the_line_that_names_it() {
    let path = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("missing-map.toml");
    std::fs::write(&path, "# mine\n\nmap = \"nowhere.svg\"\n[[source]]\npipe = \"-\"\n").unwrap();
    let error = vibrissa_live::setup::read(&path).unwrap_err().to_string();
    assert!(error.contains("missing-map.toml:3") && error.contains("nowhere.svg"), "{error}");
    assert!(error.contains("the folder of the setup"), "{error}");
    std::fs::write(&path, "map = \"missing-map.toml\"\n[[source]]\nrecording = \"nowhere.csv\"\n").unwrap();
    let error = vibrissa_live::setup::read(&path).unwrap_err().to_string();
    assert!(error.contains("missing-map.toml:3: the recording that the setup names is not there"), "{error}");
}

#[test]
fn the_guides_setup_is_one() {
    let guide = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/live.md")).unwrap();
    let text = guide.split("```toml\n").nth(1).and_then(|rest| rest.split("```").next()).unwrap();
    let setup = from_toml(text, "docs/live.md").unwrap();
    assert_eq!(setup.sources.len(), 2);
}
