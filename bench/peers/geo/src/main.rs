//! The jobs of `polygons.py` with the crate `geo`; reads the two curves, 200 points each, from standard input.

use geo::algorithm::line_intersection::{LineIntersection, line_intersection};
use geo::{BooleanOps, Buffer, Line, LineString, MultiPolygon, polygon};
use std::hint::black_box;
use std::io::Read;
use std::time::Instant;

const CROSSING: &str = "Intersection of two contact curves of 200 points";
const STRIP: &str = "Where a robot may be that touches a boundary of 2 m";

/// Median, least and largest seconds a call of nine batches.
fn row(table: &str, name: &str, remark: &str, mut call: impl FnMut()) {
    let mut repeat = 1u32;
    loop {
        let begin = Instant::now();
        (0..repeat).for_each(|_| call());
        if begin.elapsed().as_secs_f64() > 0.02 {
            break;
        }
        repeat *= 2;
    }
    let mut times: Vec<f64> = (0..9)
        .map(|_| {
            let begin = Instant::now();
            (0..repeat).for_each(|_| call());
            begin.elapsed().as_secs_f64() / f64::from(repeat)
        })
        .collect();
    times.sort_by(f64::total_cmp);
    println!("row\t{table}\t{name}\t{:.6e}\t{:.6e}\t{:.6e}\t{remark}", times[4], times[0], times[8]);
}

/// Every crossing, each pair of links looked at once.
fn crossings(a: &LineString, b: &LineString) -> usize {
    let meets = |p: Line, q: Line| matches!(line_intersection(p, q), Some(LineIntersection::SinglePoint { .. }));
    a.lines().map(|p| b.lines().filter(|&q| meets(p, q)).count()).sum()
}

fn main() {
    let mut text = String::new();
    std::io::stdin().read_to_string(&mut text).expect("the curves are text");
    let numbers: Vec<f64> = text.split_whitespace().map(|word| word.parse().expect("a number")).collect();
    let points: Vec<(f64, f64)> = numbers.chunks_exact(2).map(|pair| (pair[0], pair[1])).collect();
    let (a, b) = points.split_at(points.len() / 2);
    let (a, b) = (LineString::from(a.to_vec()), LineString::from(b.to_vec()));
    let found = crossings(&a, &b);
    row(CROSSING, "geo, every pair of links", &format!("chords only; {found} crossing"), || {
        black_box(crossings(black_box(&a), &b));
    });
    let room = polygon![(x: 0.0, y: 0.0), (x: 0.5, y: 0.0), (x: 0.5, y: 0.5), (x: 0.0, y: 0.5)];
    row(STRIP, "geo", "the strip alone: no headings, no collisions", || {
        let strip: MultiPolygon = black_box(&room).exterior().buffer(0.0697);
        black_box(strip.intersection(&room));
    });
}
