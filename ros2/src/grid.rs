//! Maps as `nav_msgs/OccupancyGrid`, both ways.

use crate::config::{FINEST_CELL, MOST_MAP_CELLS};
use crate::messages::{Header, MapMetaData, OccupancyGrid, Pose, Time};
use vibrissa_core::config::GridOptions;
use vibrissa_core::plane::{Pose2, Vec2};
use vibrissa_core::world::Map;
use vibrissa_core::{Error, Result};
use vibrissa_io::grid::{self, Cell};

/// The map whose boundaries are those between the solid and the free cells of a message, traced as those of a `map_server` file.
///
/// # Errors
///
/// A grid without boundaries or with too many cells, an origin or a resolution that makes no sense.
pub fn map_of(message: &OccupancyGrid) -> Result<Map> {
    let info = &message.info;
    let map_from_grid = info.origin.plane().ok_or_else(|| {
        Error::data("the origin is no pose in the plane").remedy("its quaternion must have the length 1")
    })?;
    let cell = |&value: &i8| if value < 0 { Cell::Unknown } else { Cell::Solid(f32::from(value.min(100)) / 100.0) };
    let grid = grid::OccupancyGrid {
        width: info.width as usize,
        height: info.height as usize,
        resolution: decimal(info.resolution),
        map_from_grid,
        cells: message.data.iter().map(cell).collect(),
    };
    grid::from_grid(&grid, &GridOptions::default()).map_err(|error| error.about("the topic of the map"))
}

/// The number that was meant: 0.05 in 32 bits is 0.05000000074506.
fn decimal(value: f32) -> f64 {
    value.to_string().parse().unwrap_or(f64::from(value))
}

/// The map as a grid for viewers: cells whose middle is free or not, as fine as their number allows.
#[must_use]
pub fn message(map: &Map, frame: &str) -> OccupancyGrid {
    let bounds = map.bounds();
    let (width, height) = (bounds.max.x - bounds.min.x, bounds.max.y - bounds.min.y);
    let size = (width * height / MOST_MAP_CELLS).sqrt().max(FINEST_CELL);
    // One row of cells beyond each side, so that the outer walls are seen.
    let count = |length: f64| (length / size).ceil() as usize + 2;
    let (columns, rows) = (count(width), count(height));
    let corner = bounds.min - Vec2::new(size, size);
    let middle = |index: usize| (index as f64 + 0.5) * size;
    let mut data = Vec::with_capacity(columns * rows);
    for row in 0..rows {
        for column in 0..columns {
            let free = map.is_free(corner + Vec2::new(middle(column), middle(row)));
            data.push(if free { 0 } else { 100 });
        }
    }
    OccupancyGrid {
        header: Header { stamp: Time::default(), frame_id: frame.to_owned() },
        info: MapMetaData {
            map_load_time: Time::default(),
            resolution: size as f32,
            width: columns as u32,
            height: rows as u32,
            origin: Pose::from(Pose2::new(corner.x, corner.y, 0.0)),
        },
        data,
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]
mod tests {
    use super::{map_of, message};
    use crate::messages::{MapMetaData, OccupancyGrid, Pose};
    use vibrissa_core::plane::{Pose2, Vec2};

    /// A room of 2 m by 1 m whose corner is at (1, 2), walls of one cell.
    fn room() -> OccupancyGrid {
        let (width, height) = (42, 22);
        let wall = |i: usize, k: usize| i == 0 || k == 0 || i == width - 1 || k == height - 1;
        let data = (0..width * height).map(|n| if wall(n % width, n / width) { 100 } else { 0 }).collect();
        let info = MapMetaData {
            resolution: 0.05,
            width: width as u32,
            height: height as u32,
            origin: Pose::from(Pose2::new(0.95, 1.95, 0.0)),
            ..MapMetaData::default()
        };
        OccupancyGrid { info, data, ..OccupancyGrid::default() }
    }

    #[test]
    fn a_grid_becomes_the_room_that_it_shows() {
        let map = map_of(&room()).unwrap();
        for (point, free) in [([1.01, 2.01], true), ([2.99, 2.99], true), ([0.99, 2.5], false), ([3.01, 2.5], false)] {
            assert_eq!(map.is_free(Vec2::new(point[0], point[1])), free, "{point:?}");
        }
        // The wall is where the cells end, to what 32 bits leave.
        let foot = map.foot(Vec2::new(1.1, 2.4), 1.0).unwrap();
        assert!((foot.position.x - 1.0).abs() < 1e-6 && (foot.position.y - 2.4).abs() < 1e-6, "{foot:?}");
    }

    #[test]
    fn what_viewers_see_is_the_map_again() {
        let map = map_of(&room()).unwrap();
        let again = map_of(&message(&map, "map")).unwrap();
        for (x, y) in [(1.02, 2.5), (2.0, 2.02), (0.97, 2.5), (2.0, 3.03)] {
            let point = Vec2::new(x, y);
            assert_eq!(again.is_free(point), map.is_free(point), "{x} {y}");
        }
    }

    #[test]
    fn grids_that_cannot_be_are_refused_with_a_reason() {
        let turned = Pose { orientation: Default::default(), ..Pose::default() };
        let info = room().info;
        for (grid, word) in [
            (OccupancyGrid { data: vec![0; 7], ..room() }, "cells"),
            (OccupancyGrid { data: vec![100; 42 * 22], ..room() }, "boundary"),
            (OccupancyGrid { info: MapMetaData { resolution: f32::NAN, ..info.clone() }, ..room() }, "resolution"),
            (OccupancyGrid { info: MapMetaData { origin: turned, ..info }, ..room() }, "origin"),
        ] {
            let error = map_of(&grid).map(|_| ()).unwrap_err().to_string();
            assert!(error.contains(word), "{error}");
        }
    }
}
