//! The fewest steps that lead out of the room, for whoever knows its plan.

use std::f64::consts::{FRAC_PI_4, SQRT_2};

use nalgebra::{Isometry2, Point2, UnitComplex, Vector2};
use pathfinding::directed::astar::astar;
use task::Action;
use task::action::STEP_LENGTH;

use super::World;
use super::exit::{EXIT_DEPTH, EXIT_WIDTH, Exit};
use super::robot::{FOOTPRINT_SIDE, Footprint};

/// The maximum number of places that are expanded; beyond it there is no path. In 100,000 random layouts
/// of each scenario the longest path has 23 steps.
const MOST_PLACES: u32 = 2_000_000;

/// The fewest steps in which the robot can escape from where it is now; 0 once it has escaped.
///
/// `None` where obstacles move, or if no way out is found.
pub fn fewest_steps(world: &World) -> Option<u32> {
    let path = shortest_path(world)?;
    u32::try_from(path.len()).ok()
}

/// Actions that lead out in the fewest steps, under the same conditions as [`fewest_steps`].
pub fn shortest_path(world: &World) -> Option<Vec<Action>> {
    if world.scenario().moving() {
        return None;
    }
    Search::new(world).run()
}

/// A pose that actions can lead to, exactly, relative to the first.
///
/// All headings are multiples of 45 degrees from the first one, so every position is an integer
/// number of steps along each of four directions, and two ways to one pose compare equal, which
/// sums of rounded lengths would not.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct Place {
    /// Steps towards 0, 45, 90 and 135 degrees; a step the other way counts -1.
    steps: [i16; 4],
    /// In eighths of a full turn, 0..=7.
    heading: u8,
}

impl Place {
    fn after(self, action: Action) -> Self {
        let heading = (self.heading as i8 + action.eighths()).rem_euclid(8) as u8;
        let mut steps = self.steps;
        steps[usize::from(heading % 4)] += if heading < 4 { 1 } else { -1 };
        Self { steps, heading }
    }
}

/// Where the search is: at a place in the room, or out of it after the step that leads there.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct State {
    place: Place,
    is_out: bool,
}

/// The room, as the search asks it.
struct Search<'world> {
    world: &'world World,
    /// Rotations by eighths of a full turn, and one step in each direction.
    rotations: [UnitComplex<f64>; 8],
    strides: [Vector2<f64>; 8],
    /// How many more places may be gone on from: there is no end of them.
    left: u32,
}

impl<'world> Search<'world> {
    fn new(world: &'world World) -> Self {
        let rotations = std::array::from_fn(|eighth| {
            world.robot().rotation * UnitComplex::new(eighth as f64 * FRAC_PI_4)
        });
        let stride = Vector2::new(STEP_LENGTH, 0.0);
        let strides = rotations.map(|rotation| rotation * stride);
        Self { world, rotations, strides, left: MOST_PLACES }
    }

    /// A* over places: each step costs 1, and walls and obstacles have no way through.
    fn run(mut self) -> Option<Vec<Action>> {
        let start = Place { steps: [0; 4], heading: 0 };
        let is_out = self.world.exit().touches(&Footprint::at(self.world.robot()));
        let bounds = Search::new(self.world);
        let (path, _) = astar(
            &State { place: start, is_out },
            |state| self.successors(state.place),
            |state| bounds.least_steps(state),
            |state| state.is_out,
        )?;
        let turns = path.windows(2).map(|pair| {
            let is_between = |action: &Action| pair[0].place.after(*action) == pair[1].place;
            Action::ALL.into_iter().find(is_between)
        });
        turns.collect()
    }

    fn successors(&mut self, place: Place) -> Vec<(State, u32)> {
        let Some(left) = self.left.checked_sub(1) else {
            return Vec::new();
        };
        self.left = left;
        let step = |action| {
            let place = place.after(action);
            let footprint = Footprint::at(&self.pose(place));
            let is_out = self.world.exit().touches(&footprint);
            let is_free = is_out || !self.world.obstacles().touch(&footprint);
            is_free.then_some((State { place, is_out }, 1))
        };
        Action::ALL.into_iter().filter_map(step).collect()
    }

    fn least_steps(&self, state: &State) -> u32 {
        match state.is_out {
            true => 0,
            false => {
                least_steps(self.world.exit(), &self.pose(state.place).translation.vector.into())
            }
        }
    }

    fn pose(&self, place: Place) -> Isometry2<f64> {
        let mut position = self.world.robot().translation;
        for (&steps, stride) in place.steps.iter().zip(&self.strides) {
            position.vector += stride * f64::from(steps);
        }
        Isometry2::from_parts(position, self.rotations[usize::from(place.heading)])
    }
}

/// A number of steps that is never more than the exit is away from a robot that does not touch it:
/// those that bring the corner of the robot to the exit on a straight line.
fn least_steps(exit: &Exit, centre: &Point2<f64>) -> u32 {
    // Contact is tested in single precision, which may reach this much further.
    const TOLERANCE: f64 = 1e-5;
    let centre = exit.pose().inverse_transform_point(centre);
    let gap = Vector2::new(
        (centre.x.abs() - EXIT_DEPTH / 2.0).max(0.0),
        (centre.y.abs() - EXIT_WIDTH / 2.0).max(0.0),
    );
    let way = gap.norm() - FOOTPRINT_SIDE / SQRT_2 - TOLERANCE;
    ((way / STEP_LENGTH).ceil() as u32).max(1)
}
