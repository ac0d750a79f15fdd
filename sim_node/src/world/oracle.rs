//! Full-knowledge shortest paths: the fewest steps to the exit for a robot that knows the room.

use std::f64::consts::{FRAC_PI_4, SQRT_2};

use nalgebra::{Isometry2, Point2, UnitComplex, Vector2};
use pathfinding::directed::astar::astar;
use task::Action;
use task::action::STEP_LENGTH;

use super::World;
use super::exit::{EXIT_DEPTH, EXIT_WIDTH, Exit};
use super::robot::{FOOTPRINT_SIDE, Footprint};

/// Maximum number of poses that the search expands before it gives up. In 100,000 random layouts of
/// each scenario, the longest path has 23 steps.
const MAX_EXPANSIONS: u32 = 2_000_000;

/// Returns the length of the shortest path from the robot's current pose to the exit, in steps; 0
/// after an escape.
///
/// Returns `None` if the scenario has moving cylinders or no path was found.
pub fn shortest_path_length(world: &World) -> Option<u32> {
    let path = shortest_path(world)?;
    u32::try_from(path.len()).ok()
}

/// Returns the actions of a shortest path from the robot's current pose to the exit; empty after an
/// escape.
///
/// Returns `None` if the scenario has moving cylinders or no path was found.
pub fn shortest_path(world: &World) -> Option<Vec<Action>> {
    if world.scenario().has_moving_obstacles() {
        return None;
    }
    Search::new(world).run()
}

/// An exact pose, relative to the start pose.
///
/// All headings differ from the start heading by multiples of 45 degrees, so every position is an
/// integer combination of steps in four directions. Two paths to the same pose therefore give equal
/// values, which sums of rounded lengths would not guarantee.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct LatticePose {
    /// Steps towards 0, 45, 90 and 135 degrees; a step in the opposite direction counts as -1.
    steps: [i16; 4],
    /// Heading in eighths of a full turn, 0..=7.
    heading: u8,
}

impl LatticePose {
    fn after(self, action: Action) -> Self {
        let heading = (self.heading as i8 + action.turn_eighths()).rem_euclid(8) as u8;
        let mut steps = self.steps;
        steps[usize::from(heading % 4)] += if heading < 4 { 1 } else { -1 };
        Self { steps, heading }
    }
}

/// A node of the search graph.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct State {
    pose: LatticePose,
    /// Whether the robot touches the exit at this pose.
    has_escaped: bool,
}

/// A search in one world.
struct Search<'world> {
    world: &'world World,
    /// The possible headings of the robot, indexed by eighths of a full turn.
    rotations: [UnitComplex<f64>; 8],
    /// One step along each of these headings, in metres.
    strides: [Vector2<f64>; 8],
    /// Remaining expansions. Without a limit, the search for an unreachable exit would not end.
    remaining: u32,
}

impl<'world> Search<'world> {
    fn new(world: &'world World) -> Self {
        let rotations = std::array::from_fn(|eighth| {
            world.robot().rotation * UnitComplex::new(eighth as f64 * FRAC_PI_4)
        });
        let stride = Vector2::new(STEP_LENGTH, 0.0);
        let strides = rotations.map(|rotation| rotation * stride);
        Self { world, rotations, strides, remaining: MAX_EXPANSIONS }
    }

    /// Runs A* over poses. Each step costs 1; a blocked move is not an edge.
    fn run(mut self) -> Option<Vec<Action>> {
        let pose = LatticePose { steps: [0; 4], heading: 0 };
        let has_escaped = self.world.exit().touches(&Footprint::at(self.world.robot()));
        let bounds = Search::new(self.world);
        let (path, _) = astar(
            &State { pose, has_escaped },
            |state| self.successors(state.pose),
            |state| bounds.lower_bound(state),
            |state| state.has_escaped,
        )?;
        let actions = path.windows(2).map(|pair| {
            let connects = |action: &Action| pair[0].pose.after(*action) == pair[1].pose;
            Action::ALL.into_iter().find(connects)
        });
        actions.collect()
    }

    fn successors(&mut self, pose: LatticePose) -> Vec<(State, u32)> {
        let Some(remaining) = self.remaining.checked_sub(1) else {
            return Vec::new();
        };
        self.remaining = remaining;
        let step = |action| {
            let pose = pose.after(action);
            let footprint = Footprint::at(&self.isometry(pose));
            let has_escaped = self.world.exit().touches(&footprint);
            let is_free = has_escaped || !self.world.obstacles().touch(&footprint);
            is_free.then_some((State { pose, has_escaped }, 1))
        };
        Action::ALL.into_iter().filter_map(step).collect()
    }

    fn lower_bound(&self, state: &State) -> u32 {
        match state.has_escaped {
            true => 0,
            false => {
                lower_bound(self.world.exit(), &self.isometry(state.pose).translation.vector.into())
            }
        }
    }

    fn isometry(&self, pose: LatticePose) -> Isometry2<f64> {
        let mut position = self.world.robot().translation;
        for (&steps, stride) in pose.steps.iter().zip(&self.strides) {
            position.vector += stride * f64::from(steps);
        }
        Isometry2::from_parts(position, self.rotations[usize::from(pose.heading)])
    }
}

/// Returns a lower bound on the number of steps to the exit, for a robot that does not touch it:
/// the number of steps in a straight line until a corner of the robot could touch the exit.
fn lower_bound(exit: &Exit, centre: &Point2<f64>) -> u32 {
    // Contact is tested in single precision and may occur this much earlier, in metres.
    const TOLERANCE: f64 = 1e-5;
    let centre = exit.pose().inverse_transform_point(centre);
    let gap = Vector2::new(
        (centre.x.abs() - EXIT_DEPTH / 2.0).max(0.0),
        (centre.y.abs() - EXIT_WIDTH / 2.0).max(0.0),
    );
    let distance = gap.norm() - FOOTPRINT_SIDE / SQRT_2 - TOLERANCE;
    ((distance / STEP_LENGTH).ceil() as u32).max(1)
}
