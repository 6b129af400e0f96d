//! `cal.json`: one reader, one writer.

use crate::config::budgets::CALIBRATION_BYTES;
use crate::text::read_text;
use crate::world::calibration::{
    Calibration, DistanceModel, MomentCurve, MomentPlane, Motion, Source, TipDeflection, VERSION, WhiskerConstants,
};
use crate::{Error, Result};
use serde_json::{Value, json};
use std::path::Path;

/// Reads a calibration file.
///
/// # Errors
///
/// A file that cannot be read, is no JSON, has another version, or lacks a key; the message names it.
pub fn read(path: impl AsRef<Path>) -> Result<Calibration> {
    let path = path.as_ref();
    from_json(&read_text(path, "calibration", CALIBRATION_BYTES)?, &path.to_string_lossy())
}

/// The calibration in a JSON text; `name` stands for the file in messages. Unknown keys are left alone.
///
/// # Errors
///
/// As [`read`].
pub fn from_json(text: &str, name: &str) -> Result<Calibration> {
    let remedy = "make it with `vibrissa calibrate`; docs/calibration.md has every key";
    parse(text).map_err(|e| e.in_file(name).or_remedy(remedy))
}

/// The calibration as JSON.
#[must_use]
pub fn to_json(calibration: &Calibration) -> Value {
    let mut object = json!({ "format": FORMAT, "version": VERSION });
    object["data"] = calibration.data.iter().map(source_json).collect();
    if let Some(curve) = &calibration.moment {
        object["moment"] = moment_json(curve);
    }
    if let Some(plane) = &calibration.plane {
        object["plane"] = plane_json(plane);
    }
    if let Some(tip) = &calibration.tip_deflection {
        object["tip_deflection"] = json!({
            "coefficients": tip.coefficients, "largest_moment": tip.largest_moment,
            "residual_rms": tip.residual_rms,
        });
    }
    if let Some(whisker) = &calibration.whisker {
        object["whisker"] = json!({
            "flexural_rigidity": whisker.flexural_rigidity, "base_stiffness": or_inf(whisker.base_stiffness),
            "tip_ratio": whisker.tip_ratio, "free": whisker.free, "covariance": whisker.covariance,
            "residual_rms": whisker.residual_rms, "samples": whisker.samples,
        });
    }
    if let Some(model) = &calibration.distance {
        object["distance"] = json!({
            "channel": calibration.channel, "motion": model.motion.as_str(), "gain": model.gain, "length": model.length,
            "tip_ratio": model.tip_ratio, "base_compliance": model.base_compliance, "scatter": model.scatter,
            "fitted": model.fitted,
        });
    }
    object
}

/// What the key `format` must say.
const FORMAT: &str = "vibrissa calibration";

/// JSON has no infinity.
fn or_inf(value: f64) -> Value {
    if value.is_infinite() { json!("inf") } else { json!(value) }
}

fn source_json(source: &Source) -> Value {
    let mut object = json!({ "file": source.file, "rows": source.rows, "used": source.used });
    if let Some(distance) = source.distance {
        object["distance"] = json!(distance);
    }
    object
}

fn moment_json(curve: &MomentCurve) -> Value {
    json!({
        "inputs": curve.inputs, "rest": curve.rest, "direction": curve.direction, "range": curve.range,
        "coefficients": curve.coefficients, "residual_rms": curve.residual_rms, "hysteresis": curve.hysteresis,
        "bound": curve.bound, "samples": curve.samples,
    })
}

fn plane_json(plane: &MomentPlane) -> Value {
    json!({
        "inputs": plane.inputs, "rest": plane.rest, "directions": plane.directions, "ranges": plane.ranges,
        "reach": plane.reach, "coefficients": plane.coefficients, "residual_rms": plane.residual_rms,
        "hysteresis": plane.hysteresis, "bound": plane.bound, "samples": plane.samples,
    })
}

fn parse(text: &str) -> Result<Calibration> {
    let root: Value =
        serde_json::from_str(text).map_err(|e| Error::data("not valid JSON").at_line(e.line().max(1)).value(&e))?;
    if root.get("format").and_then(Value::as_str) != Some(FORMAT) {
        return Err(Error::data("this is no calibration").allowed(format!("\"format\": \"{FORMAT}\"")));
    }
    let version = root.get("version").and_then(Value::as_u64);
    if version != Some(u64::from(VERSION)) {
        let shown = version.map_or("none".to_owned(), |v| v.to_string());
        return Err(Error::data("a calibration of another version").value(shown).allowed(VERSION.to_string()));
    }
    let section = |key: &'static str| root.get(key).map(|value| Section { value, path: key });
    let data = root.get("data").and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
    let calibration = Calibration {
        data: data.iter().map(source).collect::<Result<_>>()?,
        moment: section("moment").map(moment).transpose()?,
        plane: section("plane").map(plane).transpose()?,
        tip_deflection: section("tip_deflection").map(tip_deflection).transpose()?,
        whisker: section("whisker").map(whisker).transpose()?,
        channel: section("distance").map_or(Ok(String::new()), |s| s.text("channel").map(str::to_owned))?,
        distance: section("distance").map(distance).transpose()?,
    };
    Ok(calibration)
}

/// One object of the file, with its path for messages.
struct Section<'a> {
    value: &'a Value,
    path: &'static str,
}

impl<'a> Section<'a> {
    fn get<T>(&self, key: &str, what: &str, read: impl Fn(&'a Value) -> Option<T>) -> Result<T> {
        let value = self.value.get(key);
        value.and_then(read).ok_or_else(|| {
            let shown = value.map_or("missing".to_owned(), Value::to_string);
            Error::data(format!("{}.{key}", self.path)).value(shown).allowed(what)
        })
    }

    fn number(&self, key: &str) -> Result<f64> {
        self.get(key, "a number", Value::as_f64)
    }

    /// A stiffness, which may be that of a rigid base.
    fn stiffness(&self, key: &str) -> Result<f64> {
        let rigid = |v: &Value| (v.as_str() == Some("inf")).then_some(f64::INFINITY);
        self.get(key, "a number or \"inf\"", |v| v.as_f64().or_else(|| rigid(v)))
    }

    fn count(&self, key: &str) -> Result<usize> {
        self.get(key, "a whole number", Value::as_u64).map(|n| n as usize)
    }

    fn text(&self, key: &str) -> Result<&'a str> {
        self.get(key, "a text", Value::as_str)
    }

    fn numbers(&self, key: &str) -> Result<Vec<f64>> {
        self.get(key, "a list of numbers", numbers)
    }

    fn pair(&self, key: &str) -> Result<[f64; 2]> {
        self.get(key, "two numbers", |v| numbers(v)?.try_into().ok())
    }

    /// Two lists of numbers, each as long as its type says.
    fn pair_of<T: TryFrom<Vec<f64>>>(&self, key: &str, what: &str) -> Result<[T; 2]> {
        let one = |value: &Value| numbers(value)?.try_into().ok();
        self.get(key, what, |v| v.as_array()?.iter().map(one).collect::<Option<Vec<T>>>()?.try_into().ok())
    }

    fn texts(&self, key: &str) -> Result<Vec<String>> {
        self.get(key, "a list of texts", |v| v.as_array()?.iter().map(|v| v.as_str().map(str::to_owned)).collect())
    }
}

fn numbers(value: &Value) -> Option<Vec<f64>> {
    value.as_array()?.iter().map(Value::as_f64).collect()
}

fn source(value: &Value) -> Result<Source> {
    let section = Section { value, path: "data[]" };
    Ok(Source {
        file: section.text("file")?.to_owned(),
        rows: section.count("rows")?,
        used: section.count("used")?,
        distance: value.get("distance").and_then(Value::as_f64),
    })
}

fn moment(section: Section<'_>) -> Result<MomentCurve> {
    let curve = MomentCurve {
        inputs: section.texts("inputs")?,
        rest: section.numbers("rest")?,
        direction: section.numbers("direction")?,
        range: section.pair("range")?,
        coefficients: section.numbers("coefficients")?,
        residual_rms: section.number("residual_rms")?,
        hysteresis: section.number("hysteresis")?,
        bound: section.number("bound")?,
        samples: section.count("samples")?,
    };
    let n = curve.inputs.len();
    if n == 0 || curve.rest.len() != n || curve.direction.len() != n || curve.coefficients.is_empty() {
        return Err(Error::data(
            "moment: inputs, rest and direction must be of one length, and coefficients not empty",
        ));
    }
    if !(curve.range[1] > 0.0 && curve.bound >= 0.0) {
        return Err(Error::data("moment: the range's half width must be above 0 and the bound not negative"));
    }
    Ok(curve)
}

fn plane(section: Section<'_>) -> Result<MomentPlane> {
    let plane = MomentPlane {
        inputs: section.texts("inputs")?,
        rest: section.numbers("rest")?,
        directions: section.pair_of("directions", "two lists of numbers")?,
        ranges: section.pair_of("ranges", "two pairs of numbers")?,
        reach: section.number("reach")?,
        coefficients: section.pair_of("coefficients", "two lists of 10 numbers")?,
        residual_rms: section.pair("residual_rms")?,
        hysteresis: section.number("hysteresis")?,
        bound: section.pair("bound")?,
        samples: section.count("samples")?,
    };
    plane.check().map_err(|e| e.about("plane"))?;
    Ok(plane)
}

fn tip_deflection(section: Section<'_>) -> Result<TipDeflection> {
    Ok(TipDeflection {
        coefficients: section.pair("coefficients")?,
        largest_moment: section.number("largest_moment")?,
        residual_rms: section.number("residual_rms")?,
    })
}

fn whisker(section: Section<'_>) -> Result<WhiskerConstants> {
    let covariance = section.get("covariance", "a list of rows", |v| v.as_array()?.iter().map(numbers).collect())?;
    Ok(WhiskerConstants {
        flexural_rigidity: section.number("flexural_rigidity")?,
        base_stiffness: section.stiffness("base_stiffness")?,
        tip_ratio: section.number("tip_ratio")?,
        free: section.texts("free")?,
        covariance,
        residual_rms: section.number("residual_rms")?,
        samples: section.count("samples")?,
    })
}

fn distance(section: Section<'_>) -> Result<DistanceModel> {
    let motion = section.get("motion", "turn or travel", |v| v.as_str().and_then(Motion::from_word))?;
    let model = DistanceModel {
        motion,
        gain: section.number("gain")?,
        length: section.number("length")?,
        tip_ratio: section.number("tip_ratio")?,
        base_compliance: section.number("base_compliance")?,
        scatter: section.number("scatter")?,
        fitted: section.pair("fitted")?,
    };
    model.check().map_err(|e| e.about("distance"))?;
    Ok(model)
}
