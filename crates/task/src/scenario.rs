//! The experiments of the paper, by what stands in the room.

use std::fmt;
use std::str::FromStr;

/// What stands in the room beside the robot and the exit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Scenario {
    /// Nothing.
    Empty,
    /// One cylinder, placed anew at every reset.
    OneCylinder,
    /// Two cylinders, placed anew at every reset.
    TwoCylinders,
    /// Three cylinders, placed anew at every reset.
    ThreeCylinders,
    /// A half circle of wall, always in the middle of the room.
    Concave,
    /// One cylinder that wanders.
    OneMoving,
    /// Two cylinders that wander.
    TwoMoving,
    /// Three cylinders that wander.
    ThreeMoving,
}

impl Scenario {
    /// Every scenario.
    pub const ALL: [Self; 8] = [
        Self::Empty,
        Self::OneCylinder,
        Self::TwoCylinders,
        Self::ThreeCylinders,
        Self::Concave,
        Self::OneMoving,
        Self::TwoMoving,
        Self::ThreeMoving,
    ];

    /// The name that parameters, messages and files use.
    pub fn name(self) -> &'static str {
        match self {
            Self::Empty => "empty",
            Self::OneCylinder => "one_cylinder",
            Self::TwoCylinders => "two_cylinders",
            Self::ThreeCylinders => "three_cylinders",
            Self::Concave => "concave",
            Self::OneMoving => "one_moving",
            Self::TwoMoving => "two_moving",
            Self::ThreeMoving => "three_moving",
        }
    }

    /// How many cylinders stand or move in the room.
    pub fn cylinders(self) -> usize {
        match self {
            Self::Empty | Self::Concave => 0,
            Self::OneCylinder | Self::OneMoving => 1,
            Self::TwoCylinders | Self::TwoMoving => 2,
            Self::ThreeCylinders | Self::ThreeMoving => 3,
        }
    }

    /// Whether the cylinders move.
    pub fn moving(self) -> bool {
        matches!(self, Self::OneMoving | Self::TwoMoving | Self::ThreeMoving)
    }

    /// Whether the concave wall stands in the room.
    pub fn concave(self) -> bool {
        self == Self::Concave
    }
}

impl fmt::Display for Scenario {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(self.name())
    }
}

/// There is no scenario with this name.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "scenario `{0}` does not exist: it is one of {names}",
    names = Scenario::ALL.map(Scenario::name).join(", ")
)]
pub struct UnknownScenario(pub String);

impl FromStr for Scenario {
    type Err = UnknownScenario;

    fn from_str(name: &str) -> Result<Self, UnknownScenario> {
        Self::ALL
            .into_iter()
            .find(|scenario| scenario.name() == name)
            // A name may be as long as a message; the error goes back to whoever sent it.
            .ok_or_else(|| UnknownScenario(name.chars().take(100).collect()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_back() {
        for scenario in Scenario::ALL {
            assert_eq!(scenario.to_string().parse(), Ok(scenario));
        }
    }

    #[test]
    fn an_unknown_name_is_answered_with_the_known_ones() {
        let error = "maze".parse::<Scenario>().unwrap_err();
        assert_eq!(
            error.to_string(),
            "scenario `maze` does not exist: it is one of empty, one_cylinder, two_cylinders, \
             three_cylinders, concave, one_moving, two_moving, three_moving"
        );
    }
}
