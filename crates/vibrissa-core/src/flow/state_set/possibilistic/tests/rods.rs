//! Whiskers that are not uniform: no state in which a marched rod touches the map is ruled out.

use super::super::contractor::{self, BaseView, BoundaryLevels};
use super::super::errors::{PoseSlack, RestShape, UncertainWhisker};
use super::super::initial_cover;
use super::super::record::ReadingContacts;
use super::Random;
use super::{SLOPE, cell_around, foothold, holds, map};
use crate::beam::{Rod, Stretch, Whisker};
use crate::config::PossibilisticOptions;
use crate::plane::{Pose2, Vec2};
use crate::world::{Lean, MountedWhisker, WhiskerErrors};
use core::f64::consts::FRAC_PI_2;

/// Largest root of a load, in those that turn the contact by a radian in small-angle theory: below the least that buckles.
const LOAD: f64 = 1.6;

/// Tapered, curved, on an elastic base, and of several wires; each with a coefficient of friction.
fn kinds() -> Vec<(Whisker, f64)> {
    let plain = Whisker::default();
    let wire = |length, flexural_rigidity| Stretch { length, flexural_rigidity, tip_ratio: 1.0, diameter: None };
    let wires = [wire(0.03, 4e-4), wire(0.005, 4e-5), wire(0.04, 1e-4)];
    let curled = Whisker { curvature: -20.0, tip_ratio: 0.5, base_stiffness: 0.02, ..plain };
    vec![
        (Whisker { tip_ratio: 0.3, ..plain }, 0.0),
        (Whisker { curvature: 12.0, ..plain }, 0.0),
        (Whisker { tip_ratio: 0.5, base_stiffness: 0.02, ..plain }, 0.0),
        (curled, 0.2),
        (Whisker::of_stretches(&wires).unwrap(), 0.0),
    ]
}

/// The whisker as it is, within the bounds of what is told of it.
fn actual(told: &MountedWhisker, draw: &mut Random) -> Whisker {
    let mut beam = told.beam;
    let longer = 1.0 + draw.signed(told.errors.length) / beam.length;
    let stiffer = 1.0 + draw.signed(told.errors.rigidity);
    beam.length *= longer;
    beam.flexural_rigidity *= stiffer;
    let stretched = |wire: &Stretch| Stretch {
        length: wire.length * longer,
        flexural_rigidity: wire.flexural_rigidity * stiffer,
        ..*wire
    };
    let list: Vec<Stretch> = beam.stretches.as_slice().iter().map(stretched).collect();
    if list.is_empty() {
        beam
    } else {
        Whisker { base_stiffness: beam.base_stiffness, ..Whisker::of_stretches(&list).unwrap() }
    }
}

/// A contact of a rod: slope, moment, place, and the direction of the wall against the slope.
fn contact(rod: &Rod, length: f64, friction: f64, draw: &mut Random) -> (f64, Vec2, f64) {
    let lean = friction.atan();
    let side = draw.sign();
    let (s_a, tilt, off) = if draw.unit() < 0.5 {
        (length, draw.between(-lean, FRAC_PI_2), draw.signed(lean))
    } else {
        let tilt = draw.signed(lean);
        // The whisker's own normal, whatever the force.
        (length * draw.between(0.01, 1.0), tilt, tilt)
    };
    let root = draw.between(0.05, LOAD);
    let force = side * root * root / rod.slope_compliance(s_a);
    let (place, slope, moment) = rod.contact_under(force, s_a, side * tilt).unwrap();
    (moment, place, slope + side * (FRAC_PI_2 + tilt - off))
}

/// How many random cells around true states one reading halves; none of them loses its state.
fn halved(told: &MountedWhisker, draw: &mut Random) -> usize {
    let map = map();
    let ground = BoundaryLevels::new(&map);
    let options = PossibilisticOptions { largest_slope: SLOPE, ..PossibilisticOptions::default() };
    let whisker = UncertainWhisker::new(told, 0.0, SLOPE);
    let of = |size, count| super::super::contact_tables::tables(size, count, &whisker, &options);
    let mut tables = of(super::super::contact_tables::NEXT_TABLE, super::super::contact_tables::NEXT_TABLES);
    tables.extend(of(super::super::contact_tables::FIRST_TABLE, super::super::contact_tables::TABLES));
    let mut cut = 0;
    for trial in 0..150 {
        let as_is = actual(told, draw);
        let rod = as_is.rod().unwrap();
        let (moment, place, direction) = contact(&rod, as_is.length, told.friction, draw);
        let corners = draw.unit() < 0.4;
        let (at, normal, _) = foothold(&map, draw, corners);
        let heading = normal - direction;
        let base = at - place.rotated(heading);
        let robot = Pose2::new(base.x, base.y, heading).compose(told.robot_from_whisker.inverse());
        let (a, b) = (moment * (1.0 - draw.between(0.0, 0.1)), moment * (1.0 + draw.between(0.0, 0.1)));
        let touch = ReadingContacts::new(&whisker, &tables, a.min(b), a.max(b));
        for _ in 0..3 {
            let mut cell = cell_around(robot, draw);
            let before = cell.volume();
            let view =
                BaseView::new(&cell, Pose2::IDENTITY, (0.0, 0.0), touch.robot_from_whisker).with_base(touch.base);
            let left = contractor::contract(&view, &touch, &ground, &mut 0);
            let left = left.unwrap_or_else(|| panic!("lost: {told:?} {moment} {place:?} {direction}"));
            cell.contract_to(&left);
            assert!(holds(&cell, robot), "cut away: {told:?} {moment} {place:?} {direction}");
            cut += usize::from(cell.volume() < 0.5 * before);
        }
        if trial % 20 == 0 {
            let coarse = ReadingContacts::new(&whisker, &tables[tables.len() - 1..], a.min(b), a.max(b));
            let late = PoseSlack::default();
            let born = initial_cover::initial_cells(&ground.clustered, None, &coarse, (0, late));
            assert!(born.iter().any(|cell| holds(cell, robot)), "not born: {told:?} {moment} {place:?} {direction}");
        }
    }
    cut
}

/// Of a uniform whisker the closed form tells all contacts: the tables of others halve a quarter as many cells at least, and
/// with errors, which leave little to halve, all kinds together. Friction leaves nothing to halve for either.
#[test]
fn no_true_state_is_ruled_out() {
    let errors = [WhiskerErrors::default(), WhiskerErrors { length: 2e-3, rigidity: 0.05, ..WhiskerErrors::default() }];
    let told = |beam: Whisker, friction: f64, errors: WhiskerErrors| MountedWhisker {
        beam,
        friction,
        errors,
        robot_from_whisker: Pose2::new(0.03, -0.02, 0.7),
        ..MountedWhisker::default()
    };
    let mut draw = Random(71);
    for errors in errors {
        let closed = halved(&told(Whisker::default(), 0.0, errors), &mut draw);
        assert!(closed > if errors.length > 0.0 { 10 } else { 50 }, "{closed}");
        let mut all = 0;
        for (beam, friction) in kinds() {
            let ours = halved(&told(beam, friction, errors), &mut draw);
            all += ours;
            let is_exact = friction <= 0.0 && errors.length <= 0.0;
            assert!(!is_exact || 4 * ours >= closed, "{ours} against {closed}: {beam:?}");
        }
        assert!(all >= closed, "{all} against {closed}: {errors:?}");
    }
}

/// The shape at rest that free whiskers are looked for with, against a march.
#[test]
fn a_whisker_at_rest_is_where_it_is_told() {
    let mut draw = Random(72);
    for _ in 0..200 {
        let mut told = MountedWhisker::default();
        told.beam.curvature = draw.signed(30.0);
        told.beam.curvature_rise[0] = draw.signed(300.0);
        told.errors.length = draw.between(0.0, 3e-3);
        let (length, own) = (told.beam.length, told.errors.length);
        let rest = RestShape::new(&told.beam, (length - own, length + own, own), Lean::default());
        let as_is = actual(&told, &mut draw);
        let rod = as_is.rod().unwrap();
        let share = draw.between(0.01, 1.0);
        let (place, ..) = rod.contact_under(0.0, share * as_is.length, 0.0).unwrap();
        // The same share of the told length, on its chord.
        let at = share * (rest.points.len() - 1) as f64;
        let k = (at as usize).min(rest.points.len() - 2);
        let on_chord = rest.points[k] + (rest.points[k + 1] - rest.points[k]) * (at - k as f64);
        assert!(on_chord.distance(place) <= rest.off, "{told:?}: {place:?} {on_chord:?} {}", rest.off);
    }
}
