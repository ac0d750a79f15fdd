//! What the robot can do: one of seven turns, then half a foot forward (eq. 3).

use thiserror::Error;

/// The index of an action in the paper's action space, 0 to 6 by construction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
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

    /// The action of the greatest value; of equal ones, the first.
    pub fn greatest(values: &[f32; Action::COUNT]) -> Action {
        let mut greatest = 0;
        for index in 1..Action::COUNT {
            if values[index] > values[greatest] {
                greatest = index;
            }
        }
        Action(greatest as u8)
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
        assert_eq!(Action::greatest(&[0.0, 0.5, -1.0, 0.5, 0.2, 0.0, 0.1]).index(), 1);
        assert_eq!(Action::greatest(&[-3.0; 7]).index(), 0);
    }
}
