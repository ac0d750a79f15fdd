//! The scenarios of the paper: the obstacles in the room.

use std::fmt;
use std::str::FromStr;

/// A scenario: the set of obstacles in the room.
///
/// # Examples
///
/// ```
/// use task::Scenario;
///
/// let scenario: Scenario = "two_moving".parse()?;
/// assert_eq!((scenario.cylinders(), scenario.has_moving_obstacles()), (2, true));
/// assert_eq!(scenario.to_string(), "two_moving");
/// # Ok::<(), task::scenario::UnknownScenario>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Scenario {
    /// No obstacles.
    Empty,
    /// One static cylinder, placed at random on every reset.
    OneCylinder,
    /// Two static cylinders, placed at random on every reset.
    TwoCylinders,
    /// Three static cylinders, placed at random on every reset.
    ThreeCylinders,
    /// A concave semicircular wall, fixed in the middle of the room.
    Concave,
    /// One moving cylinder.
    OneMoving,
    /// Two moving cylinders.
    TwoMoving,
    /// Three moving cylinders.
    ThreeMoving,
}

impl Scenario {
    /// All scenarios.
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

    /// Returns the name used in parameters, messages and files.
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

    /// Returns the number of cylinders, static or moving.
    pub fn cylinders(self) -> usize {
        match self {
            Self::Empty | Self::Concave => 0,
            Self::OneCylinder | Self::OneMoving => 1,
            Self::TwoCylinders | Self::TwoMoving => 2,
            Self::ThreeCylinders | Self::ThreeMoving => 3,
        }
    }

    /// Returns whether the cylinders move.
    pub fn has_moving_obstacles(self) -> bool {
        matches!(self, Self::OneMoving | Self::TwoMoving | Self::ThreeMoving)
    }

    /// Returns whether the room contains the concave wall.
    pub fn has_concave_wall(self) -> bool {
        self == Self::Concave
    }
}

impl fmt::Display for Scenario {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(self.name())
    }
}

/// The error for an unknown scenario name. Holds the first 100 characters of the name.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "scenario: unknown value '{0}' (expected: {names})",
    names = Scenario::ALL.map(Scenario::name).join(", ")
)]
pub struct UnknownScenario(pub String);

impl FromStr for Scenario {
    type Err = UnknownScenario;

    /// Parses a scenario name, e.g. `three_cylinders`.
    ///
    /// # Errors
    ///
    /// Returns [`UnknownScenario`] if no scenario has this name.
    fn from_str(name: &str) -> Result<Self, UnknownScenario> {
        Self::ALL
            .into_iter()
            .find(|scenario| scenario.name() == name)
            // A client can send a name of any length, and the response quotes it.
            .ok_or_else(|| UnknownScenario(name.chars().take(100).collect()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_round_trip() {
        for scenario in Scenario::ALL {
            assert_eq!(scenario.to_string().parse(), Ok(scenario));
        }
    }

    #[test]
    fn rejects_an_unknown_scenario() {
        let error = "maze".parse::<Scenario>().unwrap_err();
        assert_eq!(
            error.to_string(),
            "scenario: unknown value 'maze' (expected: empty, one_cylinder, two_cylinders, \
             three_cylinders, concave, one_moving, two_moving, three_moving)"
        );
    }
}
