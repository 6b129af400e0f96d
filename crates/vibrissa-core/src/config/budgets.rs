//! What a file may cost: budgets far above real use, checked before memory is taken, so that a hostile or damaged file ends in an
//! error that names the budget.
//!
//! Together they keep every input file below 100 MB within 1 GB of memory and 10 s; `robustness/hostile` measures it.

/// Largest text of a map (bytes): a million points written with 17 digits take 40 MB.
pub const MAP_BYTES: u64 = 64 << 20;
/// Largest image of a map (bytes): [`super::limits::MOST_CELLS`] of them written out in digits take 80 MB.
pub const IMAGE_BYTES: u64 = 256 << 20;
/// Largest YAML file of `map_server` (bytes): they take half a kilobyte.
pub const YAML_BYTES: u64 = 1 << 20;
/// Deepest nesting of lists and mappings in it; `map_server` writes one level.
pub const YAML_DEPTH: usize = 64;
/// Most numbers of a list in it; an origin has three.
pub const YAML_LIST: usize = 64;
/// Largest robot, scenario or setup (bytes of TOML): a path through ten thousand places takes half of it.
pub const TOML_BYTES: u64 = 1 << 20;
/// Deepest nesting of a TOML text, by brackets and by dots in a line; robots have three levels.
pub const TOML_DEPTH: usize = 64;
/// Largest calibration (bytes of JSON): it takes a few kilobytes.
pub const CALIBRATION_BYTES: u64 = 4 << 20;
/// Largest trajectory (bytes): [`super::limits::MOST_LOG_ROWS`] lines.
pub const TRAJECTORY_BYTES: u64 = 1 << 30;
/// Largest recording of a foreign sensor (bytes), which is read as a whole.
pub const FOREIGN_BYTES: u64 = 1 << 29;
/// Largest table of a batch (bytes).
pub const BATCH_BYTES: u64 = 128 << 20;
/// Most rows of a batch: each keeps its fields and its solutions.
pub const MOST_BATCH_ROWS: usize = 500_000;

/// Most pieces (lines, Béziers) of a map: ten kilometres of wall with a vertex every centimetre.
pub const MOST_PIECES: usize = 1 << 20;
/// Most lines that follow a map's curves within a micrometre: a circle of a metre has 2,200.
pub const MOST_FLAT_EDGES: usize = 1 << 21;
/// Most boundaries of a map, and most outlines of one path or layer: which of them lie within which is asked of each pair.
pub const MOST_BOUNDARIES: usize = 1 << 17;
/// Most outlines of one path or one layer, of which each pair is compared.
pub const MOST_OUTLINES: usize = 1 << 13;
/// Most layers of a drawing; CAD programs are used with some ten.
pub const MOST_LAYERS: usize = 1 << 10;
/// Most ends of pieces that meet in one point of a drawing: two, where an outline goes on.
pub const MOST_MEETING: usize = 64;
/// Most groups (pairs of lines) of a DXF drawing.
pub const MOST_GROUPS: usize = 1 << 23;
/// Most entities of a DXF drawing.
pub const MOST_ENTITIES: usize = 1 << 21;

/// Most elements and other nodes of an SVG drawing.
pub const MOST_XML_NODES: usize = 1 << 20;
/// Most attributes of an SVG drawing.
pub const MOST_XML_ATTRIBUTES: usize = 1 << 22;
/// Most attributes of one element, each pair of which is compared; shapes have some ten.
pub const MOST_ELEMENT_ATTRIBUTES: usize = 1 << 10;
/// Most bytes that the entities of an SVG drawing stand for; drawing programs write namespaces by them.
pub const XML_ENTITY_BYTES: usize = 16 << 20;

/// Largest chunk or record of an MCAP recording (bytes): recorders make chunks of a few megabytes.
pub const LARGEST_CHUNK: usize = 1 << 26;
/// A recording may inflate to so many bytes whatever its size,
pub const INFLATED_BYTES: u64 = 1 << 30;
/// and to so many for each byte of the file: logs of numbers inflate to three times their size, constant ones to twenty times.
pub const INFLATED_RATIO: u64 = 20;
/// Most topics of a recording.
pub const MOST_TOPICS: usize = 1 << 10;
/// Most messages that are kept of a recording.
pub const MOST_MESSAGES: usize = 5_000_000;

/// Most columns of a log, and most fields of a line: hundreds of whiskers with all their quantities.
pub const MOST_COLUMNS: usize = 1 << 12;
/// Most numbers of a log, rows times columns: 40 bytes a row and 8 a number are kept.
pub const MOST_NUMBERS: usize = 30_000_000;
/// Most whiskers of a robot: rats have sixty.
pub const MOST_WHISKERS: usize = 1 << 8;
/// Longest name of a column, a topic, a layer, a whisker or a shape (bytes).
pub const LONGEST_NAME: usize = 256;

/// Most moves of nodes that the simulator's discrete rod makes from one rest to the next: a minute or two of work. Of hundreds of drives
/// around corners the slowest snap took 400,000 with 90 links.
pub const MOST_UNREST: u64 = 40_000_000;

/// Most steps along the boundary, over all headings, of a preimage on a page: it is kept waiting for some seconds.
pub const MOST_PAGE_STEPS: u32 = 1 << 22;
