//! The first hypotheses: seeds from a contact, judged by its first rows.

use super::super::feeler::Judge;
use super::super::history::History;
use super::super::hypothesis::{Scene, moved};
use super::super::seed::Seed;
use super::super::seeds::{Onset, Seeding};
use super::super::shares::Shared;
use super::congruent::Trail;
use super::merge::{Prospect, best_of_cells, cells};
use super::{Bank, Field, LOOSE, cut};
use crate::flow::prior;
use crate::plane::{Pose2, Vec2};

/// More hypotheses than this are not carried on.
const MOST_SEEDS: usize = 8000;
/// Standard deviations are enlarged by this while cells are judged.
const SEED_TEMPER: f64 = 1.5;

/// The search for the first hypotheses, in slices: a loaded whisker has every heading and branch at every place.
pub(in super::super) struct Search {
    pub(in super::super) feeler: usize,
    pub(in super::super) onset: usize,
    pub(in super::super) from_free: bool,
    /// Whether the contact has ended, so that following it for longer tells no more.
    pub(in super::super) ended: bool,
    /// How far the base had travelled when it began (m).
    pub(in super::super) travelled: f64,
    rows: Vec<usize>,
    /// How many rows there were then.
    seen: usize,
    pivot: Vec2,
    approach: Vec2,
    stage: Stage,
    /// Whether each hypothesis stands for all its images.
    pub(in super::super) for_all: bool,
    /// What was found before it is run from the first row on, for a search that goes on with more rows.
    pub(in super::super) found: Vec<Seed>,
}

/// What is being done.
enum Stage {
    New,
    Seeding(Seeding),
    /// All rows up to the last that judged, run anew one hypothesis after the other.
    Running(Box<Bank>, usize),
}

impl Search {
    /// A search from the contact that began at row `onset` of the history with this whisker, or from what an earlier one found.
    #[allow(clippy::too_many_arguments, reason = "what is known of the contact")]
    pub(in super::super) fn new(
        field: &Field<'_>,
        history: &History,
        (feeler, onset): (usize, usize),
        from_free: bool,
        ended: bool,
        travelled: f64,
        found: Vec<Seed>,
    ) -> Self {
        let own = &field.feelers[feeler];
        let odom_from_whisker = history.pose(onset).compose(own.robot_from_whisker);
        let tip = Vec2::new(own.length, 0.0);
        let before = history.pose(onset.saturating_sub(3)).compose(own.robot_from_whisker);
        Self {
            feeler,
            onset,
            from_free,
            ended,
            travelled,
            rows: judging_rows(history, feeler, onset, field.options.seed_step),
            seen: history.len(),
            pivot: odom_from_whisker.transform_point(tip),
            approach: tip - odom_from_whisker.inverse_transform_point(before.transform_point(tip)),
            stage: Stage::New,
            for_all: field.options.prior.is_none() && history.heading().is_none() && !field.turns.all.is_empty(),
            found,
        }
    }

    /// Whether more was found than is carried on, so that the truth may be among what was left out.
    pub(in super::super) fn is_cut(&self) -> bool {
        self.found.len() > MOST_SEEDS
    }

    /// Goes on until `work` (readings run through the forward model) is used up; gives the bank when it has come to the end.
    pub(in super::super) fn step(&mut self, field: &Field<'_>, history: &History, work: &mut usize) -> Option<Bank> {
        let options = field.options;
        let judge = Judge { temper: SEED_TEMPER, outlier_cost: f64::INFINITY };
        let scene = Scene { whole: false, ..field.scene(history, self.pivot, judge, Shared::default()) };
        let arm = history.pose(self.onset).compose(field.feelers[self.feeler].robot_from_whisker).position();
        let onset = Onset {
            feeler: self.feeler,
            row: self.onset,
            from_free: self.from_free,
            approach: self.approach,
            rows: &self.rows,
            spacing: options.seed_spacing,
            turn: options.seed_turn,
            turns: self.for_all.then_some(field.turns),
            near: options.prior.map(|region| {
                let slack = 2.0 * options.seed_spacing + arm.norm() * options.seed_turn;
                prior::around(region, arm, slack, field.feelers[self.feeler].length)
            }),
        };
        loop {
            match core::mem::replace(&mut self.stage, Stage::New) {
                Stage::New => {
                    let carried = core::mem::take(&mut self.found);
                    self.stage = Stage::Seeding(Seeding::new(&scene, &onset, carried));
                }
                Stage::Seeding(mut seeding) => {
                    let admits = |map_from_odom: Pose2| {
                        field.admits(history, map_from_odom) && field.stands(history, map_from_odom, self.onset)
                    };
                    if !seeding.step(&scene, &onset, &admits, work) {
                        self.stage = Stage::Seeding(seeding);
                        return None;
                    }
                    self.found = seeding.into_found();
                    self.stage = Stage::Running(Box::new(self.bank(field, history)), 0);
                }
                Stage::Running(mut bank, mut next) => {
                    while next < bank.hypotheses.len() && *work > 0 {
                        bank.rerun(field, history, next..next + 1);
                        *work = work.saturating_sub(bank.used.len());
                        next += 1;
                    }
                    if next < bank.hypotheses.len() {
                        self.stage = Stage::Running(bank, next);
                        return None;
                    }
                    bank.drop_outside(field, history, bank.used.last().copied().unwrap_or(self.onset));
                    bank.find_usual(field, history);
                    bank.merge(history, false);
                    bank.drop_unlikely(field, history);
                    return Some(*bank);
                }
            }
        }
    }

    /// The bank of what was found: the best of those that meet, and no more than can be carried on.
    fn bank(&self, field: &Field<'_>, history: &History) -> Bank {
        let gain = field.options.shared_gain.unwrap_or(field.feelers[self.feeler].shared_share());
        let to = |seed: &Seed, gain: f64| {
            let (cost, d) = seed.place(gain).least(LOOSE);
            Prospect { at: moved(seed.map_from_odom, self.pivot, cut(d)), cost }
        };
        // Those that begin free are judged anew from there, so that none of them has cost anything yet.
        let prospect =
            |seed: &Seed| if self.from_free { Prospect { cost: 0.0, ..to(seed, 0.0) } } else { to(seed, gain) };
        let kept = best_of_cells(
            self.found.iter().map(prospect),
            self.pivot,
            history.pose(history.len() - 1),
            cells(self.found.len()),
        );
        let mut chosen: Vec<&Seed> =
            self.found.iter().zip(kept).filter_map(|(seed, kept)| kept.then_some(seed)).collect();
        if !self.from_free || chosen.len() > MOST_SEEDS {
            chosen.sort_by(|a, b| a.told.constant.total_cmp(&b.told.constant));
        }
        chosen.truncate(MOST_SEEDS);
        let hypothesis = |seed: &Seed| {
            let h = seed.clone().grown(self.onset);
            if self.from_free { h.free_at(to(seed, 0.0).at) } else { h }
        };
        let mut bank = Bank {
            hypotheses: chosen.into_iter().map(hypothesis).collect(),
            used: (0..self.onset).chain(self.rows.iter().copied()).collect(),
            next: self.seen,
            pivot: self.pivot,
            shared: Shared::new(gain, &field.robot.odometry),
            underway: None,
            credit: 0,
            turn: 0,
            since_merge: 0,
            usual: Vec::new(),
            recent: Vec::new(),
            dropped: super::dropped::Dropped::default(),
            trail: self.from_free.then(Trail::default),
            folded: false,
            for_all: self.for_all,
        };
        bank.hypotheses.iter_mut().for_each(|h| h.look(LOOSE, bank.shared));
        bank
    }
}

/// The rows that judge seeds: the onset, then one for every `step` of the base's travel; of three neighbours always
/// that with the middle reading, so that no single false one is taken.
fn judging_rows(history: &History, feeler: usize, onset: usize, step: f64) -> Vec<usize> {
    let last = history.len() - 1;
    let mut rows = vec![onset];
    let mut travelled = 0.0;
    for row in onset + 1..last {
        travelled += history.pose(row).position().distance(history.pose(row - 1).position());
        if travelled >= step {
            let mut three = [row - 1, row, row + 1];
            three.sort_by(|&a, &b| history.readings(a)[feeler].total_cmp(&history.readings(b)[feeler]));
            if three[1] > rows[rows.len() - 1] {
                rows.push(three[1]);
                travelled = 0.0;
            }
        }
    }
    rows
}
