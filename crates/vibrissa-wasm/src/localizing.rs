//! Where the robot is, row by row.

use crate::host::Host;
use self_cell::self_cell;
use serde_json::json;
use vibrissa::flow::pose::{Hypothesis, Localization, Status};
use vibrissa::flow::sensor_log::{Channel, LogRow, Quantity, SensorLog};
use vibrissa::io::calibrated;
use vibrissa::plane::Pose2;
use vibrissa::world::{Map, Robot};
use vibrissa::{Error, Localizer, Method, Result};

/// Numbers of a row before its readings.
const ROW: usize = 4;

/// What a localizer borrows.
pub(crate) struct World {
    map: Map,
    robot: Robot,
    /// The log in moments, with as many rows as are known.
    log: SensorLog,
    method: Method,
}

/// A localizer until it is ended.
pub(crate) struct Running<'a> {
    localizer: Option<Localizer<'a>>,
    /// Rows that came after the log, and how many of both are taken.
    added: Vec<LogRow>,
    taken: usize,
}

self_cell! {
    /// A localizer with the map and the robot that it borrows.
    pub(crate) struct Localizing {
        owner: World,
        #[not_covariant]
        dependent: Running,
    }
}

pub(crate) fn localize(host: &mut Host, op: u32, n: u32) -> Result<()> {
    match op {
        0 => begin(host),
        1 => add(host),
        2 => step(host, n as usize),
        3 => finish(host),
        other => Err(Error::usage("op").value(other).allowed("0 to 3")),
    }
}

/// The columns of a steered robot's log.
fn channels(robot: &Robot) -> Vec<Channel> {
    let alone = robot.whiskers.len() == 1;
    let name = |name: &String| if alone { String::new() } else { name.clone() };
    robot.whiskers.iter().map(|w| Channel { whisker: name(&w.name), quantity: Quantity::Moment }).collect()
}

fn begin(host: &mut Host) -> Result<()> {
    let method = Method::named(&host.input_text())?;
    for whisker in &host.robot.whiskers {
        method.takes(&whisker.beam).map_err(|error| error.about(&format!("whisker \"{}\"", whisker.name)))?;
    }
    let mut log = host.log.clone();
    if log.channels.is_empty() {
        log.channels = channels(&host.robot);
    }
    let (log, robot) = calibrated(&log, &host.robot)?;
    let world = World { map: host.map()?.clone(), robot: robot.into_owned(), log: log.into_owned(), method };
    host.localizing = Some(Localizing::try_new(world, on)?);
    host.answer = None;
    progress(host)
}

/// A localizer on its world, before the first row.
fn on(world: &World) -> Result<Running<'_>> {
    let localizer = Localizer::new(&world.map, &world.robot, &world.log.channels, &world.method)?;
    Ok(Running { localizer: Some(localizer), added: Vec::new(), taken: 0 })
}

fn running(host: &mut Host) -> Result<&mut Localizing> {
    host.localizing.as_mut().ok_or_else(|| Error::usage("no localization was begun yet"))
}

fn add(host: &mut Host) -> Result<()> {
    let numbers = host.input_numbers();
    running(host)?.with_dependent_mut(|world, running| {
        let width = ROW + world.log.channels.len();
        for row in numbers.chunks_exact(width) {
            let odom_from_robot = Pose2::new(row[1], row[2], row[3]);
            let readings = row[ROW..].to_vec();
            running.added.push(LogRow { t: row[0], odom_from_robot, readings, heading: None, line: 0 });
        }
    });
    progress(host)
}

fn step(host: &mut Host, n: usize) -> Result<()> {
    running(host)?.with_dependent_mut(|world, running| {
        let Running { localizer: Some(localizer), added, taken } = running else { return Ok(()) };
        for row in world.log.rows.iter().chain(added.iter()).skip(*taken).take(n) {
            localizer.step(row).map_err(|error| match &world.log.source {
                Some(file) if error.line().is_some() => error.in_file(file),
                _ => error,
            })?;
            *taken += 1;
        }
        Ok(())
    })?;
    progress(host)
}

fn progress(host: &mut Host) -> Result<()> {
    let (taken, all) =
        running(host)?.with_dependent(|world, running| (running.taken, world.log.rows.len() + running.added.len()));
    host.numbers = vec![taken as f64, all as f64];
    Ok(())
}

fn finish(host: &mut Host) -> Result<()> {
    let answer = running(host)?.with_dependent_mut(|_, running| running.localizer.take().map(Localizer::finish));
    let Some(answer) = answer else { return Err(Error::usage("this localization has ended")) };
    let rows = host.localizing.as_ref().map_or(0, |all| all.with_dependent(|_, running| running.taken));
    told(host, answer.status, rows, &answer.hypotheses, &[]);
    host.count(answer.trajectory.len());
    for stamped in &answer.trajectory {
        host.push([stamped.t]);
        host.pose(stamped.map_from_robot);
    }
    host.text = words(&answer);
    host.answer = Some(answer);
    Ok(())
}

/// Events, how the readings fit and what they say of declared errors, as JSON.
fn words(answer: &Localization) -> String {
    let events = answer.events.iter().map(|e| json!({ "t": e.t, "kind": e.kind, "detail": e.detail }));
    let nuisances = answer.nuisances.iter().map(|n| {
        json!({ "quantity": n.quantity.as_str(), "whisker": n.whisker, "unit": n.quantity.unit(), "estimate": n.estimate,
                "std": n.std, "bound": n.bound, "significant": n.is_significant() })
    });
    let consistency = answer.consistency.as_ref().map(|c| json!({ "statistic": c.statistic, "most": c.most }));
    json!({
        "status": answer.status.as_str(),
        "method": answer.method,
        "events": events.collect::<Vec<_>>(),
        "nuisances": nuisances.collect::<Vec<_>>(),
        "consistency": consistency,
    })
    .to_string()
}

pub(crate) fn estimate(host: &mut Host, most: u32) -> Result<()> {
    let (found, states) = running(host)?
        .with_dependent(|_, running| {
            let states = |localizer: &Localizer<'_>| if most > 0 { localizer.states_now() } else { Vec::new() };
            running.localizer.as_ref().map(|localizer| (localizer.estimate(), states(localizer)))
        })
        .ok_or_else(|| Error::usage("this localization has ended"))?;
    let step = states.len().div_ceil(most.max(1) as usize).max(1);
    let shown: Vec<Pose2> = states.into_iter().step_by(step).collect();
    told(host, found.status, found.rows, &found.hypotheses, &shown);
    Ok(())
}

fn told(host: &mut Host, status: Status, rows: usize, places: &[Hypothesis], states: &[Pose2]) {
    let verdict = match status {
        Status::Localized => 0.0,
        Status::Ambiguous => 1.0,
        Status::Inconsistent => 2.0,
        Status::NoContact => 3.0,
    };
    host.push([verdict, rows as f64, places.len() as f64, states.len() as f64]);
    for place in places {
        host.pose(place.pose);
        host.push([place.weight]);
        for side in [place.extent.x, place.extent.y, place.extent.theta] {
            host.push([side.lo(), side.hi()]);
        }
        let (position, heading) = place.bound().unwrap_or((f64::NAN, f64::NAN));
        host.push([position, heading]);
    }
    states.iter().for_each(|&state| host.pose(state));
}
