//! Preimage and forward map are adjoint: a state is in the preimage of a reading exactly where the reading is among those
//! that the state can feel, found here by trying every point of the boundary.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

#[path = "data/random.rs"]
mod random;

use random::Random;
use std::f64::consts::{PI, TAU};
use vibrissa::beam::normal::{Branch, NormalBend, by_moment, by_point};
use vibrissa::beam::{Load, Whisker};
use vibrissa::flow::contact_set::{ContactModel, MomentRegime, Parts, Reading, VirtualSensor};
use vibrissa::flow::preimage::{Construction, PreimageOptions, ReadingPreimage, reading_preimage};
use vibrissa::plane::{Pose2, Vec2, wrap_angle};
use vibrissa::sets::Interval;
use vibrissa::tasks::demo;
use vibrissa::world::{BoundarySample, Map};

const CELL: f64 = 2e-3;
const HEADINGS: usize = 180;

/// The whisker at `map_from_whisker` with its side at the boundary point, and how far it is from lying along it (rad).
fn laid(at: &BoundarySample, map_from_whisker: Pose2) -> Option<(NormalBend, f64)> {
    let whisker = Whisker::default();
    let point = map_from_whisker.inverse_transform_point(at.position);
    if point.norm() > whisker.length || point.norm() < 4e-3 {
        return None;
    }
    let bend = by_point(whisker.flexural_rigidity, whisker.length, point, Branch::Least)?;
    let along = wrap_angle(map_from_whisker.theta + bend.phi_a - at.tangent);
    // Along the boundary either way; the wall pushes into free space.
    let off = if along.abs() > 0.5 * PI { wrap_angle(along - PI) } else { along };
    let push = bend.force_vector().rotated(map_from_whisker.theta).dot(Vec2::from_angle(at.tangent).perp());
    (push > 0.0).then_some((bend, off))
}

/// The moments that a robot at `state` can feel: where the whisker lies along the boundary between two neighbours.
fn felt(samples: &[BoundarySample], state: Pose2) -> Vec<f64> {
    let between = |pair: &[BoundarySample]| {
        let near = pair[0].boundary == pair[1].boundary && pair[0].position.distance(pair[1].position) < 1e-3;
        let ((a, off_a), (b, off_b)) = (laid(&pair[0], state)?, laid(&pair[1], state)?);
        // Smooth pieces only: corners belong to other samples.
        let smooth = near && (off_a - off_b).abs() < 0.1 && (off_a < 0.0) != (off_b < 0.0);
        smooth.then(|| a.moment + (b.moment - a.moment) * off_a / (off_a - off_b))
    };
    samples.windows(2).filter_map(between).collect()
}

/// The contacts of the readings in an interval, by the closed form: where, and in which direction the whisker runs there.
fn contacts(reading: Interval) -> Vec<(Vec2, f64)> {
    let whisker = Whisker::default();
    let moments = [0.0, 0.25, 0.5, 0.75, 1.0].map(|share| reading.lo() + share * reading.width());
    let arcs = (1..=150).map(|k| whisker.length * f64::from(k) / 150.0);
    let both = arcs.flat_map(|s_a| moments.map(|m| (m, s_a)));
    both.flat_map(|(m, s_a)| [Branch::Least, Branch::Curled].map(|b| by_moment(whisker.flexural_rigidity, m, s_a, b)))
        .flatten()
        // With the free side on the left, as boundaries are told.
        .map(|bend| (bend.contact, if bend.force >= 0.0 { bend.phi_a } else { bend.phi_a + PI }))
        .collect()
}

/// Whether a contact of a robot at `state` lies within `reach` of the boundary and about along it there.
fn fits(samples: &[BoundarySample], contacts: &[(Vec2, f64)], state: Pose2, reach: f64) -> bool {
    let far = Whisker::default().length + reach;
    let near: Vec<&BoundarySample> = samples.iter().filter(|s| s.position.distance(state.position()) < far).collect();
    contacts.iter().any(|(contact, direction)| {
        let place = state.transform_point(*contact);
        let offs = near.iter().filter(|s| s.position.distance(place) < reach);
        let offs = offs.map(|s| wrap_angle(state.theta + direction - s.tangent));
        // Between the directions that the boundary has there: at a corner, between those of its sides.
        let (lo, hi) = offs.fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), off| (lo.min(off), hi.max(off)));
        lo < ALONG && hi > -ALONG && hi - lo < PI
    })
}

/// Headings are told by bins, and a contact's by where it stands (rad).
const ALONG: f64 = 0.07;

fn preimage(map: &Map, reading: Interval) -> ReadingPreimage {
    let model = ContactModel::new(&Whisker::default(), Load::Normal).unwrap();
    let options = PreimageOptions {
        cell: CELL,
        headings: HEADINGS,
        construction: Construction::Alignment,
        contacts: Parts::Side,
        collision_free: false,
    };
    let sensor = VirtualSensor::Moment(MomentRegime::LargeAngle);
    reading_preimage(map, &model, Pose2::IDENTITY, &[Reading { sensor, value: reading }], &options).unwrap()
}

fn anywhere(map: &Map, random: &mut Random) -> Pose2 {
    let (bounds, size) = (map.bounds(), map.bounds().size());
    let place = bounds.min + Vec2::new(size.x * random.unit(), size.y * random.unit());
    Pose2::new(place.x, place.y, random.signed(PI))
}

#[test]
fn a_state_is_in_the_preimage_exactly_where_it_feels_the_reading() {
    let arena = demo::arena().unwrap();
    let (samples, coarse) = (arena.samples(4e-4), arena.samples(1e-3));
    let mut random = Random(31);
    let (mut feeling, mut inside, mut explained, mut chance, mut outside, mut all) = (0, 0, 0, 0, 0, 0);
    for size in [1.5e-3_f64, -2.5e-3, 4e-3, -6e-3] {
        let reading = Interval::new(size - 0.1 * size.abs(), size + 0.1 * size.abs());
        let (found, contacts) = (preimage(&arena, reading), contacts(reading));
        // A cover is grown by how far samples lie apart, by cells, and by what a bin of headings moves the tip.
        let reach = found.deviation + 2.0 * CELL + 0.075 * TAU / HEADINGS as f64;
        for index in 0..1500 {
            let state = anywhere(&arena, &mut random);
            let contained = found.states.contains(state);
            let feels = felt(&samples, state).iter().any(|m| reading.contains(*m));
            assert!(contained || !feels, "{state:?} feels {reading:?} but is not in its preimage");
            feeling += usize::from(feels);
            all += 1;
            // Where the base all but touches, a cell is too coarse to tell directions.
            let apart = arena.nearest(state.position()).unwrap().distance > reach;
            if contained && apart {
                inside += 1;
                explained += usize::from(fits(&coarse, &contacts, state, reach));
            } else if !contained && index % 15 == 0 {
                outside += 1;
                chance += usize::from(fits(&coarse, &contacts, state, reach));
            }
        }
    }
    println!(
        "{feeling} of {all} states feel, all inside; {explained} of {inside} inside fit; {chance} of {outside} outside"
    );
    assert!(feeling > 8 && inside > 50, "{feeling} {inside}");
    assert!(explained == inside, "{} inside fit nowhere", inside - explained);
    // The check of the second direction must be able to fail.
    assert!(3 * chance < outside, "{chance} of {outside} outside fit");
}
