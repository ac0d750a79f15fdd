//! The world: a room with an exit, obstacles and a robot that executes actions.
//!
//! A [`World`] is one room and the current episode in it. [`World::reset`] starts an episode with a
//! new layout. [`World::step`] moves the robot and then, in scenarios with moving cylinders, the
//! cylinders. parry2d tests contacts in single precision; poses are in double precision.
//!
//! [`crate::reality`] perturbs how the robot executes actions; by default it does so exactly.
//!
//! Everything random depends only on a seed, through [`task::Random`], which gives the same numbers
//! on every machine.
//!
//! # Examples
//!
//! ```
//! use std::num::NonZeroU64;
//!
//! use sim_node::world::{World, WorldSettings};
//! use task::{Action, Scenario};
//!
//! let mut world = World::new(WorldSettings::default(), Scenario::ThreeCylinders, 1)?;
//! world.reset(NonZeroU64::new(7), None)?;
//! let outcome = world.step(Action::ALL[3])?;
//! assert_eq!((outcome.terminated, world.steps()), (outcome.reward == 0.0, 1));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub(crate) mod concave_wall;
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
pub use oracle::{shortest_path, shortest_path_length};
pub use placement::PlacementError;
pub use robot::FOOTPRINT_SIDE;
pub use room::{ROOM_SIDE, WALL_HEIGHT, Wall};

use crate::reality::{Conditions, Reality};

use obstacles::Obstacles;
use placement::{Placement, Rules};
use robot::Footprint;

/// World settings for all scenarios.
#[derive(Debug, Clone, PartialEq)]
pub struct WorldSettings {
    /// Step limit: an episode is truncated after this many steps. At least 1.
    pub max_steps: u32,
    /// Standard deviation, in radians, of the angle by which a moving cylinder turns at each step;
    /// at least 0. The paper states only that the angle is normally distributed.
    pub heading_deviation: f64,
    /// The fixed parts of the layout.
    pub layout: Layout,
    /// The perturbations.
    pub reality: Reality,
}

impl Default for WorldSettings {
    /// Returns a limit of 10,000 steps, a deviation of 45 degrees, a random layout and no
    /// perturbations.
    fn default() -> Self {
        Self {
            max_steps: 10_000,
            heading_deviation: FRAC_PI_4,
            layout: Layout::default(),
            reality: Reality::default(),
        }
    }
}

/// The outcome of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outcome {
    /// Reward: 0 for the step that reaches the exit, otherwise -0.1.
    pub reward: f32,
    /// Whether the robot reached the exit, which ends the episode.
    pub terminated: bool,
    /// Whether the episode ended at the step limit without an escape.
    pub truncated: bool,
    /// Whether a wall or an obstacle blocked the move. Position and heading are then unchanged,
    /// unless the robot stops short
    /// ([`BlockedMotion`](crate::reality::BlockedMotion::StopShort)).
    pub blocked: bool,
}

/// Where an action takes the robot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Move {
    /// The pose of the robot's centre after the action, in metres and radians.
    pub robot: Isometry2<f64>,
    /// Whether the robot touches the exit there.
    pub terminated: bool,
    /// Whether a wall or an obstacle blocks the move.
    pub blocked: bool,
}

/// The error for a step after the end of the episode.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("the episode ended at step {steps}; reset to start the next one")]
pub struct EpisodeOver {
    /// Number of steps in the episode.
    pub steps: u32,
}

/// A room and the current episode in it.
///
/// All coordinates are in the frame of the room, in metres and radians: the origin is the centre of
/// the floor, x and y are parallel to the walls, angles are counter-clockwise from +x.
#[derive(Debug, Clone)]
pub struct World {
    settings: WorldSettings,
    scenario: Scenario,
    concave_wall: ConcaveWall,
    exit: Exit,
    cylinders: Vec<Cylinder>,
    robot: Isometry2<f64>,
    conditions: Conditions,
    steps: u32,
    is_over: bool,
    /// The fixed cylinders of the layout at the latest reset.
    fixed_cylinders: Option<Vec<Point2<f64>>>,
    /// The world's own random state, which unseeded resets advance.
    own_random: Random,
    /// The random state of an episode that started with a seeded reset.
    seeded_random: Option<Random>,
}

impl World {
    /// Creates a world at the start of its first episode.
    ///
    /// `seed` initializes the world's own random state. The first layout is the same as after
    /// [`World::reset`] with this seed.
    ///
    /// # Errors
    ///
    /// Returns an error if the fixed layout violates a placement rule or leaves no space for the
    /// random parts. A random layout never fails.
    pub fn new(
        settings: WorldSettings,
        scenario: Scenario,
        seed: u64,
    ) -> Result<Self, PlacementError> {
        let concave_wall = ConcaveWall::new();
        let mut own_random = Random::from_key([seed, 0, 0, 0]);
        let rules = Rules::new(scenario, &concave_wall);
        let placement = rules.place(&settings.layout, None, &mut own_random)?;
        let key = conditions_key(NonZeroU64::new(seed), &settings.reality, &mut own_random);
        Ok(Self {
            conditions: Conditions::draw(&settings.reality, key),
            fixed_cylinders: settings.layout.cylinders.clone(),
            settings,
            scenario,
            concave_wall,
            exit: placement.exit,
            cylinders: placement.cylinders,
            robot: placement.robot,
            steps: 0,
            is_over: false,
            own_random,
            seeded_random: None,
        })
    }

    /// Sets the fixed layout for subsequent resets; the current episode does not change.
    pub fn set_layout(&mut self, layout: Layout) {
        self.settings.layout = layout;
    }

    /// Sets the perturbations for subsequent resets; the current episode does not change.
    pub fn set_reality(&mut self, reality: Reality) {
        self.settings.reality = reality;
    }

    /// Returns the perturbations, which apply from the next reset on if they were set after the
    /// latest one.
    pub fn reality(&self) -> &Reality {
        &self.settings.reality
    }

    /// Starts a new episode, in the current scenario if `scenario` is `None`.
    ///
    /// With a seed, everything random in the episode depends only on the seed, and the world's own
    /// random state does not change. Without a seed, the reset uses and advances the world's own
    /// random state. Moving cylinders then keep their poses, as in the paper, unless the scenario
    /// changes, the layout has new fixed cylinders, or a cylinder is in the way of a fixed robot.
    ///
    /// # Errors
    ///
    /// Returns an error if the fixed layout violates a placement rule of the scenario or leaves no
    /// space for the random parts. The world is then unchanged.
    pub fn reset(
        &mut self,
        seed: Option<NonZeroU64>,
        scenario: Option<Scenario>,
    ) -> Result<(), PlacementError> {
        let scenario = scenario.unwrap_or(self.scenario);
        let fixed = &self.settings.layout.cylinders;
        let keeps_cylinders = seed.is_none()
            && scenario.has_moving_obstacles()
            && scenario == self.scenario
            && (fixed.is_none() || *fixed == self.fixed_cylinders);
        let kept_cylinders = keeps_cylinders.then(|| self.cylinders.clone());
        let mut random = seed.map_or_else(
            || self.own_random.clone(),
            |seed| Random::from_key([seed.get(), 0, 0, 0]),
        );
        let rules = Rules::new(scenario, &self.concave_wall);
        let placement = rules.place(&self.settings.layout, kept_cylinders, &mut random)?;
        let key = conditions_key(seed, &self.settings.reality, &mut random);

        self.conditions = Conditions::draw(&self.settings.reality, key);
        Placement { exit: self.exit, cylinders: self.cylinders, robot: self.robot } = placement;
        self.scenario = scenario;
        self.steps = 0;
        self.is_over = false;
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

    /// Executes an action with the robot, then moves each moving cylinder by one step.
    ///
    /// Contact is tested only at the new pose, as in the paper. The exit is tested first, because
    /// it overlaps the wall. After an escape, the robot is at the new pose; after a blocked move,
    /// it is at the old pose, or, if it stops short, where it first touches something. If it
    /// touches the exit there, it has escaped. The cylinders move after every step, including
    /// blocked steps and the last one.
    ///
    /// # Errors
    ///
    /// Returns an error if the episode is over.
    pub fn step(&mut self, action: Action) -> Result<Outcome, EpisodeOver> {
        if self.is_over {
            return Err(EpisodeOver { steps: self.steps });
        }
        let Move { robot, terminated, blocked } = self.attempt(action);
        self.robot = robot;
        if self.scenario.has_moving_obstacles() {
            motion::move_cylinders(
                &mut self.cylinders,
                &Footprint::at(&self.robot),
                CYLINDER_STEP_LENGTH * self.conditions.obstacles.speed,
                self.settings.heading_deviation,
                self.seeded_random.as_mut().unwrap_or(&mut self.own_random),
            );
        }
        self.steps += 1;
        let truncated = !terminated && self.steps >= self.settings.max_steps;
        self.is_over = terminated || truncated;
        let reward = if terminated { EXIT_REWARD } else { STEP_REWARD };
        Ok(Outcome { reward, terminated, truncated, blocked })
    }

    /// Returns where an action would take the robot, without executing it.
    pub fn attempt(&self, action: Action) -> Move {
        let (turn, distance) = self.conditions.motion(action, self.steps + 1);
        let next = robot::moved(&self.robot, turn, distance);
        let footprint = Footprint::at(&next);
        let terminated = self.exit.touches(&footprint);
        if terminated || !self.obstacles().touch(&footprint) {
            return Move { robot: next, terminated, blocked: false };
        }
        if !self.conditions.motion.stops_short {
            return Move { robot: self.robot, terminated: false, blocked: true };
        }
        let robot = robot::stopped_short(&self.robot, turn, distance, |pose| {
            self.obstacles().touch(&Footprint::at(pose))
        });
        let terminated = self.exit.touches(&Footprint::at(&robot));
        Move { robot, terminated, blocked: !terminated }
    }

    /// Moves the robot to a pose of its centre, in metres and radians, without a step. For planning:
    /// the pose is not checked.
    pub fn place_robot(&mut self, pose: Isometry2<f64>) {
        self.robot = pose;
    }

    /// Moves the exit and the centres of all cylinders, in metres. For planning with an incomplete
    /// knowledge of the room: the placement rules are not checked.
    pub fn place_objects(&mut self, exit: Exit, centres: &[Point2<f64>]) {
        self.exit = exit;
        self.cylinders = centres.iter().copied().map(Cylinder::new).collect();
    }

    /// Returns the pose of the robot's centre, in metres and radians.
    pub fn robot(&self) -> &Isometry2<f64> {
        &self.robot
    }

    /// Returns the conditions of the current episode.
    pub fn conditions(&self) -> &Conditions {
        &self.conditions
    }

    /// Returns the exit.
    pub fn exit(&self) -> &Exit {
        &self.exit
    }

    /// Returns the cylinders, of which there are 0 to 3.
    pub fn cylinders(&self) -> &[Cylinder] {
        &self.cylinders
    }

    /// Returns the concave wall, or `None` in scenarios without it.
    pub fn concave_wall(&self) -> Option<&ConcaveWall> {
        self.scenario.has_concave_wall().then_some(&self.concave_wall)
    }

    /// Returns the scenario of the current episode.
    pub fn scenario(&self) -> Scenario {
        self.scenario
    }

    /// Returns the number of steps executed in the current episode, including blocked steps.
    pub fn steps(&self) -> u32 {
        self.steps
    }

    /// Returns the number of steps after which an episode is truncated.
    pub fn max_steps(&self) -> u32 {
        self.settings.max_steps
    }

    /// Returns whether the current episode is terminated or truncated.
    pub fn is_over(&self) -> bool {
        self.is_over
    }

    /// Returns whether the robot touches a wall or an obstacle, which it never does in an episode.
    #[cfg(test)]
    pub(crate) fn robot_touches_obstacle(&self) -> bool {
        self.obstacles().touch(&Footprint::at(&self.robot))
    }

    fn obstacles(&self) -> Obstacles<'_> {
        Obstacles { cylinders: &self.cylinders, concave_wall: self.concave_wall() }
    }
}

/// Returns the key of an episode's conditions: a function of the seed, or else a word of the
/// world's own random state, which does not advance without perturbations.
fn conditions_key(seed: Option<NonZeroU64>, reality: &Reality, random: &mut Random) -> u64 {
    match seed {
        Some(seed) => seed.get(),
        None if *reality == Reality::default() => 0,
        None => random.word(),
    }
}
