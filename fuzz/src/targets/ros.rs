//! The files of ROS: grid maps with their images, and recordings.

use super::readers::map;
use super::{Verdict, promise, read, refused, size};
use crate::random::Random;
use vibrissa::config::GridOptions;
use vibrissa::io::grid::{Cell, MapServerFile, OccupancyGrid};
use vibrissa::plane::Pose2;

pub(crate) const YAML_WORDS: &[&str] = &[
    "image: a.pgm\n",
    "resolution: ",
    "origin: [0, 0, 0]\n",
    "negate: 1\n",
    "mode: scale\n",
    "mode: raw\n",
    "occupied_thresh: ",
    "free_thresh: ",
    "&a ",
    "*a",
    "[[[[",
    "---\n",
    "!!binary ",
    "\n%%\n",
    "P5\n",
    "P2\n",
    "P5\n60000 60000\n255\n",
    "99999",
    "255\n",
    "65535\n",
    "#",
    ".nan",
    ".inf",
];

pub(crate) const MCAP_WORDS: &[&str] =
    &["lz4", "zstd", "cdr", "ros2msg", "/odom", "nav_msgs/msg/Odometry", "\0\0\0\0\0\0\0\0"];

/// A YAML text, a line `%%`, then the image.
pub(crate) fn map_server(bytes: &[u8]) -> Verdict {
    const BETWEEN: &[u8] = b"\n%%\n";
    let at = bytes.windows(BETWEEN.len()).position(|w| w == BETWEEN).unwrap_or(bytes.len());
    let (text, image) = (&bytes[..at], bytes.get(at + BETWEEN.len()..).unwrap_or_default());
    let file = match MapServerFile::parse(&String::from_utf8_lossy(text), "map.yaml") {
        Err(error) => return refused(&error),
        Ok(file) => file,
    };
    match file.grid(image, "map.pgm") {
        Err(error) => refused(&error),
        Ok(grid) => traced(&grid),
    }
}

/// Cells of any shade: smooth hills, noise and stripes.
pub(crate) fn draw_grid(random: &mut Random) -> Vec<u8> {
    let width = 1 + random.below(24);
    let height = 1 + random.below(24);
    let mut bytes = vec![width as u8];
    let kind = random.below(4);
    for index in 0..width * height {
        let (x, y) = (index % width, index / width);
        bytes.push(match kind {
            0 => random.below(256) as u8,
            1 => {
                if random.below(3) == 0 {
                    100
                } else {
                    0
                }
            }
            2 => ((x * 13 + y * 29) % 101) as u8,
            _ => {
                if (x + y) % 2 == 0 {
                    100
                } else {
                    random.below(102) as u8
                }
            }
        });
    }
    bytes
}

pub(crate) fn grid(bytes: &[u8]) -> Verdict {
    let (width, cells) = bytes.split_first().unwrap_or((&1, &[]));
    let width = usize::from(*width).max(1);
    let height = cells.len() / width;
    let cell = |&value: &u8| if value <= 100 { Cell::Solid(f32::from(value) / 100.0) } else { Cell::Unknown };
    let cells: Vec<Cell> = cells[..width * height].iter().map(cell).collect();
    traced(&OccupancyGrid { width, height, resolution: 0.05, map_from_grid: Pose2::new(1.0, -2.0, 0.5), cells })
}

/// Whatever unknown cells mean, what is traced is sound, and the middles of plainly free cells are free.
fn traced(grid: &OccupancyGrid) -> Verdict {
    let open = vibrissa::io::map::from_grid(grid, &GridOptions { unknown_is_free: true, ..GridOptions::default() });
    if let Err(error) = &open {
        refused(error)?;
    }
    map(vibrissa::io::map::from_grid(grid, &GridOptions::default()))
}

pub(crate) fn mcap(bytes: &[u8]) -> Verdict {
    let log = match vibrissa::io::log::from_mcap(bytes, "log.mcap") {
        Err(error) => return refused(&error),
        Ok(log) => log,
    };
    let increasing = log.rows.windows(2).all(|w| w[0].t < w[1].t);
    promise(increasing, || "a recording whose clock does not increase was read".into())?;
    let whole = log.rows.iter().all(|row| {
        let pose = row.odom_from_robot;
        let numbers = [row.t, pose.x, pose.y, pose.theta];
        numbers.iter().chain(&row.readings).all(|v| v.is_finite()) && row.readings.len() == log.channels.len()
    });
    promise(whole && !log.rows.is_empty(), || "a recording with gaps was read".into())?;
    read((size(log.rows.len()), log.channels.len(), log.warnings.len()))
}
