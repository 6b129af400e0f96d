//! What mapping tells.

use super::changes::Change;
use crate::flow::pose::StampedPose;
use crate::plane::{Pose2, Vec2};
use crate::tasks::profile::AssembledMap;

/// Whether the robot came back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ClosureVerdict {
    /// No other place within the declared odometry bounds explains what was felt.
    Proved,
    /// Other places do, so many of them, or one that is too large to tell.
    Hypothesis,
    /// No place does: the declared bounds do not hold.
    Contradiction,
    /// The search was cut short.
    Unfinished,
}

impl ClosureVerdict {
    /// The verdict in a word, for files.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Proved => "proved",
            Self::Hypothesis => "hypothesis",
            Self::Contradiction => "contradiction",
            Self::Unfinished => "unfinished",
        }
    }
}

/// A place where the robot may have come back.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Closure {
    /// When it was there later, and earlier (s).
    pub later: f64,
    /// See `later`.
    pub earlier: f64,
    /// The logs of both times, by their number from 0, the later first.
    pub logs: (usize, usize),
    /// What is known of it.
    pub verdict: ClosureVerdict,
    /// How many separate places are left, and half of their extent: x, y (m) and heading (rad).
    pub places: usize,
    /// See `places`.
    pub extent: [f64; 3],
}

/// A quantity with its standard deviation.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Share {
    /// The value.
    pub value: f64,
    /// Its standard deviation.
    pub std: f64,
}

/// By which shares the odometry is wrong.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OdometryShares {
    /// Ways are longer than told by this share.
    pub scale: Share,
    /// Turns are larger than told by this share.
    pub turn: Share,
    /// The heading turns by so much more along the way (rad/m).
    pub drift: Share,
}

/// One of the logs, in the outline.
#[derive(Clone, Debug)]
pub struct Visit {
    /// Whether it is known where the log begins in the outline of those before: proved for the first. Without a proof it adds nothing to the
    /// outline, and its poses are not known.
    pub placed: ClosureVerdict,
    /// How many places in the outline are left for it.
    pub places: usize,
    /// The robot at every row.
    pub trajectory: Vec<StampedPose>,
    /// Covariances of its pose at some rows, relative to the first log's first row: when, and by x, y (m), heading (rad).
    pub covariances: Vec<(f64, [[f64; 3]; 3])>,
}

/// What mapping found, in the frame of the first row's odometry.
#[derive(Clone, Debug)]
pub struct Mapped {
    /// The outline: boundaries with bands, corners, unknown stretches.
    pub outline: AssembledMap,
    /// The logs, in their order.
    pub visits: Vec<Visit>,
    /// The odometry's shares.
    pub shares: OdometryShares,
    /// Where the robot came back, or may have.
    pub closures: Vec<Closure>,
    /// Walls that are not where an earlier log felt them.
    pub changes: Vec<Change>,
    /// How many felt points the outline is made of.
    pub points: usize,
    /// The least-squares problem behind it.
    pub graph: FactorGraph,
}

/// The factor graph that was solved last \[dellaert2017factor\], with its solution, for other solvers. The first pose is fixed.
#[derive(Clone, Debug, Default)]
pub struct FactorGraph {
    /// The key poses (map frame), and their covariances by x, y (m), heading (rad), relative to the first.
    pub poses: Vec<Pose2>,
    /// See `poses`.
    pub covariances: Vec<[[f64; 3]; 3]>,
    /// The odometry's shares, as of [`OdometryShares`]: scale, turn, drift.
    pub shares: [Share; 3],
    /// Standard deviations of the shares' priors around 0; a share is 0 where that is 0.
    pub share_stds: [f64; 3],
    /// The odometry between each key pose and the next.
    pub legs: Vec<LegFactor>,
    /// Contacts on walls that were felt earlier.
    pub contacts: Vec<ContactFactor>,
    /// Half of the sum of all squared residuals, each over its standard deviation.
    pub cost: f64,
}

/// The odometry from one key pose to the next: `step` and the derivatives by the shares, times these.
///
/// Residuals are the place of the next pose in the frame of the one before less that of the step, and the turn likewise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LegFactor {
    /// What the odometry says.
    pub step: Pose2,
    /// Derivatives of place (m) and turn (rad) by each share.
    pub by_share: [(Vec2, f64); 3],
    /// Standard deviations of place (m, along each axis) and turn (rad).
    pub place_std: f64,
    /// See `place_std`.
    pub turn_std: f64,
}

/// A contact on the line through an earlier one \[chen1992object\]: the residual is the distance across that line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactFactor {
    /// The key pose of the later contact, and the contact in its frame (m).
    pub later: (usize, Vec2),
    /// The same of the earlier one,
    pub earlier: (usize, Vec2),
    /// and the normal of its wall in that frame.
    pub normal: Vec2,
    /// Standard deviation of the distance (m), with the weight that the contact has for Cauchy's function.
    pub std: f64,
}

impl Mapped {
    /// The robot at every row of the first log.
    #[must_use]
    pub fn trajectory(&self) -> &[StampedPose] {
        self.visits.first().map_or(&[], |visit| &visit.trajectory)
    }
}
