//! What the robot can do: turn, then step.

use std::f64::consts::FRAC_PI_4;

use serde::{Deserialize, Serialize};

/// How far the robot moves in one step, in metres: half a foot.
///
/// The paper's text and equation 3 say 0.5 ft; the "0.5 meters" in its figure caption is a slip.
pub const STEP_LENGTH: f64 = 0.1524;

/// One of the seven moves of the paper's equation 3: a turn by a multiple of 45 degrees within
/// ±135, then one [`STEP_LENGTH`] forward.
///
/// Made from the index that policies and messages use: 0 turns by -135 degrees (right), 3 goes
/// straight on, 6 turns by 135 degrees (left).
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(try_from = "u8", into = "u8")]
pub struct Action(u8);

impl Action {
    /// How many actions there are.
    pub const COUNT: usize = 7;

    /// Every action, by index.
    pub const ALL: [Self; Self::COUNT] =
        [Self(0), Self(1), Self(2), Self(3), Self(4), Self(5), Self(6)];

    /// The action's index, 0..=6.
    pub fn index(self) -> u8 {
        self.0
    }

    /// The turn before the step, in eighths of a full turn, counter-clockwise: -3..=3.
    pub fn eighths(self) -> i8 {
        // At most 6, so the conversion keeps the value.
        self.0 as i8 - 3
    }

    /// The turn before the step, in radians, counter-clockwise.
    pub fn turn(self) -> f64 {
        f64::from(self.eighths()) * FRAC_PI_4
    }

    /// The turn before the step, in degrees, counter-clockwise.
    pub fn turn_degrees(self) -> i16 {
        45 * i16::from(self.eighths())
    }

    /// The action that turns by the same angle to the other side.
    pub fn mirrored(self) -> Self {
        Self(Self::COUNT as u8 - 1 - self.0)
    }
}

/// There is no action with this index.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("action {0} does not exist: expected 0 to 6")]
pub struct InvalidAction(pub u8);

impl From<Action> for u8 {
    fn from(action: Action) -> u8 {
        action.0
    }
}

impl TryFrom<u8> for Action {
    type Error = InvalidAction;

    fn try_from(index: u8) -> Result<Self, InvalidAction> {
        if usize::from(index) < Self::COUNT { Ok(Self(index)) } else { Err(InvalidAction(index)) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turns_are_those_of_equation_3() {
        let degrees = Action::ALL.map(|action| action.turn().to_degrees());
        assert_eq!(degrees, [-135.0, -90.0, -45.0, 0.0, 45.0, 90.0, 135.0]);
        assert_eq!(Action::ALL.map(Action::turn_degrees), [-135, -90, -45, 0, 45, 90, 135]);
        for action in Action::ALL {
            assert_eq!(action.mirrored().turn_degrees(), -action.turn_degrees());
        }
    }

    #[test]
    fn only_seven_indices_are_actions() {
        for index in 0..=u8::MAX {
            match Action::try_from(index) {
                Ok(action) => assert_eq!(action, Action::ALL[usize::from(index)]),
                Err(error) => {
                    assert!(index > 6);
                    assert_eq!(error, InvalidAction(index));
                }
            }
        }
        assert_eq!(InvalidAction(9).to_string(), "action 9 does not exist: expected 0 to 6");
    }
}
