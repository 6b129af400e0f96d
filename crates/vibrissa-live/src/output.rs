//! What is known, as a line of JSON and as a line of words.

use crate::config::PLACES_TOLD;
use std::fmt::Write;
use vibrissa_core::flow::pose::{Estimate, Hypothesis, Status};

/// The estimate at a row as one line of JSON, without its end: the same estimate gives the same bytes.
///
/// `{"t","rows","status","pose":{"x","y","theta"}|null,"places":[{"x","y","theta","weight","x_min",…,"theta_max","covariance"?}],"count","carried"?}`
/// with SI units, map frame; at most eight places are told, `count` says how many there are. Where nothing explains the
/// readings there are neither pose nor places. `carried` stands where odometry led here from an estimate that is so much older (s).
#[must_use]
pub fn json_line(t: f64, carried: f64, estimate: &Estimate) -> String {
    let told: &[Hypothesis] = if estimate.status == Status::Inconsistent { &[] } else { &estimate.hypotheses };
    let mut line = String::new();
    // Writing into a string cannot fail.
    let _ = write!(
        line,
        "{{\"t\":{},\"rows\":{},\"status\":\"{}\",\"pose\":",
        number(t),
        estimate.rows,
        estimate.status.as_str()
    );
    match told.first() {
        Some(best) => {
            let pose = best.pose;
            let _ =
                write!(line, "{{\"x\":{},\"y\":{},\"theta\":{}}}", number(pose.x), number(pose.y), number(pose.theta));
        }
        None => line.push_str("null"),
    }
    line.push_str(",\"places\":[");
    for (index, place) in told.iter().take(PLACES_TOLD).enumerate() {
        if index > 0 {
            line.push(',');
        }
        push_place(&mut line, place);
    }
    let _ = write!(line, "],\"count\":{}", told.len());
    if carried > 0.0 {
        let _ = write!(line, ",\"carried\":{}", number(carried));
    }
    line.push('}');
    line
}

fn push_place(line: &mut String, place: &Hypothesis) {
    let (pose, extent) = (place.pose, place.extent);
    let values = [
        ("x", pose.x),
        ("y", pose.y),
        ("theta", pose.theta),
        ("weight", place.weight),
        ("x_min", extent.x.lo()),
        ("x_max", extent.x.hi()),
        ("y_min", extent.y.lo()),
        ("y_max", extent.y.hi()),
        ("theta_min", extent.theta.lo()),
        ("theta_max", extent.theta.hi()),
    ];
    line.push('{');
    for (index, (name, value)) in values.into_iter().enumerate() {
        let comma = if index > 0 { "," } else { "" };
        let _ = write!(line, "{comma}\"{name}\":{}", number(value));
    }
    if let Some(covariance) = place.covariance {
        let rows: Vec<String> = covariance
            .iter()
            .map(|row| format!("[{}]", row.iter().map(|v| number(*v)).collect::<Vec<_>>().join(",")))
            .collect();
        let _ = write!(line, ",\"covariance\":[{}]", rows.join(","));
    }
    line.push('}');
}

/// A number of JSON; what is not finite is null.
fn number(value: f64) -> String {
    if value.is_finite() { format!("{value}") } else { "null".to_owned() }
}

/// A text as JSON, in quotes.
#[must_use]
pub fn json_text(text: &str) -> String {
    let mut quoted = String::from("\"");
    for character in text.chars() {
        match character {
            '"' => quoted.push_str("\\\""),
            '\\' => quoted.push_str("\\\\"),
            '\n' => quoted.push_str("\\n"),
            c if c.is_control() => {
                let _ = write!(quoted, "\\u{:04x}", u32::from(c));
            }
            c => quoted.push(c),
        }
    }
    quoted.push('"');
    quoted
}

/// The estimate in words, for one line of a terminal: verdict, pose, extent.
#[must_use]
pub fn words(estimate: &Estimate) -> String {
    let places = match estimate.hypotheses.len() {
        0 | 1 => String::new(),
        count => format!(", {count} places"),
    };
    let status = estimate.status.as_str().replace('_', " ");
    match estimate.hypotheses.first().filter(|_| estimate.status != Status::Inconsistent) {
        None => status,
        Some(best) => {
            let (pose, extent) = (best.pose, best.extent);
            let half = |width: f64| 0.5 * 1e3 * width;
            format!(
                "{status}{places}: x {:.1} y {:.1} mm, heading {:.1} deg, within {:.1} x {:.1} mm, {:.1} deg",
                1e3 * pose.x,
                1e3 * pose.y,
                pose.theta.to_degrees(),
                half(extent.x.width()),
                half(extent.y.width()),
                0.5 * extent.theta.width().to_degrees()
            )
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{json_line, json_text, words};
    use vibrissa_core::flow::pose::{Estimate, Hypothesis, Status};
    use vibrissa_core::plane::Pose2;
    use vibrissa_core::sets::{Interval, StateBox};

    #[test]
    fn an_estimate_is_one_line_and_what_is_not_finite_is_null() {
        let extent = StateBox {
            x: Interval::new(0.1, 0.3),
            y: Interval::new(f64::NEG_INFINITY, 1.0),
            theta: Interval::new(-0.1, 0.1),
        };
        let place = Hypothesis {
            pose: Pose2::new(0.2, -0.5, 0.0),
            weight: 1.0,
            extent,
            covariance: Some([[1e-6, 0.0, 0.0], [0.0, 2e-6, 0.0], [0.0, 0.0, 3.0]]),
            ridge: Vec::new(),
        };
        let mut estimate = Estimate { status: Status::Localized, hypotheses: vec![place], rows: 7 };
        assert_eq!(
            json_line(1.5, 0.0, &estimate),
            "{\"t\":1.5,\"rows\":7,\"status\":\"localized\",\"pose\":{\"x\":0.2,\"y\":-0.5,\"theta\":0},\"places\":[\
             {\"x\":0.2,\"y\":-0.5,\"theta\":0,\"weight\":1,\"x_min\":0.1,\"x_max\":0.3,\"y_min\":null,\"y_max\":1,\
             \"theta_min\":-0.1,\"theta_max\":0.1,\"covariance\":[[0.000001,0,0],[0,0.000002,0],[0,0,3]]}],\"count\":1}"
        );
        assert!(words(&estimate).starts_with("localized: x 200.0 y -500.0 mm"), "{}", words(&estimate));
        estimate.status = Status::Inconsistent;
        assert!(json_line(2.0, 0.25, &estimate).ends_with("\"pose\":null,\"places\":[],\"count\":0,\"carried\":0.25}"));
        assert_eq!(
            (words(&estimate), json_text("a\"\\\n\u{1}")),
            ("inconsistent".into(), "\"a\\\"\\\\\\n\\u0001\"".into())
        );
    }
}
