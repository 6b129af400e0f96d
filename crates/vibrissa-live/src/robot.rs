//! A simulated robot behind pseudo-terminals: real bytes in real time, as the paper's firmware and a base send them.

mod obedient;

use crate::source::PseudoTerminal;
use crate::{Error, Result};
pub use obedient::{Errand, TrueCourse};
use std::path::{Path, PathBuf};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use vibrissa_core::flow::sensor_log::{Quantity, SensorLog};
use vibrissa_core::plane::Pose2;
use vibrissa_core::world::calibration::{Calibration, MomentCurve};
use vibrissa_io::calibration::to_json;

/// Flux density at the sensor without contact (T).
const REST: [f64; 3] = [120e-6, -340e-6, 12e-3];
/// The direction in which contact moves it, a unit vector,
const DIRECTION: [f64; 3] = [0.6, 0.0, 0.8];
/// and how far (T for a N m): 17 mN m are 1.7 mT, a tenth of the sensor's range.
const GAIN: f64 = 0.1;
/// Half width of the calibrated range of moments (N m).
const RANGE: f64 = 0.04;
/// Bound on the error of a moment from a printed hundredth of a microtesla (N m).
const BOUND: f64 = 2e-7;
/// Rows for each message of odometry: 50 a second.
const ODOMETRY_EVERY: usize = 6;

/// The ports of a simulated robot with one whisker.
#[derive(Debug)]
pub struct SimulatedRobot {
    whisker: PseudoTerminal,
    base: PseudoTerminal,
}

impl SimulatedRobot {
    /// Readings a second, as the paper's firmware sends them.
    pub const RATE: f64 = 300.0;

    /// A robot that waits.
    ///
    /// # Errors
    ///
    /// The system has no pseudo-terminals left.
    pub fn new() -> Result<Self> {
        let pair = || {
            PseudoTerminal::new()
                .map_err(|e| Error::data("cannot make a pseudo-terminal").value(e).remedy("is /dev/pts mounted?"))
        };
        Ok(Self { whisker: pair()?, base: pair()? })
    }

    /// The port of the whisker: flux of the paper's firmware, `x,y,z` in µT.
    #[must_use]
    pub fn whisker_port(&self) -> &Path {
        self.whisker.port()
    }

    /// The port of the base: `seq16,t_us,x,y,theta`.
    #[must_use]
    pub fn base_port(&self) -> &Path {
        self.base.port()
    }

    /// The calibration that turns the whisker's flux into moments, as the text of its file.
    #[must_use]
    pub fn calibration() -> String {
        let curve = MomentCurve {
            inputs: ["bx", "by", "bz"].map(str::to_owned).to_vec(),
            rest: REST.to_vec(),
            direction: DIRECTION.to_vec(),
            range: [0.0, GAIN * RANGE],
            coefficients: vec![0.0, RANGE],
            residual_rms: 0.5 * BOUND,
            hysteresis: 0.0,
            bound: BOUND,
            samples: 1000,
        };
        to_json(&Calibration { moment: Some(curve), ..Calibration::default() }).to_string()
    }

    /// The setup of a live run that reads this robot; `map` and `robot` are its files, no map where one is made.
    #[must_use]
    pub fn setup(&self, map: Option<&Path>, robot: &Path) -> String {
        let quoted = |path: &Path| format!("{:?}", path.display().to_string());
        format!(
            "{}robot = {}\n\n[[source]]\nname = \"whisker\"\nserial = {}\nformat = \"serial\"\n\n[[source]]\n\
             name = \"base\"\nserial = {}\nformat = \"csv\"\ncolumns = [\"seq16\", \"t_us\", \"x\", \"y\", \"theta\"]\n",
            map.map(|map| format!("map = {}\n", quoted(map))).unwrap_or_default(),
            quoted(robot),
            quoted(self.whisker_port()),
            quoted(self.base_port()),
        )
    }

    /// Writes the files that the setup names into a folder: `robot.toml` and `cal.json`; the robot's path.
    ///
    /// # Errors
    ///
    /// A folder that cannot be written to.
    pub fn write_files(folder: &Path) -> Result<PathBuf> {
        let write = |name: &str, text: &str| {
            let path = folder.join(name);
            std::fs::write(&path, text).map(|()| path.clone()).map_err(|e| {
                Error::data("cannot write").in_file(&path).value(e).remedy("choose another folder with --out")
            })
        };
        write("cal.json", &Self::calibration())?;
        write("robot.toml", "[[whisker]]\nname = \"w0\"\ncalibration = \"cal.json\"\n")
    }

    /// Drives along a log of moments: each row's bytes are sent when its time has come.
    ///
    /// # Errors
    ///
    /// A log without moments.
    pub fn drive(self, log: SensorLog) -> Result<JoinHandle<std::io::Result<()>>> {
        let moment = log.channels.iter().position(|c| c.quantity == Quantity::Moment);
        let moment = moment.ok_or_else(|| Error::data("the log to drive along has no moments"))?;
        Ok(std::thread::spawn(move || self.send(&log, moment)))
    }

    fn send(mut self, log: &SensorLog, moment: usize) -> std::io::Result<()> {
        let began = Instant::now();
        let first = log.rows.first().map_or(0.0, |row| row.t);
        for (index, row) in log.rows.iter().enumerate() {
            let t = row.t - first;
            let due = Duration::try_from_secs_f64(t).unwrap_or_default();
            std::thread::sleep(due.saturating_sub(began.elapsed()));
            let with_odometry = index % ODOMETRY_EVERY == 0 || index + 1 == log.rows.len();
            let number = index.div_ceil(ODOMETRY_EVERY) as u32;
            self.tell(t, row.readings[moment], row.odom_from_robot, with_odometry, number)?;
        }
        // What was sent last is read before the ports go away.
        std::thread::sleep(Duration::from_millis(500));
        Ok(())
    }

    /// Sends a moment, and where it is due the odometry, with its number, as it was then.
    fn tell(
        &mut self,
        t: f64,
        moment: f64,
        odom_from_robot: Pose2,
        with_odometry: bool,
        number: u32,
    ) -> std::io::Result<()> {
        self.whisker.send(flux_line(moment).as_bytes())?;
        if !with_odometry {
            return Ok(());
        }
        // A little below the end of 32 bits, so that the stamps wrap after three seconds.
        let clock = ((4_291.967_296 + t) * 1e6) as u64 % (1 << 32);
        let (pose, number) = (odom_from_robot, number % (1 << 16));
        let line = format!("{number},{clock},{:.7},{:.7},{:.8}\r\n", pose.x, pose.y, pose.theta);
        self.base.send(line.as_bytes())
    }
}

/// The line of the paper's firmware for a moment (N m).
#[must_use]
pub fn flux_line(moment: f64) -> String {
    let [x, y, z] = [0, 1, 2].map(|axis| 1e6 * (REST[axis] + GAIN * moment * DIRECTION[axis]));
    format!("{x:.2},{y:.2},{z:.2}\r\n")
}
