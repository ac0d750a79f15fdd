//! The greedy choice: the action of the greatest value, among those that are not excluded.

use task::Action;

/// The action of the greatest value among those that are not excluded; of equal ones, the first.
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
    /// None of them.
    pub const NONE: ActionSet = ActionSet(0);
    /// All of them.
    pub const ALL: ActionSet = ActionSet((1 << Action::COUNT) - 1);

    /// Whether an action is among them.
    pub fn contains(self, action: Action) -> bool {
        self.0 & (1 << action.index()) != 0
    }

    /// These and one more.
    pub fn with(self, action: Action) -> ActionSet {
        ActionSet(self.0 | 1 << action.index())
    }

    /// How many they are.
    pub fn len(self) -> usize {
        self.0.count_ones() as usize
    }

    /// Whether there is none.
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Their mirror images.
    pub fn mirrored(self) -> ActionSet {
        ActionSet(self.0.reverse_bits() >> (u8::BITS as usize - Action::COUNT))
    }

    /// One bit an action, from the least.
    pub fn bits(self) -> u8 {
        self.0
    }

    /// As [`ActionSet::bits`] gave them.
    pub fn from_bits(bits: u8) -> Option<ActionSet> {
        (bits <= ActionSet::ALL.0).then_some(ActionSet(bits))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_greatest_value_wins_and_the_first_of_equals() {
        let values = [0.0, 0.5, -1.0, 0.5, 0.2, 0.0, 0.1];
        assert_eq!(greedy_action(&values, ActionSet::NONE).index(), 1);
        assert_eq!(greedy_action(&[-3.0; 7], ActionSet::NONE).index(), 0);
        let excluded = ActionSet::NONE.with(Action::ALL[1]);
        assert_eq!(greedy_action(&values, excluded).index(), 3);
        assert_eq!(greedy_action(&values, excluded.with(Action::ALL[3])).index(), 4);
    }

    #[test]
    fn a_set_knows_its_actions() {
        let set = Action::ALL.into_iter().take(6).fold(ActionSet::NONE, ActionSet::with);
        assert!(set.contains(Action::ALL[5]) && !set.contains(Action::ALL[6]));
        assert_eq!(set.len(), 6);
        assert_eq!(set.with(Action::ALL[6]), ActionSet::ALL);
        assert_eq!(ActionSet::from_bits(set.bits()), Some(set));
        assert_eq!(ActionSet::from_bits(128), None);
    }
}
