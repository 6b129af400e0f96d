//! A simulated robot that goes where it is told, and rests in between.

use super::{ODOMETRY_EVERY, SimulatedRobot};
use crate::{Error, Result};
use std::sync::mpsc::{Receiver, TryRecvError};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use vibrissa_core::flow::pose::StampedPose;
use vibrissa_core::plane::Pose2;
use vibrissa_sim::recorder::TrueErrors;
use vibrissa_sim::{Drive, Pace, Stage, SweepNoise, path_through};

/// A motion that the robot is told to make.
#[derive(Clone, Debug, PartialEq)]
pub struct Errand {
    /// Waypoints, seen from where the robot is.
    pub waypoints: Vec<Pose2>,
    /// The size of each whisker's reading (N m) at which it stops; none where the list is empty.
    pub stop_at: Vec<f64>,
}

/// Where a robot is that drives on another thread.
#[derive(Clone, Debug, Default)]
pub struct TrueCourse(Arc<Mutex<Option<StampedPose>>>);

impl TrueCourse {
    /// Its last pose, map frame.
    #[must_use]
    pub fn last(&self) -> Option<StampedPose> {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn set(&self, pose: StampedPose) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = Some(pose);
    }
}

/// A robot on the way.
struct Ride<'a> {
    robot: SimulatedRobot,
    drive: Drive<'a>,
    pace: Pace,
    began: Instant,
    rows: u32,
    course: &'a TrueCourse,
    errands: &'a Receiver<Errand>,
}

impl SimulatedRobot {
    /// Drives along `begin` (map frame, at least two waypoints), and then on each errand that comes; in between it rests. An errand that comes
    /// before the last is done is left out. The drive ends when nobody is left who could send one.
    ///
    /// # Errors
    ///
    /// Waypoints or a pace that make no path.
    pub fn obey(
        self,
        stage: Stage,
        begin: &[Pose2],
        pace: Pace,
        noise: SweepNoise,
        errands: Receiver<Errand>,
        course: TrueCourse,
    ) -> Result<JoinHandle<Result<()>>> {
        let path = path_through(begin, &pace)?;
        Ok(std::thread::spawn(move || {
            let Some((&first, rest)) = path.split_first() else { return Ok(()) };
            let drive = Drive::start(&stage, first, &noise)?;
            let (course, errands) = (&course, &errands);
            let mut ride = Ride { robot: self, drive, pace, began: Instant::now(), rows: 0, course, errands };
            ride.go(rest, &[])?;
            loop {
                match errands.try_recv() {
                    Ok(errand) => ride.run(&errand)?,
                    Err(TryRecvError::Empty) => ride.rest()?,
                    Err(TryRecvError::Disconnected) => break,
                }
            }
            // What was sent last is read before the ports go away.
            std::thread::sleep(Duration::from_millis(500));
            Ok(())
        }))
    }
}

impl Ride<'_> {
    fn run(&mut self, errand: &Errand) -> Result<()> {
        let from = self.drive.pose().map_from_robot;
        let waypoints: Vec<Pose2> = errand.waypoints.iter().map(|pose| from.compose(*pose)).collect();
        // A way back that has no length is none.
        let Ok(path) = path_through(&waypoints, &self.pace) else { return Ok(()) };
        self.go(&path[1..], &errand.stop_at)
    }

    /// Through poses, until a whisker feels too much or nobody sends errands any more.
    fn go(&mut self, path: &[StampedPose], stop_at: &[f64]) -> Result<()> {
        for pose in path {
            let readings = self.row(pose.map_from_robot)?;
            let feels_too_much = readings.iter().zip(stop_at).any(|(size, most)| size.abs() >= *most);
            if feels_too_much || matches!(self.errands.try_recv(), Err(TryRecvError::Disconnected)) {
                break;
            }
        }
        Ok(())
    }

    fn rest(&mut self) -> Result<()> {
        let here = self.drive.pose().map_from_robot;
        self.row(here).map(drop)
    }

    /// One row at its time; what was read.
    fn row(&mut self, map_from_robot: Pose2) -> Result<Vec<f64>> {
        self.rows += 1;
        let t = f64::from(self.rows) / self.pace.rate;
        std::thread::sleep(Duration::from_secs_f64(t).saturating_sub(self.began.elapsed()));
        let to = StampedPose { t, map_from_robot };
        let row = self.drive.advance(to, &TrueErrors::default(), 0.0)?;
        self.course.set(to);
        let every = ODOMETRY_EVERY as u32;
        let moment = row.readings.first().copied().unwrap_or_default();
        self.robot
            .tell(t, moment, row.odom_from_robot, self.rows.is_multiple_of(every), self.rows / every)
            .map_err(|error| Error::data("the simulated robot's port is gone").value(error))?;
        Ok(row.readings)
    }
}
