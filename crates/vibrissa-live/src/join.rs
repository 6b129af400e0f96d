//! Streams to rows: odometry and other readings at the time of each frame of the first stream with readings.

use crate::config::{FRAMES_WAITING, PATIENCE};
use crate::decode::Frame;
use std::collections::VecDeque;
use vibrissa_core::flow::sensor_log::LogRow;
use vibrissa_core::plane::{Pose2, Twist2, wrap_angle};

/// A row, and when the last of what it is made of arrived (host, s).
#[derive(Clone, Debug, PartialEq)]
pub struct JoinedRow {
    /// The row; its line is its number, from 1.
    pub row: LogRow,
    /// Arrival of the last byte that it needed (s).
    pub arrival: f64,
    /// How far the odometry went since the first row, and how much it turned, whatever the direction (m, rad).
    pub travel: [f64; 2],
}

/// A frame with its time and its arrival (s).
#[derive(Clone, Debug)]
struct Timed {
    t: f64,
    arrival: f64,
    frame: Frame,
}

/// What a row takes from one stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Share {
    /// Whether it has the odometry.
    pub pose: bool,
    /// How many readings a frame has.
    pub readings: usize,
}

/// Joins streams.
#[derive(Clone, Debug)]
pub struct Joiner {
    shares: Vec<Share>,
    /// The stream whose frames give the rows, and the one that gives the odometry.
    first: usize,
    odometry: usize,
    streams: Vec<VecDeque<Timed>>,
    rows: u64,
    /// The odometry of the last row, and how far it went up to there.
    last: Option<(Pose2, [f64; 2])>,
}

impl Joiner {
    /// A joiner of streams; `first` gives the rows, `odometry` the robot's poses.
    #[must_use]
    pub fn new(shares: Vec<Share>, first: usize, odometry: usize) -> Self {
        let streams = shares.iter().map(|_| VecDeque::new()).collect();
        Self { shares, first, odometry, streams, rows: 0, last: None }
    }

    /// Takes a frame of a stream, in order of its times.
    pub fn push(&mut self, stream: usize, t: f64, arrival: f64, frame: Frame) {
        self.streams[stream].push_back(Timed { t, arrival, frame });
    }

    /// Calls `told` with each row that is complete by now (arrival of the last bytes of any source, s); how many frames were
    /// given up because nothing came to join them with.
    pub fn rows(&mut self, now: f64, told: &mut dyn FnMut(JoinedRow)) -> u64 {
        let mut given_up = 0;
        while let Some(first) = self.streams[self.first].front() {
            let (t, arrival) = (first.t, first.arrival);
            match self.row(t, arrival) {
                Some(joined) => {
                    self.rows += 1;
                    self.last = Some((joined.row.odom_from_robot, joined.travel));
                    told(joined);
                }
                None if self.may_come(t) && now - arrival <= PATIENCE && !self.is_full() => break,
                None => given_up += 1,
            }
            self.streams[self.first].pop_front();
        }
        self.forget();
        given_up
    }

    /// How many frames wait.
    #[must_use]
    pub fn waiting(&self) -> usize {
        self.streams[self.first].len()
    }

    fn is_full(&self) -> bool {
        self.streams[self.first].len() > FRAMES_WAITING
    }

    /// Whether frames that are still to come can complete the row at a time.
    fn may_come(&self, t: f64) -> bool {
        let others = (0..self.shares.len()).filter(|&stream| stream != self.first && self.is_needed(stream));
        others.into_iter().all(|stream| {
            let frames = &self.streams[stream];
            // Covered, or not yet reached; none before it means never.
            frames.front().is_none_or(|front| front.t <= t) && !self.has_gap(stream, t)
        })
    }

    fn is_needed(&self, stream: usize) -> bool {
        stream == self.odometry || self.shares[stream].readings > 0
    }

    fn has_gap(&self, stream: usize, t: f64) -> bool {
        self.around(stream, t).is_some_and(|(before, after, _)| after.t - before.t > PATIENCE)
    }

    /// The frames of a stream around a time and how far it lies between them.
    fn around(&self, stream: usize, t: f64) -> Option<(&Timed, &Timed, f64)> {
        let frames = &self.streams[stream];
        let after = frames.partition_point(|frame| frame.t < t);
        let next = frames.get(after)?;
        if next.t <= t {
            return Some((next, next, 0.0));
        }
        let before = frames.get(after.checked_sub(1)?)?;
        Some((before, next, (t - before.t) / (next.t - before.t)))
    }

    /// The row at the time of the first frame that waits; none as long as something is missing.
    fn row(&self, t: f64, arrival: f64) -> Option<JoinedRow> {
        let mut row = LogRow {
            t,
            odom_from_robot: Pose2::IDENTITY,
            readings: Vec::new(),
            heading: None,
            line: usize::try_from(self.rows + 1).unwrap_or(usize::MAX),
        };
        let mut last = arrival;
        for stream in (0..self.shares.len()).filter(|&stream| stream == self.first || self.is_needed(stream)) {
            let (before, after, share) =
                if stream == self.first { self.only_first()? } else { self.around(stream, t)? };
            if after.t - before.t > PATIENCE {
                return None;
            }
            last = last.max(after.arrival);
            let between = |a: f64, b: f64| a + share * (b - a);
            if stream == self.odometry {
                row.odom_from_robot = pose_between(before.frame.pose?, after.frame.pose?, share);
            }
            let readings = before.frame.readings.iter().zip(&after.frame.readings);
            row.readings.extend(readings.map(|(a, b)| between(*a, *b)));
            if let (None, Some(a), Some(b)) = (row.heading, before.frame.heading, after.frame.heading) {
                row.heading = Some(a + share * wrap_angle(b - a));
            }
        }
        let travel = self.last.map_or([0.0; 2], |(before, [way, turn])| {
            let step = before.between(row.odom_from_robot);
            [way + step.position().norm(), turn + step.theta.abs()]
        });
        Some(JoinedRow { row, arrival: last, travel })
    }

    fn only_first(&self) -> Option<(&Timed, &Timed, f64)> {
        self.streams[self.first].front().map(|first| (first, first, 0.0))
    }

    /// Forgets frames that no row can need any more.
    fn forget(&mut self) {
        let needed = self.streams[self.first].front().map(|first| first.t);
        for (stream, frames) in self.streams.iter_mut().enumerate().filter(|(stream, _)| *stream != self.first) {
            if !(stream == self.odometry || self.shares[stream].readings > 0) {
                frames.clear();
                continue;
            }
            // Frames of the first stream that come in bursts may be older than the newest odometry.
            let newest = frames.back().map_or(0.0, |frame| frame.t);
            let horizon = needed.unwrap_or(newest).min(newest - 2.0 * PATIENCE);
            while frames.len() > FRAMES_WAITING || frames.get(1).is_some_and(|second| second.t < horizon) {
                frames.pop_front();
            }
        }
    }
}

/// The pose so far on the geodesic from one to another.
#[must_use]
pub fn pose_between(before: Pose2, after: Pose2, share: f64) -> Pose2 {
    if share <= 0.0 {
        return before;
    }
    let step = before.between(after).log();
    before.compose(Pose2::exp(Twist2 { x: share * step.x, y: share * step.y, theta: share * step.theta }))
}

#[cfg(test)]
mod tests {
    use super::{JoinedRow, Joiner, Share};
    use crate::decode::Frame;
    use vibrissa_core::plane::Pose2;

    fn reading(value: f64) -> Frame {
        Frame { readings: vec![value], ..Frame::default() }
    }

    fn pose(x: f64, theta: f64) -> Frame {
        Frame { pose: Some(Pose2::new(x, 0.0, theta)), ..Frame::default() }
    }

    fn joiner() -> Joiner {
        Joiner::new(vec![Share { pose: false, readings: 1 }, Share { pose: true, readings: 0 }], 0, 1)
    }

    fn rows(joiner: &mut Joiner, now: f64) -> (Vec<JoinedRow>, u64) {
        let mut rows = Vec::new();
        let given_up = joiner.rows(now, &mut |row| rows.push(row));
        (rows, given_up)
    }

    #[test]
    fn odometry_is_interpolated_when_it_has_come() {
        let mut joiner = joiner();
        joiner.push(1, 1.0, 1.0, pose(0.0, 0.0));
        joiner.push(0, 1.025, 1.03, reading(7.0));
        assert_eq!(rows(&mut joiner, 1.03), (vec![], 0));
        joiner.push(1, 1.1, 1.11, pose(0.4, 0.0));
        let (found, given_up) = rows(&mut joiner, 1.11);
        assert_eq!((found.len(), given_up), (1, 0));
        assert!((found[0].row.odom_from_robot.x - 0.1).abs() < 1e-12);
        assert_eq!((found[0].arrival, found[0].row.line, found[0].row.readings[0]), (1.11, 1, 7.0));
    }

    #[test]
    fn what_cannot_be_joined_is_given_up_in_time() {
        let mut joiner = joiner();
        joiner.push(0, 0.9, 0.9, reading(1.0));
        assert_eq!(rows(&mut joiner, 0.95).1, 0, "odometry may still come");
        joiner.push(1, 1.0, 1.0, pose(0.0, 0.0));
        joiner.push(0, 1.05, 1.05, reading(2.0));
        let (found, given_up) = rows(&mut joiner, 1.05);
        assert_eq!((found.len(), given_up), (0, 1), "the first lies before all odometry");
        let (found, given_up) = rows(&mut joiner, 1.5);
        assert_eq!((found.len(), given_up), (0, 1), "no odometry came any more");
        // A gap of the odometry is not bridged.
        joiner.push(0, 1.6, 1.6, reading(3.0));
        joiner.push(1, 1.7, 1.7, pose(1.0, 0.0));
        assert_eq!(rows(&mut joiner, 1.7).1, 1);
        joiner.push(0, 1.75, 1.75, reading(4.0));
        joiner.push(1, 1.8, 1.8, pose(1.1, 0.0));
        assert_eq!(rows(&mut joiner, 1.8).0.len(), 1);
        assert_eq!(joiner.waiting(), 0);
    }
}
