//! Odometry by itself, as stages, bases and motion capture leave it.

use super::columns::{ODOMETRY, without_units};
use super::csv_lines::{Lines, fields};
use super::csv_reader::{in_reach, number};
use super::text_form::{TextForm, recognised};
use crate::config::limits::MOST_LOG_ROWS;
use crate::flow::pose::StampedPose;
use crate::plane::Pose2;
use crate::text::{beyond, listed, open};
use crate::trajectory::read_tum;
use crate::{Error, Result};
use std::io::Read;
use std::path::Path;

/// The robot over time from a file: `.tum` (or `.txt`) lines, the `nav_msgs/Odometry` of a recording `.mcap`, else CSV with the columns
/// `t,x,y,theta` (s, m, rad) among others.
///
/// # Errors
///
/// A file that cannot be read or holds no odometry; a row that is damaged, no finite number, beyond 1e8 m, or not after the one before: the
/// message names file and line.
pub fn read_odometry(path: impl AsRef<Path>) -> Result<Vec<StampedPose>> {
    let path = path.as_ref();
    match path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase().as_str() {
        "tum" | "txt" => read_tum(path),
        #[cfg(feature = "mcap")]
        "mcap" => of_recording(path),
        _ => of_csv(path),
    }
}

fn of_csv(path: &Path) -> Result<Vec<StampedPose>> {
    let faulty =
        |error: Error| error.in_file(path).or_remedy("correct or remove the line, or record the odometry again");
    let (form, plain) = recognised(open(path, "odometry")?).map_err(faulty)?;
    rows(plain, &form).map_err(faulty)
}

/// The poses in lines of CSV. A last line without a line end is left out: the rest of its last number may be missing.
fn rows(reader: impl Read, form: &TextForm) -> Result<Vec<StampedPose>> {
    let mut lines = Lines::new(reader);
    let mut header: Option<Header> = None;
    let mut poses: Vec<StampedPose> = Vec::new();
    while let Some(line) = lines.next()? {
        if line.is_blank() || line.is_comment() {
            continue;
        }
        let number = line.number;
        let record = fields(&line, form.delimiter).map_err(|error| error.at_line(number));
        let Some(header) = &header else {
            let names = record?.iter().map(|field| String::from_utf8_lossy(field).into_owned()).collect();
            header = Some(Header::new(names).map_err(|error| error.at_line(number))?);
            continue;
        };
        if !line.ended {
            break;
        }
        if poses.len() >= MOST_LOG_ROWS {
            let remedy = "cut it into parts, or keep every tenth row";
            return Err(beyond("the odometry has too many rows", poses.len() + 1, MOST_LOG_ROWS, remedy));
        }
        let pose = record.and_then(|record| header.pose(&record, form.decimal_comma));
        poses.push(pose.and_then(|pose| after(poses.last(), pose)).map_err(|error| error.at_line(number))?);
    }
    if poses.is_empty() {
        return Err(Error::data("the odometry has no rows")
            .allowed("a header line with t,x,y,theta, then one row for each pose"));
    }
    Ok(poses)
}

/// Where the columns stand.
struct Header {
    names: usize,
    odometry: [usize; 4],
}

impl Header {
    fn new(names: Vec<String>) -> Result<Self> {
        let names = without_units(names)?;
        let place = |word: &str| {
            names.iter().position(|name| name.trim() == word).ok_or_else(|| {
                let held: Vec<&str> = names.iter().map(String::as_str).collect();
                Error::data(format!("the odometry has no column `{word}`"))
                    .value(format!("it holds {}", listed(&held)))
                    .remedy("its first line has to name the columns: t,x,y,theta (s, m, rad)")
            })
        };
        let [t, x, y, theta] = ODOMETRY;
        Ok(Self { odometry: [place(t)?, place(x)?, place(y)?, place(theta)?], names: names.len() })
    }

    fn pose(&self, record: &[&[u8]], decimal_comma: bool) -> Result<StampedPose> {
        if record.len() != self.names {
            return Err(Error::data("a line with another number of fields")
                .value(record.len())
                .allowed(format!("{}, as the header names", self.names))
                .remedy("the line was damaged: repair or remove it"));
        }
        let [t, x, y, theta] = self.odometry.map(|place| record[place].trim_ascii());
        let [t_name, x_name, y_name, theta_name] = ODOMETRY;
        let metres = |field, name| number(field, decimal_comma, name).and_then(|value| in_reach(value, name));
        Ok(StampedPose {
            t: number(t, decimal_comma, t_name)?,
            map_from_robot: Pose2::new(
                metres(x, x_name)?,
                metres(y, y_name)?,
                number(theta, decimal_comma, theta_name)?,
            ),
        })
    }
}

/// A pose that comes after the one before.
fn after(before: Option<&StampedPose>, pose: StampedPose) -> Result<StampedPose> {
    match before {
        Some(before) if before.t >= pose.t => Err(Error::data("t does not increase")
            .value(format!("{} s after {} s", pose.t, before.t))
            .allowed(format!("above {} s", before.t))
            .remedy("sort the rows by time and remove repeated ones")),
        _ => Ok(pose),
    }
}

#[cfg(feature = "mcap")]
fn of_recording(path: &Path) -> Result<Vec<StampedPose>> {
    use super::bag::too_many_messages;
    use crate::config::budgets::MOST_MESSAGES;
    use crate::ros::{Kind, decode_odometry, read_bag};
    let file = open(path, "odometry")?;
    let mut topics: Vec<String> = Vec::new();
    let mut poses: Vec<StampedPose> = Vec::new();
    read_bag(file, &path.to_string_lossy(), |topic, _, bytes| {
        if topic.kind == Some(Kind::Odometry)
            && let Some((header, map_from_robot)) = decode_odometry(bytes)
        {
            if poses.len() >= MOST_MESSAGES {
                return Err(too_many_messages());
            }
            let Pose2 { x, y, theta } = map_from_robot;
            for (value, name) in [(x, "x"), (y, "y"), (theta, "theta")] {
                let message = format!("message {} of {}", poses.len() + 1, topic.name);
                if !value.is_finite() {
                    let error = Error::data(format!("{name} is not a finite number")).value(value);
                    return Err(error.remedy("leave the message out, or record the odometry again").about(&message));
                }
                in_reach(value, name).map_err(|error| error.about(&message))?;
            }
            if !topics.contains(&topic.name) {
                topics.push(topic.name.clone());
            }
            poses.push(StampedPose { t: header.stamp.seconds(), map_from_robot });
        }
        Ok(())
    })?;
    if topics.is_empty() {
        return Err(Error::data("the recording holds no odometry")
            .in_file(path)
            .allowed("a topic of nav_msgs/msg/Odometry")
            .remedy("record the robot's odometry too"));
    }
    if topics.len() > 1 {
        return Err(Error::data("the recording holds several topics of odometry")
            .in_file(path)
            .value(listed(&topics))
            .remedy("`mcap filter` keeps one of the topics"));
    }
    poses.sort_by(|a, b| a.t.total_cmp(&b.t));
    poses.dedup_by(|later, earlier| later.t <= earlier.t);
    Ok(poses)
}
