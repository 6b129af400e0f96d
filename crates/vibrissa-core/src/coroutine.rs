//! Work that pauses: a coroutine \[conway1963design\], written as an `async` function.
//!
//! Work that keeps its place in a few numbers pauses by keeping them (`flow/state_set/possibilistic/agenda`). Work that is many functions
//! deep is written as `async` functions instead, and the compiler keeps the place. No runtime is behind it: whoever wants the result resumes
//! the coroutine until it has come to its end.

use crate::{Stop, WorkBudget};
use core::future::{Future, poll_fn};
use core::pin::{Pin, pin};
use core::task::{Context, Poll, Waker};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// How much work a coroutine may do before it pauses: of the one who resumes it to those who work. Clones are one and the same; a new one
/// never pauses.
#[derive(Clone, Debug)]
pub(crate) struct Pace(Arc<AtomicUsize>);

impl Default for Pace {
    fn default() -> Self {
        Self(Arc::new(AtomicUsize::new(usize::MAX)))
    }
}

impl Pace {
    /// Takes work off that was done, and pauses if none is left.
    pub(crate) fn spend(&self, units: usize) -> Pause<'_> {
        Pause { pace: self, units, has_paused: false }
    }

    /// Takes work off that was done; whether it is time to pause.
    fn take_off(&self, units: usize) -> bool {
        let left = self.0.load(Ordering::Relaxed);
        if left == usize::MAX {
            return false;
        }
        self.0.store(left.saturating_sub(units), Ordering::Relaxed);
        left <= units
    }
}

/// Work that was done, after which there may be a pause, see [`Pace::spend`].
#[must_use = "nothing is spent until it is awaited"]
pub(crate) struct Pause<'a> {
    pace: &'a Pace,
    units: usize,
    has_paused: bool,
}

impl Future for Pause<'_> {
    type Output = ();

    fn poll(mut self: Pin<&mut Self>, _: &mut Context<'_>) -> Poll<()> {
        if self.has_paused || !self.pace.take_off(self.units) {
            return Poll::Ready(());
        }
        self.has_paused = true;
        Poll::Pending
    }
}

/// A computation that can be left and taken up again.
pub(crate) struct Coroutine<'a, T> {
    body: Pin<Box<dyn Future<Output = T> + Send + 'a>>,
    pace: Pace,
}

impl<'a, T> Coroutine<'a, T> {
    /// Not begun yet; the body pauses nowhere but where it spends at this pace.
    pub(crate) fn new(pace: Pace, body: impl Future<Output = T> + Send + 'a) -> Self {
        Self { body: Box::pin(body), pace }
    }

    /// Goes on until the budget is spent; gives the result at the end, after which it must not be resumed.
    pub(crate) fn resume(&mut self, budget: &mut WorkBudget) -> Option<T> {
        if budget.is_spent() {
            return None;
        }
        self.pace.0.store(budget.left(), Ordering::Relaxed);
        let polled = self.body.as_mut().poll(&mut Context::from_waker(Waker::noop()));
        *budget = WorkBudget::new(self.pace.0.swap(usize::MAX, Ordering::Relaxed));
        match polled {
            Poll::Ready(result) => Some(result),
            Poll::Pending => None,
        }
    }
}

/// The result of a computation that pauses nowhere, since nobody has given it a budget.
pub(crate) fn completed<T>(body: impl Future<Output = T>) -> T {
    let mut body = pin!(body);
    loop {
        if let Poll::Ready(result) = body.as_mut().poll(&mut Context::from_waker(Waker::noop())) {
            return result;
        }
    }
}

/// What a computation gives; none where its end is asked for by the time of one of its pauses.
pub(crate) async fn until<T>(stop: &Stop, body: impl Future<Output = T>) -> Option<T> {
    let mut body = pin!(body);
    poll_fn(|context| match body.as_mut().poll(context) {
        Poll::Ready(result) => Poll::Ready(Some(result)),
        Poll::Pending if stop.is_asked() => Poll::Ready(None),
        Poll::Pending => Poll::Pending,
    })
    .await
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The sum of the numbers below `n`, each of which costs as much as it is.
    async fn sum(pace: &Pace, n: usize) -> usize {
        let mut sum = 0;
        for k in 0..n {
            sum += k;
            pace.spend(k).await;
        }
        sum
    }

    #[test]
    fn slices_change_no_result_and_budgets_are_kept() {
        assert_eq!(completed(sum(&Pace::default(), 100)), 4950);
        for units in [1, 7, 1000, 100_000] {
            let pace = Pace::default();
            let mut coroutine = Coroutine::new(pace.clone(), async move { sum(&pace, 100).await });
            let (mut slices, mut found) = (0, None);
            while found.is_none() {
                let mut budget = WorkBudget::new(units);
                found = coroutine.resume(&mut budget);
                slices += 1;
                assert!(found.is_some() || budget.is_spent());
            }
            assert_eq!(found, Some(4950));
            // A slice may go over its budget by one number.
            assert!(slices <= 4950 / units + 1 && slices >= 4950 / (units + 99), "{slices} slices of {units}");
        }
    }

    #[test]
    fn what_is_asked_to_end_ends_at_a_pause() {
        let (stop, pace) = (Stop::default(), Pace::default());
        let (heeded, own) = (stop.clone(), pace.clone());
        let mut coroutine = Coroutine::new(pace, async move { until(&heeded, sum(&own, 100)).await });
        assert_eq!(coroutine.resume(&mut WorkBudget::new(10)), None);
        stop.ask();
        assert_eq!(coroutine.resume(&mut WorkBudget::new(10)), Some(None));
        // Without a pause nothing is left undone.
        assert_eq!(completed(until(&stop, sum(&Pace::default(), 100))), Some(4950));
    }

    #[test]
    fn a_spent_budget_does_nothing() {
        let mut coroutine = Coroutine::new(Pace::default(), async { 1 });
        assert_eq!(coroutine.resume(&mut WorkBudget::new(0)), None);
        assert_eq!(coroutine.resume(&mut WorkBudget::unlimited()), Some(1));
    }
}
