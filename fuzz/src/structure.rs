//! Damage by structure: fields that change places, blocks in brackets or tags that are left out, repeated or nested, counts of bytes
//! that are not those of what follows.

use crate::random::Random;
use core::ops::Range;

/// What separates fields in any of the formats.
const SEPARATORS: &[u8] = b",;:=<>[]{}()\" \t\n";
/// Pairs that hold a block.
const PAIRS: [(u8, u8); 3] = [(b'[', b']'), (b'{', b'}'), (b'<', b'>')];
/// Most bytes that a block is repeated to.
const LARGEST: usize = 1 << 15;

/// Does one such damage.
pub(crate) fn damage(text: &mut Vec<u8>, random: &mut Random) {
    // Formats of bytes have zeros, those of text have none.
    if text.contains(&0) && !random.one_in(3) {
        return change_count(text, random);
    }
    if random.one_in(2) { swap_fields(text, random) } else { change_block(text, random) }
}

/// The fields of a text: what stands between separators.
fn fields(text: &[u8]) -> Vec<Range<usize>> {
    let (mut found, mut start) = (Vec::new(), 0);
    for (at, byte) in text.iter().enumerate() {
        if SEPARATORS.contains(byte) {
            if at > start {
                found.push(start..at);
            }
            start = at + 1;
        }
    }
    found
}

/// One field takes the place of another, or both change places.
fn swap_fields(text: &mut Vec<u8>, random: &mut Random) {
    let fields = fields(text);
    if fields.len() < 2 {
        return;
    }
    let (a, b) = (fields[random.below(fields.len())].clone(), fields[random.below(fields.len())].clone());
    let (first, second) = if a.start <= b.start { (a, b) } else { (b, a) };
    if first.end > second.start {
        return;
    }
    let (one, other) = (text[first.clone()].to_vec(), text[second.clone()].to_vec());
    text.splice(second, one);
    if random.one_in(2) {
        text.splice(first, other);
    }
}

/// A block in brackets, from its opening to its closing one.
fn block(text: &[u8], random: &mut Random) -> Option<Range<usize>> {
    let (open, close) = PAIRS[random.below(PAIRS.len())];
    let starts: Vec<usize> = (0..text.len()).filter(|&at| text[at] == open).collect();
    let start = *starts.get(random.below(starts.len().max(1)))?;
    let mut depth = 0_usize;
    for (at, byte) in text.iter().enumerate().skip(start) {
        depth += usize::from(*byte == open);
        depth -= usize::from(*byte == close);
        if depth == 0 {
            return Some(start..at + 1);
        }
    }
    None
}

/// A block is left out, repeated, or put into itself.
fn change_block(text: &mut Vec<u8>, random: &mut Random) {
    let Some(range) = block(text, random) else { return };
    let whole = text[range.clone()].to_vec();
    match random.below(3) {
        0 => drop(text.drain(range)),
        1 => {
            let most = (LARGEST / whole.len()).clamp(1, 300);
            let times = 2 + random.below(most);
            text.splice(range.end..range.end, whole.repeat(times));
        }
        _ => {
            let middle = range.start + 1 + random.below(whole.len() - 1);
            text.splice(middle..middle, whole);
        }
    }
}

/// A count of four or eight bytes that may be that of what follows becomes another one.
fn change_count(text: &mut [u8], random: &mut Random) {
    let wide = if random.one_in(2) { 8 } else { 4 };
    let counts: Vec<usize> = (0..text.len().saturating_sub(wide))
        .filter(|&at| {
            let value = text[at..at + wide].iter().rev().fold(0_u64, |value, byte| value << 8 | u64::from(*byte));
            value > 0 && value <= text.len() as u64
        })
        .collect();
    let Some(&at) = counts.get(random.below(counts.len().max(1))) else { return };
    let value = text[at..at + wide].iter().rev().fold(0_u64, |value, byte| value << 8 | u64::from(*byte));
    let other = match random.below(6) {
        0 => 0,
        1 => value + 1,
        2 => value - 1,
        3 => value << (8 * random.below(wide)),
        4 => u64::MAX,
        _ => 1 << 26,
    };
    text[at..at + wide].copy_from_slice(&other.to_le_bytes()[..wide]);
}
