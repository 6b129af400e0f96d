//! The maps of ROS `map_server`: a YAML file beside a PGM or PNG image.

use super::keys::{Fault, Keys};
use super::picture::Picture;
use super::{Cell, OccupancyGrid};
use crate::config::budgets::{IMAGE_BYTES, YAML_BYTES};
use crate::plane::Pose2;
use crate::text::{read_bytes, read_text};
use crate::{Error, Result};
use std::path::{Path, PathBuf};

/// What the shade of a pixel means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Mode {
    /// Solid, free or unknown, by two thresholds.
    Trinary,
    /// As solid as the shade says between the thresholds.
    Scale,
    /// The shade's number is the percentage.
    Raw,
}

/// The keys of the YAML file with their values.
#[derive(Debug)]
struct Entries {
    image: String,
    resolution: f64,
    origin: Vec<f64>,
    negate: Option<String>,
    occupied_thresh: f64,
    free_thresh: f64,
    mode: Option<String>,
}

impl Entries {
    fn read(text: &str) -> core::result::Result<Self, Fault> {
        let wanted = ["image", "resolution", "origin", "negate", "occupied_thresh", "free_thresh", "mode"];
        let keys = Keys::read(text, &wanted)?;
        let missing = |key: &str| Fault { line: 1, why: format!("{key} is missing") };
        let text = |key: &str| Ok(keys.text(key)?.map(str::to_owned));
        Ok(Self {
            image: text("image")?.ok_or_else(|| missing("image"))?,
            resolution: keys.number("resolution")?.ok_or_else(|| missing("resolution"))?,
            origin: keys.numbers("origin")?.ok_or_else(|| missing("origin"))?,
            negate: text("negate")?,
            occupied_thresh: keys.number("occupied_thresh")?.unwrap_or(0.65),
            free_thresh: keys.number("free_thresh")?.unwrap_or(0.25),
            mode: text("mode")?,
        })
    }
}

/// The shade by which `map_saver` marks unknown cells.
const UNKNOWN_SHADE: u8 = 205;

/// What a map's YAML file says about its image.
#[derive(Clone, Debug, PartialEq)]
pub struct MapServerFile {
    /// The image's path as written, relative to the YAML file.
    pub image: PathBuf,
    resolution: f64,
    map_from_grid: Pose2,
    negate: bool,
    occupied: f64,
    free: f64,
    mode: Mode,
}

impl OccupancyGrid {
    /// Reads a map of ROS `map_server`: a YAML file and the image that it names.
    ///
    /// # Errors
    ///
    /// A file that cannot be read, or a fault in one of them; the message names file and remedy.
    pub fn read_map_server(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        let file = MapServerFile::parse(&read_text(path, "map", YAML_BYTES)?, &path.to_string_lossy())?;
        let image = file.image_beside(path);
        let bytes = read_bytes(&image, "map image", IMAGE_BYTES)?;
        file.grid(&bytes, &image.to_string_lossy())
    }
}

impl MapServerFile {
    /// What a YAML text says; `name` stands for the file in messages.
    ///
    /// # Errors
    ///
    /// What is not YAML, a key that is missing or out of range.
    pub fn parse(text: &str, name: &str) -> Result<Self> {
        let keys = Entries::read(text).map_err(|Fault { line, why }| {
            Error::data("not a map_server file").in_file(name).at_line(line).value(why).remedy(
                "it needs the keys image, resolution and origin, and may have negate, occupied_thresh, free_thresh, mode",
            )
        })?;
        Self::check(keys).map_err(|error| error.in_file(name).or_remedy("correct it, or save the map again"))
    }

    /// Where the image is when the YAML file is at `path`.
    pub(crate) fn image_beside(&self, path: &Path) -> PathBuf {
        path.parent().unwrap_or(Path::new("")).join(&self.image)
    }

    fn check(keys: Entries) -> Result<Self> {
        let wrong = |key: &str, value: &dyn core::fmt::Display, allowed: &str| {
            Err(Error::data(format!("{key} is out of range")).value(value).allowed(allowed))
        };
        let [x, y, yaw] = match keys.origin[..] {
            [x, y] => [x, y, 0.0],
            [x, y, yaw] => [x, y, yaw],
            _ => return wrong("origin", &format!("{} numbers", keys.origin.len()), "[x, y, yaw] in m, m, rad"),
        };
        if ![x, y, yaw].iter().all(|v| v.abs() <= crate::config::limits::LARGEST_COORDINATE) {
            return wrong("origin", &format!("[{x}, {y}, {yaw}]"), "-1e5 to 1e5");
        }
        if !(keys.resolution >= 1e-5 && keys.resolution <= 1e3) {
            return wrong("resolution", &keys.resolution, "1e-5 to 1000 m a cell");
        }
        let (free, occupied) = (keys.free_thresh, keys.occupied_thresh);
        if !(0.0 <= free && free < occupied && occupied <= 1.0) {
            let value = format!("free_thresh {free}, occupied_thresh {occupied}");
            return wrong("a threshold", &value, "0 <= free_thresh < occupied_thresh <= 1");
        }
        let negate = match keys.negate.as_deref().map(str::trim) {
            None | Some("0" | "false" | "False" | "no" | "") => false,
            Some("1" | "true" | "True" | "yes") => true,
            Some(other) => return wrong("negate", &other, "0 or 1"),
        };
        let mode = match keys.mode.as_deref() {
            None | Some("trinary") => Mode::Trinary,
            Some("scale") => Mode::Scale,
            Some("raw") => Mode::Raw,
            Some(other) => return wrong("mode", &other, "trinary, scale or raw"),
        };
        let map_from_grid = Pose2::new(x, y, yaw);
        Ok(Self { image: keys.image.into(), resolution: keys.resolution, map_from_grid, negate, occupied, free, mode })
    }

    /// The grid in the bytes of an image (PGM or PNG); `name` stands for the image in messages.
    ///
    /// As `map_server` has it, a cell is solid above `occupied_thresh`, free below `free_thresh` and unknown between. But
    /// a cell between that has both a solid and a free neighbour is partly solid, as its shade says: it is the grey of a
    /// smooth drawing. The shade 205, by which `map_saver` marks unknown cells, stays unknown beside another such cell.
    ///
    /// # Errors
    ///
    /// What is not such an image, is damaged, or has more than 16 million pixels.
    pub fn grid(&self, bytes: &[u8], name: &str) -> Result<OccupancyGrid> {
        let Picture { width, pixels } = Picture::read(bytes).map_err(|error| error.in_file(name))?;
        // The first row of an image is at the top, that of a grid at the bottom.
        let pixels: Vec<[u8; 2]> = pixels.chunks(width.max(1)).rev().flatten().copied().collect();
        let height = pixels.len() / width.max(1);
        let cells = match self.mode {
            Mode::Trinary => self.trinary(&pixels, width),
            Mode::Scale => pixels.iter().map(|&pixel| self.scaled(pixel)).collect(),
            Mode::Raw => pixels.iter().map(|&[shade, _]| percent(shade)).collect(),
        };
        Ok(OccupancyGrid { width, height, resolution: self.resolution, map_from_grid: self.map_from_grid, cells })
    }

    /// How likely a shade is solid.
    fn occupancy(&self, shade: u8) -> f64 {
        let light = f64::from(shade) / 255.0;
        if self.negate { light } else { 1.0 - light }
    }

    fn scaled(&self, [shade, opacity]: [u8; 2]) -> Cell {
        if opacity < u8::MAX {
            return Cell::Unknown;
        }
        let share = (self.occupancy(shade) - self.free) / (self.occupied - self.free);
        Cell::Solid(share.clamp(0.0, 1.0) as f32)
    }

    fn trinary(&self, pixels: &[[u8; 2]], width: usize) -> Vec<Cell> {
        let class = |shade: u8| {
            let occupancy = self.occupancy(shade);
            if occupancy > self.occupied {
                Some(true)
            } else if occupancy < self.free {
                Some(false)
            } else {
                None
            }
        };
        let height = pixels.len() / width.max(1);
        let cell = |index: usize| {
            let (x, y) = (index % width, index / width);
            let (xs, ys) = (x.saturating_sub(1)..(x + 2).min(width), y.saturating_sub(1)..(y + 2).min(height));
            let around = ys.flat_map(|y| xs.clone().map(move |x| y * width + x));
            let shade = pixels[index][0];
            let (mut solid, mut free, mut between, mut unknown) = (false, false, false, false);
            for neighbour in around {
                unknown |= neighbour != index && shade == UNKNOWN_SHADE && pixels[neighbour][0] == UNKNOWN_SHADE;
                match class(pixels[neighbour][0]) {
                    Some(true) => solid = true,
                    Some(false) => free = true,
                    None => between = true,
                }
            }
            let grey = Cell::Solid(self.occupancy(shade) as f32);
            match class(shade) {
                None if !unknown && solid && free => grey,
                None => Cell::Unknown,
                Some(true) => {
                    if free || between {
                        grey
                    } else {
                        Cell::Solid(1.0)
                    }
                }
                Some(false) => {
                    if solid || between {
                        grey
                    } else {
                        Cell::Solid(0.0)
                    }
                }
            }
        };
        (0..pixels.len()).map(cell).collect()
    }
}

fn percent(shade: u8) -> Cell {
    if shade <= 100 { Cell::Solid(f32::from(shade) / 100.0) } else { Cell::Unknown }
}
