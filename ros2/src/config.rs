//! Defaults and limits of the node, each with its unit and its reason.

/// Messages that a subscription of sensor data keeps: half a second of 100 Hz, in case the node is scheduled late.
pub const SENSOR_DEPTH: usize = 50;
/// Messages that a publisher keeps.
pub const DEPTH: usize = 10;
/// How often the heart beats (s): transforms at 20 Hz, as base controllers look them up.
pub const BEAT: f64 = 0.05;
/// How often the bond tells that the node lives (s): the period that Nav2's nodes have,
pub const BOND_PERIOD: f64 = 0.1;
/// and after how much silence it counts as broken (s), as Nav2's.
pub const BOND_TIMEOUT: f64 = 4.0;
/// How often diagnostics are told (s): what aggregators expect.
pub const DIAGNOSTICS_PERIOD: f64 = 1.0;
/// By how much transforms are dated ahead (s): the default of Nav2's AMCL.
pub const TRANSFORM_TOLERANCE: f64 = 1.0;
/// Half width of the region of an initial pose in standard deviations.
pub const REGION_DEVIATIONS: f64 = 3.0;
/// Least half width of that region (m): a pose that says no covariance is meant so exactly,
pub const LEAST_REGION: f64 = 0.05;
/// and in heading (rad).
pub const LEAST_TURN: f64 = 0.1;
/// Places in `particle_cloud` at most.
pub const MOST_PLACES: usize = 2000;
/// Readings or odometry older than this (s) make the diagnostics warn.
pub const STALE: f64 = 1.0;
/// Cells of the grid that viewers get of a map at most: those of 10 m by 10 m at 1 cm, a megabyte on the wire,
pub const MOST_MAP_CELLS: f64 = 1e6;
/// and their least side (m): finer than a whisker tells walls.
pub const FINEST_CELL: f64 = 5e-4;
/// Largest file of parameters (bytes).
pub const PARAMETERS_BYTES: u64 = 1 << 20;
/// Deepest nesting of such a file.
pub const PARAMETERS_DEPTH: usize = 32;
