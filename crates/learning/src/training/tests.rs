use std::num::NonZeroU64;

use task::{EXIT_REWARD, Image, Random, STEP_REWARD};

use super::*;
use crate::{
    checkpoint::model_bytes,
    exploration::EpsilonDecay,
    settings::{Preset, TargetUpdate},
};

/// A room that is a function of its seed and the actions: a number that actions push about.
struct Toy {
    seed: u64,
    position: u64,
    steps: u32,
    /// Where it fails, if it does: the chance in each call.
    faults: Option<(Random, f64)>,
}

impl Toy {
    fn new() -> Toy {
        Toy { seed: 0, position: 0, steps: 0, faults: None }
    }

    fn failing(seed: u8, chance: f64) -> Toy {
        Toy { faults: Some((Random::from_key([seed.into(); 4]), chance)), ..Toy::new() }
    }

    fn maybe_fail(&mut self) -> Result<(), Fault> {
        let fails = self.faults.as_mut().is_some_and(|(random, chance)| random.chance(*chance));
        if fails { Err(Fault) } else { Ok(()) }
    }

    fn image(&self) -> Image {
        let word = (self.position ^ self.seed).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let bytes: Vec<u8> = (0..Image::BYTES).map(|i| (word >> (i % 57)) as u8).collect();
        Image::try_from(bytes.as_slice()).unwrap()
    }
}

/// Why a room fails.
#[derive(Debug, Error, PartialEq)]
#[error("a fault")]
struct Fault;

impl Environment for Toy {
    type Error = Fault;
    type PendingReset = Image;
    type PendingStep = Action;

    fn begin_reset(&mut self, seed: NonZeroU64, _scenario: &str) -> Result<Image, Fault> {
        self.maybe_fail()?;
        (self.seed, self.position, self.steps) = (seed.get(), seed.get() % 97, 0);
        Ok(self.image())
    }

    fn finish_reset(&mut self, image: Image) -> Result<Image, Fault> {
        self.maybe_fail()?;
        Ok(image)
    }

    fn begin_step(&mut self, action: Action) -> Result<Action, Fault> {
        self.maybe_fail()?;
        Ok(action)
    }

    fn finish_step(&mut self, action: Action) -> Result<Step, Fault> {
        self.maybe_fail()?;
        self.position = (self.position * 7 + u64::from(action.index())) % 97;
        self.steps += 1;
        let terminated = self.position < 4;
        let truncated = !terminated && self.steps == 30;
        let reward = if terminated { EXIT_REWARD } else { STEP_REWARD };
        let blocked = self.position.is_multiple_of(5);
        Ok(Step { image: self.image(), reward, terminated, truncated, blocked })
    }
}

struct Silent;

impl Listener for Silent {
    fn episode(&mut self, _training: &Training, _record: &EpisodeRecord) -> anyhow::Result<()> {
        Ok(())
    }
}

fn plan(rooms: usize) -> Plan {
    Plan { scenario: "toy".into(), episodes: 25, seed: 11, rooms }
}

fn toys(rooms: usize) -> Vec<Toy> {
    (0..rooms).map(|_| Toy::new()).collect()
}

/// Settings in which the newest memory is drawn rarely, often and always, and several updates a step.
fn all_settings() -> Vec<Settings> {
    let paper = Preset::Paper.settings().with(|s| {
        s.network.hidden_layers = vec![16, 8];
        s.exploration.epsilon =
            EpsilonDecay { minimum: 0.2, ..Preset::Paper.settings().exploration.epsilon };
        s.replay.batch_size = 20;
        s.optimizer.learning_rate = 1e-2;
    });
    vec![
        paper.clone().with(|s| s.replay.capacity = 20),
        paper.clone().with(|s| {
            s.replay.capacity = 33;
            s.replay.planning_steps = 3;
        }),
        paper.clone().with(|s| s.replay.planning_steps = 0),
        Preset::Robust.settings().with(|s| {
            s.target.update_at = TargetUpdate::Update;
            s.network.hidden_layers = vec![16, 8];
            s.replay.batch_size = 20;
            s.replay.capacity = 40;
        }),
        paper,
    ]
}

/// The loop as the paper writes it: act, step, remember, update, one after the other; with several
/// rooms each of these in every room before the next.
fn sequential(plan: &Plan, settings: &Settings) -> (u64, Vec<u8>) {
    let mut learner = DynaQ::new(settings.clone(), plan.seed, plan.rooms).unwrap();
    let mut rooms = toys(plan.rooms);
    let mut episodes = 0..plan.episodes;
    // The episode, and the number in the memory of what is seen.
    let mut present: Vec<Option<(u32, u64)>> = vec![None; plan.rooms];
    let (mut steps, mut ended) = (0, 0);
    loop {
        for (room, present) in rooms.iter_mut().zip(&mut present) {
            if present.is_none()
                && let Some(episode) = episodes.next()
            {
                let seed = episode_seed(Purpose::Training, plan.seed, episode);
                let image = room.reset(seed, &plan.scenario).unwrap();
                let number = learner.begin_episode(&image);
                *present = Some((episode, number));
            }
        }
        if present.iter().all(Option::is_none) {
            return (steps, model_bytes(learner.network()).unwrap());
        }
        let mut results = Vec::new();
        for (room, present) in rooms.iter_mut().zip(&present) {
            results.push(present.as_ref().map(|(episode, number)| {
                let epsilon = settings.exploration.epsilon.epsilon(*episode, plan.episodes);
                let decision = learner.act(&[(*number, epsilon)]).remove(0);
                (decision.action, room.step(decision.action).unwrap())
            }));
        }
        let mut updates = 0;
        for (present, result) in present.iter_mut().zip(&results) {
            if let (Some((_, number)), Some((action, step))) = (present, result) {
                steps += 1;
                updates += settings.replay.planning_steps;
                *number = learner.remember(*number, *action, step);
            }
        }
        learner.set_progress(f64::from(ended) / f64::from(plan.episodes));
        for _ in 0..updates {
            learner.plan();
        }
        for (present, result) in present.iter_mut().zip(results) {
            if result.is_some_and(|(_, step)| step.terminated || step.truncated) {
                learner.end_episode();
                ended += 1;
                *present = None;
            }
        }
    }
}

#[test]
fn updating_while_the_room_works_gives_the_result_of_the_sequential_loop() {
    for rooms in [1, 3] {
        for settings in all_settings() {
            let mut training = Training::new(plan(rooms), settings.clone()).unwrap();
            training.run(&mut toys(rooms), &mut Silent).unwrap();
            let (steps, model) = sequential(&plan(rooms), &settings);
            assert_eq!(training.progress.total_steps, steps);
            assert!(model_bytes(training.learner.network()).unwrap() == model, "{settings:?}");
            let mut episodes: Vec<u32> =
                training.progress.records.iter().map(|record| record.episode).collect();
            episodes.sort_unstable();
            assert!(episodes.into_iter().eq(0..25), "every episode once");
        }
    }
}

/// What must not depend on interruptions: everything but times.
fn result(training: &Training) -> (Records, u64, u64, Vec<u8>) {
    let Progress { records, total_steps, updates, .. } = training.progress.clone();
    (records, total_steps, updates, model_bytes(training.learner.network()).unwrap())
}

#[test]
fn a_training_interrupted_anywhere_ends_as_one_that_was_not() {
    let directory = tempfile::tempdir().unwrap();
    let file = directory.path().join("checkpoint.safetensors");
    for (rooms, chance) in [(1, 0.01), (3, 0.005)] {
        for settings in all_settings() {
            let mut undisturbed = Training::new(plan(rooms), settings.clone()).unwrap();
            undisturbed.run(&mut toys(rooms), &mut Silent).unwrap();

            let mut training = Training::new(plan(rooms), settings.clone()).unwrap();
            let mut interruptions = 0u8;
            let failing = |interruptions: u8| -> Vec<Toy> {
                let room = |room: usize| Toy::failing(interruptions ^ (room as u8) << 6, chance);
                (0..rooms).map(room).collect()
            };
            while training.run(&mut failing(interruptions), &mut Silent).is_err() {
                interruptions = interruptions.checked_add(1).expect("it gets ahead between faults");
                training.write_checkpoint(&file).unwrap();
                training = Training::load(&file, plan(rooms), settings.clone()).unwrap();
            }
            assert!(interruptions > 3, "only {interruptions} interruptions");
            assert!(result(&training) == result(&undisturbed), "{rooms} rooms, {settings:?}");
        }
    }
}
