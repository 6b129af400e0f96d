//! Hours of a whisker that is free, and of one that is touched now and then: no contact is made up, and none above twice the noise is
//! missed, whatever law the noise has within the declared bound.
//!
//! `contact` sees logs of ten minutes, and every method sees a share of them row by row on the arena of the demo.

use crate::free_whisker::{FreeLaw, FreeWhisker, RATE, ROWS};
use std::sync::atomic::{AtomicUsize, Ordering};
use vibrissa::config::ContactOptions;
use vibrissa::flow::pose::Status;
use vibrissa::flow::sensor_log::SensorLog;
use vibrissa::tasks::contact::contacts;
use vibrissa::{Localizer, Method, Result};

/// Rows with touches for each log without: contacts take far more time than none.
const TOUCHED_ROWS: usize = ROWS / 60;
/// One log in so many is seen by the methods, too.
const FOR_METHODS: usize = 20;
/// Rows of it that they see.
const METHOD_ROWS: usize = ROWS / 10;

/// What was counted.
#[derive(Clone, Copy, Debug, Default)]
struct Count {
    /// Rows of a free whisker.
    rows: usize,
    /// Contacts that `contact` made up.
    phantoms: usize,
    /// Touches, and those that were missed or told more than once.
    touches: usize,
    missed: usize,
    /// Rows that each method saw, and logs of which one told a contact.
    method_rows: usize,
    told: [usize; METHODS],
}

const METHODS: usize = 3;

impl Count {
    fn add(&mut self, other: &Self) {
        self.rows += other.rows;
        self.phantoms += other.phantoms;
        self.touches += other.touches;
        self.missed += other.missed;
        self.method_rows += other.method_rows;
        self.told.iter_mut().zip(other.told).for_each(|(mine, theirs)| *mine += theirs);
    }

    fn is_clean(&self) -> bool {
        self.phantoms + self.missed + self.told.iter().sum::<usize>() == 0
    }
}

/// So many hours of each law; whether nothing was made up and nothing missed.
pub(crate) fn hours(hours: f64, seed: u64, threads: usize) -> Result<bool> {
    let logs = ((hours * 3600.0 * RATE / ROWS as f64).ceil() as usize).max(1);
    let methods = [
        Method::Deterministic(Default::default()),
        Method::Possibilistic(Default::default()),
        Method::Probabilistic(Default::default()),
    ];
    println!("| law | free rows | phantom contacts | touches | missed | rows of each method | phantoms of {} |", {
        methods.each_ref().map(Method::name).join(", ")
    });
    println!("| --- | --- | --- | --- | --- | --- | --- |");
    let mut clean = true;
    for law in FreeLaw::ALL {
        let count = of_law(law, logs, seed, threads, &methods)?;
        let told = count.told.map(|told| told.to_string()).join(", ");
        println!(
            "| {law:?} | {} | {} | {} | {} | {} | {told} |",
            count.rows, count.phantoms, count.touches, count.missed, count.method_rows
        );
        clean &= count.is_clean();
    }
    println!("{}", if clean { "nothing made up, nothing missed" } else { "BROKEN: contacts were made up or missed" });
    Ok(clean)
}

fn of_law(law: FreeLaw, logs: usize, seed: u64, threads: usize, methods: &[Method; METHODS]) -> Result<Count> {
    let next = AtomicUsize::new(0);
    let worker = || -> Result<Count> {
        let mut own = Count::default();
        loop {
            let log = next.fetch_add(1, Ordering::Relaxed);
            if log >= logs {
                return Ok(own);
            }
            own.add(&one(law, seed.wrapping_mul(1_000_003).wrapping_add(log as u64), log, methods)?);
        }
    };
    let counts = std::thread::scope(|scope| {
        let workers: Vec<_> = (0..threads).map(|_| scope.spawn(worker)).collect();
        // A worker that panics takes the program down with its message.
        workers
            .into_iter()
            .map(|worker| worker.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
            .collect()
    });
    let counts: Vec<Result<Count>> = counts;
    let mut all = Count::default();
    for count in counts {
        all.add(&count?);
    }
    Ok(all)
}

/// One free log, one with touches, and a share of the free one by the methods.
fn one(law: FreeLaw, seed: u64, number: usize, methods: &[Method; METHODS]) -> Result<Count> {
    let (robot, mut whisker) = (law.robot(), FreeWhisker::new(law, seed));
    let found = |log: &SensorLog| contacts(log, &robot, &ContactOptions::default());
    let free = whisker.free(ROWS);
    let report = found(&free)?;
    let (touched, touches) = whisker.touched(TOUCHED_ROWS);
    let events = found(&touched)?.events;
    let of = |kind: &str| events.iter().filter(|event| event.kind == kind).count();
    let missed = of("contact").abs_diff(touches).max(of("lift_off").abs_diff(touches));
    let mut count = Count {
        rows: free.rows.len(),
        phantoms: report.events.iter().filter(|event| event.kind == "contact").count().max(report.steps.len()),
        touches,
        missed,
        ..Count::default()
    };
    if number.is_multiple_of(FOR_METHODS) {
        let short = SensorLog { rows: free.rows[..METHOD_ROWS].to_vec(), ..free.clone() };
        count.method_rows = short.rows.len();
        for (told, method) in count.told.iter_mut().zip(methods) {
            *told = usize::from(tells_contact(&short, &robot, method)?);
        }
    }
    Ok(count)
}

/// Whether a method takes a free whisker for one that touches, although it has taken account of all that the robot declares.
fn tells_contact(log: &SensorLog, robot: &vibrissa::world::Robot, method: &Method) -> Result<bool> {
    let map = vibrissa::tasks::demo::arena()?;
    let mut localizer = Localizer::new(&map, robot, &log.channels, method)?;
    for row in &log.rows {
        localizer.step(row)?;
    }
    let answer = localizer.finish();
    if answer.events.iter().any(|event| event.kind == "unused") {
        return Ok(false);
    }
    Ok(answer.status != Status::NoContact || answer.events.iter().any(|event| event.kind == "contact"))
}
