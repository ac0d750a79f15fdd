//! A search for the action with the fewest expected steps, given the rooms that are possible.

use std::collections::{BTreeMap, HashMap};

use nalgebra::Isometry2;
use sim_node::{
    camera::{Camera, Frame},
    world::{World, shortest_path_length},
};
use task::Action;

/// The cost of a room without a path, in steps.
const NO_PATH: f64 = 100.0;

/// A pose in micrometres and microradians, to compare poses.
type Key = [i64; 3];

/// A possible room, with the lengths of its shortest paths that have been computed.
struct Room {
    world: World,
    lengths: HashMap<Key, f64>,
}

impl Room {
    /// Returns the number of steps to the exit for a robot that knows the room.
    fn length(&mut self, pose: &Isometry2<f64>) -> f64 {
        let Room { world, lengths } = self;
        *lengths.entry(key(pose)).or_insert_with(|| {
            world.place_robot(*pose);
            shortest_path_length(world).map_or(NO_PATH, f64::from)
        })
    }
}

/// The possible rooms and the camera.
pub struct Planner<'a> {
    camera: &'a Camera,
    rooms: Vec<Room>,
}

/// Rooms in which the robot is at the same pose and sees the same image.
struct Group {
    pose: Isometry2<f64>,
    rooms: Vec<usize>,
}

/// What an action leads to: the groups that the robot can then tell apart. Rooms in which it has
/// reached the exit are in none.
struct Outcome {
    groups: Vec<Group>,
    /// A lower bound on the steps of all rooms together: from the next step on, the robot knows the
    /// room.
    bound: f64,
}

impl<'a> Planner<'a> {
    /// Creates a planner for these rooms, which must not be empty.
    pub fn new(camera: &'a Camera, rooms: &[World]) -> Planner<'a> {
        let room = |world: &World| Room { world: world.clone(), lengths: HashMap::new() };
        Planner { camera, rooms: rooms.iter().map(room).collect() }
    }

    /// Returns the best action at a pose and the expected number of steps, if the robot uses what
    /// it sees in the next `depth` steps and is then told the room. The number is a lower bound.
    pub fn best(&mut self, pose: &Isometry2<f64>, depth: u32) -> (Action, f64) {
        let all = Group { pose: *pose, rooms: (0..self.rooms.len()).collect() };
        let (action, steps) = self.best_in(&all, depth.max(1));
        (action, steps / self.rooms.len() as f64)
    }

    /// Returns the mean length of the shortest paths from a pose: the expected number of steps for a
    /// robot that is told the room now.
    pub fn known(&mut self, pose: &Isometry2<f64>) -> f64 {
        let lengths: f64 = self.rooms.iter_mut().map(|room| room.length(pose)).sum();
        lengths / self.rooms.len() as f64
    }

    /// Returns the best action and the number of steps of all rooms together.
    fn best_in(&mut self, group: &Group, depth: u32) -> (Action, f64) {
        let mut outcomes: Vec<(Action, Outcome)> =
            Action::ALL.into_iter().map(|action| (action, self.outcome(group, action))).collect();
        outcomes.sort_by(|(_, first), (_, second)| first.bound.total_cmp(&second.bound));
        let mut best = (outcomes[0].0, f64::INFINITY);
        for (action, outcome) in outcomes {
            if outcome.bound >= best.1 {
                break;
            }
            let later: f64 = outcome.groups.iter().map(|group| self.steps(group, depth - 1)).sum();
            let steps = group.rooms.len() as f64 + later;
            if steps < best.1 {
                best = (action, steps);
            }
        }
        best
    }

    fn steps(&mut self, group: &Group, depth: u32) -> f64 {
        match (depth, &group.rooms[..]) {
            (0, _) | (_, [_]) => {
                group.rooms.iter().map(|room| self.rooms[*room].length(&group.pose)).sum()
            }
            _ => self.best_in(group, depth).1,
        }
    }

    fn outcome(&mut self, group: &Group, action: Action) -> Outcome {
        let mut groups: BTreeMap<(Key, [u8; Frame::LENGTH]), Group> = BTreeMap::new();
        let mut bound = group.rooms.len() as f64;
        for &index in &group.rooms {
            let room = &mut self.rooms[index];
            room.world.place_robot(group.pose);
            let next = room.world.attempt(action);
            if next.terminated {
                continue;
            }
            bound += room.length(&next.robot);
            room.world.place_robot(next.robot);
            let image = *self.camera.render(&room.world).bytes();
            let group = groups.entry((key(&next.robot), image));
            group.or_insert(Group { pose: next.robot, rooms: Vec::new() }).rooms.push(index);
        }
        Outcome { groups: groups.into_values().collect(), bound }
    }
}

fn key(pose: &Isometry2<f64>) -> Key {
    let micro = |value: f64| (value * 1e6).round() as i64;
    [micro(pose.translation.x), micro(pose.translation.y), micro(pose.rotation.angle())]
}
