//! What the node is without its wires: map and robot, rows that wait, the estimating thread, and what it knows.

use crate::config::{LEAST_REGION, LEAST_TURN, REGION_DEVIATIONS};
use crate::feed::Feed;
use crate::lifecycle::{Change, Lifecycle};
use crate::messages::{OccupancyGrid, Transition, TransitionDescription};
use crate::parameters::Parameters;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use vibrissa::tasks::plan::{Plan, Planner};
use vibrissa_core::config::SettingValue;
use vibrissa_core::flow::pose::{Estimate, Hypothesis, Status};
use vibrissa_core::flow::sensor_log::Channel;
use vibrissa_core::localizer::Method;
use vibrissa_core::plane::Pose2;
use vibrissa_core::world::{Map, Robot};
use vibrissa_core::{Error, Result};
use vibrissa_io::Calibrator;
use vibrissa_live::counts::Counts;
use vibrissa_live::estimate::{LiveEstimator, UsedRow};
use vibrissa_live::source::HostClock;

/// A region of start: least and largest x, y (m) and heading (rad), map frame.
pub type Region = [[f64; 2]; 3];

/// What configuring loads.
#[derive(Clone, Debug)]
struct Loaded {
    /// None until it has come as a message.
    map: Option<Arc<Map>>,
    /// With the bounds of its calibrations.
    robot: Robot,
    calibrator: Option<Calibrator>,
    /// What messages hold, and what rows hold.
    sent: Vec<Channel>,
    channels: Vec<Channel>,
}

/// An estimate, and where the robot's odometry was.
#[derive(Clone, Debug)]
pub struct Report {
    /// Time of its row (s).
    pub t: f64,
    /// Verdict and places.
    pub estimate: Estimate,
    /// The row's odometry.
    pub odom_from_robot: Pose2,
}

/// What is said while the node estimates.
#[derive(Debug)]
pub enum Said<'a> {
    /// It begins to estimate on a map.
    Began(&'a Map),
    /// An estimate.
    Estimate(&'a Report),
}

/// What the heart tells.
#[derive(Clone, Debug, Default)]
pub struct Pulse {
    /// The state of the node.
    pub state: Lifecycle,
    /// Where the odometry's origin is, and the stamp (s) of the last odometry: as long as the robot is localized.
    pub map_from_odom: Option<(f64, Pose2)>,
    /// Verdict of the last estimate.
    pub status: Option<Status>,
    /// Places of the last estimate.
    pub places: usize,
    /// Rows taken, rows that others stand for, rows that no whisker can cause.
    pub rows: [u64; 3],
    /// Times the estimate began anew.
    pub restarts: u64,
    /// Counts of readings and of odometry, and how long ago each was heard (s).
    pub sources: Vec<(&'static str, Counts, Option<f64>)>,
    /// What stands in the way, with what to do.
    pub fault: Option<String>,
}

#[derive(Default)]
struct Inner {
    state: Lifecycle,
    loaded: Option<Arc<Loaded>>,
    /// The map that came as a message last.
    told_map: Option<Arc<Map>>,
    feed: Option<Feed>,
    region: Option<Region>,
    /// Counts the beginnings of estimates: the thread begins anew when it changes.
    session: u64,
    restarts: u64,
    map_from_odom: Option<Pose2>,
    last: Option<(Status, usize)>,
    /// Where the robot may be, and what a plan looks at.
    places: Vec<Hypothesis>,
    planner: Option<Planner>,
    rows: [u64; 3],
    fault: Option<String>,
    ended: bool,
}

/// The node without its wires.
pub struct Engine {
    parameters: Parameters,
    clock: HostClock,
    inner: Mutex<Inner>,
    more: Condvar,
}

impl Engine {
    /// An engine that is not configured.
    #[must_use]
    pub fn new(parameters: Parameters) -> Self {
        Self { parameters, clock: HostClock::new(), inner: Mutex::default(), more: Condvar::new() }
    }

    fn lock(&self) -> MutexGuard<'_, Inner> {
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The state of the node.
    #[must_use]
    pub fn state(&self) -> Lifecycle {
        self.lock().state
    }

    /// Does what a manager asks for. Loading a large map takes its time; nothing waits for it but the caller.
    ///
    /// # Errors
    ///
    /// A change that the state does not allow; files that cannot be read.
    pub fn change(&self, asked: &Transition) -> Result<TransitionDescription> {
        let state = self.state();
        let Some((change, next, description)) = state.change(asked) else {
            let word = state.message().label;
            let allowed: Vec<String> = state.changes().into_iter().map(|one| one.transition.label).collect();
            return Err(Error::data(format!("the node is {word}: it cannot do that"))
                .value(format!("transition {} \"{}\"", asked.id, asked.label))
                .allowed(allowed.join(", ")));
        };
        let loaded = if change == Change::Configure { Some(Arc::new(self.load()?)) } else { None };
        let mut inner = self.lock();
        match change {
            Change::Configure => {
                inner.loaded = loaded;
                inner.region = self.parameters.initial_region();
            }
            Change::Activate => self.begin(&mut inner),
            Change::Deactivate => inner.stop(),
            Change::CleanUp => inner.loaded = None,
            Change::Shutdown => {
                inner.stop();
                inner.ended = true;
            }
        }
        inner.state = next;
        drop(inner);
        self.more.notify_all();
        Ok(description)
    }

    fn load(&self) -> Result<Loaded> {
        let map = match self.parameters.map_topic {
            None => Some(Arc::new(vibrissa_io::read_map(&self.parameters.map)?)),
            Some(_) => self.lock().told_map.clone(),
        };
        let robot = match &self.parameters.robot {
            Some(path) => vibrissa_io::read_robot(path)?,
            None => Robot::default(),
        };
        let sent = self.parameters.channels(&robot)?;
        let calibrator = Calibrator::new(&sent, &robot)?;
        let (channels, robot) = match &calibrator {
            Some(calibrator) => (calibrator.channels(&sent), calibrator.robot(&robot)),
            None => (sent.clone(), robot),
        };
        Ok(Loaded { map, robot, calibrator, sent, channels })
    }

    /// Begins to estimate anew.
    fn begin(&self, inner: &mut Inner) {
        let Some(loaded) = inner.loaded.clone() else { return };
        inner.feed = Some(Feed::new(loaded.sent.len(), loaded.calibrator.clone(), self.parameters.delay));
        inner.session += 1;
        (inner.map_from_odom, inner.last, inner.fault) = (None, None, None);
        (inner.places, inner.planner) = (Vec::new(), None);
        if let (None, Some(topic)) = (&loaded.map, &self.parameters.map_topic) {
            inner.fault = Some(format!(
                "no map came on the topic {topic}; start map_server, or check its name (transient local, reliable)"
            ));
        }
    }

    /// Takes a map that came as a message and begins anew on it; one that cannot be used is told and left out.
    pub fn map_message(&self, message: &OccupancyGrid) {
        let traced = crate::grid::map_of(message);
        let mut inner = self.lock();
        match traced {
            Err(error) => inner.fault = Some(one_line(&error)),
            Ok(map) => {
                let map = Arc::new(map);
                inner.told_map = Some(Arc::clone(&map));
                if let Some(loaded) = &inner.loaded {
                    inner.loaded = Some(Arc::new(Loaded { map: Some(map), ..Loaded::clone(loaded) }));
                }
                if inner.state == Lifecycle::Active {
                    inner.restarts += 1;
                    self.begin(&mut inner);
                }
            }
        }
        drop(inner);
        self.more.notify_all();
    }

    fn restart(&self, region: Option<Region>) {
        let mut inner = self.lock();
        inner.region = region;
        if inner.state == Lifecycle::Active {
            inner.restarts += 1;
            self.begin(&mut inner);
        }
        drop(inner);
        self.more.notify_all();
    }

    /// Begins anew with the robot in a region around a pose (map frame), as wide as its covariance says.
    pub fn initial_pose(&self, pose: Pose2, variances: [f64; 3]) {
        self.restart(Some(region_around(pose, variances)));
    }

    /// Begins anew with the robot anywhere on the map.
    pub fn anywhere(&self) {
        self.restart(None);
    }

    /// Takes odometry with its stamp (s); none where the message held no pose.
    pub fn odometry(&self, stamp: f64, pose: Option<Pose2>) {
        self.hear(|feed, now| feed.odometry(stamp, now, pose));
    }

    /// Takes readings with their stamp (s); none where the message did not hold them.
    pub fn readings(&self, stamp: f64, values: Option<Vec<f64>>) {
        self.hear(|feed, now| feed.readings(stamp, now, values));
    }

    fn hear(&self, take: impl FnOnce(&mut Feed, f64)) {
        let now = self.clock.now();
        let mut inner = self.lock();
        let Some(feed) = &mut inner.feed else { return };
        take(feed, now);
        let (jumped, wakes) = (feed.jumped(), feed.has_rows());
        if jumped {
            inner.restarts += 1;
            self.begin(&mut inner);
        }
        drop(inner);
        if wakes || jumped {
            self.more.notify_all();
        }
    }

    /// The whiskers and readings that messages hold, once the node is configured.
    #[must_use]
    pub fn channels(&self) -> Vec<Channel> {
        self.lock().loaded.as_ref().map(|loaded| loaded.sent.clone()).unwrap_or_default()
    }

    /// What the heart tells now; it never waits for the estimate.
    #[must_use]
    pub fn pulse(&self) -> Pulse {
        let now = self.clock.now();
        let mut inner = self.lock();
        if let Some(feed) = &mut inner.feed {
            feed.tick(now);
        }
        let feed = inner.feed.as_ref();
        let pulse = Pulse {
            state: inner.state,
            map_from_odom: feed.and_then(Feed::last_odometry).zip(inner.map_from_odom).map(|((t, _), pose)| (t, pose)),
            status: inner.last.map(|(status, _)| status),
            places: inner.last.map_or(0, |(_, places)| places),
            rows: inner.rows,
            restarts: inner.restarts,
            sources: feed.map_or_else(Vec::new, |feed| {
                feed.counts().map(|(name, counts, heard)| (name, *counts, heard.map(|t| now - t))).to_vec()
            }),
            fault: inner.fault.clone(),
        };
        let wakes = feed.is_some_and(Feed::has_rows);
        drop(inner);
        if wakes {
            self.more.notify_all();
        }
        pulse
    }

    /// The next motion that tells the places of the last estimate apart. It takes a fifth of a second; no message waits for it.
    ///
    /// # Errors
    ///
    /// No place is known, or the robot's motions cannot be planned.
    pub fn plan(&self) -> Result<Plan> {
        let inner = self.lock();
        let state = inner.state;
        let (loaded, planner, places) = (inner.loaded.clone(), inner.planner.clone(), inner.places.clone());
        drop(inner);
        let Some(loaded) = loaded.filter(|_| state == Lifecycle::Active) else {
            return Err(Error::data("no plan: the node is not active").remedy("activate it first"));
        };
        let Some(map) = loaded.map.as_ref().filter(|_| !places.is_empty()) else {
            return Err(Error::data("no plan: no place is known between which a motion could decide")
                .remedy("touch a wall for some centimetres first"));
        };
        match planner {
            Some(planner) => planner.plan(map, &loaded.robot, &places),
            // What stands in the way.
            None => Planner::new(&loaded.robot, &loaded.channels, self.parameters.plan)
                .and_then(|planner| planner.plan(map, &loaded.robot, &places)),
        }
    }

    /// Estimates until the node ends, on the calling thread; `told` gets what is said.
    pub fn run(&self, told: &mut dyn FnMut(Said<'_>)) {
        let mut session = 0;
        while let Some((next, loaded, region)) = self.next_session(session) {
            session = next;
            if let Err(error) = self.estimate(session, &loaded, region, told) {
                let mut inner = self.lock();
                if inner.session == session {
                    inner.fault = Some(one_line(&error));
                }
            }
        }
    }

    /// Waits for a session after this one; none when the node ends.
    fn next_session(&self, session: u64) -> Option<(u64, Arc<Loaded>, Option<Region>)> {
        let mut inner = self.lock();
        loop {
            if inner.ended {
                return None;
            }
            let begun = inner.session > session && inner.feed.is_some();
            if let Some(loaded) = inner.loaded.as_ref().filter(|loaded| begun && loaded.map.is_some()) {
                return Some((inner.session, Arc::clone(loaded), inner.region));
            }
            inner = self.more.wait(inner).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Waits for rows of a session; none when it is over.
    fn next_rows(&self, session: u64) -> Option<Vec<UsedRow>> {
        let mut inner = self.lock();
        loop {
            if inner.ended || inner.session != session {
                return None;
            }
            match &mut inner.feed {
                None => return None,
                Some(feed) if feed.has_rows() => return Some(feed.take()),
                Some(_) => inner = self.more.wait(inner).unwrap_or_else(PoisonError::into_inner),
            }
        }
    }

    fn estimate(
        &self,
        session: u64,
        loaded: &Loaded,
        region: Option<Region>,
        told: &mut dyn FnMut(Said<'_>),
    ) -> Result<()> {
        let mut method: Method = self.parameters.method;
        if let Some(region) = region {
            method.set("within", SettingValue::Region(region))?;
        }
        let Loaded { map: Some(map), robot, channels, .. } = loaded else { return Ok(()) };
        told(Said::Began(map));
        let mut estimator = LiveEstimator::new(map, robot, channels, &method, self.parameters.rate)?;
        // Robots whose motions cannot be planned are localized all the same.
        self.lock().planner = Planner::new(robot, channels, self.parameters.plan).ok();
        while let Some(rows) = self.next_rows(session) {
            for used in rows {
                let step = estimator.step(&used.joined);
                let mut inner = self.lock();
                if inner.session != session {
                    return Ok(());
                }
                inner.planner.iter_mut().for_each(|planner| planner.row(&used.joined.row));
                inner.rows[0] += 1;
                inner.rows[1] += used.merged - 1;
                match step {
                    Ok(None) => {}
                    Err(error) => {
                        inner.rows[2] += 1;
                        inner.fault = Some(one_line(&error));
                    }
                    Ok(Some(one)) => {
                        let odom_from_robot = used.joined.row.odom_from_robot;
                        let report = Report { t: one.t, estimate: one.estimate, odom_from_robot };
                        inner.take(&report);
                        drop(inner);
                        told(Said::Estimate(&report));
                    }
                }
            }
        }
        Ok(())
    }
}

impl Inner {
    fn stop(&mut self) {
        self.feed = None;
        self.session += 1;
        (self.map_from_odom, self.last) = (None, None);
        (self.places, self.planner) = (Vec::new(), None);
    }

    /// Where the odometry's origin is, as long as one place is known: while several are possible the last one known is kept,
    /// and where nothing explains the readings none is told.
    fn take(&mut self, report: &Report) {
        let estimate = &report.estimate;
        self.last = Some((estimate.status, estimate.hypotheses.len()));
        self.places = if estimate.status == Status::Inconsistent { Vec::new() } else { estimate.hypotheses.clone() };
        self.fault = None;
        match (estimate.status, estimate.pose()) {
            (Status::Localized, Some(map_from_robot)) => {
                self.map_from_odom = Some(map_from_robot.compose(report.odom_from_robot.inverse()));
            }
            (Status::Inconsistent, _) => self.map_from_odom = None,
            _ => {}
        }
    }
}

/// The region of three standard deviations around a pose.
#[must_use]
pub fn region_around(pose: Pose2, variances: [f64; 3]) -> Region {
    let half = |variance: f64, least: f64| (REGION_DEVIATIONS * variance.max(0.0).sqrt()).max(least);
    let around = |middle: f64, half: f64| [middle - half, middle + half];
    let turn = half(variances[2], LEAST_TURN).min(core::f64::consts::PI);
    [
        around(pose.x, half(variances[0], LEAST_REGION)),
        around(pose.y, half(variances[1], LEAST_REGION)),
        around(pose.theta, turn),
    ]
}

/// An error on one line.
#[must_use]
pub fn one_line(error: &Error) -> String {
    error.to_string().replace("\n  help: ", "; ").replace('\n', " ")
}
