//! Rows to estimates, on a thread of its own: a search of the map takes a tenth of a second, and nobody waits for it.

use super::queue::Shared;
use crate::Result;
use crate::estimate::LiveEstimator;
use crate::journal::{Journal, row_names};
use crate::pipeline::Notice;
use crate::source::HostClock;
use vibrissa_core::flow::pose::{Estimate, Localization};
use vibrissa_core::localizer::Method;
use vibrissa_core::world::Map;

/// What the estimator ends with.
pub(super) type Outcome = (Estimate, Option<Localization>);

/// Estimates until no rows come any more.
pub(super) fn estimate_rows(
    map: Option<&Map>,
    (method, rate): (&Method, f64),
    journal: Option<&Journal>,
    clock: &HostClock,
    shared: &Shared,
) -> Result<Outcome> {
    let outcome = take_rows(map, (method, rate), journal, clock, shared);
    shared.finish();
    outcome
}

fn take_rows(
    map: Option<&Map>,
    (method, rate): (&Method, f64),
    journal: Option<&Journal>,
    clock: &HostClock,
    shared: &Shared,
) -> Result<Outcome> {
    let Some((channels, robot)) = shared.known()? else { return Ok((Estimate::default(), None)) };
    let estimator = |map| LiveEstimator::new(map, &robot, &channels, method, rate);
    let mut estimator = map.map(estimator).transpose()?;
    let names = row_names(&channels);
    let mut refusing = false;
    while let Some(rows) = shared.rows()? {
        for used in rows {
            if let Some(journal) = journal {
                journal.row(&names, &used);
            }
            let step = estimator.as_mut().map_or(Ok(None), |estimator| estimator.step(&used.joined));
            let now = clock.now();
            let (told, error) = match step {
                Ok(told) => (told, None),
                Err(error) => (None, Some(error)),
            };
            // Of a stretch that is refused the first row is told.
            let is_new = error.is_some() && !refusing;
            refusing = error.is_some();
            let notice = error.map(|error| Notice {
                t: used.joined.row.t,
                source: "rows".to_owned(),
                text: error.to_string().replace("\n  help: ", "; "),
            });
            shared.took(&used, now, told, refusing, notice.filter(|_| is_new));
        }
    }
    let estimate = estimator.as_ref().map(LiveEstimator::estimate).unwrap_or_default();
    Ok((estimate, estimator.map(LiveEstimator::finish)))
}
