//! Problems of one call: what is known, for each of them or for all.

use super::Bends;
use super::rows::{Row, Rows};
use crate::long::Watch;
use vibrissa::beam::{Bend, Load, Whisker, force_mode, moment_mode, point_mode, tip_mode};
use vibrissa::plane::Vec2;
use vibrissa::tasks::batch;
use vibrissa::{Error, Result};

/// Problems that a thread takes at a time where one takes a fraction of a microsecond.
const GRAIN: usize = 4096;

/// Which quantities are known.
#[derive(Clone, Copy, Debug)]
pub(super) enum Given {
    Force,
    Point,
    Tip,
    Moment,
}

/// The loads by their names, without their angles.
#[derive(Clone, Copy, Debug)]
enum Kind {
    Normal,
    Vertical,
    Tilted,
    Directed,
}

/// Every problem of one call. Each column holds one number for all problems, or one for each.
#[derive(Debug)]
pub(super) struct Problems {
    given: Given,
    count: usize,
    first: Vec<f64>,
    second: Vec<f64>,
    kind: Kind,
    /// Empty for the loads without an angle.
    angles: Vec<f64>,
    whiskers: Vec<Whisker>,
}

/// What stands at `i` of a column; the first where it holds one for all.
fn at<T>(column: &[T], i: usize) -> &T {
    &column[if column.len() == 1 { 0 } else { i }]
}

impl Problems {
    pub(super) fn new(
        given: Given,
        count: usize,
        [first, second, angles]: [Vec<f64>; 3],
        load: &str,
        whiskers: Vec<Whisker>,
    ) -> Result<Self> {
        let kind = match (load, angles.is_empty()) {
            ("normal", true) => Kind::Normal,
            ("vertical", true) => Kind::Vertical,
            ("tilted", false) => Kind::Tilted,
            ("directed", false) => Kind::Directed,
            ("normal" | "vertical", _) => {
                return Err(Error::usage("angle").allowed("with the loads tilted and directed only"));
            }
            ("tilted" | "directed", _) => {
                return Err(Error::usage("the load's angle is missing").remedy("give angle (rad)"));
            }
            (other, _) => {
                return Err(Error::usage("the load").value(other).allowed("normal, vertical, tilted, directed"));
            }
        };
        Ok(Self { given, count, first, second, kind, angles, whiskers })
    }

    pub(super) fn count(&self) -> usize {
        self.count
    }

    fn load(&self, i: usize) -> Load {
        match self.kind {
            Kind::Normal => Load::Normal,
            Kind::Vertical => Load::Vertical,
            Kind::Tilted => Load::Tilted(*at(&self.angles, i)),
            Kind::Directed => Load::Directed(*at(&self.angles, i)),
        }
    }

    fn equilibria(&self, i: usize) -> Result<Vec<Bend>> {
        let (whisker, a, b) = (at(&self.whiskers, i), *at(&self.first, i), *at(&self.second, i));
        match self.given {
            Given::Force => force_mode(whisker, a, b, self.load(i)),
            Given::Moment => moment_mode(whisker, a, b, self.load(i)),
            Given::Point => point_mode(whisker, Vec2::new(a, b), self.load(i)),
            Given::Tip => tip_mode(whisker, Vec2::new(a, b)),
        }
    }

    /// The equilibria of these problems, and those that make no sense.
    fn solve(&self, cases: core::ops::Range<usize>, watch: &Watch) -> (Vec<Row>, Vec<(usize, Error)>) {
        let (mut rows, mut faults) = (Vec::with_capacity(cases.len()), Vec::new());
        for case in cases {
            if watch.is_cancelled() {
                break;
            }
            match self.equilibria(case) {
                Ok(bends) => {
                    rows.extend(bends.into_iter().enumerate().map(|(branch, bend)| Row { case, branch, bend }))
                }
                Err(error) => faults.push((case, error)),
            }
        }
        (rows, faults)
    }

    /// The equilibria in the order of the problems, and the problems that make no sense.
    pub(super) fn solve_all(self, threads: usize, watch: &Watch) -> Bends {
        // Some take longer than others, so that small shares keep all threads busy to the end.
        let grain = (self.count / (16 * threads)).clamp(1, GRAIN);
        let starts: Vec<usize> = (0..self.count).step_by(grain).collect();
        let solved = batch::map(&starts, threads, |&start| self.solve(start..self.count.min(start + grain), watch));
        let (parts, faults): (Vec<_>, Vec<_>) = solved.into_iter().unzip();
        Bends {
            problems: self.count,
            rows: Rows::new(parts, threads),
            faults: faults.into_iter().flatten().collect(),
            whiskers: self.whiskers,
        }
    }
}
