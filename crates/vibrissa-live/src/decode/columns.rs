//! Lines of numbers whose columns have names.

use super::Frame;
use crate::{Error, Result};
use vibrissa_core::flow::sensor_log::{Channel, Quantity};
use vibrissa_core::plane::Pose2;
use vibrissa_io::log::foreign::number;
use vibrissa_io::text::did_you_mean;

/// What a column holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Column {
    /// Time, and the factor to seconds.
    Time(f64),
    /// The frame's number, and after how many it begins anew.
    Number(Option<u64>),
    /// Odometry: x, y (0, 1) in m or heading (2) in rad, and the factor to them.
    Pose(usize, f64),
    /// Absolute heading, and the factor to rad.
    Heading(f64),
    /// The reading of this index, and the factor to its SI unit.
    Reading(usize, f64),
    /// Something else.
    Other,
}

/// Names of columns beside the readings, for messages.
const KNOWN: [&str; 11] = ["t", "t_ms", "t_us", "seq", "seq8", "seq16", "seq32", "x", "y", "theta", "heading"];
/// Units that a column's name may carry, and their factor to SI.
const UNITS: [(&str, f64); 8] = [
    ("_uT", 1e-6),
    ("_mT", 1e-3),
    ("_mm", 1e-3),
    ("_deg", core::f64::consts::PI / 180.0),
    ("_mNm", 1e-3),
    ("_uNm", 1e-6),
    ("_mN", 1e-3),
    ("_G", 1e-4),
];
/// What 32 bits of milliseconds and microseconds hold (s).
const WRAP_MS: f64 = 4_294_967.296;
const WRAP_US: f64 = 4_294.967_296;

/// The columns of a line.
#[derive(Clone, Debug, PartialEq)]
pub struct Columns {
    columns: Vec<Column>,
    channels: Vec<Channel>,
}

/// The frame of a line.
pub(super) struct Values(pub(super) Frame);

impl Columns {
    /// Columns by their names; `whisker` is whose readings those are that do not say it. The name `-` stands for a column that is not
    /// used.
    ///
    /// # Errors
    ///
    /// A name that means nothing, names twice, odometry without x, y or theta, neither odometry nor readings.
    pub fn new(names: &[String], whisker: &str) -> Result<Self> {
        let columns = Self::known(names, whisker);
        if let Some((name, _)) =
            names.iter().zip(&columns.columns).find(|(name, column)| **column == Column::Other && *name != "-")
        {
            let bare = name.rsplit('.').next().unwrap_or(name);
            let words: Vec<&str> = KNOWN.into_iter().chain(Quantity::ALL.map(Quantity::word)).collect();
            return Err(Error::data("unknown column")
                .value(format!("\"{name}\""))
                .allowed(format!("{}; units as in bx_uT, x_mm, theta_deg, moment_mNm", words.join(", ")))
                .remedy(format!("{}; \"-\" for a column that is not used", did_you_mean(bare, &words))));
        }
        if let Some((index, name)) =
            names.iter().enumerate().find(|(index, name)| *name != "-" && names[..*index].contains(name))
        {
            return Err(Error::data("two columns have the same name")
                .value(format!("\"{name}\", the second is column {}", index + 1))
                .remedy("rename one; several whiskers are told apart as NAME.moment"));
        }
        columns.complete()
    }

    /// The columns of a header line; none where the line is no header. Names that mean nothing are not used.
    pub(super) fn of_header(names: &[String], whisker: &str) -> Option<Self> {
        let names_only = names.iter().all(|name| number(name).is_none() && !name.is_empty());
        names_only.then(|| Self::known(names, whisker).complete().ok()).flatten()
    }

    fn known(names: &[String], whisker: &str) -> Self {
        let mut channels = Vec::new();
        let columns = names.iter().map(|name| column(name, whisker, &mut channels)).collect();
        Self { columns, channels }
    }

    fn complete(self) -> Result<Self> {
        let poses = self.columns.iter().filter(|column| matches!(column, Column::Pose(..))).count();
        if !matches!(poses, 0 | 3) {
            return Err(Error::data("odometry has three columns")
                .value(format!("{poses} of them"))
                .allowed("x, y and theta, or none of them"));
        }
        if poses == 0 && self.channels.is_empty() {
            return Err(Error::data("the columns hold neither odometry nor readings")
                .allowed("x, y and theta, or readings such as moment or bx, by, bz"));
        }
        Ok(self)
    }

    /// The readings, in order.
    #[must_use]
    pub fn channels(&self) -> &[Channel] {
        &self.channels
    }

    pub(super) fn has_pose(&self) -> bool {
        self.columns.iter().any(|column| matches!(column, Column::Pose(..)))
    }

    pub(super) fn stamp_wraps(&self) -> Option<f64> {
        self.columns.iter().find_map(|column| match column {
            Column::Time(factor) if *factor < 1e-4 => Some(WRAP_US),
            Column::Time(factor) if *factor < 1e-1 => Some(WRAP_MS),
            _ => None,
        })
    }

    pub(super) fn number_wraps(&self) -> Option<u64> {
        self.columns.iter().find_map(|column| if let Column::Number(wraps) = column { *wraps } else { None })
    }

    /// The frame of a line; none where a field is missing, one too many, or not a finite number.
    pub(super) fn line(&self, text: &str) -> Option<Values> {
        let mut fields = text.split(',');
        let values: Option<Vec<f64>> = self
            .columns
            .iter()
            .map(|column| {
                let field = fields.next()?;
                if *column == Column::Other { Some(0.0) } else { number(field) }
            })
            .collect();
        let values = values.filter(|_| fields.next().is_none())?;
        Some(Values(self.frame(&values)))
    }

    /// The frame of these numbers, one for each column.
    pub(super) fn frame(&self, values: &[f64]) -> Frame {
        let mut frame = Frame { readings: vec![0.0; self.channels.len()], ..Frame::default() };
        let mut pose = [None; 3];
        for (column, value) in self.columns.iter().zip(values) {
            match *column {
                Column::Time(factor) => frame.stamp = Some(value * factor),
                // Numbers of frames are whole and not negative; what is not says nothing.
                Column::Number(_) => frame.number = (*value >= 0.0 && *value < 1e15).then_some(*value as u64),
                Column::Pose(index, factor) => pose[index] = Some(value * factor),
                Column::Heading(factor) => frame.heading = Some(value * factor),
                Column::Reading(index, factor) => frame.readings[index] = value * factor,
                Column::Other => {}
            }
        }
        if let [Some(x), Some(y), Some(theta)] = pose {
            frame.pose = Some(Pose2::new(x, y, theta));
        }
        frame
    }
}

/// What a name stands for; a reading's channel goes to `channels`.
fn column(name: &str, whisker: &str, channels: &mut Vec<Channel>) -> Column {
    let unit = UNITS.iter().find_map(|&(unit, factor)| Some((name.strip_suffix(unit)?, factor)));
    let (name, factor) = unit.unwrap_or((name, 1.0));
    match name {
        "t" => return Column::Time(1.0),
        "t_ms" => return Column::Time(1e-3),
        "t_us" => return Column::Time(1e-6),
        "seq" => return Column::Number(None),
        "seq8" => return Column::Number(Some(1 << 8)),
        "seq16" => return Column::Number(Some(1 << 16)),
        "seq32" => return Column::Number(Some(1 << 32)),
        "x" => return Column::Pose(0, factor),
        "y" => return Column::Pose(1, factor),
        "theta" => return Column::Pose(2, factor),
        "heading" => return Column::Heading(factor),
        _ => {}
    }
    let (of, word) = name.rsplit_once('.').unwrap_or((whisker, name));
    let Some(quantity) = Quantity::ALL.into_iter().find(|quantity| quantity.word() == word) else {
        return Column::Other;
    };
    channels.push(Channel { whisker: of.to_owned(), quantity });
    Column::Reading(channels.len() - 1, factor)
}
