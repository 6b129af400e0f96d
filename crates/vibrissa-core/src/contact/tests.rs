//! The two ways to follow a contact against each other: a uniform whisker without friction feels the same by both.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

use super::follow::{Contact, ElasticBase, ForwardModel, Mechanics, WhiskerState};
use super::quasi_static::{Equilibrium, LoadedWhisker, Outcome, Step, WhiskerOnMap, between, first_touch, onset};
use super::{Boundaries, Hold, SensedQuantity, Support};
use crate::beam::{TipModel, Whisker};
use crate::plane::{Curve, Pose2, Vec2};
use crate::world::{Boundary, Map, Role};
use core::f64::consts::{FRAC_PI_2, TAU};

/// Way of the base from row to row (m).
const STEP: f64 = 2.5e-4;
/// Halvings of a step before the branch is said to end.
const MOST_HALVINGS: i32 = 14;
/// How far moments (over `EI / L`, and of themselves) and contacts (m) may differ: `follow` ends its search one step of
/// Newton's method beyond a residual of 2e-5, which leaves the square of that and more where the branch is about to
/// fold.
const SAME_MOMENT: f64 = 2e-7;
const SAME_MOMENT_IN_CORNER: f64 = 1e-5;
const SAME_PLACE: f64 = 2e-8;

/// Rows of a sweep in which only one of the two may be in contact.
const MOST_ALONE: usize = 2;

/// A sweep: where the base goes, and where the whisker points (rad).
struct Sweep {
    map: Map,
    heading: f64,
    way: Vec<Vec2>,
    /// Way from row to row (m).
    step: f64,
}

/// What a sweep has seen: rows in contact by their holds, and where only one of the two is in contact, whether
/// `follow`.
#[derive(Debug, Default)]
struct Seen {
    tip: usize,
    tip_in_corner: usize,
    side: usize,
    side_on_corner: usize,
    one_alone: Vec<(Pose2, bool)>,
}

impl Seen {
    fn count(&mut self, hold: &Hold) {
        match hold {
            Hold::Tip(Support::Piece(..)) => self.tip += 1,
            Hold::Tip(Support::Corner(_)) => self.tip_in_corner += 1,
            Hold::Side(Support::Piece(..), _) => self.side += 1,
            Hold::Side(Support::Corner(_), _) => self.side_on_corner += 1,
            Hold::Both(_) => {}
        }
    }
}

/// Moment, place and hold are the same.
fn same_contact(at: &str, moment: f64, ours: &Contact, theirs: &Equilibrium) {
    // In a corner the place is given, which a whisker that is all but straight meets with any force.
    let stiff = matches!(theirs.hold, Hold::Tip(Support::Corner(_)));
    let (exact, same) = (theirs.state.m, if stiff { SAME_MOMENT_IN_CORNER } else { SAME_MOMENT });
    assert!((moment - exact).abs() < same * (1.0 + exact.abs()), "{at}: {moment} {exact}");
    assert!(ours.place.distance(theirs.place) < SAME_PLACE, "{at}: {ours:?} {theirs:?}");
    let at_end = matches!(ours.hold, Hold::Tip(Support::Piece(_, at)) if (at - at.round()).abs() < 1e-6);
    assert!(ours.hold.is_same(&theirs.hold) || at_end, "{at}: {ours:?} {theirs:?}");
}

impl Sweep {
    fn poses(&self) -> Vec<Pose2> {
        let leg = |pair: &[Vec2]| {
            let (a, b) = (pair[0], pair[1]);
            let count = (a.distance(b) / self.step).ceil() as usize;
            (1..=count).map(move |i| a + (b - a) * (i as f64 / count as f64)).collect::<Vec<_>>()
        };
        let places = core::iter::once(self.way[0]).chain(self.way.windows(2).flat_map(leg));
        places.map(|p| Pose2::new(p.x, p.y, self.heading)).collect()
    }

    /// The forward model of the sweep's whisker, of this length (m).
    fn model<'a>(&'a self, boundaries: &'a Boundaries, length: f64, whole: bool) -> ForwardModel<'a> {
        let (mechanics, quantity) = (Mechanics::ClosedForm, SensedQuantity::Moment);
        ForwardModel { map: &self.map, boundaries, length, mechanics, whole, quantity, base: None }
    }

    /// Rows in which the simulation is in contact, and what `follow` does not know how.
    fn count_unknown(&self) -> usize {
        let whisker = Whisker::default();
        let boundaries = Boundaries::new(&self.map).with_clearance(&self.map);
        let loaded = LoadedWhisker::new(&whisker).unwrap();
        let model = self.model(&boundaries, whisker.length, true);
        let (mut state, mut held, mut unknown, mut touched) = (WhiskerState::Free, None, 0, 0);
        for pair in self.poses().windows(2) {
            let predicted = model.advance(&mut state, pair[0], pair[1], false);
            let on = |pose: Pose2| WhiskerOnMap::new(&self.map, &boundaries, &loaded, pose);
            held = stepped(&on, held, pair[0], pair[1]).unwrap();
            match (state, held) {
                (WhiskerState::Touching(_), Some(Equilibrium { state, .. })) => {
                    assert!((predicted.value - state.m).abs() < 1e-4, "{pair:?}: {} {}", predicted.value, state.m);
                }
                (_, Some(_)) => unknown += 1,
                _ => {}
            }
            touched += usize::from(held.is_some());
        }
        assert!(touched > 20, "{touched}");
        unknown
    }

    /// Follows the whisker by both until the branch of the simulation ends, and compares moment, place and hold; nothing but its contact is near
    /// the whisker, so that to look at all of it changes nothing.
    fn compare(&self, name: &str) -> Seen {
        self.compare_looking(false, name);
        self.compare_looking(true, name)
    }

    /// The same where the whole whisker is looked at, or its contact alone.
    fn compare_looking(&self, whole: bool, name: &str) -> Seen {
        let whisker = Whisker::default();
        let boundaries = Boundaries::new(&self.map).with_clearance(&self.map);
        let loaded = LoadedWhisker::new(&whisker).unwrap();
        let model = self.model(&boundaries, whisker.length, whole);
        let (mut state, mut held) = (WhiskerState::Free, None);
        let mut seen = Seen::default();
        for pair in self.poses().windows(2) {
            let predicted = model.advance(&mut state, pair[0], pair[1], false);
            let on = |pose: Pose2| WhiskerOnMap::new(&self.map, &boundaries, &loaded, pose);
            let Ok(now) = stepped(&on, held, pair[0], pair[1]) else { break };
            held = now;
            let followed = match state {
                WhiskerState::Touching(contact) if contact.q > 0.0 => Some(contact),
                _ => None,
            };
            let (Some(ours), Some(theirs)) = (followed, held) else {
                if followed.is_some() != held.is_some() {
                    seen.one_alone.push((pair[1], followed.is_some()));
                }
                continue;
            };
            let at = format!("{name}, whole {whole} {pair:?}");
            same_contact(&at, predicted.value, &ours, &theirs);
            seen.count(&theirs.hold);
        }
        // A row may end between the two onsets or lift-offs.
        assert!(seen.one_alone.len() <= MOST_ALONE, "{name}: {seen:?}");
        seen
    }
}

impl Sweep {
    /// Moments, their derivatives and places of a whisker on an elastic base by both, until the branch of the simulation ends; rows with the tip
    /// and with the side in contact.
    fn compare_yielding(&self, whisker: &Whisker) -> [usize; 2] {
        let boundaries = Boundaries::new(&self.map).with_clearance(&self.map);
        let (loaded, tip) = (LoadedWhisker::new(whisker).unwrap(), TipModel::new(whisker).unwrap());
        let base = ElasticBase::of(&tip, SensedQuantity::Moment);
        assert!(base.is_some());
        let model = ForwardModel { base, ..self.model(&boundaries, whisker.length, false) };
        let per = tip.rigidity() / whisker.flexural_rigidity;
        let (mut state, mut held, mut seen) = (WhiskerState::Free, None, [0; 2]);
        let mut alone = 0;
        for pair in self.poses().windows(2) {
            let before = state;
            let predicted = model.advance(&mut state, pair[0], pair[1], false);
            let on = |pose: Pose2| WhiskerOnMap::new(&self.map, &boundaries, &loaded, pose);
            let Ok(now) = stepped(&on, held, pair[0], pair[1]) else { break };
            held = now;
            let (WhiskerState::Touching(ours), Some(theirs)) = (state, held) else {
                alone += usize::from(held.is_some());
                continue;
            };
            let at = format!("{whisker:?} {pair:?}: {ours:?} {theirs:?}");
            assert!((per * predicted.value - theirs.state.m).abs() < 1e-6 * (1.0 + theirs.state.m.abs()), "{at}");
            assert!(ours.place.distance(theirs.place) < 1e-7, "{at}");
            seen[usize::from(matches!(theirs.hold, Hold::Side(..)))] += 1;
            // Derivatives against differences, within one hold.
            if before == WhiskerState::Free {
                continue;
            }
            for (k, step) in [(0, 1e-6), (1, 1e-6), (2, 1e-5)] {
                let mut moved = pair[1];
                [&mut moved.x, &mut moved.y, &mut moved.theta].into_iter().nth(k).map(|v| *v += step).unwrap();
                let mut there = state;
                let beside = model.advance(&mut there, pair[1], moved, false);
                if matches!(there, WhiskerState::Touching(touch) if touch.hold.is_same(&ours.hold)) {
                    let difference = (beside.value - predicted.value) / step;
                    let (told, size) =
                        (predicted.gradient[k], predicted.gradient.iter().map(|g| g.abs()).fold(1.0, f64::max));
                    assert!((difference - told).abs() < 2e-3 * size, "{at}: {k} {difference} {told}");
                }
            }
        }
        assert!(alone <= MOST_ALONE, "{alone} {whisker:?}");
        seen
    }
}

/// The contact of the simulation one row later; an error where its branch ends.
fn stepped<'a>(
    on: &dyn Fn(Pose2) -> WhiskerOnMap<'a>,
    held: Option<Equilibrium>,
    from: Pose2,
    to: Pose2,
) -> Result<Option<Equilibrium>, &'static str> {
    let (mut contact, mut share) = match held {
        Some(contact) => (contact, 0.0),
        None => {
            let start = on(from);
            let Some(share) = first_touch(start.map, &start.whisker.rest, from, to) else { return Ok(None) };
            (onset(&on(between(from, to, share))).ok_or("an onset that is not understood")?, share)
        }
    };
    let mut step = 1.0 - share;
    while share < 1.0 {
        let target = (share + step).min(1.0);
        match (Step { on: on(between(from, to, target)), cone: 0.0 }).next(&contact) {
            Outcome::Touching(next) => (contact, share) = (next, target),
            Outcome::LiftOff => return Ok(None),
            Outcome::Ends(why) => {
                step *= 0.5;
                if step < 0.5_f64.powi(MOST_HALVINGS) {
                    return Err(why);
                }
            }
        }
    }
    Ok(Some(contact))
}

fn map(role: Role, corners: &[(f64, f64)]) -> Map {
    let corners: Vec<Vec2> = corners.iter().map(|&(x, y)| Vec2::new(x, y)).collect();
    let curve = Curve::polyline(&corners, role != Role::Wall).unwrap();
    Map::new(vec![Boundary::new(role, curve, None).unwrap()]).unwrap()
}

fn way(points: &[(f64, f64)]) -> Vec<Vec2> {
    points.iter().map(|&(x, y)| Vec2::new(x, y)).collect()
}

const ROOM: [(f64, f64); 4] = [(0.0, 0.0), (0.5, 0.0), (0.5, 0.5), (0.0, 0.5)];
const BLOCK: [(f64, f64); 4] = [(0.2, 0.2), (0.3, 0.2), (0.3, 0.3), (0.2, 0.3)];

#[test]
fn along_a_wall() {
    for lean in [-0.7, -0.3, 0.3, 0.7_f64] {
        let (heading, height) = (lean - FRAC_PI_2, 0.8 * 0.075 * lean.cos());
        let way = way(&[(0.25, 0.09), (0.25, height), (0.33, height), (0.33, 0.09)]);
        let seen = Sweep { map: map(Role::Arena, &ROOM), heading, way, step: STEP }.compare("along a wall");
        assert!(seen.tip > 300, "{seen:?}");
    }
}

#[test]
fn over_concave_corners() {
    let mut caught = 0;
    // A floor that falls towards the corner and rises behind it.
    let floor = [(0.0, 0.1), (0.25, 0.0), (0.5, 0.1), (0.5, 0.6), (0.0, 0.6)];
    for (lean, x) in [(-0.6_f64, -0.06), (-0.6, 0.06), (-0.2, 0.06), (0.6, -0.06), (0.6, 0.06)] {
        let (heading, height) = (lean - FRAC_PI_2, 0.6 * 0.075 * lean.cos() + 0.012);
        // A tip is caught for some hundredths of a millimetre only: the force turns fast.
        let way = way(&[(0.25 - x, 0.2), (0.25 - x, height), (0.25 + x, height)]);
        let sweep = Sweep { map: map(Role::Arena, &floor), heading, way, step: 0.02 * STEP };
        caught += sweep.compare(&format!("over a corner {lean} {x}")).tip_in_corner;
    }
    assert!(caught > 20, "{caught}");
}

#[test]
fn over_convex_corners_with_the_tip_and_the_side() {
    for (heading, x) in [(-FRAC_PI_2 - 0.5, 0.40), (-FRAC_PI_2 + 0.5, 0.10)] {
        let way = way(&[(0.25, 0.39), (0.25, 0.34), (x, 0.34)]);
        let seen = Sweep { map: map(Role::Obstacle, &BLOCK), heading, way, step: STEP }.compare("off a corner");
        assert!(seen.tip > 50 && seen.side_on_corner > 0, "{seen:?}");
    }
    for heading in [FRAC_PI_2 + 0.2, FRAC_PI_2 + 0.5] {
        let way = way(&[(0.19, 0.16), (0.26, 0.16)]);
        let seen = Sweep { map: map(Role::Obstacle, &BLOCK), heading, way, step: STEP }.compare("side on a corner");
        assert!(seen.side_on_corner > 60, "{seen:?}");
    }
}

#[test]
fn around_something_round() {
    let post: Vec<(f64, f64)> = (0..48)
        .map(|k| f64::from(k) * TAU / 48.0)
        .map(|angle| (0.25 + 0.03 * angle.cos(), 0.25 + 0.03 * angle.sin()))
        .collect();
    let circle = Curve::circle(Vec2::new(0.25, 0.25), 0.03).unwrap();
    let circle = Map::new(vec![Boundary::new(Role::Obstacle, circle, None).unwrap()]).unwrap();
    for (name, map) in [("polygon", map(Role::Obstacle, &post)), ("circle", circle)] {
        for lean in [-0.3, 0.0, 0.3] {
            let sweep = Sweep {
                map: map.clone(),
                heading: lean - FRAC_PI_2,
                way: way(&[(0.19, 0.33), (0.31, 0.33)]),
                step: STEP,
            };
            let seen = sweep.compare(name);
            assert!(seen.tip + seen.side + seen.side_on_corner > 40, "{seen:?}");
        }
        let way = way(&[(0.31, 0.20), (0.25, 0.20)]);
        let seen = Sweep { map, heading: FRAC_PI_2, way, step: STEP }.compare(name);
        assert!(seen.side + seen.side_on_corner > 60, "{seen:?}");
    }
}

#[test]
fn over_the_ends_of_a_thin_wall() {
    // On either side of the wall, drawn in either direction, over both of its ends.
    for (side, drawn) in [(1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)] {
        let end = 0.05 * side * drawn;
        let map = map(Role::Wall, &[(0.25 - end, 0.25), (0.25 + end, 0.25)]);
        for lean in [-0.5, 0.5] {
            // The whisker trails: it leaves the wall over the end ahead.
            let (heading, ahead) = (lean - side * FRAC_PI_2, -lean * side);
            let at = |x: f64, y: f64| (0.25 + x * ahead.signum(), 0.25 + y * side);
            let way = way(&[at(0.0, 0.09), at(0.0, 0.04), at(0.15, 0.04)]);
            let seen = Sweep { map: map.clone(), heading, way, step: STEP }
                .compare(&format!("wall end {side} {drawn} {lean}"));
            assert!(seen.tip > 50 && seen.side_on_corner > 0, "{seen:?}");
        }
    }
}

#[test]
fn along_the_sides_of_posts_with_acute_corners() {
    // Half of the angle at the corner (degrees), over which the whisker leaves with its tip or with its side.
    for half in [10.0, 15.0, 22.0, 30.0, 40.0, 60.0_f64] {
        let wide = 0.12 * half.to_radians().tan();
        let map = map(Role::Obstacle, &[(0.2, 0.25), (0.32, 0.25 - wide), (0.32, 0.25 + wide)]);
        // Along the upper side, towards the corner, with the whisker trailing.
        let side = Vec2::from_angle(half.to_radians());
        for lean in [0.3, 0.6, 0.9_f64] {
            let heading = (side.perp() * -1.0).angle() - lean;
            let base = |along: f64, share: f64| {
                let up = side.perp() * (share * 0.075 * lean.cos());
                Vec2::new(0.2, 0.25) + side * (along + 0.075 * lean.sin()) + up
            };
            let way = vec![base(0.05, 1.3), base(0.05, 0.8), base(-0.08, 0.8)];
            let seen = Sweep { map: map.clone(), heading, way, step: STEP }.compare(&format!("post {half} {lean}"));
            assert!(seen.tip > 100, "{half} {lean} {seen:?}");
        }
    }
}

/// The side of the nearest boundary on which a place is, against windings, all around stars and posts in a room.
#[test]
fn what_is_behind_the_nearest_boundary_is_not_free() {
    let mut seed = 7_u64;
    let mut unit = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1_u64 << 53) as f64
    };
    let (mut behind, mut free) = (0, 0);
    for round in 0..60 {
        // A star with long points, or a post of three corners, in a room.
        let count = if round % 3 == 0 { 3 } else { 14 };
        let post: Vec<Vec2> = (0..count)
            .map(|k| {
                let reach = if k % 2 == 0 { 0.08 + 0.1 * unit() } else { 0.02 + 0.05 * unit() };
                Vec2::new(0.25, 0.25) + Vec2::from_angle(TAU * f64::from(k) / f64::from(count)) * reach
            })
            .collect();
        let outline =
            |role: Role, corners: &[Vec2]| Boundary::new(role, Curve::polyline(corners, true).unwrap(), None).unwrap();
        let map = Map::new(vec![outline(Role::Arena, &way(&ROOM)), outline(Role::Obstacle, &post)]).unwrap();
        let boundaries = Boundaries::new(&map);
        for _ in 0..400 {
            let place = Vec2::new(0.5 * unit(), 0.5 * unit());
            let (piece, at, distance) = boundaries.nearest(&map, place, place, 1.0).unwrap();
            if distance < 1e-9 {
                continue;
            }
            let is_behind = boundaries.is_behind((piece, at), place);
            assert_eq!(is_behind, !map.is_free(place), "round {round}: {place:?} {piece} {at} {distance}");
            if is_behind { behind += 1 } else { free += 1 }
        }
    }
    assert!(behind > 1000 && free > 10_000, "{behind} {free}");
}

#[test]
fn head_on_into_walls_and_hollows() {
    // Radius of a hollow (m), how far the whisker is off its normal (degrees), and which way the base goes on (m).
    let straight = [-4.0, -2.5, -0.5, 0.5, 1.5, 4.0].map(|off| (1e3, off, 0.0));
    let hollow = [-3.5, -1.5, -0.5, 0.5, 2.5].map(|off| (0.12, off, 0.0));
    for (radius, off, aside) in straight.into_iter().chain(hollow).chain([(0.07, -1.5, 0.01), (0.07, 1.5, -0.01)]) {
        let place = |k: i32| {
            let angle = f64::from(k) * 1e-3 / radius;
            (radius * angle.sin(), radius * (1.0 - angle.cos()))
        };
        let map = map(Role::Wall, &(-60..=60).map(place).collect::<Vec<_>>());
        let (length, heading) = (Whisker::default().length, f64::to_radians(off) - FRAC_PI_2);
        let begin = Vec2::new(-(length + 0.003) * heading.cos(), length + 0.003);
        let way = vec![begin, Vec2::new(begin.x + aside, length - 0.015)];
        let unknown = Sweep { map, heading, way, step: 2.0 * STEP }.count_unknown();
        assert!(unknown <= 1, "{radius} {off}: {unknown} rows");
    }
}

#[test]
fn a_base_that_yields_is_followed_around_a_block() {
    let (mut sides, mut tips) = (0, 0);
    for share in [1.5, 6.0, 30.0] {
        let plain = Whisker::default();
        let whisker = Whisker { base_stiffness: share * plain.flexural_rigidity / plain.length, ..plain };
        let ways = [
            (FRAC_PI_2 + 0.2, way(&[(0.19, 0.16), (0.26, 0.16)])),
            (FRAC_PI_2 + 0.5, way(&[(0.19, 0.16), (0.26, 0.16)])),
            (-FRAC_PI_2 - 0.5, way(&[(0.25, 0.39), (0.25, 0.34), (0.40, 0.34)])),
            (-FRAC_PI_2 + 0.5, way(&[(0.25, 0.39), (0.25, 0.34), (0.10, 0.34)])),
        ];
        for (heading, way) in ways {
            let sweep = Sweep { map: map(Role::Obstacle, &BLOCK), heading, way, step: STEP };
            let [tip, side] = sweep.compare_yielding(&whisker);
            (tips, sides) = (tips + tip, sides + side);
        }
    }
    assert!(sides > 200 && tips > 500, "{sides} {tips}");
}
