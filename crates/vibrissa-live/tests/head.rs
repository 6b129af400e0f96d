//! From the bytes of a sensor head to a pose, with losses on the wire: those of a simulated head, or of an emulated processor that
//! `firmware/check` names.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must fail")]

mod common;

use common::Dice;
use std::fmt::Write;
use std::path::Path;
use vibrissa::flow::pose::Status;
use vibrissa::sensing::SensingChain;
use vibrissa::tasks::demo;
use vibrissa::world::{MountedWhisker, Robot};
use vibrissa_head::LONGEST;
use vibrissa_head::frame::Message;
use vibrissa_head::simulated::{FluxNoise, NOISE, Rehearsal};
use vibrissa_live::estimate::LiveEstimator;
use vibrissa_live::pipeline::Pipeline;
use vibrissa_live::setup::from_toml;
use vibrissa_live::source::{Arrived, Chunk};

/// The moments of the demo's sweep at a third of its speed (nN m), one a line: what the emulated processor feels, too.
const MOMENTS: &str = "../../firmware/moments.txt";
/// Largest moment that the simulated sensor is calibrated for (N m).
const LARGEST: f64 = 0.006;

/// The packets of a head.
fn packets(moments: &[f64], faulty: bool) -> Vec<u8> {
    let mut rehearsal = Rehearsal::new(300, LARGEST);
    let mut bytes = Vec::new();
    for (slot, moment) in moments.iter().enumerate() {
        let Some(message) = rehearsal.slot(slot, *moment, faulty) else { continue };
        let mut packet = [0; LONGEST];
        let length = message.write(&mut packet).unwrap();
        bytes.extend(&packet[..length]);
    }
    bytes
}

/// The numbers of the readings in bytes that nothing has happened to, and how many of them hold a moment.
fn numbers(bytes: &[u8]) -> (Vec<u32>, usize) {
    let readings = bytes.split(|byte| *byte == 0).filter_map(|packet| match Message::read(packet) {
        Ok(Message::Reading(reading)) => Some(reading),
        _ => None,
    });
    let (mut numbers, mut with_moment) = (Vec::new(), 0);
    for reading in readings {
        numbers.push(reading.number);
        with_moment += usize::from(reading.moment.is_some());
    }
    (numbers, with_moment)
}

#[test]
fn packets_of_a_head_with_losses_on_the_wire_become_a_pose_and_every_loss_is_counted() {
    let map = demo::arena().unwrap();
    let sweep = demo::sweep_at(1, 0.05).unwrap();
    let moment = sweep.log.channels.iter().position(|c| c.quantity.word() == "moment").unwrap();
    let rounded: Vec<i64> = sweep.log.rows.iter().map(|row| (row.readings[moment] * 1e9).round() as i64).collect();
    let text = rounded.iter().fold(String::new(), |mut text, value| {
        writeln!(text, "{value}").unwrap();
        text
    });
    let kept = Path::new(env!("CARGO_MANIFEST_DIR")).join(MOMENTS);
    if std::env::var_os("RECORD").is_some() {
        std::fs::write(&kept, &text).unwrap();
    }
    assert!(std::fs::read_to_string(&kept).unwrap() == text, "{MOMENTS} is of another sweep: run this with RECORD=1");
    let moments: Vec<f64> = rounded.iter().map(|value| *value as f64 * 1e-9).collect();
    let told = packets(&moments, true);
    let sent = match std::env::var_os("HEAD_BYTES") {
        Some(path) => std::fs::read(path).unwrap(),
        None => told.clone(),
    };
    assert!(sent == told, "the processor's bytes are not those of the host: {} and {}", sent.len(), told.len());
    let (seen, with_moment) = numbers(&sent);

    // Every hundredth packet loses a byte, and one packet in three hundred is gone.
    let mut dice = Dice::new(5);
    let (mut wire, mut gone, mut garbled) = (Vec::new(), 0, 0);
    for (k, packet) in sent.split_inclusive(|byte| *byte == 0).enumerate() {
        let mut packet = packet.to_vec();
        match k {
            k if k % 300 == 150 => {
                gone += 1;
                continue;
            }
            k if k % 100 == 50 => {
                packet.remove(dice.below(packet.len() - 1));
                garbled += 1;
            }
            _ => {}
        }
        wire.extend(packet);
    }

    let base = sweep.log.rows.iter().enumerate().fold(String::new(), |mut text, (slot, row)| {
        let (t, pose) = (slot as f64 / 300.0, row.odom_from_robot);
        writeln!(text, "{t:.6},{:.7},{:.7},{:.8}", pose.x, pose.y, pose.theta).unwrap();
        text
    });
    let text = "map = \"none.svg\"\n[[source]]\nname = \"whisker\"\npipe = \"head.bin\"\nformat = \"head\"\ntime = \"own\"\n\
                [[source]]\nname = \"base\"\npipe = \"base.csv\"\ntime = \"own\"\ncolumns = [\"t\", \"x\", \"y\", \"theta\"]\n";
    let setup = from_toml(text, "live.toml").unwrap();
    let mut whisker = MountedWhisker::default();
    // The chip's noise at its most where the whisker is free, a count, and what the curve leaves.
    let chain = SensingChain::default();
    let per_flux = 1e-4 / (chain.flux(1e-4)[1] - chain.flux(0.0)[1]).abs();
    whisker.noise.moment_absolute += FluxNoise::most(NOISE) * per_flux + 5e-6;
    let robot = Robot { whiskers: vec![whisker], ..Robot::default() };
    // No threads: the same rows on any machine.
    let mut pipeline = Pipeline::new(&setup, &robot).unwrap();
    let mut rows = Vec::new();
    let mut push = |source, arrival: f64, bytes: &[u8]| {
        let chunk = Chunk { source, arrival, what: Arrived::Bytes(bytes.to_vec()) };
        pipeline.push(&chunk, &mut |row| rows.push(row)).unwrap();
    };
    // Odometry and packets side by side, the packets in pieces that do not care where one ends.
    let lines: Vec<&str> = base.split_inclusive('\n').collect();
    let size = wire.len().div_ceil(lines.len());
    for (slot, line) in lines.iter().enumerate() {
        let t = slot as f64 / 300.0;
        push(1, t, line.as_bytes());
        push(0, t, &wire[(slot * size).min(wire.len())..((slot + 1) * size).min(wire.len())]);
    }
    pipeline.finish(&mut |row| rows.push(row));
    let channels = pipeline.channels().unwrap().to_vec();
    let mut estimator = LiveEstimator::new(&map, &robot, &channels, &setup.method, setup.estimate_rate).unwrap();
    for row in &rows {
        estimator.step(row).unwrap();
    }
    let estimate = estimator.estimate();
    let counts = *pipeline.counts().next().unwrap().1;
    assert!(counts.unjoined < 5, "{counts:?}");
    assert_eq!(rows.len() as u64 + counts.uncalibrated + counts.unjoined, counts.frames, "{counts:?}");
    // What the head missed and what the wire lost are gaps in the numbers, but for the ends.
    let slots = u64::from(seen.last().unwrap() - seen[0] + 1);
    assert_eq!(counts.frames + counts.lost, slots, "{counts:?}");
    assert_eq!(counts.damaged, garbled, "{counts:?}");
    assert_eq!(counts.frames, seen.len() as u64 - gone - garbled, "{counts:?}");
    let without = seen.len() - with_moment;
    assert!(without > 0 && counts.uncalibrated <= without as u64 && counts.uncalibrated + 2 >= without as u64);
    assert!(counts.saturated > 0, "{counts:?}");

    assert_eq!(estimate.status, Status::Localized);
    let truth = sweep.truth.last().unwrap().map_from_robot;
    let off = estimate.pose().unwrap().position().distance(truth.position());
    println!("off by {:.3} mm; {}", off * 1e3, counts.words());
    assert!(off < 5e-3, "off by {off} m");
}
