#![allow(missing_docs, clippy::all)]
use vibrissa::tasks::simulate::*;
use vibrissa::plane::*;
use vibrissa::flow::pose::StampedPose;
use vibrissa::world::*;
fn bd(role: Role, c: Option<Curve>) -> Boundary { Boundary::new(role, c.unwrap(), None).unwrap() }
struct R(u64);
impl R { fn u(&mut self) -> f64 { self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15); let mut z = self.0; z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9); z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb); ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64 }
 fn s(&mut self, a: f64) -> f64 { (2.0*self.u()-1.0)*a } }
fn main() {
    let verbose = std::env::args().nth(3).is_some();
    let lo: u64 = std::env::args().nth(1).unwrap().parse().unwrap();
    let hi: u64 = std::env::args().nth(2).unwrap().parse().unwrap();
    let (mut worst_all, mut rows_all, mut odd_all, mut chain_rows, mut t_fast, mut t_slow) = (0.0f64, 0, 0, 0, 0.0, 0.0);
    for seed in lo..hi {
        let mut r = R(seed * 7919 + 13);
        let c = Vec2::new(r.s(0.02), 0.03 + 0.05 * r.u());
        let boundary = match seed % 4 {
            0 => bd(Role::Obstacle, Curve::circle(c, 0.005 + 0.03 * r.u())),
            1 => { let n = 3 + (r.u() * 5.0) as usize; let a0 = r.s(3.0); let rad = 0.005 + 0.02 * r.u();
                let pts: Vec<Vec2> = (0..n).map(|i| c + Vec2::from_angle(a0 + i as f64 * std::f64::consts::TAU / n as f64) * rad).collect();
                bd(Role::Obstacle, Curve::polyline(&pts, true)) }
            2 => { let d = Vec2::from_angle(r.s(3.0)) * 0.03; bd(Role::Wall, Curve::polyline(&[c - d, c + d], false)) }
            _ => { let d = Vec2::from_angle(r.s(3.0)) * 0.03; let e = Vec2::from_angle(r.s(3.0)) * 0.03; bd(Role::Wall, Curve::polyline(&[c - d, c, c + e], false)) }
        };
        let map = Map::new(vec![boundary]).unwrap();
        let th = 1.57 + r.s(1.2);
        let y = -0.03 + 0.03 * r.u();
        let poses = [Pose2::new(-0.15, y, th), Pose2::new(0.15, y + r.s(0.01), th + r.s(0.4))];
        let path: Vec<StampedPose> = path_through(&poses, &Pace { speed: 0.15, turn_rate: 1.0, rate: 150.0 }).unwrap();
        let t = std::time::Instant::now();
        let fast = match simulate(&map, &Robot::default(), &path, &SweepNoise::none(), &SimulateOptions::default()) { Ok(s) => s, Err(e) => { println!("{seed}: {e}"); continue } };
        let tf = t.elapsed().as_secs_f64();
        let t = std::time::Instant::now();
        let slow = simulate(&map, &Robot::default(), &path, &SweepNoise::none(), &SimulateOptions { solver: Solver::DiscreteRod, ..SimulateOptions::default() }).unwrap();
        let ts = t.elapsed().as_secs_f64();
        t_fast += tf; t_slow += ts;
        let mut odd = vec![]; let mut worst = 0.0f64;
        for i in 0..path.len() {
            let (a, b) = (fast.exact_moments[i][0], slow.exact_moments[i][0]);
            let e = (a - b).abs();
            if e > 2e-6 + 1e-3 * b.abs() { odd.push((i, a, b)); } else { worst = worst.max(e / (b.abs() + 1e-4)); }
        }
        let touching = fast.exact_moments.iter().filter(|m| m[0] != 0.0).count();
        rows_all += touching; odd_all += odd.len(); worst_all = worst_all.max(worst);
        let mut inchain = false; let mut ev = fast.events.iter().peekable();
        for p in &path { while ev.peek().is_some_and(|e| e.t <= p.t) { let k = ev.next().unwrap().kind; inchain = match k { "discrete_rod" => true, "single_contact" | "snap" | "lift_off" | "onset" | "lost" => false, _ => inchain }; } if inchain { chain_rows += 1; } }
        if odd.len() > 0 || verbose {
            println!("{seed}: touching {touching} odd {} worst {worst:.1e} t {:.1} {:.1} ms", odd.len(), tf*1e3, ts*1e3);
            for e in &fast.events { println!("   F {:.4} {} {}", e.t, e.kind, e.detail); }
            for e in &slow.events { println!("   S {:.4} {} {}", e.t, e.kind, e.detail); }
            for (i, a, b) in odd.iter().take(4) { println!("   row {i} t {:.4}: {a:.6e} {b:.6e}", path[*i].t); 
              for c in fast.contacts.iter().filter(|c| c.row == *i) { println!("      F s {:.5} at {:.5} {:.5} f {:.4} {:.4} {:?}", c.s_a, c.position.x, c.position.y, c.force.x, c.force.y, c.part); }
              for c in slow.contacts.iter().filter(|c| c.row == *i) { println!("      S s {:.5} at {:.5} {:.5} f {:.4} {:.4}", c.s_a, c.position.x, c.position.y, c.force.x, c.force.y); } }
        }
    }
    println!("rows {rows_all}, odd {odd_all}, chain rows {chain_rows}, worst else {worst_all:.2e}; {:.2} s fast, {:.2} s slow", t_fast, t_slow);
}
