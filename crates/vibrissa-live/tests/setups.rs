//! `live.toml`: what it takes, and what it says about mistakes.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::float_cmp,
    reason = "a test that cannot go on must fail"
)]

use vibrissa::Method;
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
        ("baud = 921600", "baud = 3", "live.toml:13: baud is out of range: 3 (allowed: 50 to 12000000)", "firmware"),
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

#[test]
fn a_map_that_is_not_there_is_told_with_the_line_that_names_it() {
    let path = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("missing-map.toml");
    std::fs::write(&path, "# mine\n\nmap = \"nowhere.svg\"\n[[source]]\npipe = \"-\"\n").unwrap();
    let error = vibrissa_live::setup::read(&path).unwrap_err().to_string();
    assert!(error.contains("missing-map.toml:3") && error.contains("nowhere.svg"), "{error}");
    assert!(error.contains("the folder of the setup"), "{error}");
}

#[test]
fn the_guides_setup_is_one() {
    let guide = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/live.md")).unwrap();
    let text = guide.split("```toml\n").nth(1).and_then(|rest| rest.split("```").next()).unwrap();
    let setup = from_toml(text, "docs/live.md").unwrap();
    assert_eq!(setup.sources.len(), 2);
}
