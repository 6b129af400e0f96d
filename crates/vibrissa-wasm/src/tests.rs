//! What the page is told is what the library says; the page's own tests compare it with the command.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::float_cmp,
    reason = "a test that cannot go on must fail"
)]

use crate::host::Host;
use crate::{bend, contacts, driving, files, localizing, whiskers};
use vibrissa::beam::{Load, Whisker, point_mode};
use vibrissa::plane::{Pose2, Vec2};
use vibrissa::tasks::demo;
use vibrissa::{Method, Robot, localize};

fn give(host: &mut Host, name: &str, content: &str) {
    host.input = [name.as_bytes(), b"\0", content.as_bytes()].concat();
}

fn give_numbers(host: &mut Host, numbers: &[f64]) {
    host.input = numbers.iter().flat_map(|v| v.to_le_bytes()).collect();
}

fn with_arena() -> Host {
    let mut host = Host::default();
    give(&mut host, "arena.svg", demo::ARENA_SVG);
    files::read(&mut host, 0).unwrap();
    host.numbers.clear();
    host
}

#[test]
fn a_bend_is_told_whole() {
    let mut host = Host::default();
    bend::solve(&mut host, 1, 0.055, 0.02, 0, 0.0).unwrap();
    let bends = point_mode(&Whisker::default(), Vec2::new(0.055, 0.02), Load::Normal).unwrap();
    let points = host.numbers[1] as usize;
    assert_eq!(host.numbers[..2], [bends.len() as f64, 101.0]);
    assert_eq!(host.numbers.len(), 2 + bends.len() * (14 + 2 * points));
    assert!((host.numbers[8] - bends[0].moment).abs() < 1e-18);
    assert!(bend::solve(&mut host, 9, 0.055, 0.02, 0, 0.0).unwrap_err().is_usage());
}

#[test]
fn a_drive_is_localized_as_its_log() {
    let mut host = with_arena();
    let path = demo::path().unwrap();
    let first = path[0].map_from_robot;
    give_numbers(&mut host, &[path[0].t, first.x, first.y, first.theta, 1.0, 1.0]);
    driving::drive(&mut host, 0).unwrap();
    for part in path[1..].chunks(37) {
        let pose = |p: &vibrissa::flow::pose::StampedPose| {
            let at = p.map_from_robot;
            [p.t, at.x, at.y, at.theta, 0.0, 0.0, 0.0]
        };
        let numbers: Vec<f64> = part.iter().flat_map(pose).collect();
        host.numbers.clear();
        give_numbers(&mut host, &numbers);
        driving::drive(&mut host, 1).unwrap();
        assert_eq!(host.numbers[..2], [part.len() as f64, 1.0]);
    }
    assert_eq!(host.log.rows.len(), path.len());
    host.input = b"deterministic".to_vec();
    localizing::localize(&mut host, 0, 0).unwrap();
    localizing::localize(&mut host, 2, 100).unwrap();
    assert_eq!(host.numbers, [100.0, path.len() as f64, 1.0]);
    localizing::localize(&mut host, 2, u32::MAX).unwrap();
    host.numbers.clear();
    localizing::localize(&mut host, 3, 0).unwrap();
    let method = Method::named("deterministic").unwrap();
    let arena = demo::arena().unwrap();
    let expected = localize(&host.log, &arena, &Robot::default(), &method, &mut |_| {}).unwrap();
    let best = expected.estimate.unwrap();
    assert_eq!(host.numbers[..4], [0.0, path.len() as f64, expected.hypotheses.len() as f64, 0.0]);
    assert_eq!(host.numbers[4..7], [best.x, best.y, best.theta]);
    assert!(host.text.contains("\"localized\""), "{}", host.text);
    assert!(localizing::localize(&mut host, 3, 0).is_err(), "it ends once");
    files::write(&mut host, 2).unwrap();
    assert!(host.text.starts_with("<svg") || host.text.starts_with("<?xml"), "{}", &host.text[..60]);
}

/// Against the simulator, which bends the whisker by another iteration.
#[test]
fn whiskers_at_a_row_hang_where_the_simulated_ones_do() {
    let mut host = with_arena();
    let sweep = demo::sweep(1).unwrap();
    host.log = sweep.log.clone();
    let mut held = 0;
    for row in (0..host.log.rows.len()).step_by(23) {
        let at = sweep.truth[row].map_from_robot;
        whiskers::bent(&mut host, row, at).unwrap();
        let [count, from, x, y, moment, points] = host.numbers[..6] else { panic!("{:?}", host.numbers) };
        assert_eq!((count, host.numbers.len()), (1.0, 6 + 2 * points as usize));
        let base = Vec2::new(host.numbers[6], host.numbers[7]);
        let mount = host.robot.whiskers[0].robot_from_whisker;
        assert!(base.distance(at.compose(mount).position()) < 1e-12);
        let Some(touch) = sweep.contacts.iter().find(|touch| touch.row == row) else {
            assert!(from < 2.0, "row {row} is free, and bent at {x}, {y}");
            continue;
        };
        held += 1;
        let off = touch.position.distance(Vec2::new(x, y));
        assert!(from == 2.0 && off < 1e-6, "row {row}: {off} m off");
        // The readings have noise within their bound.
        let noise = host.robot.whiskers[0].noise;
        let read = host.log.rows[row].readings[0];
        assert!(
            (read - moment).abs() <= noise.moment_relative * read.abs() + noise.moment_absolute + 1e-9,
            "row {row}"
        );
        let end = host.numbers.len();
        let tip = Vec2::new(host.numbers[end - 2], host.numbers[end - 1]);
        assert!(touch.s_a < 0.0749 || tip.distance(touch.position) < 1e-6, "row {row}: the tip is at {tip:?}");
    }
    assert!(held > 10, "{held}");
    assert!(whiskers::bent(&mut host, 9999, Pose2::IDENTITY).unwrap_err().is_usage());
    // Off the wall the map bends nothing: the reading alone does.
    let touch = &sweep.contacts[40];
    let at = sweep.truth[touch.row].map_from_robot;
    let off = touch.force * (0.02 / touch.force.norm());
    whiskers::bent(&mut host, touch.row, Pose2::new(at.x + off.x, at.y + off.y, at.theta)).unwrap();
    assert!(host.numbers[1] == 1.0 && host.numbers[2].is_nan() && host.numbers[5] > 2.0, "{:?}", &host.numbers[..6]);
}

#[test]
fn what_is_missing_or_wrong_is_refused_in_words() {
    let mut host = Host::default();
    assert!(contacts::preimage(&mut host, 3, 4e-3, 5e-3, 5e-3, 36).is_err());
    assert!(contacts::contact_set(&mut host, 3, 5e-3, 4e-3, 0).is_err());
    assert!(localizing::localize(&mut host, 0, 0).is_err());
    give(&mut host, "room.pgm", "P5");
    let words = files::read(&mut host, 0).unwrap_err();
    let words = host.words_of(words);
    assert!(words.contains("room.pgm") && words.contains("an image alone is no map"), "{words}");
    give(&mut host, "short.csv", "t,x,y,theta,moment\n0,0,0,0,0\n1,2\n2,0,0,0,0\n");
    let words = files::read(&mut host, 2).unwrap_err().to_string();
    assert!(words.contains("short.csv") && words.contains('3'), "{words}");
}

#[cfg(feature = "ros-map")]
#[test]
fn a_map_of_ros_takes_its_image_along() {
    const YAML: &str =
        "image: room.pgm\nresolution: 0.01\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.2\n";
    let mut host = Host::default();
    give(&mut host, "room.yaml", YAML);
    let words = files::read(&mut host, 0).unwrap_err().to_string();
    assert!(words.contains("room.pgm"), "{words}");
    let pixels: String =
        (0..40 * 30).map(|k| if matches!((k % 40, k / 40), (4..36, 4..26)) { "254 " } else { "0 " }).collect();
    for image in ["other.pgm", "room.pgm"] {
        give(&mut host, image, &format!("P2\n40 30\n255\n{pixels}"));
        files::read(&mut host, 4).unwrap();
        give(&mut host, "room.yaml", YAML);
        assert_eq!(files::read(&mut host, 0).is_ok(), image == "room.pgm");
    }
    assert!(host.numbers[0] >= 1.0, "an outline");
}

#[test]
fn a_recording_is_a_log() {
    let mut host = Host::default();
    give(&mut host, "cut.mcap", "nothing of the kind");
    let words = files::read(&mut host, 2).unwrap_err().to_string();
    assert!(words.contains("cut.mcap") && words.to_lowercase().contains("mcap"), "{words}");
}

#[test]
fn a_preimage_and_its_headings_belong_together() {
    let mut host = with_arena();
    contacts::preimage(&mut host, 3, 3.8e-3, 4.2e-3, 8e-3, 36).unwrap();
    let (x, y, cell, columns) = (host.numbers[5], host.numbers[6], host.numbers[7], host.numbers[8] as usize);
    let shares = host.numbers[10..].to_vec();
    let index = shares.iter().position(|&share| share > 0.0 && share < 1.0).unwrap();
    let place = |count: usize, origin: f64| origin + (count as f64 + 0.5) * cell;
    contacts::headings(&mut host, place(index % columns, x), place(index / columns, y)).unwrap();
    let sum: f64 = host.numbers.chunks_exact(2).map(|run| run[1] - run[0]).sum();
    assert!((sum / core::f64::consts::TAU - shares[index]).abs() < 1e-12);
}

#[test]
fn a_preimage_that_a_page_would_wait_long_for_is_refused() {
    let mut host = with_arena();
    let refused = contacts::preimage(&mut host, 3, 3.8e-3, 4.2e-3, 1e-5, 3600).unwrap_err();
    assert!(refused.is_usage() && refused.to_string().contains("coarser cells"), "{refused}");
    let refused = contacts::preimage(&mut host, 3, 3.8e-3, 4.2e-3, 0.0, 36).unwrap_err();
    assert!(refused.to_string().contains("1e-5 to 1 m"), "{refused}");
}
