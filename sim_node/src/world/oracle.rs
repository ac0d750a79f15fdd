//! The fewest steps that lead out of the room, for whoever knows its plan.

use std::collections::HashMap;
use std::f64::consts::{FRAC_PI_4, SQRT_2};

use nalgebra::{Isometry2, Point2, UnitComplex, Vector2};
use task::Action;
use task::action::STEP_LENGTH;

use super::World;
use super::exit::{EXIT_DEPTH, EXIT_WIDTH, Exit};
use super::robot::{FOOTPRINT_SIDE, Footprint};

/// Longer paths are not looked for. The longest needed in 100,000 random layouts of each scenario
/// has 23 steps.
const MOST_STEPS: usize = 64;

/// The fewest steps in which the robot can escape from where it is now; 0 once it has escaped.
///
/// `None` where obstacles move, or if no path of at most 64 steps leads out.
pub fn fewest_steps(world: &World) -> Option<u32> {
    let path = shortest_path(world)?;
    Some(u32::try_from(path.len()).expect("a path has at most 64 steps"))
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
    steps: [i8; 4],
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

/// How a place was reached.
struct Visit {
    place: Place,
    steps: usize,
    /// The index of the visit before this one and the action that led here.
    from: Option<(usize, Action)>,
}

/// An A* search over places: each step costs 1, and walls and obstacles have no way through.
struct Search<'world> {
    world: &'world World,
    /// Rotations by eighths of a full turn, and one step in each direction.
    rotations: [UnitComplex<f64>; 8],
    strides: [Vector2<f64>; 8],
    visits: Vec<Visit>,
    /// The fewest steps to a place so far; 0 where the robot cannot be, so that no way is better.
    fewest: HashMap<Place, usize>,
    /// Visits to go on from, by the least length of a path through them.
    frontier: Vec<Vec<usize>>,
}

impl<'world> Search<'world> {
    fn new(world: &'world World) -> Self {
        let rotations = std::array::from_fn(|eighth| {
            world.robot().rotation * UnitComplex::new(eighth as f64 * FRAC_PI_4)
        });
        let stride = Vector2::new(STEP_LENGTH, 0.0);
        Self {
            world,
            rotations,
            strides: rotations.map(|rotation| rotation * stride),
            visits: Vec::new(),
            fewest: HashMap::new(),
            frontier: vec![Vec::new(); MOST_STEPS + 1],
        }
    }

    fn run(mut self) -> Option<Vec<Action>> {
        if self.world.exit().touches(&Footprint::at(self.world.robot())) {
            return Some(Vec::new());
        }
        let start = Place { steps: [0; 4], heading: 0 };
        self.fewest.insert(start, 0);
        self.reach(Visit { place: start, steps: 0, from: None });
        for length in 0..=MOST_STEPS {
            while let Some(index) = self.frontier[length].pop() {
                if let Some(path) = self.go_on(index) {
                    return Some(path);
                }
            }
        }
        None
    }

    /// Takes every action from a visited place; the path, if one of them leads out.
    fn go_on(&mut self, index: usize) -> Option<Vec<Action>> {
        let Visit { place, steps, .. } = self.visits[index];
        if self.fewest[&place] < steps {
            return None; // A shorter way was found since.
        }
        for action in Action::ALL {
            let next = place.after(action);
            if self.fewest.get(&next).is_some_and(|&fewest| fewest <= steps + 1) {
                continue;
            }
            let footprint = Footprint::at(&self.pose(next));
            // No way out is shorter: a path through this place has at least this length, and one
            // through any other place of the frontier is at least as long.
            if self.world.exit().touches(&footprint) {
                return Some(self.path(index, action));
            }
            let blocked = self.world.obstacles().touch(&footprint);
            self.fewest.insert(next, if blocked { 0 } else { steps + 1 });
            if !blocked {
                self.reach(Visit { place: next, steps: steps + 1, from: Some((index, action)) });
            }
        }
        None
    }

    fn reach(&mut self, visit: Visit) {
        let centre = self.pose(visit.place).translation.vector.into();
        let length = visit.steps + least_steps(self.world.exit(), &centre);
        if let Some(visits) = self.frontier.get_mut(length) {
            visits.push(self.visits.len());
            self.visits.push(visit);
        }
    }

    fn pose(&self, place: Place) -> Isometry2<f64> {
        let mut position = self.world.robot().translation;
        for (&steps, stride) in place.steps.iter().zip(&self.strides) {
            position.vector += stride * f64::from(steps);
        }
        Isometry2::from_parts(position, self.rotations[usize::from(place.heading)])
    }

    fn path(&self, index: usize, last: Action) -> Vec<Action> {
        let mut path = vec![last];
        let mut visit = &self.visits[index];
        while let Some((index, action)) = visit.from {
            path.push(action);
            visit = &self.visits[index];
        }
        path.reverse();
        path
    }
}

/// A number of steps that is never more than the exit is away from a robot that does not touch it:
/// those that bring the corner of the robot to the exit on a straight line.
fn least_steps(exit: &Exit, centre: &Point2<f64>) -> usize {
    // Contact is tested in single precision, which may reach this much further.
    const TOLERANCE: f64 = 1e-5;
    let centre = exit.pose().inverse_transform_point(centre);
    let gap = Vector2::new(
        (centre.x.abs() - EXIT_DEPTH / 2.0).max(0.0),
        (centre.y.abs() - EXIT_WIDTH / 2.0).max(0.0),
    );
    let way = gap.norm() - FOOTPRINT_SIDE / SQRT_2 - TOLERANCE;
    ((way / STEP_LENGTH).ceil() as usize).max(1)
}
