//! Bytes of messages: what comes through is what was sent, whatever happens to the wire.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must fail")]

use vibrissa_head::calibration::{Calibration, Response, Signal};
use vibrissa_head::command::{Command, Inbox, Refusal};
use vibrissa_head::frame::{ChipName, Health, Identity, Message, Reading, State};
use vibrissa_head::{Damage, LONGEST};

/// Numbers from a seed, the same everywhere.
struct Dice(u64);

impl Dice {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        self.0 >> 16
    }

    fn below(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }

    fn real(&mut self) -> f64 {
        (self.next() as f64 / 2f64.powi(47) - 1.0) * 10f64.powi(self.below(12) as i32 - 9)
    }
}

fn message(dice: &mut Dice) -> Message {
    match dice.below(5) {
        0 => Message::Health(Health { slots: dice.next() as u32, freed: 3, ..Health::default() }),
        1 => Message::Identity(Identity { version: 1, chip: ChipName::Tle493d, rate: 300, calibrated_axes: 2 }),
        2 => Message::Refused(Refusal::TooFast),
        _ => Message::Reading(Reading {
            number: dice.next() as u32,
            stamp_us: dice.next() as u32,
            flux: [0; 3].map(|_| dice.real() as f32),
            moment: (dice.below(3) > 0).then(|| dice.real()),
            across: (dice.below(3) == 0).then(|| dice.real()),
            state: State(dice.next() as u8),
        }),
    }
}

fn written(message: &Message) -> Vec<u8> {
    let mut bytes = [0; LONGEST];
    let length = message.write(&mut bytes).unwrap();
    bytes[..length].to_vec()
}

#[test]
fn a_packet_has_one_zero_and_is_read_as_it_was_written() {
    let mut dice = Dice(1);
    let mut longest = 0;
    for _ in 0..20_000 {
        let sent = message(&mut dice);
        let bytes = written(&sent);
        longest = longest.max(bytes.len());
        let (end, body) = bytes.split_last().unwrap();
        assert!(*end == 0 && !body.contains(&0));
        assert_eq!(Message::read(body), Ok(sent));
        let room = dice.below(bytes.len());
        assert_eq!(sent.write(&mut vec![0; room]), None, "{room} bytes are too few");
    }
    assert!(longest <= 52, "{longest}");
}

/// The check value of the catalogue, and one packet byte by byte: what other languages are to write.
#[test]
fn the_bytes_of_a_packet_are_those_that_are_documented() {
    let done = written(&Message::Done);
    // 03 is the fourth message; 4b0bbe37 its CRC-32, low byte first.
    assert_eq!(done, [6, 3, 0x37, 0xbe, 0x0b, 0x4b, 0]);
    let reading = Reading { number: 300, stamp_us: 5, flux: [0.0, 1.0, -2.0], moment: Some(1.0), ..Reading::default() };
    let body = [0, 0xac, 2, 5, 0, 0, 0, 0, 0, 0, 0x80, 0x3f, 0, 0, 0, 0xc0, 1, 0, 0, 0, 0, 0, 0, 0xf0, 0x3f, 0, 0];
    let mut want = body.to_vec();
    want.extend(crc32(&body).to_le_bytes());
    assert_eq!(without_zeros(&written(&Message::Reading(reading))), want);
}

/// The checksum bit by bit.
fn crc32(bytes: &[u8]) -> u32 {
    let step = |crc: u32| if crc & 1 == 1 { crc >> 1 ^ 0xedb8_8320 } else { crc >> 1 };
    !bytes.iter().fold(!0, |crc, byte| (0..8).fold(crc ^ u32::from(*byte), |crc, _| step(crc)))
}

/// The bytes that a packet stands for: each block begins with how far the next zero is.
fn without_zeros(packet: &[u8]) -> Vec<u8> {
    let (mut out, mut rest) = (Vec::new(), packet);
    while let Some((distance, tail)) = rest.split_first().filter(|(distance, _)| **distance > 0) {
        let (block, tail) = tail.split_at(usize::from(*distance) - 1);
        out.extend(block);
        out.push(0);
        rest = tail;
    }
    out.pop();
    out
}

#[test]
fn no_damage_is_read_as_another_message() {
    let mut dice = Dice(7);
    let mut damages = [0; 4];
    for _ in 0..100_000 {
        let sent = message(&mut dice);
        let mut bytes = written(&sent);
        bytes.pop();
        for _ in 0..=dice.below(3) {
            let at = dice.below(bytes.len());
            match dice.below(4) {
                0 => bytes[at] ^= 1 << dice.below(8),
                1 => drop(bytes.remove(at)),
                2 => bytes.insert(at, dice.next() as u8),
                _ => bytes.truncate(at.max(1)),
            }
            if bytes.is_empty() {
                bytes.push(1);
            }
        }
        match Message::read(&bytes) {
            Ok(read) => assert_eq!(read, sent),
            Err(damage) => damages[damage as usize] += 1,
        }
    }
    assert!(damages[Damage::Framing as usize] > 1000 && damages[Damage::Checksum as usize] > 1000, "{damages:?}");
    assert_eq!(Message::read(&[1; LONGEST + 1]), Err(Damage::Long));
}

#[test]
fn noise_is_no_message_and_nothing_falls_over() {
    let mut dice = Dice(3);
    for _ in 0..200_000 {
        let bytes: Vec<u8> = (0..dice.below(80)).map(|_| dice.next() as u8).collect();
        assert!(Message::read(&bytes).is_err() && Command::read(&bytes).is_err(), "{bytes:?}");
    }
}

#[test]
fn commands_come_out_of_bytes_one_by_one() {
    let signal = Signal { direction: [0.1, -0.7, 0.3], range: [1e-4, 2e-3] };
    let plane = Calibration { rest: [1e-3; 3], response: Response::Plane([signal; 2], [[1.0 / 3.0; 10]; 2]) };
    let line = Calibration { rest: [1e-3; 3], response: Response::Line(signal, [1.0 / 3.0; 6]) };
    let commands = [
        Command::Identify,
        Command::Load(plane),
        Command::Tare(100),
        Command::Load(line),
        Command::Rate(500),
        Command::Unload,
    ];
    let mut bytes = vec![0, 0];
    for command in commands {
        let mut packet = [0; LONGEST];
        let length = command.write(&mut packet).unwrap();
        bytes.extend(&packet[..length]);
        // Too much between two zeros is damaged, and the next packet is read again.
        bytes.extend([7; 400]);
        bytes.push(0);
    }
    let mut inbox = Inbox::default();
    let found: Vec<_> = bytes.iter().filter_map(|byte| inbox.push(*byte)).collect();
    assert_eq!(found.len(), 2 * commands.len());
    for (pair, command) in found.chunks(2).zip(commands) {
        assert_eq!(pair, [Ok(command), Err(Damage::Long)]);
    }
}
