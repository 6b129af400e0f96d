//! What the last door says: a verdict, places, and the way there.

use crate::flow::state_set::probabilistic::calibrated;
use crate::plane::{Pose2, Vec2};
use crate::sets::StateBox;

/// The verdict on a log.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Status {
    /// One place explains the log.
    Localized,
    /// Several separate places explain the log, or the contact was too short to tell any place.
    Ambiguous,
    /// No state explains this log on this map.
    Inconsistent,
    /// The whisker never touched anything.
    #[default]
    NoContact,
}

/// One place that explains the log, kept apart from every other.
#[derive(Clone, Debug, PartialEq)]
pub struct Hypothesis {
    /// The chosen state at the last row, map frame.
    pub pose: Pose2,
    /// Its share among all hypotheses; the shares sum to 1.
    pub weight: f64,
    /// The extent of the component that it stands for.
    pub extent: StateBox,
    /// Covariance of (x, y, heading) in the map frame (m², m rad, rad²), where the method gives one: what the declared
    /// noise and odometry bounds leave open at this place.
    pub covariance: Option<[[f64; 3]; 3]>,
    /// The curve along which the readings leave the place open, where the method gives one and the place is longer than 4 mm:
    /// states at the last row (map frame), in order from one end of what the readings allow to the other, each a fit of its
    /// own; else empty. Between neighbours states lie on a straight line, their headings on the shorter way.
    pub ridge: Vec<Pose2>,
}

impl Hypothesis {
    /// The error to be expected: root mean square of the position (m) and of the heading (rad), where the method gives a
    /// covariance.
    #[must_use]
    pub fn bound(&self) -> Option<(f64, f64)> {
        self.covariance.map(|c| ((c[0][0] + c[1][1]).max(0.0).sqrt(), c[2][2].max(0.0).sqrt()))
    }

    /// How far the robot's positions go along the ridge (m), where there is one.
    #[must_use]
    pub fn ridge_length(&self) -> Option<f64> {
        let length = self.ridge.windows(2).map(|w| w[0].position().distance(w[1].position())).sum();
        (self.ridge.len() > 1).then_some(length)
    }
}

/// Something that happened at one time.
#[derive(Clone, Debug, PartialEq)]
pub struct Event {
    /// When (s).
    pub t: f64,
    /// A short fixed word: `contact`, `lift_off`, `inconsistent`, …
    pub kind: &'static str,
    /// What happened, for people.
    pub detail: String,
}

/// The state set after one update.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepRecord {
    /// When (s).
    pub t: f64,
    /// How many separate components the set has.
    pub components: usize,
    /// Area of the set's projection onto the plane (m²).
    pub area_m2: f64,
    /// Volume of the set (m² rad).
    pub volume: f64,
}

/// The robot at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StampedPose {
    /// When (s).
    pub t: f64,
    /// The robot in the map frame.
    pub map_from_robot: Pose2,
}

/// One reconstructed whisker shape.
#[derive(Clone, Debug, PartialEq)]
pub struct ShapeRecord {
    /// When (s).
    pub t: f64,
    /// Index of the whisker in the robot.
    pub whisker: usize,
    /// Points along the whisker from base to tip, robot frame (m).
    pub points: Vec<Vec2>,
}

/// What the readings say about the odometry: each of its increments has to be stretched, turned aside and turned further alike.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OdometryEstimate {
    /// The true length of an increment over the one that odometry gives; 1 where it is right.
    pub translation_scale: f64,
    /// Its standard deviation.
    pub translation_scale_std: f64,
    /// How far increments go to the left of where odometry says (rad).
    pub aside: f64,
    /// Its standard deviation (rad).
    pub aside_std: f64,
    /// The true turn of an increment over the one that odometry gives; 1 where it is right.
    pub rotation_scale: f64,
    /// Its standard deviation.
    pub rotation_scale_std: f64,
}

impl OdometryEstimate {
    /// An increment of the odometry (robot frame), corrected.
    #[must_use]
    pub fn corrected(&self, increment: Pose2) -> Pose2 {
        calibrated(increment, [self.translation_scale - 1.0, self.aside, self.rotation_scale - 1.0])
    }
}

/// A quantity that the robot file bounds because it is not known exactly.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NuisanceQuantity {
    /// Moment that is read while the whisker is free (N m).
    Zero,
    /// How fast that changes (N m/s).
    ZeroDrift,
    /// Base of the whisker on the robot, x (m).
    MountX,
    /// Base of the whisker on the robot, y (m).
    MountY,
    /// Direction of the whisker on the robot (rad).
    MountHeading,
    /// Length of the whisker (m).
    Length,
    /// Flexural rigidity, relative to the declared one.
    Rigidity,
    /// Gain of the readings, relative.
    Gain,
    /// How much later than the odometry the readings were taken (s).
    Delay,
    /// Scale of the map, relative: how much larger the world is.
    MapScale,
}

impl NuisanceQuantity {
    /// The word that names it in files.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Zero => "zero",
            Self::ZeroDrift => "zero_drift",
            Self::MountX => "mount_x",
            Self::MountY => "mount_y",
            Self::MountHeading => "mount_heading",
            Self::Length => "length",
            Self::Rigidity => "stiffness",
            Self::Gain => "gain",
            Self::Delay => "delay",
            Self::MapScale => "map_scale",
        }
    }

    /// The SI unit of its values; empty for shares.
    #[must_use]
    pub fn unit(self) -> &'static str {
        match self {
            Self::Zero => "N m",
            Self::ZeroDrift => "N m/s",
            Self::MountX | Self::MountY | Self::Length => "m",
            Self::MountHeading => "rad",
            Self::Rigidity | Self::Gain | Self::MapScale => "",
            Self::Delay => "s",
        }
    }
}

/// What the readings say of a quantity that is not known exactly: the true value less the declared one.
#[derive(Clone, Debug, PartialEq)]
pub struct Nuisance {
    /// Which quantity.
    pub quantity: NuisanceQuantity,
    /// The name of its whisker, where it is of one.
    pub whisker: Option<String>,
    /// Estimate, in the quantity's unit.
    pub estimate: f64,
    /// Its standard deviation.
    pub std: f64,
    /// The declared bound.
    pub bound: f64,
}

impl Nuisance {
    /// Whether the readings tell it from zero: by more than two standard deviations.
    #[must_use]
    pub fn is_significant(&self) -> bool {
        self.estimate.abs() > 2.0 * self.std
    }

    /// What the quantity was, in one clause: "the zero of w0 was off by +0.210 ± 0.020 mN m".
    #[must_use]
    pub fn sentence(&self) -> String {
        let Self { quantity, estimate, std, .. } = *self;
        let whisker = self.whisker.as_deref().unwrap_or("the whiskers");
        // The size in the unit that shows it, with as many digits as the deviation is worth.
        let size = |factor: f64, unit: &str| {
            let (value, std) = (factor * estimate, factor * std);
            let digits = if std > 0.0 { (1.0 - std.log10().floor()).clamp(0.0, 6.0) as usize } else { 3 };
            (
                format!("{value:+.digits$} ± {std:.digits$} {unit}"),
                format!("{:.digits$} ± {std:.digits$} {unit}", value.abs()),
            )
        };
        let either = |more: &str, less: &str| if estimate < 0.0 { less.to_owned() } else { more.to_owned() };
        match quantity {
            NuisanceQuantity::Zero => format!("the zero of {whisker} was off by {}", size(1e3, "mN m").0),
            NuisanceQuantity::ZeroDrift => format!("the zero of {whisker} drifted by {}", size(1e6, "uN m/s").0),
            NuisanceQuantity::MountX => format!("the mount of {whisker} was off in x by {}", size(1e3, "mm").0),
            NuisanceQuantity::MountY => format!("the mount of {whisker} was off in y by {}", size(1e3, "mm").0),
            NuisanceQuantity::MountHeading => {
                format!("the mount of {whisker} was turned by {}", size(1f64.to_degrees(), "deg").0)
            }
            NuisanceQuantity::Length => {
                format!("{whisker} was {} {} than declared", size(1e3, "mm").1, either("longer", "shorter"))
            }
            NuisanceQuantity::Rigidity => {
                format!("{whisker} was {} {} than declared", size(100.0, "%").1, either("stiffer", "softer"))
            }
            NuisanceQuantity::Gain => {
                format!("the readings of {whisker} were {} too {}", size(100.0, "%").1, either("large", "small"))
            }
            NuisanceQuantity::Delay => {
                format!("readings were taken {} {} than the odometry", size(1e3, "ms").1, either("later", "earlier"))
            }
            NuisanceQuantity::MapScale => {
                format!("the world was {} {} than the map", size(100.0, "%").1, either("larger", "smaller"))
            }
        }
    }
}

/// A stretch of the log (s).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch {
    /// Time of its first row.
    pub from: f64,
    /// Time of its last row.
    pub to: f64,
}

/// One change of log, robot or map that was tried because the readings do not fit.
#[derive(Clone, Debug, PartialEq)]
pub struct Remedy {
    /// What was changed, for people: "the sign of w0.moment is the other way round".
    pub change: String,
    /// The consistency statistic with it; the least first.
    pub statistic: f64,
    /// The verdict with it.
    pub status: Status,
}

/// How well the readings fit what was declared \[barshalom2001estimation, sec. 5.4\].
#[derive(Clone, Debug, PartialEq)]
pub struct ConsistencyReport {
    /// Mean normalised innovation squared: 1 where the errors are as declared, above `most` where the readings contradict.
    pub statistic: f64,
    /// The largest that errors within the declared bounds can make it.
    pub most: f64,
    /// How long the readings' errors stay alike (s), 0 where they are independent.
    pub correlation_time: f64,
    /// The stretch of the log that fits worst, and the statistic there.
    pub worst: Option<(Stretch, f64)>,
    /// What was tried where the readings contradict, the best first.
    pub remedies: Vec<Remedy>,
}

/// What can be said before the log has ended: less exact than the answer at the end, see [`crate::localizer::Estimator`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Estimate {
    /// The verdict on the rows so far.
    pub status: Status,
    /// Every surviving place at the last row, map frame, heaviest first.
    pub hypotheses: Vec<Hypothesis>,
    /// How many rows have been taken.
    pub rows: usize,
}

impl Estimate {
    /// The best hypothesis at the last row, map frame; none as long as no place is known.
    #[must_use]
    pub fn pose(&self) -> Option<Pose2> {
        self.hypotheses.first().map(|h| h.pose)
    }
}

/// What a log and a map say about the robot.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Localization {
    /// The name of the method that made this answer.
    pub method: &'static str,
    /// The verdict.
    pub status: Status,
    /// The best hypothesis at the last row, map frame.
    pub estimate: Option<Pose2>,
    /// Every surviving place, heaviest first, never averaged over separate places.
    pub hypotheses: Vec<Hypothesis>,
    /// The best hypothesis over time, one entry for each log row from the first estimate on.
    pub trajectory: Vec<StampedPose>,
    /// What is said about the odometry, by the probabilistic method where the robot declares that it may be wrong.
    pub odometry: Option<OdometryEstimate>,
    /// The final state set; for the deterministic method its surviving points.
    pub states: Vec<StateBox>,
    /// Whether `states` hold every state that the declared bounds allow: what lies outside is ruled out.
    pub encloses: bool,
    /// The candidates after the first observation, at that time: the first row of the trajectory.
    pub first_states: Vec<Pose2>,
    /// The set's size after each update.
    pub steps: Vec<StepRecord>,
    /// What happened along the way.
    pub events: Vec<Event>,
    /// Whisker shapes along the sweep, for drawing.
    pub shapes: Vec<ShapeRecord>,
    /// What is said of quantities that the robot file bounds, by methods that estimate them.
    pub nuisances: Vec<Nuisance>,
    /// How well the readings fit, by methods that tell.
    pub consistency: Option<ConsistencyReport>,
    /// Stretches in which the trajectory is not sure: more than one place, or none, explained the readings there.
    pub unsure: Vec<Stretch>,
}
