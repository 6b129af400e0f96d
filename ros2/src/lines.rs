//! Messages as lines of CSV, as `vibrissa live` reads them: `vibrissa-ros2 --lines odometry /odom`.
//!
//! | kind | message | line |
//! | --- | --- | --- |
//! | `odometry` | `nav_msgs/Odometry` | `t,x,y,theta` |
//! | `joints` | `sensor_msgs/JointState` | a header, then `t` and what it names |
//! | `array` | `std_msgs/Float64MultiArray` | its numbers |
//! | `wrench` | `geometry_msgs/WrenchStamped` | `t`, the torque about z |
//!
//! A message that does not hold what it should is a line [`NOTHING`], so that whoever reads counts it as damaged.

use crate::messages::{Float64MultiArray, JointState, Odometry, Time, WrenchStamped};
use std::fmt::Write as _;
use vibrissa_core::{Error, Result};
use vibrissa_io::text::did_you_mean;
use vibrissa_live::source::Ros2Message;

/// The line of a message that holds nothing.
pub const NOTHING: &str = "?";

/// What the arguments behind `--lines` ask for: a kind of messages and a topic.
///
/// # Errors
///
/// An unknown kind, no topic, arguments too many.
pub fn asked(args: &[String]) -> Result<(Ros2Message, String)> {
    let known = Ros2Message::ALL.map(Ros2Message::as_str);
    let [kind, topic] = args else {
        return Err(Error::usage("--lines takes the kind of messages and a topic")
            .value(args.join(" "))
            .allowed(known.join(", "))
            .remedy("such as vibrissa-ros2 --lines odometry /odom"));
    };
    let message = Ros2Message::ALL.into_iter().find(|message| message.as_str() == kind);
    let message = message.ok_or_else(|| {
        Error::usage("unknown kind of messages")
            .value(kind)
            .allowed(known.join(", "))
            .remedy(did_you_mean(kind, &known))
    })?;
    Ok((message, topic.clone()))
}

/// The line of odometry; `now` (s) stands for a stamp that was not filled in.
#[must_use]
pub fn odometry(message: &Odometry, now: f64) -> String {
    let pose = message.pose.pose.plane();
    pose.map_or(NOTHING.to_owned(), |pose| numbers(at(&message.header.stamp, now), &[pose.x, pose.y, pose.theta]))
}

/// The line of a wrench.
#[must_use]
pub fn wrench(message: &WrenchStamped, now: f64) -> String {
    numbers(at(&message.header.stamp, now), &[message.wrench.torque.z])
}

/// The line of an array, without a time.
#[must_use]
pub fn array(message: &Float64MultiArray) -> String {
    numbers(None, &message.data)
}

/// The columns of a `JointState`, as its first message has them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Joints {
    /// Names as messages have them, and whether the effort is meant.
    names: Vec<(String, bool)>,
}

impl Joints {
    /// Positions under their names, or efforts of names without a dot where there are efforts: moments of whiskers. None where a message
    /// names nothing that a column can be called.
    #[must_use]
    pub fn of(message: &JointState) -> Option<Self> {
        let is_plain = |name: &str| {
            !name.is_empty() && name != "t" && name.chars().all(|c| c.is_ascii_alphanumeric() || "._-".contains(c))
        };
        let named = message.name.iter().enumerate().filter(|(_, name)| is_plain(name));
        let names: Vec<(String, bool)> = named
            .filter_map(|(index, name)| {
                let effort = index < message.effort.len() && !name.contains('.');
                (effort || index < message.position.len()).then(|| (name.clone(), effort))
            })
            .collect();
        (!names.is_empty()).then_some(Self { names })
    }

    /// The header line.
    #[must_use]
    pub fn header(&self) -> String {
        self.names.iter().fold("t".to_owned(), |mut line, (name, effort)| {
            // Writing into a string cannot fail.
            let _ = write!(line, ",{name}{}", if *effort { ".moment" } else { "" });
            line
        })
    }

    /// The line of a message.
    #[must_use]
    pub fn line(&self, message: &JointState, now: f64) -> String {
        let value = |(name, effort): &(String, bool)| {
            let index = message.name.iter().position(|one| one == name)?;
            if *effort { message.effort.get(index) } else { message.position.get(index) }.copied()
        };
        let values: Option<Vec<f64>> = self.names.iter().map(value).collect();
        values.map_or(NOTHING.to_owned(), |values| numbers(at(&message.header.stamp, now), &values))
    }
}

fn at(stamp: &Time, now: f64) -> Option<f64> {
    Some(stamp.seconds().unwrap_or(now))
}

/// Numbers in the shortest form that reads back the same, with commas between them.
fn numbers(t: Option<f64>, values: &[f64]) -> String {
    let words: Vec<String> = t.iter().chain(values).map(f64::to_string).collect();
    words.join(",")
}

#[cfg(test)]
mod tests {
    use super::{Joints, NOTHING, array, asked, odometry, wrench};
    use crate::messages::{Float64MultiArray, Header, JointState, Odometry, Time, Vector, WrenchStamped};
    use vibrissa_live::source::Ros2Message;

    fn header(sec: i32, nanosec: u32) -> Header {
        Header { stamp: Time { sec, nanosec }, frame_id: String::new() }
    }

    #[test]
    fn each_message_is_the_line_that_a_live_run_reads() {
        let mut message = Odometry { header: header(12, 500_000_000), ..Odometry::default() };
        assert_eq!(odometry(&message, 9.0), NOTHING, "a quaternion of no length");
        message.pose.pose.position = Vector { x: 0.25, y: -1.0, z: 3.0 };
        (message.pose.pose.orientation.z, message.pose.pose.orientation.w) = (1.0, 0.0);
        assert_eq!(odometry(&message, 9.0), format!("12.5,0.25,-1,{}", core::f64::consts::PI));
        let mut turned = WrenchStamped::default();
        turned.wrench.torque.z = 2e-3;
        assert_eq!(wrench(&turned, 9.0), "9,0.002", "a stamp that was not filled in");
        assert_eq!(array(&Float64MultiArray { data: vec![0.5, -2.0], ..Float64MultiArray::default() }), "0.5,-2");
    }

    #[test]
    fn joints_are_read_by_name_whatever_their_order() {
        let names = |names: &[&str]| names.iter().map(|&name| name.to_owned()).collect::<Vec<_>>();
        let first = JointState {
            header: header(1, 0),
            name: names(&["left", "right.bx", "a,b", "wheel"]),
            position: vec![0.1, 3e-6, 0.3],
            effort: vec![2e-3],
            ..JointState::default()
        };
        let joints = Joints::of(&first).unwrap();
        assert_eq!(joints.header(), "t,left.moment,right.bx");
        assert_eq!(joints.line(&first, 0.0), "1,0.002,0.000003");
        let turned = JointState {
            header: header(2, 0),
            name: names(&["right.bx", "left"]),
            position: vec![4e-6],
            effort: vec![0.0, 5e-3],
            ..JointState::default()
        };
        assert_eq!(joints.line(&turned, 0.0), "2,0.005,0.000004");
        let other = JointState { name: names(&["left"]), effort: vec![1.0], ..JointState::default() };
        assert_eq!(joints.line(&other, 0.0), NOTHING);
        assert_eq!(Joints::of(&JointState::default()), None);
    }

    #[test]
    fn what_is_asked_for_is_a_kind_and_a_topic() {
        let args = |words: &str| words.split_whitespace().map(str::to_owned).collect::<Vec<_>>();
        assert_eq!(asked(&args("wrench /w")).unwrap(), (Ros2Message::Wrench, "/w".to_owned()));
        for wrong in ["", "wrench", "wrench /w x"] {
            assert!(asked(&args(wrong)).unwrap_err().to_string().contains("a topic"), "{wrong}");
        }
        assert!(asked(&args("odometrie /odom")).unwrap_err().to_string().contains("did you mean `odometry`?"));
    }
}
