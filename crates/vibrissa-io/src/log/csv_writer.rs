//! A log as the text of its file, in SI units, each number in the shortest form that reads back the same.

use crate::flow::sensor_log::{Channel, SensorLog};
use std::fmt::Write;

/// The log as CSV: `t,x,y,theta`, one column for each channel, and `heading` where the first row has one (SI).
#[must_use]
pub fn to_csv(log: &SensorLog) -> String {
    let mut text = String::from("t,x,y,theta");
    for column in log.channels.iter().map(Channel::column) {
        text.push(',');
        text.push_str(&column);
    }
    let headed = log.rows.first().is_some_and(|row| row.heading.is_some());
    text.push_str(if headed { ",heading\n" } else { "\n" });
    for row in &log.rows {
        let pose = row.odom_from_robot;
        // Writing into a string cannot fail.
        let _ = write!(text, "{},{},{},{}", row.t, pose.x, pose.y, pose.theta);
        for reading in &row.readings {
            let _ = write!(text, ",{reading}");
        }
        if let (true, Some(heading)) = (headed, row.heading) {
            let _ = write!(text, ",{heading}");
        }
        text.push('\n');
    }
    text
}
