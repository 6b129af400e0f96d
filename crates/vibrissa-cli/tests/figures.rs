//! Every kind of figure, with one whisker and with several: text stays on its page and does not cover other text; pictures
//! are written beside them. The figures are left in cargo's folder for test files, to be looked at.

#![cfg(feature = "pictures")]
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must fail")]

#[path = "common/mod.rs"]
mod common;

use common::{folder as empty, vibrissa};
use resvg::usvg::{Group, Node, Options, Rect, Tree, fontdb::Database};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

const SCENARIO: &str = r#"
title = "Two whiskers between two walls, whose title is long enough to need a second line of the page"
seed = 3
WHISKERS
[map]
arena = [[0, -0.02], [0.2, -0.02], [0.25, 0], [0.4, 0], [0.4, 0.13], [0.25, 0.13], [0.2, 0.15], [0, 0.15]]

[path]
start = ["120 mm", "65 mm"]

[[path.leg]]
kind = "line"
to = ["350 mm", "65 mm"]
speed = "250 mm/s"
"#;
const TWO: &str = r#"
[[whisker]]
name = "left"
mount = [0, "10 mm", "115 deg"]
[[whisker]]
name = "right"
mount = [0, "-10 mm", "-115 deg"]
"#;
const ONE: &str = r#"
[[whisker]]
name = "w0"
mount = [0, "10 mm", "115 deg"]
"#;

fn folder(name: &str) -> PathBuf {
    empty(&format!("figures-{name}"))
}

fn run(args: &[&str], out: &Path) {
    run_with(args, out, "pdf");
}

/// Pixels take seconds: they are drawn of the smaller figures.
fn run_with(args: &[&str], out: &Path, pictures: &str) {
    let out = out.to_str().unwrap();
    let answer = vibrissa(&[args, &["--out", out, "--pictures", pictures]].concat());
    assert_eq!(answer.code, Some(0), "{args:?}: {}\n{}", answer.stdout, answer.stderr);
}

fn parsed(svg: &str) -> Tree {
    let mut fonts = Database::new();
    for name in ["DejaVuSans.ttf", "DejaVuSans-Bold.ttf"] {
        fonts.load_font_file(Path::new(env!("CARGO_MANIFEST_DIR")).join("fonts").join(name)).unwrap();
    }
    fonts.set_sans_serif_family("DejaVu Sans");
    let options = Options { font_family: "DejaVu Sans".into(), fontdb: Arc::new(fonts), ..Options::default() };
    Tree::from_str(svg, &options).unwrap()
}

/// The text boxes of a figure with their words.
fn boxes(group: &Group, found: &mut Vec<(String, Rect)>) {
    for node in group.children() {
        match node {
            Node::Text(text) => {
                let words = text.chunks().iter().map(|chunk| chunk.text().to_owned()).collect();
                found.push((words, text.abs_bounding_box()));
            }
            Node::Group(group) => boxes(group, found),
            _ => {}
        }
    }
}

/// What is wrong with the text of a figure.
fn faults(svg: &str) -> Vec<String> {
    let tree = parsed(svg);
    let mut found = Vec::new();
    boxes(tree.root(), &mut found);
    assert!(!found.is_empty());
    let (width, height) = (tree.size().width(), tree.size().height());
    let off = |b: &Rect| b.left() < 0.0 || b.top() < 0.0 || b.right() > width || b.bottom() > height;
    let mut faults: Vec<String> =
        found.iter().filter(|(_, b)| off(b)).map(|(words, b)| format!("off the page: {words} {b:?}")).collect();
    for (index, (words, a)) in found.iter().enumerate() {
        for (other, b) in &found[..index] {
            let across = a.right().min(b.right()) - a.left().max(b.left());
            let down = a.bottom().min(b.bottom()) - a.top().max(b.top());
            let least = (a.width() * a.height()).min(b.width() * b.height());
            if across > 0.0 && down > 0.0 && across * down > 0.3 * least {
                faults.push(format!("\"{words}\" covers \"{other}\""));
            }
        }
    }
    faults
}

/// Checks all figures of a folder, and that there are some; each has its pictures.
fn check(folder: &Path) {
    let mut count = 0;
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|end| end != "svg") || path.ends_with("map.svg") {
            continue;
        }
        let faults = faults(&fs::read_to_string(&path).unwrap());
        assert!(faults.is_empty(), "{}: {faults:#?}", path.display());
        assert!(fs::read(path.with_extension("pdf")).unwrap().starts_with(b"%PDF"));
        count += 1;
    }
    assert!(count > 0, "{}", folder.display());
}

#[test]
fn text_off_the_page_and_covered_text_are_found() {
    let page = |text: &str| {
        format!("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"200\" height=\"50\" font-size=\"12\">{text}</svg>")
    };
    assert!(faults(&page("<text x=\"10\" y=\"20\">inside</text>")).is_empty());
    assert_eq!(faults(&page("<text x=\"180\" y=\"20\">outside</text>")).len(), 1);
    assert_eq!(faults(&page("<text x=\"10\" y=\"20\">one</text><text x=\"12\" y=\"22\">two</text>")).len(), 1);
}

#[test]
fn whiskers_alone() {
    for (name, args) in [
        ("force", vec!["beam", "force", "--s-a", "60 mm", "--force", "0.3 N"]),
        ("point", vec!["beam", "point", "--x", "40 mm", "--y", "40 mm"]),
        ("moment", vec!["beam", "moment", "--s-a", "70 mm", "--moment", "17 mN m", "--load", "vertical"]),
        ("load", vec!["contact-set", "--sensor", "load", "--value", "0.3 N"]),
        ("moments", vec!["contact-set", "--sensor", "moment", "--value", "5 mN m"]),
        (
            "two",
            vec!["contact-set", "--sensor", "load", "--value", "0.3 N", "--sensor", "moment", "--value", "11 mN m"],
        ),
        (
            "region",
            vec![
                "contact-set",
                "--sensor",
                "load",
                "--value",
                "0.3 N",
                "--sensor",
                "moment",
                "--value",
                "11 mN m",
                "--tolerance",
                "5 %",
            ],
        ),
    ] {
        let out = folder(name);
        run_with(&args, &out, "png,pdf");
        check(&out);
        let pixels = fs::read_dir(&out)
            .unwrap()
            .map(|entry| entry.unwrap().path())
            .find(|path| path.extension().is_some_and(|end| end == "png"));
        assert!(fs::read(pixels.unwrap()).unwrap().starts_with(b"\x89PNG"));
    }
}

#[test]
fn sweeps_with_one_whisker() {
    all_of_a_sweep("one", ONE);
}

#[test]
fn sweeps_with_two_whiskers() {
    all_of_a_sweep("two-whiskers", TWO);
}

fn all_of_a_sweep(name: &str, whiskers: &str) {
    let out = folder(name);
    let scenario = out.join("scenario.toml");
    fs::write(&scenario, SCENARIO.replace("WHISKERS", whiskers)).unwrap();
    run(&["simulate", scenario.to_str().unwrap()], &out);
    check(&out);
    let file = |name: &str| out.join(name).to_str().unwrap().to_owned();
    let (log, map, robot, truth) = (file("log.csv"), file("map.geojson"), file("robot.toml"), file("truth.tum"));
    let files = [&*log, "--map", &map, "--robot", &robot, "--truth", &truth];
    for method in ["deterministic", "possibilistic", "probabilistic"] {
        let there = folder(&format!("{name}-{method}"));
        run(&[&["localize"][..], &files, &["--method", method, "--animate"]].concat(), &there);
        check(&there);
        let drawn = fs::read_to_string(there.join("localization.svg")).unwrap();
        let last = drawn.matches("class=\"whisker-last\"").count();
        // Each whisker's last shape, in the close-up of a short sweep again, and the legend's sample.
        let panels = 1 + usize::from(drawn.contains("Close up: the sweep"));
        assert_eq!(last, 1 + panels * whiskers.matches("[[whisker]]").count(), "{method}");
        let film = fs::read_to_string(there.join("localization.html")).unwrap();
        assert!(film.contains("const frames = [[") && film.len() < 3_000_000, "{}", film.len());
    }
    let commands: [&[&str]; 4] = [&["contact"], &["contact", "--filter", "--spacing", "4 mm"], &["profile"], &["map"]];
    for command in commands {
        let there = folder(&format!("{name}-{}", command.join("").replace(' ', "")));
        run(&[command, &[&log, "--robot", &robot]].concat(), &there);
        check(&there);
    }
    let there = folder(&format!("{name}-plan"));
    run(&["plan", &log, "--map", &map, "--robot", &robot, "--budget", "2000"], &there);
    check(&there);
    let slices: [&[&str]; 2] = [&[], &["--heading", "-115 deg"]];
    for (kind, more) in ["strip", "slice"].into_iter().zip(slices) {
        let there = folder(&format!("{name}-{kind}"));
        let args = ["preimage", "--map", &map, "--sensor", "moment", "--value", "5 mN m", "--cell", "4 mm"];
        run(&[&args[..], &["--heading-step", "4 deg"], more].concat(), &there);
        check(&there);
    }
}

#[test]
fn sensors_and_contacts_in_space() {
    let out = folder("sensor");
    run(&["sensor", "design", "--distance", "5 mm"], &out);
    check(&out);
    let mut log = String::from("t,x,y,theta,moment,across\n");
    let mut contacts = String::from("x,y,z,bx,by\n");
    for i in 0..120 {
        let (sin, cos) = (0.05 * f64::from(i)).sin_cos();
        log.push_str(&format!("{},{},0,0,{},{}\n", 0.01 * f64::from(i), 1e-4 * f64::from(i), 5e-3 * cos, 5e-3 * sin));
        let r = 1e-3 * f64::from(1 + i % 7);
        contacts.push_str(&format!(
            "0.06,{},{},{},{}\n",
            r * cos,
            r * sin,
            r * (cos - 0.2 * sin),
            r * (0.1 * cos + sin)
        ));
    }
    for (name, command, text) in [("space", &["contact", "--space"][..], log), ("plane", &["calibrate"], contacts)] {
        let out = folder(name);
        let file = out.join("in.csv");
        fs::write(&file, text).unwrap();
        run(&[command, &[file.to_str().unwrap()]].concat(), &out);
        check(&out);
    }
}

#[test]
fn the_demo() {
    let out = folder("demo");
    run(&["demo"], &out);
    check(&out);
}
