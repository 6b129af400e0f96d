//! A loaded whisker, every equilibrium.

use crate::host::Host;
use vibrissa::beam::{Bend, Load, Whisker, force_mode, moment_mode, point_mode, tip_mode};
use vibrissa::plane::Vec2;
use vibrissa::{Error, Result};

/// Points of a shape, as the command gives them.
const POINTS: usize = 101;

/// The robot's first whisker.
pub(crate) fn whisker(host: &Host) -> Result<Whisker> {
    let first = host.robot.whiskers.first();
    first
        .map(|mounted| mounted.beam)
        .ok_or_else(|| Error::data("the robot has no whisker").remedy("add a [[whisker]] to the robot file"))
}

pub(crate) fn solve(host: &mut Host, given: u32, a: f64, b: f64, load: u32, angle: f64) -> Result<()> {
    let whisker = whisker(host)?;
    let load = match load {
        0 => Load::Normal,
        1 => Load::Vertical,
        2 => Load::Tilted(angle),
        3 => Load::Directed(angle),
        other => return Err(Error::usage("load").value(other).allowed("0 to 3")),
    };
    let bends = match given {
        0 => force_mode(&whisker, a, b, load)?,
        1 => point_mode(&whisker, Vec2::new(a, b), load)?,
        2 => moment_mode(&whisker, a, b, load)?,
        3 => tip_mode(&whisker, Vec2::new(a, b))?,
        other => return Err(Error::usage("given").value(other).allowed("0 to 3")),
    };
    host.count(bends.len());
    host.count(POINTS);
    bends.iter().for_each(|bend| equilibrium(host, bend, &whisker));
    Ok(())
}

fn equilibrium(host: &mut Host, bend: &Bend, whisker: &Whisker) {
    host.push([bend.force, bend.s_a, bend.phi_a, bend.beta, bend.contact.x, bend.contact.y, bend.moment]);
    host.point(bend.force_vector());
    host.push([bend.energy()]);
    host.point(bend.tip(whisker.length));
    let strain = bend.largest_strain_of(whisker);
    host.push([strain.map_or(f64::NAN, |most| most.strain), strain.map_or(f64::NAN, |most| most.s)]);
    bend.shape(whisker.length, POINTS).into_iter().for_each(|p| host.point(p));
}
