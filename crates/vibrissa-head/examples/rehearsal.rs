//! The bytes of a head in a run without hardware: moments in nN m as lines of a file, bytes to standard output.

#![allow(clippy::unwrap_used, reason = "an example that cannot go on must stop")]

use std::io::Write;
use vibrissa_head::LONGEST;
use vibrissa_head::simulated::Rehearsal;

fn main() {
    let file = std::env::args().nth(1).unwrap();
    let text = std::fs::read_to_string(file).unwrap();
    let mut rehearsal = Rehearsal::new(300, 0.006);
    for (slot, line) in text.lines().enumerate() {
        let moment = line.parse::<i32>().unwrap();
        let Some(message) = rehearsal.slot(slot, f64::from(moment) * 1e-9, true) else { continue };
        let mut packet = [0; LONGEST];
        let length = message.write(&mut packet).unwrap();
        std::io::stdout().write_all(&packet[..length]).unwrap();
    }
}
