#![allow(missing_docs, clippy::all)]
use vibrissa::tasks::simulate::discrete::*;
use vibrissa::flow::trajectory::read_tum;
use vibrissa::world::{Map, Robot};
fn main() {
    let name = std::env::args().nth(1).unwrap();
    let links: usize = std::env::args().nth(2).unwrap().parse().unwrap();
    let folder = std::path::Path::new("/work/shared/sweeps");
    let map = Map::read(folder.join(format!("{}.geojson", name.split('-').next().unwrap()))).unwrap();
    let path = read_tum(folder.join(format!("{name}.truth.tum"))).unwrap();
    let exact: Vec<f64> = std::fs::read_to_string(folder.join(format!("{name}.exact.csv"))).unwrap().lines().skip(1).map(|l| l.split(',').nth(1).unwrap().parse().unwrap()).collect();
    let w = Robot::default().whiskers[0].beam;
    let mut rod = DiscreteRod::new(&w, links, path[0].map_from_robot).unwrap();
    let t = std::time::Instant::now();
    let mut bad = 0; let mut odd = 0; let mut worst: f64 = 0.0;
    for (i, p) in path.iter().enumerate() {
        let s = rod.advance(&map, p.map_from_robot);
        let e = (rod.moment() - exact[i]).abs();
        if s != Relaxed::Converged { bad += 1; println!("row {i} {s:?}"); }
        if e > 1e-6_f64.max(1e-3*exact[i].abs()) { odd += 1; println!("row {i}: {} vs {} {:?}", rod.moment(), exact[i], rod.presses()); }
        worst = worst.max(e / exact[i].abs().max(1e-4));
    }
    println!("{name}: {} rows, bad {bad}, odd {odd}, worst {worst:e}, {:.3} ms/row", path.len(), t.elapsed().as_secs_f64()*1e3/path.len() as f64);
}
