//! Robots and quantities: values against hand-made factors.

#[path = "data/shared.rs"]
mod shared;

use shared::shared;
use std::f64::consts::{FRAC_PI_2, PI};
use std::path::PathBuf;
use vibrissa::io::{Dimension, parse_quantity};
use vibrissa::plane::Pose2;
use vibrissa::world::{Odometry, Robot, WhiskerErrors};

#[test]
fn quantities() {
    use Dimension::{
        Angle, Curvature, FlexuralRigidity, Flux, Force, Frequency, Length, MagneticMoment, Moment, MomentRate,
        Pressure, Ratio, Speed, Stiffness, Time, TurnPerLength, TurnRate,
    };
    for (text, dimension, expected) in [
        ("75 mm", Length, 0.075),
        ("75mm", Length, 0.075),
        ("  -0.58e0 mm ", Length, -0.58e-3),
        ("+7.5e1 mm", Length, 0.075),
        ("12 µm", Length, 12e-6),
        ("12 μm", Length, 12e-6),
        ("12 um", Length, 12e-6),
        ("3 in", Length, 0.0762),
        ("2 km", Length, 2000.0),
        ("150 mm/s", Speed, 0.15),
        ("90 deg / s", TurnRate, FRAC_PI_2),
        ("1.2 kHz", Frequency, 1200.0),
        ("3.6 mA m^2", MagneticMoment, 3.6e-3),
        ("3.6 A·m²", MagneticMoment, 3.6),
        ("5 uN m/s", MomentRate, 5e-6),
        ("2 deg/m", TurnPerLength, 2.0 * PI / 180.0),
        ("52 GPa", Pressure, 52e9),
        ("3 N/mm^2", Pressure, 3e6),
        ("17 mN m", Moment, 0.017),
        ("17 mN·m", Moment, 0.017),
        ("17 mN*m", Moment, 0.017),
        ("17 mNm", Moment, 0.017),
        ("17 N mm", Moment, 0.017),
        ("17 mN mm", Moment, 17e-6),
        ("1 MN m", Moment, 1e6),
        ("0.2 mN m/rad", Stiffness, 2e-4),
        ("1 N m / deg", Stiffness, 180.0 / PI),
        ("2.8886e-4 N m²", FlexuralRigidity, 2.8886e-4),
        ("288.86 N mm^2", FlexuralRigidity, 2.8886e-4),
        ("2 deg", Angle, 2.0 * PI / 180.0),
        ("90°", Angle, FRAC_PI_2),
        ("5 mrad", Angle, 0.005),
        ("0.002 1/mm", Curvature, 2.0),
        ("3 m^-1", Curvature, 3.0),
        ("5 %", Ratio, 0.05),
        ("5", Ratio, 5.0),
        ("50 ms", Time, 0.05),
        ("2 min", Time, 120.0),
        ("40 uT", Flux, 40e-6),
        ("0.5 G", Flux, 5e-5),
        ("3 cN", Force, 0.03),
        ("inf", Stiffness, f64::INFINITY),
        ("-inf", Stiffness, f64::NEG_INFINITY),
    ] {
        let found = parse_quantity(text, dimension).unwrap();
        assert!(
            found.to_bits() == expected.to_bits() || (found - expected).abs() <= 2e-16 * expected.abs(),
            "{text}: {found} {expected}"
        );
    }
    assert_eq!(parse_quantity("75 mm", Length).unwrap().to_bits(), 0.075_f64.to_bits());
    for text in ["", "mm", "1", "1e mm", "1 mmm", "1 m m", "nan m", "1 2 m", "1 Nm", "--1 m", "1 m/s", "∞ m", "é"] {
        assert!(parse_quantity(text, Length).is_err(), "{text}");
    }
    for text in ["1 N", "1 m", "1 m N m", "1 N m m", "1 N/m", "1 Nm/rad", "1 N m^2", "m 1 N"] {
        assert!(parse_quantity(text, Moment).is_err(), "{text}");
    }
}

const EXAMPLE: &str = r#"
[[whisker]]
name = "left"
length = "80 mm"
young_modulus = "52 GPa"
diameter = "0.58 mm"
tip_ratio = 1
curvature = "0.002 1/mm"
base_stiffness = inf
mount = ["50 mm", -0.02, "90 deg"]
friction = 0.1
calibration = "cal.json"
noise = { moment_relative = "5.5 %", moment_absolute = "20 uN m" }
[[whisker]]
name = "right"
flexural_rigidity = 2.8886e-4
young_modulus = 52e9
diameter = 0.58e-3
base_stiffness = "30 mN m/rad"
[odometry]
translation_relative = 0.0101
rotation_relative = "1 %"
"#;

#[test]
fn the_contract_is_read() {
    assert_eq!(vibrissa::io::robot::from_toml("", "empty").unwrap(), Robot::default());
    assert_eq!(vibrissa::io::robot::from_toml("\u{feff}[[whisker]]\r\n", "bom").unwrap(), Robot::default());
    let robot = vibrissa::io::robot::from_toml(EXAMPLE, "robot.toml").unwrap();
    let [left, right] = &robot.whiskers[..] else { panic!("{robot:?}") };
    assert_eq!((left.name.as_str(), right.name.as_str()), ("left", "right"));
    // 52 GPa times the paper's second moment of area, 5.555e-15 m⁴ to four digits.
    assert!((left.beam.flexural_rigidity - 2.8886e-4).abs() < 1e-8);
    assert!((left.beam.length - 0.08).abs() < 1e-16 && (left.beam.curvature - 2.0).abs() < 1e-12);
    assert!(left.beam.base_stiffness.is_infinite() && (right.beam.base_stiffness - 0.03).abs() < 1e-15);
    let mount = left.robot_from_whisker;
    assert!(mount.position().distance(Pose2::new(0.05, -0.02, 0.0).position()) < 1e-15);
    assert!((mount.theta - FRAC_PI_2).abs() < 1e-15);
    assert_eq!(left.calibration, Some(PathBuf::from("cal.json")));
    assert!((left.noise.moment_relative - 0.055).abs() < 1e-15 && (left.noise.moment_absolute - 2e-5).abs() < 1e-18);
    assert!((robot.odometry.translation_relative - 0.0101).abs() < 1e-15);
    assert!((robot.odometry.rotation_relative - 0.01).abs() < 1e-15);
    assert!((right.beam.flexural_rigidity - 2.8886e-4).abs() < 1e-18);
}

#[test]
fn the_contract_page_itself_is_read() {
    let Some(path) = shared("contract.md") else { return };
    let page = std::fs::read_to_string(path).unwrap();
    let lines: Vec<&str> = page
        .lines()
        .skip_while(|l| l.trim() != "[[whisker]]")
        .take_while(|l| l.starts_with("    "))
        .map(str::trim)
        .collect();
    let robot = vibrissa::io::robot::from_toml(&lines.join("\n"), "contract").unwrap();
    assert_eq!(robot.whiskers[0].beam, Robot::default().whiskers[0].beam);
    assert_eq!(robot.whiskers[0].calibration, Some(PathBuf::from("cal.json")));
}

#[test]
fn a_calibration_is_found_beside_the_robot() {
    let folder = std::env::temp_dir().join(format!("vibrissa-robot-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("r.toml"), EXAMPLE).unwrap();
    let robot = vibrissa::read_robot(folder.join("r.toml")).unwrap();
    assert_eq!(robot.whiskers[0].calibration, Some(folder.join("cal.json")));
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn wires_in_a_row_and_curvature_that_changes() {
    let text = r#"
[[whisker]]
name = "jointed"
segments = [
  { length = "25 mm", flexural_rigidity = 2.8886e-4 },
  { length = 0.02, young_modulus = "52 GPa", diameter = "0.4 mm", tip_diameter = "0.2 mm" },
  { length = 0.03, flexural_rigidity = "1e-5 N m^2", tip_ratio = 0.5 },
]
curvature = [2.0, -100, 500.0]
strain_limit = "1 %"
base_stiffness = 0.3
"#;
    let beam = vibrissa::io::robot::from_toml(text, "robot.toml").unwrap().whiskers.remove(0).beam;
    assert!((beam.length - 0.075).abs() < 1e-15 && (beam.flexural_rigidity - 2.8886e-4).abs() < 1e-18);
    let [first, second, third] = beam.stretches.as_slice() else { panic!("three segments") };
    assert!((first.tip_ratio - 1.0).abs() < 1e-15 && first.diameter.is_none());
    assert!((second.tip_ratio - 0.5).abs() < 1e-15 && (third.tip_ratio - 0.5).abs() < 1e-15);
    // 52 GPa times pi (0.4 mm)^4 / 64, by hand.
    assert!((second.flexural_rigidity / 6.534_512_7e-5 - 1.0).abs() < 1e-7, "{}", second.flexural_rigidity);
    assert!((beam.radius_at(0.035).unwrap() - 0.15e-3).abs() < 1e-15 && beam.radius_at(0.01).is_none());
    assert!((beam.curvature_terms()[1] + 100.0).abs() < 1e-12 && (beam.curvature_terms()[2] - 500.0).abs() < 1e-12);
    assert!((beam.strain_limit - 0.01).abs() < 1e-15 && (beam.base_stiffness - 0.3).abs() < 1e-15);
    assert!(!beam.is_uniform() && beam.rod().is_ok());
    assert!((beam.rod().unwrap().length() - 0.075).abs() < 1e-15);
}

#[test]
fn faults_of_segments_name_line_value_and_range() {
    let cases = [
        ("segments = []", 2, "must be a list of wires"),
        ("segments = 3", 2, "must be a list of wires: 3"),
        ("segments = [1]", 2, "whisker.segments[0] must be a table: 1"),
        ("segments = [{ length = 0.01 }]", 2, "segments[0].flexural_rigidity is missing"),
        ("segments = [{ flexural_rigidity = 1e-4 }]", 2, "segments[0].length is missing"),
        (
            "segments = [\n{ length = 0.01, flexural_rigidity = 1e-4 },\n{ length = -1, flexural_rigidity = 1e-4 }]",
            4,
            "segments[1].length is out of range: -1 m",
        ),
        ("segments = [{ length = 0.01, flexural_rigidity = nan }]", 2, "flexural_rigidity is out of range: nan"),
        ("segments = [{ length = 0.01, flexural_rigidity = 1e-4, tip_ratio = 0 }]", 2, "allowed: 0.001 to 1000"),
        (
            "segments = [{ length = 0.01, flexural_rigidity = 1e-4, tip_diameter = 1e-4 }]",
            2,
            "tip_diameter without diameter",
        ),
        (
            "segments = [{ length = 0.01, flexural_rigidity = 1e-4, colour = 1 }]",
            2,
            "unknown key: whisker.segments[0].colour",
        ),
        ("length = 0.05\nsegments = [{ length = 0.01, flexural_rigidity = 1e-4 }]", 2, "whisker.length contradicts"),
        (
            "segments = [{ length = 9.0, flexural_rigidity = 1 }, { length = 9.0, flexural_rigidity = 1 }]",
            2,
            "too long: 18",
        ),
        ("curvature = []", 2, "curvature has too many or no values"),
        ("curvature = [1, 2, 3, 4, 5, 6, 7]", 2, "too many or no values: 7"),
        ("curvature = [1, \"2 1/m\"]", 2, "curvature[1] must be a bare number"),
        ("curvature = [1, inf]", 2, "curvature[1] is out of range"),
        ("name = \"a\"\ncurvature = [0, 1e6]", 3, "turns by less than 2 pi"),
        ("curvature = 1000", 2, "turns by less than 2 pi"),
        ("strain_limit = 0", 2, "strain_limit is out of range: 0"),
        ("tip_ratio = 1e-4", 2, "allowed: 0.001 to 1"),
    ];
    for (text, line, word) in cases {
        let error = vibrissa::io::robot::from_toml(&format!("[[whisker]]\n{text}\n"), "robot.toml").unwrap_err();
        assert!(error.is_data() && error.line() == Some(line), "{text}: {error}");
        assert!(error.to_string().contains(word), "{text}: {error}");
    }
}

#[test]
fn what_a_lab_cannot_know_exactly_is_read_in_its_units() {
    let text = r#"
[[whisker]]
zero_error = "0.2 mN m"
zero_drift_error = "2 uN m/s"
mount_error = ["0.5 mm", 1e-3, "2 deg"]
length_error = "0.4 mm"
stiffness_error = "2 %"
gain_error = 0.03
[[whisker]]
length = "20 mm"
[odometry]
delay_error = "20 ms"
[map]
scale_error = "1 %"
"#;
    let robot = vibrissa::io::robot::from_toml(text, "robot.toml").unwrap();
    let near = |a: f64, b: f64| (a - b).abs() <= 1e-15 * b.abs();
    let WhiskerErrors { zero, zero_drift, mount, length, rigidity, gain } = robot.whiskers[0].errors;
    assert!(
        near(zero, 2e-4) && near(zero_drift, 2e-6) && near(length, 4e-4) && near(rigidity, 0.02) && near(gain, 0.03)
    );
    assert!(near(mount[0], 5e-4) && near(mount[1], 1e-3) && near(mount[2], 2.0 * PI / 180.0));
    assert!(near(robot.odometry.delay, 0.02) && near(robot.map_scale, 0.01));
    assert_eq!(robot.whiskers[1].errors, WhiskerErrors::default());
    assert_eq!(Odometry { delay: Odometry::default().delay, ..robot.odometry }, Odometry::default());
    let again = vibrissa::io::robot::from_toml(&vibrissa::io::robot::to_toml(&robot), "again.toml").unwrap();
    assert_eq!(again, robot);
}

#[test]
fn a_robot_written_is_read_back_the_same() {
    let text = "[[whisker]]\nname = \"a\"\nlength = \"61.3 mm\"\ntip_ratio = 0.3\ncurvature = -2.5\nbase_stiffness = 0.07\n\
                mount = [0.1, -0.2, \"128 deg\"]\nfriction = 0.2\ncalibration = \"a \\\"b\\\\c.json\"\n\
                noise = { moment_relative = \"3 %\", moment_absolute = \"7 uN m\" }\n[[whisker]]\nname = \"b\"\n\
                [odometry]\ntranslation_relative = 0.01\nrotation_relative = 1e-7\n";
    let robot = vibrissa::io::robot::from_toml(text, "robot.toml").unwrap();
    assert_eq!(vibrissa::io::robot::from_toml(&vibrissa::io::robot::to_toml(&robot), "again.toml").unwrap(), robot);
    assert_eq!(
        vibrissa::io::robot::from_toml(&vibrissa::io::robot::to_toml(&Robot::default()), "again.toml").unwrap(),
        Robot::default()
    );
    let jointed = "[[whisker]]\ncurvature = [1.5, -20.0]\nstrain_limit = 0.02\nsegments = [\n\
                   { length = 0.03, flexural_rigidity = 3e-4, diameter = 5e-4, tip_diameter = 4e-4 },\n\
                   { length = 0.02, flexural_rigidity = 1e-4 } ]\n";
    let robot = vibrissa::io::robot::from_toml(jointed, "robot.toml").unwrap();
    assert_eq!(vibrissa::io::robot::from_toml(&vibrissa::io::robot::to_toml(&robot), "again.toml").unwrap(), robot);
}

#[test]
fn methods_without_declared_errors_say_so() {
    use vibrissa::Localizer;
    use vibrissa::flow::sensor_log::{Channel, Quantity};
    let text =
        "[[whisker]]\nzero_error = \"0.2 mN m\"\nmount_error = [0, 0, \"1 deg\"]\n[odometry]\ndelay_error = \"5 ms\"\n";
    let robot = vibrissa::io::robot::from_toml(text, "robot.toml").unwrap();
    assert_eq!(robot.declared_errors(), ["delay_error", "mount_error", "zero_error"]);
    assert!(Robot::default().declared_errors().is_empty());
    let demo = vibrissa::tasks::demo::arena().unwrap();
    let channels = [Channel { whisker: String::new(), quantity: Quantity::Moment }];
    for (method, says) in [("deterministic", true), ("probabilistic", false), ("possibilistic", false)] {
        let method = vibrissa::Method::named(method).unwrap();
        let told = Localizer::new(&demo, &robot, &channels, &method).unwrap().finish();
        assert_eq!(told.events.iter().any(|event| event.kind == "unused"), says, "{}", told.method);
    }
}
