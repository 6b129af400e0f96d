//! The modes at the end of a log: each at its least cost over all rows, the noise of its readings estimated, and likelier minima looked for
//! around the best by multistart \[marti2003multistart\].

use super::super::adaptive_sampling::ProposalComponent;
use super::super::correlated_noise::NoiseModel;
use super::super::measurement::{MeasurementModel, Row, State, moved};
use super::super::optimisation::UNEXPLAINED;
use super::super::unknowns::POSE;
use super::{Bank, MOVED, SLACK, STEPS, WEAK_PRIOR, key_rows};

/// So many of the best modes are looked around from,
const LOOKED_AROUND: usize = 4;
/// by so many starts, drawn from so much wider a Gaussian; so many of them are descended from, in so many steps.
const STARTS: usize = 40;
const START_WIDTH: f64 = 1.3;
const DESCENDED: usize = 6;
const DESCENDED_STEPS: usize = 6;
/// Steps of a mode before the noise of its readings is estimated.
const STEPS_BEFORE_NOISE: usize = 3;
/// So many of the best are searched along their open direction: once as long as key rows judge, and up to so often when all rows do, by the
/// key rows and those around unexplained readings. Of 184 drags along a block and off its corner, drawn at random, the true place is missed in 8
/// with the latter, in 19 without it.
const MOST_SEARCHED: usize = 40;
const SEARCHES: usize = 4;
const AROUND: usize = 2;

impl Bank {
    /// Moves every mode to its least cost over all rows, and looks for likelier ones around the best; no mode is kept that costs more than
    /// `gate` above the best. The noise of each mode is that of its residuals afterwards.
    pub(in super::super) async fn refine(&mut self, model: &MeasurementModel<'_>, gate: f64) {
        for gate in [gate + SLACK, gate + 0.5 * SLACK] {
            self.settle(model, key_rows(model, None, 0..model.window.len()), STEPS, gate, MOST_SEARCHED).await;
            self.join_overlapping(model).await;
        }
        self.explain_events(model).await;
        self.settle(model, (0..model.window.len()).collect(), STEPS, gate + 0.5 * SLACK, 0).await;
        self.estimate_noise(model).await;
        self.multistart(model).await;
        self.settle(model, (0..model.window.len()).collect(), STEPS, gate, 0).await;
    }

    /// Fits every mode to these rows until it is settled; so many of the best are searched along their open direction first.
    async fn settle(
        &mut self,
        model: &MeasurementModel<'_>,
        rows: Vec<usize>,
        steps: usize,
        gate: f64,
        searched: usize,
    ) {
        self.rows = rows;
        self.seen = model.window.len();
        self.relinearise(model).await;
        self.modes.sort_by(|a, b| a.evidence().total_cmp(&b.evidence()));
        for mode in self.modes.iter_mut().take(searched) {
            mode.search_line(model, &self.rows, &mut self.scratch).await;
        }
        self.prune(gate);
        for mode in &mut self.modes {
            mode.descend(model, &self.rows, steps, &mut self.scratch).await;
            if mode.might_move(MOVED) {
                mode.descend_independently(model, &self.rows, steps, &mut self.scratch).await;
            }
        }
        self.prune(gate);
        self.sort(model).await;
    }

    /// Searches the modes that leave readings unexplained along their open direction: one that stands beside its place misses when a contact
    /// begins or ends by some rows, which no derivative tells.
    async fn explain_events(&mut self, model: &MeasurementModel<'_>) {
        let all: Vec<usize> = (0..model.window.len()).collect();
        let keys = key_rows(model, None, 0..all.len());
        for mode in self.modes.iter_mut().take(MOST_SEARCHED) {
            for _ in 0..SEARCHES {
                model.run(&mode.state, &mode.start, &all, &mut self.scratch).await;
                let mut rows: Vec<usize> = unexplained_rows(&self.scratch.rows)
                    .flat_map(|row| row.saturating_sub(AROUND)..(row + AROUND + 1).min(all.len()))
                    .collect();
                if rows.is_empty() {
                    break;
                }
                rows.extend(&keys);
                rows.sort_unstable();
                rows.dedup();
                mode.relinearise(model, &rows, &mut self.scratch).await;
                if !mode.search_line(model, &rows, &mut self.scratch).await {
                    break;
                }
                mode.descend(model, &rows, STEPS, &mut self.scratch).await;
            }
        }
    }

    /// Takes for each mode the noise that its residuals tell.
    async fn estimate_noise(&mut self, model: &MeasurementModel<'_>) {
        for mode in &mut self.modes {
            mode.descend(model, &self.rows, STEPS_BEFORE_NOISE, &mut self.scratch).await;
            let (noise, credit) = mode.estimated_noise(model, &self.rows, &mut self.scratch).await;
            *mode = mode.by(noise);
            mode.fits[0].credit = credit;
            mode.relinearise(model, &self.rows, &mut self.scratch).await;
            // Modes are compared where they cost least by their own noise.
            mode.descend(model, &self.rows, STEPS, &mut self.scratch).await;
        }
    }

    /// Looks for likelier minima around the best modes under their own noise: starts drawn from what independent errors allow, the likeliest of
    /// which are descended from \[marti2003multistart\].
    async fn multistart(&mut self, model: &MeasurementModel<'_>) {
        let rows = self.rows.clone();
        let thinned: Vec<usize> = key_rows(model, None, 0..model.window.len());
        let mut found = Vec::new();
        for mode in self.modes.iter().take(LOOKED_AROUND) {
            let mut wide = mode.by(NoiseModel::DECLARED);
            wide.relinearise(model, &thinned, &mut self.scratch).await;
            let around =
                wide.marginal(model).covariance(WEAK_PRIOR).and_then(|c| ProposalComponent::new([0.0; POSE], &c));
            let Some(around) = around else { continue };
            let mut starts: Vec<(f64, State)> = Vec::with_capacity(STARTS);
            for n in 0..STARTS {
                let frame = moved(mode.state.frame, model.pivot(), around.sample(n, START_WIDTH));
                let there = mode.at(mode.state_at(model, frame), model, &thinned, &mut self.scratch).await;
                starts.push((there.evidence(), there.state));
            }
            starts.sort_by(|a, b| a.0.total_cmp(&b.0));
            for (_, state) in starts.into_iter().take(DESCENDED) {
                let mut there = mode.at(state, model, &rows, &mut self.scratch).await;
                there.descend(model, &rows, DESCENDED_STEPS, &mut self.scratch).await;
                found.push(there);
            }
        }
        self.modes.extend(found);
    }
}

/// The rows with readings that are further off than noise.
fn unexplained_rows(rows: &[Row]) -> impl Iterator<Item = usize> {
    rows.iter().filter(|row| row.plain.abs() > UNEXPLAINED).map(|row| row.row)
}
