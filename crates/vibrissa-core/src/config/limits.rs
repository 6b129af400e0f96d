//! Tolerances of the geometry, and the limits beyond which a file is taken to be in the wrong unit.

/// Largest distance between a map's curve and the chain of lines that stands for it in look-ups (m): a micrometre.
pub const FLATTEN_TOLERANCE: f64 = 1e-6;
pub use vibrissa_beam::config::ARC_TOLERANCE;
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
/// Most boundary that the probabilistic method searches without a region for the first pose (m): a metre takes some tenths of a second.
pub const MOST_SEARCHED: f64 = 100.0;
/// Most boundary that the possibilistic method lays cells along without one (m): a metre takes a millisecond and half a megabyte.
pub const MOST_COVERED: f64 = 1_500.0;
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
/// Longest time between most rows of a log that raises no doubt (s): whiskers are read hundreds of times a second, and at a
/// hundred hertz milliseconds are 10 apart.
pub const SLOW_SAMPLING: f64 = 0.9;
/// Latest time of a row that raises no doubt (s): the year 5138 since 1970, and 1973 in milliseconds.
pub const LATEST_TIME: f64 = 1e11;
/// Largest speed in most rows of a log that raises no doubt (m/s): no robot touches walls that fast.
pub const FASTEST_ROBOT: f64 = 15.0;
/// Largest distance of a whisker's base from the robot's origin that raises no doubt (m).
pub const FARTHEST_MOUNT: f64 = 2.0;
/// Smallest size of a map that raises no doubt, in lengths of the longest whisker.
pub const SMALLEST_MAP: f64 = 1.0;
/// Largest distance of a map from its origin that raises no doubt, in sizes of the map: as a geographic one.
pub const FARTHEST_MAP: f64 = 20.0;
/// Largest moment of a whisker that raises no doubt (N m): hundreds of times the paper's readings.
pub const LARGEST_MOMENT: f64 = 1.0;
/// Most cells of a grid map: a quarter of a square kilometre at 5 cm, and 200 MB while it is traced.
pub const MOST_CELLS: usize = 1 << 24;
/// Most borders between solid and free cells of a grid map: more is noise, not walls.
pub const MOST_CROSSINGS: usize = 1 << 20;
/// Longest gap between two messages of odometry that is bridged without a word (s): robots send some ten a second.
pub const ODOMETRY_GAP: f64 = 0.25;
/// Farthest that a steered robot moves from one simulated pose to the next (m): along the way its whiskers are looked at every tenth of
/// a millimetre, and 10 m take a tenth of a second.
pub const LONGEST_DRIVE_STEP: f64 = 10.0;
