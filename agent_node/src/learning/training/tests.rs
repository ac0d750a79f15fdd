use std::num::NonZeroU64;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::learning::{
    checkpoint::model_bytes, exploration::EpsilonDecay, image::Image, settings::Preset,
};

/// A room that is a function of its seed and the actions: a number that actions push about.
struct Toy {
    seed: u64,
    position: u64,
    steps: u32,
    action: Option<Action>,
    /// Where it fails, if it does: the chance in each call.
    faults: Option<(ChaCha8Rng, f64)>,
}

impl Toy {
    fn new() -> Toy {
        Toy { seed: 0, position: 0, steps: 0, action: None, faults: None }
    }

    fn failing(seed: u8, chance: f64) -> Toy {
        Toy { faults: Some((ChaCha8Rng::from_seed([seed; 32]), chance)), ..Toy::new() }
    }

    fn maybe_fail(&mut self) -> Result<(), EnvironmentError> {
        let fails =
            self.faults.as_mut().is_some_and(|(random, chance)| random.random_bool(*chance));
        if fails { Err(EnvironmentError::Shutdown) } else { Ok(()) }
    }

    fn image(&self) -> Image {
        let word = (self.position ^ self.seed).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let bytes: Vec<u8> = (0..Image::BYTES).map(|i| (word >> (i % 57)) as u8).collect();
        Image::try_from(bytes.as_slice()).unwrap()
    }
}

impl Environment for Toy {
    fn begin_reset(&mut self, seed: NonZeroU64, _scenario: &str) -> Result<(), EnvironmentError> {
        self.maybe_fail()?;
        (self.seed, self.position, self.steps) = (seed.get(), seed.get() % 97, 0);
        Ok(())
    }

    fn finish_reset(&mut self) -> Result<Image, EnvironmentError> {
        self.maybe_fail()?;
        Ok(self.image())
    }

    fn begin_step(&mut self, decision: &Decision) -> Result<(), EnvironmentError> {
        self.maybe_fail()?;
        self.action = Some(decision.action);
        Ok(())
    }

    fn finish_step(&mut self) -> Result<Step, EnvironmentError> {
        self.maybe_fail()?;
        let action = self.action.take().expect("a step was begun");
        self.position = (self.position * 7 + u64::from(action.index())) % 97;
        self.steps += 1;
        let terminated = self.position < 4;
        let truncated = !terminated && self.steps == 30;
        let reward = if terminated { 0.0 } else { -0.1 };
        let blocked = self.position.is_multiple_of(5);
        Ok(Step { image: self.image(), reward, terminated, truncated, blocked })
    }
}

struct Silent;

impl Listener for Silent {
    fn episode(&mut self, _training: &Training) -> anyhow::Result<()> {
        Ok(())
    }
}

fn plan() -> Plan {
    Plan { scenario: "toy".into(), episodes: 25, seed: 11 }
}

/// Settings in which the newest memory is drawn rarely, often and always, and several updates a step.
fn all_settings() -> Vec<Settings> {
    let paper = Settings {
        hidden_layers: vec![16, 8],
        exploration: EpsilonDecay { minimum: 0.2, ..Preset::Paper.settings().exploration },
        batch_size: 20,
        learning_rate: 1e-2,
        ..Preset::Paper.settings()
    };
    vec![
        Settings { memory_capacity: 20, ..paper.clone() },
        Settings { memory_capacity: 33, planning_steps: 3, ..paper.clone() },
        Settings { planning_steps: 0, ..paper.clone() },
        paper,
    ]
}

/// The loop as the paper writes it: act, step, remember, update, one after the other.
fn sequential(plan: &Plan, settings: &Settings) -> (u64, Vec<u8>) {
    let mut learner = DynaQ::new(settings.clone(), plan.seed).unwrap();
    let mut room = Toy::new();
    let mut steps = 0;
    for episode in 0..plan.episodes {
        let epsilon = settings.exploration.epsilon(episode, plan.episodes);
        let seed = episode_seed(Purpose::Training, plan.seed, episode);
        let mut state = room.reset(seed, &plan.scenario).unwrap();
        learner.begin_episode(&state);
        loop {
            let decision = learner.act(&state, epsilon);
            let step = room.step(&decision).unwrap();
            steps += 1;
            learner.remember(decision.action, step.reward, step.terminated, &step.image);
            for _ in 0..settings.planning_steps {
                learner.plan();
            }
            if step.terminated || step.truncated {
                break;
            }
            state = step.image;
        }
        learner.end_episode();
    }
    (steps, model_bytes(learner.network()).unwrap())
}

#[test]
fn updating_while_the_room_works_gives_the_result_of_the_sequential_loop() {
    for settings in all_settings() {
        let mut training = Training::new(plan(), settings.clone()).unwrap();
        training.run(&mut Toy::new(), &mut Silent).unwrap();
        let (steps, model) = sequential(&plan(), &settings);
        assert_eq!(training.progress.total_steps, steps);
        assert!(model_bytes(training.learner.network()).unwrap() == model, "{settings:?}");
    }
}

/// What must not depend on interruptions: everything but times.
fn result(training: &Training) -> (Vec<EpisodeRecord>, u64, u64, Vec<u8>) {
    let Progress { records, total_steps, updates, .. } = training.progress.clone();
    (records, total_steps, updates, model_bytes(training.learner.network()).unwrap())
}

#[test]
fn a_training_interrupted_anywhere_ends_as_one_that_was_not() {
    let directory = tempfile::tempdir().unwrap();
    let file = directory.path().join("checkpoint.safetensors");
    for settings in all_settings() {
        let mut undisturbed = Training::new(plan(), settings.clone()).unwrap();
        undisturbed.run(&mut Toy::new(), &mut Silent).unwrap();

        let mut training = Training::new(plan(), settings.clone()).unwrap();
        let mut interruptions = 0;
        while training.run(&mut Toy::failing(interruptions, 0.01), &mut Silent).is_err() {
            interruptions = interruptions.checked_add(1).expect("it gets ahead between two faults");
            std::fs::write(&file, training.checkpoint_bytes().unwrap()).unwrap();
            training = Training::load(&file, plan(), settings.clone()).unwrap();
        }
        assert!(interruptions > 3, "only {interruptions} interruptions");
        assert!(result(&training) == result(&undisturbed), "{settings:?}");
    }
}
