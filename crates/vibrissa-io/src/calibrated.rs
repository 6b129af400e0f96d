//! Logs of raw readings as logs of moments, by the calibration that each whisker's robot file names.

use crate::calibration;
use crate::flow::sensor_log::{Channel, LogRow, Quantity, SensorLog};
use crate::world::calibration::{MomentCurve, MomentPlane};
use crate::world::{MountedWhisker, Robot};
use crate::{Error, Result};
use std::borrow::Cow;

/// One whisker's raw channels, and what they go through.
#[derive(Clone, Debug)]
struct Converted {
    whisker: usize,
    name: String,
    channels: Vec<usize>,
    response: Response,
}

/// From raw readings to a moment, or to the moments about both transverse axes.
#[derive(Clone, Debug)]
enum Response {
    Curve(MomentCurve),
    Plane(MomentPlane),
}

impl Response {
    fn inputs(&self) -> &[String] {
        match self {
            Self::Curve(curve) => &curve.inputs,
            Self::Plane(plane) => &plane.inputs,
        }
    }

    /// What it gives, in order.
    fn quantities(&self) -> &'static [Quantity] {
        match self {
            Self::Curve(_) => &[Quantity::Moment],
            Self::Plane(_) => &[Quantity::Moment, Quantity::Across],
        }
    }

    /// The bound on the error of each moment (N m).
    fn bound(&self) -> f64 {
        match self {
            Self::Curve(curve) => curve.bound,
            Self::Plane(plane) => plane.bound[0].max(plane.bound[1]),
        }
    }
}

/// Raw readings to moments, row by row.
#[derive(Clone, Debug)]
pub struct Calibrator {
    converted: Vec<Converted>,
}

impl Calibrator {
    /// The calibrator of each whisker that has a calibration and no moment among these channels; none when there is no such whisker.
    ///
    /// # Errors
    ///
    /// A calibration that cannot be read or holds no curve to moments, channels without its inputs.
    pub fn new(channels: &[Channel], robot: &Robot) -> Result<Option<Self>> {
        Self::of(&SensorLog { channels: channels.to_vec(), ..SensorLog::default() }, robot)
    }

    fn of(log: &SensorLog, robot: &Robot) -> Result<Option<Self>> {
        let wanted =
            robot.whiskers.iter().enumerate().filter(|(_, whisker)| log.moment_channel(&whisker.name).is_err());
        let converted: Vec<Converted> =
            wanted.filter_map(|(index, whisker)| convert(log, whisker, index).transpose()).collect::<Result<_>>()?;
        Ok((!converted.is_empty()).then_some(Self { converted }))
    }

    /// The robot with the calibrations' bounds added to the declared bounds of their whiskers.
    #[must_use]
    pub fn robot(&self, robot: &Robot) -> Robot {
        let mut robot = robot.clone();
        for one in &self.converted {
            robot.whiskers[one.whisker].noise.moment_absolute += one.response.bound();
        }
        robot
    }

    /// The channels with a moment for each whisker that is calibrated, at the end; with both moments where both axes are.
    #[must_use]
    pub fn channels(&self, channels: &[Channel]) -> Vec<Channel> {
        let moments = self.converted.iter().flat_map(|one| {
            one.response.quantities().iter().map(|&quantity| Channel { whisker: one.name.clone(), quantity })
        });
        channels.iter().cloned().chain(moments).collect()
    }

    /// Adds the moments to a row.
    ///
    /// # Errors
    ///
    /// A reading beyond the calibrated range; a row without one of its readings.
    pub fn row(&self, row: &mut LogRow) -> Result<()> {
        for one in &self.converted {
            row.check(one.channels.iter().copied())?;
            let raw: Vec<f64> = one.channels.iter().map(|&channel| row.readings[channel]).collect();
            match &one.response {
                Response::Curve(curve) => row.readings.push(curve.moment(&raw)?),
                Response::Plane(plane) => row.readings.extend(plane.moments(&raw)?),
            }
        }
        Ok(())
    }
}

/// The log with a moment for each whisker that has a calibration and no moment yet, and the robot with the calibration's
/// bound added to the declared bounds of these whiskers; both untouched when there is nothing to do.
///
/// # Errors
///
/// A calibration that cannot be read or holds no curve to moments, a log without its inputs, a reading beyond the
/// calibrated range; the message names file and line.
pub fn calibrated<'a>(log: &'a SensorLog, robot: &'a Robot) -> Result<(Cow<'a, SensorLog>, Cow<'a, Robot>)> {
    let Some(calibrator) = Calibrator::of(log, robot)? else {
        return Ok((Cow::Borrowed(log), Cow::Borrowed(robot)));
    };
    let row = |row: &LogRow| -> Result<LogRow> {
        let mut row = row.clone();
        calibrator.row(&mut row).map_err(|e| at(e, log, row.line))?;
        Ok(row)
    };
    let rows = log.rows.iter().map(row).collect::<Result<_>>()?;
    let channels = calibrator.channels(&log.channels);
    let calibrated = SensorLog { channels, rows, warnings: log.warnings.clone(), source: log.source.clone() };
    Ok((Cow::Owned(calibrated), Cow::Owned(calibrator.robot(robot))))
}

fn convert(log: &SensorLog, whisker: &MountedWhisker, index: usize) -> Result<Option<Converted>> {
    let Some(path) = &whisker.calibration else { return Ok(None) };
    let calibration = calibration::read(path)?;
    let both = calibration.plane.map(Response::Plane);
    let response = both.or(calibration.moment.map(Response::Curve)).ok_or_else(|| {
        Error::data("the calibration does not turn readings into moments")
            .in_file(path)
            .remedy("make one with `vibrissa calibrate LOG.csv --out DIR` from labelled contacts")
    })?;
    let channels: Vec<usize> =
        response.inputs().iter().map(|word| raw_channel(log, &whisker.name, word)).collect::<Result<_>>()?;
    // A log that names its columns names the moment too.
    let name = channels.first().map(|&channel| log.channels[channel].whisker.clone()).unwrap_or_default();
    Ok(Some(Converted { whisker: index, name, channels, response }))
}

/// The channel of this quantity that belongs to the whisker; an unnamed one belongs to any.
fn raw_channel(log: &SensorLog, whisker: &str, word: &str) -> Result<usize> {
    let find = |name: &str| log.channels.iter().position(|c| c.quantity.word() == word && c.whisker == name);
    find(whisker).or_else(|| find("")).ok_or_else(|| {
        let held: Vec<String> = log.channels.iter().map(Channel::column).collect();
        let error = Error::data(format!("the log has neither a moment nor `{word}` for the whisker \"{whisker}\""))
            .value(format!("it holds {}", crate::text::listed(&held)))
            .remedy("the calibration needs the columns that it was made from");
        match &log.source {
            Some(file) => error.in_file(file),
            None => error,
        }
    })
}

fn at(error: Error, log: &SensorLog, line: usize) -> Error {
    let error = if line > 0 { error.at_line(line) } else { error };
    match &log.source {
        Some(file) => error.in_file(file),
        None => error,
    }
}
