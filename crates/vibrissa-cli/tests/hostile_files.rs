//! Files that are made to cost: each reader refuses them before memory is taken, and says what is allowed.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must fail")]

#[path = "common/mod.rs"]
mod common;

use common::{folder, vibrissa};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

/// The demo's results.
static DEMO: LazyLock<PathBuf> = LazyLock::new(|| {
    let folder = folder("hostile-demo");
    assert_eq!(vibrissa(&["demo", "--out", folder.to_str().unwrap()]).code, Some(0));
    folder
});

fn demo(name: &str) -> String {
    DEMO.join(name).to_str().unwrap().to_owned()
}

/// A command on a file, its error, which must name the file, the allowed value and a remedy.
fn refused(name: &str, content: &[u8], command: &dyn Fn(&str) -> Vec<String>, words: &[&str]) {
    let path = folder(&format!("hostile-{name}")).join(name);
    fs::write(&path, content).unwrap();
    let told = error(path.to_str().unwrap(), command);
    for word in words.iter().chain(&["(allowed: ", "\n  help: ", name]) {
        assert!(told.contains(word), "{name}: `{word}` is missing in {told}");
    }
    assert!(told.len() < 2000, "{name}: {} bytes", told.len());
    let _ = fs::remove_file(path);
}

fn error(path: &str, command: &dyn Fn(&str) -> Vec<String>) -> String {
    let args = command(path);
    let outcome = vibrissa(&args.iter().map(String::as_str).collect::<Vec<_>>());
    assert_eq!(outcome.code, Some(1), "{path}: {outcome:?}");
    assert!(outcome.stdout.is_empty(), "{path}: {}", outcome.stdout);
    outcome.stderr
}

fn words(words: &[&str]) -> Vec<String> {
    words.iter().map(|word| (*word).to_owned()).collect()
}

fn as_map(path: &str) -> Vec<String> {
    words(&["localize", &demo("log.csv"), "--map", path])
}

fn as_log(path: &str) -> Vec<String> {
    words(&["localize", path, "--map", &demo("map.svg")])
}

fn as_robot(path: &str) -> Vec<String> {
    words(&["contact", &demo("log.csv"), "--robot", path])
}

fn as_truth(path: &str) -> Vec<String> {
    words(&["localize", &demo("log.csv"), "--map", &demo("map.svg"), "--truth", path])
}

fn as_calibration(path: &str) -> Vec<String> {
    words(&["contact", &demo("log.csv"), "--taps", "--calibration", path])
}

fn as_scenario(path: &str) -> Vec<String> {
    words(&["simulate", path])
}

fn as_batch(path: &str) -> Vec<String> {
    words(&["beam", "force", "--batch", path])
}

#[test]
fn maps_beyond_a_budget_are_refused() {
    let svg = |inner: &str, front: &str| format!("{front}<svg xmlns=\"http://www.w3.org/2000/svg\">{inner}</svg>");
    let arena = "<rect id=\"arena\" width=\"40\" height=\"30\"/>";
    let entity = format!("<!DOCTYPE svg [<!ENTITY a \"{}\">]>", "x".repeat(100_000));
    let quadratic = svg(&format!("{arena}<text>{}</text>", "&a;".repeat(1000)), &entity);
    refused("entities.svg", quadratic.as_bytes(), &as_map, &["entities stand for too much", "16777216"]);
    let far = svg("<path id=\"wall\" d=\"M0 0 C 9e7 9e7 -9e7 9e7 1 1 C 9e7 8e7 -9e7 8e7 2 2\"/>", "")
        .replace("/></svg>", &format!("/>{}</svg>", "<circle id=\"wall\" r=\"9e7\"/>".repeat(4)));
    refused("far.svg", far.as_bytes(), &as_map, &["within a micrometre", "2097152", "metres are due"]);
    let nodes = svg(&(arena.to_owned() + &"<g/>".repeat(1 << 20)), "");
    refused("nodes.svg", nodes.as_bytes(), &as_map, &["too many elements", "1048576"]);
    let path = svg(&format!("<path id=\"wall\" d=\"M0 0{}\"/>", "h1".repeat(1 << 20) + "h1"), "");
    refused("path.svg", path.as_bytes(), &as_map, &["too many pieces", "1048576"]);
    let ring: Vec<String> = (0..(1 << 20) + 1).map(|i| format!("[{i}e-4,{}]", i % 2)).collect();
    let points = format!(
        "{{\"type\":\"Feature\",\"properties\":{{\"role\":\"wall\"}},\"geometry\":{{\"type\":\"LineString\",\"coordinates\":[{}]}}}}",
        ring.join(",")
    );
    refused("points.geojson", points.as_bytes(), &as_map, &["too many points", "1048576"]);
    let dxf = |entities: &str, unit: u32| {
        format!(
            "0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\n{unit}\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n{entities}0\nENDSEC\n0\nEOF\n"
        )
    };
    let hole = |i: usize| format!("0\nCIRCLE\n8\narena\n10\n{}\n20\n0\n40\n60\n", 130 * i);
    let holes: String = (0..700).map(hole).collect();
    refused("holes.dxf", dxf(&holes, 6).as_bytes(), &as_map, &["within a micrometre", "metres are due"]);
    let one = "0\nLINE\n8\nobstacle\n10\n0\n20\n0\n11\n0\n21\n0\n".repeat(100);
    refused("one-point.dxf", dxf(&one, 4).as_bytes(), &as_map, &["end in one point", "64"]);
    let layers: String = (0..2000).map(|i| format!("0\nLINE\n8\nwall{i}\n10\n0\n20\n{i}\n11\n1\n21\n{i}\n")).collect();
    refused("layers.dxf", dxf(&layers, 4).as_bytes(), &as_map, &["too many layers", "1024"]);
    let sparse = folder("hostile-sparse").join("large.svg");
    fs::File::create(&sparse).unwrap().set_len(1 << 40).unwrap();
    let told = error(sparse.to_str().unwrap(), &as_map);
    assert!(told.contains("too large: 1099511627776 bytes (allowed: up to 67108864 bytes)"), "{told}");
}

#[test]
fn logs_beyond_a_budget_are_refused() {
    let names: Vec<String> = (0..5000).map(|i| format!("c{i}")).collect();
    let columns = format!("t,x,y,theta,moment,{}\n", names.join(","));
    refused("columns.csv", columns.as_bytes(), &as_log, &["too many fields", "4096"]);
    let name = format!("t,x,y,theta,moment,{}\n0,0,0,0,0,0\n", "n".repeat(5000));
    refused("name.csv", name.as_bytes(), &as_log, &["name of a column is too long", "256"]);
    refused("line.csv", "1,".repeat(1 << 20).as_bytes(), &as_log, &["line is too long", "1048576"]);
    // Fields of a chunk that says that it inflates to 128 MB.
    let mut mcap = b"\x89MCAP0\r\n".to_vec();
    let mut record = |kind: u8, body: &[u8]| {
        mcap.push(kind);
        mcap.extend((body.len() as u64).to_le_bytes());
        mcap.extend(body);
    };
    let text = |word: &str| [&(word.len() as u32).to_le_bytes()[..], word.as_bytes()].concat();
    record(3, &[&1_u16.to_le_bytes()[..], &text("nav_msgs/msg/Odometry"), &text("ros2msg"), &text("")].concat());
    record(4, &[&[1, 0, 1, 0][..], &text("/odom"), &text("cdr"), &text("")].concat());
    let head = [0_u64, 1, 1 << 27].map(u64::to_le_bytes).concat();
    record(6, &[&head[..], &[0; 4], &text("zstd"), &[0; 8]].concat());
    record(15, &[0; 4]);
    record(2, &[0; 20]);
    mcap.extend(b"\x89MCAP0\r\n");
    refused("chunk.mcap", &mcap, &as_log, &["a chunk of the recording is too large: 134217728 bytes", "67108864"]);
}

#[test]
fn robots_and_other_files_beyond_a_budget_are_refused() {
    let deep = format!("a = {}", "[".repeat(100));
    refused("deep.toml", deep.as_bytes(), &as_robot, &["nested too deeply", "64"]);
    let dotted = format!("{}a = 1", "a.".repeat(100));
    refused("dotted.toml", dotted.as_bytes(), &as_robot, &["nested too deeply", "64"]);
    let whiskers: String = (0..300).map(|i| format!("[[whisker]]\nname = \"w{i}\"\n")).collect();
    refused("whiskers.toml", whiskers.as_bytes(), &as_robot, &["too many whiskers: 300", "256"]);
    refused("large.toml", "# \n".repeat(400_000).as_bytes(), &as_robot, &["robot file is too large", "1048576"]);
    refused("large2.toml", "# \n".repeat(400_000).as_bytes(), &as_scenario, &["scenario file is too large", "1048576"]);
    refused(
        "large.json",
        " ".repeat(5 << 20).as_bytes(),
        &as_calibration,
        &["calibration file is too large", "4194304"],
    );
    let yaml = |rest: &str| format!("image: a.pgm\nresolution: 0.05\norigin: [0, 0, 0]\n{rest}");
    let path = folder("hostile-yaml").join("deep.yaml");
    fs::write(&path, yaml(&format!("other: {}{}\n", "[".repeat(80), "]".repeat(80)))).unwrap();
    let told = error(path.to_str().unwrap(), &as_map);
    assert!(told.contains("nested deeper than 64 levels"), "{told}");
    fs::write(&path, "image: a.pgm\nresolution: 0.05\norigin: [".to_owned() + &"0, ".repeat(100) + "0]\n").unwrap();
    let told = error(path.to_str().unwrap(), &as_map);
    assert!(told.contains("more than 64 values"), "{told}");
    let batch = "s_a,F\n".to_owned() + &"0.07,0.05\n".repeat(500_001);
    refused("batch.csv", batch.as_bytes(), &as_batch, &["too many rows", "500000"]);
}

/// The arguments of a command that reads this file.
#[cfg(unix)]
type Arguments<'a> = &'a dyn Fn(&str) -> Vec<String>;

#[cfg(unix)]
#[test]
fn what_is_no_file_is_refused_at_once() {
    let here = folder("hostile-special");
    let fifo = here.join("fifo");
    let _ = fs::remove_file(&fifo);
    assert!(std::process::Command::new("mkfifo").arg(&fifo).status().unwrap().success());
    let _ = fs::remove_file(here.join("socket"));
    let _socket = std::os::unix::net::UnixListener::bind(here.join("socket")).unwrap();
    let readers: [(&str, Arguments<'_>); 9] = [
        ("svg", &as_map),
        ("dxf", &as_map),
        ("yaml", &as_map),
        ("mcap", &as_log),
        ("csv", &as_log),
        ("toml", &as_robot),
        ("tum", &as_truth),
        ("json", &as_calibration),
        ("batch", &as_batch),
    ];
    for (extension, command) in readers {
        let (socket, folder) = (here.join("socket"), DEMO.as_path());
        for (target, word) in
            [(Path::new("/dev/zero"), "a device"), (&fifo, "a named pipe"), (&socket, "a socket"), (folder, "a folder")]
        {
            let link = here.join(format!("link.{extension}"));
            let _ = fs::remove_file(&link);
            std::os::unix::fs::symlink(target, &link).unwrap();
            let told = error(link.to_str().unwrap(), command);
            assert!(told.contains(word) && told.contains("\n  help: "), "{extension}: {told}");
        }
    }
}
