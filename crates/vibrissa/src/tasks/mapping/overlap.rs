//! Later contacts on earlier walls: point to line \[chen1992object\], within closures that are proved. A wall that has moved would draw the map along, so
//! that contacts are weighed by Cauchy's function of their distance, by iterated reweighting \[holland1977robust\].

use super::changes::Outdated;
use super::front_end::{FrontEnd, StretchPoint};
use super::graph::{Overlap, Solution};
use crate::config::MappingOptions;
use crate::plane::Pose2;

/// A proved closure: two key poses, where the later one is in the frame of the earlier one, and half of what is left open.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tie {
    pub(super) earlier: usize,
    pub(super) later: usize,
    pub(super) earlier_from_later: Pose2,
    pub(super) extent: [f64; 3],
}

/// Normals that belong together differ by less (cosine): 25 degrees.
const SAME_WAY: f64 = 0.9;
/// Farthest along the wall from a later contact to an earlier point (m): neighbours are half a millimetre apart.
const ALONG: f64 = 1.5e-3;
/// How far across the wall they may be once poses have been solved (m), beside what is left open before.
const ACROSS: f64 = 3e-3;
/// Where the weight of a contact begins to fall (standard deviations): 95 % of what least squares is worth where errors are Gaussian.
const CAUCHY: f64 = 2.385;
/// Later contacts are taken this far apart (m), and what both traces of a wall leave is alike over this length.
const SPACING: f64 = 2e-3;
const ALIKE: f64 = 20e-3;

/// What lies on what, by the closures themselves or by a solution, which is near the last one or not; earlier points that no longer hold
/// are left out.
pub(super) fn overlaps(
    front: &FrontEnd,
    ties: &[Tie],
    solution: Option<(&Solution, bool)>,
    outdated: &Outdated,
    options: &MappingOptions,
) -> Vec<Overlap> {
    let mut all = Vec::new();
    for tie in ties {
        let across = solution.map_or(ACROSS + tie.extent[0].max(tie.extent[1]), |_| ACROSS);
        let [earlier, later] = [tie.earlier, tie.later].map(|key| front.within(key, options.submap));
        // Of neighbouring closures a later contact is taken once.
        let taken = all.last().map_or(0, |overlap: &Overlap| overlap.later.0 + 1);
        for key in later.0.max(taken)..=later.1 {
            let earlier_from_later = |early: usize| match solution {
                Some((solution, _)) => solution.poses[early].between(solution.poses[key]),
                None => {
                    let to_middle = front.keys[tie.later].odom_from_key.between(front.keys[key].odom_from_key);
                    let from_middle = front.keys[tie.earlier].odom_from_key.between(front.keys[early].odom_from_key);
                    from_middle.inverse().compose(tie.earlier_from_later).compose(to_middle)
                }
            };
            let moves: Vec<(usize, Pose2)> = (earlier.0..=earlier.1).map(|k| (k, earlier_from_later(k))).collect();
            for stretch in front.stretches.iter().filter(|stretch| stretch.key == key) {
                let is_near = solution.is_some_and(|(_, is_near)| is_near);
                add((front, outdated), (key, &stretch.points), &moves, (across, is_near), &mut all);
            }
        }
    }
    all
}

fn add(
    (front, outdated): (&FrontEnd, &Outdated),
    (key, points): (usize, &[StretchPoint]),
    moves: &[(usize, Pose2)],
    (across, is_near): (f64, bool),
    all: &mut Vec<Overlap>,
) {
    let mut last = None;
    for point in points {
        if last.is_some_and(|last: crate::plane::Vec2| last.distance(point.position) < SPACING) {
            continue;
        }
        let candidates = moves.iter().flat_map(|(early, to_earlier)| {
            let (place, normal) = (to_earlier.transform_point(point.position), point.normal.rotated(to_earlier.theta));
            let of_key = front.stretches.iter().enumerate().filter(move |(_, stretch)| stretch.key == *early);
            let points = of_key.flat_map(|(index, stretch)| {
                stretch.points.iter().enumerate().map(move |(k, other)| ((index, k), other))
            });
            points.filter_map(move |(index, other)| {
                let gap = place - other.position;
                let (off, along) = (other.normal.dot(gap).abs(), other.normal.cross(gap).abs());
                let fits = normal.dot(other.normal) > SAME_WAY && off <= across && along <= ALONG;
                (fits && !outdated.contains(&index)).then_some((off + along, off, *early, other))
            })
        });
        let Some((_, off, early, other)) = candidates.min_by(|a, b| a.0.total_cmp(&b.0)) else { continue };
        last = Some(point.position);
        let std = spread(point, other);
        all.push(Overlap {
            later: (key, point.position),
            earlier: (early, other.position),
            normal: other.normal,
            std: if is_near { std * (off / (CAUCHY * std)).hypot(1.0) } else { std },
        });
    }
}

/// The standard deviation of the distance between two traces of one wall (m), shared among neighbours that all say the same.
fn spread(point: &StretchPoint, other: &StretchPoint) -> f64 {
    (ALIKE / SPACING).sqrt() * point.std.hypot(other.std)
}
