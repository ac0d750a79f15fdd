//! The robot's seven actions: a turn in place followed by one step forward.

use std::f64::consts::FRAC_PI_4;

use serde::{Deserialize, Serialize};

/// Length of one step in metres (half a foot).
///
/// Source: equation 3 of the paper. The "0.5 meters" in the paper's figure caption contradicts both
/// the text and the equation.
pub const STEP_LENGTH: f64 = 0.1524;

/// One of the seven actions in equation 3 of the paper.
///
/// The robot turns in place by a multiple of 45 degrees, then moves [`STEP_LENGTH`] metres forward.
/// The index, 0..=6, which policies and messages use, determines the turn: 0 turns 135 degrees to
/// the right, 3 keeps the heading, and 6 turns 135 degrees to the left. An action is serialized as
/// its index.
///
/// # Examples
///
/// ```
/// use task::Action;
///
/// let action = Action::try_from(5)?;
/// assert_eq!(action.turn_degrees(), 90);
/// assert_eq!(action.mirrored().turn_degrees(), -90);
///
/// let error = Action::try_from(7).unwrap_err();
/// assert_eq!(error.to_string(), "action: unknown value 7 (expected: 0 to 6)");
/// # Ok::<(), task::action::InvalidAction>(())
/// ```
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(try_from = "u8", into = "u8")]
pub struct Action(u8);

impl Action {
    /// Number of actions.
    pub const COUNT: usize = 7;

    /// All actions, in index order.
    pub const ALL: [Self; Self::COUNT] =
        [Self(0), Self(1), Self(2), Self(3), Self(4), Self(5), Self(6)];

    /// Returns the index of the action, 0..=6.
    pub fn index(self) -> u8 {
        self.0
    }

    /// Returns the turn in units of 45 degrees (eighths of a full turn), -3..=3; counter-clockwise
    /// is positive.
    pub fn turn_eighths(self) -> i8 {
        // The index is at most 6, so the cast is lossless.
        self.0 as i8 - 3
    }

    /// Returns the turn in radians; counter-clockwise is positive.
    pub fn turn(self) -> f64 {
        f64::from(self.turn_eighths()) * FRAC_PI_4
    }

    /// Returns the turn in degrees; counter-clockwise is positive.
    pub fn turn_degrees(self) -> i16 {
        45 * i16::from(self.turn_eighths())
    }

    /// Returns the action that turns by the same angle in the opposite direction.
    pub fn mirrored(self) -> Self {
        Self(Self::COUNT as u8 - 1 - self.0)
    }
}

/// The error for an action index above 6.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("action: unknown value {0} (expected: 0 to 6)")]
pub struct InvalidAction(pub u8);

impl From<Action> for u8 {
    fn from(action: Action) -> u8 {
        action.0
    }
}

impl TryFrom<u8> for Action {
    type Error = InvalidAction;

    /// Converts an index, 0..=6, to its action.
    ///
    /// # Errors
    ///
    /// Returns [`InvalidAction`] if the index is above 6.
    fn try_from(index: u8) -> Result<Self, InvalidAction> {
        if usize::from(index) < Self::COUNT { Ok(Self(index)) } else { Err(InvalidAction(index)) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turns_match_equation_3() {
        let degrees = Action::ALL.map(|action| action.turn().to_degrees());
        assert_eq!(degrees, [-135.0, -90.0, -45.0, 0.0, 45.0, 90.0, 135.0]);
        assert_eq!(Action::ALL.map(Action::turn_degrees), [-135, -90, -45, 0, 45, 90, 135]);
        for action in Action::ALL {
            assert_eq!(action.mirrored().turn_degrees(), -action.turn_degrees());
        }
    }

    #[test]
    fn rejects_an_index_above_6() {
        for index in 0..=u8::MAX {
            match Action::try_from(index) {
                Ok(action) => assert_eq!(action, Action::ALL[usize::from(index)]),
                Err(error) => {
                    assert!(index > 6);
                    assert_eq!(error, InvalidAction(index));
                }
            }
        }
        assert_eq!(InvalidAction(9).to_string(), "action: unknown value 9 (expected: 0 to 6)");
    }
}
