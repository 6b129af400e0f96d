//! Many whiskers on many threads: the same bits as one after the other.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

use vibrissa::beam::normal::{Branch, NormalBend, by_force_batch, by_moment_batch, by_point_batch};
use vibrissa::beam::{Load, Whisker};
use vibrissa::plane::Vec2;
use vibrissa::tasks::batch::{all_cores, by_force, by_moment, by_point, map};

#[path = "data/random.rs"]
mod random;
use random::Random;

const EI: f64 = 2.8886e-4;

/// Every number of a shape, bit by bit.
fn bits(shapes: &[NormalBend]) -> Vec<[u64; 6]> {
    let of = |b: &NormalBend| [b.force, b.s_a, b.phi_a, b.moment, b.contact.x, b.contact.y].map(f64::to_bits);
    shapes.iter().map(of).collect()
}

#[test]
fn normal_loads_are_the_same_bits_on_any_number_of_threads() {
    let mut random = Random(3);
    let n = 30_011;
    let forces: Vec<f64> = (0..n).map(|_| random.signed(0.2)).collect();
    let arcs: Vec<f64> = (0..n).map(|_| random.between(0.02, 0.075)).collect();
    let moments: Vec<f64> = (0..n).map(|_| random.signed(0.01)).collect();
    let points: Vec<Vec2> = arcs.iter().map(|s| 0.9 * *s * Vec2::from_angle(random.signed(1.4))).collect();
    let blank = || vec![NormalBend::default(); n];
    let mut expected = [blank(), blank(), blank()];
    by_force_batch(EI, &forces, &arcs, &mut expected[0]);
    by_moment_batch(EI, &moments, &arcs, Branch::Least, &mut expected[1]);
    by_point_batch(EI, 0.075, &points, Branch::Least, &mut expected[2]);
    for threads in [0, 1, 2, 3, 7, 64] {
        let mut found = [blank(), blank(), blank()];
        by_force(EI, &forces, &arcs, &mut found[0], threads);
        by_moment(EI, &moments, &arcs, Branch::Least, &mut found[1], threads);
        by_point(EI, 0.075, &points, Branch::Least, &mut found[2], threads);
        for (found, expected) in found.iter().zip(&expected) {
            assert!(bits(found) == bits(expected), "{threads} threads");
        }
    }
    // The shortest slice counts.
    let mut short = blank();
    by_force(EI, &forces[..10], &arcs, &mut short, 2);
    assert!(bits(&short[..10]) == bits(&expected[0][..10]) && bits(&short[10..]) == bits(&blank()[10..]));
}

#[test]
fn rods_keep_their_order() {
    let whisker = Whisker { tip_ratio: 0.3, curvature: 4.0, base_stiffness: 0.3, ..Whisker::default() };
    let rod = whisker.rod().unwrap();
    let forces: Vec<f64> = (0..200).map(|i| 2e-4 * f64::from(i)).collect();
    let solve = |force: &f64| rod.force_mode(*force, 0.06, Load::Normal).unwrap();
    let expected: Vec<_> = forces.iter().map(solve).collect();
    for threads in [0, 1, 2, 5, all_cores()] {
        assert!(map(&forces, threads, solve) == expected);
    }
    assert!(map(&[] as &[f64], 4, solve).is_empty());
}
