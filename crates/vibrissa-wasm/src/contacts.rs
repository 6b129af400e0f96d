//! Which contacts explain a reading, and which robot states do on a map.

use crate::bend::whisker;
use crate::host::Host;
use core::f64::consts::TAU;
use vibrissa::beam::Load;
use vibrissa::config::budgets::MOST_PAGE_STEPS;
use vibrissa::config::contact_set::NODES;
use vibrissa::flow::contact_set::{
    Contact, ContactModel, ContactRegion, ContactSet, MomentRegime, Reading, Resolution, VirtualSensor,
};
use vibrissa::flow::preimage::{PreimageOptions, reading_preimage};
use vibrissa::plane::Vec2;
use vibrissa::sets::Interval;
use vibrissa::{Error, Result};

/// Points of a drawn whisker.
const POINTS: usize = 48;

fn reading(sensor: u32, lo: f64, hi: f64) -> Result<Reading> {
    let sensor = match sensor {
        0 => VirtualSensor::Load,
        1 => VirtualSensor::Strip,
        2 => VirtualSensor::Slope,
        3 => VirtualSensor::Moment(MomentRegime::Auto),
        other => return Err(Error::usage("sensor").value(other).allowed("0 to 3")),
    };
    if lo.is_nan() || hi.is_nan() || lo > hi {
        return Err(Error::usage("reading")
            .value(format!("{lo}..{hi}"))
            .allowed("an interval lo..hi with lo not above hi"));
    }
    let reading = Reading { sensor, value: Interval::new(lo, hi) };
    reading.check()?;
    Ok(reading)
}

pub(crate) fn contact_set(host: &mut Host, sensor: u32, lo: f64, hi: f64, shapes: u32) -> Result<()> {
    let reading = reading(sensor, lo, hi)?;
    let model = ContactModel::new(&whisker(host)?, Load::Normal)?;
    let set = ContactSet::new(&model, reading.sensor, 0.5 * (lo + hi), NODES)?;
    host.count(set.curves.len());
    host.push([set.tolerance]);
    for curve in &set.curves {
        host.count(curve.contacts().len());
        for c in curve.contacts() {
            host.push([c.position.x, c.position.y, c.s_a, c.phi_a, c.force, c.moment]);
        }
    }
    if reading.value.width() > 0.0 {
        let region = ContactRegion::new(&model, &[reading], &Resolution::default())?;
        host.push([region.area()]);
        host.count(region.components().len());
        host.count(region.cells.len());
        region.cells.iter().for_each(|cell| host.points(cell.cover.corners()));
    } else {
        host.push([0.0; 3]);
    }
    let contacts: Vec<Contact> = set.curves.iter().flat_map(|curve| curve.contacts().to_vec()).collect();
    let step = contacts.len().div_ceil(shapes.max(1) as usize).max(1);
    let drawn: Vec<Vec<Vec2>> = if shapes == 0 {
        Vec::new()
    } else {
        contacts.iter().step_by(step).map(|contact| set.model().shape(contact, POINTS)).collect()
    };
    host.count(drawn.len());
    drawn.iter().for_each(|points| host.points(points));
    Ok(())
}

pub(crate) fn preimage(host: &mut Host, sensor: u32, lo: f64, hi: f64, cell: f64, headings: u32) -> Result<()> {
    let reading = reading(sensor, lo, hi)?;
    let model = ContactModel::new(&whisker(host)?, Load::Normal)?;
    let mount = host.robot.whiskers[0].robot_from_whisker;
    let options = PreimageOptions { cell, headings: headings as usize, ..PreimageOptions::default() };
    options.check()?;
    let map = host.map()?;
    let steps = map.total_length() / cell * f64::from(headings);
    if steps > f64::from(MOST_PAGE_STEPS) {
        let error = Error::usage("steps of a cell along the boundary, over all headings").value(steps.round());
        return Err(error
            .allowed(format!("up to {MOST_PAGE_STEPS}"))
            .remedy("take coarser cells, fewer headings or a part of the map"));
    }
    let found = reading_preimage(map, &model, mount, &[reading], &options)?;
    let states = &found.states;
    let raster = *states.raster();
    host.push([
        f64::from(u8::from(states.is_empty())),
        states.area(),
        found.sampled_area,
        states.volume(),
        found.deviation,
        raster.origin.x,
        raster.origin.y,
        raster.cell,
    ]);
    host.count(raster.columns);
    host.count(raster.rows);
    for row in 0..raster.rows {
        for column in 0..raster.columns {
            let held = if states.holds(column, row) {
                states.heading_runs(column, row).iter().map(|(first, last)| last - first).sum()
            } else {
                0
            };
            host.push([held as f64 / states.bins() as f64]);
        }
    }
    host.states = Some(found.states);
    Ok(())
}

pub(crate) fn headings(host: &mut Host, x: f64, y: f64) -> Result<()> {
    let Some(states) = &host.states else { return Err(Error::usage("no preimage was asked for yet")) };
    let raster = *states.raster();
    let step = TAU / states.bins() as f64;
    let runs = raster
        .index(Vec2::new(x, y))
        .map_or_else(Vec::new, |cell| states.heading_runs(cell % raster.columns, cell / raster.columns));
    host.numbers = runs.iter().flat_map(|&(first, last)| [first as f64 * step, last as f64 * step]).collect();
    Ok(())
}
