//! A map made while the robot drives. Rows are traced and maps are made on threads of their own: a run never waits for them.

use crate::commands::map::{captions, files, report, summary};
use crate::output::{complain, write_all};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::{JoinHandle, Scope, ScopedJoinHandle};
use std::time::{Duration, Instant};
use vibrissa::Result;
use vibrissa::config::MappingOptions;
use vibrissa::flow::sensor_log::{Channel, SensorLog};
use vibrissa::tasks::mapping::{Mapped, Mapper};
use vibrissa::world::Robot;
use vibrissa_live::estimate::{UsedRow, merged};
use vibrissa_live::join::JoinedRow;
use vibrissa_live::run::Update;

/// So long after a map the next one is begun, and no sooner than after so many times what the last one took.
const PERIOD: Duration = Duration::from_secs(5);
const PATIENCE: u32 = 4;
/// Where more rows than this wait to be traced (some MB), the newest of each stretch stands for all.
const MOST_WAITING: usize = 20_000;

/// What the run hands over.
enum News {
    Began(Vec<Channel>, Box<Robot>),
    Row(JoinedRow),
}

/// A map in words.
pub(super) struct Answer {
    /// Time of the last row that it is of (s).
    t: f64,
    /// One line.
    pub(super) words: String,
    /// All that is told of it.
    pub(super) report: String,
    summary: Value,
}

impl Answer {
    /// A line of JSON: `t` (s) is the time of the last row, `map` is as `vibrissa map --json` has it.
    pub(super) fn line(&self) -> String {
        json!({ "t": self.t, "map": self.summary }).to_string()
    }
}

/// Makes maps of a run's rows.
pub(super) struct Mapping {
    news: Option<Sender<News>>,
    answers: Receiver<Answer>,
    thread: JoinHandle<()>,
}

impl Mapping {
    /// For rows that come; `patient` where they wait to be traced, as those of files do. Files go into `folder`, with `suffix` behind
    /// their names.
    pub(super) fn start(options: MappingOptions, patient: bool, folder: &Path, suffix: &str) -> Result<Self> {
        options.check()?;
        let (sender, news) = channel();
        let (answered, answers) = channel();
        let maker = Maker { options, patient, folder: folder.to_owned(), suffix: suffix.to_owned(), answered };
        let thread = std::thread::spawn(move || {
            if let Err(error) = maker.make(&news) {
                complain("no map", &error);
            }
        });
        Ok(Self { news: Some(sender), answers, thread })
    }

    /// Takes what is new in the run.
    pub(super) fn see(&mut self, update: &Update<'_>) {
        let news = match update {
            Update::Began(channels, robot) => News::Began(channels.to_vec(), Box::new((*robot).clone())),
            Update::Row(row) => News::Row((*row).clone()),
            _ => return,
        };
        if let Some(sender) = &self.news {
            // Where no map can be made nobody listens; that has been said.
            let _ = sender.send(news);
        }
    }

    /// A map that is ready.
    pub(super) fn ready(&mut self) -> Option<Answer> {
        self.answers.try_recv().ok()
    }

    /// The map of all rows, once the run is over.
    pub(super) fn end(mut self) -> Option<Answer> {
        self.news = None;
        let last = self.answers.iter().last();
        // A panic there has been told by itself.
        let _ = self.thread.join();
        last
    }
}

/// What the thread that traces knows.
struct Maker {
    options: MappingOptions,
    patient: bool,
    folder: PathBuf,
    suffix: String,
    answered: Sender<Answer>,
}

/// Rows that were traced.
#[derive(Clone, Copy, Default)]
struct Traced {
    /// Time of the last one (s).
    t: f64,
    rows: u64,
    merged: u64,
}

impl Maker {
    /// Traces rows until none come any more, with a map of those so far now and then.
    fn make(&self, news: &Receiver<News>) -> Result<()> {
        let Some((channels, robot)) = news.iter().find_map(|one| match one {
            News::Began(channels, robot) => Some((channels, robot)),
            News::Row(_) => None,
        }) else {
            return Ok(());
        };
        let log = SensorLog { channels, ..SensorLog::default() };
        let mut mapper = Mapper::new(&robot, &log, self.options)?;
        let mut traced = Traced::default();
        std::thread::scope(|scope| {
            let mut drafts =
                Drafts { scope, maker: self, under_way: None, due: Instant::now() + PERIOD, refused: false };
            while let Ok(first) = news.recv() {
                let rows: Vec<UsedRow> = core::iter::once(first).chain(news.try_iter()).filter_map(row).collect();
                let most = if self.patient { usize::MAX } else { MOST_WAITING };
                for UsedRow { joined, merged } in merged(rows.into_iter(), most) {
                    drafts.push(&mut mapper, &joined);
                    traced = Traced { t: joined.row.t, rows: traced.rows + 1, merged: traced.merged + merged - 1 };
                }
                drafts.begin(&mapper, traced);
            }
        });
        self.tell(mapper.map()?, traced)
    }

    /// Writes a map's files and tells it.
    fn tell(&self, found: Mapped, traced: Traced) -> Result<()> {
        let named = |(name, text): (String, String)| match name.split_once('.') {
            Some((stem, extension)) => (format!("{stem}{}.{extension}", self.suffix), text),
            None => (name, text),
        };
        let files: Vec<(String, String)> = files(&found, None, None).into_iter().map(named).collect();
        let files: Vec<(&str, String)> = files.iter().map(|(name, text)| (name.as_str(), text.clone())).collect();
        write_all(&self.folder, &files)?;
        let mut answer = Answer {
            t: traced.t,
            words: captions(&found, None).join("; "),
            report: report(&found, None),
            summary: summary(&found, None),
        };
        if traced.merged > 0 {
            let late = format!("{} of {} rows merged into others", traced.merged, traced.rows + traced.merged);
            answer.words.push_str(&format!("; {late}"));
            answer.report.push_str(&format!("  tracing was late: {late}\n"));
        }
        // The run may be over.
        let _ = self.answered.send(answer);
        Ok(())
    }
}

fn row(news: News) -> Option<UsedRow> {
    match news {
        News::Row(joined) => Some(UsedRow { joined, merged: 1 }),
        News::Began(..) => None,
    }
}

/// Maps of the rows so far, one at a time.
struct Drafts<'scope, 'env> {
    scope: &'scope Scope<'scope, 'env>,
    maker: &'env Maker,
    under_way: Option<ScopedJoinHandle<'scope, Duration>>,
    due: Instant,
    /// Whether the last row was refused.
    refused: bool,
}

impl Drafts<'_, '_> {
    /// Traces a row; of a stretch that cannot be traced the first one is told.
    fn push(&mut self, mapper: &mut Mapper, joined: &JoinedRow) {
        let refused = mapper.push(&joined.row).err();
        if let Some(error) = refused.as_ref().filter(|_| !self.refused) {
            complain("a row is left out of the map", error);
        }
        self.refused = refused.is_some();
    }

    /// Begins a map if one is due.
    fn begin(&mut self, mapper: &Mapper, traced: Traced) {
        if let Some(done) = self.under_way.take_if(|thread| thread.is_finished()) {
            let took = done.join().unwrap_or_default();
            self.due = Instant::now() + PERIOD.max(PATIENCE * took);
        }
        if self.under_way.is_some() || Instant::now() < self.due {
            return;
        }
        let (mut mapper, maker) = (mapper.clone(), self.maker);
        self.under_way = Some(self.scope.spawn(move || {
            let began = Instant::now();
            // Early on nothing has been felt that makes an outline.
            let told = mapper.map().map_or(Ok(()), |found| maker.tell(found, traced));
            if let Err(error) = told {
                complain("the map cannot be written", &error);
            }
            began.elapsed()
        }));
    }
}
