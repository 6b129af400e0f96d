//! The example in C, compiled and run: its numbers against the closed form, which shares no tables with what it calls.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must fail")]

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;
use vibrissa_beam::beam::{Load, Whisker, force_mode, point_mode};
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
}
