//! Escapes for the pictures: the policy's way out of rooms that are held fixed, and out of some of
//! the test's, with where everything really was.

use std::{num::NonZeroU64, time::Duration};

use learning::run::RunDirectory;
use log::warn;
use report::{
    EscapeFigures,
    escape::{Escape, Moment},
};
use ros_runtime::parameters::{ParameterClient, ParameterValue};
use task::{
    Environment, Image, Scenario,
    seeds::{Purpose, episode_scenario, episode_seed},
};

use super::{common::Common, ground_truth::GroundTruth, policy_test::PolicyTest};

/// Rooms of the test that are shown, the first ones.
const ROOMS: u32 = 6;
/// No picture shows more steps than these.
const MOST_STEPS: u32 = 200;
/// How often an episode begins anew until somebody says where things are: at first the readers may
/// not be known yet.
const ATTEMPTS: usize = 5;
/// How long the simulator's parameter services may take.
const DEADLINE: Duration = Duration::from_secs(5);

/// A room that is held fixed, as the simulator's parameters `fixed_*` say it.
struct FixedRoom {
    exit: [f64; 2],
    cylinders: &'static [f64],
    /// Where the robot starts, one after the other: x, y and heading.
    starts: [[f64; 3]; 3],
}

impl FixedRoom {
    fn of(scenario: Scenario) -> FixedRoom {
        let around = [[-0.8, -0.8, 0.0], [0.9, -0.7, 2.4], [-1.0, 0.1, -1.6]];
        let room = FixedRoom { exit: [1.0, 0.5], cylinders: &[], starts: around };
        match scenario {
            Scenario::Empty => room,
            // Figure 7: the exit is behind the wall, and the robot within it.
            Scenario::Concave => FixedRoom {
                exit: [1.0, 0.0],
                starts: [[0.0, -0.05, -1.0], [-0.3, -0.2, 2.0], [0.25, -0.2, 0.5]],
                ..room
            },
            Scenario::OneCylinder | Scenario::OneMoving => {
                FixedRoom { cylinders: &[0.1, 0.1], ..room }
            }
            Scenario::TwoCylinders | Scenario::TwoMoving => {
                FixedRoom { cylinders: &[-0.35, 0.25, 0.4, -0.1], ..room }
            }
            Scenario::ThreeCylinders | Scenario::ThreeMoving => {
                FixedRoom { cylinders: &[-0.45, 0.3, 0.45, 0.35, 0.0, -0.45], ..room }
            }
        }
    }
}

/// Draws the policy's escapes into the directory `figures`; `None` where they cannot be seen, or if
/// the node shuts down. The simulator stands in a namespace relative to the node's own.
pub(super) fn draw(
    test: &mut PolicyTest,
    namespace: &str,
    common: &Common,
    directory: &RunDirectory,
) -> anyhow::Result<Option<EscapeFigures>> {
    if !common.figures {
        return Ok(None);
    }
    let truth = GroundTruth::new(test.room.node(), namespace)?;
    let figures = match figures(test, &truth, &common.simulator_parameters) {
        Ok(Some(figures)) => figures,
        Ok(None) => return Ok(None),
        // What is done is done; only pictures are missing.
        Err(error) => {
            warn!("there are no figures of escapes: {error:#}");
            return Ok(None);
        }
    };
    let directory = RunDirectory::open(&directory.file("figures"))?;
    figures.files().try_for_each(|(name, bytes)| directory.write(&name, bytes))?;
    Ok(Some(figures))
}

/// The figures of a policy in a scenario; `None`, with a warning, where nobody publishes the ground
/// truth.
fn figures<'node>(
    test: &mut PolicyTest<'_, 'node>,
    truth: &GroundTruth<'node>,
    parameters: &ParameterClient,
) -> anyhow::Result<Option<EscapeFigures>> {
    let plan = test.plan.clone();
    let mut recorder = Recorder { test, truth };
    let mut rooms = Vec::new();
    for episode in 0..plan.episodes.min(ROOMS) {
        let seed = episode_seed(Purpose::Test, plan.seed, episode);
        let scenario = episode_scenario(&plan.scenario, Purpose::Test, plan.seed, episode);
        let Some(escape) = recorder.record(seed, scenario)? else {
            warn!("nobody publishes odom and scene: there are no figures of escapes");
            return Ok(None);
        };
        rooms.push(escape);
    }
    // None where each episode has a scenario of its own.
    let scenario = plan.scenario.parse::<Scenario>().ok();
    let fixed = match scenario {
        None => Vec::new(),
        Some(scenario) => recorder.fixed(scenario, parameters)?,
    };
    let moves = scenario.is_some_and(Scenario::moving);
    Ok(Some(EscapeFigures::draw(&rooms, &fixed, moves)))
}

struct Recorder<'a, 'b, 'node> {
    test: &'a mut PolicyTest<'b, 'node>,
    truth: &'a GroundTruth<'node>,
}

impl Recorder<'_, '_, '_> {
    /// Three escapes from one room; none, with a warning, where the room cannot be held fixed.
    fn fixed(
        &mut self,
        scenario: Scenario,
        simulator: &ParameterClient,
    ) -> anyhow::Result<Vec<Escape>> {
        let node = self.test.room.node();
        let before = match node.block_on(simulator.values(DEADLINE)) {
            Ok(values) => values,
            Err(error) => {
                warn!("the room cannot be held fixed for the figures: {error}");
                return Ok(Vec::new());
            }
        };
        let set = |name: &str, value: ParameterValue| {
            let set = node.block_on(simulator.set(name, value, DEADLINE));
            let refused = set.map_or_else(|error| Some(error.to_string()), Result::err);
            if let Some(reason) = &refused {
                warn!("the room cannot be held fixed for the figures: {reason}");
            }
            refused.is_none()
        };
        let escapes = self.record_starts(scenario, set);
        // Whatever happened: a room that stays fixed would be another one for who comes next.
        for name in ["fixed_exit", "fixed_cylinders", "fixed_robot"] {
            set(name, before.get(name).cloned().unwrap_or(ParameterValue::DoubleArray(Vec::new())));
        }
        escapes
    }

    /// The escapes from the starts of a [`FixedRoom`], as far as `set` can set a parameter of the
    /// simulator.
    fn record_starts(
        &mut self,
        scenario: Scenario,
        set: impl Fn(&str, ParameterValue) -> bool,
    ) -> anyhow::Result<Vec<Escape>> {
        let FixedRoom { exit, cylinders, starts } = FixedRoom::of(scenario);
        let set = |name, numbers: &[f64]| set(name, ParameterValue::DoubleArray(numbers.to_vec()));
        let mut escapes = Vec::new();
        if !(set("fixed_exit", &exit) && set("fixed_cylinders", cylinders)) {
            return Ok(escapes);
        }
        for (start, episode) in starts.iter().zip(0..) {
            if !set("fixed_robot", start) {
                break;
            }
            let seed = episode_seed(Purpose::Test, self.test.plan.seed, episode);
            escapes.extend(self.record(seed, scenario.name())?);
        }
        Ok(escapes)
    }

    /// One episode; `None` if nobody says where things are.
    fn record(&mut self, seed: NonZeroU64, scenario: &str) -> anyhow::Result<Option<Escape>> {
        let mut begun: Option<(Image, _)> = None;
        for _ in 0..ATTEMPTS {
            let image = self.test.room.reset(seed, scenario)?;
            if let Some(seen) = self.truth.at(self.test.room.stamp()) {
                begun = Some((image, seen));
                break;
            }
        }
        let Some((mut image, (mut pose, mut scene))) = begun else {
            return Ok(None);
        };
        self.test.policy.begin(image.clone());
        let (mut moments, mut escaped) = (Vec::new(), false);
        for _ in 0..self.test.plan.max_steps.min(MOST_STEPS) {
            let decision = self.test.policy.decide();
            self.test.announcer.announce(&decision);
            let step = self.test.room.step(decision.action)?;
            let Some((next_pose, next_scene)) = self.truth.at(self.test.room.stamp()) else {
                return Ok(None);
            };
            let (values, action, blocked) = (decision.values, decision.action, step.blocked);
            moments.push(Moment { pose, scene, image, values, action, blocked });
            (pose, scene, image) = (next_pose, next_scene, step.image.clone());
            self.test.policy.observe(action, step.image);
            escaped = step.terminated;
            if step.terminated || step.truncated {
                break;
            }
        }
        Ok(Some(Escape { moments, last: (pose, scene), escaped }))
    }
}
