//! Constants of the whisker from labelled contacts, by least squares.

use super::labelled::Labelled;
use crate::beam::Whisker;
use crate::least_squares::{Scale, linear, minimise};
use crate::world::calibration::WhiskerConstants;
use crate::{Error, Result};

/// A constant of the whisker that may be fitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Constant {
    /// Flexural rigidity at the base (N m²).
    FlexuralRigidity,
    /// Rotational compliance of the base, `1 / k_base` (rad/(N m)).
    BaseCompliance,
    /// Tip radius over base radius.
    TipRatio,
}

impl Constant {
    /// Every constant.
    pub const ALL: [Self; 3] = [Self::FlexuralRigidity, Self::BaseCompliance, Self::TipRatio];

    /// The word on the command line and in files.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Self::FlexuralRigidity => "flexural_rigidity",
            Self::BaseCompliance => "base_compliance",
            Self::TipRatio => "tip_ratio",
        }
    }

    fn of(self, whisker: &Whisker) -> f64 {
        match self {
            Self::FlexuralRigidity => whisker.flexural_rigidity,
            Self::BaseCompliance => 1.0 / whisker.base_stiffness,
            Self::TipRatio => whisker.tip_ratio,
        }
    }

    fn set(self, whisker: &mut Whisker, value: f64) {
        match self {
            Self::FlexuralRigidity => whisker.flexural_rigidity = value,
            Self::BaseCompliance => whisker.base_stiffness = 1.0 / value,
            Self::TipRatio => whisker.tip_ratio = value,
        }
    }

    fn scale(self, whisker: &Whisker) -> Scale {
        let soft = whisker.length / whisker.flexural_rigidity;
        match self {
            Self::FlexuralRigidity => {
                let size = whisker.flexural_rigidity;
                Scale { lo: 1e-3 * size, hi: 1e3 * size, size }
            }
            // Beyond the upper end the base does all of the bending.
            Self::BaseCompliance => Scale { lo: 0.0, hi: 1e3 * soft, size: soft },
            Self::TipRatio => Scale { lo: 0.01, hi: 1.0, size: 1.0 },
        }
    }
}

/// Fits the constants `free` of a whisker to measured moments, or, without these, to a signal that follows the moment by an
/// unknown response of third degree; then the flexural rigidity cannot be told and must not be free.
///
/// The covariance assumes independent errors of equal size, which is estimated from the residuals.
///
/// # Errors
///
/// Usage: nothing free, or the rigidity without moments. Data: fewer contacts than constants, contacts that no whisker
/// reaches, data that do not fix the constants.
pub fn fit_constants(
    labelled: &Labelled,
    signal: &[f64],
    start: &Whisker,
    free: &[Constant],
) -> Result<WhiskerConstants> {
    let by_gain = labelled.moments.is_none();
    if free.is_empty() || (by_gain && free.contains(&Constant::FlexuralRigidity)) {
        return Err(Error::usage("the flexural rigidity cannot be told from raw readings")
            .allowed("base_compliance and tip_ratio, or a log with a column moment"));
    }
    let targets: &[f64] = labelled.moments.as_deref().unwrap_or(signal);
    let reached: Vec<usize> = labelled.explain(start)?.iter().map(|e| e.row).collect();
    let nuisance = if by_gain { SENSOR } else { 0 };
    let fewest = free.len() + nuisance + 3;
    if reached.len() < fewest {
        return Err(Error::data("too few contacts that the whisker can reach")
            .in_file(&labelled.source)
            .value(reached.len())
            .allowed(format!("{fewest} or more")));
    }
    let chosen = Labelled { contacts: reached.iter().map(|&r| labelled.contacts[r]).collect(), ..labelled.clone() };
    let targets: Vec<f64> = reached.iter().map(|&r| targets[r]).collect();
    let whisker = |parameters: &[f64]| {
        let mut whisker = *start;
        free.iter().zip(parameters).for_each(|(constant, value)| constant.set(&mut whisker, *value));
        whisker
    };
    let residuals = |parameters: &[f64]| -> Option<Vec<f64>> {
        let explained = chosen.explain(&whisker(parameters)).ok()?;
        if explained.len() != targets.len() {
            return None;
        }
        let moments: Vec<f64> = explained.iter().map(|e| e.moment).collect();
        let model = if by_gain { through_sensor(&moments, &targets)? } else { moments };
        Some(model.iter().zip(&targets).map(|(model, target)| model - target).collect())
    };
    let scales: Vec<Scale> = free.iter().map(|c| c.scale(start)).collect();
    let begin: Vec<f64> = free.iter().map(|c| c.of(start)).collect();
    let minimum = minimise(residuals, &begin, &scales).map_err(|e| e.in_file(&labelled.source))?;
    let spare = targets.len() - free.len() - nuisance;
    let variance = minimum.residuals.iter().map(|r| r * r).sum::<f64>() / spare as f64;
    if minimum.unit_covariance.is_empty() {
        return Err(Error::data("the contacts do not fix these constants")
            .in_file(&labelled.source)
            .value(free.iter().map(|c| c.as_str()).collect::<Vec<_>>().join(", "))
            .remedy("record contacts at several distances along the whisker, or free fewer constants"));
    }
    let fitted = whisker(&minimum.parameters);
    Ok(WhiskerConstants {
        flexural_rigidity: fitted.flexural_rigidity,
        base_stiffness: fitted.base_stiffness,
        tip_ratio: fitted.tip_ratio,
        free: free.iter().map(|c| c.as_str().to_owned()).collect(),
        covariance: minimum.unit_covariance.iter().map(|row| row.iter().map(|c| c * variance).collect()).collect(),
        residual_rms: variance.sqrt(),
        samples: targets.len(),
    })
}

/// Constants of a sensor that is not known: offset, gain, and two that bend it.
const SENSOR: usize = 4;

/// The signal that a sensor with the best response of third degree makes of the moments.
fn through_sensor(moments: &[f64], targets: &[f64]) -> Option<Vec<f64>> {
    let scale = moments.iter().fold(0.0, |most: f64, m| most.max(m.abs()));
    let rows: Vec<Vec<f64>> =
        moments.iter().map(|m| m / scale).map(|z| (0..SENSOR).map(|k| z.powi(k as i32)).collect()).collect();
    let response = linear(&rows, targets)?;
    Some(rows.iter().map(|row| row.iter().zip(&response).map(|(power, c)| power * c).sum()).collect())
}
