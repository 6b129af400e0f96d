//! Numbers as people read them.

/// Below this a number that should be zero is what rounding left of it.
const ROUNDING: f64 = 1e-12;

/// A number with a fixed count of decimals and no negative zero.
#[must_use]
pub fn fixed(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        Some(size) if size.chars().all(|c| matches!(c, '0' | '.')) => size.into(),
        _ => text,
    }
}

/// The same, but with an exponent where the decimals would show fewer than two digits of it: `1.0e-4` rather than `0.0001`.
///
/// What is smaller than 10⁻¹² is shown as zero.
#[must_use]
pub fn significant(value: f64, decimals: usize) -> String {
    let least = 10f64.powi(1 - i32::try_from(decimals).unwrap_or(i32::MAX));
    if (ROUNDING..least).contains(&value.abs()) { format!("{value:.1e}") } else { fixed(value, decimals) }
}

#[cfg(test)]
mod tests {
    use super::{fixed, significant};

    #[test]
    fn small_numbers_keep_their_digits() {
        let cases = [
            (0.25, "0.2500"),
            (-17.123_46, "-17.1235"),
            (0.001, "0.0010"),
            (0.000_96, "9.6e-4"),
            (1e-7, "1.0e-7"),
            (-2.5e-10, "-2.5e-10"),
            (1e-17, "0.0000"),
            (-1e-17, "0.0000"),
            (0.0, "0.0000"),
            (-0.0, "0.0000"),
            (f64::NAN, "NaN"),
            (f64::INFINITY, "inf"),
        ];
        for (value, words) in cases {
            assert_eq!(significant(value, 4), words);
        }
        assert_eq!(fixed(-0.0004, 3), "0.000");
        assert_eq!(fixed(-0.0005001, 3), "-0.001");
        assert_eq!(significant(30.0, 0), "30");
    }
}
