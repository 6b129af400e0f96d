//! What `rostopic echo` prints.

use super::lines::lines;
use super::yaml::Message;
use super::{Format, Recording, Series};
use crate::math;
use crate::plane::{Pose2, wrap_angle};

/// The numbers of one kind of message: columns with units, and their paths.
struct Kind {
    columns: &'static [(&'static str, &'static str)],
    paths: &'static [&'static str],
}

/// Readings; odometry is dealt with apart.
const KINDS: [Kind; 3] = [
    // A wrench about the whisker's base: the moment counter-clockwise about z.
    Kind { columns: &[("moment", "N m")], paths: &["wrench.torque.z"] },
    Kind {
        columns: &[("bx", "T"), ("by", "T"), ("bz", "T")],
        paths: &["magnetic_field.x", "magnetic_field.y", "magnetic_field.z"],
    },
    Kind { columns: &[("twist_x", "m"), ("twist_y", "m")], paths: &["twist.linear.x", "twist.linear.y"] },
];

/// Stamped values with the line that they began in.
type Stamped<T> = Vec<(f64, T, usize)>;

/// Messages of any mixture of topics, each ended by `---`.
///
/// The readings of the topic with most messages give the rows; odometry and other readings are interpolated at their
/// times. Odometry alone gives rows of its own.
pub(super) fn read(bytes: &[u8]) -> Recording {
    let mut recording = Recording::new(Format::Rostopic, &[]);
    let messages = messages(bytes, &mut recording);
    let mut odometry: Stamped<Pose2> = Vec::new();
    let mut readings: Vec<Stamped<Vec<f64>>> = KINDS.iter().map(|_| Vec::new()).collect();
    for message in &messages {
        let (Some(t), line) = (message.stamp(), message.line) else {
            recording.repairs.lines_dropped += 1;
            continue;
        };
        if let Some(pose) = pose(message) {
            odometry.push((t, pose, line));
            continue;
        }
        let found = KINDS.iter().position(|kind| kind.paths.iter().all(|path| message.get(path).is_some()));
        match found {
            Some(k) => {
                let values = KINDS[k].paths.iter().filter_map(|path| message.get(path)).collect();
                readings[k].push((t, values, line));
            }
            None => recording.repairs.lines_dropped += 1,
        }
    }
    let mut dropped = in_order(&mut odometry);
    readings.iter_mut().for_each(|list| dropped += in_order(list));
    recording.repairs.out_of_order += dropped;
    merge(&mut recording, &odometry, &readings);
    recording
}

fn messages(bytes: &[u8], recording: &mut Recording) -> Vec<Message> {
    let mut done = Vec::new();
    let mut message = Message::default();
    let mut whole = true;
    for (line, raw) in lines(bytes).zip(bytes.split_inclusive(|&b| b == b'\n')) {
        if line.text == "---" {
            let finished = core::mem::take(&mut message).finished();
            if whole && !finished.is_empty() {
                done.push(finished);
            }
            whole = true;
        } else if !line.text.is_empty() {
            let raw = core::str::from_utf8(raw).unwrap_or(line.text);
            if !message.take(raw, &line) {
                recording.repairs.drop_line(&line);
                whole = false;
            }
        }
    }
    if !message.is_empty() {
        // Without its `---` the last message may lack its end.
        recording.repairs.lines_dropped += 1;
        recording.repairs.last_line_cut += 1;
    }
    done
}

/// The pose of an odometry message, heading from the quaternion.
fn pose(message: &Message) -> Option<Pose2> {
    let get = |path: &str| message.get(&format!("pose.pose.{path}"));
    let [x, y, z, w] = [get("orientation.x")?, get("orientation.y")?, get("orientation.z")?, get("orientation.w")?];
    let heading = math::atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z));
    Some(Pose2::new(get("position.x")?, get("position.y")?, heading))
}

/// Keeps what increases in time; how many are dropped.
fn in_order<T>(list: &mut Stamped<T>) -> usize {
    let before = list.len();
    let mut last = f64::NEG_INFINITY;
    list.retain(|(t, ..)| {
        let later = *t > last;
        if later {
            last = *t;
        }
        later
    });
    before - list.len()
}

fn merge(recording: &mut Recording, odometry: &Stamped<Pose2>, readings: &[Stamped<Vec<f64>>]) {
    let main =
        (0..readings.len()).max_by_key(|&k| (readings[k].len(), KINDS.len() - k)).filter(|&k| !readings[k].is_empty());
    let times: Vec<(f64, usize)> = match main {
        Some(k) => readings[k].iter().map(|(t, _, line)| (*t, *line)).collect(),
        None => odometry.iter().map(|(t, _, line)| (*t, *line)).collect(),
    };
    let Some(&(origin, _)) = times.first() else { return };
    let add = |recording: &mut Recording, columns: &[(&str, &'static str)]| {
        let new = columns.iter().map(|&(name, unit)| Series { name: name.to_owned(), unit, values: Vec::new() });
        recording.series.extend(new);
    };
    if !odometry.is_empty() {
        add(recording, &[("x", "m"), ("y", "m"), ("theta", "rad")]);
    }
    let used: Vec<usize> = (0..readings.len()).filter(|&k| !readings[k].is_empty()).collect();
    used.iter().for_each(|&k| add(recording, KINDS[k].columns));
    for (t, line) in times {
        let mut values = Vec::new();
        if !odometry.is_empty() {
            let Some((before, after, share)) = around(odometry, t) else {
                recording.repairs.lines_dropped += 1;
                continue;
            };
            let turn = wrap_angle(after.theta - before.theta);
            values.extend([
                before.x + share * (after.x - before.x),
                before.y + share * (after.y - before.y),
                before.theta + share * turn,
            ]);
            recording.repairs.interpolated += usize::from(share > 0.0 && share < 1.0);
        }
        let mut complete = true;
        for &k in &used {
            match around(&readings[k], t) {
                Some((before, after, share)) => {
                    values.extend(before.iter().zip(after).map(|(a, b)| a + share * (b - a)))
                }
                None => complete = false,
            }
        }
        if complete {
            recording.t.push(t - origin);
            recording.push(line, values);
        } else {
            recording.repairs.lines_dropped += 1;
        }
    }
}

/// The neighbours of a time and how far it lies between them; none outside the list.
fn around<T>(list: &Stamped<T>, t: f64) -> Option<(&T, &T, f64)> {
    let after = list.partition_point(|(at, ..)| *at < t);
    let next = list.get(after)?;
    if next.0 <= t {
        return Some((&next.1, &next.1, 0.0));
    }
    let before = list.get(after.checked_sub(1)?)?;
    Some((&before.1, &next.1, (t - before.0) / (next.0 - before.0)))
}
