//! The example in C, compiled and run: its numbers against the closed form, which shares no tables with what it calls.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must fail")]

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;
use vibrissa_beam::beam::{Load, Whisker, force_mode, moment_mode_in_space, point_mode};
use vibrissa_beam::plane::Vec2;

/// The static library that cargo made for this test.
fn library() -> PathBuf {
    std::env::current_exe().unwrap().parent().unwrap().join("libvibrissa_c.a")
}

#[test]
fn the_example_in_c_prints_the_numbers_of_the_closed_form() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let program = Path::new(env!("CARGO_TARGET_TMPDIR")).join("press");
    let compiled = Command::new("cc")
        .args(["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-O1"])
        .arg(root.join("examples/press.c"))
        .arg(library())
        .args(["-lm", "-lpthread", "-ldl", "-o"])
        .arg(&program)
        .output();
    let Ok(compiled) = compiled else {
        // Past the harness, which keeps what passing tests print.
        let _ = std::io::stderr().write_all(b"SKIPPED: no C compiler, so the interface for C was NOT tried\n");
        return;
    };
    assert!(compiled.status.success(), "{}", String::from_utf8_lossy(&compiled.stderr));
    let ran = Command::new(&program).output().unwrap();
    let text = String::from_utf8(ran.stdout).unwrap();
    assert!(ran.status.success(), "{text}");
    let numbers = |key: &str| -> Vec<f64> {
        let line = text.lines().find_map(|line| line.strip_prefix(key)).unwrap();
        line.split_whitespace().map(|word| word.parse().unwrap()).collect()
    };
    let near = |found: &[f64], want: &[f64]| {
        assert_eq!(found.len(), want.len());
        for (found, want) in found.iter().zip(want) {
            assert!((found - want).abs() < 1e-8 * want.abs(), "{found} and {want}: {text}");
        }
    };
    let whisker = Whisker { base_stiffness: f64::INFINITY, ..Whisker::default() };
    let point = Vec2::new(0.065, 0.030);
    let pressed = point_mode(&whisker, point, Load::Normal).unwrap().remove(0);
    near(&numbers("point "), &[pressed.moment, pressed.force, pressed.phi_a]);
    near(&numbers("moment "), &[point.x, point.y]);
    let forced = force_mode(&whisker, 0.1, 0.075, Load::Normal).unwrap().remove(0);
    near(&numbers("force "), &[forced.contact.x, forced.contact.y, forced.moment]);
    // (6e-4 * 0.6 + 8e-4 * 0.8) / 4e-3 = 0.25
    near(&numbers("flux "), &[0.25 * 0.04 + 1e-3 * 0.25_f64.powi(3)]);
    // Excursions of 2e-4, 5e-4 and 1e-4 T: signals of 4.21e-3 and -2.54e-3 N m.
    let (u, v) = ((4.21e-3 - 1e-4) / 0.02, (-2.54e-3 + 2e-4) / 0.02);
    let both = [0.02 * u + 1e-4 * u * v + 3e-4 * u * u * u, 0.02 * v + 2e-4 * u * u + 4e-4 * v * v * v];
    near(&numbers("both "), &both);
    let contact = moment_mode_in_space(&whisker, both, whisker.length, Load::Normal).unwrap().remove(0);
    near(&numbers("space "), &[contact.x, contact.r, contact.plane.angle]);
}

/// Names after `key` on the lines of a text, up to the first sign that is no name's.
fn names<'a>(text: &'a str, key: &str) -> Vec<&'a str> {
    let name = |rest: &'a str| rest.split(|c: char| !c.is_alphanumeric() && c != '_').next().unwrap();
    text.lines().filter_map(|line| line.trim().strip_prefix(key).map(name)).collect()
}

/// cbindgen makes the header; where it is not installed this still sees a function, a code or a struct's field that the header lacks.
#[test]
fn the_header_has_what_is_exported() {
    let (source, header) = (include_str!("../src/abi.rs"), include_str!("../include/vibrissa.h"));
    let functions = names(source, "pub extern \"C\" fn ");
    assert!(functions.len() >= 5, "{functions:?}");
    for function in &functions {
        let of = |text: &str, end: char| {
            let from = text.find(&format!("{function}(")).unwrap_or_else(|| panic!("{function} is not in the header"));
            let list = &text[from..from + text[from..].find(end).unwrap()];
            list.split(',').filter(|word| word.contains(' ') || word.contains('(')).count()
        };
        // The last comma of a list on lines of its own ends no parameter.
        let told = source[source.find(&format!("fn {function}(")).unwrap() + 3..].to_owned();
        let parameters = told[..told.find(" ->").unwrap()].matches(": ").count();
        assert_eq!(of(header, ';'), parameters, "parameters of {function}");
    }
    for (name, value) in source.lines().filter_map(|line| line.strip_prefix("pub const ")?.split_once(": i32 = ")) {
        assert!(header.contains(&format!("#define {name} {}\n", value.trim_end_matches(';'))), "{name}");
    }
    for name in names(source, "pub struct ") {
        let body = &source[source.find(&format!("pub struct {name} {{")).unwrap()..];
        let fields = names(&body[..body.find('}').unwrap()], "pub ");
        let end = header.find(&format!("}} {name};")).unwrap_or_else(|| panic!("{name} is not in the header"));
        let told = &header[header[..end].rfind("typedef struct {").unwrap()..end];
        let told = names(told, "double ");
        assert_eq!(told, fields[1..], "fields of {name}");
    }
}
