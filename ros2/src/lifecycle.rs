//! The states of a managed node and what leads from one to another, as `lifecycle_msgs` numbers them.

use crate::messages::{State, Transition, TransitionDescription};

/// A primary state of a managed node.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Lifecycle {
    /// Nothing is loaded.
    #[default]
    Unconfigured,
    /// Map and robot are loaded; nothing is estimated.
    Inactive,
    /// Rows are estimated and told.
    Active,
    /// The node ends.
    Finalized,
}

/// What a manager asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Change {
    /// Load map and robot.
    Configure,
    /// Forget them.
    CleanUp,
    /// Estimate.
    Activate,
    /// Stop to estimate.
    Deactivate,
    /// End, whatever the state.
    Shutdown,
}

/// Every change by its number: number, word, from, to.
const CHANGES: [(u8, &str, Change, Lifecycle, Lifecycle); 7] = [
    (1, "configure", Change::Configure, Lifecycle::Unconfigured, Lifecycle::Inactive),
    (2, "cleanup", Change::CleanUp, Lifecycle::Inactive, Lifecycle::Unconfigured),
    (3, "activate", Change::Activate, Lifecycle::Inactive, Lifecycle::Active),
    (4, "deactivate", Change::Deactivate, Lifecycle::Active, Lifecycle::Inactive),
    (5, "shutdown", Change::Shutdown, Lifecycle::Unconfigured, Lifecycle::Finalized),
    (6, "shutdown", Change::Shutdown, Lifecycle::Inactive, Lifecycle::Finalized),
    (7, "shutdown", Change::Shutdown, Lifecycle::Active, Lifecycle::Finalized),
];

impl Lifecycle {
    /// Every state.
    pub const ALL: [Self; 4] = [Self::Unconfigured, Self::Inactive, Self::Active, Self::Finalized];

    /// The state as a message.
    #[must_use]
    pub fn message(self) -> State {
        let (id, label) = match self {
            Self::Unconfigured => (1, "unconfigured"),
            Self::Inactive => (2, "inactive"),
            Self::Active => (3, "active"),
            Self::Finalized => (4, "finalized"),
        };
        State { id, label: label.to_owned() }
    }

    /// What a request leads to from here: the change, the next state, and its description; none where it may not be asked for.
    /// A request of number 0 is known by its word.
    #[must_use]
    pub fn change(self, asked: &Transition) -> Option<(Change, Self, TransitionDescription)> {
        let found = CHANGES.into_iter().find(|&(id, label, _, from, _)| {
            from == self && (id == asked.id || (asked.id == 0 && label == asked.label))
        });
        found.map(|one| (one.2, one.4, description(one)))
    }

    /// The changes that may be asked for here.
    #[must_use]
    pub fn changes(self) -> Vec<TransitionDescription> {
        CHANGES.into_iter().filter(|one| one.3 == self).map(description).collect()
    }

    /// The changes of all states.
    #[must_use]
    pub fn graph() -> Vec<TransitionDescription> {
        CHANGES.into_iter().map(description).collect()
    }
}

fn description((id, label, _, from, to): (u8, &str, Change, Lifecycle, Lifecycle)) -> TransitionDescription {
    TransitionDescription {
        transition: Transition { id, label: label.to_owned() },
        start_state: from.message(),
        goal_state: to.message(),
    }
}

#[cfg(test)]
mod tests {
    use super::{Change, Lifecycle};
    use crate::messages::Transition;

    #[test]
    fn only_what_a_state_allows_is_done() {
        let by_id = |id| Transition { id, label: String::new() };
        let next = |state: Lifecycle, id| state.change(&by_id(id)).map(|(change, next, _)| (change, next));
        assert_eq!(next(Lifecycle::Unconfigured, 1), Some((Change::Configure, Lifecycle::Inactive)));
        assert_eq!(next(Lifecycle::Inactive, 3), Some((Change::Activate, Lifecycle::Active)));
        assert_eq!(next(Lifecycle::Active, 7), Some((Change::Shutdown, Lifecycle::Finalized)));
        for (state, id) in [(Lifecycle::Unconfigured, 3), (Lifecycle::Active, 1), (Lifecycle::Finalized, 5)] {
            assert_eq!(next(state, id), None);
        }
        let word = Transition { id: 0, label: "shutdown".to_owned() };
        assert_eq!(Lifecycle::Inactive.change(&word).map(|found| found.2.transition.id), Some(6));
    }
}
