//! Look-ups in the tree against testing every edge.

#[path = "../../vibrissa/tests/data/random.rs"]
mod random;

use random::Random;
use vibrissa_beam::plane::{SegmentTree, Vec2, segment_contact};

type Edge = [Vec2; 2];

fn edges(random: &mut Random, count: usize, size: f64, on_grid: bool) -> Vec<Edge> {
    let mut point = |c: Vec2, s: f64| {
        let p = Vec2::new(c.x + random.signed(s), c.y + random.signed(s));
        if on_grid { Vec2::new(p.x.round(), p.y.round()) } else { p }
    };
    (0..count)
        .map(|_| {
            let a = point(Vec2::ZERO, 10.0);
            [a, point(a, size)]
        })
        .collect()
}

/// Distance to a segment by a route of its own: the foot of the perpendicular when it is inside, else the nearer end.
fn distance(p: Vec2, [a, b]: Edge) -> f64 {
    let (along, to_p) = (b - a, p - a);
    let inside = to_p.dot(along) > 0.0 && (p - b).dot(along) < 0.0;
    if inside { (along.cross(to_p) / along.norm()).abs() } else { p.distance(a).min(p.distance(b)) }
}

#[test]
fn nearest_point() {
    let mut random = Random(3);
    for (count, size) in [(0, 1.0), (1, 1.0), (4, 5.0), (5, 0.0), (300, 0.5), (300, 20.0)] {
        let edges = edges(&mut random, count, size, false);
        let tree = SegmentTree::new(&edges);
        for _ in 0..200 {
            let p = Vec2::new(random.signed(15.0), random.signed(15.0));
            let best = edges.iter().map(|e| distance(p, *e)).min_by(f64::total_cmp);
            let found = tree.nearest(p);
            assert_eq!(found.is_some(), best.is_some());
            if let (Some(found), Some(best)) = (found, best) {
                assert!((found.distance - best).abs() < 1e-12);
                let [a, b] = edges[found.edge];
                assert!((a + (b - a) * found.t).distance(found.point) < 1e-12);
            }
        }
        assert!(tree.nearest(Vec2::new(f64::NAN, 0.0)).is_none());
    }
}

/// Contact in exact arithmetic on a small integer grid.
fn touch_exactly([a, b]: Edge, [c, d]: Edge) -> bool {
    let i = |v: f64| v as i64;
    let turn = |p: Vec2, q: Vec2, r: Vec2| {
        ((i(q.x) - i(p.x)) * (i(r.y) - i(p.y)) - (i(q.y) - i(p.y)) * (i(r.x) - i(p.x))).signum()
    };
    let between = |p: Vec2, q: Vec2, r: Vec2| {
        i(r.x) >= i(p.x).min(i(q.x))
            && i(r.x) <= i(p.x).max(i(q.x))
            && i(r.y) >= i(p.y).min(i(q.y))
            && i(r.y) <= i(p.y).max(i(q.y))
    };
    let (s1, s2, s3, s4) = (turn(a, b, c), turn(a, b, d), turn(c, d, a), turn(c, d, b));
    (s1 != s2 && s3 != s4)
        || (s1 == 0 && between(a, b, c))
        || (s2 == 0 && between(a, b, d))
        || (s3 == 0 && between(c, d, a))
        || (s4 == 0 && between(c, d, b))
}

#[test]
fn contacts_on_a_grid() {
    let mut random = Random(11);
    let mut hits = 0;
    for _ in 0..20 {
        let edges = edges(&mut random, 60, 4.0, true);
        let tree = SegmentTree::new(&edges);
        for (i, e) in edges.iter().enumerate() {
            for f in &edges[i + 1..] {
                let exact = touch_exactly(*e, *f);
                hits += usize::from(exact);
                assert_eq!(segment_contact(e[0], e[1], f[0], f[1]).is_some(), exact, "{e:?} {f:?}");
            }
        }
        let probe = [Vec2::new(random.signed(9.0).round(), 3.0), Vec2::new(random.signed(9.0).round(), -2.0)];
        assert_eq!(tree.crosses(probe[0], probe[1]), edges.iter().any(|e| touch_exactly(*e, probe)));
    }
    assert!(hits > 500);
}

#[test]
fn crossings_and_self_intersections() {
    let mut random = Random(5);
    for size in [0.3, 3.0] {
        let edges = edges(&mut random, 400, size, false);
        let tree = SegmentTree::new(&edges);
        let mut pairs = Vec::new();
        for (i, e) in edges.iter().enumerate() {
            for (j, f) in edges.iter().enumerate().skip(i + 1) {
                if segment_contact(e[0], e[1], f[0], f[1]).is_some() {
                    pairs.push((i, j));
                }
            }
        }
        let found = tree.self_intersections();
        assert!(
            found.iter().all(|x| distance(x.point, edges[x.first]) < 1e-9 && distance(x.point, edges[x.second]) < 1e-9)
        );
        assert_eq!(found.iter().map(|x| (x.first, x.second)).collect::<Vec<_>>(), pairs);
        for _ in 0..300 {
            let e = [
                Vec2::new(random.signed(12.0), random.signed(12.0)),
                Vec2::new(random.signed(12.0), random.signed(12.0)),
            ];
            let brute = edges.iter().any(|f| segment_contact(e[0], e[1], f[0], f[1]).is_some());
            assert_eq!(tree.crosses(e[0], e[1]), brute);
        }
    }
}

/// A star-shaped polygon with `count` corners.
fn star(count: usize) -> Vec<Edge> {
    let corner = |k: usize| {
        let angle = std::f64::consts::TAU * k as f64 / count as f64;
        Vec2::from_angle(angle) * (1.0 + 0.3 * (7.0 * angle).sin())
    };
    (0..count).map(|k| [corner(k), corner((k + 1) % count)]).collect()
}

#[test]
fn inside_a_polygon() {
    let mut random = Random(9);
    let tree = SegmentTree::new(&star(5000));
    for _ in 0..2000 {
        let p = Vec2::new(random.signed(1.5), random.signed(1.5));
        let limit = 1.0 + 0.3 * (7.0 * p.angle()).sin();
        if (p.norm() - limit).abs() > 1e-3 {
            assert_eq!(tree.ray_crossings(p) % 2 == 1, p.norm() < limit);
        }
    }
    // Rays through corners.
    let square = [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)].map(|(x, y)| Vec2::new(x, y));
    let diamond = SegmentTree::new(&std::array::from_fn::<_, 4, _>(|k| [square[k], square[(k + 1) % 4]]));
    assert_eq!(diamond.ray_crossings(Vec2::ZERO), 1);
    assert_eq!(diamond.ray_crossings(Vec2::new(-2.0, 0.0)), 2);
    assert_eq!(diamond.ray_crossings(Vec2::new(-2.0, 1.0)) % 2, 0);
}
