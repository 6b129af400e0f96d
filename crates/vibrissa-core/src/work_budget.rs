//! How much work is done before the next pause.

/// How much work may be done before the next pause, by counting: the same work on every machine, since nothing here reads clocks.
///
/// A unit is some tenth of a microsecond to a microsecond. Whoever must answer within milliseconds gives a thousand units at a
/// time and looks at the clock in between. Where the pauses are changes no answer.
///
/// ```
/// use vibrissa_core::WorkBudget;
///
/// let mut budget = WorkBudget::new(3);
/// budget.spend(2);
/// assert!(!budget.is_spent());
/// budget.spend(2);
/// assert!(budget.is_spent());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WorkBudget {
    left: usize,
}

impl WorkBudget {
    /// So many units.
    #[must_use]
    pub fn new(units: usize) -> Self {
        Self { left: units }
    }

    /// As much as there is.
    #[must_use]
    pub fn unlimited() -> Self {
        Self::new(usize::MAX)
    }

    /// Takes work that was done off; what is done in one piece may be more than was left.
    pub fn spend(&mut self, units: usize) {
        if self.left < usize::MAX {
            self.left = self.left.saturating_sub(units);
        }
    }

    /// Units that are left.
    pub(crate) fn left(&self) -> usize {
        self.left
    }

    /// Whether it is time to pause.
    #[must_use]
    pub fn is_spent(&self) -> bool {
        self.left == 0
    }
}
