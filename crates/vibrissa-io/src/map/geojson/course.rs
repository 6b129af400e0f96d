//! How exactly a boundary is known, from a feature's properties `band`, `band_std`, `band_length`, `unknown` and `unknown_depth`.

use super::{Object, Source, excerpt};
use crate::config::band::{CORRELATION_LENGTH, STDS_IN_BOUND};
use crate::plane::Vec2;
use crate::world::{Band, Course, PieceCourse};
use crate::{Error, Result};
use serde_json::value::RawValue;

/// A number for all points, or one for each.
#[derive(Clone, Debug)]
enum Lengths {
    All(f64),
    Each(Vec<f64>),
}

/// What is unknown: everything, or from one point to another.
#[derive(Clone, Debug)]
enum Unknown {
    All,
    Stretches(Vec<[usize; 2]>),
}

/// What a feature says of how exactly it is known.
#[derive(Clone, Debug, Default)]
pub(super) struct CourseLabel {
    band: Option<Lengths>,
    std: Option<Lengths>,
    length: Option<f64>,
    unknown: Option<Unknown>,
    depth: Option<f64>,
}

impl<'a> Source<'a> {
    /// What the properties say; nothing where they say nothing of it.
    pub(super) fn course_label(&self, properties: &Object<'a>) -> Result<CourseLabel> {
        let lengths = |key: &str| properties.get(key).map(|raw| self.lengths(raw, key)).transpose();
        let number = |key: &str| properties.get(key).map(|raw| self.number(raw, key)).transpose();
        Ok(CourseLabel {
            band: lengths("band")?,
            std: lengths("band_std")?,
            length: number("band_length")?,
            unknown: properties.get("unknown").and_then(|raw| self.unknown(raw).transpose()).transpose()?,
            depth: number("unknown_depth")?,
        })
    }

    fn number(&self, raw: &'a RawValue, key: &str) -> Result<f64> {
        serde_json::from_str(raw.get()).map_err(|_| {
            self.fault(raw.get(), format!("\"{key}\" is not a number")).value(excerpt(raw.get())).allowed("metres")
        })
    }

    fn lengths(&self, raw: &'a RawValue, key: &str) -> Result<Lengths> {
        let one = serde_json::from_str(raw.get()).map(Lengths::All);
        one.or_else(|_| serde_json::from_str(raw.get()).map(Lengths::Each)).map_err(|_| {
            self.fault(raw.get(), format!("\"{key}\" is neither a number nor a list of numbers"))
                .value(excerpt(raw.get()))
                .allowed("metres: one number, or one for each point")
        })
    }

    fn unknown(&self, raw: &'a RawValue) -> Result<Option<Unknown>> {
        if let Ok(all) = serde_json::from_str::<bool>(raw.get()) {
            return Ok(all.then_some(Unknown::All));
        }
        let stretches = serde_json::from_str(raw.get()).map(|pairs| Some(Unknown::Stretches(pairs)));
        stretches.map_err(|_| {
            self.fault(raw.get(), "\"unknown\" is neither true nor a list of pairs of points")
                .value(excerpt(raw.get()))
                .allowed("true, or [[from, to], …] with points counted from 0")
        })
    }
}

impl CourseLabel {
    /// Whether it says anything.
    pub(super) fn is_some(&self) -> bool {
        self.band.is_some() || self.std.is_some() || self.unknown.is_some()
    }

    /// Whether it counts points, so that it can be of one ring or line only.
    pub(super) fn counts_points(&self) -> bool {
        let each = |lengths: &Option<Lengths>| matches!(lengths, Some(Lengths::Each(_)));
        each(&self.band) || each(&self.std) || matches!(self.unknown, Some(Unknown::Stretches(_)))
    }

    /// What it says of a line or a ring through these points.
    pub(super) fn course(&self, points: &[Vec2], closed: bool) -> Result<Course> {
        let count = points.len();
        // A repeated point makes no piece: what remains are those that begin one.
        let repeats = closed && count > 1 && points.first() == points.last();
        let vertices = if repeats { count - 1 } else { count };
        let [band, std] = [("band", &self.band), ("band_std", &self.std)].map(|(key, lengths)| match lengths {
            Some(Lengths::Each(each)) if each.len() != vertices && each.len() != count => {
                Err(Error::data(format!("\"{key}\" has another number of entries than the line has points"))
                    .value(each.len().to_string())
                    .allowed(format!("{vertices}, or one number for all")))
            }
            lengths => Ok(lengths.as_ref()),
        });
        let (bound, std) = (band?, std?);
        let at = |lengths: Option<&Lengths>, vertex: usize| match lengths {
            Some(Lengths::All(all)) => Some(*all),
            Some(Lengths::Each(each)) => each.get(vertex % vertices).copied(),
            None => None,
        };
        let band_at = |vertex: usize| match (at(bound, vertex), at(std, vertex)) {
            (Some(bound), Some(std)) => Band { std, bound },
            (Some(bound), None) => Band::even(bound),
            (None, Some(std)) => Band { std, bound: STDS_IN_BOUND * std },
            (None, None) => Band::default(),
        };
        let unknown = self.unknown_pieces(vertices, closed)?;
        let last = if closed { vertices } else { vertices.saturating_sub(1) };
        let length = |piece: usize| points[piece].distance(points[(piece + 1) % vertices]);
        let stretch = |piece: usize| -> f64 {
            // The whole stretch around the piece: a gap is as deep as it is long.
            let ahead = (piece..piece + last).take_while(|k| unknown[k % vertices]).map(|k| length(k % vertices));
            let behind = (1..last).take_while(|k| unknown[(piece + last - k) % last]);
            let behind = behind.map(|k| length((piece + last - k) % last));
            let open: f64 = ahead.sum::<f64>() + behind.sum::<f64>();
            open
        };
        let pieces = (0..last).filter(|&k| length(k) > 0.0).map(|k| {
            if unknown[k] {
                PieceCourse::Unknown(self.depth.unwrap_or_else(|| stretch(k)))
            } else {
                PieceCourse::Band([band_at(k), band_at(k + 1)])
            }
        });
        Course::new(pieces.collect(), self.length.unwrap_or(CORRELATION_LENGTH))
    }

    /// Whether the piece after each point is unknown.
    fn unknown_pieces(&self, vertices: usize, closed: bool) -> Result<Vec<bool>> {
        let mut unknown = vec![matches!(self.unknown, Some(Unknown::All)); vertices];
        let Some(Unknown::Stretches(stretches)) = &self.unknown else { return Ok(unknown) };
        for &[from, to] in stretches {
            // A ring's first point may be counted again at its end.
            let last = if closed { vertices } else { vertices - 1 };
            if from > last || to > last || from == to || (!closed && from > to) {
                return Err(Error::data("an unknown stretch that is none of the line's")
                    .value(format!("[{from}, {to}]"))
                    .allowed(format!("two different points from 0 to {last}, in the line's order")));
            }
            let (from, to) = (from % vertices, to % vertices);
            let count = (to + vertices - from) % vertices;
            (0..count).for_each(|k| unknown[(from + k) % vertices] = true);
        }
        Ok(unknown)
    }
}
