//! Host stamps: reading them, and the even times behind their jitter.

/// A host stamp `2024-04-17_11:48:11.545069`, also with a blank or `T` in the middle, as seconds since 1970.
#[must_use]
pub fn host_stamp(text: &str) -> Option<f64> {
    let (date, time) = text.split_once(['_', ' ', 'T'])?;
    let mut date = date.split('-').map(|part| part.parse::<i64>().ok());
    let (year, month, day) = (date.next()??, date.next()??, date.next()??);
    let mut time = time.split(':');
    let hour = time.next()?.parse::<u32>().ok()?;
    let minute = time.next()?.parse::<u32>().ok()?;
    let second = time.next()?.parse::<f64>().ok()?;
    let sane = (1970..10_000).contains(&year) && (1..=12).contains(&month) && (1..=31).contains(&day);
    if !sane || date.next().is_some() || time.next().is_some() || hour > 24 || minute > 59 {
        return None;
    }
    if !(0.0..61.0).contains(&second) {
        return None;
    }
    let clock = f64::from(hour) * 3600.0 + f64::from(minute) * 60.0 + second;
    Some(days_since_1970(year, month, day) as f64 * 86_400.0 + clock)
}

/// Days of the Gregorian calendar, counted in years that begin in March.
fn days_since_1970(year: i64, month: i64, day: i64) -> i64 {
    let (year, month) = if month > 2 { (year, month - 3) } else { (year - 1, month + 9) };
    365 * year + year / 4 - year / 100 + year / 400 + (153 * month + 2) / 5 + day - 719_469
}

/// Longest pause that jitter explains (s); a longer one is a pause of the recording.
const PAUSE: f64 = 0.1;

/// Times through jittering stamps (s), from the first on, even in the `places` of the readings in the stream, which grow;
/// a pause stays a pause.
///
/// The sensor's clock is steadier than the host's: the times are a straight line through the stamps of each stretch,
/// and a later stretch never begins before an earlier one ends.
pub(super) fn even_times(stamps: &[f64], places: &[usize]) -> Vec<f64> {
    let Some(&origin) = stamps.first() else { return Vec::new() };
    let mut times: Vec<f64> = Vec::with_capacity(stamps.len());
    let mut start = 0;
    while start < stamps.len() {
        let more = stamps[start..].windows(2).take_while(|w| (0.0..PAUSE).contains(&(w[1] - w[0]))).count();
        let stretch = &stamps[start..=start + more];
        let from_first = |i: usize| (places[start + i] - places[start]) as f64;
        let (offset, period) = line(stretch, &from_first);
        let first = offset - origin;
        let after = times.last().map_or(first, |last| first.max(last + period.max(1e-6)));
        times.extend((0..stretch.len()).map(|i| after + period * from_first(i)));
        start += more + 1;
    }
    let first = times[0];
    times.iter_mut().for_each(|t| *t -= first);
    times
}

/// Offset and step of the least-squares line through values at the places `at(index)`.
fn line(values: &[f64], at: &impl Fn(usize) -> f64) -> (f64, f64) {
    let n = values.len() as f64;
    if values.len() < 2 {
        return (values[0], 0.0);
    }
    let origin = values[0];
    let middle = (0..values.len()).map(at).sum::<f64>() / n;
    let mean = values.iter().map(|v| v - origin).sum::<f64>() / n;
    let weighted: f64 = values.iter().enumerate().map(|(i, v)| (at(i) - middle) * (v - origin)).sum();
    let step = weighted / (0..values.len()).map(|i| (at(i) - middle).powi(2)).sum::<f64>();
    (origin + mean - step * middle, step)
}

#[cfg(test)]
mod tests {
    use super::{even_times, host_stamp};

    #[test]
    fn stamps_count_seconds_across_days_and_leap_years() {
        assert_eq!(host_stamp("1970-01-01_00:00:00.0"), Some(0.0));
        assert_eq!(host_stamp("2000-02-29 12:00:00.5"), Some(951_825_600.5));
        assert_eq!(host_stamp("2024-04-17_11:48:11.545069").map(|t| t.floor()), Some(1_713_354_491.0));
        for bad in ["", "2024-04-17", "2024-13-17_11:48:11", "2024-04-17_11:48", "2024-04-17_11:99:11", "a-b-c_d:e:f"] {
            assert_eq!(host_stamp(bad), None, "{bad}");
        }
    }

    #[test]
    fn jitter_is_taken_out_and_pauses_stay() {
        let jitter = |i: usize| ((i * 7919) % 13) as f64 * 1e-4;
        let mut stamps: Vec<f64> = (0..500).map(|i| 5.0 + i as f64 / 800.0 + jitter(i)).collect();
        stamps.extend((0..500).map(|i| 9.0 + i as f64 / 800.0 + jitter(i)));
        let places: Vec<usize> = (0..1000).collect();
        let times = even_times(&stamps, &places);
        assert!((times[499] - 499.0 / 800.0).abs() < 5e-4, "{}", times[499]);
        assert!((times[500] - 4.0).abs() < 5e-4, "{}", times[500]);
        assert!(times.windows(2).all(|w| w[1] > w[0]));
    }

    /// Of 500 even readings every seventh line is lost: the others keep their times.
    #[test]
    fn lost_lines_keep_their_places() {
        let places: Vec<usize> = (0..500).filter(|i| i % 7 != 3).collect();
        let stamps: Vec<f64> = places.iter().map(|&i| 5.0 + i as f64 / 800.0 + ((i * 31) % 11) as f64 * 1e-4).collect();
        for (time, place) in even_times(&stamps, &places).iter().zip(&places) {
            assert!((time - *place as f64 / 800.0).abs() < 2e-4, "{time} at {place}");
        }
    }
}
