//! The training loop (the paper's Figure 2).

use std::{
    num::NonZeroU64,
    time::{Duration, Instant},
};

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::{
    action::Action,
    dyna_q::{Decision, DynaQ},
    record::EpisodeRecord,
    seeds::{Purpose, episode_seed},
    settings::Settings,
};
use crate::environment::{Environment, EnvironmentError, Step};

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
    /// The step that was begun, if its end has not been seen.
    pub begun: Option<BegunStep>,
}

/// A step under way.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct BegunStep {
    /// The index of its action.
    pub action: u8,
    /// Updates that belong to it and are made already.
    pub updates: u32,
}

/// Who wants to know how the training goes.
pub trait Listener {
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

    /// Trains until all episodes are done. After an error of the room, [`super::checkpoint`] can save
    /// the training, and `run` goes on from there as if nothing had happened.
    pub fn run(
        &mut self,
        room: &mut impl Environment,
        listener: &mut impl Listener,
    ) -> Result<(), TrainingError> {
        let mut started = Instant::now();
        self.begin_reset(room)?;
        while self.episode() < self.plan.episodes {
            self.run_episode(room, &mut started)?;
            // While the room makes itself ready, there is time to tell of the episode.
            self.begin_reset(room)?;
            listener.episode(self)?;
        }
        Ok(())
    }

    /// Asks for the present episode, if there is one more.
    fn begin_reset(&self, room: &mut impl Environment) -> Result<(), TrainingError> {
        if self.episode() < self.plan.episodes {
            room.begin_reset(self.episode_seed(), &self.plan.scenario)?;
        }
        Ok(())
    }

    fn episode_seed(&self) -> NonZeroU64 {
        episode_seed(Purpose::Training, self.plan.seed, self.episode())
    }

    /// `counted` is the time up to which the wall time is counted.
    fn run_episode(
        &mut self,
        room: &mut impl Environment,
        counted: &mut Instant,
    ) -> Result<(), TrainingError> {
        let epsilon = self.epsilon();
        let seed = self.episode_seed();
        let mut state = room.finish_reset()?;
        // Unless the episode was interrupted, this is a first image, and new.
        let interrupted = !self.progress.current.actions.is_empty();
        if !interrupted && self.learner.memory.latest_image() != Some(state.bytes()) {
            self.learner.begin_episode(&state);
        }
        // An interrupted episode: the room is brought back to where it was.
        for (step, index) in self.progress.current.actions.clone().into_iter().enumerate() {
            let again = room.step(&Decision::from(action(index)?))?;
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
            let decision = match self.progress.current.begun {
                None => self.learner.act(&state, epsilon),
                // unless it had chosen before it was interrupted,
                Some(begun) => Decision::from(action(begun.action)?),
            };
            let index = decision.action.index();
            self.progress.current.begun.get_or_insert(BegunStep { action: index, updates: 0 });
            // then transitions to s_t+1 and receives R_t+1. Experience replay is performed every time
            // the agent takes a step: it begins while the room is at work.
            room.begin_step(&decision)?;
            let step = self.plan_and_finish_step(room, decision.action)?;
            let current = &mut self.progress.current;
            current.begun = None;
            current.actions.push(index);
            current.episode_return += step.reward;
            current.blocked += u32::from(step.blocked);
            self.progress.total_steps += 1;
            self.progress.wall += counted.elapsed();
            *counted = Instant::now();
            if step.terminated || step.truncated {
                // The target network follows at the end of each episode.
                self.learner.end_episode();
                self.finish_episode(epsilon, step.terminated);
                return Ok(());
            }
            state = step.image;
        }
    }

    /// Makes the updates of a step, and waits for its end where one of them needs its experience.
    ///
    /// The result is that of remembering first and updating then: what a batch holds follows from the
    /// length that the memory will have, so a batch without the newest experience is known before.
    fn plan_and_finish_step(
        &mut self,
        room: &mut impl Environment,
        action: Action,
    ) -> Result<Step, TrainingError> {
        let newest = self.learner.memory.next_index();
        let mut finished: Option<Step> = None;
        while self.updates_made() < self.learner.settings.planning_steps as u32 {
            let before = self.learner.replay_random.clone();
            let is_drawn = self.learner.draw(finished.is_none());
            let needs_newest = is_drawn && self.learner.batch().contains(&newest);
            if needs_newest && finished.is_none() {
                let step = room.finish_step().inspect_err(|_| {
                    // The update was not made: made later, it must be the same one.
                    self.learner.replay_random = before;
                })?;
                self.learner.remember(action, step.reward, step.terminated, &step.image);
                finished = Some(step);
            }
            if is_drawn {
                self.update()?;
            }
            if let Some(begun) = &mut self.progress.current.begun {
                begun.updates += 1;
            }
        }
        match finished {
            Some(step) => Ok(step),
            None => {
                let step = room.finish_step()?;
                self.learner.remember(action, step.reward, step.terminated, &step.image);
                Ok(step)
            }
        }
    }

    fn updates_made(&self) -> u32 {
        self.progress.current.begun.map_or(0, |begun| begun.updates)
    }

    fn update(&mut self) -> Result<(), TrainingError> {
        let started = Instant::now();
        let loss = self.learner.update();
        if !loss.is_finite() {
            return Err(TrainingError::Diverged { loss, episode: self.episode() });
        }
        self.progress.updates += 1;
        self.progress.update_time += started.elapsed();
        self.progress.current.loss_sum += f64::from(loss);
        self.progress.current.losses += 1;
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

/// An action of a checkpoint.
fn action(index: u8) -> Result<Action, TrainingError> {
    Ok(Action::try_from(index).map_err(anyhow::Error::from)?)
}

#[cfg(test)]
mod tests;
