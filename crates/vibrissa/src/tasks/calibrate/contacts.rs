//! A whole calibration from labelled contacts, and what is known of a shaft before its distances are fitted.

use super::{
    Constant, Explained, Labelled, Shaft, fit_constants, fit_moment_curve, fit_moment_plane, fit_tip_deflection,
};
use crate::beam::Whisker;
use crate::config::{CurveOptions, shaft};
use crate::io::log::foreign::Recording;
use crate::world::calibration::{Calibration, Motion, Source};
use crate::{Error, Result};

/// A calibration, and the contacts behind it.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactCalibration {
    /// What was found.
    pub calibration: Calibration,
    /// The readings with their contacts.
    pub labelled: Labelled,
    /// The contacts that the whisker reaches, as the calibrated whisker explains them.
    pub explained: Vec<Explained>,
}

impl ContactCalibration {
    /// How many contacts are out of the whisker's reach and were left out.
    #[must_use]
    pub fn out_of_reach(&self) -> usize {
        self.labelled.contacts.len() - self.explained.len()
    }
}

/// Calibrates a whisker from a recording of labelled contacts (columns `x,y` and raw readings or `moment`): raw readings
/// to moments, moments to the tip's retreat, and the constants `free` of the whisker; `file` names the recording in the
/// calibration. With a column `z`, raw readings to the moments about both transverse axes.
///
/// # Errors
///
/// As [`Labelled::from_recording`], [`fit_constants`], [`fit_moment_curve`] and [`fit_moment_plane`]; data: nothing to calibrate.
pub fn calibrate_contacts(
    recording: &Recording,
    file: &str,
    whisker: &Whisker,
    free: &[Constant],
) -> Result<ContactCalibration> {
    let labelled = Labelled::from_recording(recording)?;
    let (options, mut whisker) = (CurveOptions::default(), *whisker);
    let mut explained = labelled.explain(&whisker)?;
    let constants = if free.is_empty() {
        None
    } else {
        let constants = fit_constants(&labelled, &signal(&labelled, &explained, &options)?, &whisker, free)?;
        whisker.flexural_rigidity = constants.flexural_rigidity;
        whisker.base_stiffness = constants.base_stiffness;
        whisker.tip_ratio = constants.tip_ratio;
        explained = labelled.explain(&whisker)?;
        Some(constants)
    };
    let (mut moment, mut plane) = (None, None);
    if labelled.inputs.is_empty() {
        // Moments are measured: there is nothing to turn into them.
    } else if labelled.angles.is_empty() {
        moment = Some(fit_moment_curve(&labelled, &explained, &options)?);
    } else {
        plane = Some(fit_moment_plane(&labelled, &explained, &options)?);
    }
    let source = Source { file: file.to_owned(), rows: recording.lines.len(), used: explained.len(), distance: None };
    let calibration = Calibration {
        data: vec![source],
        moment,
        plane,
        tip_deflection: fit_tip_deflection(&explained),
        whisker: constants,
        ..Calibration::default()
    };
    if moment_free(&calibration) && calibration.tip_deflection.is_none() && calibration.whisker.is_none() {
        return Err(Error::data(
            "there is nothing to calibrate: no contact bends the whisker, and there are no raw readings",
        )
        .in_file(file)
        .remedy("give contact points x,y in m in the whisker frame beside bx,by,bz or ax,ay,az; docs/calibration.md"));
    }
    Ok(ContactCalibration { calibration, labelled, explained })
}

fn moment_free(calibration: &Calibration) -> bool {
    calibration.moment.is_none() && calibration.plane.is_none()
}

/// The readings' excursion for each contact; nothing where moments are measured.
fn signal(labelled: &Labelled, explained: &[Explained], options: &CurveOptions) -> Result<Vec<f64>> {
    if labelled.moments.is_some() {
        return Ok(Vec::new());
    }
    if !labelled.angles.is_empty() {
        return Err(Error::data("constants of the whisker cannot be told from raw readings of contacts in space")
            .in_file(&labelled.source)
            .allowed("contacts in the x-y plane (z = 0), or a column moment")
            .remedy("record contacts in one plane for --free, and all others in a log of their own"));
    }
    let curve = fit_moment_curve(labelled, explained, options)?;
    Ok(labelled.readings.iter().map(|readings| curve.signal(readings)).collect())
}

/// What a call says of a shaft's taper.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Taper {
    /// Nothing: the whisker's, or what the usual shaft of this motion has.
    #[default]
    Usual,
    /// Tip radius over base radius.
    Given(f64),
    /// It is fitted.
    Free,
}

impl Shaft {
    /// The shaft that a call describes: what it leaves out comes from `whisker`, or else from the usual shaft of this motion.
    ///
    /// # Errors
    ///
    /// Usage: a length or a taper out of range.
    pub fn described(
        motion: Motion,
        whisker: Option<&Whisker>,
        length: Option<f64>,
        taper: Taper,
        clamped: bool,
    ) -> Result<Self> {
        let (usual_length, usual_ratio) = match motion {
            Motion::Turn => (shaft::TAPPED_LENGTH, Some(shaft::TAPPED_TIP_RATIO)),
            Motion::Travel => (shaft::STAIRCASE_LENGTH, None),
        };
        let tip_ratio = match taper {
            Taper::Free => None,
            Taper::Given(ratio) => Some(ratio),
            Taper::Usual => whisker.map_or(usual_ratio, |beam| Some(beam.tip_ratio)),
        };
        let length = length.or(whisker.map(|beam| beam.length)).unwrap_or(usual_length);
        if !(length > 0.0 && length <= 10.0) {
            return Err(Error::usage("--length").value(length).allowed("above 0, up to 10 m"));
        }
        if let Some(ratio) = tip_ratio.filter(|ratio| !(1e-3..=1.0).contains(ratio)) {
            return Err(Error::usage("--tip-ratio").value(ratio).allowed("0.001 to 1, or free"));
        }
        Ok(Self { motion, length, tip_ratio, clamped: clamped || tip_ratio.is_none() })
    }
}
