//! Tries on one target, and what came of them.

use crate::mutate::mutate;
use crate::random::Random;
use crate::targets::{Outcome, Source, Target};
use crate::watch::{Watch, worked};
use std::collections::HashSet;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// About how many inputs besides the seeds are damaged further.
const POOL: usize = 1000;
/// A target with this many findings is given up.
const MOST_FINDINGS: usize = 8;

/// What is read may take so many times the time that what is refused may take.
const SOUND: u32 = 3;

/// Where the last panic was, written by the hook.
pub(crate) static LAST_PANIC: Mutex<String> = Mutex::new(String::new());

/// How long and how strictly a target is tried.
#[derive(Clone, Debug)]
pub(crate) struct Plan {
    pub(crate) seconds: f64,
    pub(crate) seed: u64,
    /// Longest time for one input.
    pub(crate) limit: Duration,
    /// Where findings are kept.
    pub(crate) folder: PathBuf,
    /// Where inputs are kept that made the code do something new, for runs to come.
    pub(crate) corpus: PathBuf,
    /// Keep each input in a file before it is tried.
    pub(crate) trace: bool,
}

/// What came of a target.
#[derive(Default)]
pub(crate) struct Tally {
    pub(crate) tries: usize,
    pub(crate) read: usize,
    pub(crate) marks: HashSet<u64>,
    pub(crate) slowest: Duration,
    /// What was found, without repetitions, and where its input is kept.
    pub(crate) findings: Vec<(String, PathBuf)>,
}

/// Feeds `target` until time is up or too much is found.
///
/// The inputs depend on the seed and on what earlier runs have kept, not on the clock.
pub(crate) fn run(target: &Target, plan: &Plan, watch: &Watch) -> Tally {
    let begin = Instant::now();
    let mut random = Random::new(plan.seed);
    let mut pool = seeds(target);
    let whole = pool.len();
    let kept = plan.corpus.join(target.name);
    pool.extend(files(&kept));
    let known = pool.len();
    let mut tally = Tally::default();
    let mut kinds = HashSet::new();
    while begin.elapsed().as_secs_f64() < plan.seconds && tally.findings.len() < MOST_FINDINGS {
        // The seeds themselves come first.
        let input = match pool.get(tally.tries) {
            Some(seed) if tally.tries < known => seed.clone(),
            _ => next(target, &pool, whole, &mut random),
        };
        if plan.trace {
            let _ = keep(&plan.folder, &format!("{}-trace.input", target.name), &input);
        }
        let (verdict, time) = attempt(target, &input, plan.limit, watch);
        tally.tries += 1;
        tally.slowest = tally.slowest.max(time);
        match verdict {
            Ok(outcome) => {
                tally.read += usize::from(outcome.read);
                if tally.marks.insert(outcome.mark) && tally.tries > known {
                    if outcome_is_rare(&kept, outcome.mark) {
                        keep(&kept, &format!("{:016x}", outcome.mark), &input);
                    }
                    let at = whole + random.below(POOL);
                    if at < pool.len() { pool[at] = input } else { pool.push(input) }
                }
            }
            Err(finding) => {
                if kinds.insert(kind(&finding)) {
                    let name = format!("{}-{}.input", target.name, tally.findings.len());
                    let small = shrink(target, input, &finding, plan.limit, watch);
                    tally.findings.push((finding, keep(&plan.folder, &name, &small)));
                }
            }
        }
    }
    tally
}

/// The next input: half of them come from the seeds, which are the first `whole` of the pool.
fn next(target: &Target, pool: &[Vec<u8>], whole: usize, random: &mut Random) -> Vec<u8> {
    match target.source {
        Source::Drawn(draw) => draw(random),
        Source::Grown(draw, words) if random.one_in(2) => {
            let own = draw(random);
            if random.one_in(2) { own } else { damaged(&own, pool, words, random) }
        }
        Source::Damaged(_, words) | Source::Grown(_, words) => {
            let from = if whole > 0 && random.one_in(2) { whole } else { pool.len() };
            let seed = pool.get(random.below(from)).cloned().unwrap_or_default();
            damaged(&seed, pool, words, random)
        }
    }
}

/// A damaged input; another one of the pool lends pieces.
fn damaged(seed: &[u8], pool: &[Vec<u8>], words: &[&str], random: &mut Random) -> Vec<u8> {
    let other = pool.get(random.below(pool.len())).map_or(&[][..], Vec::as_slice);
    mutate(seed, other, words, random)
}

/// One try: its verdict, panics and delays included, and its time.
pub(crate) fn attempt(
    target: &Target,
    input: &[u8],
    limit: Duration,
    watch: &Watch,
) -> (Result<Outcome, String>, Duration) {
    let mut time = Duration::MAX;
    // A busy machine may delay one try, but hardly three.
    for _ in 0..3 {
        watch.begin(target.name, input);
        let (begin, before) = (Instant::now(), worked());
        let verdict = catch_unwind(AssertUnwindSafe(|| (target.check)(input)));
        time = time.min(begin.elapsed());
        if time > limit {
            // A busy machine lets a try wait; what counts is its own work.
            time = time.min(worked().zip(before).map_or(time, |(now, then)| now.saturating_sub(then)));
        }
        watch.end();
        let verdict = verdict
            .unwrap_or_else(|_| Err(format!("panic at {}", LAST_PANIC.lock().unwrap_or_else(PoisonError::into_inner))));
        // What is sound may be long; what is refused must be so at once.
        let allowed = if verdict.as_ref().is_ok_and(|outcome| outcome.read) { SOUND * limit } else { limit };
        if verdict.is_err() || time <= allowed {
            return (verdict, time);
        }
    }
    (Err("slow: more than the allowed time for one input".to_owned()), time)
}

/// The finding without the numbers of the input.
fn kind(finding: &str) -> String {
    finding.chars().filter(|c| c.is_alphabetic() || *c == ' ' || *c == ':').take(60).collect()
}

/// The input with as many lines, then bytes, left out as the same finding allows.
fn shrink(target: &Target, input: Vec<u8>, finding: &str, limit: Duration, watch: &Watch) -> Vec<u8> {
    let until = Instant::now() + Duration::from_secs(5);
    let same = |input: &[u8]| attempt(target, input, limit, watch).0.is_err_and(|other| kind(&other) == kind(finding));
    let mut best = input;
    let mut piece = best.len() / 2;
    while piece > 0 && Instant::now() < until {
        let mut at = 0;
        while at < best.len() && Instant::now() < until {
            let mut shorter = best.clone();
            shorter.drain(at..(at + piece).min(best.len()));
            if same(&shorter) {
                best = shorter;
            } else {
                at += piece;
            }
        }
        piece /= 2;
    }
    best
}

fn keep(folder: &Path, name: &str, input: &[u8]) -> PathBuf {
    let path = folder.join(name);
    if let Err(error) = std::fs::create_dir_all(folder).and_then(|()| std::fs::write(&path, input)) {
        eprintln!("cannot keep {} ({error})", path.display());
    }
    path
}

/// The committed files of a target, in the order of their names.
pub(crate) fn seeds(target: &Target) -> Vec<Vec<u8>> {
    let Source::Damaged(folders, _) = target.source else { return Vec::new() };
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    folders.iter().flat_map(|folder| files(&root.join(folder))).collect()
}

/// The contents of a folder's files, in the order of their names; none where there is no folder.
fn files(folder: &Path) -> Vec<Vec<u8>> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.path()).collect();
    paths.sort();
    paths.iter().filter_map(|path| std::fs::read(path).ok()).collect()
}

/// Most inputs that are kept of a target: each runs first in every later run.
const MOST_KEPT: usize = 2000;

/// Whether an outcome is to be kept: it has no input yet, and there is room.
fn outcome_is_rare(kept: &Path, mark: u64) -> bool {
    !kept.join(format!("{mark:016x}")).exists()
        && std::fs::read_dir(kept).map_or(0, |entries| entries.count()) < MOST_KEPT
}
