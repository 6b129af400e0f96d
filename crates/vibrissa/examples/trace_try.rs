//! try
#![allow(clippy::unwrap_used, clippy::expect_used, missing_docs)]
use vibrissa::beam::Whisker;
use vibrissa::flow::sensor_log::SensorLog;
use vibrissa::plane::*;
use vibrissa::tasks::profile::*;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let name = &a[1];
    let turn: f64 = a[2].parse().unwrap();
    let step: f64 = a[3].parse().unwrap();
    let spacing: f64 = a[4].parse().unwrap();
    let log = SensorLog::read(format!("../shared/sweeps/{name}.csv")).unwrap();
    let truth = vibrissa::flow::trajectory::read_tum(format!("../shared/sweeps/{name}.truth.tum")).unwrap();
    let contacts = std::fs::read_to_string(format!("../shared/sweeps/{name}.contacts.csv")).unwrap();
    let contacts: Vec<Vec<f64>> =
        contacts.lines().skip(1).map(|l| l.split(',').map(|v| v.parse().unwrap()).collect()).collect();
    // stretches of contact, thinned
    let mut stretches: Vec<Vec<TraceNode>> = vec![vec![]];
    let mut last: Option<(Pose2, f64)> = None;
    for (row, tr) in log.rows.iter().zip(&truth) {
        let z = row.readings[0];
        let std = (0.05 * z.abs() + 1e-6) / 3f64.sqrt();
        if z.abs() < 2e-5 {
            if !stretches.last().unwrap().is_empty() {
                stretches.push(vec![]);
            }
            last = None;
            continue;
        }
        let pose = tr.map_from_robot;
        let cur = stretches.last_mut().unwrap();
        if let (Some((p, _)), Some(n)) = (last, cur.last_mut()) {
            if p.position().distance(pose.position()) < spacing && (n.moment > 0.0) == (z > 0.0) {
                let _ = &n;
                continue;
            }
            if (n.moment > 0.0) != (z > 0.0) {
                stretches.push(vec![]);
            }
        }
        stretches.last_mut().unwrap().push(TraceNode { t: row.t, odom_from_whisker: pose, moment: z, std });
        last = Some((pose, z));
    }
    for s in stretches.iter().filter(|s| s.len() > 5) {
        let t0 = std::time::Instant::now();
        let traces = tip_traces(&Whisker::default(), s, TraceOptions { step_std: step, turn });
        for pts in traces {
            let el = t0.elapsed().as_secs_f64();
            let mut errs = vec![];
            let mut across = vec![];
            let mut chi = 0.0;
            for p in &pts {
                chi += p.residual * p.residual;
                if let Some(c) = contacts.iter().find(|c| (c[0] - p.t).abs() < 1e-4) {
                    let d = p.position - Vec2::new(c[1], c[2]);
                    errs.push(d.norm());
                    across.push((d.dot(Vec2::from_angle(p.normal)).abs(), p.std));
                    if a.len() > 5 {
                        println!(
                            "{:.3} err {:.3} across {:.3} std {:.3} res {:.2} phi {:.2} beta {:.2}",
                            p.t,
                            d.norm() * 1e3,
                            d.dot(Vec2::from_angle(p.normal)) * 1e3,
                            p.std * 1e3,
                            p.residual,
                            p.bend.phi_a,
                            p.bend.beta
                        );
                    }
                }
            }
            let n = errs.len() as f64;
            if pts.is_empty() {
                println!("{name} none n={}", s.len());
                continue;
            }
            println!(
                "{name} n={} points={} mean {:.3} mm across {:.3} std {:.3} max {:.3} chi2/n {:.2} time {:.1} ms",
                s.len(),
                pts.len(),
                errs.iter().sum::<f64>() / n * 1e3,
                across.iter().map(|a| a.0).sum::<f64>() / n * 1e3,
                across.iter().map(|a| a.1).sum::<f64>() / n * 1e3,
                errs.iter().cloned().fold(0.0, f64::max) * 1e3,
                chi / pts.len() as f64,
                el * 1e3
            );
        }
    }
}
