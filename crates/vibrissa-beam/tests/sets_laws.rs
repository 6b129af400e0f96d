//! Laws of intervals and boxes of states, the empty set among them, against membership of sampled numbers.

#[path = "../../vibrissa/tests/data/random.rs"]
mod random;

use random::Random;
use std::f64::consts::{PI, TAU};
use vibrissa_beam::plane::{Pose2, wrap_angle};
use vibrissa_beam::sets::{Interval, StateBox};

/// Empty, single, unbounded and random intervals, some sharing ends.
fn intervals() -> Vec<Interval> {
    let mut random = Random(11);
    let ends = [-2.0, -0.5, 0.0, -0.0, 1e-300, 0.5, 2.0, f64::INFINITY, f64::NEG_INFINITY];
    let mut all =
        vec![Interval::EMPTY, Interval::new(1.0, 0.0), Interval::new(f64::NAN, 1.0), Interval::point(f64::NAN)];
    for _ in 0..60 {
        let mut end = || if random.unit() < 0.6 { ends[(random.unit() * 9.0) as usize] } else { random.signed(3.0) };
        all.push(Interval::new(end(), end()));
        all.push(Interval::point(end()));
    }
    all
}

/// Numbers at, next to and between the ends of both.
fn probes(a: Interval, b: Interval) -> Vec<f64> {
    let mut all = vec![0.0, -1e308, 1e308];
    for end in [a.lo(), a.hi(), b.lo(), b.hi()].into_iter().filter(|e| e.is_finite()) {
        all.extend([end, end.next_up(), end.next_down(), end + 0.1, end - 0.1]);
    }
    all
}

#[test]
fn intersection_and_hull_are_what_their_members_say() {
    let all = intervals();
    for &a in &all {
        for &b in &all {
            let (both, hull) = (a.intersection(b), a.hull(b));
            for x in probes(a, b) {
                assert_eq!(both.contains(x), a.contains(x) && b.contains(x), "{a:?} {b:?} {x}");
                assert!(hull.contains(x) || !(a.contains(x) || b.contains(x)), "{a:?} {b:?} {x}");
                // Nothing smaller holds both: what is in the hull has members of either on both sides.
                let between = a.lo().min(b.lo()) <= x && x <= a.hi().max(b.hi());
                assert_eq!(hull.contains(x), between, "{a:?} {b:?} {x}");
            }
            assert_eq!((both, hull), (b.intersection(a), b.hull(a)));
            assert_eq!(a.hull(both), a, "a set holds what it shares: {a:?} {b:?}");
            assert_eq!(a.intersection(hull), a, "a set is in its hull: {a:?} {b:?}");
        }
    }
}

#[test]
fn intersection_and_hull_of_three_do_not_depend_on_the_order() {
    let all = intervals();
    for trio in all.windows(3) {
        let [a, b, c] = [trio[0], trio[1], trio[2]];
        assert_eq!(a.intersection(b).intersection(c), a.intersection(b.intersection(c)));
        assert_eq!(a.hull(b).hull(c), a.hull(b.hull(c)));
    }
}

#[test]
fn the_empty_set_is_neutral_to_hulls_absorbs_intersections_and_holds_nothing() {
    for a in intervals() {
        assert_eq!(a.hull(Interval::EMPTY), a);
        assert_eq!(a.intersection(Interval::EMPTY), Interval::EMPTY);
        assert_eq!(a.is_empty(), a == Interval::EMPTY, "{a:?}: there is one empty set");
        assert!(a.width() >= 0.0 && (!a.is_empty() || a.width() <= 0.0), "{a:?}");
    }
    assert!([0.0, -1.0, f64::INFINITY, f64::NEG_INFINITY, f64::NAN].iter().all(|x| !Interval::EMPTY.contains(*x)));
}

#[test]
fn a_box_grown_by_states_holds_them_all_whatever_turn_their_heading_is_told_in() {
    let mut random = Random(12);
    for round in 0..300 {
        // Less than half a turn around any heading, the half turn itself among them.
        let middle = if round % 3 == 0 { PI } else { random.signed(PI) };
        let states: Vec<Pose2> = (0..5)
            .map(|_| {
                let turns = (random.unit() * 5.0).floor() - 2.0;
                Pose2 {
                    theta: middle + random.signed(0.7) + TAU * turns,
                    ..Pose2::new(random.signed(2.0), random.signed(9.0), 0.0)
                }
            })
            .collect();
        let grown = states.iter().fold(StateBox::EMPTY, |all, state| all.including(*state));
        for state in &states {
            let near: Vec<f64> = (-5..=5).map(|k| state.theta + TAU * f64::from(k)).collect();
            let slack = Interval::new(grown.theta.lo() - 1e-12, grown.theta.hi() + 1e-12);
            assert!(grown.x.contains(state.x) && grown.y.contains(state.y), "{grown:?} {state:?}");
            assert!(near.iter().any(|theta| slack.contains(*theta)), "{grown:?} {state:?}");
        }
        let spread = states.iter().flat_map(|a| states.iter().map(|b| wrap_angle(a.theta - b.theta).abs()));
        let widest = spread.fold(0.0, f64::max);
        assert!(grown.theta.width() <= widest + 1e-12, "wider than its states: {} {widest}", grown.theta.width());
        assert_eq!(grown.hull(&StateBox::EMPTY), grown);
        assert_eq!(StateBox::EMPTY.hull(&grown), grown);
    }
}
