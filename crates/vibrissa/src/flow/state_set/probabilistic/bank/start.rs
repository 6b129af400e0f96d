//! The first hypotheses: seeds from a contact, judged by its first rows.

use super::super::history::{History, Judge};
use super::super::hypothesis::{Scene, moved};
use super::super::seeds::{Onset, seeds};
use super::{Bank, Field, LOOSE, cut};
use crate::flow::prior;
use crate::plane::{Pose2, Vec2};

/// More hypotheses than this are not carried on.
const MOST_SEEDS: usize = 8000;
/// Standard deviations are enlarged by this while cells are judged.
const SEED_TEMPER: f64 = 1.5;

impl Bank {
    /// Seeds from the contact that began at row `onset` of the history with this whisker.
    pub(in super::super) fn start(
        field: &Field<'_>,
        history: &History,
        feeler: usize,
        onset: usize,
        from_free: bool,
    ) -> Self {
        let options = field.options;
        let own = &field.feelers[feeler];
        let odom_from_whisker = history.pose(onset).compose(own.robot_from_whisker);
        let tip = Vec2::new(own.length, 0.0);
        let pivot = odom_from_whisker.transform_point(tip);
        let rows = judging_rows(history, feeler, onset, options.seed_step);
        let before = history.pose(onset.saturating_sub(3)).compose(own.robot_from_whisker);
        let approach = tip - odom_from_whisker.inverse_transform_point(before.transform_point(tip));
        let judge = Judge { temper: SEED_TEMPER, outlier_cost: f64::INFINITY };
        let scene = Scene { whole: false, ..field.scene(history, pivot, judge, 0.0) };
        let onset_of = Onset {
            feeler,
            row: onset,
            from_free,
            approach,
            rows: &rows,
            spacing: options.seed_spacing,
            turn: options.seed_turn,
            near: options.prior.map(|region| {
                let arm = odom_from_whisker.position();
                let slack = 2.0 * options.seed_spacing + arm.norm() * options.seed_turn;
                prior::around(region, arm, slack, own.length)
            }),
        };
        let admits = |map_from_odom: Pose2| field.admits(history, map_from_odom);
        let mut hypotheses = seeds(&scene, &onset_of, &admits);
        if from_free {
            hypotheses.iter_mut().for_each(|h| {
                h.map_from_odom = moved(h.map_from_odom, pivot, cut(h.best(LOOSE, 0.0).1));
                *h = h.restarted_free();
            });
        }
        let used = (0..onset).chain(rows).collect();
        let mut bank = Self {
            hypotheses,
            used,
            pivot,
            shared: options.shared_gain.unwrap_or(own.shared_share()),
            credit: 0,
            turn: 0,
            since_merge: 0,
            recent: Vec::new(),
            folded: false,
        };
        bank.merge(field, history);
        bank.hypotheses.sort_by(|a, b| a.normal.cost.total_cmp(&b.normal.cost));
        bank.hypotheses.truncate(MOST_SEEDS);
        bank.rerun(field, history);
        bank.merge(field, history);
        bank.drop_unlikely(field, history);
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
