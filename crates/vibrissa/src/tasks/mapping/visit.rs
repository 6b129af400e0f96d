//! Where a later log begins in the outline of those before: global localization by set inversion \[jaulin2009robust\], with the outline for all
//! there is.
//!
//! Every contact lies on a wall that was felt, or where nobody felt whether there is one; no wall that was felt lies deep in the space that was passed
//! later. Submaps along the log are placed one by one until two that agree within the odometry's bounds say the same.

use super::closure::{PoseBounds, PoseBox, Proof, Resolution, Submap, by_longer_submaps, one_place};
use super::front_end::FrontEnd;
use super::overlap::Tie;
use super::submap::{submap, way_bounds};
use super::{ClosureVerdict, Solution};
use crate::Stop;
use crate::config::MappingOptions;
use crate::plane::{Pose2, Vec2};
use crate::world::{Map, PieceCourse, Robot};
use core::f64::consts::PI;

/// Where a log begins: the tie of one of its key poses to one of those before, if that is proved.
pub(super) struct Placed {
    pub(super) verdict: ClosureVerdict,
    /// How many places are left.
    pub(super) places: usize,
    pub(super) tie: Option<Tie>,
}

/// The outline, and what nobody knows of it.
struct Walls<'a> {
    map: &'a Map,
    /// Ends of unknown stretches, and how far walls may be from them (m).
    unknown: Vec<([Vec2; 2], f64)>,
}

impl<'a> Walls<'a> {
    fn of(map: &'a Map) -> Self {
        let unknown = map.boundaries().iter().flat_map(|boundary| {
            let pieces = boundary.curve().segments().iter().enumerate();
            pieces.filter_map(|(k, segment)| match boundary.piece_course(k)? {
                PieceCourse::Unknown(depth) => Some(([segment.start(), segment.end()], depth)),
                PieceCourse::Band(_) => None,
            })
        });
        Self { map, unknown: unknown.collect() }
    }

    /// No wall is nearer to a place than this (m).
    fn away(&self, place: Vec2) -> f64 {
        let nearest =
            self.map.nearest(place).map_or(f64::INFINITY, |nearest| nearest.distance - self.map.widest_bound());
        let gap = |([a, b], depth): &([Vec2; 2], f64)| {
            let along = *b - *a;
            let share = ((place - *a).dot(along) / along.norm_squared().max(1e-18)).clamp(0.0, 1.0);
            place.distance(*a + along * share) - depth
        };
        self.unknown.iter().map(gap).fold(nearest, f64::min)
    }
}

/// A submap that has one place in the outline.
struct Found {
    key: usize,
    map_from_key: PoseBounds,
}

/// Places a log in the outline of those before, whose key poses are `solution`'s; of these `is_known` tells which have a place.
pub(super) fn place(
    (front, visit): (&FrontEnd, usize),
    (map, solution, is_known): (&Map, &Solution, &dyn Fn(usize) -> bool),
    robot: &Robot,
    options: &MappingOptions,
    stop: &Stop,
) -> Placed {
    let walls = Walls::of(map);
    let felt: Vec<(Vec2, f64)> = map
        .samples(options.contact_spacing)
        .iter()
        .filter_map(|sample| {
            let boundary = &map.boundaries()[sample.boundary];
            let course = boundary.piece_course(boundary.curve().segment_at(sample.arc_length));
            course.and_then(|course| course.widest()).map(|band| (sample.position, band.bound))
        })
        .collect();
    // Whiskers that touch the outline are no farther from it.
    let bounds = map.bounds().inflated(options.submap);
    let middle = (bounds.min + bounds.max) * 0.5;
    let whole = PoseBounds {
        middle: Pose2::new(middle.x, middle.y, 0.0),
        half: [0.5 * bounds.size().x, 0.5 * bounds.size().y, PI],
    };
    let keys = front.visit(visit);
    let known: Vec<usize> = (0..keys.start).filter(|key| is_known(*key)).collect();
    let (mut found, mut left): (Vec<Found>, Option<(ClosureVerdict, usize)>) = (Vec::new(), None);
    let whole_way: f64 = front.keys[keys.clone()].iter().skip(1).map(|key| key.leg.way).sum();
    let (mut way, mut due) = (0.0, options.submap.min(0.5 * whole_way));
    for key in keys.clone() {
        way += if key > keys.start { front.keys[key].leg.way } else { 0.0 };
        if way < due || stop.is_asked() {
            continue;
        }
        due = way + options.submap;
        let bounds = options.same_start.map_or(whole, |(place, turn)| {
            let start = PoseBounds { middle: solution.poses[0], half: [place, place, turn] };
            start.then(way_bounds(front, robot, options.drift, (keys.start, key)))
        });
        match in_outline((front, key), (&walls, &felt), bounds, (robot, options), stop) {
            Some(Proof::Unique(map_from_key)) => {
                let agrees = |other: &Found| {
                    let between = way_bounds(front, robot, options.drift, (other.key, key));
                    meet(other.map_from_key.then(between), map_from_key)
                };
                if let Some(other) = found.iter().find(|other| agrees(other)) {
                    return tied(solution, other, &known);
                }
                found.push(Found { key, map_from_key });
            }
            Some(Proof::Open(places, _)) => left = left.or(Some((ClosureVerdict::Hypothesis, places))),
            Some(Proof::Unfinished) => left = left.or(Some((ClosureVerdict::Unfinished, 0))),
            Some(Proof::Contradiction) => left = left.or(Some((ClosureVerdict::Contradiction, 0))),
            None => {}
        }
    }
    match &found[..] {
        [only] => tied(solution, only, &known),
        [] => {
            let (verdict, places) = left.unwrap_or((ClosureVerdict::Hypothesis, 0));
            Placed { verdict, places, tie: None }
        }
        several => Placed { verdict: ClosureVerdict::Hypothesis, places: several.len(), tie: None },
    }
}

/// What submaps around a key pose leave of all poses in the outline; none with too few contacts.
fn in_outline(
    (front, key): (&FrontEnd, usize),
    (walls, felt): (&Walls<'_>, &[(Vec2, f64)]),
    whole: PoseBounds,
    (robot, options): (&Robot, &MappingOptions),
    stop: &Stop,
) -> Option<Proof> {
    by_longer_submaps(options, whole, stop, &|reach, bounds| {
        let here = submap(front, robot, options, (key, reach))?;
        let contradicts =
            |poses: &PoseBox| is_off_the_walls(&here, walls, poses) || poses.is_in_passed(felt, &here.passed);
        Some(one_place(&contradicts, bounds, Resolution::of(options), stop))
    })
}

/// Whether every pose of a box puts a contact where no wall is.
fn is_off_the_walls(here: &Submap, walls: &Walls<'_>, poses: &PoseBox) -> bool {
    here.contacts.iter().any(|(contact, off)| {
        let (there, open) = poses.there(*contact);
        walls.away(there) > open + off
    })
}

/// Whether two sets of poses have one in common, as far as their bounds tell.
fn meet(a: PoseBounds, b: PoseBounds) -> bool {
    let gap =
        [a.middle.x - b.middle.x, a.middle.y - b.middle.y, crate::plane::wrap_angle(a.middle.theta - b.middle.theta)];
    (0..3).all(|k| gap[k].abs() <= a.half[k] + b.half[k])
}

/// A place in the outline as a tie to the nearest key pose that is known.
fn tied(solution: &Solution, found: &Found, known: &[usize]) -> Placed {
    let place = found.map_from_key.middle.position();
    let near = |k: &usize| solution.poses[*k].position().distance(place);
    let earlier = known.iter().copied().min_by(|a, b| near(a).total_cmp(&near(b)));
    let tie = earlier.map(|earlier| {
        let exact = PoseBounds { middle: solution.poses[earlier].inverse(), half: [0.0; 3] };
        let PoseBounds { middle, half } = exact.then(found.map_from_key);
        Tie { earlier, later: found.key, earlier_from_later: middle, extent: half }
    });
    Placed { verdict: ClosureVerdict::Proved, places: 1, tie }
}
