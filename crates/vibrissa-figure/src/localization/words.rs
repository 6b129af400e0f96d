//! The figure's sentences.

use super::counted;
use crate::flow::pose::{Localization, Status};
use crate::numbers::fixed;
use crate::plane::Pose2;

/// The verdict in one sentence, with the estimate in millimetres and degrees.
#[must_use]
pub fn verdict(answer: &Localization) -> String {
    if answer.status == Status::Ambiguous && answer.hypotheses.is_empty() {
        return "ambiguous: the whisker touched, but too briefly or too roughly to tell where the robot is".into();
    }
    let place = answer.estimate.map(place).unwrap_or_else(|| "nowhere".into());
    match answer.status {
        Status::Localized => format!("localized: {place}; {}{}", shrinkage(answer), lost(answer)),
        Status::Ambiguous => {
            let weight = answer.hypotheses.first().map_or(0.0, |first| first.weight);
            let found = match answer.hypotheses.len() {
                1 => format!("one place explains the log, too wide or too doubtful to settle on: {place}"),
                // The share of a set's volume is no probability.
                places if answer.encloses => {
                    format!("{places} separate places explain the log; number 1, the largest, is {place}")
                }
                places => {
                    format!("{places} separate places explain the log; number 1 ({:.0} %) is {place}", 100.0 * weight)
                }
            };
            format!("ambiguous: {found}; {}{}", shrinkage(answer), lost(answer))
        }
        Status::Inconsistent => {
            let step = answer.events.iter().find(|event| event.kind == "inconsistent");
            let step =
                step.map(|event| format!("; the last was ruled out at t = {:.3} s", event.t)).unwrap_or_default();
            format!("inconsistent: no state on this map explains the log{step}")
        }
        Status::NoContact => {
            "no contact: the whisker never touched anything, so the log does not tell where the robot is".into()
        }
    }
}

/// Until when the robot was lost, where it was and is no more: what the answer says holds from then on.
fn lost(answer: &Localization) -> String {
    let last = answer.events.iter().rev().find(|event| matches!(event.kind, "inconsistent" | "recovered"));
    let found = last.filter(|event| event.kind == "recovered");
    found.map(|event| format!("; lost until t = {:.3} s", event.t)).unwrap_or_default()
}

/// A pose in millimetres and degrees.
fn place(pose: Pose2) -> String {
    let (x, y) = (fixed(pose.x * 1e3, 1), fixed(pose.y * 1e3, 1));
    format!("{x} mm, {y} mm, {}°", fixed(pose.theta.to_degrees(), 1))
}

fn shrinkage(answer: &Localization) -> String {
    let (left, all) = (answer.states.len(), answer.first_states.len());
    // The second observation may let in more candidates than the first.
    let candidates = if all >= left && all > 0 {
        format!("{left} of {}", counted(all, part(answer)))
    } else {
        counted(left, part(answer))
    };
    let swept: f64 = answer
        .trajectory
        .windows(2)
        .map(|pair| pair[0].map_from_robot.position().distance(pair[1].map_from_robot.position()))
        .sum();
    format!("{candidates} left after {} mm of sweep", fixed(swept * 1e3, 0))
}

/// What an answer's state set consists of.
pub(super) fn part(answer: &Localization) -> &'static str {
    if answer.encloses { "cell" } else { "candidate" }
}

/// The text broken at spaces into lines of at most `limit` characters; a longer word keeps a line of its own.
#[must_use]
pub fn wrapped(text: &str, limit: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= limit => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.into()),
        }
    }
    lines
}
