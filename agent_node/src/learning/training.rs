//! The training loop (the paper's Figure 2).

use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::{
    action::Action,
    dyna_q::{Decision, DynaQ},
    record::EpisodeRecord,
    seeds::{Purpose, episode_seed},
    settings::Settings,
};
use crate::environment::{Environment, EnvironmentError};

/// What a training is of, apart from the method's own numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// The scenario of every reset.
    pub scenario: String,
    /// `e_total` of eq. 4.
    pub episodes: u32,
    /// The seed of the run.
    pub seed: u64,
}

/// Why a training does not go on.
#[derive(Debug, Error)]
pub enum TrainingError {
    /// The room does not answer as it should.
    #[error(transparent)]
    Environment(#[from] EnvironmentError),
    /// The networks cannot be computed.
    #[error("the networks cannot be computed: {0}")]
    Network(#[from] candle_core::Error),
    /// Weights grew beyond all bounds.
    #[error(
        "the loss is {loss} in episode {episode}: the training diverges, try a smaller learning_rate"
    )]
    Diverged {
        /// The loss.
        loss: f32,
        /// The episode.
        episode: u32,
    },
    /// Whoever listens cannot go on.
    #[error(transparent)]
    Listener(#[from] anyhow::Error),
}

/// What a training has done so far.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Progress {
    /// One record per finished episode.
    pub records: Vec<EpisodeRecord>,
    /// Steps of all episodes, the unfinished one included.
    pub total_steps: u64,
    /// Updates of the training network.
    pub updates: u64,
    /// Time from the first reset to the last update, interruptions left out.
    pub wall: Duration,
    /// Time spent in updates.
    pub update_time: Duration,
    /// The unfinished episode.
    pub current: CurrentEpisode,
}

/// An episode under way.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CurrentEpisode {
    /// Indices of the actions taken so far. With the seed they bring the room back to this state.
    pub actions: Vec<u8>,
    /// The sum of the rewards so far.
    pub episode_return: f32,
    /// Sum and number of the losses so far.
    pub loss_sum: f64,
    /// How many losses the sum is of.
    pub losses: u32,
    /// Blocked moves so far.
    pub blocked: u32,
}

/// Who wants to know how the training goes.
pub trait Listener {
    /// The agent has decided and the room has answered.
    fn step(&mut self, _training: &Training, _decision: &Decision) {}

    /// An episode has ended; its record is the last one.
    fn episode(&mut self, training: &Training) -> anyhow::Result<()>;
}

/// A training: the plan, the learner and how far they are.
#[derive(Debug)]
pub struct Training {
    /// What it is of.
    pub plan: Plan,
    /// What has been done.
    pub progress: Progress,
    pub(super) learner: DynaQ,
}

impl Training {
    /// A training that has not begun.
    pub fn new(plan: Plan, settings: Settings) -> Result<Training, candle_core::Error> {
        let learner = DynaQ::new(settings, plan.seed)?;
        Ok(Training { plan, progress: Progress::default(), learner })
    }

    /// The learner.
    pub fn learner(&self) -> &DynaQ {
        &self.learner
    }

    /// The number of the present episode, from 0; the number of episodes once all are done.
    pub fn episode(&self) -> u32 {
        self.progress.records.len() as u32
    }

    /// The exploration probability of the present episode.
    pub fn epsilon(&self) -> f64 {
        self.learner.settings.exploration.epsilon(self.episode(), self.plan.episodes)
    }

    /// Steps per second of wall time, so far.
    pub fn steps_per_s(&self) -> f64 {
        self.progress.total_steps as f64 / self.progress.wall.as_secs_f64().max(f64::MIN_POSITIVE)
    }

    /// Mean time of an update in microseconds; 0 before the first.
    pub fn update_us(&self) -> f64 {
        self.progress.update_time.as_secs_f64() * 1e6 / self.progress.updates.max(1) as f64
    }

    /// Trains until all episodes are done. After an error the training is as it was before the step
    /// that failed: [`super::checkpoint`] can save it, and `run` goes on from there.
    pub fn run(
        &mut self,
        room: &mut impl Environment,
        listener: &mut impl Listener,
    ) -> Result<(), TrainingError> {
        while self.episode() < self.plan.episodes {
            self.run_episode(room, listener)?;
            listener.episode(self)?;
        }
        Ok(())
    }

    fn run_episode(
        &mut self,
        room: &mut impl Environment,
        listener: &mut impl Listener,
    ) -> Result<(), TrainingError> {
        let epsilon = self.epsilon();
        let mut started = Instant::now();
        let seed = episode_seed(Purpose::Training, self.plan.seed, self.episode());
        let mut state = room.reset(seed, &self.plan.scenario)?;
        // Unless the episode was interrupted, this is a first image, and new.
        let interrupted = !self.progress.current.actions.is_empty();
        if !interrupted && self.learner.memory.latest_image() != Some(state.bytes()) {
            self.learner.begin_episode(&state);
        }
        // An interrupted episode: the room is brought back to where it was.
        for (step, index) in self.progress.current.actions.clone().into_iter().enumerate() {
            let action = Action::try_from(index).map_err(anyhow::Error::from)?;
            let again = room.step(&Decision::from(action))?;
            state = again.image;
            if again.terminated || again.truncated {
                let step = step as u32 + 1;
                return Err(EnvironmentError::NotRepeatable { step, seed: seed.get() }.into());
            }
        }
        if self.learner.memory.latest_image() != Some(state.bytes()) {
            let step = self.progress.current.actions.len() as u32;
            return Err(EnvironmentError::NotRepeatable { step, seed: seed.get() }.into());
        }
        loop {
            // At time t the agent observes s_t and chooses a_t,
            let before = self.learner.exploration_random.clone();
            let decision = self.learner.act(&state, epsilon)?;
            // then transitions to s_t+1 and receives R_t+1.
            let step = match room.step(&decision) {
                Ok(step) => step,
                Err(error) => {
                    // The step was not taken: taken later, it must be the same one.
                    self.learner.exploration_random = before;
                    return Err(error.into());
                }
            };
            self.learner.remember(decision.action, step.reward, step.terminated, &step.image);
            // Experience replay is performed every time the agent takes a step.
            for _ in 0..self.learner.settings.planning_steps {
                self.plan_once()?;
            }
            let current = &mut self.progress.current;
            current.actions.push(decision.action.index());
            current.episode_return += step.reward;
            current.blocked += u32::from(step.blocked);
            self.progress.total_steps += 1;
            self.progress.wall += started.elapsed();
            started = Instant::now();
            listener.step(self, &decision);
            if step.terminated || step.truncated {
                // The target network follows at the end of each episode.
                self.learner.end_episode()?;
                self.finish_episode(epsilon, step.terminated);
                return Ok(());
            }
            state = step.image;
        }
    }

    fn plan_once(&mut self) -> Result<(), TrainingError> {
        let started = Instant::now();
        if let Some(loss) = self.learner.plan()? {
            if !loss.is_finite() {
                return Err(TrainingError::Diverged { loss, episode: self.episode() });
            }
            self.progress.updates += 1;
            self.progress.update_time += started.elapsed();
            self.progress.current.loss_sum += f64::from(loss);
            self.progress.current.losses += 1;
        }
        Ok(())
    }

    fn finish_episode(&mut self, epsilon: f64, terminated: bool) {
        let current = std::mem::take(&mut self.progress.current);
        let record = EpisodeRecord {
            episode: self.episode(),
            steps: current.actions.len() as u32,
            episode_return: current.episode_return,
            epsilon,
            loss: (current.losses > 0).then(|| current.loss_sum / f64::from(current.losses)),
            blocked: current.blocked,
            terminated,
        };
        self.progress.records.push(record);
    }
}
