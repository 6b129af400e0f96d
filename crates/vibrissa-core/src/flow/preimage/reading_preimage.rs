//! The robot states that explain readings: contact sets laid against the whole boundary.

use super::painter::Painter;
use super::solid::{Solid, deep_cells};
use super::state_grid::{Raster, StateGrid};
use super::thin::ThinWalls;
use super::touch::{BoundaryTouch, touches};
use crate::config::defaults;
use crate::flow::contact_set::{
    ContactCell, ContactModel, ContactRegion, ContactSet, MomentRegime, Parts, Reading, Resolution, VirtualSensor,
};
use crate::plane::{Bounds, Pose2, Vec2};
use crate::sets::Interval;
use crate::world::{Map, Role};
use crate::{Error, Result};
use core::f64::consts::TAU;

/// Points of the whisker that are kept out of solids.
pub(super) const BODY_POINTS: usize = 16;
/// How far a whisker may be from the chords between these points, as a share of their distance.
const CHORD_SLACK: f64 = 0.1;
/// Nodes of the curves of exact readings.
const NODES: usize = 800;
/// Largest memory of a set (bytes): 1 GB.
const LARGEST_SET: f64 = 1e9;
/// How the tolerance of one cell is shared out: extent of a contact cell, and what its slopes move the base.
const SHARES: [f64; 2] = [0.45, 0.4];

/// Which states count as explaining a contact \[routray, section "Preimages of a Load Sensor"\].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Construction {
    /// The whisker's shape is laid along the boundary as it is at frictionless contact: with its side, whose tangent is
    /// the boundary's there, or with its tip, pushed along the boundary's normal; at corners directions lie between both
    /// walls'.
    #[default]
    Alignment,
    /// Directional distance: for every heading the base is as far from the boundary as the contact is from the base, at whatever angle
    /// the whisker meets the boundary. Holds with friction too, and is larger.
    Distance,
}

/// How a preimage is computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PreimageOptions {
    /// Side of the cells of places (m).
    pub cell: f64,
    /// How many headings make a turn.
    pub headings: usize,
    /// Which states count.
    pub construction: Construction,
    /// Which parts of the whisker may touch.
    pub contacts: Parts,
    /// Whether whisker and base must be out of solids, which the paper does not ask.
    pub collision_free: bool,
}

impl Default for PreimageOptions {
    /// The paper's millimetre, and a degree.
    fn default() -> Self {
        Self {
            cell: defaults::PREIMAGE_CELL,
            headings: defaults::PREIMAGE_HEADINGS,
            construction: Construction::default(),
            contacts: Parts::default(),
            collision_free: true,
        }
    }
}

impl PreimageOptions {
    /// Checks that cells and headings are in their ranges.
    ///
    /// # Errors
    /// Usage: names the option, its value and the allowed range.
    pub fn check(&self) -> Result<()> {
        if !(self.cell >= 1e-5 && self.cell <= 1.0) {
            return Err(Error::usage("the cell of a preimage").value(self.cell).allowed("1e-5 to 1 m"));
        }
        if !(4..=3600).contains(&self.headings) {
            return Err(Error::usage("the headings of a preimage").value(self.headings).allowed("4 to 3600 in a turn"));
        }
        Ok(())
    }

    /// The resolution of contact regions that suits a preimage of a whisker whose base is up to `reach` (m) from the contact.
    #[must_use]
    pub fn resolution(&self, reach: f64) -> Resolution {
        match self.construction {
            Construction::Alignment => Resolution::even(SHARES[0] * self.cell, SHARES[1] * self.cell / reach),
            Construction::Distance => Resolution::even(SHARES[0] * self.cell, 0.5),
        }
    }
}

/// The robot states that explain readings, covered by cells of a grid.
#[derive(Clone, Debug, PartialEq)]
pub struct ReadingPreimage {
    /// The states; never fewer than all.
    pub states: StateGrid,
    /// The area of the places before they are grown to cover (m²): between this and the cover's lies the true area, up to
    /// what a cell cannot show.
    pub sampled_area: f64,
    /// How far a true state can be from a sampled one (m).
    pub deviation: f64,
}

/// The robot states on `map` that explain `readings` of one whisker on the robot: the paper's `h^-1(z)` without the shape.
///
/// ```text
/// { (x, y, theta) : some contact of the region, placed at (x, y, theta), lies on the boundary and touches it as the construction says }
/// ```
///
/// The heading is unknown: every heading counts at which some contact fits. With [`PreimageOptions::collision_free`] states are left
/// out whose base or whisker is inside something solid, or through a thin wall, by more than the grid's tolerance (about
/// four cells).
///
/// # Errors
/// Usage: readings or options out of range; a grid beyond a gigabyte.
pub fn reading_preimage(
    map: &Map,
    model: &ContactModel,
    robot_from_whisker: Pose2,
    readings: &[Reading],
    options: &PreimageOptions,
) -> Result<ReadingPreimage> {
    options.check()?;
    let resolution = options.resolution(model.length() + robot_from_whisker.position().norm());
    let region = match readings {
        // Where the curve of the side is written down, it is taken as it is.
        [Reading { sensor, value }] if options.contacts.side() && model.has_closed_family() && value.width() <= 0.0 => {
            let sensor = match sensor {
                VirtualSensor::Moment(MomentRegime::Auto) => VirtualSensor::Moment(MomentRegime::LargeAngle),
                other => *other,
            };
            let side = ContactRegion::along(&ContactSet::new(model, sensor, value.lo(), NODES)?, &resolution);
            if options.contacts.tip() {
                side.joined(ContactRegion::of_parts(model, readings, Parts::Tip, &resolution)?)
            } else {
                side
            }
        }
        _ => ContactRegion::of_parts(model, readings, options.contacts, &resolution)?,
    };
    region_preimage(map, &region, robot_from_whisker, options)
}

/// The robot states on `map` that explain a contact region, as [`reading_preimage`].
///
/// # Errors
/// Usage: options out of range; a grid beyond a gigabyte.
pub fn region_preimage(
    map: &Map,
    region: &ContactRegion,
    robot_from_whisker: Pose2,
    options: &PreimageOptions,
) -> Result<ReadingPreimage> {
    fused_preimage(map, &[(region.clone(), robot_from_whisker)], options)
}

/// The robot states on `map` that explain the contact regions of several whiskers that touch one and the same point.
///
/// Each region comes with `robot_from_whisker`. A region keeps the contacts that every other whisker can make at the same
/// place; states stay that each whisker allows by itself, its body included.
///
/// # Errors
/// Usage: no region, options out of range; a grid beyond a gigabyte.
pub fn fused_preimage(
    map: &Map,
    regions: &[(ContactRegion, Pose2)],
    options: &PreimageOptions,
) -> Result<ReadingPreimage> {
    options.check()?;
    let largest = |value: &dyn Fn(&(ContactRegion, Pose2)) -> f64| regions.iter().map(value).fold(0.0, f64::max);
    let mount = largest(&|r| r.1.position().norm());
    // The same grid for every reading of a whisker, so that preimages can be compared.
    let raster = raster(map, largest(&|r| r.0.model().length() + r.1.position().norm()), mount, options)?;
    let mut found: Option<ReadingPreimage> = None;
    for (i, (region, robot_from_whisker)) in regions.iter().enumerate() {
        let others = regions.iter().enumerate().filter(|(j, _)| *j != i);
        let shared = others.fold(region.clone(), |own, (_, (other, robot_from_other))| {
            own.shared_with(other, robot_from_whisker.between(*robot_from_other))
        });
        let next = laid(map, &shared, *robot_from_whisker, raster, options);
        found = Some(match found {
            None => next,
            Some(before) => ReadingPreimage {
                states: before.states.intersection(&next.states).unwrap_or(next.states),
                sampled_area: before.sampled_area.min(next.sampled_area),
                deviation: before.deviation.max(next.deviation),
            },
        });
    }
    found.ok_or_else(|| Error::usage("no contact region").allowed("one or more"))
}

/// The states on a grid at which the contacts of one whisker fit.
fn laid(
    map: &Map,
    region: &ContactRegion,
    robot_from_whisker: Pose2,
    raster: Raster,
    options: &PreimageOptions,
) -> ReadingPreimage {
    let mount = robot_from_whisker.position().norm();
    let farthest = |cell: &ContactCell| cell.contact.position.norm() + cell.radius;
    let reach = region.cells.iter().map(farthest).fold(options.cell, f64::max) + mount;
    let mut states = StateGrid::empty(raster, options.headings);
    let places = match options.construction {
        Construction::Alignment => touches(map, options.cell, reach),
        Construction::Distance => touches(map, options.cell, 0.01 * options.cell),
    };
    let half_bin = 0.5 * TAU / options.headings as f64;
    let largest = |value: &dyn Fn(&BoundaryTouch) -> f64| places.iter().map(value).fold(0.0, f64::max);
    let of_cells = |value: &dyn Fn(&ContactCell) -> f64| region.cells.iter().map(value).fold(0.0, f64::max);
    let deviation = match options.construction {
        Construction::Alignment => {
            let turned = of_cells(&|c| c.radius + 0.5 * c.wall.width() * (farthest(c) + mount));
            turned + largest(&|t| t.spread + reach * t.half_turn)
        }
        Construction::Distance => of_cells(&|c| c.radius) + reach * half_bin + largest(&|t| t.spread),
    };
    let solid = options.collision_free.then(|| {
        let bounds = map.bounds();
        let margin = region.model().length() + 2.0 * options.cell;
        Solid::new(map, Raster::over(grown(bounds, margin), options.cell), 2.0 * deviation)
    });
    let chords = CHORD_SLACK * region.model().length() / (BODY_POINTS - 1) as f64;
    let thin = if options.collision_free { ThinWalls::new(map, 2.0 * deviation + options.cell + chords) } else { None };
    let painter = Painter { region, places: &places, solid: solid.as_ref(), thin: thin.as_ref(), robot_from_whisker };
    match options.construction {
        Construction::Alignment => painter.align(&mut states),
        Construction::Distance => painter.turn(&mut states, options.headings),
    }
    // The robot's origin is the whisker's base, which is never inside something solid.
    let deep = (options.collision_free && mount <= 0.0).then(|| deep_cells(map, states.raster(), 0.0));
    let possible = |index: usize| deep.as_ref().is_none_or(|deep| !deep[index]);
    let sampled_area = states.area_of(possible);
    states.grown((deviation / options.cell - 1e-9).ceil().max(0.0) as usize);
    states.retain(possible);
    ReadingPreimage { states, sampled_area, deviation }
}

fn grown(bounds: Bounds, margin: f64) -> Bounds {
    let corner = Vec2::new(margin, margin);
    Bounds { min: bounds.min - corner, max: bounds.max + corner }
}

/// The places that robots can have: around the whole map, or in its arena where bases must be free.
fn raster(map: &Map, reach: f64, mount: f64, options: &PreimageOptions) -> Result<Raster> {
    let arena = map.boundaries().iter().any(|b| b.role() == Role::Arena) && options.collision_free;
    let margin = if arena { mount } else { reach } + 4.0 * options.cell;
    let bounds = grown(map.bounds(), margin);
    let size = bounds.size();
    let bytes = size.x / options.cell * (size.y / options.cell) * options.headings.div_ceil(64) as f64 * 8.0;
    if bytes > LARGEST_SET {
        let coarser = options.cell * (bytes / LARGEST_SET).sqrt() * 1.01;
        return Err(Error::usage("the cell of a preimage is too small for this map")
            .value(format!("{} m, which takes {:.0} GB", options.cell, bytes / 1e9))
            .allowed(format!("from {:.1} mm on", coarser * 1e3))
            .remedy("take larger cells, fewer headings, or a smaller map"));
    }
    Ok(Raster::over(bounds, options.cell))
}

/// The interval of distances from the base at which the contacts lie (m): the widths of the strip around the boundary.
#[must_use]
pub fn distances(region: &ContactRegion) -> Interval {
    let of = |cell: &ContactCell| {
        let middle = cell.contact.position.norm();
        Interval::new((middle - cell.radius).max(0.0), middle + cell.radius)
    };
    region.cells.iter().map(of).fold(Interval::EMPTY, Interval::hull)
}
