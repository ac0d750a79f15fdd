//! What the robot can do: one of seven turns, then half a foot forward (eq. 3).

use thiserror::Error;

/// The index of an action in the paper's action space, 0 to 6 by construction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Action(u8);

/// The turns of the actions, in degrees, counter-clockwise (eq. 3).
pub const TURNS_DEGREES: [i16; Action::COUNT] = [-135, -90, -45, 0, 45, 90, 135];

/// Why a number is no action.
#[derive(Debug, Error, PartialEq)]
#[error("{0} is no action: expected 0 to 6")]
pub struct NoSuchAction(pub u8);

impl Action {
    /// How many actions there are.
    pub const COUNT: usize = 7;

    /// The index, 0 to 6.
    pub fn index(self) -> u8 {
        self.0
    }

    /// The turn in degrees, counter-clockwise.
    pub fn turn_degrees(self) -> i16 {
        TURNS_DEGREES[usize::from(self.0)]
    }

    /// All of them.
    pub fn all() -> impl Iterator<Item = Action> {
        (0..Action::COUNT as u8).map(Action)
    }

    /// The turn to the other side.
    pub fn mirrored(self) -> Action {
        Action(Action::COUNT as u8 - 1 - self.0)
    }

    /// The action of the greatest value among those that are not excluded; of equal ones, the first.
    pub fn greatest(values: &[f32; Action::COUNT], excluded: ActionSet) -> Action {
        let allowed = Action::all().filter(|action| !excluded.contains(*action));
        let value = |action: Action| values[usize::from(action.0)];
        allowed
            .reduce(|best, action| if value(action) > value(best) { action } else { best })
            .unwrap_or(Action(0))
    }
}

/// Some of the actions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ActionSet(u8);

impl ActionSet {
    /// None of them.
    pub const NONE: ActionSet = ActionSet(0);
    /// All of them.
    pub const ALL: ActionSet = ActionSet((1 << Action::COUNT) - 1);

    /// Whether an action is among them.
    pub fn contains(self, action: Action) -> bool {
        self.0 & (1 << action.0) != 0
    }

    /// These and one more.
    pub fn with(self, action: Action) -> ActionSet {
        ActionSet(self.0 | 1 << action.0)
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

impl TryFrom<u8> for Action {
    type Error = NoSuchAction;

    fn try_from(index: u8) -> Result<Action, NoSuchAction> {
        if usize::from(index) < Action::COUNT {
            Ok(Action(index))
        } else {
            Err(NoSuchAction(index))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_are_seven() {
        assert_eq!(Action::try_from(6).unwrap().turn_degrees(), 135);
        assert_eq!(Action::try_from(7), Err(NoSuchAction(7)));
    }

    #[test]
    fn the_greatest_value_wins_and_the_first_of_equals() {
        let values = [0.0, 0.5, -1.0, 0.5, 0.2, 0.0, 0.1];
        assert_eq!(Action::greatest(&values, ActionSet::NONE).index(), 1);
        assert_eq!(Action::greatest(&[-3.0; 7], ActionSet::NONE).index(), 0);
        let excluded = ActionSet::NONE.with(Action(1));
        assert_eq!(Action::greatest(&values, excluded).index(), 3);
        assert_eq!(Action::greatest(&values, excluded.with(Action(3))).index(), 4);
    }

    #[test]
    fn a_set_knows_its_actions() {
        let set = Action::all().take(6).fold(ActionSet::NONE, ActionSet::with);
        assert!(set.contains(Action(5)) && !set.contains(Action(6)));
        assert_eq!(set.len(), 6);
        assert_eq!(set.with(Action(6)), ActionSet::ALL);
        assert_eq!(ActionSet::from_bits(set.bits()), Some(set));
        assert_eq!(ActionSet::from_bits(128), None);
    }
}
