//! `vibrissa studio` through the real binary: a page that is missing, written, and served.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must fail")]

#[path = "common/mod.rs"]
mod common;

use common::{folder, vibrissa};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Command, Stdio};

const PAGE: &str = "<!doctype html><title>vibrissa studio</title><p>a page</p>";

#[test]
fn a_page_that_is_not_there_is_asked_for_by_its_script() {
    let missing = vibrissa(&["studio", "--page", "/no/such/studio.html", "--out", "x.html"]);
    assert_eq!(missing.code, Some(1), "{missing:?}");
    assert!(
        missing.stderr.contains("studio/build") && missing.stderr.contains("/no/such/studio.html"),
        "{}",
        missing.stderr
    );
    let dir = folder("studio_other_page");
    let other = dir.join("other.html");
    std::fs::write(&other, "<title>another page</title>").unwrap();
    let refused = vibrissa(&["studio", "--page", other.to_str().unwrap(), "--out", "x.html"]);
    assert_eq!(refused.code, Some(1), "{refused:?}");
    assert!(refused.stderr.contains("not the studio's page"), "{}", refused.stderr);
}

#[test]
fn the_page_is_written_as_one_file() {
    let dir = folder("studio_out");
    let (page, out) = (dir.join("in.html"), dir.join("made/studio.html"));
    std::fs::write(&page, PAGE).unwrap();
    let done = vibrissa(&["studio", "--page", page.to_str().unwrap(), "--out", out.to_str().unwrap()]);
    assert_eq!(done.code, Some(0), "{done:?} {}", done.stdout);
    assert_eq!(std::fs::read_to_string(&out).unwrap(), PAGE);
    let refused = vibrissa(&["studio", "--page", page.to_str().unwrap(), "--out", dir.to_str().unwrap()]);
    assert_eq!(refused.code, Some(2), "{refused:?}");
}

#[test]
fn the_page_is_served_at_its_whole_address_only() {
    let dir = folder("studio_serve");
    let page = dir.join("in.html");
    std::fs::write(&page, PAGE).unwrap();
    let mut child = Command::new(env!("CARGO_BIN_EXE_vibrissa"))
        .args(["studio", "--json", "--page", page.to_str().unwrap()])
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut line = String::new();
    BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
    let value: serde_json::Value = serde_json::from_str(&line).unwrap();
    let url = value["url"].as_str().unwrap().strip_prefix("http://").unwrap().to_owned();
    let (host, path) = url.split_once('/').unwrap();
    assert!(host.starts_with("127.0.0.1:"), "{host}");
    let get = |path: &str| {
        let mut stream = TcpStream::connect(host).unwrap();
        write!(stream, "GET /{path} HTTP/1.1\r\nHost: {host}\r\n\r\n").unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        answer
    };
    let (found, lost) = (get(path), get(""));
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(found.starts_with("HTTP/1.1 200 OK\r\n") && found.ends_with(PAGE), "{found}");
    assert!(lost.starts_with("HTTP/1.1 404 ") && !lost.contains("a page"), "{lost}");
}
