//! Every default and limit of live runs, once, with its unit and its reason.

/// Baud rate of a serial port that names none: that of the paper's firmware.
pub const BAUD: u32 = 115_200;
/// Readings a second of the paper's one sensor without stamps (Hz), and of each of two that take turns.
pub const RATE: f64 = 300.0;
/// Readings a second of each of two sensors that take turns (Hz).
pub const RATE_OF_TWO: f64 = 150.0;

/// Longest line of a stream (bytes): a longer one is noise, or another baud rate.
pub const LONGEST_LINE: usize = 4096;
/// Most bytes of one read: what a serial line brings in a third of a second at 115200 baud.
pub const READ_SIZE: usize = 4096;
/// Chunks of bytes between sources and the join: four seconds of a kilohertz of single lines. A source then waits, and its
/// port's own buffer fills.
pub const CHUNKS_WAITING: usize = 4096;
/// How long a source waits for bytes before it looks whether it is to end (s).
pub const READ_PATIENCE: f64 = 0.1;
/// How long a source that has gone waits before it is opened again (s).
pub const REOPEN: f64 = 0.5;

/// Frames with which a clock begins to be believed, at least so long (s): the first arrivals of a port come in bursts.
pub const WARM_UP: f64 = 0.4;
/// How far back arrivals are kept for a clock (s): at 50 ppm a crystal drifts by half a millisecond within it,
pub const CLOCK_SPAN: f64 = 10.0;
/// and one arrival of each so long (s): the least delayed one.
pub const CLOCK_BIN: f64 = 0.1;
/// Largest relative error of a device's clock: a crystal's is 1e-4, an oscillator without one has 2 %.
pub const LARGEST_DRIFT: f64 = 1e-3;
/// The same where time is counted in readings at a nominal rate.
pub const LARGEST_RATE_ERROR: f64 = 0.05;
/// A device clock that leaves its line by more (s) was set anew.
pub const CLOCK_JUMP: f64 = 1.0;
/// A pause of a stream without stamps (s) after which its count starts anew.
pub const COUNT_PAUSE: f64 = 0.2;

/// How long a reading waits for odometry and other readings after it (s), and how far apart two odometry messages may be
/// to interpolate between.
pub const PATIENCE: f64 = 0.25;
/// Frames of one stream that wait to be joined: at 1 kHz those of two seconds.
pub const FRAMES_WAITING: usize = 2048;

/// Rows that wait for the estimator: with more the newest stands for all.
pub const ROWS_BEFORE_MERGING: usize = 32;
/// Rows between join and estimator at most: those of two seconds at 1 kHz.
pub const ROWS_WAITING: usize = 2048;
/// How long a row waits for the estimator (s) before its pose is the last estimate carried on by odometry: half of what a
/// control loop at 300 Hz leaves.
pub const CARRY_AFTER: f64 = 2e-3;
/// Estimates a second of row time that are written (Hz).
pub const ESTIMATE_RATE: f64 = 20.0;
/// Places of an estimate that are told one by one.
pub const PLACES_TOLD: usize = 8;

/// How often the recording is handed to the system (s): `kill -9` loses no more than this.
pub const WRITE: f64 = 0.05;
/// How often it is synchronised with the disk (s): a power cut loses no more than this, [`WRITE`], and the time that the disk takes.
pub const SYNC: f64 = 0.2;
/// Memory of what waits for the disk (bytes): six minutes of the paper's sensor. What comes on top is dropped and counted.
pub const RECORD_WAITING: usize = 32 << 20;
/// How long a full disk is left alone before it is tried again (s).
pub const DISK_RETRY: f64 = 1.0;

/// Share of the lines of a stretch that may be damaged before the words say that this is no such stream,
pub const DAMAGED_SHARE: f64 = 0.5;
/// of at least so many lines.
pub const FEWEST_LINES: u64 = 50;
/// Lines after which a stretch of a stream is looked at: a third of a second of the paper's sensor.
pub const STRETCH: u64 = 100;
/// Share of its frames that are missing before the words say so: of fewer the count alone tells,
pub const MISSING_SHARE: f64 = 0.1;
/// and with at most so many a stretch is whole again, so that the next fault is told anew.
pub const WHOLE_SHARE: f64 = 0.01;
/// Bytes without the end of a line before the words say that these are none (bytes): six seconds at 115200 baud.
pub const ENDLESS: u64 = 64 * 1024;
/// Readings that are all zero on end (frames) before the words say that the sensor is silent.
pub const ZEROS: u64 = 300;

/// Points of a bent whisker that viewers draw: chords off by less than a pixel.
pub const SHAPE_POINTS: usize = 25;
/// To what its points are told (m).
pub const SHAPE_DIGIT: f64 = 1e-6;
/// Messages that wait to be made ready for viewers: some rows and an estimate each twentieth of a second; with more they miss some.
pub const VIEW_WAITING: usize = 4096;
