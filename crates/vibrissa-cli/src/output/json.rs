//! `result.json`: the keys are a promise; what is not finite is `null`.

use super::Run;
use serde::Serialize;
use vibrissa::flow::pose::{ConsistencyReport, Localization, Nuisance, OdometryEstimate, Remedy, Status, Stretch};
use vibrissa::flow::trajectory::TrajectoryError;
use vibrissa::plane::Pose2;
use vibrissa::{Error, Result};

#[derive(Serialize)]
struct ResultJson<'a> {
    status: &'static str,
    method: &'static str,
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    interrupted: bool,
    estimate: Option<PoseJson>,
    hypotheses: Vec<HypothesisJson>,
    #[serde(skip_serializing_if = "Option::is_none")]
    odometry: Option<OdometryJson>,
    nuisances: Vec<NuisanceJson<'a>>,
    consistency: Option<ConsistencyJson<'a>>,
    unsure: Vec<StretchJson>,
    events: Vec<EventJson<'a>>,
    runtime: RuntimeJson,
    #[serde(skip_serializing_if = "Option::is_none")]
    truth: Option<TruthJson>,
}

#[derive(Serialize)]
struct PoseJson {
    x: f64,
    y: f64,
    theta: f64,
}

#[derive(Serialize)]
struct HypothesisJson {
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
    #[serde(skip_serializing_if = "Option::is_none")]
    covariance: Option<[[f64; 3]; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    bound: Option<BoundJson>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    ridge: Vec<[f64; 3]>,
}

/// The error to be expected by the declared noise and odometry bounds: root mean squares.
#[derive(Serialize)]
struct BoundJson {
    position_m: f64,
    heading_rad: f64,
}

/// By what the odometry has to be corrected.
#[derive(Serialize)]
struct OdometryJson {
    translation_scale: f64,
    translation_scale_std: f64,
    aside: f64,
    aside_std: f64,
    rotation_scale: f64,
    rotation_scale_std: f64,
}

/// What is said of a quantity that the robot file bounds.
#[derive(Serialize)]
struct NuisanceJson<'a> {
    quantity: &'static str,
    whisker: Option<&'a str>,
    unit: &'static str,
    estimate: f64,
    std: f64,
    bound: f64,
}

/// How well the readings fit what was declared.
#[derive(Serialize)]
struct ConsistencyJson<'a> {
    statistic: f64,
    most: f64,
    correlation_time: f64,
    worst: Option<WorstJson>,
    remedies: Vec<RemedyJson<'a>>,
}

#[derive(Serialize)]
struct WorstJson {
    from: f64,
    to: f64,
    statistic: f64,
}

#[derive(Serialize)]
struct RemedyJson<'a> {
    change: &'a str,
    statistic: f64,
    status: &'static str,
}

#[derive(Serialize)]
struct StretchJson {
    from: f64,
    to: f64,
}

#[derive(Serialize)]
struct EventJson<'a> {
    t: f64,
    kind: &'a str,
    detail: &'a str,
}

#[derive(Serialize)]
struct RuntimeJson {
    updates: usize,
    total_s: f64,
    p50_us: f64,
    p99_us: f64,
}

#[derive(Serialize)]
struct TruthJson {
    rows: usize,
    final_position_m: f64,
    final_heading_rad: f64,
    mean_position_m: f64,
    mean_heading_rad: f64,
}

/// The answer as pretty JSON with a line end; `truth` is there only when an error is given.
pub(crate) fn result(run: &Run, error: Option<&TrajectoryError>) -> Result<String> {
    let (answer, runtime) = (&run.answer, &run.runtime);
    let value = ResultJson {
        status: answer.status.as_str(),
        method: answer.method,
        interrupted: run.interrupted,
        // Where nothing explains the log no pose may look like an answer.
        estimate: answer.estimate.filter(|_| answer.status != Status::Inconsistent).map(pose),
        hypotheses: if answer.status == Status::Inconsistent { Vec::new() } else { hypotheses(answer) },
        odometry: answer.odometry.map(odometry),
        nuisances: answer.nuisances.iter().map(nuisance).collect(),
        consistency: answer.consistency.as_ref().map(consistency),
        unsure: answer.unsure.iter().map(|&Stretch { from, to }| StretchJson { from, to }).collect(),
        events: answer.events.iter().map(|e| EventJson { t: e.t, kind: e.kind, detail: &e.detail }).collect(),
        runtime: RuntimeJson {
            updates: runtime.updates,
            total_s: runtime.total_s,
            p50_us: runtime.p50_us,
            p99_us: runtime.p99_us,
        },
        truth: error.map(|error| TruthJson {
            rows: error.rows,
            final_position_m: error.final_position,
            final_heading_rad: error.final_heading,
            mean_position_m: error.mean_position,
            mean_heading_rad: error.mean_heading,
        }),
    };
    let mut text = serde_json::to_string_pretty(&value)
        .map_err(|error| Error::data(format!("cannot write the result as JSON ({error})")))?;
    text.push('\n');
    Ok(text)
}

fn nuisance(one: &Nuisance) -> NuisanceJson<'_> {
    NuisanceJson {
        quantity: one.quantity.as_str(),
        whisker: one.whisker.as_deref(),
        unit: one.quantity.unit(),
        estimate: one.estimate,
        std: one.std,
        bound: one.bound,
    }
}

fn remedy(one: &Remedy) -> RemedyJson<'_> {
    RemedyJson { change: &one.change, statistic: one.statistic, status: one.status.as_str() }
}

fn consistency(report: &ConsistencyReport) -> ConsistencyJson<'_> {
    ConsistencyJson {
        statistic: report.statistic,
        most: report.most,
        correlation_time: report.correlation_time,
        worst: report.worst.map(|(Stretch { from, to }, statistic)| WorstJson { from, to, statistic }),
        remedies: report.remedies.iter().map(remedy).collect(),
    }
}

fn odometry(odometry: OdometryEstimate) -> OdometryJson {
    OdometryJson {
        translation_scale: odometry.translation_scale,
        translation_scale_std: odometry.translation_scale_std,
        aside: odometry.aside,
        aside_std: odometry.aside_std,
        rotation_scale: odometry.rotation_scale,
        rotation_scale_std: odometry.rotation_scale_std,
    }
}

fn pose(pose: Pose2) -> PoseJson {
    PoseJson { x: pose.x, y: pose.y, theta: pose.theta }
}

fn hypotheses(answer: &Localization) -> Vec<HypothesisJson> {
    let one = |h: &vibrissa::flow::pose::Hypothesis| HypothesisJson {
        x: h.pose.x,
        y: h.pose.y,
        theta: h.pose.theta,
        weight: h.weight,
        x_min: h.extent.x.lo(),
        x_max: h.extent.x.hi(),
        y_min: h.extent.y.lo(),
        y_max: h.extent.y.hi(),
        theta_min: h.extent.theta.lo(),
        theta_max: h.extent.theta.hi(),
        covariance: h.covariance,
        bound: h.bound().map(|(position_m, heading_rad)| BoundJson { position_m, heading_rad }),
        ridge: h.ridge.iter().map(|pose| [pose.x, pose.y, pose.theta]).collect(),
    };
    answer.hypotheses.iter().map(one).collect()
}
