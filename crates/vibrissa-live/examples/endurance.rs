//! How long a row takes from the port to the estimate, and whether memory grows: a simulated robot drives to and fro behind a
//! pseudo-terminal, its whole run recorded. Linux.
//!
//!     cargo run --release -p vibrissa-live --example endurance -- [SECONDS] [ROWS A SECOND] [WHISKERS] [FILE.csv]
//!
//! The file gets a line each ten seconds: time, rows, memory, latencies of the stretch before. `memory_mb` is what the system has given to
//! the process, `heap_mb` what is allocated now, `heap_most_mb` at most since the line before.

#[cfg(target_os = "linux")]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    linux::main()
}

#[cfg(not(target_os = "linux"))]
fn main() {
    println!("this program reads /proc");
}

#[cfg(target_os = "linux")]
mod linux {
    use core::ops::ControlFlow;
    use peak_alloc::PeakAlloc;
    use std::io::Write;
    use std::sync::Arc;
    use std::sync::atomic::{AtomicBool, Ordering};
    use std::time::{Duration, Instant};
    use vibrissa::plane::Pose2;
    use vibrissa::sim::{Pace, SweepNoise, path_through, simulate_tip_sweep};
    use vibrissa::tasks::demo;
    use vibrissa::world::{MountedWhisker, Robot};
    use vibrissa_live::journal::Journal;
    use vibrissa_live::latency::Histogram;
    use vibrissa_live::record::FileStorage;
    use vibrissa_live::run::{Update, run};
    use vibrissa_live::setup::from_toml;
    use vibrissa_live::source::PseudoTerminal;

    /// How often the file gets a line (s), and what stands in it.
    const NOTE: f64 = 10.0;
    const COLUMNS: &str =
        "t_s,rows,merged,carried,missing,not_recorded,memory_mb,heap_mb,heap_most_mb,p50_ms,p99_ms,largest_ms";

    /// Counts what is allocated: the allocator keeps pages of a busy time, so that those of the process cannot tell whether anything grows.
    #[global_allocator]
    static HEAP: PeakAlloc = PeakAlloc;

    pub(super) fn main() -> Result<(), Box<dyn std::error::Error>> {
        let given: Vec<String> = std::env::args().skip(1).collect();
        let mut csv = match given.get(3) {
            Some(path) => {
                let mut file = std::fs::File::create(path)?;
                writeln!(file, "{COLUMNS}")?;
                Some(file)
            }
            None => None,
        };
        let mut args = given.iter().map(|arg| arg.parse::<f64>());
        let seconds = args.next().transpose()?.unwrap_or(20.0);
        let rate = args.next().transpose()?.unwrap_or(1000.0);
        let count = args.next().transpose()?.unwrap_or(1.0) as usize;
        let map = demo::arena()?;
        let whisker = |i: usize| MountedWhisker {
            name: format!("w{i}"),
            robot_from_whisker: Pose2::new(0.0, 0.0, 0.03 * i as f64),
            ..MountedWhisker::default()
        };
        let robot = Robot { whiskers: (0..count).map(whisker).collect(), ..Robot::default() };
        let ends = demo::path()?;
        let corners: Vec<Pose2> = ends.iter().step_by(60).chain(ends.last()).map(|pose| pose.map_from_robot).collect();
        let path = path_through(&corners, &Pace { speed: 0.05, turn_rate: 0.3, rate })?;
        let log = simulate_tip_sweep(&map, &robot, &path, &SweepNoise::seeded(1))?.log;

        let mut terminal = PseudoTerminal::new()?;
        let names: Vec<String> = log.channels.iter().map(|channel| format!("\"{}\"", channel.column())).collect();
        let text = format!(
            "map = \"-\"\n[[source]]\nserial = \"{}\"\ntime = \"stamps\"\ncolumns = [\"seq16\", \"t_us\", \"x\", \"y\", \"theta\", {}]\n",
            terminal.port().display(),
            names.join(", ")
        );
        let setup = from_toml(&text, "endurance")?;
        let over = Arc::new(AtomicBool::new(false));
        let done = Arc::clone(&over);
        let sender = std::thread::spawn(move || {
            let began = Instant::now();
            let period = (log.rows.len() - 1) * 2;
            for number in 0..(seconds * rate) as usize {
                let place = number % period;
                // To and fro.
                let row = &log.rows[if place < log.rows.len() { place } else { period - place }];
                let t = number as f64 / rate;
                std::thread::sleep(Duration::from_secs_f64(t).saturating_sub(began.elapsed()));
                let pose = row.odom_from_robot;
                let readings: Vec<String> = row.readings.iter().map(|moment| format!("{moment:.7e}")).collect();
                let stamp = (t * 1e6) as u64 % (1 << 32);
                let line = format!(
                    "{},{stamp},{:.7},{:.7},{:.8},{}\r\n",
                    number % (1 << 16),
                    pose.x,
                    pose.y,
                    pose.theta,
                    readings.join(",")
                );
                if terminal.send(line.as_bytes()).is_err() {
                    break;
                }
            }
            std::thread::sleep(Duration::from_millis(500));
            done.store(true, Ordering::Relaxed);
        });

        let folder = std::env::temp_dir().join(format!("vibrissa-endurance-{}", std::process::id()));
        let (storage, file) = FileStorage::create(&folder, "recording")?;
        let journal = Journal::begin(storage, &setup, &folder, 1.0);
        let (began, mut looked, mut noted) = (Instant::now(), 0.0, 0.0);
        let mut before = Histogram::default();
        println!("seconds  rows  merged  carried  p50 ms  p99 ms  most ms  taken p99 ms  memory MB");
        let finished = run(&setup, Some(&map), &robot, Some(&journal), &mut |update| {
            if let Update::Estimate(_, health) | Update::Idle(health) = update {
                let passed = began.elapsed().as_secs_f64();
                if let Some(file) = csv.as_mut().filter(|_| passed > noted + NOTE) {
                    noted = passed;
                    let stretch = health.latency.since(&before);
                    before.clone_from(&health.latency);
                    let missing: u64 = health.sources.iter().map(|(_, counts)| counts.missing()).sum();
                    // A file that cannot be written is seen by what is missing in it.
                    let _ = writeln!(
                        file,
                        "{passed:.1},{},{},{},{missing},{},{:.2},{:.3},{:.3},{:.3},{:.3},{:.3}",
                        health.rows,
                        health.merged,
                        health.carried,
                        health.dropped,
                        resident(),
                        HEAP.current_usage() as f64 / 1e6,
                        HEAP.peak_usage() as f64 / 1e6,
                        1e3 * stretch.quantile(0.5),
                        1e3 * stretch.quantile(0.99),
                        1e3 * health.latency.largest()
                    );
                    HEAP.reset_peak_usage();
                }
                if passed > looked + seconds / 10.0 {
                    looked = passed;
                    println!(
                        "{passed:7.0} {:>6} {:>6} {:>6} {:7.3} {:7.3} {:8.2} {:8.2} {:8.1}",
                        health.rows,
                        health.merged,
                        health.carried,
                        1e3 * health.latency.quantile(0.5),
                        1e3 * health.latency.quantile(0.99),
                        1e3 * health.latency.largest(),
                        1e3 * health.taken.quantile(0.99),
                        resident()
                    );
                }
            }
            if over.load(Ordering::Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        })?;
        let _ = sender.join();
        let dropped = journal.recorder().dropped();
        journal.finish()?;
        let size = std::fs::metadata(&file)?.len();
        std::fs::remove_dir_all(&folder)?;
        println!("\n{}", vibrissa_live::output::words(&finished.estimate));
        for (_, counts) in &finished.health.sources {
            println!(
                "{} frames; {}; {dropped} messages not recorded; {} MB recorded",
                counts.frames,
                counts.words(),
                size >> 20
            );
        }
        println!("\nlatency up to (ms)   rows");
        for (end, count) in finished.health.latency.buckets() {
            println!("{:>18.4} {count:>6}", 1e3 * end);
        }
        Ok(())
    }

    /// Memory in use (MB).
    fn resident() -> f64 {
        let text = std::fs::read_to_string("/proc/self/statm").unwrap_or_default();
        let pages = text.split_whitespace().nth(1).and_then(|word| word.parse::<f64>().ok()).unwrap_or(0.0);
        pages * 4096.0 / 1e6
    }
}
