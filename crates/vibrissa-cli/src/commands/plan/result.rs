//! The places of a `result.json`.

use serde::Deserialize;
use std::path::Path;
use vibrissa::config::budgets::MAP_BYTES;
use vibrissa::flow::pose::Hypothesis;
use vibrissa::io::text::read_text;
use vibrissa::plane::Pose2;
use vibrissa::sets::{Interval, StateBox};
use vibrissa::{Error, Result};

#[derive(Deserialize)]
struct ResultFile {
    hypotheses: Vec<Place>,
}

#[derive(Deserialize)]
struct Place {
    x: f64,
    y: f64,
    theta: f64,
    weight: f64,
    x_min: f64,
    x_max: f64,
    y_min: f64,
    y_max: f64,
    theta_min: f64,
    theta_max: f64,
    covariance: Option<[[f64; 3]; 3]>,
    #[serde(default)]
    ridge: Vec<[f64; 3]>,
}

/// The places of a result that `localize` wrote.
pub(super) fn read(path: &Path) -> Result<Vec<Hypothesis>> {
    let remedy = "give the result.json of `vibrissa localize --out DIR`, or a sensor log";
    let text = read_text(path, "result", MAP_BYTES)?;
    let file: ResultFile = serde_json::from_str(&text).map_err(|error| {
        Error::data(format!("this is no result of a localization ({error})")).in_file(path).remedy(remedy)
    })?;
    if file.hypotheses.is_empty() {
        return Err(Error::data("the result tells no place between which a motion could decide")
            .in_file(path)
            .remedy(remedy));
    }
    Ok(file.hypotheses.iter().map(hypothesis).collect())
}

fn hypothesis(place: &Place) -> Hypothesis {
    Hypothesis {
        pose: Pose2::new(place.x, place.y, place.theta),
        weight: place.weight,
        extent: StateBox {
            x: Interval::new(place.x_min, place.x_max),
            y: Interval::new(place.y_min, place.y_max),
            theta: Interval::new(place.theta_min, place.theta_max),
        },
        covariance: place.covariance,
        ridge: place.ridge.iter().map(|[x, y, theta]| Pose2::new(*x, *y, *theta)).collect(),
    }
}
