//! The messages: plain numbers in the plane on our side, the fields of ROS on the other.

use super::cdr::{CdrReader, CdrWriter};
use super::drawing::LineSet;
use crate::grid::{Cell, OccupancyGrid};
use crate::math;
use crate::plane::{Pose2, Vec2};

/// A time as ROS 2 has it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Stamp {
    /// Whole seconds.
    pub sec: i32,
    /// The rest (ns).
    pub nanosec: u32,
}

/// When and in which frame a message holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Header<'a> {
    /// When.
    pub stamp: Stamp,
    /// The frame's name.
    pub frame: &'a str,
}

impl Stamp {
    /// The stamp nearest to a time (s), within what a stamp can hold.
    #[must_use]
    pub fn from_seconds(t: f64) -> Self {
        let whole = t.floor();
        let nanosec = ((t - whole) * 1e9).round() as u32;
        let carry = nanosec >= 1_000_000_000;
        Self { sec: whole as i32 + i32::from(carry), nanosec: if carry { 0 } else { nanosec } }
    }

    /// The time (s): exact to 0.2 µs for the stamps of this century.
    #[must_use]
    pub fn seconds(self) -> f64 {
        f64::from(self.sec) + 1e-9 * f64::from(self.nanosec)
    }

    /// Nanoseconds since 1970, never before.
    #[must_use]
    pub fn nanoseconds(self) -> u64 {
        u64::try_from(i64::from(self.sec) * 1_000_000_000 + i64::from(self.nanosec)).unwrap_or(0)
    }
}

fn read_header<'a>(reader: &mut CdrReader<'a>) -> Option<Header<'a>> {
    Some(Header { stamp: Stamp { sec: reader.i32()?, nanosec: reader.u32()? }, frame: reader.text()? })
}

fn begin(header: Header) -> CdrWriter {
    let mut writer = CdrWriter::new();
    write_header(&mut writer, header);
    writer
}

fn write_header(writer: &mut CdrWriter, header: Header) {
    writer.i32(header.stamp.sec).u32(header.stamp.nanosec).text(header.frame);
}

/// A pose of space as one of the plane: heading about z, whatever the tilt; none for a quaternion of no length.
fn read_pose(reader: &mut CdrReader) -> Option<Pose2> {
    let [x, y, _] = reader.f64s()?;
    Some(Pose2::new(x, y, heading_of(reader.f64s()?)?))
}

/// The heading about z (rad) of a quaternion x, y, z, w; none for one of no length.
fn heading_of([qx, qy, qz, qw]: [f64; 4]) -> Option<f64> {
    let length = qx * qx + qy * qy + qz * qz + qw * qw;
    let is_turn = length > 1e-6 && length.is_finite();
    is_turn.then(|| math::atan2(2.0 * (qw * qz + qx * qy), qw * qw + qx * qx - qy * qy - qz * qz))
}

fn write_pose(writer: &mut CdrWriter, pose: Pose2) {
    let (qz, qw) = math::sin_cos(0.5 * pose.theta);
    writer.f64s(&[pose.x, pose.y, 0.0, 0.0, 0.0, qz, qw]);
}

/// A covariance of (x, y, heading) in the place that six coordinates have.
fn write_covariance(writer: &mut CdrWriter, covariance: &[[f64; 3]; 3]) {
    let place = [0, 1, 5];
    let mut all = [0.0; 36];
    for (i, row) in covariance.iter().enumerate() {
        for (k, value) in row.iter().enumerate() {
            all[6 * place[i] + place[k]] = *value;
        }
    }
    writer.f64s(&all);
}

/// The header and the pose of a `nav_msgs/Odometry`.
#[must_use]
pub fn decode_odometry(bytes: &[u8]) -> Option<(Header<'_>, Pose2)> {
    let mut reader = CdrReader::new(bytes)?;
    let header = read_header(&mut reader)?;
    reader.text()?;
    Some((header, read_pose(&mut reader)?))
}

/// A `nav_msgs/Odometry` of a robot whose speed is not told.
#[must_use]
pub fn encode_odometry(header: Header, child_frame: &str, pose: Pose2) -> Vec<u8> {
    let mut writer = begin(header);
    write_pose(writer.text(child_frame), pose);
    write_covariance(&mut writer, &[[0.0; 3]; 3]);
    writer.f64s(&[0.0; 6]);
    // A speed that is not known: the first variance is -1.
    let mut unknown = [0.0; 36];
    unknown[0] = -1.0;
    writer.f64s(&unknown);
    writer.finish()
}

/// The header and the torque about z (N m) of a `geometry_msgs/WrenchStamped`.
#[must_use]
pub fn decode_wrench(bytes: &[u8]) -> Option<(Header<'_>, f64)> {
    let mut reader = CdrReader::new(bytes)?;
    let header = read_header(&mut reader)?;
    let [_, _, _, _, _, moment] = reader.f64s()?;
    Some((header, moment))
}

/// A `geometry_msgs/WrenchStamped` with this moment about z (N m), counter-clockwise positive; the force is not known.
#[must_use]
pub fn encode_wrench(header: Header, moment: f64) -> Vec<u8> {
    let mut writer = begin(header);
    writer.f64s(&[0.0, 0.0, 0.0, 0.0, 0.0, moment]);
    writer.finish()
}

/// The header and the flux density (T) of a `sensor_msgs/MagneticField`.
#[must_use]
pub fn decode_field(bytes: &[u8]) -> Option<(Header<'_>, [f64; 3])> {
    let mut reader = CdrReader::new(bytes)?;
    Some((read_header(&mut reader)?, reader.f64s()?))
}

/// A `sensor_msgs/MagneticField` (T).
#[must_use]
pub fn encode_field(header: Header, flux: [f64; 3]) -> Vec<u8> {
    let mut writer = begin(header);
    writer.f64s(&flux).f64s(&[0.0; 9]);
    writer.finish()
}

/// What a `sensor_msgs/Imu` says about the vertical.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImuReading {
    /// Heading about z (rad); none where the message says that it has no orientation.
    pub heading: Option<f64>,
    /// Angular velocity about z (rad/s), counter-clockwise positive; none where the message says that it has none.
    pub yaw_rate: Option<f64>,
}

/// The header and the numbers of a `sensor_msgs/Imu`: what has -1 as its first covariance is not measured.
#[must_use]
pub fn decode_imu(bytes: &[u8]) -> Option<(Header<'_>, ImuReading)> {
    let mut reader = CdrReader::new(bytes)?;
    let header = read_header(&mut reader)?;
    let quaternion = reader.f64s()?;
    let [turned, ..] = reader.f64s::<9>()?;
    let [_, _, rate] = reader.f64s()?;
    let [turning, ..] = reader.f64s::<9>()?;
    let measured = |first: f64| first.to_bits() != (-1.0_f64).to_bits();
    let heading = heading_of(quaternion).filter(|_| measured(turned));
    Some((header, ImuReading { heading, yaw_rate: measured(turning).then_some(rate) }))
}

/// A `sensor_msgs/Imu`; what is not measured gets -1 as its first covariance.
#[must_use]
pub fn encode_imu(header: Header, reading: ImuReading) -> Vec<u8> {
    let covariance = |known: bool| {
        let mut all = [0.0; 9];
        all[0] = if known { 0.0 } else { -1.0 };
        all
    };
    let mut writer = begin(header);
    let (qz, qw) = math::sin_cos(0.5 * reading.heading.unwrap_or(0.0));
    writer.f64s(&[0.0, 0.0, qz, qw]).f64s(&covariance(reading.heading.is_some()));
    writer.f64s(&[0.0, 0.0, reading.yaw_rate.unwrap_or(0.0)]).f64s(&covariance(reading.yaw_rate.is_some()));
    writer.f64s(&[0.0; 3]).f64s(&covariance(false));
    writer.finish()
}

/// The header and the pose of a `geometry_msgs/PoseStamped` or `PoseWithCovarianceStamped`, which begin alike.
#[must_use]
pub fn decode_pose(bytes: &[u8]) -> Option<(Header<'_>, Pose2)> {
    let mut reader = CdrReader::new(bytes)?;
    Some((read_header(&mut reader)?, read_pose(&mut reader)?))
}

/// A `geometry_msgs/PoseStamped`, or with the covariance of (x, y, heading) a `PoseWithCovarianceStamped`.
#[must_use]
pub fn encode_pose(header: Header, pose: Pose2, covariance: Option<&[[f64; 3]; 3]>) -> Vec<u8> {
    let mut writer = begin(header);
    write_pose(&mut writer, pose);
    if let Some(covariance) = covariance {
        write_covariance(&mut writer, covariance);
    }
    writer.finish()
}

/// A `nav_msgs/Path` through these poses.
#[must_use]
pub fn encode_path(header: Header, poses: &[(Stamp, Pose2)]) -> Vec<u8> {
    let mut writer = begin(header);
    writer.u32(poses.len() as u32);
    for &(stamp, pose) in poses {
        write_header(&mut writer, Header { stamp, frame: header.frame });
        write_pose(&mut writer, pose);
    }
    writer.finish()
}

/// The header and the grid of a `nav_msgs/OccupancyGrid`; none where it has not as many cells as it says.
#[must_use]
pub fn decode_grid(bytes: &[u8]) -> Option<(Header<'_>, OccupancyGrid)> {
    let mut reader = CdrReader::new(bytes)?;
    let header = read_header(&mut reader)?;
    reader.i32()?;
    reader.u32()?;
    // A width told in single precision is meant as the shortest decimal that it stands for.
    let resolution = reader.f32()?.to_string().parse().ok()?;
    let (width, height) = (reader.u32()? as usize, reader.u32()? as usize);
    let map_from_grid = read_pose(&mut reader)?;
    let data = reader.bytes()?;
    if width.checked_mul(height) != Some(data.len()) {
        return None;
    }
    let cell = |&value: &u8| match value {
        0..=100 => Cell::Solid(f32::from(value) / 100.0),
        _ => Cell::Unknown,
    };
    Some((header, OccupancyGrid { width, height, resolution, map_from_grid, cells: data.iter().map(cell).collect() }))
}

/// A `nav_msgs/OccupancyGrid`.
#[must_use]
pub fn encode_grid(header: Header, grid: &OccupancyGrid) -> Vec<u8> {
    let mut writer = begin(header);
    writer.i32(header.stamp.sec).u32(header.stamp.nanosec).f32(grid.resolution as f32);
    writer.u32(grid.width as u32).u32(grid.height as u32);
    write_pose(&mut writer, grid.map_from_grid);
    let byte = |cell: &Cell| match cell {
        Cell::Solid(share) => (100.0 * share.clamp(0.0, 1.0)).round() as u8,
        Cell::Unknown => u8::MAX,
    };
    writer.bytes(&grid.cells.iter().map(byte).collect::<Vec<u8>>());
    writer.finish()
}

/// A `visualization_msgs/MarkerArray`: one list of lines for each set, which replaces the one of the same name.
#[must_use]
pub fn encode_lines(header: Header, sets: &[LineSet]) -> Vec<u8> {
    const LINE_LIST: i32 = 5;
    let mut writer = CdrWriter::new();
    writer.u32(sets.len() as u32);
    for set in sets {
        write_header(&mut writer, header);
        writer.text(set.name).i32(0).i32(LINE_LIST).i32(0);
        write_pose(&mut writer, Pose2::IDENTITY);
        writer.f64s(&[set.width, 0.0, 0.0]);
        set.color.iter().for_each(|&part| {
            writer.f32(part);
        });
        writer.i32(0).u32(0).u8(0);
        let pieces: Vec<[Vec2; 2]> = set.lines.iter().flat_map(|line| line.pieces()).collect();
        writer.u32(2 * pieces.len() as u32);
        pieces.iter().flatten().for_each(|p| {
            writer.f64s(&[p.x, p.y, set.height]);
        });
        // No colours of single points, no texture.
        writer.u32(0).text("");
        write_header(&mut writer, Header { stamp: Stamp::default(), frame: "" });
        writer.text("").bytes(&[]).u32(0);
        // No text, no mesh.
        writer.text("").text("").text("").bytes(&[]).u8(0);
    }
    writer.finish()
}

/// A `sensor_msgs/PointCloud2` of points in the plane, each with its height (m) and colour (red, green, blue).
#[must_use]
pub fn encode_cloud(header: Header, points: impl IntoIterator<Item = (Vec2, f64, [u8; 3])>) -> Vec<u8> {
    const FLOAT32: u8 = 7;
    const STEP: u32 = 16;
    let mut data = Vec::new();
    for (point, height, [red, green, blue]) in points {
        [point.x, point.y, height].iter().for_each(|&v| data.extend((v as f32).to_le_bytes()));
        // The colour's bytes stand in the place of a number.
        data.extend([blue, green, red, 0]);
    }
    let count = (data.len() / STEP as usize) as u32;
    let mut writer = begin(header);
    writer.u32(1).u32(count).u32(4);
    for (index, name) in ["x", "y", "z", "rgb"].into_iter().enumerate() {
        writer.text(name).u32(4 * index as u32).u8(FLOAT32).u32(1);
    }
    writer.u8(0).u32(STEP).u32(STEP * count).bytes(&data).u8(1);
    writer.finish()
}

/// A `sensor_msgs/JointState` with an effort (N m) for each name.
#[must_use]
pub fn encode_effort(header: Header, names: &[String], efforts: &[f64]) -> Vec<u8> {
    let mut writer = begin(header);
    writer.u32(names.len() as u32);
    names.iter().for_each(|name| {
        writer.text(name);
    });
    // Neither positions nor velocities.
    writer.u32(0).u32(0).u32(efforts.len() as u32).f64s(efforts);
    writer.finish()
}

/// A `std_msgs/String`.
#[must_use]
pub fn encode_text(text: &str) -> Vec<u8> {
    let mut writer = CdrWriter::new();
    writer.text(text);
    writer.finish()
}

/// The text of a `std_msgs/String`.
#[must_use]
pub fn decode_text(bytes: &[u8]) -> Option<&str> {
    CdrReader::new(bytes)?.text()
}

/// Names and numbers of equal count.
pub type NamedNumbers<'a> = (Vec<&'a str>, Vec<f64>);

/// A `sensor_msgs/JointState` whose positions are these numbers: each under its name, exact, and shown by viewers as plots.
#[must_use]
pub fn encode_named(header: Header, names: &[String], values: &[f64]) -> Vec<u8> {
    let mut writer = begin(header);
    writer.u32(names.len() as u32);
    names.iter().for_each(|name| {
        writer.text(name);
    });
    writer.u32(values.len() as u32).f64s(values).u32(0).u32(0);
    writer.finish()
}

/// The header, names and positions of a `sensor_msgs/JointState` that has as many of both.
#[must_use]
pub fn decode_named(bytes: &[u8]) -> Option<(Header<'_>, NamedNumbers<'_>)> {
    let mut reader = CdrReader::new(bytes)?;
    let header = read_header(&mut reader)?;
    // Each name takes five bytes at least, each number eight: a false count ends the message, not the memory.
    let names: Vec<&str> = (0..reader.u32()?).map_while(|_| reader.text()).take(bytes.len() / 5 + 1).collect();
    let count = reader.u32()? as usize;
    let values: Vec<f64> = (0..count).map_while(|_| reader.f64()).collect();
    (names.len() == values.len() && values.len() == count).then_some((header, (names, values)))
}

/// A `std_msgs/UInt8MultiArray` of these bytes.
#[must_use]
pub fn encode_bytes(bytes: &[u8]) -> Vec<u8> {
    let mut writer = CdrWriter::new();
    // No dimensions, no offset.
    writer.u32(0).u32(0).bytes(bytes);
    writer.finish()
}

/// The bytes of a `std_msgs/UInt8MultiArray` without dimensions.
#[must_use]
pub fn decode_bytes(bytes: &[u8]) -> Option<&[u8]> {
    let mut reader = CdrReader::new(bytes)?;
    let (0, _) = (reader.u32()?, reader.u32()?) else { return None };
    reader.bytes()
}
