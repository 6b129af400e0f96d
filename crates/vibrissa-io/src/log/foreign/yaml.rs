//! The little of YAML that `rostopic echo` prints: nested keys, numbers, documents that end in `---`.

use super::lines::{Line, number};

/// Deepest nesting that a message has.
const DEEPEST: usize = 12;

/// The numbers that are read of any message.
const WANTED: [&str; 16] = [
    "header.stamp.secs",
    "header.stamp.sec",
    "header.stamp.nsecs",
    "header.stamp.nanosec",
    "pose.pose.position.x",
    "pose.pose.position.y",
    "pose.pose.orientation.x",
    "pose.pose.orientation.y",
    "pose.pose.orientation.z",
    "pose.pose.orientation.w",
    "wrench.torque.z",
    "magnetic_field.x",
    "magnetic_field.y",
    "magnetic_field.z",
    "twist.linear.x",
    "twist.linear.y",
];

/// One message: its numbers by path, such as `pose.pose.position.x`.
#[derive(Clone, Debug, Default)]
pub(super) struct Message {
    pub(super) line: usize,
    values: Vec<(&'static str, f64)>,
    stack: Vec<(usize, String)>,
}

impl Message {
    /// The number at a path.
    pub(super) fn get(&self, path: &str) -> Option<f64> {
        self.values.iter().find(|(known, _)| *known == path).map(|(_, value)| *value)
    }

    /// The message at its end, without what was needed to read it.
    pub(super) fn finished(mut self) -> Self {
        self.stack = Vec::new();
        self
    }

    pub(super) fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// The time of the header's stamp (s), as ROS 1 or ROS 2 writes it.
    pub(super) fn stamp(&self) -> Option<f64> {
        let part = |one: &str, two: &str| {
            self.get(&format!("header.stamp.{one}")).or_else(|| self.get(&format!("header.stamp.{two}")))
        };
        Some(part("secs", "sec")? + 1e-9 * part("nsecs", "nanosec")?)
    }

    /// Takes one line with its blanks in front; `false` when it cannot be read.
    pub(super) fn take(&mut self, raw: &str, line: &Line<'_>) -> bool {
        if self.values.is_empty() && self.stack.is_empty() {
            self.line = line.number;
        }
        let indent = raw.len() - raw.trim_start().len();
        if line.text.starts_with(['-', '[', ']', '#']) || line.text.ends_with([',', ']']) && !line.text.contains(':') {
            // Lists, such as covariances, hold nothing of interest.
            return true;
        }
        let Some((key, value)) = line.text.split_once(':') else { return false };
        while self.stack.last().is_some_and(|(depth, _)| *depth >= indent) {
            self.stack.pop();
        }
        let value = value.trim();
        if value.is_empty() {
            if self.stack.len() >= DEEPEST {
                return false;
            }
            self.stack.push((indent, key.trim().to_owned()));
            return true;
        }
        if let Some(value) = number(value) {
            let mut path: String = self.stack.iter().fold(String::new(), |path, (_, key)| path + key + ".");
            path.push_str(key.trim());
            // Of hundreds of numbers a few are read; the first of a name counts.
            if let Some(wanted) = WANTED.iter().find(|wanted| **wanted == path)
                && self.get(wanted).is_none()
            {
                self.values.push((wanted, value));
            }
        }
        true
    }
}
