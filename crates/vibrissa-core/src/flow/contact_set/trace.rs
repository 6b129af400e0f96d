//! Curves of equal reading, traced over the plane of load number and arc length: for whiskers without a closed family.
//!
//! The reading is known at the nodes of a grid of triangles; where it passes the value on an edge, the place is found to
//! rounding, and the places of neighbouring edges make the curve. So every branch and every fold is found that the grid can
//! see, and each node of the curve is a true contact.

use super::{Contact, ContactModel, VirtualSensor};
use crate::math;
use std::collections::BTreeMap;

/// Arc lengths and load numbers of the grid.
const ROWS: usize = 40;
const COLUMNS: usize = 97;
/// Steps of the search along an edge.
const STEPS: usize = 60;

/// A grid edge by its two nodes, the lower first.
type GridEdge = (usize, usize);

/// The grid: contacts at the nodes, and how much more than the value each reads.
struct Grid<'a> {
    model: &'a ContactModel,
    sensor: VirtualSensor,
    value: f64,
    /// Stretched load number of the last column.
    last: f64,
    excess: Vec<f64>,
}

/// All branches on which `sensor` reads `value`, within whisker and limits.
pub(super) fn traced(model: &ContactModel, sensor: VirtualSensor, value: f64, nodes: usize) -> Vec<Vec<Contact>> {
    let last = math::asinh(2.0 * model.last_load_number());
    let mut grid = Grid { model, sensor, value, last, excess: Vec::with_capacity(ROWS * COLUMNS) };
    for node in 0..ROWS * COLUMNS {
        let (s, v) = grid.place(node);
        grid.excess.push(grid.at(s, v).map_or(f64::NAN, |(_, excess)| excess));
    }
    let chains = grid.chains();
    chains.into_iter().flat_map(|chain| grid.admitted(&chain, nodes)).collect()
}

impl Grid<'_> {
    fn place(&self, node: usize) -> (f64, f64) {
        let (row, column) = (node / COLUMNS, node % COLUMNS);
        let first = self.model.first_arc_length();
        let s = first + (self.model.length() - first) * row as f64 / (ROWS - 1) as f64;
        (s, self.last * (2.0 * column as f64 / (COLUMNS - 1) as f64 - 1.0))
    }

    /// What counts as one in readings: the value, or where it is smaller what a strong load gives.
    fn scale(&self) -> f64 {
        let length = self.model.length();
        let typical = if self.sensor == VirtualSensor::Slope { 1.0 } else { self.model.force_of(1.0, length) * length };
        self.value.abs().max(typical)
    }

    /// The contact at arc length `s` and stretched load number `v`, and its excess.
    fn at(&self, s: f64, v: f64) -> Option<(Contact, f64)> {
        let contact = self.model.contact(self.model.force_of(0.5 * math::sinh(v), s), s)?;
        Some((contact, self.sensor.read(&contact) - self.value))
    }

    /// The place on an edge where the sensor reads the value.
    fn crossing(&self, (a, b): GridEdge) -> Option<(f64, f64)> {
        let (pa, pb) = (self.place(a), self.place(b));
        let on = |t: f64| (pa.0 + t * (pb.0 - pa.0), pa.1 + t * (pb.1 - pa.1));
        self.root(&|t| on(t), self.excess[a], self.excess[b])
    }

    /// The place on a path from 0 to 1 where the excess vanishes: false position with bisection against its slowness.
    fn root(&self, on: &dyn Fn(f64) -> (f64, f64), start: f64, end: f64) -> Option<(f64, f64)> {
        let (mut lo, mut hi, mut at_lo, mut at_hi) = (0.0, 1.0, start, end);
        for step in 0..STEPS {
            let t = if step % 3 == 2 { 0.5 * (lo + hi) } else { lo + (hi - lo) * (at_lo / (at_lo - at_hi)) };
            let (s, v) = on(t);
            let excess = self.at(s, v)?.1;
            if excess.abs() <= 1e-14 * self.scale() || hi - lo < 1e-14 {
                return Some(on(t));
            }
            if (excess > 0.0) == (at_lo > 0.0) { (lo, at_lo) = (t, excess) } else { (hi, at_hi) = (t, excess) }
        }
        Some(on(0.5 * (lo + hi)))
    }

    fn is_crossed(&self, (a, b): GridEdge) -> bool {
        let (x, y) = (self.excess[a], self.excess[b]);
        !x.is_nan() && !y.is_nan() && (x > 0.0) != (y > 0.0)
    }

    /// The curves as chains of places: triangles join the two edges that the value crosses.
    fn chains(&self) -> Vec<Vec<(f64, f64)>> {
        let mut joined: BTreeMap<GridEdge, Vec<GridEdge>> = BTreeMap::new();
        let edge = |a: usize, b: usize| (a.min(b), a.max(b));
        for row in 0..ROWS - 1 {
            for column in 0..COLUMNS - 1 {
                let corner = row * COLUMNS + column;
                let (right, up, far) = (corner + 1, corner + COLUMNS, corner + COLUMNS + 1);
                for [a, b, c] in [[corner, right, far], [corner, far, up]] {
                    let crossed: Vec<GridEdge> =
                        [edge(a, b), edge(b, c), edge(c, a)].into_iter().filter(|&e| self.is_crossed(e)).collect();
                    // With a node beyond the first mode, a single edge may be crossed: the curve leaves the grid there.
                    if let [p, q] = crossed[..] {
                        joined.entry(p).or_default().push(q);
                        joined.entry(q).or_default().push(p);
                    }
                }
            }
        }
        let mut chains = Vec::new();
        // Open curves from their ends, then closed ones from anywhere.
        for ends_only in [true, false] {
            let starts: Vec<GridEdge> = joined.keys().copied().collect();
            for start in starts {
                let degree = joined.get(&start).map_or(0, Vec::len);
                if degree == 1 || (!ends_only && degree > 0) {
                    let edges = walk(&mut joined, start);
                    chains.push(edges.into_iter().filter_map(|e| self.crossing(e)).collect());
                }
            }
        }
        chains
    }

    /// The pieces of a chain within the limits, thinned or refined to about `nodes` contacts each.
    fn admitted(&self, chain: &[(f64, f64)], nodes: usize) -> Vec<Vec<Contact>> {
        if chain.len() < 2 {
            return Vec::new();
        }
        let last = (chain.len() - 1) as f64;
        let on = |t: f64| {
            let i = (t.floor().max(0.0) as usize).min(chain.len() - 2);
            let (share, (a, b)) = (t - i as f64, (chain[i], chain[i + 1]));
            (a.0 + share * (b.0 - a.0), a.1 + share * (b.1 - a.1))
        };
        // The chord between two true places is left along the grid's direction in which the reading changes the most.
        let at = |t: f64| self.corrected(on(t)).filter(|c| self.model.limits().admit(c));
        super::family::along([0.0, last], &[], nodes, &at)
    }

    /// The contact next to a place that reads the value, by Newton's method up the gradient.
    fn corrected(&self, (mut s, mut v): (f64, f64)) -> Option<Contact> {
        let (ds, dv) = (1e-6 * self.model.length(), 1e-6);
        for _ in 0..8 {
            let (contact, excess) = self.at(s, v)?;
            if excess.abs() <= 1e-13 * self.scale() {
                return Some(contact);
            }
            let length = self.model.length();
            // One-sided at the tip and at the end of the first mode.
            let (step_s, step_v) = (if s + ds > length { -ds } else { ds }, if v > 0.0 { -dv } else { dv });
            let by_s = (self.at(s + step_s, v)?.1 - excess) / step_s * length;
            let by_v = (self.at(s, v + step_v)?.1 - excess) / step_v;
            let square = by_s * by_s + by_v * by_v;
            s = (s - excess * by_s / square * length).clamp(self.model.first_arc_length(), length);
            v -= excess * by_v / square;
        }
        self.at(s, v)
            .map(|(contact, _)| contact)
            .filter(|c| (self.sensor.read(c) - self.value).abs() <= 1e-9 * self.scale())
    }
}

/// Takes the chain that starts at `start` out of the graph.
fn walk(joined: &mut BTreeMap<GridEdge, Vec<GridEdge>>, start: GridEdge) -> Vec<GridEdge> {
    let mut chain = vec![start];
    let mut here = start;
    while let Some(next) = joined.get_mut(&here).and_then(Vec::pop) {
        if let Some(back) = joined.get_mut(&next)
            && let Some(i) = back.iter().position(|&e| e == here)
        {
            back.swap_remove(i);
        }
        chain.push(next);
        here = next;
    }
    chain
}
