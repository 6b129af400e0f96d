//! How well a robot finds itself in a map that it felt before: laps along the walls of random rooms, mapped, and second visits by
//! each method.
//!
//! `cargo run --release --example felt_maps -- [ROOMS] [FIRST_SEED]`

#[path = "../tests/data/lap.rs"]
mod lap;
#[path = "../tests/data/random.rs"]
mod random;

use lap::{Kind, Law, OdometryError, record, robot, room, way};
use random::Random;
use vibrissa::Stop;
use vibrissa::config::MappingOptions;
use vibrissa::config::PossibilisticOptions;
use vibrissa::flow::pose::Status;
use vibrissa::plane::{Vec2, wrap_angle};
use vibrissa::tasks::mapping::map_log;
use vibrissa::{Method, localize};

fn main() {
    let mut arguments = std::env::args().skip(1).map_while(|a| a.parse::<u64>().ok());
    let (rooms, first) = (arguments.next().unwrap_or(10), arguments.next().unwrap_or(1));
    for seed in first..first + rooms {
        if let Some(told) = visit(seed) {
            println!("{told}");
        }
    }
}

fn visit(seed: u64) -> Option<String> {
    let mut draw = Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15));
    let kind = [Kind::Rectangle, Kind::LShape, Kind::Polygon][(seed % 3) as usize];
    let law = [Law::Even, Law::Edge, Law::Normal, Law::Correlated][(seed / 3 % 4) as usize];
    let room = room(&mut draw, kind, (1.2, 2.5))?;
    let robot = robot(&mut draw);
    let length: f64 = room.map.total_length();
    let path = way(&room, &mut draw, 0.3, 1.1 * length)?;
    let started = std::time::Instant::now();
    let lap = record(&room.map, &robot, &path, law, OdometryError::default(), &mut draw)?;
    let simulated = started.elapsed().as_secs_f64();
    // The felt map is in the odometry frame of the lap.
    let odom_from_map = path[0].map_from_robot.inverse();
    let started = std::time::Instant::now();
    let felt = map_log(&lap.log, &robot, MappingOptions::default(), &Stop::default(), &mut |_, _| {}).ok()?;
    let took = started.elapsed().as_secs_f64();
    let map = &felt.outline.map;
    let mut told = format!(
        "{seed} {kind:?} {law:?} {length:.2} m, {} rows, sim {simulated:.1} s, mapped in {took:.1} s: {} boundaries, corners {} of {}",
        path.len(),
        map.boundaries().len(),
        felt.outline.corners.len(),
        room.corners.len(),
    );
    for visit in 0..2 {
        let share = draw.between(0.1, 0.8);
        let path = way(&room, &mut draw, share, draw_length(&mut Random(seed + visit), length))?;
        let Some(second) = record(&room.map, &robot, &path, law, OdometryError::default(), &mut draw) else { continue };
        let truth = odom_from_map.compose(path[path.len() - 1].map_from_robot);
        let possibilistic = PossibilisticOptions { two_contacts: Some(0.05), ..PossibilisticOptions::default() };
        for method in [Method::Possibilistic(possibilistic), Method::Probabilistic(Default::default())] {
            let started = std::time::Instant::now();
            let answer = match localize(&second.log, map, &robot, &method, &mut |_| {}) {
                Ok(answer) => answer,
                Err(error) => {
                    told += &format!("\n   {}: {error}", method.name());
                    continue;
                }
            };
            let took = started.elapsed().as_secs_f64();
            let holds = answer.hypotheses.iter().position(|h| {
                let middle = 0.5 * (h.extent.theta.lo() + h.extent.theta.hi());
                h.extent.x.contains(truth.x)
                    && h.extent.y.contains(truth.y)
                    && h.extent.theta.contains(middle + wrap_angle(truth.theta - middle))
            });
            let best = answer.hypotheses.first();
            let off = best.map_or(f64::NAN, |h| h.pose.position().distance(Vec2::new(truth.x, truth.y)));
            let size = best.map_or(f64::NAN, |h| h.extent.x.width().max(h.extent.y.width()));
            told += &format!(
                "\n   {} {} places {} {} holds {holds:?} off {:.3} mm extent {:.2} mm {took:.1} s",
                method.name(),
                second.log.rows.len(),
                answer.hypotheses.len(),
                answer.status,
                1e3 * off,
                1e3 * size
            );
            if answer.status == Status::Inconsistent {
                told += &format!(" {:?}", answer.events.last());
            }
        }
    }
    Some(told)
}

fn draw_length(draw: &mut Random, length: f64) -> f64 {
    draw.between(0.3, 0.9) * length
}
