//! The interface for programs in C: any numbers, null pointers, and what comes back checked by the relations that a bend keeps.

use super::{Verdict, promise, read, size};
use crate::random::Random;
use core::ptr::{null, null_mut};
use vibrissa_c::abi::{
    VIBRISSA_BEYOND, VIBRISSA_NONE, VIBRISSA_NULL, VIBRISSA_OK, VIBRISSA_RANGE, VibrissaBend, VibrissaCalibration,
    VibrissaPlane, vibrissa_by_force, vibrissa_by_moment, vibrissa_by_point, vibrissa_moment, vibrissa_moments,
};

/// How far a bend may miss what was asked for, relative to it: the header's six digits.
const MISS: f64 = 1e-6;
/// Numbers of a call, at most.
const NUMBERS: usize = 40;
/// Calls of a script, at most.
const MOST_CALLS: usize = 64;

/// Words that stand in scripts.
pub(crate) const WORDS: &[&str] = &[
    "force ", "moment ", "curled ", "point ", "line ", "plane ", "null ", "nan ", "inf ", "-inf ", "0 ", "1e-300 ",
    "1e300 ",
];

/// Lines of a function's name and its numbers: as they are in use, or wild.
pub(crate) fn draw(random: &mut Random) -> Vec<u8> {
    let wild = [0.0, -0.0, 1e-300, 5e-324, -1e-12, 1e12, 1e300, f64::MAX, f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
    let mut text = String::new();
    for _ in 0..1 + random.below(6) {
        let (name, usual): (_, &[f64]) = [
            ("force", &[2.9e-4, 0.1, 0.05][..]),
            ("moment", &[2.9e-4, 2e-3, 0.07]),
            ("curled", &[2.9e-4, 2e-3, 0.07]),
            ("point", &[2.9e-4, 0.075, 0.06, 0.02]),
            ("line", &[1e-4, 1e-4, 1e-3, 0.0, 0.6, 0.8, 1e-3, 1e-2, 0.1, 0.2, 0.0, 0.1, 0.0, 0.0, 1e-3, 1e-3, 2e-3]),
            ("plane", &[1e-3; NUMBERS]),
        ][random.below(6)];
        if random.one_in(20) {
            text += "null ";
        }
        text += name;
        for &value in usual {
            let value = match random.below(8) {
                0 => *random.pick(&wild).unwrap_or(&0.0),
                1 => value * 10f64.powi(random.below(9) as i32 - 4) * random.signed(),
                2 | 3 => value * 2.0 * random.signed(),
                _ => value,
            };
            text += &format!(" {value:?}");
        }
        text.push('\n');
    }
    text.into_bytes()
}

/// Does the calls of a script.
pub(crate) fn calls(bytes: &[u8]) -> Verdict {
    let script = String::from_utf8_lossy(bytes);
    let mut codes = [0_usize; 5];
    for line in script.lines().take(MOST_CALLS) {
        let (is_null, line) = line.strip_prefix("null ").map_or((false, line), |rest| (true, rest));
        let (name, rest) = line.split_once(' ').unwrap_or((line, ""));
        let mut numbers = [0.0; NUMBERS];
        for (place, word) in numbers.iter_mut().zip(rest.split_whitespace()) {
            *place = word.parse().unwrap_or(f64::NAN);
        }
        let code = match name {
            "force" | "moment" | "curled" | "point" => bend(name, &numbers, is_null)?,
            "line" => line_moment(&numbers, is_null)?,
            "plane" => plane_moments(&numbers, is_null)?,
            _ => continue,
        };
        let known = [VIBRISSA_OK, VIBRISSA_NULL, VIBRISSA_NONE, VIBRISSA_RANGE, VIBRISSA_BEYOND];
        let at = known.iter().position(|other| *other == code).ok_or(format!("the code {code} of {line:?}"))?;
        promise(!is_null || code == VIBRISSA_NULL, || format!("a null pointer gives {code} in {line:?}"))?;
        codes[at] += 1;
    }
    read(codes.map(size))
}

/// A bend: what is written is numbers that answer the question, and where none is nothing is written.
fn bend(name: &str, numbers: &[f64; NUMBERS], is_null: bool) -> Result<i32, String> {
    let untouched = VibrissaBend { force: 1.25, ..VibrissaBend::default() };
    let mut found = untouched;
    let out = if is_null { null_mut() } else { &raw mut found };
    let [a, b, c, d, ..] = *numbers;
    let code = match name {
        "force" => vibrissa_by_force(a, b, c, out),
        "point" => vibrissa_by_point(a, b, c, d, out),
        _ => vibrissa_by_moment(a, b, c, name == "curled", out),
    };
    if code != VIBRISSA_OK {
        promise(found == untouched, || format!("{name} {a:?} {b:?} {c:?} {d:?} gives {code} and writes {found:?}"))?;
        return Ok(code);
    }
    let VibrissaBend { force, arc_length, slope, x, y, moment } = found;
    let finite = [force, arc_length, slope, x, y, moment].iter().all(|value| value.is_finite());
    promise(finite, || format!("{name} {a:?} {b:?} {c:?} {d:?} gives {found:?}"))?;
    let near = |told: f64, asked: f64, scale: f64| (told - asked).abs() <= MISS * scale.abs() + f64::MIN_POSITIVE;
    let right = match name {
        "force" => near(force, b, b) && near(arc_length, c, c),
        "point" => near(x, c, b) && near(y, d, b) && arc_length <= b * (1.0 + MISS),
        _ => near(moment, b, b) && near(arc_length, c, c),
    };
    promise(right, || format!("{name} {a:?} {b:?} {c:?} {d:?} gives another bend: {found:?}"))?;
    // A whisker is no shorter than the way to its contact.
    promise(x.hypot(y) <= arc_length * (1.0 + MISS) + f64::MIN_POSITIVE, || {
        format!("{name} {a:?} {b:?} {c:?} {d:?}: stretched {found:?}")
    })?;
    Ok(code)
}

fn line_moment(numbers: &[f64; NUMBERS], is_null: bool) -> Result<i32, String> {
    let three = |k: usize| [numbers[k], numbers[k + 1], numbers[k + 2]];
    let calibration = VibrissaCalibration {
        rest: three(0),
        direction: three(3),
        range: [numbers[6], numbers[7]],
        coefficients: core::array::from_fn(|k| numbers[8 + k]),
    };
    let (flux, mut moment) = (three(14), 1.25);
    let given = if is_null { null() } else { &raw const calibration };
    let code = vibrissa_moment(given, flux.as_ptr(), &raw mut moment);
    written(code, &[moment], &calibration)
}

fn plane_moments(numbers: &[f64; NUMBERS], is_null: bool) -> Result<i32, String> {
    let three = |k: usize| [numbers[k], numbers[k + 1], numbers[k + 2]];
    let plane = VibrissaPlane {
        rest: three(0),
        directions: [three(3), three(6)],
        ranges: [[numbers[9], numbers[10]], [numbers[11], numbers[12]]],
        coefficients: [core::array::from_fn(|k| numbers[13 + k]), core::array::from_fn(|k| numbers[23 + k])],
    };
    let (flux, mut moments) = (three(33), [1.25, 1.25]);
    let out = if is_null { null_mut() } else { moments.as_mut_ptr() };
    let code = vibrissa_moments(&raw const plane, flux.as_ptr(), out);
    written(code, &moments, &plane)
}

/// What is written is finite, and nothing is where there is no answer.
fn written(code: i32, moments: &[f64], of: &impl core::fmt::Debug) -> Result<i32, String> {
    let sound =
        moments.iter().all(|m| if code == VIBRISSA_OK { m.is_finite() } else { m.to_bits() == 1.25_f64.to_bits() });
    promise(sound, || format!("{of:?} gives {code} and writes {moments:?}"))?;
    Ok(code)
}
