//! What files hold neither steers the terminal nor a viewer: control characters, marks that turn writing round and endless names, fed
//! through each reader, come out escaped and cut in messages, JSON and SVG.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must fail")]

#[path = "common/mod.rs"]
mod common;

use common::{folder, vibrissa};
use std::fs;
use std::path::Path;

/// Ends a title, moves the cursor, turns the writing round, and never ends.
const STEERING: &str = "\u{1b}]0;title\u{7}\u{1b}[2J\u{202e}gnp\u{2066}\u{9b}31m\u{7f}\u{200f}";
/// The same without what XML, TOML and YAML forbid.
const MARKS: &str = "\u{202e}gnp\u{2066}\u{9b}31m\u{200f}\u{2028}x";

/// Whether a character steers what shows it, told by Unicode's own ranges rather than by the product.
fn steers(c: char) -> bool {
    let control = (c < ' ' && c != '\n' && c != '\t') || ('\u{7f}'..='\u{9f}').contains(&c);
    control || matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

fn clean(what: &str, text: &str) {
    let found: Vec<char> = text.chars().filter(|c| steers(*c)).collect();
    assert!(found.is_empty(), "{what}: {found:?} in {}", &text[..text.len().min(2000)].escape_debug());
}

/// Runs a command in which no word is there without being shown or cut.
fn check(name: &str, args: &[&str], out: Option<&Path>) {
    let outcome = vibrissa(args);
    assert!(matches!(outcome.code, Some(0..=2)), "{name}: {outcome:?}");
    clean(&format!("{name}, standard error"), &outcome.stderr);
    clean(&format!("{name}, standard output"), &outcome.stdout);
    assert!(outcome.stderr.len() < 6000, "{name}: {} bytes: {}", outcome.stderr.len(), &outcome.stderr[..1000]);
    for entry in out.and_then(|out| fs::read_dir(out).ok()).into_iter().flatten() {
        let path = entry.unwrap().path();
        let kind = path.extension().unwrap_or_default().to_string_lossy().into_owned();
        if ["json", "geojson", "svg", "html"].contains(&kind.as_str()) {
            clean(&format!("{name}, {}", path.display()), &fs::read_to_string(&path).unwrap());
        }
    }
}

#[test]
fn no_reader_lets_what_a_file_holds_steer_its_viewer() {
    let demo = folder("terminal-demo");
    assert_eq!(vibrissa(&["demo", "--out", demo.to_str().unwrap()]).code, Some(0));
    let sound = |name: &str| demo.join(name).to_str().unwrap().to_owned();
    let (log, map) = (sound("log.csv"), sound("map.svg"));
    let good = fs::read_to_string(&log).unwrap();
    let drawing = fs::read_to_string(&map).unwrap();
    let (steering, marks, endless) = (STEERING, MARKS, "n".repeat(200_000));
    let out = folder("terminal-out");
    let out_word = out.to_str().unwrap().to_owned();
    let mut tried = 0;
    let mut through = |name: &str, content: String, args: &dyn Fn(&str) -> Vec<String>| {
        // The file's own name steers, too.
        let path = folder("terminal").join(format!("{MARKS}\u{1b}[31m{name}"));
        fs::write(&path, content).unwrap();
        let args = args(path.to_str().unwrap());
        check(name, &args.iter().map(String::as_str).collect::<Vec<_>>(), Some(&out));
        let json: Vec<&str> = args.iter().map(String::as_str).chain(["--json"]).collect();
        check(name, &json, Some(&out));
        tried += 1;
    };
    let words = |words: &[&str]| -> Vec<String> { words.iter().map(|word| (*word).to_owned()).collect() };
    let as_map =
        |path: &str| words(&["localize", &log, "--map", path, "--out", &out_word, "--method", "deterministic"]);
    let as_log =
        |path: &str| words(&["localize", path, "--map", &map, "--out", &out_word, "--method", "deterministic"]);
    let as_robot = |path: &str| words(&["contact", &log, "--robot", path, "--out", &out_word]);
    for bad in [steering, marks, &endless] {
        let role = |word: &str| {
            format!(
                "{{\"type\":\"Feature\",\"properties\":{{\"role\":\"{word}\",\"name\":\"{bad}\"}},\"geometry\":{{\"type\":\"{word}\",\"coordinates\":[[0,\"{bad}\"]]}}}}"
            )
        };
        through("a.geojson", role(bad), &as_map);
        through("b.geojson", role("wall"), &as_map);
        through("c.geojson", format!("{{\"type\":\"{bad}\"}}"), &as_map);
        let escaped = bad.chars().map(|c| format!("\\u{:04x}", c as u32)).take(60).collect::<String>();
        through("d.geojson", format!("{{\"type\":\"{escaped}\"}}"), &as_map);
        let svg = |inner: &str| drawing.replace("</svg>", &format!("{inner}</svg>"));
        through("a.svg", svg(&format!("<rect id=\"{bad}\" width=\"1\" height=\"1\"/>")), &as_map);
        through("b.svg", svg(&format!("<rect id=\"wall{bad}\" width=\"{bad}\" height=\"1\"/>")), &as_map);
        through("c.svg", format!("<{bad}/>"), &as_map);
        through("d.svg", svg(&format!("<path id=\"wall\" d=\"{bad}\" transform=\"{bad}\"/>")), &as_map);
        let dxf = |layer: &str, value: &str| {
            format!(
                "0\nSECTION\n2\nENTITIES\n0\nLINE\n8\n{layer}\n10\n{value}\n20\n0\n11\n1\n21\n1\n0\nENDSEC\n0\nEOF\n"
            )
        };
        through("a.dxf", dxf(bad, "0"), &as_map);
        through("b.dxf", dxf(&format!("wall{bad}"), bad), &as_map);
        through("c.dxf", format!("0\n{bad}\n{bad}\n"), &as_map);
        through("a.yaml", format!("image: \"{bad}\"\nresolution: 0.05\norigin: [0, 0, 0]\n"), &as_map);
        through("b.yaml", format!("image: a.pgm\nresolution: {bad}\norigin: [0, 0, {bad}]\n"), &as_map);
        through("a.csv", good.replacen("moment", &format!("moment,{bad}"), 1).replace('\n', ",0\n"), &as_log);
        through("b.csv", good.replacen("moment", bad, 1), &as_log);
        through("c.csv", good.replacen("\n0", &format!("\n{bad}"), 1), &as_log);
        through("a.toml", format!("[[whisker]]\nname = \"{bad}\"\n"), &as_robot);
        through("b.toml", format!("\"{bad}\" = 1\n"), &as_robot);
        through("c.toml", format!("[[whisker]]\nlength = \"{bad}\"\n"), &as_robot);
        let as_truth = |path: &str| words(&["localize", &log, "--map", &map, "--truth", path]);
        through("a.tum", format!("0 0 0 0 0 0 0 {bad}\n"), &as_truth);
        let as_calibration = |path: &str| words(&["contact", &log, "--taps", "--calibration", path]);
        through(
            "a.json",
            format!("{{\"format\":\"vibrissa calibration\",\"version\":1,\"data\":[{{\"file\":\"{bad}\"}}]}}"),
            &as_calibration,
        );
        through("b.json", format!("{{\"format\":\"{bad}\"}}"), &as_calibration);
        let as_foreign = |path: &str| words(&["localize", path, "--format", "csv", "--map", &map]);
        through("a.txt", format!("t,x,y,{bad}\n0,0,0,0\n1,0,0,0\n"), &as_foreign);
        let as_batch = |path: &str| words(&["beam", "force", "--batch", path]);
        through("a.batch", format!("s_a,F,{bad}\n0.07,{bad},{bad}\n"), &as_batch);
        through("a.scenario", format!("title = \"{bad}\"\nmap = \"{bad}\"\n"), &|path| words(&["simulate", path]));
    }
    assert_eq!(tried, 3 * 25);
    recordings(&map);
}

/// A recording whose topics, kinds and encodings steer.
fn recordings(map: &str) {
    for bad in [STEERING, MARKS, &"n".repeat(200_000), &"/n".repeat(100)] {
        let text = |word: &str| [&(word.len() as u32).to_le_bytes()[..], word.as_bytes()].concat();
        for (kind, topic, encoding) in
            [(bad, "/odom", "cdr"), ("nav_msgs/msg/Odometry", bad, "cdr"), ("nav_msgs/msg/Odometry", "/odom", bad)]
        {
            let mut bytes = b"\x89MCAP0\r\n".to_vec();
            let schema = [&[1, 0][..], &text(kind), &text("ros2msg"), &text("")].concat();
            let channel = [&[1, 0, 1, 0][..], &text(topic), &text(encoding), &text("")].concat();
            for (op, body) in [(3, schema), (4, channel), (15, vec![0; 4]), (2, vec![0; 20])] {
                bytes.push(op);
                bytes.extend((body.len() as u64).to_le_bytes());
                bytes.extend(body);
            }
            bytes.extend(b"\x89MCAP0\r\n");
            let path = folder("terminal-mcap").join(format!("{MARKS}.mcap"));
            fs::write(&path, bytes).unwrap();
            let path = path.to_str().unwrap();
            check("log.mcap", &["localize", path, "--map", map], None);
            check("map.mcap", &["preimage", "--map", path, "--sensor", "load", "--value", "0.1 N"], None);
        }
    }
}
