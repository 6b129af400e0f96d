//! Sliding tips where the whisker is strongly bent: whatever the noise, no tip may be far off where it claims to be known.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must fail")]

use vibrissa::config::ContactOptions;
use vibrissa::plane::Pose2;
use vibrissa::sim::{Pace, SweepNoise, path_through, simulate_tip_sweep};
use vibrissa::tasks::contact::{ContactKind, contacts};
use vibrissa::world::{MountedWhisker, Robot};
use vibrissa_reproduce::{ARENA_SVG, SWEEPS};

/// With these seeds short windows slide off to another shape in the bay (1, 11, 15); with the others they do not.
const SEEDS: [u64; 5] = [1, 2, 11, 15, 30];

#[test]
fn strongly_bent_whiskers_stay_on_their_branch() {
    let map = vibrissa::io::map::from_svg(ARENA_SVG, "arena").unwrap();
    let robot_from_whisker = Pose2::new(0.0, 0.0, 128_f64.to_radians());
    let whiskers = vec![MountedWhisker { robot_from_whisker, ..MountedWhisker::default() }];
    let robot = Robot { whiskers, ..Robot::default() };
    let way: Vec<Pose2> = SWEEPS[0].way.iter().map(|[x, y]| Pose2::new(1e-3 * x, 1e-3 * y, 0.0)).collect();
    let path = path_through(&way, &Pace { speed: 0.15, turn_rate: 1.0, rate: 300.0 }).unwrap();
    for seed in SEEDS {
        let sweep = simulate_tip_sweep(&map, &robot, &path, &SweepNoise::seeded(seed)).unwrap();
        let report = contacts(&sweep.log, &robot, &ContactOptions::default()).unwrap();
        let start = path[0].map_from_robot.compose(sweep.log.rows[0].odom_from_robot.inverse());
        let tips = report.steps.iter().filter(|step| step.kind == ContactKind::Tip);
        let mut found = 0;
        for step in tips {
            let late = |t: f64| (t - step.t).abs();
            let truth = sweep.contacts.iter().min_by(|a, b| late(a.t).total_cmp(&late(b.t))).unwrap();
            let off = start.transform_point(step.position().unwrap()).distance(truth.position);
            let std = step.std.unwrap();
            assert!(off < 1e-3 + 5.0 * std, "seed {seed}, {} s: {off} m off at {std}", step.t);
            found += 1;
        }
        assert!(found > 455, "seed {seed}: {found} tips");
    }
}
