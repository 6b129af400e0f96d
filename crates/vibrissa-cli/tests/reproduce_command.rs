//! `vibrissa reproduce` through the real binary: the page, the file of numbers, and that they say the same.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on must fail")]

#[path = "common/mod.rs"]
mod common;

use common::{folder, vibrissa};
use roxmltree::{Document, Node, ParsingOptions};
use serde_json::Value;
use std::collections::BTreeSet;

/// The sections that take no time, with both kinds of tables.
const LIGHT: [&str; 7] =
    ["beam", "contact-sets", "calibration", "filtering", "contact-table", "deterministic", "errata"];

fn made(name: &str, sections: &[&str]) -> (String, String) {
    let out = folder(name).display().to_string();
    let mut args = vec!["reproduce", "--trials", "5", "--seeds", "1", "--sweeps", "1", "--out", &out];
    sections.iter().for_each(|section| args.extend(["--only", section]));
    let outcome = vibrissa(&args);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    assert_eq!(outcome.stderr, "", "no bar where nobody watches");
    assert!(outcome.stdout.contains("report.html") && outcome.stdout.contains("paper"), "{}", outcome.stdout);
    let read = |file: &str| std::fs::read_to_string(std::path::Path::new(&out).join(file)).unwrap();
    (read("report.html"), read("reproduce.json"))
}

fn parsed(page: &str) -> Document<'_> {
    Document::parse_with_options(page, ParsingOptions { allow_dtd: true, ..ParsingOptions::default() }).unwrap()
}

fn words(node: Node<'_, '_>) -> String {
    node.descendants().filter(Node::is_text).filter_map(|n| n.text()).collect()
}

/// The numbers in a text, as they are spelled.
fn numerals(text: &str) -> Vec<String> {
    let piece = |c: char| !(c.is_ascii_digit() || c == '.');
    text.split(piece).map(|n| n.trim_matches('.').to_owned()).filter(|n| !n.is_empty()).collect()
}

#[test]
fn each_picture_of_the_page_is_a_file_where_pictures_are_asked_for() {
    let out = folder("reproduce-pictures");
    let place = out.display().to_string();
    let outcome = vibrissa(&["reproduce", "--only", "beam", "--pictures", "png", "--out", &place]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    let names = |end: &str| {
        let files = std::fs::read_dir(&out).unwrap().map(|file| file.unwrap().file_name().into_string().unwrap());
        files.filter_map(|name| name.strip_suffix(end).map(str::to_owned)).collect::<BTreeSet<String>>()
    };
    assert_eq!(names(".svg").len(), page.matches("class=\"plate\"").count());
    assert!(!names(".svg").is_empty() && names(".svg") == names(".png"), "{:?}", names(".png"));
}

#[test]
fn the_page_is_well_formed_and_all_of_its_numbers_are_in_the_file() {
    let (page, json) = made("reproduce-page", &LIGHT);
    let (document, json_value): (Document<'_>, Value) = (parsed(&page), serde_json::from_str(&json).unwrap());
    let numbers = json_value["numbers"].as_object().unwrap();
    let keyed: Vec<Node<'_, '_>> = document.descendants().filter(|n| n.has_attribute("data-key")).collect();
    assert!(keyed.len() > 80, "{}", keyed.len());
    for node in &keyed {
        let key = node.attribute("data-key").unwrap();
        let number = numbers.get(key).unwrap_or_else(|| panic!("{key} is not in the file"));
        assert_eq!(words(*node), number["shown"].as_str().unwrap(), "{key}");
    }
    let shown: BTreeSet<&str> = keyed.iter().filter_map(|n| n.attribute("data-key")).collect();
    let missing: Vec<&String> = numbers.keys().filter(|key| !shown.contains(key.as_str())).collect();
    assert!(missing.is_empty(), "in the file, not on the page: {missing:?}");
    // What stands in plain words or in pictures is in the file's words.
    let known: BTreeSet<String> = numerals(&json).into_iter().collect();
    let text = |node: &Node<'_, '_>| {
        node.is_text() && !node.ancestors().any(|a| a.has_tag_name("style") || a.tag_name().name() == "style")
    };
    for node in document.descendants().filter(text) {
        for numeral in numerals(node.text().unwrap()) {
            assert!(known.contains(&numeral), "{numeral} in “{}” is not in the file", node.text().unwrap().trim());
        }
    }
}

#[test]
fn the_page_needs_nothing_else_and_its_pictures_are_whole() {
    let (page, _) = made("reproduce-whole", &LIGHT);
    let document = parsed(&page);
    let mut ids = BTreeSet::new();
    for node in document.descendants().filter(Node::is_element) {
        if let Some(id) = node.attribute("id") {
            assert!(ids.insert(id), "two elements are called {id}");
        }
        for name in ["src", "href"] {
            let target = node.attribute(name).unwrap_or("#");
            assert!(target.starts_with('#') || target.starts_with("data:"), "{name} {target}");
        }
        assert!(!["script", "iframe", "object", "embed"].contains(&node.tag_name().name()));
    }
    for target in page.split("url(#").skip(1).map(|rest| rest.split(')').next().unwrap()) {
        assert!(ids.contains(target), "nothing is called {target}");
    }
    for link in document.descendants().filter_map(|n| n.attribute("href")).filter(|t| t.len() > 1 && t.starts_with('#'))
    {
        assert!(ids.contains(&link[1..]), "nothing is called {link}");
    }
    let pictures: Vec<Node<'_, '_>> = document.descendants().filter(|n| n.tag_name().name() == "svg").collect();
    assert!(pictures.len() >= 17, "{}", pictures.len());
    for picture in pictures {
        let shapes = ["path", "line", "circle", "rect"];
        let count = picture.descendants().filter(|n| shapes.contains(&n.tag_name().name())).count();
        assert!(count > 8 && picture.descendants().any(|n| n.tag_name().name() == "title"));
        assert!(!picture.descendants().any(|n| n.tag_name().name() == "style"), "styles stand once, in the head");
    }
    assert!(page.contains("simulated") && page.contains("prefers-color-scheme: dark"));
}

#[test]
fn the_same_call_gives_the_same_bytes() {
    let sections = ["beam", "contact-table", "errata"];
    assert_eq!(made("reproduce-first", &sections), made("reproduce-second", &sections));
}

#[test]
fn a_script_gets_json_with_the_time_apart() {
    let outcome = vibrissa(&["reproduce", "--only", "beam", "--json"]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    let value: Value = serde_json::from_str(&outcome.stdout).unwrap();
    assert!(value["runtime"]["total_s"].as_f64().unwrap() >= 0.0);
    assert!((value["numbers"]["beam.load_gap"]["value"].as_f64().unwrap() - 7.65).abs() < 0.01);
    let (_, file) = made("reproduce-json", &["beam"]);
    assert!(serde_json::from_str::<Value>(&file).unwrap().get("runtime").is_none());
}

#[test]
fn a_wrong_call_is_told_what_there_is() {
    for args in
        [&["reproduce", "--only", "figures"][..], &["reproduce", "--seeds", "0"], &["reproduce", "--sweeps", "6"]]
    {
        let outcome = vibrissa(args);
        assert_eq!(outcome.code, Some(2), "{args:?}: {}", outcome.stderr);
        assert!(outcome.stderr.contains("error: ") && outcome.stderr.contains("allowed"), "{}", outcome.stderr);
    }
}
