//! Every default of the product, once, with its unit and its reason.

use crate::{Error, Result};

/// Tolerances of the geometry, and the limits beyond which a file is taken to be in the wrong unit.
pub mod limits {
    /// Largest distance between a map's curve and the chain of lines that stands for it in look-ups (m): a micrometre.
    pub const FLATTEN_TOLERANCE: f64 = 1e-6;
    /// Largest distance between a circular or elliptical arc and the cubics that replace it (m): a nanometre.
    pub const ARC_TOLERANCE: f64 = 1e-9;
    /// Largest coordinate of a map (m): beyond it the file is in millimetres, degrees or a geographic grid.
    pub const LARGEST_COORDINATE: f64 = 1e5;
    /// Largest odometry coordinate (m): any metric grid fits, and a micrometre is still resolved.
    pub const LARGEST_ODOMETRY: f64 = 1e8;
    /// Most rows of a log: 4.6 hours at 300 Hz, and about a GB with all that is remembered of each.
    pub const MOST_LOG_ROWS: usize = 5_000_000;
    /// Longest line of a log (bytes): hundreds of whiskers fit, a file that is no log is refused at once.
    pub const LONGEST_LOG_LINE: usize = 1 << 20;
    /// Most boundary points at which whiskers are aligned: 100 m of walls at 1 mm, and at worst a GB of candidates.
    pub const MOST_SAMPLES: f64 = 1e5;
    /// Most boundary that the possibilistic and the probabilistic method search without a region for the first pose (m):
    /// the first contact takes a second for every few metres.
    pub const MOST_SEARCHED: f64 = 100.0;
    /// Coarsest spacing of these points (m).
    pub const COARSEST_SPACING: f64 = 0.1;
    /// Largest extent of a map that raises no doubt (m).
    pub const LARGEST_MAP: f64 = 200.0;
    /// Largest strain limit of a whisker: no wire springs back from its own length.
    pub const LARGEST_STRAIN: f64 = 1.0;
    /// Largest heading change between two rows of a log that raises no doubt (rad).
    pub const HEADING_JUMP: f64 = 1.0;
    /// Largest move between two rows of a log that raises no doubt (m): 30 m/s at 300 Hz.
    pub const POSITION_JUMP: f64 = 0.1;
    /// Largest moment of a whisker that raises no doubt (N m): hundreds of times the paper's readings.
    pub const LARGEST_MOMENT: f64 = 1.0;
    /// Most cells of a grid map: a quarter of a square kilometre at 5 cm, and 200 MB while it is traced.
    pub const MOST_CELLS: usize = 1 << 24;
    /// Most borders between solid and free cells of a grid map: more is noise, not walls.
    pub const MOST_CROSSINGS: usize = 1 << 20;
    /// Longest gap between two messages of odometry that is bridged without a word (s): robots send some ten a second.
    pub const ODOMETRY_GAP: f64 = 0.25;
    /// Largest chunk or record of an MCAP recording (bytes): recorders make chunks of a few megabytes.
    pub const LARGEST_CHUNK: usize = 1 << 28;
}

/// The paper's whisker and the constants of the method.
pub mod defaults {
    /// Whisker length (m): the paper's Nitinol wire \[routray, section "Sensor Fabrication"\].
    pub const LENGTH: f64 = 0.075;
    /// Young's modulus (Pa): Nitinol, \[routray, section "Sensor Fabrication"\].
    pub const YOUNG_MODULUS: f64 = 52e9;
    /// Wire diameter (m), \[routray, section "Sensor Fabrication"\].
    pub const DIAMETER: f64 = 0.58e-3;
    /// Largest strain of the surface that raises no doubt: superelastic Nitinol springs back from about 6 %.
    pub const STRAIN_LIMIT: f64 = 0.06;
    /// Flexural rigidity E I (N m²): 52 GPa times 5.555e-15 m⁴, rounded as the paper rounds it.
    pub const FLEXURAL_RIGIDITY: f64 = 2.8886e-4;
    /// Tip radius over base radius: the paper's wire does not taper.
    pub const TIP_RATIO: f64 = 1.0;
    /// Intrinsic curvature (1/m): the paper's wire is straight.
    pub const CURVATURE: f64 = 0.0;
    /// Rotational stiffness of the base (N m/rad): clamped.
    pub const BASE_STIFFNESS: f64 = f64::INFINITY;
    /// Bound on the Coulomb coefficient: contact is frictionless, as in the paper.
    pub const FRICTION: f64 = 0.0;
    /// Bound on the reading's error relative to the reading: the paper's 5 % \[routray, section "Possibilistic Method"\].
    pub const MOMENT_RELATIVE: f64 = 0.05;
    /// Bound on the reading's error that stays at zero moment (N m).
    pub const MOMENT_ABSOLUTE: f64 = 2e-5;
    /// The same of a contact force: as that of the moment.
    pub const FORCE_RELATIVE: f64 = 0.05;
    /// Bound on a force's error at zero (N): the moment's at the end of the paper's whisker.
    pub const FORCE_ABSOLUTE: f64 = 3e-4;
    /// The same of a slope: as that of the moment.
    pub const SLOPE_RELATIVE: f64 = 0.05;
    /// Bound on a slope's error at zero (rad): that of the paper's whisker under the moment's.
    pub const SLOPE_ABSOLUTE: f64 = 3e-3;
    /// Bound on the error of each odometry increment relative to it: the paper's stage is exact to 10 µm.
    pub const ODOMETRY_RELATIVE: f64 = 0.0;
}

/// The magnet and the rubber disc at a whisker's base, where a scenario asks for flux or counts.
pub mod sensing {
    /// Rotational stiffness of the compliant element (N m/rad): a strong contact of 5 mN m turns the magnet by 6 deg.
    pub const STIFFNESS: f64 = 0.05;
    /// Dipole moment of the magnet (A m²): a neodymium disc of 2 mm diameter and 1 mm height.
    pub const MAGNET_MOMENT: f64 = 3.6e-3;
    /// Depth of the magnet below the pivot (m).
    pub const MAGNET_DEPTH: f64 = 3e-3;
    /// Distance from the magnet to the chip (m): the field along the whisker, 5.8 mT, is well inside the chip's range.
    pub const CHIP_DISTANCE: f64 = 5e-3;
}

/// The shafts whose distances are calibrated, where a call does not describe them.
pub mod shaft {
    /// Length of the rat-like whisker whose taps are public (m).
    pub const TAPPED_LENGTH: f64 = 0.18;
    /// Its tip radius over its base radius.
    pub const TAPPED_TIP_RATIO: f64 = 1.0 / 3.0;
    /// Length of the shaft whose staircase of contacts is public (m); its taper is fitted.
    pub const STAIRCASE_LENGTH: f64 = 0.15;
}

/// How finely the contacts that explain a reading are told.
pub mod contact_set {
    /// Contacts on each branch of an exact reading's curve: smooth on any screen.
    pub const NODES: usize = 200;
    /// How close curves must come to meet (m), beyond what their chords leave out: rounding.
    pub const MEETING: f64 = 1e-9;
}

/// What a scenario leaves out, and its limits.
pub mod scenario {
    /// Speed of the robot (m/s): half a millimetre a row.
    pub const SPEED: f64 = 0.15;
    /// Largest turning rate (rad/s).
    pub const TURN_RATE: f64 = 1.0;
    /// Rows a second (Hz): the paper's sampling rate.
    pub const RATE: f64 = 300.0;
    /// Most rows: an hour and a half at 300 Hz, and about a GB of memory.
    pub const MOST_ROWS: f64 = 2e6;
    /// Curved legs are followed by chords of this length (m); the sagitta on a 10 mm radius is a micrometre.
    pub const CHORD: f64 = 0.25e-3;
    /// Most chords of one leg: 100 m of wall.
    pub const MOST_CHORDS: f64 = 4e5;
    /// How far outside the robot's outline a whisker's mount may lie (m): drawn outlines are rounded.
    pub const MOUNT_SLACK: f64 = 1e-3;
}

/// Which way the contact force acts at a whisker's tip.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TipLoad {
    /// Normal to the boundary, as frictionless contact of a tip with a smooth wall is.
    #[default]
    BoundaryNormal,
    /// Normal to the whisker, as the paper has it; millimetres off where the whisker meets the wall aslant.
    WhiskerNormal,
}

/// The knobs of the deterministic method \[routray, section "Localization: Deterministic Method"\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeterministicOptions {
    /// Spacing of the points along the boundary at which the whisker is aligned (m); the paper's 1 mm.
    pub boundary_spacing: f64,
    /// How many whisker shapes estimate the boundary's slope; the paper's 2 to 5.
    pub history_shapes: usize,
    /// How far the whisker base travels from the first to the last of these shapes (m).
    ///
    /// A reading off by 5 % moves the tip by a millimetre or two. Over 10 mm the slope is good to a few degrees, and
    /// walls are still all but straight.
    pub history_travel: f64,
    /// How far the whisker base travels between two updates (m).
    pub update_travel: f64,
    /// Where on the boundary and at which heading a candidate may miss an observation, in standard deviations.
    pub tolerance: f64,
    /// Heading tolerance that stays when readings are exact (rad): the wall bends within the history.
    pub heading_floor: f64,
    /// Position tolerance that stays when readings are exact (m): shapes and walls are interpolated.
    pub position_floor: f64,
    /// Share of the observations that a candidate may miss: 0 is the paper's plain intersection.
    ///
    /// At corners the slope of the history is nobody's slope; a few bad observations must not empty the set.
    pub missed_share: f64,
    /// Which way the force acts at the tip.
    pub tip_load: TipLoad,
    /// Where the robot is at the first row, map frame, where that is known: least and largest x (m), y (m), heading (rad).
    pub prior: Option<[[f64; 2]; 3]>,
}

/// How boundaries are traced from grid maps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridOptions {
    /// How far lines may miss the boundary points of grey cells (cells): a few times what 8 bits of grey leave open.
    pub grey_tolerance: f64,
    /// The same where cells are all solid or all free (cells): the stairs of a slanting wall, from crest to crest.
    pub sharp_tolerance: f64,
    /// Whether unknown cells are free: the robot may have been where nobody looked, and walls then have two sides.
    pub unknown_is_free: bool,
}

impl Default for GridOptions {
    fn default() -> Self {
        Self { grey_tolerance: 0.05, sharp_tolerance: 0.8, unknown_is_free: false }
    }
}

/// The knobs of contact points and outlines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactOptions {
    /// Readings are merged into one step while the base is nearer than this to their mean (m): finer than any wall of interest.
    pub spacing: f64,
    /// The same for whiskers that are integrated (m): each of their shapes takes thousands of times as long.
    pub rod_spacing: f64,
    /// How far a step of a sliding tip may miss the wall's direction (m); walls are smooth at 10 µm.
    pub step_std: f64,
    /// How much a wall turns along the way (rad per root of a metre): 0.03 rad over a millimetre.
    pub turn: f64,
    /// What the odometry's places are rounded to (m): a base that moves evenly within it is taken to move evenly. The paper's stage.
    pub odometry_resolution: f64,
}

impl Default for ContactOptions {
    fn default() -> Self {
        Self { spacing: 0.1e-3, rod_spacing: 0.75e-3, step_std: 1e-5, turn: 1.0, odometry_resolution: 1e-5 }
    }
}

impl ContactOptions {
    /// Checks that every knob is in its range.
    ///
    /// # Errors
    ///
    /// Usage: names the knob, its value and the allowed range.
    pub fn check(&self) -> Result<()> {
        for (name, value, lo, hi) in [
            ("spacing", self.spacing, 0.0, 0.01),
            ("rod_spacing", self.rod_spacing, 0.0, 0.01),
            ("step_std", self.step_std, 1e-7, 1e-2),
            ("turn", self.turn, 1e-3, 1e3),
            ("odometry_resolution", self.odometry_resolution, 0.0, 1e-3),
        ] {
            if !(value >= lo && value <= hi) {
                return Err(Error::usage(format!("the option {name} is out of range"))
                    .value(value)
                    .allowed(format!("{lo} to {hi}")));
            }
        }
        Ok(())
    }
}

/// The knobs of outlines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProfileOptions {
    /// Spacing of an outline's points (m).
    pub resolution: f64,
    /// How near runs of contact are taken to be the same wall (m): several times a sweep's error.
    pub reach: f64,
    /// Largest standard deviation of a contact on an outline (m).
    pub largest_std: f64,
    /// Largest gap within a run (m).
    pub largest_gap: f64,
    /// Fewest contacts of a run.
    pub fewest: usize,
    /// Shortest run (m).
    pub shortest: f64,
}

impl Default for ProfileOptions {
    fn default() -> Self {
        Self { resolution: 0.5e-3, reach: 2e-3, largest_std: 1e-3, largest_gap: 5e-3, fewest: 8, shortest: 2e-3 }
    }
}

impl ProfileOptions {
    /// Checks that every knob is in its range.
    ///
    /// # Errors
    ///
    /// Usage: names the knob, its value and the allowed range.
    pub fn check(&self) -> Result<()> {
        for (name, value, lo, hi) in [
            ("resolution", self.resolution, 1e-5, 0.1),
            ("reach", self.reach, 1e-5, 0.1),
            ("largest_std", self.largest_std, 1e-6, 1.0),
            ("largest_gap", self.largest_gap, 1e-5, 1.0),
            ("shortest", self.shortest, 0.0, 1.0),
        ] {
            if !(value >= lo && value <= hi) {
                return Err(Error::usage(format!("the option {name} is out of range"))
                    .value(value)
                    .allowed(format!("{lo} to {hi} m")));
            }
        }
        Ok(())
    }
}

impl Default for DeterministicOptions {
    fn default() -> Self {
        Self {
            boundary_spacing: 1e-3,
            history_shapes: 5,
            history_travel: 10e-3,
            update_travel: 2e-3,
            tolerance: 4.0,
            heading_floor: 0.05,
            position_floor: 0.7e-3,
            missed_share: 0.25,
            tip_load: TipLoad::default(),
            prior: None,
        }
    }
}

impl DeterministicOptions {
    /// Checks that every knob is in its range.
    ///
    /// # Errors
    ///
    /// Usage: names the knob, its value and the allowed range.
    pub fn check(&self) -> Result<()> {
        check_region(self.prior)?;
        within("boundary_spacing", self.boundary_spacing, 1e-5, limits::COARSEST_SPACING, "m")?;
        within("history_shapes", self.history_shapes as f64, 2.0, 5.0, "shapes")?;
        within("history_travel", self.history_travel, 1e-5, 1.0, "m")?;
        // Shorter updates share all but a hundredth of their readings: time is spent, nothing is learned.
        let least = 0.01 * self.history_travel;
        within(
            "update_travel",
            self.update_travel,
            least,
            self.history_travel,
            "m, a hundredth to all of history_travel",
        )?;
        within("tolerance", self.tolerance, 0.1, 10.0, "standard deviations")?;
        within("heading_floor", self.heading_floor, 0.0, 1.0, "rad")?;
        within("position_floor", self.position_floor, 0.0, 0.1, "m")?;
        within("missed_share", self.missed_share, 0.0, 0.9, "of the observations")
    }
}

/// How the paper's figures and tables are made anew.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReproduceOptions {
    /// Draws of the noise for each sweep of the localization table: enough for a mean and a spread, in a minute.
    pub seeds: usize,
    /// How many of the five sweeps are run.
    pub sweeps: usize,
    /// Trials for each distance of the contact table: the worst of a thousand in all.
    pub trials: usize,
    /// The sections by key; all when empty.
    pub only: Vec<String>,
    /// Threads; as many as the machine has processors when none. The answer does not depend on it.
    pub threads: Option<usize>,
}

impl Default for ReproduceOptions {
    fn default() -> Self {
        Self { seeds: 5, sweeps: 5, trials: 200, only: Vec::new(), threads: None }
    }
}

impl ReproduceOptions {
    /// Checks that every knob is in its range.
    ///
    /// # Errors
    ///
    /// Usage: names the knob, its value and the allowed range.
    pub fn check(&self) -> Result<()> {
        within("seeds", self.seeds as f64, 1.0, 100.0, "draws")?;
        within("sweeps", self.sweeps as f64, 1.0, 5.0, "sweeps")?;
        within("trials", self.trials as f64, 1.0, 10_000.0, "trials")?;
        within("threads", self.threads.unwrap_or(1) as f64, 1.0, 1024.0, "threads")
    }
}

/// How taps are found in a recording and their onsets measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TapOptions {
    /// Least height of a tap over the noise at rest, in standard deviations.
    pub prominence: f64,
    /// Least height of a tap relative to the recording's largest: below lie the swings before and after a tap.
    pub threshold: f64,
    /// How long the reading rests before a tap is over (s).
    pub settle: f64,
    /// Beginning of the stretch before a tap that gives the level of rest (s before the tap): four swings of the shaft.
    pub rest_from: f64,
    /// Its end (s before the tap).
    pub rest_until: f64,
    /// Shortest length over which the ramp's slope is taken (s): three ripples of a touched shaft.
    pub shortest_ramp: f64,
    /// Longest length (s): five hundredths of a second after the onset no stroke is a ramp any more.
    pub longest_ramp: f64,
    /// How many lengths are averaged.
    pub ramp_lengths: usize,
    /// Most that the slopes over these lengths may differ, as a share: what bends more is no ramp.
    pub most_spread: f64,
}

impl Default for TapOptions {
    fn default() -> Self {
        Self {
            prominence: 8.0,
            threshold: 0.25,
            settle: 10e-3,
            rest_from: 190e-3,
            rest_until: 19e-3,
            shortest_ramp: 32.5e-3,
            longest_ramp: 45e-3,
            ramp_lengths: 6,
            most_spread: 0.15,
        }
    }
}

impl TapOptions {
    /// The lengths over which the slope is taken, evenly spaced (s).
    pub fn ramps(&self) -> impl Iterator<Item = f64> {
        let (shortest, span) = (self.shortest_ramp, self.longest_ramp - self.shortest_ramp);
        let last = self.ramp_lengths.saturating_sub(1).max(1) as f64;
        (0..self.ramp_lengths).map(move |i| shortest + span * i as f64 / last)
    }
}

/// How the steps of a staircase recording are measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StaircaseOptions {
    /// Where the level before a step is taken: at the end of the step before, in dwells (its first part still creeps).
    pub before: [f64; 2],
    /// Where the level after a step is taken, in dwells: the first third of a dwell still holds the move.
    pub after: [f64; 2],
    /// Distances that differ by less are one and the same (m): rigs tilt by hundredths of a millimetre.
    pub same_distance: f64,
    /// Fewest rows that give a level.
    pub fewest_rows: usize,
}

impl Default for StaircaseOptions {
    fn default() -> Self {
        Self { before: [0.7, 0.98], after: [0.35, 0.6], same_distance: 1e-3, fewest_rows: 6 }
    }
}

/// How the curve from raw readings to moments is fitted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurveOptions {
    /// Highest degree of the polynomial: a magnet's field is bent, but not in waves.
    pub most_degree: usize,
    /// Fewest labelled contacts: blocks of eight in ten parts leave too little of less.
    pub fewest_contacts: usize,
}

impl Default for CurveOptions {
    fn default() -> Self {
        Self { most_degree: 5, fewest_contacts: 20 }
    }
}

fn within(name: &str, value: f64, lo: f64, hi: f64, unit: &str) -> Result<()> {
    if value >= lo && value <= hi {
        return Ok(());
    }
    Err(Error::usage(format!("the option {name} is out of range")).value(value).allowed(format!("{lo} to {hi} {unit}")))
}

/// The knobs of the probabilistic method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProbabilisticOptions {
    /// Spacing along the boundary of the first hypotheses (m): a few of them lie within the reach of one linearisation.
    pub seed_spacing: f64,
    /// Spacing of their headings (rad).
    pub seed_turn: f64,
    /// Base travel after the first touch before hypotheses start (m): enough to tell most headings apart.
    pub seed_travel: f64,
    /// Base travel between the readings that judge them first (m).
    pub seed_step: f64,
    /// Standard deviation of a relative error that all readings share (gain, stiffness), estimated along; 0 for none.
    ///
    /// None takes a quarter of the declared relative bound: a bound is seldom noise alone, and readings enough show how
    /// large the shared part is.
    pub shared_gain: Option<f64>,
    /// Bound on the error of the log's absolute headings (rad), taken as one error of the whole log.
    pub heading_error: f64,
    /// Where the robot is at the first row, map frame, where that is known: least and largest x (m), y (m), heading (rad).
    pub prior: Option<[[f64; 2]; 3]>,
    /// Rows that are kept and fitted again; what older ones say is summed up as a Gaussian for each hypothesis.
    pub window: usize,
    /// Share of the rows that no equilibrium needs to explain, 0 to 0.5: while the whisker has snapped or touches at three
    /// places, even the true place explains nothing.
    pub tolerated_share: f64,
}

impl Default for ProbabilisticOptions {
    fn default() -> Self {
        Self {
            seed_spacing: 4e-3,
            seed_turn: 0.11,
            seed_travel: 12e-3,
            seed_step: 2e-3,
            shared_gain: None,
            heading_error: 0.05,
            prior: None,
            window: 1000,
            tolerated_share: 0.05,
        }
    }
}

impl ProbabilisticOptions {
    /// Checks that every knob is in its range.
    ///
    /// # Errors
    ///
    /// Usage: names the knob, its value and the allowed range.
    pub fn check(&self) -> Result<()> {
        check_region(self.prior)?;
        within("window", self.window as f64, 200.0, 1e6, "rows")?;
        within("tolerated_share", self.tolerated_share, 0.0, 0.5, "(share of the rows)")?;
        within("heading_error", self.heading_error, 1e-4, core::f64::consts::PI, "rad")?;
        within("seed_spacing", self.seed_spacing, 5e-4, 2e-2, "m")?;
        within("seed_turn", self.seed_turn, 5e-3, 0.2, "rad")?;
        within("seed_travel", self.seed_travel, 2e-3, 1.0, "m")?;
        within("shared_gain", self.shared_gain.unwrap_or(0.0), 0.0, 0.5, "(relative)")?;
        within("seed_step", self.seed_step, 2e-4, self.seed_travel, "m, up to seed_travel")
    }
}

/// Checks a prior region.
fn check_region(region: Option<[[f64; 2]; 3]>) -> Result<()> {
    let wrong = |[lo, hi]: &&[f64; 2]| !(lo <= hi && lo.is_finite() && hi.is_finite());
    match region.as_ref().and_then(|bounds| bounds.iter().find(wrong)) {
        Some([lo, hi]) => Err(Error::usage("the prior region is empty")
            .value(format!("{lo} to {hi}"))
            .allowed("a finite least value, and a largest that is no smaller")),
        None => Ok(()),
    }
}

/// The knobs of the possibilistic method \[routray, section "Possibilistic Method"\]: they trade time for tightness,
/// never for soundness.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PossibilisticOptions {
    /// Most cells that are halved into; the first reading may take more.
    pub most_cells: usize,
    /// How often a cell meets a reading in one update, at most, over all cells.
    pub work: usize,
    /// The same once more at the end of the log, when nobody waits for the next row.
    pub last_work: usize,
    /// Cells smaller than this are not halved (m; headings count by an arm of 0.1 m).
    pub resolution: f64,
    /// Largest slope of a whisker at its contact (rad): what is bent further is ruled out, not searched.
    pub largest_slope: f64,
    /// How many readings the true state may violate.
    pub tolerate: usize,
    /// Bound on the error of an absolute heading in the log (rad).
    pub heading_error: f64,
    /// Where the robot is at the first row, map frame, where that is known: least and largest x (m), y (m), heading (rad).
    pub prior: Option<[[f64; 2]; 3]>,
}

impl Default for PossibilisticOptions {
    fn default() -> Self {
        Self {
            most_cells: 2000,
            work: 130,
            last_work: 5_000_000,
            resolution: 0.4e-3,
            largest_slope: 2.2,
            tolerate: 0,
            heading_error: 0.05,
            prior: None,
        }
    }
}

impl PossibilisticOptions {
    /// Checks that every knob is in its range.
    ///
    /// # Errors
    ///
    /// Usage: names the knob, its value and the allowed range.
    pub fn check(&self) -> Result<()> {
        check_region(self.prior)?;
        within("most_cells", self.most_cells as f64, 1.0, 1e6, "cells")?;
        within("work", self.work as f64, 1.0, 1e7, "meetings a row")?;
        within("last_work", self.last_work as f64, 0.0, 1e9, "meetings")?;
        within("resolution", self.resolution, 1e-5, 0.1, "m")?;
        within("largest_slope", self.largest_slope, 0.1, core::f64::consts::PI, "rad")?;
        within("tolerate", self.tolerate as f64, 0.0, 100.0, "readings")?;
        within("heading_error", self.heading_error, 0.0, core::f64::consts::PI, "rad")
    }
}
