//! The exact text of every message about scenarios, reviewed by eye.
//!
//! After a deliberate change run with `VIBRISSA_BLESS=1` and read the difference.

#![allow(clippy::unwrap_used, reason = "helpers of tests may fail like tests")]

#[path = "data/random.rs"]
mod random;

use random::Random;
use std::fmt::Write as _;
use std::path::Path;
use vibrissa::sim::Scenario;

const MAP: &str = "map = { arena = [[0, 0], [0.6, 0], [0.6, 0.4], [0, 0.4]] }\n";
const WAY: &str = "[path]\nwaypoints = [[0.15, 0.335], [0.4, 0.335]]\n";

/// The text that reading or simulating gives.
fn said(text: &str) -> String {
    match Scenario::from_toml(text, "scenario.toml", "missing").and_then(|scenario| scenario.simulate()) {
        Ok(simulation) => simulation.warnings.iter().map(|w| format!("warning: {w}\n")).collect(),
        Err(error) => {
            assert!(error.is_data(), "a file is at fault: {error}");
            format!("{error}\n")
        }
    }
}

fn leg(keys: &str) -> String {
    format!("{MAP}[path]\nstart = [0.15, 0.335, 0]\n[[path.leg]]\n{keys}")
}

fn way(keys: &str) -> String {
    format!("{MAP}[path]\n{keys}")
}

#[test]
fn messages() {
    let plain = |before: &str, after: &str| format!("{before}{MAP}{WAY}{after}");
    let cases = [
        ("empty", String::new()),
        ("not TOML", "map = = 3".into()),
        ("no map", WAY.into()),
        ("no path", MAP.into()),
        ("unknown key", plain("sede = 3\n", "")),
        ("seed", plain("seed = -1\n", "")),
        ("map not there", format!("map = \"arena.svg\"\n{WAY}")),
        ("map a number", format!("map = 3\n{WAY}")),
        ("map key", format!("map = {{ arenas = [[0, 0], [1, 0], [1, 1]] }}\n{WAY}")),
        ("map that crosses itself", format!("map = {{ arena = [[0, 0], [1, 1], [1, 0], [0, 0.5]] }}\n{WAY}")),
        ("map of one point", format!("map = {{ wall = [[0, 0]] }}\n{WAY}")),
        ("map without boundaries", format!("map = {{ }}\n{WAY}")),
        ("robot not there", plain("robot = \"robot.toml\"\n", "")),
        ("robot twice", plain("robot = \"robot.toml\"\n", "[[whisker]]\nlength = 0.1\n")),
        ("whisker key", plain("", "[[whisker]]\nlenght = 0.1\n")),
        (
            "mount outside",
            plain("outline = { radius = \"60 mm\" }\n", "[[whisker]]\nname = \"left\"\nmount = [0, \"75 mm\", 0]\n"),
        ),
        ("outline without radius", plain("outline = { }\n", "")),
        ("outline of two points", plain("outline = [[0, 0], [0.1, 0]]\n", "")),
        ("outline that overlaps a wall", plain("outline = { radius = \"70 mm\" }\n", "")),
        ("path key", way("waypoint = [[0.1, 0.2], [0.4, 0.2]]\n")),
        ("nothing to do", way("speed = 0.1\n")),
        ("negative speed", way("speed = \"-10 mm/s\"\nwaypoints = [[0.1, 0.2], [0.4, 0.2]]\n")),
        ("speed in the wrong unit", way("speed = \"10 mm\"\nwaypoints = [[0.1, 0.2], [0.4, 0.2]]\n")),
        ("rate 0", way("rate = 0\nwaypoints = [[0.1, 0.2], [0.4, 0.2]]\n")),
        ("rate not a number", way("rate = nan\nwaypoints = [[0.1, 0.2], [0.4, 0.2]]\n")),
        ("a billion rows", way("rate = \"1 GHz\"\nwaypoints = [[0.1, 0.2], [0.4, 0.2]]\n")),
        ("one waypoint", way("waypoints = [[0.1, 0.2]]\n")),
        ("no length", way("waypoints = [[0.1, 0.2], [0.1, 0.2]]\n")),
        ("waypoint of one value", way("waypoints = [[0.1, 0.2], [0.1]]\n")),
        ("waypoint not a number", way("waypoints = [[0.1, 0.2], [nan, 0.1]]\n")),
        ("waypoint in millimetres", way("waypoints = [[0.1, 0.2], [400000, 0.2]]\n")),
        (
            "start inside a wall",
            way("waypoints = [[0.1, 0.2], [0.7, 0.2]]\n")
                .replace("[0.1, 0.2]", "[0.7, 0.3]")
                .replace("[0.7, 0.2]", "[0.4, 0.2]"),
        ),
        ("a path through a wall", way("waypoints = [[0.3, 0.2], [0.7, 0.2]]\n")),
        ("both ways", way("waypoints = [[0.3, 0.2], [0.7, 0.2]]\nstart = [0, 0]\n")),
        ("no start", way("[[path.leg]]\nkind = \"line\"\nto = [0.1, 0.1]\n")),
        ("heading", way("waypoints = [[0.1, 0.2], [0.4, 0.2]]\nheading = \"alogn\"\n")),
        ("heading offset alone", way("waypoints = [[0.1, 0.2], [0.4, 0.2]]\nheading = 0\nheading_offset = 1\n")),
        ("leg without kind", leg("to = [0.1, 0.1]\n")),
        ("leg of unknown kind", leg("kind = \"lines\"\nto = [0.1, 0.1]\n")),
        ("leg with another's key", leg("kind = \"line\"\nto = [0.1, 0.1]\ncentre = [0.3, 0.3]\n")),
        ("leg without its key", leg("kind = \"arc\"\ncentre = [0.3, 0.3]\n")),
        ("arc round itself", leg("kind = \"arc\"\ncentre = [0.15, 0.335]\nangle = 1\n")),
        ("spline to itself", leg("kind = \"spline\"\nthrough = [0.15, 0.335]\n")),
        ("wall side", leg("kind = \"wall\"\nside = \"top\"\nstandoff = 0.05\nlength = 0.2\n")),
        ("too narrow for the standoff", leg("kind = \"wall\"\nside = \"left\"\nstandoff = 0.25\nlength = 0.2\n")),
        ("endless wall", leg("kind = \"wall\"\nside = \"left\"\nstandoff = 0.05\nlength = \"1 km\"\n")),
        ("a single table for legs", way("start = [0.1, 0.1]\n[path.leg]\nkind = \"line\"\n")),
        ("path a number", format!("{MAP}path = 3\n")),
        ("noise key", plain("", "[noise]\ngain = 0.1\n")),
        ("noise share", plain("", "[noise]\ndropped_share = \"100 %\"\n")),
        ("noise law", plain("", "[noise]\nlaw = \"ar2\"\n")),
        ("law a number", plain("", "[noise]\nlaw = 1\n")),
        ("time of another law", plain("", "[noise]\nlaw = \"sine\"\ntime_constant = \"0.5 s\"\n")),
        ("no time", plain("", "[noise]\nlaw = \"ar1\"\ntime_constant = 0\n")),
        ("half a bit", plain("", "[noise]\nlaw = \"quantised\"\nbits = 7.5\n")),
        ("errors key", plain("", "[errors]\nzero_error = 1e-4\n")),
        ("errors unit", plain("", "[errors]\nzero = \"0.2 mm\"\n")),
        ("errors share", plain("", "[errors]\ngain = -1\n")),
        ("errors mount", plain("", "[errors]\nmount = \"1 deg\"\n")),
        ("errors length", plain("", "[errors]\nlength = -0.08\n")),
        ("errors heading", plain("", "[errors]\nheading = \"20 deg\"\n")),
        (
            "map's scale and a robot file",
            format!("robot = \"robot.toml\"\nmap = {{ wall = [[0, 0], [1, 0]], scale_error = 0.1 }}\n{WAY}"),
        ),
        ("noise unit", plain("", "[noise]\ndrift = \"5 uN m\"\n")),
        ("slip", plain("", "[[noise.odometry.slip]]\nt = 1\nshare = -1\n")),
        ("sensing key", plain("", "[sensing]\ncolumn = [\"flux\"]\n")),
        ("columns", plain("", "[sensing]\ncolumns = [\"fluxes\"]\n")),
        ("chip", plain("", "[sensing]\nchip = \"MLX9039\"\n")),
        ("a register", plain("", "[sensing]\ngain = 9\n")),
        ("another chip's setting", plain("", "[sensing]\nchip = \"TLE493D\"\ngain = 3\n")),
        ("too slow a chip", plain("", "[sensing]\nfilter = 7\noversampling = 3\n")),
        ("chip in the magnet", plain("", "[sensing]\nchip_offset = [\"-3 mm\", 0, 0]\n")),
        ("magnet moment", plain("", "[sensing]\nmagnet_moment = [\"3 A m\", 0, 0]\n")),
        ("serial", plain("", "[sensing]\nserial = \"interleaved\"\n")),
        ("a whisker that starts in touch", format!("{MAP}{WAY}[[whisker]]\nmount = [0, 0, \"90 deg\"]\n")),
        ("no touch", format!("{MAP}[path]\nwaypoints = [[0.15, 0.2], [0.4, 0.2]]\n")),
    ];
    let found: String = cases.iter().fold(String::new(), |mut out, (title, text)| {
        write!(out, "== {title}\n{}", said(text)).unwrap();
        out
    });
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/scenario_messages.txt");
    if std::env::var_os("VIBRISSA_BLESS").is_some() {
        std::fs::write(&path, &found).unwrap();
    }
    let stored = std::fs::read_to_string(&path).unwrap_or_default();
    for (s, f) in stored.split("\n== ").zip(found.split("\n== ")) {
        assert_eq!(f, s);
    }
    assert_eq!(found, stored);
}

#[test]
fn mutilated_scenarios_are_read_or_refused_with_their_file() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenarios");
    let texts: Vec<String> = ["round_array.toml", "cluttered_room.toml", "square.toml"]
        .map(|name| std::fs::read_to_string(folder.join(name)).unwrap())
        .into();
    let scraps = ["-", "9", "e9", "nan", "inf", "[", "]", "\"", "=", "\n", "0", ".", "[[path.leg]]\n", "deg", "{", "}"];
    let mut random = Random(17);
    let (mut read, mut refused) = (0, 0);
    for round in 0..600 {
        let mut text: Vec<char> = texts[round % texts.len()].chars().collect();
        for _ in 0..1 + (random.unit() * 3.0) as usize {
            let at = (random.unit() * text.len() as f64) as usize;
            let scrap = scraps[(random.unit() * scraps.len() as f64) as usize];
            match (random.unit() * 3.0) as usize {
                0 => drop(text.splice(at..at, scrap.chars())),
                1 => drop(text.splice(at..(at + 1).min(text.len()), scrap.chars())),
                _ => drop(text.drain(at..(at + 3).min(text.len()))),
            }
        }
        let text: String = text.into_iter().collect();
        match Scenario::from_toml(&text, "scenario.toml", &folder) {
            Ok(scenario) => {
                assert!(scenario.path.iter().all(|pose| pose.map_from_robot.position().is_finite()));
                read += 1;
            }
            Err(error) => {
                assert!(error.is_data() && error.file().is_some() && error.to_string().contains("help: "), "{error}");
                refused += 1;
            }
        }
    }
    assert!(read > 30 && refused > 200, "{read} read, {refused} refused");
}
