//! The map in a recording.

use super::{Kind, decode_grid, read_bag};
use crate::grid::OccupancyGrid;
use crate::text::open;
use crate::{Error, Result};
use std::io::Read;
use std::path::Path;

/// The last `nav_msgs/OccupancyGrid` of a recording.
///
/// # Errors
///
/// A file that cannot be read, is damaged, or holds no such message; grids on several topics.
pub fn read_grid(path: &Path) -> Result<OccupancyGrid> {
    grid_in(open(path, "map")?, &path.to_string_lossy())
}

/// The last `nav_msgs/OccupancyGrid` of a recording that is read from somewhere; `name` stands for the file in messages.
///
/// # Errors
///
/// As [`read_grid`].
pub fn grid_in(source: impl Read, name: &str) -> Result<OccupancyGrid> {
    let mut found: Option<(String, OccupancyGrid)> = None;
    read_bag(source, name, |topic, _, bytes| {
        if topic.kind != Some(Kind::Grid) {
            return Ok(());
        }
        let (_, grid) = decode_grid(bytes).ok_or_else(|| {
            Error::data(format!("a message of {} is damaged", topic.name)).remedy("record the map again")
        })?;
        match &found {
            Some((name, _)) if *name != topic.name => Err(Error::data("the recording holds several maps")
                .value(format!("{name}, {}", topic.name))
                .remedy("`mcap filter` keeps one of the topics")),
            _ => {
                found = Some((topic.name.clone(), grid));
                Ok(())
            }
        }
    })?;
    found.map(|(_, grid)| grid).ok_or_else(|| {
        Error::data("the recording holds no map")
            .in_file(name)
            .allowed("a topic of nav_msgs/msg/OccupancyGrid")
            .remedy("give a map file: .geojson, .svg or .yaml")
    })
}
