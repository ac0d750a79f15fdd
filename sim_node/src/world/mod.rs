//! The world: a room, an exit, obstacles, and a robot that takes one action after another.
//!
//! [`World`] is one room and the episode that runs in it. [`World::reset`] lays the room out anew,
//! [`World::step`] moves the robot, and then, in the scenarios where they move, the obstacles.
//! Contacts are parry2d's; poses are in double precision.
//!
//! Everything random follows from a seed, through a stream of numbers that this project specifies
//! itself.

mod concave_wall;
pub(crate) mod contact;
mod cylinder;
mod exit;
mod layout;
mod motion;
mod obstacles;
mod oracle;
mod placement;
mod robot;
mod room;
mod spacing;
#[cfg(test)]
mod tests;

use std::f64::consts::FRAC_PI_4;
use std::num::NonZeroU64;

use nalgebra::{Isometry2, Point2};
use task::{Action, EXIT_REWARD, Random, STEP_REWARD, Scenario};

pub use concave_wall::{CONCAVE_WALL_HEIGHT, ConcaveWall};
pub use cylinder::{CYLINDER_HEIGHT, CYLINDER_RADIUS, Cylinder};
pub use exit::{EXIT_DEPTH, EXIT_HEIGHT, EXIT_REACH, EXIT_WIDTH, Exit, ExitOffWall};
pub use layout::{Layout, LayoutError};
pub use motion::CYLINDER_STEP_LENGTH;
pub use oracle::{fewest_steps, shortest_path};
pub use placement::PlacementError;
pub use robot::FOOTPRINT_SIDE;
pub use room::{ROOM_SIDE, WALL_HEIGHT, Wall};

use obstacles::Obstacles;
use placement::{Placement, Rules};
use robot::Footprint;

/// What a world is like, whatever the scenario.
#[derive(Debug, Clone, PartialEq)]
pub struct WorldSettings {
    /// An episode is truncated after this many steps; at least 1.
    pub max_steps: u32,
    /// The standard deviation of the angle by which a moving cylinder turns at each step, in
    /// radians. The paper only says that it is normally distributed.
    pub heading_deviation: f64,
    /// What is held fixed.
    pub layout: Layout,
}

impl Default for WorldSettings {
    /// 10,000 steps, 45 degrees, and nothing fixed.
    fn default() -> Self {
        Self { max_steps: 10_000, heading_deviation: FRAC_PI_4, layout: Layout::default() }
    }
}

/// What a step led to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outcome {
    /// 0 for the step that leads out, -0.1 for every other.
    pub reward: f32,
    /// The robot has escaped.
    pub terminated: bool,
    /// The episode has had all its steps, and the robot has not escaped.
    pub truncated: bool,
    /// A wall or an obstacle was in the way: the robot has neither moved nor turned.
    pub blocked: bool,
}

/// A step was asked for after the end of the episode.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("the episode ended with step {steps}: reset before the next step")]
pub struct EpisodeOver {
    /// How many steps the episode had.
    pub steps: u32,
}

/// A room and the episode that runs in it.
#[derive(Debug, Clone)]
pub struct World {
    settings: WorldSettings,
    scenario: Scenario,
    concave_wall: ConcaveWall,
    exit: Exit,
    cylinders: Vec<Cylinder>,
    robot: Isometry2<f64>,
    steps: u32,
    over: bool,
    /// Where the latest reset was to put the cylinders.
    fixed_cylinders: Option<Vec<Point2<f64>>>,
    /// The world's own randomness, which goes on from one unseeded reset to the next.
    own_random: Random,
    /// The randomness of an episode that began with a seeded reset.
    seeded_random: Option<Random>,
}

impl World {
    /// A world at the beginning of its first episode.
    ///
    /// `seed` begins the world's own randomness; the first layout is the one that
    /// [`World::reset`] with the same seed would give.
    ///
    /// # Errors
    ///
    /// If what the settings hold fixed breaks a rule of placement or leaves no room for the rest.
    pub fn new(
        settings: WorldSettings,
        scenario: Scenario,
        seed: u64,
    ) -> Result<Self, PlacementError> {
        let concave_wall = ConcaveWall::new();
        let mut own_random = Random::from_key([seed, 0, 0, 0]);
        let rules = Rules::new(scenario, &concave_wall);
        let placement = rules.place(&settings.layout, None, &mut own_random)?;
        Ok(Self {
            fixed_cylinders: settings.layout.cylinders.clone(),
            settings,
            scenario,
            concave_wall,
            exit: placement.exit,
            cylinders: placement.cylinders,
            robot: placement.robot,
            steps: 0,
            over: false,
            own_random,
            seeded_random: None,
        })
    }

    /// Holds something else fixed from the next reset on; this episode stays as it is.
    pub fn set_layout(&mut self, layout: Layout) {
        self.settings.layout = layout;
    }

    /// Begins a new episode, in another scenario if one is given.
    ///
    /// With a seed, everything random in the episode follows from it, and the world's own
    /// randomness stays as it was. Without one, the world's own randomness goes on; cylinders that
    /// move then stay where they are, as in the paper, unless the scenario changes, the layout has
    /// new places for them, or one of them is in the way of a fixed robot.
    ///
    /// # Errors
    ///
    /// If what is held fixed breaks a rule of placement in this scenario or leaves no room for the
    /// rest. The world is then as it was.
    pub fn reset(
        &mut self,
        seed: Option<NonZeroU64>,
        scenario: Option<Scenario>,
    ) -> Result<(), PlacementError> {
        let scenario = scenario.unwrap_or(self.scenario);
        let fixed = &self.settings.layout.cylinders;
        let keeps_cylinders = seed.is_none()
            && scenario.moving()
            && scenario == self.scenario
            && (fixed.is_none() || *fixed == self.fixed_cylinders);
        let kept = keeps_cylinders.then(|| self.cylinders.clone());
        let mut random = seed.map_or_else(
            || self.own_random.clone(),
            |seed| Random::from_key([seed.get(), 0, 0, 0]),
        );
        let rules = Rules::new(scenario, &self.concave_wall);
        let placement = rules.place(&self.settings.layout, kept, &mut random)?;

        Placement { exit: self.exit, cylinders: self.cylinders, robot: self.robot } = placement;
        self.scenario = scenario;
        self.steps = 0;
        self.over = false;
        self.fixed_cylinders.clone_from(&self.settings.layout.cylinders);
        self.seeded_random = match seed {
            Some(_) => Some(random),
            None => {
                self.own_random = random;
                None
            }
        };
        Ok(())
    }

    /// Lets the robot act once, and then the moving cylinders.
    ///
    /// Contact is tested at the new pose only, as in the paper, and the exit first, because it
    /// stands in the wall. A robot that escapes stands at the new pose, one that is blocked at the
    /// old one. The cylinders move after every step, the last one included.
    ///
    /// # Errors
    ///
    /// If the episode is over.
    pub fn step(&mut self, action: Action) -> Result<Outcome, EpisodeOver> {
        if self.over {
            return Err(EpisodeOver { steps: self.steps });
        }
        let next = robot::moved(&self.robot, action);
        let footprint = Footprint::at(&next);
        let terminated = self.exit.touches(&footprint);
        let blocked = !terminated && self.obstacles().touch(&footprint);
        if !blocked {
            self.robot = next;
        }
        if self.scenario.moving() {
            motion::wander(
                &mut self.cylinders,
                &Footprint::at(&self.robot),
                self.settings.heading_deviation,
                self.seeded_random.as_mut().unwrap_or(&mut self.own_random),
            );
        }
        self.steps += 1;
        let truncated = !terminated && self.steps >= self.settings.max_steps;
        self.over = terminated || truncated;
        let reward = if terminated { EXIT_REWARD } else { STEP_REWARD };
        Ok(Outcome { reward, terminated, truncated, blocked })
    }

    /// The pose of the robot's centre.
    pub fn robot(&self) -> &Isometry2<f64> {
        &self.robot
    }

    /// The exit.
    pub fn exit(&self) -> &Exit {
        &self.exit
    }

    /// The cylinders, none to three.
    pub fn cylinders(&self) -> &[Cylinder] {
        &self.cylinders
    }

    /// The concave wall, in the scenario that has it.
    pub fn concave_wall(&self) -> Option<&ConcaveWall> {
        self.scenario.concave().then_some(&self.concave_wall)
    }

    /// The scenario.
    pub fn scenario(&self) -> Scenario {
        self.scenario
    }

    /// How many steps the episode has had.
    pub fn steps(&self) -> u32 {
        self.steps
    }

    /// After how many steps an episode is truncated.
    pub fn max_steps(&self) -> u32 {
        self.settings.max_steps
    }

    /// Whether the robot has escaped or the episode was truncated.
    pub fn is_over(&self) -> bool {
        self.over
    }

    fn obstacles(&self) -> Obstacles<'_> {
        Obstacles { cylinders: &self.cylinders, concave_wall: self.concave_wall() }
    }
}
