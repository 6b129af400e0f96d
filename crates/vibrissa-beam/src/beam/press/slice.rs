//! The contacts that explain one interval of moments, by the direction of the wall.

use super::PressTable;
use super::sheet::PressSheet;
use super::side::Sides;
use crate::plane::Vec2;
use crate::sets::Interval;
use alloc::vec::Vec;
#[cfg(not(feature = "std"))]
use num_traits::Float as _;

/// Contacts on one sheet for a small range of the wall's direction `psi` and all moments of an interval.
///
/// Every contact is `center + by_direction (psi - middle) + share by_moment + rest`, with `|share| <= 1`,
/// `|psi - middle| <= half` and `|rest| <= radius`; lengths over the whisker's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PressEntry {
    /// The middle of the range of directions (rad).
    pub middle: f64,
    /// Half of that range (rad).
    pub half: f64,
    /// The contact in the middle.
    pub center: Vec2,
    /// Its derivative by the direction.
    pub by_direction: Vec2,
    /// How far it moves over half the interval of moments.
    pub by_moment: Vec2,
    /// What the linear model leaves.
    pub radius: f64,
    /// Whether the whisker has an inflection: stable only where the contact is held.
    pub inflected: bool,
}

/// The contacts that explain an interval of moments; slopes at the contact towards +y, dimensionless.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PressSlice {
    lo: f64,
    width: f64,
    starts: Vec<u32>,
    entries: Vec<PressEntry>,
    spans: Vec<Span>,
}

/// Where all contacts of one bucket lie, seen along the wall's normal and along the wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    /// Least and largest `u(psi) · p`: how far the contact lies along the normal.
    pub reach: (f64, f64),
    /// Least and largest coordinate along the wall, which has free space on its left.
    pub place: (f64, f64),
}

impl Span {
    const EMPTY: Self = Self { reach: (f64::INFINITY, f64::NEG_INFINITY), place: (f64::INFINITY, f64::NEG_INFINITY) };

    fn hull(self, other: Self) -> Self {
        let join = |a: (f64, f64), b: (f64, f64)| (a.0.min(b.0), a.1.max(b.1));
        Self { reach: join(self.reach, other.reach), place: join(self.place, other.place) }
    }

    /// The span of an entry whose middle direction is `u`.
    fn of(entry: &PressEntry, u: Vec2) -> Self {
        let side = Vec2::new(u.y, -u.x);
        let (p, slope, half) = (entry.center, entry.by_direction, entry.half);
        let second = half
            * (0.5 * p.norm_squared().sqrt() * half
                + slope.norm_squared().sqrt() * half
                + entry.by_moment.norm_squared().sqrt()
                + entry.radius);
        let around = |direction: Vec2, turned: f64| {
            let off = (turned + direction.dot(slope)).abs() * half
                + direction.dot(entry.by_moment).abs()
                + entry.radius
                + second;
            (direction.dot(p) - off, direction.dot(p) + off)
        };
        Self { reach: around(u, -side.dot(p)), place: around(side, u.dot(p)) }
    }
}

impl PressSlice {
    /// The directions that the table knows (rad).
    #[must_use]
    pub fn directions(&self) -> Interval {
        let buckets = self.starts.len().saturating_sub(1);
        if buckets == 0 { Interval::EMPTY } else { Interval::new(self.lo, self.lo + buckets as f64 * self.width) }
    }

    /// How wide its buckets are (rad).
    #[must_use]
    pub fn width(&self) -> f64 {
        self.width
    }

    /// All entries, by growing direction.
    #[must_use]
    pub fn entries(&self) -> &[PressEntry] {
        &self.entries
    }

    /// The entries whose ranges meet the directions from `lo` to `hi` (rad).
    #[must_use]
    pub fn between(&self, lo: f64, hi: f64) -> &[PressEntry] {
        let (first, end) = self.buckets(lo, hi);
        if first < end { &self.entries[self.starts[first] as usize..self.starts[end] as usize] } else { &[] }
    }

    /// Where all contacts lie whose walls have directions from `lo` to `hi` (rad); empty ranges when there is none.
    #[must_use]
    pub fn span(&self, lo: f64, hi: f64) -> Span {
        let (first, end) = self.buckets(lo, hi);
        let spans = if first < end { &self.spans[first..end] } else { &[] };
        spans.iter().fold(Span::EMPTY, |all, one| all.hull(*one))
    }

    /// The buckets that meet the directions from `lo` to `hi`: the first and the one after the last.
    fn buckets(&self, lo: f64, hi: f64) -> (usize, usize) {
        let last = self.starts.len().saturating_sub(1) as f64;
        let per_width = 1.0 / self.width;
        let first = (lo - self.lo) * per_width - 1e-9;
        let end = (hi - self.lo) * per_width + 1e-9;
        if !(first < last && end >= 0.0) {
            return (0, 0);
        }
        // Casts cut towards zero: the floor, for what is not negative.
        (first.max(0.0) as usize, (end + 1.0).min(last) as usize)
    }
}

impl PressSlice {
    /// The entries of so many buckets of a whole turn.
    pub(super) fn of_buckets<I: Iterator<Item = PressEntry>>(buckets: usize, found: impl Iterator<Item = I>) -> Self {
        let mut starts = Vec::with_capacity(buckets + 1);
        let (mut spans, mut entries) = (Vec::with_capacity(buckets), Vec::new());
        for of_bucket in found {
            let start = entries.len();
            starts.push(start as u32);
            entries.extend(of_bucket);
            let span = |all: Span, entry: &PressEntry| all.hull(Span::of(entry, Vec2::from_angle(entry.middle)));
            spans.push(entries[start..].iter().fold(Span::EMPTY, span));
        }
        starts.push(entries.len() as u32);
        Self { lo: 0.0, width: core::f64::consts::TAU / buckets as f64, starts, entries, spans }
    }
}

impl PressTable {
    /// The contacts that cause a dimensionless moment between `lo` and `hi`: shapes that bend one way cause those that
    /// are not negative, shapes with an inflection those that are not positive.
    #[must_use]
    pub fn slice(&self, lo: f64, hi: f64) -> PressSlice {
        let columns = self.directions.len() - 1;
        let mut slice = PressSlice {
            lo: self.directions[0],
            width: (self.directions[columns] - self.directions[0]) / columns as f64,
            starts: Vec::with_capacity(columns + 1),
            entries: Vec::with_capacity(2 * columns),
            spans: Vec::with_capacity(columns),
        };
        for column in 0..columns {
            let start = slice.entries.len();
            slice.starts.push(start as u32);
            self.contacts_of(column, (lo, hi), &mut slice.entries);
            slice.spans.push(
                slice.entries[start..].iter().fold(Span::EMPTY, |all, e| all.hull(Span::of(e, self.middles[column]))),
            );
        }
        slice.starts.push(slice.entries.len() as u32);
        slice
    }

    /// Adds the contacts of one column that cause a moment between `lo` and `hi`.
    pub(super) fn contacts_of(&self, column: usize, (lo, hi): (f64, f64), entries: &mut Vec<PressEntry>) {
        if hi >= 0.0 {
            self.tips(&self.plain, column, (lo.max(0.0), hi), entries);
            entries.extend(self.side(&self.sides, column, (lo.max(0.0), hi)));
        }
        if lo <= 0.0 {
            let (first, range) = (entries.len(), ((-hi).max(0.0), -lo));
            self.tips(&self.inflected, column, range, entries);
            entries.extend(self.inflected_sides.as_ref().and_then(|sides| self.side(sides, column, range)));
            entries[first..].iter_mut().for_each(|entry| entry.inflected = true);
        }
    }

    /// The columns that meet directions from `lo` to `hi` (rad).
    pub(super) fn columns(&self, lo: f64, hi: f64) -> core::ops::Range<usize> {
        let first = self.directions.partition_point(|direction| *direction < lo).saturating_sub(1);
        let end = self.directions.partition_point(|direction| *direction <= hi).min(self.directions.len() - 1);
        first..end.max(first)
    }

    /// No tip contact has a larger dimensionless moment, of either sign.
    pub(super) fn largest_of_tips(&self) -> f64 {
        self.plain.largest().max(self.inflected.largest())
    }

    /// One entry for each run of cells that reach the interval and along which the moment keeps rising or falling.
    fn tips(&self, sheet: &PressSheet, column: usize, range: (f64, f64), entries: &mut Vec<PressEntry>) {
        let rising = |row: usize| {
            let mean = |r: usize| sheet.node(column, r).moment + sheet.node(column + 1, r).moment;
            mean(row + 1) > mean(row)
        };
        let mut start: Option<usize> = None;
        let mut row = 0;
        while row <= sheet.rows {
            if start.is_none() && row < sheet.rows {
                row = sheet.next(column, row, range);
            }
            let inside = row < sheet.rows && sheet.reaches(column, row, range);
            if let Some(first) = start
                && (!inside || rising(row) != rising(first))
            {
                entries.push(self.run(sheet, column, (first, row), range));
                start = None;
            }
            if inside && start.is_none() {
                start = Some(row);
            }
            row += 1;
        }
    }

    /// The linear model over the cells from `first` to before `end`.
    ///
    /// Moment and tip are bilinear within each cell up to their gaps, so the model's deviation, bilinear as well, is
    /// largest at a node.
    fn run(&self, sheet: &PressSheet, column: usize, (first, end): (usize, usize), (lo, hi): (f64, f64)) -> PressEntry {
        let (left, right) = (self.directions[column], self.directions[column + 1]);
        let (middle, half) = (0.5 * (left + right), 0.5 * (right - left));
        let mean = |row: usize| {
            let (a, b) = (sheet.node(column, row), sheet.node(column + 1, row));
            (0.5 * (a.moment + b.moment), (a.tip + b.tip) * 0.5)
        };
        let (low, high) = (mean(first), mean(end));
        let steep = (high.0 - low.0).abs() > 1e-6;
        let by_mu = if steep { (high.1 - low.1) * (1.0 / (high.0 - low.0)) } else { Vec2::ZERO };
        let across = |row: usize| {
            let (a, b) = (sheet.node(column, row), sheet.node(column + 1, row));
            (b.tip - a.tip - by_mu * (b.moment - a.moment)) * (0.5 / half)
        };
        let by_direction = (across(first) + across(end)) * 0.5;
        let deviation = |c: usize, row: usize| {
            let (node, side) = (sheet.node(column + c, row), if c == 0 { -half } else { half });
            node.tip - by_mu * node.moment - by_direction * side
        };
        let (mut least, mut most) = (deviation(0, first), deviation(0, first));
        for row in first..=end {
            for at in [deviation(0, row), deviation(1, row)] {
                least = Vec2::new(least.x.min(at.x), least.y.min(at.y));
                most = Vec2::new(most.x.max(at.x), most.y.max(at.y));
            }
        }
        let gaps = sheet.gaps(column, first, end);
        let gap = gaps.iter().map(|g| g.tip + by_mu.norm_squared().sqrt() * g.moment).fold(0.0, f64::max);
        PressEntry {
            middle,
            half,
            center: (least + most) * 0.5 + by_mu * (0.5 * (lo + hi)),
            by_direction,
            by_moment: by_mu * (0.5 * (hi - lo)),
            radius: 0.5 * (most - least).norm_squared().sqrt() + gap,
            inflected: false,
        }
    }

    /// The side contacts of one column.
    fn side(&self, sides: &Sides, column: usize, range: (f64, f64)) -> Option<PressEntry> {
        let (left, right) = (self.directions[column], self.directions[column + 1]);
        let of_column = (0.5 * (left + right), 0.5 * (right - left));
        if self.has_sides(column) { sides.entry(column, range, of_column) } else { None }
    }

    /// Whether the whisker's normal can have the directions of a column.
    fn has_sides(&self, column: usize) -> bool {
        let slopes = [self.directions[column], self.directions[column + 1]].map(|d| d - core::f64::consts::FRAC_PI_2);
        slopes[1] >= 0.0 && slopes[0] <= self.steepest
    }
}

impl PressSlice {
    /// The same for whiskers that are longer or shorter by up to a share `stretch` of their length.
    #[must_use]
    pub fn widened(mut self, stretch: f64) -> Self {
        if stretch <= 0.0 {
            return self;
        }
        for entry in &mut self.entries {
            let [center, along, thick] =
                [entry.center, entry.by_direction, entry.by_moment].map(|v| v.norm_squared().sqrt());
            entry.radius += stretch * (center + along * entry.half + thick + entry.radius);
        }
        for (span, ends) in self.spans.iter_mut().zip(self.starts.windows(2)) {
            let entries = &self.entries[ends[0] as usize..ends[1] as usize];
            let of = |entry: &PressEntry| Span::of(entry, Vec2::from_angle(entry.middle));
            *span = entries.iter().fold(Span::EMPTY, |all, entry| all.hull(of(entry)));
        }
        self
    }

    /// The same with lengths in metres, for a whisker of this length (m).
    #[must_use]
    pub fn scaled(mut self, length: f64) -> Self {
        for entry in &mut self.entries {
            entry.center = entry.center * length;
            entry.by_direction = entry.by_direction * length;
            entry.by_moment = entry.by_moment * length;
            entry.radius *= length;
        }
        for span in &mut self.spans {
            span.reach = (span.reach.0 * length, span.reach.1 * length);
            span.place = (span.place.0 * length, span.place.1 * length);
        }
        self
    }
}
