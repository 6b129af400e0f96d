//! Damage that files meet: lost, repeated and foreign bytes, numbers out of range, lines out of order, deep nesting, and damage by
//! structure.

use crate::random::Random;
use crate::structure;

/// Longest input (bytes): long enough for every fault of form, short enough for many tries.
const LONGEST: usize = 1 << 16;

/// Numbers at which arithmetic, ranges or conversions change.
const NUMBERS: &[&str] = &[
    "0",
    "-0",
    "1",
    "-1",
    "2",
    "0.5",
    "1e-3",
    "-1e-3",
    "1e-9",
    "1e-15",
    "5e-324",
    "1e-300",
    "1e9",
    "-1e9",
    "1e15",
    "1e154",
    "-1e154",
    "1e300",
    "1.8e308",
    "1e999",
    "-1e999",
    "NaN",
    "nan",
    "inf",
    "-inf",
    "+inf",
    "Infinity",
    "null",
    "true",
    "\"\"",
    "\"75 mm\"",
    "\"1e400 km\"",
    "\"nan m\"",
    "3.141592653589793",
    "-3.141592653589794",
    "6.3",
    "90",
    "255",
    "256",
    "32767",
    "32768",
    "65535",
    "65536",
    "-32769",
    "2147483648",
    "4294967296",
    "9007199254740993",
    "9223372036854775807",
    "9223372036854775808",
    "18446744073709551616",
    "0x10",
    "1_000",
    "1,5",
    "--1",
    "1e",
    ".",
    "",
];

/// Bytes that end, open or split something.
const BYTES: &[u8] = b"\0\t\n\r \"#&'()*+,-./0189:;<=>?@[\\]_`{|}~\x7f\x80\xbf\xc2\xe2\xef\xf0\xfe\xff";

/// `seed` after one to several damages; `other` lends pieces, `words` are the format's own.
pub(crate) fn mutate(seed: &[u8], other: &[u8], words: &[&str], random: &mut Random) -> Vec<u8> {
    let mut text = seed.to_vec();
    let most = [1, 1, 1, 2, 2, 4, 16][random.below(7)];
    let rounds = 1 + random.below(most);
    for _ in 0..rounds {
        match random.below(15) {
            0..=3 => replace_number(&mut text, random),
            4 => swap_bytes(&mut text, random),
            5 => drop_piece(&mut text, random),
            6 => repeat_piece(&mut text, random),
            7 => insert_word(&mut text, words, random),
            8 => replace_word(&mut text, words, random),
            9 => move_line(&mut text, random),
            10 => splice(&mut text, other, random),
            11..=13 => structure::damage(&mut text, random),
            _ => replace_number_slightly(&mut text, random),
        }
        text.truncate(LONGEST);
    }
    if random.one_in(12) {
        text.truncate(random.below(text.len() + 1));
    }
    text
}

/// A random range of `text` of at most `longest` bytes.
fn range(text: &[u8], longest: usize, random: &mut Random) -> core::ops::Range<usize> {
    let start = random.below(text.len() + 1);
    let length = random.below(longest.min(text.len() - start) + 1);
    start..start + length
}

/// The ranges of `text` whose bytes all belong to what `inside` accepts.
fn runs(text: &[u8], inside: impl Fn(u8) -> bool) -> Vec<core::ops::Range<usize>> {
    let (mut found, mut start) = (Vec::new(), None);
    for (index, byte) in text.iter().chain([&b'\n']).enumerate() {
        match (inside(*byte) && index < text.len(), start) {
            (true, None) => start = Some(index),
            (false, Some(from)) => {
                found.push(from..index);
                start = None;
            }
            _ => {}
        }
    }
    found
}

fn numbers(text: &[u8]) -> Vec<core::ops::Range<usize>> {
    let mut found = runs(text, |b| b.is_ascii_digit() || matches!(b, b'.' | b'-' | b'+' | b'e'));
    found.retain(|range| text[range.clone()].iter().any(u8::is_ascii_digit));
    found
}

fn replace_number(text: &mut Vec<u8>, random: &mut Random) {
    let new = random.pick(NUMBERS).copied().unwrap_or_default();
    if let Some(range) = random.pick(&numbers(text)).cloned() {
        text.splice(range, new.bytes());
    }
}

/// A number near the one that stands there: what a range check lets through.
fn replace_number_slightly(text: &mut Vec<u8>, random: &mut Random) {
    let Some(range) = random.pick(&numbers(text)).cloned() else { return };
    let Ok(Ok(old)) = core::str::from_utf8(&text[range.clone()]).map(str::parse::<f64>) else { return };
    let new = match random.below(6) {
        0 => -old,
        1 => old * 10f64.powi(random.below(13) as i32 - 6),
        2 => old + random.signed(),
        3 => old * (1.0 + 1e-9 * random.signed()),
        4 => old.round(),
        _ => old * 2.0 * random.signed(),
    };
    let new = if random.one_in(2) { format!("{new}") } else { format!("{new:e}") };
    text.splice(range, new.into_bytes());
}

fn swap_bytes(text: &mut Vec<u8>, random: &mut Random) {
    for _ in 0..=random.below(4) {
        let at = random.below(text.len());
        let byte = if random.one_in(3) { random.bits() as u8 } else { random.pick(BYTES).copied().unwrap_or(0) };
        match text.get_mut(at) {
            Some(old) => *old = byte,
            None => text.push(byte),
        }
    }
}

fn drop_piece(text: &mut Vec<u8>, random: &mut Random) {
    let longest = if random.one_in(2) { 4 } else { 200 };
    let range = range(text, longest, random);
    text.drain(range);
}

/// Repeats a piece: up to twice often, thousands of times now and then.
fn repeat_piece(text: &mut Vec<u8>, random: &mut Random) {
    let longest = if random.one_in(2) { 8 } else { 300 };
    let range = range(text, longest, random);
    let piece = text[range.clone()].to_vec();
    let times = if random.one_in(20) { LONGEST / piece.len().max(1) } else { 1 + random.below(3) };
    let room = LONGEST.saturating_sub(text.len());
    let copies: Vec<u8> = piece.iter().copied().cycle().take((piece.len() * times).min(room)).collect();
    text.splice(range.end..range.end, copies);
}

fn insert_word(text: &mut Vec<u8>, words: &[&str], random: &mut Random) {
    let at = random.below(text.len() + 1);
    let word = random.pick(words).copied().unwrap_or("[");
    text.splice(at..at, word.bytes());
}

fn replace_word(text: &mut Vec<u8>, words: &[&str], random: &mut Random) {
    let found = runs(text, |b| b.is_ascii_alphabetic() || b == b'_');
    let Some(range) = random.pick(&found).cloned() else { return };
    let own = random.pick(&found).cloned().unwrap_or(0..0);
    let word = match random.pick(words) {
        Some(word) if random.one_in(2) => word.as_bytes().to_vec(),
        _ => text[own].to_vec(),
    };
    text.splice(range, word);
}

fn move_line(text: &mut Vec<u8>, random: &mut Random) {
    let mut lines: Vec<&[u8]> = text.split(|b| *b == b'\n').collect();
    let line = lines.remove(random.below(lines.len()));
    for _ in 0..random.below(3) {
        lines.insert(random.below(lines.len() + 1), line);
    }
    *text = lines.join(&b'\n');
}

fn splice(text: &mut Vec<u8>, other: &[u8], random: &mut Random) {
    let from = range(other, 400, random);
    let to = range(text, 400, random);
    text.splice(to, other[from].iter().copied());
}

#[cfg(test)]
mod tests {
    use super::{LONGEST, mutate};
    use crate::random::Random;

    #[test]
    fn the_same_seed_gives_the_same_damage_and_damage_is_damage() {
        let seed = b"t,x\n0.5,-1e-3\n".as_slice();
        let run = |number: u64| mutate(seed, b"[1, 2]", &["word"], &mut Random::new(number));
        assert!((0..500).all(|n| run(n) == run(n)));
        assert!((0..500).filter(|n| run(*n) == seed).count() < 100);
        assert!((0..5000).all(|n| run(n).len() <= LONGEST));
        assert!(mutate(b"", b"", &[], &mut Random::new(1)).len() <= LONGEST);
    }
}
