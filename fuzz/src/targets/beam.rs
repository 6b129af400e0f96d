//! Whiskers and loads of any size: shapes that are numbers, or a refusal.

use super::{Verdict, promise, read, refused, size};
use crate::random::Random;
use vibrissa::Result;
use vibrissa::beam::{Bend, Load, Whisker, force_mode, moment_mode, point_mode, tip_mode};
use vibrissa::plane::Vec2;

/// Six numbers: whisker length, rigidity, place, force or moment, angle, and the contact's height.
pub(crate) fn draw(random: &mut Random) -> Vec<u8> {
    let wild = [0.0, -0.0, 1e-300, -1e-12, 1e12, 1e300, f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 0.075, 1.0];
    let mut text = String::new();
    for usual in [0.075, 2.8886e-4, 0.075, 0.1, 1.0, 0.05] {
        let value = match random.below(6) {
            0 => *random.pick(&wild).unwrap_or(&0.0),
            1 => usual * 10f64.powi(random.below(9) as i32 - 4) * random.signed(),
            2 => usual,
            _ => usual * random.signed().abs(),
        };
        let value = if random.one_in(4) { -value } else { value };
        text += &format!("{value:?} ");
    }
    text.into_bytes()
}

/// Nine numbers: those of [`draw`], then taper, curvature and the base's stiffness, within what a robot file may say.
pub(crate) fn draw_rod(random: &mut Random) -> Vec<u8> {
    let mut text = String::new();
    let between = |low: f64, high: f64, random: &mut Random| low * (high / low).powf(0.5 + 0.5 * random.signed());
    let (length, rigidity) = (between(1e-3, 10.0, random), between(1e-12, 10.0, random));
    let s_a = length * between(1e-3, 1.0, random);
    let load = random.signed() * rigidity / (length * length) * between(1e-3, 1e9, random);
    let taper = if random.one_in(3) { 1.0 } else { between(1e-3, 1.0, random) };
    let curvature = if random.one_in(3) { 0.0 } else { 6.0 * random.signed() / length };
    let stiffness = if random.one_in(3) { f64::INFINITY } else { rigidity / length * between(1e-6, 1e3, random) };
    let all =
        [length, rigidity, s_a, load, 2.0 * random.signed(), length * random.signed(), taper, curvature, stiffness];
    for value in all {
        text += &format!("{value:?} ");
    }
    text.into_bytes()
}

fn numbers(bytes: &[u8]) -> Vec<f64> {
    String::from_utf8_lossy(bytes).split_whitespace().filter_map(|n| n.parse().ok()).collect()
}

/// Whiskers that are not uniform, one question each: a table of them asks thousands.
pub(crate) fn rods(bytes: &[u8]) -> Verdict {
    let [length, flexural_rigidity, s_a, load, angle, height, tip_ratio, curvature, base_stiffness] =
        numbers(bytes)[..]
    else {
        return Ok(super::Outcome { read: false, mark: 0 });
    };
    let whisker = Whisker { length, flexural_rigidity, tip_ratio, curvature, base_stiffness, ..Whisker::default() };
    let mut found = 0;
    let mut last = None;
    for direction in [Load::Normal, Load::Tilted(angle)] {
        found += sound(force_mode(&whisker, load, s_a, direction), &mut last)?;
        found += sound(moment_mode(&whisker, load * length, s_a, direction), &mut last)?;
    }
    found += sound(point_mode(&whisker, Vec2::new(s_a, height), Load::Normal), &mut last)?;
    match last {
        Some(error) if found == 0 => refused(&error),
        _ => read((size(found), tip_ratio < 0.1, base_stiffness.is_finite(), curvature.abs() > 0.0)),
    }
}

pub(crate) fn modes(bytes: &[u8]) -> Verdict {
    let numbers = numbers(bytes);
    let [length, rigidity, s_a, load, angle, height] = numbers[..] else {
        return Ok(super::Outcome { read: false, mark: 0 });
    };
    let whisker = Whisker { length, flexural_rigidity: rigidity, ..Whisker::default() };
    let mut found = 0;
    let mut last = None;
    for direction in [Load::Normal, Load::Vertical, Load::Tilted(angle), Load::Directed(angle)] {
        found += sound(force_mode(&whisker, load, s_a, direction), &mut last)?;
        found += sound(moment_mode(&whisker, load * 0.01, s_a, direction), &mut last)?;
        found += sound(point_mode(&whisker, Vec2::new(s_a, height), direction), &mut last)?;
    }
    found += sound(tip_mode(&whisker, Vec2::new(s_a, height)), &mut last)?;
    match last {
        Some(error) if found == 0 => refused(&error),
        _ => read(size(found)),
    }
}

/// How many shapes there are, each of them in numbers.
fn sound(answer: Result<Vec<Bend>>, last: &mut Option<vibrissa::Error>) -> core::result::Result<usize, String> {
    match answer {
        Err(error) => {
            refused(&error)?;
            *last = Some(error);
            Ok(0)
        }
        Ok(bends) => {
            for bend in &bends {
                let moved = bend.shape(bend.s_a, 8);
                let whole = moved.iter().all(|p| p.is_finite()) && bend.force.is_finite() && bend.phi_a.is_finite();
                promise(whole, || format!("a shape that is no numbers: {bend:?}"))?;
            }
            Ok(bends.len())
        }
    }
}
