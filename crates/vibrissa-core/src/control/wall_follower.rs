//! Wall following by touch: a bending moment is kept along a boundary that nobody knows.
//!
//! A whisker that leads and leans to the wall tells of the wall where the robot will be. Steering in proportion to its moment is then
//! damped by that lead, as in the antenna-based wall following of cockroaches and of wheeled robots after them \[cowan2006task,
//! lamperski2005dynamical\]. What a wall does that is no wall any more is a state machine, as in \[jung1996whisker\]: a corner that goes away is
//! circled at the wall's distance; a whisker that is caught, or bent too far, has the robot go back the way it came and turn off.
//!
//! | the reading | is | the robot |
//! | --- | --- | --- |
//! | pushed off the wall's side | the wall | steers so that the moment stays within the band |
//! | below the threshold for 4 mm of way | the wall's end, an outer corner | goes on by the tip's lead, then around the corner |
//! | pushed back, or a whisker that points ahead | a wall ahead, an inner corner | goes back until its whiskers can turn freely, and turns off |
//! | near the largest moment | a wall too near | likewise, and turns a little |
//! | the like again and again without way | a dead end | stands and says so |

use super::feeler::{Feeler, felt};
use super::options::FollowOptions;
use super::trail::{Trail, length};
use crate::config::wall_following::{
    ABOUT, AFTER_TURN, AGAIN, ATTEMPTS, CLEARANCE, HELD, LEAN, LOST, LOST_TURN, RELIEF, ROOM, SIDEWAYS, SLOWEST,
    STEERING, STRIDE, WIDER,
};
use crate::math;
use crate::plane::Twist2;
use crate::world::Robot;
use crate::{Error, Result};

/// What the controller does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FollowState {
    /// Nothing was felt yet: straight ahead.
    Searching,
    /// The wall is touched, less than the band wants.
    Approaching,
    /// The wall is kept.
    Following,
    /// The wall went away: around its end.
    TurningOuterCorner,
    /// Something is ahead: back and around.
    TurningInnerCorner,
    /// No way on was found; the robot stands until [`WallFollower::reset`].
    Blocked,
}

/// What the robot is to do until the next reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FollowCommand {
    /// Velocity of the body: forward, to the left (m/s), counter-clockwise (rad/s).
    pub twist: Twist2,
    /// What it is for.
    pub state: FollowState,
}

/// What the controller does, in more detail; the wall is on the right.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Phase {
    Search,
    /// Way since the wall was last felt (m), and whether it was kept.
    Follow {
        lost: f64,
        was_firm: bool,
    },
    /// Straight on for so far (m), then around.
    Coast {
        left: f64,
        inner: bool,
    },
    /// Around; turned so far (rad).
    Circle {
        turned: f64,
        inner: bool,
    },
    /// A turn on the spot back (rad), back for so far (m), then a turn by so much (rad); after tries that met something past other
    /// places where it turned.
    Retreat {
        left: f64,
        undo: f64,
        then: f64,
        tries: usize,
    },
    /// A turn on the spot, so much more and so much done (rad), this way round, after so many that met something.
    Turn {
        left: f64,
        turned: f64,
        way: f64,
        tries: usize,
    },
    Blocked,
}

/// The controller of one robot, fed row by row.
///
/// It keeps whiskers, that are straight at rest, gentle and the footprint off what they feel. What no whisker comes to before the footprint does it
/// cannot know: a robot with one whisker is kept clear of walls on that side alone.
///
/// ```
/// use vibrissa_core::control::{FollowOptions, FollowState, WallFollower};
/// use vibrissa_core::plane::Pose2;
/// use vibrissa_core::world::{MountedWhisker, Robot};
///
/// let whisker = MountedWhisker { robot_from_whisker: Pose2::new(0.0, 0.0, -0.8), ..MountedWhisker::default() };
/// let robot = Robot { whiskers: vec![whisker], ..Robot::default() };
/// let mut follower = WallFollower::new(&robot, &FollowOptions::default())?;
/// let free = follower.step(0.00, &[0.0]);
/// assert_eq!(free.state, FollowState::Searching);
/// // Bent more than the band wants: away from the wall, which is on the right.
/// let near = follower.step(0.02, &[5e-3]);
/// assert!(near.state == FollowState::Following && near.twist.theta > 0.0);
/// # Ok::<(), vibrissa_core::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct WallFollower {
    options: FollowOptions,
    mirror: f64,
    feelers: Vec<Feeler>,
    /// Least lead of the wall's whiskers, greatest reach of any, radius of the way around corners (m).
    lead: f64,
    reach: f64,
    radius: f64,
    /// How far it turns off what is ahead (rad).
    turn_off: f64,
    phase: Phase,
    trail: Trail,
    time: Option<f64>,
    twist: Twist2,
    /// Turns off something ahead, and way since the last (m).
    attempts: usize,
    since: f64,
}

impl WallFollower {
    /// The controller of a robot, before its first reading.
    ///
    /// # Errors
    ///
    /// Usage: options out of range; no whisker that points ahead to the wall's side and reaches further than the footprint. Whiskers that lean.
    pub fn new(robot: &Robot, options: &FollowOptions) -> Result<Self> {
        options.check(robot)?;
        robot.require_level("following walls")?;
        let feelers = Feeler::all(robot, options);
        let on_wall = || feelers.iter().filter(|feeler| feeler.is_on_wall());
        let least = |value: fn(&Feeler) -> f64| on_wall().map(value).fold(f64::INFINITY, f64::min);
        let (lead, distance) = (least(|f| f.tip.x), least(Feeler::distance));
        if !(lead.is_finite() && lead > options.footprint && distance > options.footprint) {
            return Err(Error::usage("whiskers to follow a wall with")
                .value(format!("{} in all", feelers.len()))
                .allowed(
                    "one at least that points 12 to 78 deg off straight ahead, to the wall's side, past the footprint",
                )
                .remedy("mount one so, choose the other side, or make the footprint smaller"));
        }
        let reach = feelers.iter().map(|f| f.tip.norm()).fold(0.0, f64::max);
        let mirror = if options.side_of(robot) == super::Side::Right { 1.0 } else { -1.0 };
        let aside = on_wall().map(|f| math::atan2(-f.tip.y, f.tip.x)).fold(0.0, f64::max);
        Ok(Self {
            options: *options,
            mirror,
            lead,
            reach,
            radius: distance.max(options.footprint + CLEARANCE),
            turn_off: aside + LEAN,
            feelers,
            phase: Phase::Search,
            trail: Trail::default(),
            time: None,
            twist: Twist2::default(),
            attempts: 0,
            since: 0.0,
        })
    }

    /// Forgets what was felt, and searches.
    pub fn reset(&mut self) {
        self.phase = Phase::Search;
        (self.attempts, self.since) = (0, 0.0);
    }

    /// What the robot is to do from time `t` (s) on, at which its whiskers read these moments (N m), until the next call.
    ///
    /// The robot is taken to have moved as it was told last. Where a reading is missing or no finite number, or time runs back, it stands.
    pub fn step(&mut self, t: f64, readings: &[f64]) -> FollowCommand {
        let passed = self.time.map_or(0.0, |before| t - before);
        let is_sound = readings.len() == self.feelers.len() && readings.iter().all(|z| z.is_finite());
        if !(is_sound && passed >= 0.0 && passed.is_finite()) {
            self.twist = Twist2::default();
            return FollowCommand { twist: self.twist, state: self.state() };
        }
        self.time = Some(t);
        self.moved(passed);
        let felt = felt(&self.feelers, readings);
        self.react(&felt);
        // Slow sensors make slow robots.
        let slower = if passed > 0.0 { (STRIDE / (passed * self.options.speed)).min(1.0) } else { 1.0 };
        self.twist = self.command(&felt, slower);
        let Twist2 { x, y, theta } = self.twist;
        FollowCommand { twist: Twist2 { x, y: self.mirror * y, theta: self.mirror * theta }, state: self.state() }
    }

    /// What the controller does.
    #[must_use]
    pub fn state(&self) -> FollowState {
        match self.phase {
            Phase::Search => FollowState::Searching,
            Phase::Follow { was_firm: false, .. } => FollowState::Approaching,
            Phase::Follow { was_firm: true, .. } => FollowState::Following,
            Phase::Coast { inner: false, .. } | Phase::Circle { inner: false, .. } => FollowState::TurningOuterCorner,
            Phase::Blocked => FollowState::Blocked,
            _ => FollowState::TurningInnerCorner,
        }
    }

    /// Counts what the robot did since the last reading.
    fn moved(&mut self, time: f64) {
        let (way, turn) = (time * length(self.twist), time * self.twist.theta);
        match &mut self.phase {
            Phase::Retreat { left, undo, .. } => {
                (*left, *undo) = if way > 0.0 { (*left - way, *undo) } else { (*left, *undo - turn.abs()) };
                return self.trail.take(time);
            }
            Phase::Coast { left, .. } => *left -= way,
            Phase::Circle { turned, .. } => *turned += turn.abs(),
            Phase::Turn { left, turned, .. } => (*left, *turned) = (*left - turn.abs(), *turned + turn.abs()),
            Phase::Follow { lost, .. } => *lost += way,
            Phase::Search | Phase::Blocked => {}
        }
        self.since += way;
        self.trail.add(self.twist, time);
    }

    /// What comes next.
    fn react(&mut self, felt: &super::feeler::Felt) {
        if self.since > AGAIN {
            self.attempts = 0;
        }
        self.phase = match self.phase {
            Phase::Blocked => Phase::Blocked,
            Phase::Retreat { left, undo, then, tries } => {
                let (is_back, is_soft) = (left <= 0.0 && undo <= 0.0, felt.hardest < 1.0);
                let turn = Phase::Turn { left: then.abs(), turned: 0.0, way: then.signum(), tries };
                match self.trail.back() {
                    // Something holds the whisker on the way back, too.
                    _ if felt.hardest > HELD => Phase::Blocked,
                    _ if is_back && is_soft => turn,
                    Some((_, on_the_spot)) if !on_the_spot || undo > 0.0 || tries > 1 || !is_soft => self.phase,
                    _ if is_soft => turn,
                    _ => Phase::Blocked,
                }
            }
            // A whisker that swings over a wall may be pushed either way.
            Phase::Turn { left, .. } if felt.hardest < 1.0 => {
                // What was ahead is beside it already.
                let is_beside = left < 0.5 * self.turn_off && felt.too_near.is_some() && felt.ahead.is_none();
                match left {
                    _ if is_beside => Phase::Follow { lost: 0.0, was_firm: felt.is_firm },
                    left if left > 0.0 => self.phase,
                    _ => Phase::Coast { left: AFTER_TURN * self.reach, inner: true },
                }
            }
            // No room on this side: the other way round, or further back.
            Phase::Turn { turned, way, tries, .. } => self.no_room(turned, way, tries),
            _ if felt.ahead.is_some() => self.go_back(felt.ahead.unwrap_or(self.lead), self.turn_off),
            Phase::Search if felt.is_other => self.go_back(self.lead, -ABOUT),
            _ if felt.hardest >= 1.0 => self.go_back(self.lead, if felt.is_other { -ABOUT } else { RELIEF }),
            Phase::Follow { was_firm, .. } if felt.too_near.is_some() => {
                Phase::Follow { lost: 0.0, was_firm: was_firm || felt.is_firm }
            }
            Phase::Follow { lost, .. } if lost > LOST => Phase::Coast { left: self.lead - lost, inner: false },
            Phase::Follow { .. } => self.phase,
            _ if felt.too_near.is_some() => Phase::Follow { lost: 0.0, was_firm: felt.is_firm },
            Phase::Coast { left, inner } if left <= 0.0 => Phase::Circle { turned: 0.0, inner },
            Phase::Circle { turned, .. } if turned > LOST_TURN => Phase::Search,
            phase => phase,
        };
    }

    /// Something is ahead of a tip that leads by so much, or too near: back until all whiskers can turn freely, and a turn by so much (rad).
    fn go_back(&mut self, lead: f64, then: f64) -> Phase {
        self.attempts += 1;
        self.since = 0.0;
        if self.attempts > ATTEMPTS {
            return Phase::Blocked;
        }
        Phase::Retreat { left: (self.reach - lead).max(0.0) + ROOM, undo: 0.0, then, tries: 0 }
    }

    /// A turn met something: back to where it began, and the other way round; then further back each time.
    fn no_room(&mut self, undo: f64, way: f64, tries: usize) -> Phase {
        let then = if way > 0.0 { -ABOUT } else { self.turn_off };
        match self.go_back(self.lead, then) {
            Phase::Retreat { left, .. } => {
                Phase::Retreat { left: left + tries as f64 * self.reach, undo, then, tries: tries + 1 }
            }
            phase => phase,
        }
    }

    /// The twist of the phase, the wall on the right.
    fn command(&self, felt: &super::feeler::Felt, slower: f64) -> Twist2 {
        let speed = slower * self.options.speed;
        let ahead = |x: f64| Twist2 { x, y: 0.0, theta: 0.0 };
        match self.phase {
            Phase::Search | Phase::Coast { .. } => ahead(speed),
            Phase::Follow { .. } => self.steer(felt, speed),
            Phase::Circle { inner, .. } => {
                // A wall that was ahead is met at a small angle.
                let radius = if inner { WIDER * self.radius } else { self.radius };
                let v = speed.min(radius * self.options.turn_rate);
                Twist2 { x: v, y: 0.0, theta: -v / radius }
            }
            // As fast as it came.
            Phase::Retreat { .. } => self.trail.back().map_or_else(Twist2::default, |(twist, _)| twist),
            Phase::Turn { way, .. } => {
                Twist2 { x: 0.0, y: 0.0, theta: way * self.options.turn_rate.min(speed / self.reach) }
            }
            Phase::Blocked => Twist2::default(),
        }
    }

    /// Keeps the moment: steers by what the wall is too near, damped by the tip's lead.
    fn steer(&self, felt: &super::feeler::Felt, speed: f64) -> Twist2 {
        // A wall that is not felt is further off than any that is.
        let too_near = felt.too_near.unwrap_or(-0.5 * CLEARANCE);
        let turn_rate = self.options.turn_rate;
        let curvature = STEERING / (self.lead * self.lead) * too_near;
        // Around a wall that comes nearer it may turn on the spot; around one that goes away it must not cut the corner.
        let curvature = curvature.max(-1.0 / self.radius);
        let slow = ((1.0 - felt.hardest) / 0.5).clamp(SLOWEST, 1.0);
        let v = slow * speed.min(turn_rate / curvature.abs().max(1e-9)).max(SLOWEST * speed);
        let theta = (speed * curvature).clamp(-turn_rate, turn_rate);
        let theta = if curvature < 0.0 { theta.max(v * curvature) } else { theta };
        let y = if self.options.sideways { (SIDEWAYS * too_near).clamp(-0.5 * speed, 0.5 * speed) } else { 0.0 };
        Twist2 { x: v, y, theta }
    }
}
