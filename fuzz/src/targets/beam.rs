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

pub(crate) fn modes(bytes: &[u8]) -> Verdict {
    let text = String::from_utf8_lossy(bytes);
    let numbers: Vec<f64> = text.split_whitespace().filter_map(|n| n.parse().ok()).collect();
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
