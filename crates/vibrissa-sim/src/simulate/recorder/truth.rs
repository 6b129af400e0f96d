//! How a robot, its map and its readings really are where that is not as declared.

use super::{Sweep, in_range};
use crate::beam::{Stretch, Stretches};
use crate::flow::pose::StampedPose;
use crate::plane::{Curve, Pose2, Segment, Vec2};
use crate::world::{Boundary, Map, Robot, Role};
use crate::{Error, Result};

/// The true values less the declared ones, the same for all whiskers; the default has none.
///
/// A robot that is simulated is the true one: [`TrueErrors::true_robot`] makes it of a declared one, and
/// [`TrueErrors::declared_robot`] goes back. The rest befalls what is recorded.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TrueErrors {
    /// Moment that is read while a whisker is free (N m).
    pub zero: f64,
    /// How fast that changes (N m/s), from the first row on.
    pub zero_drift: f64,
    /// Base of the whiskers on the robot: x, y (m), heading (rad).
    pub mount: [f64; 3],
    /// Length of the whiskers (m).
    pub length: f64,
    /// Flexural rigidity, relative to the declared one, above -1.
    pub rigidity: f64,
    /// Gain of the readings, relative to the declared one, above -1.
    pub gain: f64,
    /// How much later than its odometry a row's readings are taken (s); below 0 they are older.
    pub delay: f64,
    /// How much more way the odometry counts than is gone, relative, above -1.
    pub odometry_translation: f64,
    /// How much more turn it counts, relative, above -1.
    pub odometry_rotation: f64,
    /// How much larger the world is than its map, relative, above -1.
    pub map_scale: f64,
    /// How much further to the left an absolute heading points than the robot does (rad).
    pub heading: f64,
}

impl TrueErrors {
    pub(super) fn check(&self) -> Result<()> {
        for (name, value) in [
            ("rigidity", self.rigidity),
            ("gain", self.gain),
            ("odometry_translation", self.odometry_translation),
            ("odometry_rotation", self.odometry_rotation),
            ("map_scale", self.map_scale),
        ] {
            if !(value > -1.0 && value.is_finite()) {
                return Err(Error::usage(format!("the true error {name}")).value(value).allowed("above -1"));
            }
        }
        let rest = [self.zero, self.zero_drift, self.length, self.delay, self.heading];
        rest.iter().chain(&self.mount).try_for_each(|value| in_range("true errors", value.abs(), f64::INFINITY))
    }

    /// The robot as it is, of one as it is declared.
    ///
    /// # Errors
    ///
    /// Data: a whisker without length.
    pub fn true_robot(&self, declared: &Robot) -> Result<Robot> {
        self.other(declared, 1.0, |value, error| value * (1.0 + error))
    }

    /// The robot as it is declared, of one as it is.
    ///
    /// # Errors
    ///
    /// Data: a whisker without length.
    pub fn declared_robot(&self, truth: &Robot) -> Result<Robot> {
        self.other(truth, -1.0, |value, error| value / (1.0 + error))
    }

    fn other(&self, robot: &Robot, sign: f64, scale: impl Fn(f64, f64) -> f64) -> Result<Robot> {
        let mut robot = robot.clone();
        for whisker in &mut robot.whiskers {
            let (mount, [x, y, heading]) = (whisker.robot_from_whisker, self.mount.map(|error| sign * error));
            whisker.robot_from_whisker = Pose2::new(mount.x + x, mount.y + y, mount.theta + heading);
            let beam = &mut whisker.beam;
            let length = beam.length + sign * self.length;
            if !(length > 0.0 && length.is_finite()) {
                return Err(Error::data(format!("the length of the whisker {} without its error", whisker.name))
                    .value(format!("{:.3} mm", 1e3 * length))
                    .allowed("above 0 m"));
            }
            let stretched = length / beam.length;
            beam.flexural_rigidity = scale(beam.flexural_rigidity, self.rigidity);
            let wires = beam.stretches.as_slice().iter().map(|wire| Stretch {
                length: wire.length * stretched,
                flexural_rigidity: scale(wire.flexural_rigidity, self.rigidity),
                ..*wire
            });
            let wires: Vec<Stretch> = wires.collect();
            if !wires.is_empty() {
                beam.stretches = Stretches::new(&wires)?;
            }
            beam.length = length;
        }
        Ok(robot)
    }

    /// The map as it is declared, of the world as it is: about the origin.
    ///
    /// # Errors
    ///
    /// Data: a map too large for its coordinates.
    pub fn declared_map(&self, world: &Map) -> Result<Map> {
        if self.map_scale.abs() > 0.0 { scaled(world, 1.0 / (1.0 + self.map_scale)) } else { Ok(world.clone()) }
    }

    /// The world as it is, of the map as it is declared: about the origin.
    ///
    /// # Errors
    ///
    /// Data: a world too large for its coordinates.
    pub fn world(&self, declared: &Map) -> Result<Map> {
        if self.map_scale.abs() > 0.0 { scaled(declared, 1.0 + self.map_scale) } else { Ok(declared.clone()) }
    }

    /// A path on the declared map, in the world as it is.
    pub(crate) fn path_in_world(&self, path: &[StampedPose]) -> Vec<StampedPose> {
        let scale = 1.0 + self.map_scale;
        let place = |p: Pose2| Pose2::new(scale * p.x, scale * p.y, p.theta);
        path.iter().map(|p| StampedPose { map_from_robot: place(p.map_from_robot), ..*p }).collect()
    }

    /// The places of a sweep in the world as it is, in the frame of the map as it is declared.
    pub(crate) fn put_on_declared_map(&self, sweep: &mut Sweep) {
        if self.map_scale.abs() <= 0.0 {
            return;
        }
        let scale = 1.0 / (1.0 + self.map_scale);
        sweep.truth.iter_mut().for_each(|pose| pose.map_from_robot = self.on_declared_map(pose.map_from_robot));
        sweep.contacts.iter_mut().for_each(|touch| touch.position = touch.position * scale);
        sweep.shapes.iter_mut().flat_map(|shape| &mut shape.points).for_each(|point| *point = *point * scale);
    }

    /// A pose of the world as it is, in the frame of the map as it is declared.
    #[must_use]
    pub fn on_declared_map(&self, pose: Pose2) -> Pose2 {
        let scale = 1.0 / (1.0 + self.map_scale);
        Pose2::new(scale * pose.x, scale * pose.y, pose.theta)
    }

    /// The moment (N m) that a sensor makes of a true one, so long (s) after the first row.
    pub(in super::super) fn read(&self, since: f64, moment: f64) -> f64 {
        (1.0 + self.gain) * moment + self.zero + self.zero_drift * since
    }

    /// An increment of the odometry (robot frame).
    pub(in super::super) fn counted(&self, step: Pose2) -> Pose2 {
        let (way, turn) = (1.0 + self.odometry_translation, 1.0 + self.odometry_rotation);
        Pose2 { x: way * step.x, y: way * step.y, theta: turn * step.theta }
    }
}

/// The map, so much larger about the origin.
fn scaled(map: &Map, factor: f64) -> Result<Map> {
    let boundary = |b: &Boundary| {
        let place = |p: Vec2| p * factor;
        let segment = |s: &Segment| match *s {
            Segment::Line(p) => Segment::Line(p.map(place)),
            Segment::Quadratic(p) => Segment::Quadratic(p.map(place)),
            Segment::Cubic(p) => Segment::Cubic(p.map(place)),
        };
        let segments = b.curve().segments().iter().map(segment).collect();
        let curve = Curve::from_segments(segments, b.curve().is_closed())
            .ok_or_else(|| Error::data("a boundary without length").value(factor))?;
        let name = b.name().map(str::to_owned);
        // Free space lies on the left: an obstacle that runs counter-clockwise is a hole of another.
        match b.role() {
            Role::Obstacle if curve.signed_area() > 0.0 => Boundary::obstacle_hole(curve, name),
            role => Boundary::new(role, curve, name),
        }
    };
    Map::new(map.boundaries().iter().map(boundary).collect::<Result<_>>()?)
}

/// The moments of one whisker at these times and so much later (s), linear between rows.
pub(super) fn delayed(times: &[f64], moments: &[f64], delay: f64) -> Vec<f64> {
    if delay.abs() <= 0.0 || moments.len() < 2 {
        return moments.to_vec();
    }
    let at = |t: f64| {
        let next = times.partition_point(|&other| other < t).clamp(1, times.len() - 1);
        let share = ((t - times[next - 1]) / (times[next] - times[next - 1])).clamp(0.0, 1.0);
        moments[next - 1] + share * (moments[next] - moments[next - 1])
    };
    times.iter().map(|t| at(t + delay)).collect()
}
