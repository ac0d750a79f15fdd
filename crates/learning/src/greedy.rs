//! Greedy action selection, and sets of actions.
//!
//! # Examples
//!
//! ```
//! use learning::greedy::{ActionSet, greedy_action};
//!
//! let values = [0.0, 0.5, -1.0, 0.5, 0.2, 0.0, 0.1];
//! let best = greedy_action(&values, ActionSet::NONE);
//! assert_eq!(best.index(), 1);
//! assert_eq!(greedy_action(&values, ActionSet::NONE.with(best)).index(), 3);
//! ```

use task::Action;

/// Returns the action with the highest value among those that are not excluded. If several actions
/// share the highest value, the first of them is returned.
///
/// Returns the default action (index 0) if all actions are excluded.
pub fn greedy_action(values: &[f32; Action::COUNT], excluded: ActionSet) -> Action {
    let allowed = Action::ALL.into_iter().filter(|action| !excluded.contains(*action));
    let value = |action: Action| values[usize::from(action.index())];
    allowed
        .reduce(|best, action| if value(action) > value(best) { action } else { best })
        .unwrap_or_default()
}

/// A set of actions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ActionSet(u8);

impl ActionSet {
    /// The empty set.
    pub const NONE: ActionSet = ActionSet(0);
    /// The set of all actions.
    pub const ALL: ActionSet = ActionSet((1 << Action::COUNT) - 1);

    /// Returns whether the set contains the given action.
    pub fn contains(self, action: Action) -> bool {
        self.0 & (1 << action.index()) != 0
    }

    /// Returns the set with the given action added.
    pub fn with(self, action: Action) -> ActionSet {
        ActionSet(self.0 | 1 << action.index())
    }

    /// Returns the number of actions in the set.
    pub fn len(self) -> usize {
        self.0.count_ones() as usize
    }

    /// Returns whether the set is empty.
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Returns the set of mirrored actions ([`Action::mirrored`]).
    pub fn mirrored(self) -> ActionSet {
        ActionSet(self.0.reverse_bits() >> (u8::BITS as usize - Action::COUNT))
    }

    /// Returns the set as bits; the least significant bit is action 0.
    pub fn bits(self) -> u8 {
        self.0
    }

    /// Returns the set with the given [`bits`](ActionSet::bits), or `None` if a set bit does not
    /// correspond to an action.
    pub fn from_bits(bits: u8) -> Option<ActionSet> {
        (bits <= ActionSet::ALL.0).then_some(ActionSet(bits))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn selects_the_highest_value_and_the_first_of_equal_values() {
        let values = [0.0, 0.5, -1.0, 0.5, 0.2, 0.0, 0.1];
        assert_eq!(greedy_action(&values, ActionSet::NONE).index(), 1);
        assert_eq!(greedy_action(&[-3.0; 7], ActionSet::NONE).index(), 0);
        let excluded = ActionSet::NONE.with(Action::ALL[1]);
        assert_eq!(greedy_action(&values, excluded).index(), 3);
        assert_eq!(greedy_action(&values, excluded.with(Action::ALL[3])).index(), 4);
    }

    #[test]
    fn a_set_contains_the_actions_added_to_it() {
        let set = Action::ALL.into_iter().take(6).fold(ActionSet::NONE, ActionSet::with);
        assert!(set.contains(Action::ALL[5]) && !set.contains(Action::ALL[6]));
        assert_eq!(set.len(), 6);
        assert_eq!(set.with(Action::ALL[6]), ActionSet::ALL);
        assert_eq!(ActionSet::from_bits(set.bits()), Some(set));
        assert_eq!(ActionSet::from_bits(128), None);
    }
}
