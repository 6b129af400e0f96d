//! How long the updates took.

use std::time::Instant;
use vibrissa::flow::pose::StepRecord;
use vibrissa::flow::sensor_log::LogRow;

/// Times of the updates of one localization.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Runtime {
    /// How many rows updated the state set.
    pub(crate) updates: usize,
    /// From the start to the answer (s).
    pub(crate) total_s: f64,
    /// Median time of an update (µs).
    pub(crate) p50_us: f64,
    /// 99th percentile of the time of an update (µs).
    pub(crate) p99_us: f64,
}

/// Takes the time of each row; most rows only lengthen the history and cost next to nothing.
#[derive(Debug)]
pub(crate) struct Stopwatch {
    begin: Instant,
    last: Instant,
    laps_us: Vec<f64>,
}

impl Stopwatch {
    /// Starts now.
    pub(crate) fn start() -> Self {
        let now = Instant::now();
        Self { begin: now, last: now, laps_us: Vec::new() }
    }

    /// Ends a row and begins the next.
    pub(crate) fn lap(&mut self) {
        let now = Instant::now();
        self.laps_us.push(now.duration_since(self.last).as_secs_f64() * 1e6);
        self.last = now;
    }

    /// The times so far of the rows that updated the state set: those with the time of a step.
    pub(crate) fn stop(self, rows: &[LogRow], steps: &[StepRecord]) -> Runtime {
        let total_s = self.begin.elapsed().as_secs_f64();
        let updated = |row: &LogRow| steps.binary_search_by(|step| step.t.total_cmp(&row.t)).is_ok();
        let timed = rows.iter().zip(&self.laps_us).filter(|(row, _)| updated(row));
        let mut laps_us: Vec<f64> = timed.map(|(_, lap)| *lap).collect();
        laps_us.sort_by(f64::total_cmp);
        Runtime {
            updates: laps_us.len(),
            total_s,
            p50_us: percentile(&laps_us, 0.50),
            p99_us: percentile(&laps_us, 0.99),
        }
    }
}

/// The smallest of the sorted values that at least `share` of them do not exceed; 0 of none.
fn percentile(sorted: &[f64], share: f64) -> f64 {
    let rank = (share * sorted.len() as f64).ceil() as usize;
    sorted.get(rank.saturating_sub(1)).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::percentile;

    #[test]
    fn percentiles_follow_the_nearest_rank() {
        let hundred: Vec<f64> = (1..=100).map(f64::from).collect();
        for (values, share, expected) in
            [(&hundred[..], 0.5, 50.0), (&hundred, 0.99, 99.0), (&hundred[..1], 0.99, 1.0), (&[], 0.5, 0.0)]
        {
            assert!((percentile(values, share) - expected).abs() < 1e-12);
        }
    }
}
