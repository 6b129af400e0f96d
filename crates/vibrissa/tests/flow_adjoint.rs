//! Preimage and forward map are adjoint: a state is in the preimage of a reading exactly where the reading is among those
//! that the state can feel, found here by trying every point of the boundary.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

#[path = "data/random.rs"]
mod random;

use random::Random;
use std::f64::consts::PI;
use vibrissa::beam::normal::{Branch, NormalBend, by_point};
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
        let smooth = near && (off_a - off_b).abs() < 0.1 && off_a * off_b <= 0.0 && off_a != off_b;
        smooth.then(|| a.moment + (b.moment - a.moment) * off_a / (off_a - off_b))
    };
    samples.windows(2).filter_map(between).collect()
}

/// Whether a state within a cell of `state` could feel a moment of about `reading`.
fn feels_about(samples: &[BoundarySample], state: Pose2, reading: Interval) -> bool {
    let slack = 0.4e-3 + 0.15 * reading.hi().abs();
    let near = |at: &BoundarySample| {
        laid(at, state).is_some_and(|(bend, off)| {
            off.abs() < 0.12 && bend.moment > reading.lo() - slack && bend.moment < reading.hi() + slack
        })
    };
    samples.iter().any(near)
}

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
    let samples = arena.samples(2.5e-4);
    let mut random = Random(31);
    let (mut feeling, mut inside, mut explained, mut chance, mut all) = (0, 0, 0, 0, 0);
    for size in [1.5e-3_f64, -2.5e-3, 4e-3, -6e-3] {
        let reading = Interval::new(size - 0.1 * size.abs(), size + 0.1 * size.abs());
        let found = preimage(&arena, reading);
        for _ in 0..4000 {
            let state = anywhere(&arena, &mut random);
            let contained = found.states.contains(state);
            if contained {
                inside += 1;
                explained += usize::from(feels_about(&samples, state, reading));
            }
            if all % 8 == 0 {
                chance += usize::from(feels_about(&samples, state, reading));
                if felt(&samples, state).iter().any(|m| reading.contains(*m)) {
                    feeling += 1;
                    assert!(contained, "{state:?} feels {reading:?} but is not in its preimage");
                }
            }
            all += 1;
        }
    }
    println!(
        "{feeling} states that feel, all inside; {explained} of {inside} inside feel about that; {chance} by chance"
    );
    assert!(feeling > 40 && inside > 400, "{feeling} {inside}");
    assert!(explained * 100 >= inside * 97, "{explained} of {inside}");
    // The check of the second direction must be able to fail.
    assert!(chance * 8 < all / 2, "{chance} of {} by chance", all / 8);
}
