//! Disks that are slow, full or lose power: what was synchronised is there, what was dropped is counted.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::float_cmp,
    reason = "a test that cannot go on must fail"
)]

mod common;

use common::Dice;
use std::io::{Error, ErrorKind, Result};
use std::sync::{Arc, Condvar, Mutex};
use vibrissa::io::ros::{BagStream, GrowingFile, Kind, Stamp, decode_text, encode_text, read_bag};
use vibrissa_live::record::{Recorder, Storage, Synchroniser};

/// The texts that a file holds, in order; an error where it cannot be read at all.
fn texts(bytes: &[u8]) -> vibrissa::Result<Vec<String>> {
    let mut found = Vec::new();
    read_bag(bytes, "cut.mcap", |_, _, message| {
        found.extend(decode_text(message).map(str::to_owned));
        Ok(())
    })?;
    Ok(found)
}

/// Ten thousand power cuts: everything up to the last synchronisation is there; of what came after any blocks may be there, in
/// any order, or filled with zeros, or cut.
#[test]
fn ten_thousand_power_cuts_lose_nothing_that_was_synchronised() {
    let mut dice = Dice::new(99);
    for cut in 0..10_000 {
        let mut stream = BagStream::new();
        let topic = stream.topic("/raw/w0", Kind::Text, false);
        let (mut file, mut sent, mut count) = (Vec::new(), Vec::new(), 0);
        for _ in 0..=dice.below(4) {
            for _ in 0..=dice.below(6) {
                let text = format!("line {count} {}", "x".repeat(dice.below(60)));
                stream.push(topic, Stamp::from_seconds(f64::from(count)), &encode_text(&text));
                sent.push(text);
                count += 1;
            }
            file.extend(stream.flush());
        }
        let mut safe = sent.len();
        // What was written and not synchronised yet.
        for _ in 0..=dice.below(8) {
            let text = format!("unsafe {count} {}", "y".repeat(dice.below(200)));
            stream.push(topic, Stamp::from_seconds(f64::from(count)), &encode_text(&text));
            sent.push(text);
            count += 1;
        }
        let mut tail = stream.flush();
        if dice.below(3) == 0 {
            // The index is written when all before it is on the disk, and the last eight bytes after it.
            file.extend(&tail);
            safe = sent.len();
            tail = stream.finish();
            tail.truncate(tail.len() - 8);
        }
        let block = 1 + dice.below(128);
        match dice.below(5) {
            0 => tail.truncate(dice.below(tail.len())),
            1 => tail.chunks_mut(block).filter(|_| dice.below(2) == 0).for_each(|block| block.fill(0)),
            2 => tail.fill(0),
            3 => {
                // The file's length is there, its bytes are those of another file.
                let end = tail.len();
                tail[dice.below(end)..].iter_mut().for_each(|byte| *byte = (dice.next() >> 32) as u8);
            }
            _ => {
                tail.chunks_mut(block).filter(|_| dice.below(3) == 0).for_each(<[u8]>::reverse);
                tail.truncate(dice.below(tail.len()));
            }
        }
        file.extend(&tail);
        match texts(&file) {
            Ok(found) => assert_eq!(found[..safe], sent[..safe], "cut {cut}"),
            Err(error) => panic!("cut {cut}: {error}"),
        }
    }
}

/// A disk in memory that a test can hold, fill and look at.
#[derive(Clone, Default)]
struct Disk(Arc<(Mutex<State>, Condvar)>);

#[derive(Default)]
struct State {
    bytes: Vec<u8>,
    held: bool,
    /// Whether no synchronisation returns, whether the next one fails and forgets what was written since the last one, and up to where
    /// bytes are safe.
    slow: bool,
    forgets: bool,
    safe: usize,
    /// Whether reading does not come back, as long as nobody is in a hurry; whether somebody tried.
    unreadable: bool,
    looked: bool,
    /// Room that is left; none without end.
    room: Option<usize>,
    refusals: usize,
}

impl Disk {
    fn change(&self, change: impl FnOnce(&mut State)) {
        change(&mut self.0.0.lock().unwrap());
        self.0.1.notify_all();
    }

    fn wait_for(&self, condition: impl Fn(&State) -> bool) {
        let state = self.0.0.lock().unwrap();
        drop(self.0.1.wait_while(state, |state| !condition(state)).unwrap());
    }

    fn bytes(&self) -> Vec<u8> {
        self.0.0.lock().unwrap().bytes.clone()
    }
}

impl GrowingFile for Disk {
    fn append(&mut self, bytes: &[u8]) -> Result<()> {
        let state = self.0.0.lock().unwrap();
        let mut state = self.0.1.wait_while(state, |state| state.held).unwrap();
        let fits = state.room.map_or(bytes.len(), |room| room.saturating_sub(state.bytes.len()).min(bytes.len()));
        state.bytes.extend(&bytes[..fits]);
        state.refusals += usize::from(fits < bytes.len());
        self.0.1.notify_all();
        if fits < bytes.len() { Err(Error::from(ErrorKind::StorageFull)) } else { Ok(()) }
    }

    fn read_at(&mut self, place: u64, buffer: &mut [u8]) -> Result<usize> {
        let mut state = self.0.0.lock().unwrap();
        state.looked = true;
        self.0.1.notify_all();
        if state.unreadable {
            // Nothing is read: asked again and again.
            return Err(Error::from(ErrorKind::Interrupted));
        }
        state.bytes.read_at(place, buffer)
    }
}

impl Storage for Disk {
    fn synchroniser(&self) -> Synchroniser {
        let disk = self.clone();
        Box::new(move || {
            let state = disk.0.0.lock().unwrap();
            // What is written while a synchronisation goes on is not part of it.
            let length = state.bytes.len();
            let mut state = disk.0.1.wait_while(state, |state| state.slow).unwrap();
            if core::mem::take(&mut state.forgets) {
                let safe = state.safe;
                state.bytes[safe..].fill(0);
                state.refusals += 1;
                disk.0.1.notify_all();
                return Err(Error::from(ErrorKind::Other));
            }
            state.safe = state.safe.max(length.min(state.bytes.len()));
            disk.0.1.notify_all();
            Ok(())
        })
    }

    fn truncate(&mut self, length: u64) -> Result<()> {
        self.change(|state| {
            assert!(state.safe <= length as usize, "what was synchronised is taken away");
            state.bytes.truncate(length as usize);
        });
        Ok(())
    }
}

#[test]
fn a_slow_disk_never_stalls_the_caller_and_what_is_dropped_is_counted() {
    let disk = Disk::default();
    disk.change(|state| state.held = true);
    let (recorder, topics) = Recorder::with_limit(disk.clone(), &[("/raw/w0".to_owned(), Kind::Text, false)], 20_000);
    // The disk does not answer at all, and yet every call returns.
    let kept = (0..5000).filter(|i| recorder.push(topics[0], f64::from(*i), encode_text(&format!("{i}")))).count();
    assert!(kept > 100 && kept < 5000, "{kept} kept");
    assert_eq!(recorder.dropped(), 5000 - kept as u64);
    disk.change(|state| state.held = false);
    recorder.finish().unwrap();
    let found = texts(&disk.bytes()).unwrap();
    assert_eq!(found.len(), kept);
}

#[test]
fn writing_goes_on_while_the_disk_synchronises_and_what_is_dropped_is_counted() {
    let disk = Disk::default();
    disk.change(|state| state.slow = true);
    let (recorder, topics) = Recorder::with_limit(disk.clone(), &[("/raw/w0".to_owned(), Kind::Text, false)], 20_000);
    for i in 0..20 {
        let text = format!("line {i}");
        assert!(recorder.push(topics[0], f64::from(i), encode_text(&text)));
        // It is with the system, though no synchronisation has come back yet: `kill -9` would not lose it.
        disk.wait_for(|state| texts(&state.bytes).is_ok_and(|found| found.last() == Some(&text)));
    }
    assert_eq!(recorder.synced(), 0);
    // Memory is bounded all the same.
    let kept =
        20 + (20..5000).filter(|i| recorder.push(topics[0], f64::from(*i), encode_text(&format!("{i}")))).count();
    assert!(kept > 100 && kept < 1000, "{kept} kept");
    std::thread::sleep(std::time::Duration::from_millis(200));
    assert!(!recorder.push(topics[0], 5e3, encode_text("no room")), "written is not yet safe, and stays in memory");
    assert_eq!(recorder.dropped(), 5001 - kept as u64);
    disk.change(|state| state.slow = false);
    recorder.finish().unwrap();
    assert_eq!(texts(&disk.bytes()).unwrap().len(), kept);
}

#[test]
fn who_has_to_leave_at_once_leaves_a_whole_file() {
    let disk = Disk::default();
    let topic = [("/raw/w0".to_owned(), Kind::Text, false)];
    let (recorder, topics) = Recorder::with_limit(disk.clone(), &topic, 1 << 20);
    // Messages of more than a hundredth of the memory are chunks of their own: more of them than an index is kept for.
    let long = "z".repeat(11_000);
    for i in 0..1100 {
        while !recorder.push(topics[0], f64::from(i), encode_text(&long)) {
            std::thread::yield_now();
        }
    }
    disk.wait_for(|state| state.bytes.len() > 1000 * long.len());
    assert!(recorder.push(topics[0], 2e3, encode_text("last")));
    // The index is made by reading the file: that takes for ever here.
    disk.change(|state| state.unreadable = true);
    let closer = recorder.closer();
    let ending = std::thread::spawn(move || recorder.finish());
    disk.wait_for(|state| state.looked);
    assert!(closer.close_now(20.0));
    ending.join().unwrap().unwrap();
    let bytes = disk.bytes();
    let found = texts(&bytes).unwrap();
    assert_eq!(
        (found.len(), found.last().map(String::as_str)),
        (1101, Some("last")),
        "what was refused was offered again"
    );
    let summary = read_bag(&bytes[..], "hurried.mcap", |_, _, _| Ok(())).unwrap();
    assert!(summary.warnings.is_empty(), "{:?}", summary.warnings);
    assert!(closer.close_now(0.0), "a closed file stays closed");
}

#[test]
fn a_disk_that_never_answers_holds_nobody_who_has_to_leave() {
    let disk = Disk::default();
    let (recorder, topics) = Recorder::begin(disk.clone(), &[("/raw/w0".to_owned(), Kind::Text, false)]);
    disk.change(|state| state.slow = true);
    assert!(recorder.push(topics[0], 0.0, encode_text("first")));
    disk.wait_for(|state| !state.bytes.is_empty());
    assert!(!recorder.closer().close_now(0.2));
    assert_eq!(texts(&disk.bytes()).unwrap(), ["first"]);
    disk.change(|state| state.slow = false);
    recorder.finish().unwrap();
}

#[test]
fn what_a_disk_forgets_instead_of_synchronising_is_written_again() {
    let disk = Disk::default();
    let (recorder, topics) = Recorder::begin(disk.clone(), &[("/raw/w0".to_owned(), Kind::Text, false)]);
    for i in 0..600 {
        match i {
            // In the middle, and at the very end.
            200 | 599 => disk.change(|state| state.forgets = true),
            400 => disk.wait_for(|state| state.refusals == 1),
            _ => {}
        }
        assert!(recorder.push(topics[0], f64::from(i), encode_text(&format!("line {i}"))));
    }
    recorder.finish().unwrap();
    assert_eq!(disk.0.0.lock().unwrap().refusals, 2);
    assert_eq!(texts(&disk.bytes()).unwrap(), (0..600).map(|i| format!("line {i}")).collect::<Vec<_>>());
}

#[test]
fn a_full_disk_is_told_and_tried_again_and_nothing_is_lost() {
    let disk = Disk::default();
    disk.change(|state| state.room = Some(3000));
    let (recorder, topics) = Recorder::begin(disk.clone(), &[("/raw/w0".to_owned(), Kind::Text, false)]);
    for i in 0..500 {
        assert!(recorder.push(topics[0], f64::from(i), encode_text(&format!("line {i}"))));
    }
    disk.wait_for(|state| state.refusals > 0);
    while recorder.fault().is_none() {
        std::thread::yield_now();
    }
    // Somebody makes room.
    disk.change(|state| state.room = None);
    recorder.finish().unwrap();
    let found = texts(&disk.bytes()).unwrap();
    assert_eq!(found, (0..500).map(|i| format!("line {i}")).collect::<Vec<_>>());
}

#[test]
fn a_disk_that_stays_full_is_an_error_and_what_was_before_is_whole() {
    let disk = Disk::default();
    disk.change(|state| state.room = Some(5000));
    let (recorder, topics) = Recorder::begin(disk.clone(), &[("/raw/w0".to_owned(), Kind::Text, false)]);
    assert!(recorder.push(topics[0], 0.0, encode_text("first")));
    disk.wait_for(|state| !state.bytes.is_empty());
    let long = "z".repeat(6000);
    assert!(recorder.push(topics[0], 1.0, encode_text(&long)));
    assert!(recorder.finish().is_err());
    assert_eq!(texts(&disk.bytes()).unwrap(), ["first"]);
}
