//! The exact text of every message about maps, robots and logs, reviewed by eye.
//!
//! After a deliberate change run with `VIBRISSA_BLESS=1` and read the difference.

#![allow(clippy::unwrap_used, reason = "helpers of tests may fail like tests")]

use std::fmt::Write as _;
use std::path::Path;
use vibrissa::io::{Dimension, parse_quantity};

/// Compares `found` with the stored text.
fn check(file: &str, found: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(file);
    if std::env::var_os("VIBRISSA_BLESS").is_some() {
        std::fs::write(&path, found).unwrap();
    }
    let stored = std::fs::read_to_string(&path).unwrap_or_default();
    for (s, f) in stored.split("\n== ").zip(found.split("\n== ")) {
        assert_eq!(f, s, "in {file}");
    }
    assert_eq!(found, stored);
}

fn gallery<T: std::fmt::Debug>(
    cases: &[(&str, String)],
    read: impl Fn(&str) -> Result<T, vibrissa::Error>,
    warnings: impl Fn(&T) -> &[String],
) -> String {
    let mut out = String::new();
    for (title, text) in cases {
        match read(text) {
            Err(e) => {
                assert!(e.is_data(), "{title}");
                writeln!(out, "== {title}\n{e}").unwrap();
            }
            Ok(value) => {
                writeln!(out, "== {title} (read)").unwrap();
                warnings(&value).iter().for_each(|w| writeln!(out, "warning: {w}").unwrap());
            }
        }
    }
    out
}

fn cases(list: &[(&'static str, &str)]) -> Vec<(&'static str, String)> {
    list.iter().map(|(title, text)| (*title, (*text).to_owned())).collect()
}

/// A feature collection of one polygon, a point a line from line 4 on.
fn polygon(role: &str, points: &[&str]) -> String {
    format!(
        "{{\"type\": \"FeatureCollection\", \"features\": [\n{{\"type\": \"Feature\", \"properties\": {{\"role\": \"{role}\"}},\n\
         \"geometry\": {{\"type\": \"Polygon\", \"coordinates\": [[\n{}\n]]}}}}\n]}}",
        points.join(",\n")
    )
}

#[test]
fn geojson() {
    let feature = |inside: &str| format!("{{\"type\": \"FeatureCollection\", \"features\": [\n{{{inside}}}]}}");
    let square = "\"geometry\": {\"type\": \"Polygon\", \"coordinates\": [[[0,0],[1,0],[1,1]]]}";
    let found = [
        ("empty file", String::new()),
        ("not JSON", "{\"type\": \"FeatureCollection\",\n \"features\": [}".into()),
        ("cut short", "{\"type\": \"FeatureCollection\",\n \"features\": [".into()),
        ("a list", "[1, 2]".into()),
        ("no type", "{\"a\": 1}".into()),
        ("no features", "{\"type\": \"FeatureCollection\", \"features\": []}".into()),
        ("features missing", "{\"type\": \"FeatureCollection\"}".into()),
        (
            "unknown role",
            feature(&format!("\"type\": \"Feature\", \"properties\": {{\"role\": \"obstacel\"}}, {square}")),
        ),
        ("far role", feature(&format!("\"type\": \"Feature\", \"properties\": {{\"role\": \"x\"}}, {square}"))),
        ("role a number", feature(&format!("\"type\": \"Feature\", \"properties\": {{\"role\": 3}}, {square}"))),
        ("no role", feature(&format!("\"type\": \"Feature\", \"properties\": {{}}, {square}"))),
        ("null properties", feature(&format!("\"type\": \"Feature\", \"properties\": null, {square}"))),
        ("no geometry", feature("\"type\": \"Feature\", \"properties\": {\"role\": \"wall\"}, \"geometry\": null")),
        (
            "point",
            feature(
                "\"type\": \"Feature\", \"properties\": {\"role\": \"wall\"}, \"geometry\": {\"type\": \"Point\", \"coordinates\": [0, 0]}",
            ),
        ),
        (
            "no coordinates",
            feature(
                "\"type\": \"Feature\", \"properties\": {\"role\": \"wall\"}, \"geometry\": {\"type\": \"Polygon\"}",
            ),
        ),
        (
            "flat coordinates",
            feature(
                "\"type\": \"Feature\", \"properties\": {\"role\": \"wall\"}, \"geometry\": {\"type\": \"Polygon\", \"coordinates\": [0, 1]}",
            ),
        ),
        (
            "open arena",
            feature(
                "\"type\": \"Feature\", \"properties\": {\"role\": \"arena\"}, \"geometry\": {\"type\": \"LineString\", \"coordinates\": [[0, 1], [2, 3]]}",
            ),
        ),
        (
            "wall of one point",
            feature(
                "\"type\": \"Feature\", \"properties\": {\"role\": \"wall\"}, \"geometry\": {\"type\": \"LineString\", \"coordinates\": [[0, 1], [0, 1]]}",
            ),
        ),
        ("two points", polygon("arena", &["[0, 0]", "[1, 0]", "[0, 0]"])),
        ("millimetres", polygon("arena", &["[0, 0]", "[400000, 0]", "[400000, 400000]"])),
        ("overflow", polygon("arena", &["[0, 0]", "[1e999, 0]", "[1, 1]"])),
        ("NaN", polygon("arena", &["[0, 0]", "[NaN, 0]", "[1, 1]"])),
        ("text as number", polygon("arena", &["[0, 0]", "[\"1\", 0]", "[1, 1]"])),
        ("one coordinate", polygon("arena", &["[0, 0]", "[1]", "[1, 1]"])),
        ("bow tie", polygon("arena", &["[0, 0]", "[0.2, 0.2]", "[0.2, 0]", "[0, 0.1]"])),
        ("pinched", polygon("obstacle", &["[0, 0]", "[2, 0]", "[1, 1]", "[2, 2]", "[0, 2]", "[1, 1]"])),
        ("on one line", polygon("obstacle", &["[0, 0]", "[1, 1]", "[2, 2]"])),
    ];
    check(
        "geojson_messages.txt",
        &gallery(&found, |t| vibrissa::io::map::from_geojson(t, "map.geojson"), |m| &m.warnings),
    );
}

#[test]
fn svg() {
    let svg = |inside: &str| {
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" xmlns:inkscape=\"http://www.inkscape.org/namespaces/inkscape\" \
             width=\"200mm\" height=\"100mm\" viewBox=\"0 0 200 100\">\n{inside}\n</svg>"
        )
    };
    let arena = "<rect class=\"arena\" width=\"200\" height=\"100\"/>\n";
    let found = [
        ("empty file", String::new()),
        ("not XML", "<svg><g></svg>".into()),
        ("not SVG", "<html/>".into()),
        ("nothing drawn", svg("")),
        ("no roles", svg("<rect id=\"rect1\" width=\"3\" height=\"3\"/><path id=\"path7\" d=\"M0 0H4\"/>")),
        (
            "some without role",
            svg(&format!("{arena}<rect id=\"obstacl2\" width=\"3\" height=\"3\"/><path d=\"M0 0H4\"/>")),
        ),
        ("open arena", svg("<path id=\"arena\" d=\"M0 0 H4 V4\"/>")),
        ("crossing", svg("<polygon id=\"obstacle-3\" points=\"0,0 20,20 20,0 0,10\"/>")),
        ("flat", svg("<polygon id=\"obstacle-3\" points=\"0,0 20,20\"/>")),
        ("empty path", svg("<path id=\"wall\" d=\"\"/>")),
        ("bad path", svg("<path id=\"wall\" d=\"M0 0 L 3 q\"/>")),
        ("bad transform", svg("<path id=\"wall\" transform=\"turn(3)\" d=\"M0 0 L 3 3\"/>")),
        ("collapsed", svg("<circle id=\"obstacle\" transform=\"scale(0)\" r=\"3\"/>")),
        ("units inside", svg("<circle id=\"obstacle\" r=\"3mm\"/>")),
        ("no radius", svg("<circle id=\"obstacle\"/>")),
        ("clone", svg("<use id=\"obstacle\" href=\"#a\"/>")),
        ("clone in a layer", svg("<g id=\"obstacles\"><use id=\"use9\" href=\"#a\"/></g>")),
        ("clone without role", svg(&format!("{arena}<use id=\"use9\" href=\"#a\"/>"))),
        ("embedded drawing", svg("<g id=\"obstacles\"><text>caption</text><svg/></g>")),
        ("text", svg("<text id=\"wall\">a</text>")),
        ("huge", svg("<rect class=\"arena\" width=\"1e12\" height=\"100\"/>")),
        ("bad viewBox", "<svg viewBox=\"0 0 0 0\"/>".into()),
        ("bad width", "<svg width=\"wide\"/>".into()),
        ("pixels", format!("<svg width=\"200px\" height=\"100px\" viewBox=\"0 0 200 100\">{arena}</svg>")),
        ("no viewBox", format!("<svg width=\"200mm\" height=\"100mm\">{arena}</svg>")),
        ("stretched", format!("<svg width=\"200mm\" height=\"200mm\" viewBox=\"0 0 200 100\">{arena}</svg>")),
    ];
    check("svg_messages.txt", &gallery(&found, |t| vibrissa::io::map::from_svg(t, "map.svg"), |m| &m.warnings));
}

#[test]
fn robot() {
    let found = cases(&[
        ("not TOML", "[[whisker]]\nlength = = 3"),
        ("repeated key", "[[whisker]]\nlength = 0.1\nlength = 0.2"),
        ("unknown section", "[whiskers]\nlength = 3"),
        ("unknown key", "[[whisker]]\nname = \"a\"\nlenght = 0.07"),
        ("far unknown key", "[odometry]\nspeed = 1"),
        ("unknown noise key", "[[whisker]]\nnoise = { relative = 0.1 }"),
        ("single table", "[whisker]\nlength = 0.07"),
        ("empty list", "whisker = []"),
        ("odometry a number", "odometry = 3"),
        ("same name", "[[whisker]]\nname = \"a\"\n[[whisker]]\nname = \"a\""),
        ("name with a dot", "[[whisker]]\nname = \"left.front\""),
        ("name a number", "[[whisker]]\nname = 3"),
        ("millimetres", "[[whisker]]\nlength = 75"),
        ("negative length", "[[whisker]]\nlength = -0.075"),
        ("negative with unit", "[[whisker]]\nlength = \"-75 mm\""),
        ("not a number", "[[whisker]]\nlength = nan"),
        ("boolean", "[[whisker]]\nlength = true"),
        ("wrong unit", "[[whisker]]\nlength = \"75 nm2\""),
        ("near unit", "[[whisker]]\nlength = \"75 MM\""),
        ("no unit", "[[whisker]]\nlength = \"75\""),
        ("no number", "[[whisker]]\nlength = \"long\""),
        ("tip ratio", "[[whisker]]\ntip_ratio = 0"),
        ("tip ratio above 1", "[[whisker]]\ntip_ratio = 1.5"),
        ("infinite curvature", "[[whisker]]\ncurvature = inf"),
        ("no stiffness", "[[whisker]]\nbase_stiffness = 0.0"),
        ("negative friction", "[[whisker]]\nfriction = -0.1"),
        ("noise of one", "[[whisker]]\n[whisker.noise]\nmoment_relative = 5"),
        ("noise of 120 %", "[[whisker]]\nnoise = { moment_relative = \"120 %\" }"),
        ("odometry", "[odometry]\ntranslation_relative = -0.01"),
        ("mount of two", "[[whisker]]\nmount = [0, 0]"),
        ("mount in degrees", "[[whisker]]\nmount = [0, 0, 90]"),
        ("mount in millimetres", "[[whisker]]\nmount = [120, 0, 0]"),
        ("mount part", "[[whisker]]\nmount = [\"50 deg\", 0, 0]"),
        ("modulus alone", "[[whisker]]\nyoung_modulus = \"52 GPa\""),
        ("diameter alone", "[[whisker]]\ndiameter = \"0.58 mm\""),
        ("contradiction", "[[whisker]]\nflexural_rigidity = 1e-3\nyoung_modulus = \"52 GPa\"\ndiameter = \"0.58 mm\""),
        ("second whisker", "[[whisker]]\n[[whisker]]\nlength = 0"),
        ("zero in Newton", "[[whisker]]\nzero_error = \"0.2 N\""),
        ("negative zero", "[[whisker]]\nzero_error = -1e-4"),
        ("drift without time", "[[whisker]]\nzero_drift_error = \"0.1 mN m\""),
        ("one mount error", "[[whisker]]\nmount_error = \"1 mm\""),
        ("mount error in degrees", "[[whisker]]\nmount_error = [0, 0, 5]"),
        ("mount error in millimetres", "[[whisker]]\nmount_error = [1, 2, 0]"),
        ("longer than the whisker", "[[whisker]]\nlength = 0.05\nlength_error = 0.5"),
        ("stiffness of 200 %", "[[whisker]]\nstiffness_error = \"200 %\""),
        ("gain of one", "[[whisker]]\ngain_error = 1"),
        ("a misspelt error", "[[whisker]]\ngian_error = 0.1"),
        ("delay in milliseconds", "[odometry]\ndelay_error = 20"),
        ("map's scale", "[map]\nscale_error = 3"),
        ("a whisker that points up", "[[whisker]]\nelevation = \"85 deg\""),
        ("elevation in degrees", "[[whisker]]\nelevation = 20"),
        ("height in degrees", "[[whisker]]\nmount_height = \"5 deg\""),
        ("yaw of the body", "[body]\nyaw = 1"),
        ("straight down on its body", "[body]\npitch = \"45 deg\"\n[[whisker]]\nelevation = \"-45 deg\""),
        ("below the floor", "[body]\nheight = \"20 mm\"\n[[whisker]]\nelevation = \"-45 deg\""),
        ("map's file", "[map]\nfile = \"map.svg\""),
    ]);
    check("robot_messages.txt", &gallery(&found, |t| vibrissa::io::robot::from_toml(t, "robot.toml"), |_| &[]));
}

#[test]
fn log() {
    let found = cases(&[
        ("empty file", ""),
        ("no header", "0.0,1,2,3,4\n"),
        ("only a header", "t,x,y,theta,moment\n"),
        ("no moment", "t,x,y,theta\n0,0,0,0\n"),
        ("near moment", "t,x,y,theta,momnet\n0,0,0,0,0\n"),
        ("near whisker moment", "t,x,y,theta,w0.moments\n0,0,0,0,0\n"),
        ("no theta", "t,x,y,yaw,moment\n0,0,0,0,0\n"),
        ("near theta", "t,x,y,thetha,moment\n0,0,0,0,0\n"),
        ("semicolons", "t;x;y;theta;moment\n0;0;0;0;0\n"),
        ("twice", "t,x,y,theta,moment,moment\n0,0,0,0,0,0\n"),
        ("cut in the middle", "t,x,y,theta,moment\n0,0,0,0,0\n1,0,0\n2,0,0,0,0\n"),
        ("cut at the end", "t,x,y,theta,moment\n0,0,0,0,0\n1,0,0"),
        ("cut number at the end", "t,x,y,theta,moment\n0,0,0,0,0\n1,0,0,0,1e-"),
        ("only a cut row", "t,x,y,theta,moment\n0,0,0"),
        ("decimal commas", "t,x,y,theta,moment\n0,0,0,0,0,5\n1,0,0,0,0\n"),
        ("text", "t,x,y,theta,moment\n0,0,0,0,zero\n1,0,0,0,0\n"),
        ("text in the last row", "t,x,y,theta,moment\n0,0,0,0,0\n1,0,0,0,zero\n"),
        ("gap", "t,x,y,theta,moment\n0,0,,0,0\n1,0,0,0,0\n"),
        ("NaN", "t,x,y,theta,moment\n0,0,0,0,NaN\n1,0,0,0,0\n"),
        ("infinite", "t,x,y,theta,moment\n0,0,0,0,-inf\n1,0,0,0,0\n"),
        ("clock stands", "t,x,y,theta,moment\n0.5,0,0,0,0\n0.5,0,0,0,0\n1,0,0,0,0\n"),
        ("clock runs back", "t,x,y,theta,moment\n0.5,0,0,0,0\n0.25,0,0,0,0\n1,0,0,0,0\n"),
        ("unknown columns", "t,x,y,theta,moment,temp,headin\n0,0,0,0,0,3,4\n"),
        ("flux only", "t,x,y,theta,bx,by,bz\n0,0,0,0,0,0,0\n"),
        ("degrees", "t,x,y,theta,moment,heading\n0,0,0,0,0,0\n1,0,0,45,0,0\n2,0,0,90,0,90\n"),
        ("wraps quietly", "t,x,y,theta,moment\n0,0,0,3.14,0\n1,0,0,-3.14,0\n"),
        ("millimetres", "t,x,y,theta,moment\n0,0,0,0,0\n1,0.5,0,0,17\n2,1.0,0,0,-18\n"),
    ]);
    check("log_messages.txt", &gallery(&found, |t| vibrissa::io::log::from_csv(t, "log.csv"), |l| &l.warnings));
}

#[test]
fn files() {
    let mut out = String::new();
    for path in ["missing/map.geojson", "missing.svg", "map.yaml", "map.dxf", "map.svgz", "map", "map.txt"] {
        writeln!(out, "== {path}\n{}", vibrissa::read_map(path).unwrap_err()).unwrap();
    }
    writeln!(out, "== missing.toml\n{}", vibrissa::read_robot("missing.toml").unwrap_err()).unwrap();
    writeln!(out, "== missing.csv\n{}", vibrissa::read_log("missing.csv").unwrap_err()).unwrap();
    writeln!(out, "== a folder\n{}", vibrissa::read_log("src").unwrap_err()).unwrap();
    writeln!(out, "== a folder\n{}", vibrissa::read_robot("src").unwrap_err()).unwrap();
    for (text, dimension) in [("3 parsec", Dimension::Length), ("2 mn m", Dimension::Moment), ("", Dimension::Time)] {
        writeln!(out, "== {text}\n{}", parse_quantity(text, dimension).unwrap_err()).unwrap();
    }
    let log = vibrissa::io::log::from_csv("t,x,y,theta,left.moment,right.bx\n0,0,0,0,1,2\n", "log.csv").unwrap();
    assert_eq!(log.moment_channel("left").unwrap(), 0);
    writeln!(out, "== other whisker\n{}", log.moment_channel("right").unwrap_err()).unwrap();
    let log = vibrissa::io::log::from_csv("t,x,y,theta,bx\n0,0,0,0,2\n", "log.csv").unwrap();
    writeln!(out, "== flux only\n{}", log.moment_channel("w0").unwrap_err()).unwrap();
    check("file_messages.txt", &out);
}
