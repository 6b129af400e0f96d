//! Where the robot is, row by row.

use crate::host::Host;
use self_cell::self_cell;
use serde_json::json;
use vibrissa::config::SettingValue;
use vibrissa::flow::one_in;
use vibrissa::flow::pose::{Hypothesis, Localization, Status};
use vibrissa::flow::sensor_log::{Channel, LogRow, Quantity, SensorLog};
use vibrissa::io::calibrated;
use vibrissa::plane::Pose2;
use vibrissa::world::{Map, Robot};
use vibrissa::{Error, Localizer, Method, Result, WorkBudget};

/// Numbers of a row before its readings.
const ROW: usize = 4;
/// What a row costs beside what its method counts.
const ROW_COST: usize = 20;

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
    /// Whether all work on the rows that were taken, or on the end, is done.
    is_idle: bool,
}

impl Running<'_> {
    /// Takes the next row, whose work is left to `advance`; whether there was one.
    fn begin(&mut self, log: &SensorLog) -> Result<bool> {
        let Some(localizer) = &mut self.localizer else { return Ok(false) };
        let Some(row) = log.rows.iter().chain(&self.added).nth(self.taken) else { return Ok(false) };
        localizer.begin(row).map_err(|error| match &log.source {
            Some(file) if error.line().is_some() => error.in_file(file),
            _ => error,
        })?;
        self.taken += 1;
        Ok(true)
    }

    /// Works until the budget is spent or nothing is left.
    fn advance(&mut self, budget: &mut WorkBudget) {
        self.is_idle = self.localizer.as_mut().is_none_or(|localizer| localizer.advance(budget));
    }
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
        4 => advance(host, n as usize),
        5 => end(host),
        other => Err(Error::usage("op").value(other).allowed("0 to 5")),
    }
}

/// The columns of a steered robot's log.
fn channels(robot: &Robot) -> Vec<Channel> {
    let alone = robot.whiskers.len() == 1;
    let name = |name: &String| if alone { String::new() } else { name.clone() };
    robot.whiskers.iter().map(|w| Channel { whisker: name(&w.name), quantity: Quantity::Moment }).collect()
}

fn begin(host: &mut Host) -> Result<()> {
    let text = host.input_text();
    let mut words = text.split_whitespace();
    let mut method = Method::named(words.next().unwrap_or_default())?;
    // Options that are words, as name=value.
    for option in words {
        let (name, value) = option.split_once('=').unwrap_or((option, ""));
        method.set(name, SettingValue::Choice(value.to_owned()))?;
    }
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
    Ok(Running { localizer: Some(localizer), added: Vec::new(), taken: 0, is_idle: true })
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
        for _ in 0..n {
            if !running.begin(&world.log)? {
                break;
            }
            running.advance(&mut WorkBudget::unlimited());
        }
        Ok(())
    })?;
    progress(host)
}

/// Goes on with the work that is left, or with the next row; a row's beginning is work, too.
fn advance(host: &mut Host, units: usize) -> Result<()> {
    running(host)?.with_dependent_mut(|world, running| {
        let mut budget = WorkBudget::new(units);
        while !budget.is_spent() {
            if running.is_idle && !running.begin(&world.log)? {
                break;
            }
            running.advance(&mut budget);
            budget.spend(ROW_COST);
            if running.is_idle {
                break;
            }
        }
        Ok(())
    })?;
    progress(host)
}

fn end(host: &mut Host) -> Result<()> {
    running(host)?.with_dependent_mut(|_, running| {
        if let Some(localizer) = &mut running.localizer {
            localizer.end();
            running.is_idle = false;
        }
    });
    progress(host)
}

fn progress(host: &mut Host) -> Result<()> {
    let state = running(host)?.with_dependent(|world, running| {
        let all = world.log.rows.len() + running.added.len();
        [running.taken as f64, all as f64, f64::from(u8::from(running.is_idle))]
    });
    host.numbers = state.to_vec();
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
                "std": n.std, "bound": n.bound, "significant": n.is_significant(), "words": n.sentence() })
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
    let shown: Vec<Pose2> = one_in(states, step).collect();
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
