use std::num::NonZeroU64;

use task::{EXIT_REWARD, Image, Random, STEP_REWARD};

use super::*;
use crate::{
    checkpoint::model_bytes,
    exploration::EpsilonDecay,
    settings::{Architecture, Preset, TargetUpdate},
};

/// A deterministic environment whose state is a number that depends on the seed and the actions.
struct NumberWorld {
    seed: u64,
    position: u64,
    steps: u32,
    /// The random numbers and the probability that determine which calls fail, if any.
    faults: Option<(Random, f64)>,
}

impl NumberWorld {
    fn new() -> NumberWorld {
        NumberWorld { seed: 0, position: 0, steps: 0, faults: None }
    }

    fn failing(seed: u8, chance: f64) -> NumberWorld {
        NumberWorld {
            faults: Some((Random::from_key([seed.into(); 4]), chance)),
            ..NumberWorld::new()
        }
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

/// An injected fault.
#[derive(Debug, Error, PartialEq)]
#[error("injected fault")]
struct Fault;

impl Environment for NumberWorld {
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

/// A listener that does nothing.
struct Silent;

impl Listener for Silent {
    fn episode(&mut self, _training: &Training, _record: &EpisodeRecord) -> anyhow::Result<()> {
        Ok(())
    }
}

fn plan(environments: usize) -> Plan {
    Plan { scenario: "numbers".into(), episodes: 25, seed: 11, rooms: environments }
}

fn number_worlds(count: usize) -> Vec<NumberWorld> {
    (0..count).map(|_| NumberWorld::new()).collect()
}

/// Returns settings that sample the newest transition rarely, often or always, perform zero, one or
/// several updates per step, and cover every architecture.
fn all_settings() -> Vec<Settings> {
    let paper = Preset::Paper.settings().with(|s| {
        s.network.hidden_layers = vec![16, 8];
        s.exploration.epsilon =
            EpsilonDecay { minimum: 0.2, ..Preset::Paper.settings().exploration.epsilon };
        s.replay.batch_size = 20;
        s.optimizer.learning_rate = 1e-2;
    });
    let with = |architecture: Architecture| {
        paper.clone().with(|s| {
            s.network.architecture = architecture;
            s.network.observation_frames = 2;
            s.replay.batch_size = 4;
        })
    };
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
        with(Architecture::Dueling),
        with(Architecture::Convolutional),
        with(Architecture::Recurrent),
        paper,
    ]
}

/// The training loop of the paper, without overlap: act and step, store, update. With several
/// environments, each of these stages is completed in all environments before the next one begins.
/// Returns the number of steps and the model.
fn sequential(plan: &Plan, settings: &Settings) -> (u64, Vec<u8>) {
    let mut learner = DynaQ::new(settings.clone(), plan.seed, plan.rooms).unwrap();
    let mut environments = number_worlds(plan.rooms);
    let mut episodes = 0..plan.episodes;
    // The episode of each environment, and the number of its current image in the replay memory.
    let mut current: Vec<Option<(u32, u64)>> = vec![None; plan.rooms];
    let (mut steps, mut ended) = (0, 0);
    loop {
        for (environment, current) in environments.iter_mut().zip(&mut current) {
            if current.is_none()
                && let Some(episode) = episodes.next()
            {
                let seed = episode_seed(Purpose::Training, plan.seed, episode);
                let image = environment.reset(seed, &plan.scenario).unwrap();
                let number = learner.begin_episode(&image);
                *current = Some((episode, number));
            }
        }
        if current.iter().all(Option::is_none) {
            return (steps, model_bytes(learner.network()).unwrap());
        }
        let mut results = Vec::new();
        for (environment, current) in environments.iter_mut().zip(&current) {
            results.push(current.as_ref().map(|(episode, number)| {
                let epsilon = settings.exploration.epsilon.epsilon(*episode, plan.episodes);
                let decision = learner.act(&[(*number, epsilon)]).remove(0);
                (decision.action, environment.step(decision.action).unwrap())
            }));
        }
        let mut updates = 0;
        for (current, result) in current.iter_mut().zip(&results) {
            if let (Some((_, number)), Some((action, step))) = (current, result) {
                steps += 1;
                if steps % settings.replay.update_interval as u64 == 0 {
                    updates += settings.replay.planning_steps;
                }
                *number = learner.store(*number, *action, step);
            }
        }
        learner.set_progress(f64::from(ended) / f64::from(plan.episodes));
        for _ in 0..updates {
            learner.plan();
        }
        for (current, result) in current.iter_mut().zip(results) {
            if result.is_some_and(|(_, step)| step.terminated || step.truncated) {
                learner.end_episode();
                ended += 1;
                *current = None;
            }
        }
    }
}

#[test]
fn overlapping_updates_and_steps_give_the_same_result_as_the_sequential_loop() {
    for count in [1, 3] {
        for settings in all_settings() {
            let mut training = Training::new(plan(count), settings.clone()).unwrap();
            training.run(&mut number_worlds(count), &mut Silent).unwrap();
            let (steps, model) = sequential(&plan(count), &settings);
            assert_eq!(training.progress.total_steps, steps);
            assert!(model_bytes(training.learner.network()).unwrap() == model, "{settings:?}");
            let mut episodes: Vec<u32> =
                training.progress.records.iter().map(|record| record.episode).collect();
            // Losses count for the episodes of all environments. There are none in the first
            // episode, before the first batch, and there may be none in a short one.
            let mut later = training.progress.records.iter().skip(1);
            let is_counted = settings.replay.planning_steps > 0;
            assert!(
                !is_counted || later.all(|record| record.loss.is_some() || record.steps < 9),
                "{count} environments, {settings:?}"
            );
            episodes.sort_unstable();
            assert!(episodes.into_iter().eq(0..25), "an episode did not run exactly once");
        }
    }
}

/// Returns the part of the result that must not depend on interruptions: everything except the
/// times.
fn result(training: &Training) -> (Records, u64, u64, Vec<u8>) {
    let Progress { records, total_steps, updates, .. } = training.progress.clone();
    (records, total_steps, updates, model_bytes(training.learner.network()).unwrap())
}

#[test]
fn an_interrupted_run_gives_the_same_result_as_an_uninterrupted_one() {
    let directory = tempfile::tempdir().unwrap();
    let file = directory.path().join("checkpoint.safetensors");
    for (count, chance) in [(1, 0.01), (3, 0.005)] {
        for settings in all_settings() {
            let mut uninterrupted = Training::new(plan(count), settings.clone()).unwrap();
            uninterrupted.run(&mut number_worlds(count), &mut Silent).unwrap();

            let mut training = Training::new(plan(count), settings.clone()).unwrap();
            let mut interruptions = 0u8;
            let failing = |interruptions: u8| -> Vec<NumberWorld> {
                let seed = |index: usize| interruptions ^ (index as u8) << 6;
                (0..count).map(|index| NumberWorld::failing(seed(index), chance)).collect()
            };
            while training.run(&mut failing(interruptions), &mut Silent).is_err() {
                interruptions = interruptions.checked_add(1).expect("at most 255 interruptions");
                training.write_checkpoint(&file).unwrap();
                training = Training::load(&file, plan(count), settings.clone()).unwrap();
            }
            assert!(interruptions > 3, "only {interruptions} interruptions");
            let is_identical = result(&training) == result(&uninterrupted);
            assert!(is_identical, "{count} environments, {settings:?}");
        }
    }
}
