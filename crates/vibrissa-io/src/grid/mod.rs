//! Maps as grids of cells: occupancy grids and what is traced from them.
//!
//! | file | what it knows |
//! | --- | --- |
//! | `trace` | the loops between solid and free cells, and where in its cells each crossing lies |
//! | `outline` | few straight lines through the many points of a loop |
//! | `yaml` | the files of ROS `map_server` |
//! | `keys` | the keys of such a file |
//! | `picture` | the image that it names |
//! | `pnm` | images that are PBM, PGM or PPM |
//! | `portable_network` | images that are PNG; in a page none |

#[cfg(feature = "ros-map")]
mod keys;
mod outline;
#[cfg(feature = "ros-map")]
mod picture;
#[cfg(feature = "ros-map")]
mod pnm;
#[cfg(all(feature = "ros-map", not(target_family = "wasm")))]
mod portable_network;
#[cfg(all(feature = "ros-map", target_family = "wasm"))]
#[path = "no_portable_network.rs"]
mod portable_network;
mod trace;
#[cfg(feature = "ros-map")]
mod yaml;

#[cfg(feature = "ros-map")]
pub use yaml::MapServerFile;

use crate::config::GridOptions;
use crate::config::limits::{MOST_CELLS, MOST_CROSSINGS};
use crate::plane::{Curve, Pose2, Vec2};
use crate::world::{Boundary, Map, Role};
use crate::{Error, Result};

/// What is known of a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cell {
    /// The share of the cell that is solid, from 0 to 1.
    Solid(f32),
    /// Nothing is known.
    Unknown,
}

/// A map as a grid of square cells.
#[derive(Clone, Debug, PartialEq)]
pub struct OccupancyGrid {
    /// Cells along the grid's x.
    pub width: usize,
    /// Cells along the grid's y.
    pub height: usize,
    /// Side of a cell (m).
    pub resolution: f64,
    /// The grid's frame, whose origin is the outer corner of the first cell, in the map frame.
    pub map_from_grid: Pose2,
    /// The cells row by row, along x first, the row with the least y first.
    pub cells: Vec<Cell>,
}

impl OccupancyGrid {
    /// Checks size, resolution and origin.
    fn check(&self) -> Result<()> {
        if self.width.checked_mul(self.height) != Some(self.cells.len()) || self.cells.is_empty() {
            return Err(Error::data("the grid has no cells, or not as many as its size says")
                .value(format!("{} by {}, {} cells", self.width, self.height, self.cells.len()))
                .remedy("save the map again"));
        }
        if self.cells.len() > MOST_CELLS {
            return Err(Error::data("the grid is too large")
                .value(format!("{} by {} cells", self.width, self.height))
                .allowed(format!("up to {MOST_CELLS} cells"))
                .remedy("cut out the part of the map that the robot can be in"));
        }
        if !(self.resolution >= 1e-5 && self.resolution <= 1e3) {
            return Err(Error::data("the resolution is out of range")
                .value(format!("{} m", self.resolution))
                .allowed("1e-5 to 1000 m a cell")
                .remedy("it is the side of a cell in metres"));
        }
        if !(self.map_from_grid.position().is_finite() && self.map_from_grid.theta.is_finite()) {
            return Err(Error::data("the origin is not finite").remedy("it is [x, y, yaw] in m and rad"));
        }
        Ok(())
    }

    /// The share of each cell that is solid, and how long free cells border on unknown ones (cells).
    fn shares(&self, unknown: f32) -> (Vec<f32>, usize) {
        let share = |cell: &Cell| match cell {
            Cell::Solid(share) => share.clamp(0.0, 1.0),
            Cell::Unknown => unknown,
        };
        let free = |cell: &Cell| matches!(cell, Cell::Solid(share) if *share < 0.5);
        let frontier = |a: &Cell, b: &Cell| (free(a) && *b == Cell::Unknown) || (free(b) && *a == Cell::Unknown);
        let along = self.cells.chunks(self.width).flat_map(|row| row.windows(2)).filter(|w| frontier(&w[0], &w[1]));
        let across = self.cells.iter().zip(self.cells.iter().skip(self.width)).filter(|(a, b)| frontier(a, b));
        (self.cells.iter().map(share).collect(), along.count() + across.count())
    }
}

/// The map whose boundaries are traced from a grid.
///
/// A cell's share is taken for the part of it that is solid, so that the grey of smooth drawings places a boundary
/// within its cell: to a hundredth of a cell along straight walls. Where cells are all solid or all free, a straight
/// wall is found to within half a cell. Loops are simplified by lines that miss none of their points by more than
/// [`GridOptions::grey_tolerance`] or [`GridOptions::sharp_tolerance`] of a cell; corners are where lines meet.
/// Cells of which nothing is known, and all that is outside the grid, are solid unless the options say otherwise.
///
/// # Errors
///
/// A grid without any boundary, with more than 16 million cells, or with as many boundaries as noise has.
pub fn from_grid(grid: &OccupancyGrid, options: &GridOptions) -> Result<Map> {
    grid.check()?;
    let unknown = if options.unknown_is_free { 0.0 } else { 1.0 };
    let (shares, frontier) = grid.shares(unknown);
    let field = trace::Field { width: grid.width, height: grid.height, shares: &shares, outside: unknown };
    let loops = trace::loops(&field, MOST_CROSSINGS).ok_or_else(|| {
        Error::data("the grid has too much boundary: is it an image of something else than a map?")
            .allowed(format!("up to {MOST_CROSSINGS} borders between solid and free cells"))
            .remedy("smooth the image, or check the thresholds")
    })?;
    let mut boundaries = Vec::new();
    for one in &loops {
        boundaries.push(boundary(grid, one, options)?);
    }
    if boundaries.is_empty() {
        return Err(Error::data("the grid has no boundary: all of it is solid, or all of it is free or unknown")
            .remedy("check the thresholds and `negate`"));
    }
    let mut map = Map::new(boundaries)?;
    let total: usize = loops.iter().map(|one| one.crossings.len()).sum();
    if frontier * 20 > total && !options.unknown_is_free {
        map.warnings.push(format!(
            "{:.1} m of the boundary is where free cells meet unknown ones; they are taken for solid",
            frontier as f64 * grid.resolution
        ));
    }
    Ok(map)
}

/// One boundary from one loop: by its lines, or where those cross each other, by the sides of the cells.
fn boundary(grid: &OccupancyGrid, one: &trace::Loop, options: &GridOptions) -> Result<Boundary> {
    let fitted = outline::fit(&one.crossings, options);
    made(grid, one, &fitted).or_else(|_| made(grid, one, &one.corners))
}

fn made(grid: &OccupancyGrid, one: &trace::Loop, corners: &[Vec2]) -> Result<Boundary> {
    let place = |p: &Vec2| grid.map_from_grid.transform_point(*p * grid.resolution);
    let mut points: Vec<Vec2> = corners.iter().map(place).collect();
    points.dedup();
    let curve = Curve::polyline(&points, true).ok_or_else(|| Error::data("a loop of fewer than three corners"))?;
    match one.kind {
        trace::LoopKind::Room => Boundary::new(Role::Arena, curve, None),
        trace::LoopKind::Island => Boundary::new(Role::Obstacle, curve, None),
        trace::LoopKind::Hole => Boundary::obstacle_hole(curve, None),
    }
}
