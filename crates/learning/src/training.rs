//! The training loop (Figure 2 of the paper), in one or several environments.

use std::{
    num::NonZeroU64,
    time::{Duration, Instant},
};

use pulp::Arch;
use serde::{Deserialize, Serialize};
use task::{
    Action, Environment, Step,
    seeds::{Purpose, episode_scenario, episode_seed},
};
use thiserror::Error;

use super::{
    dyna_q::{Decision, DynaQ},
    policy::Policy,
    record::{EpisodeRecord, Records},
    settings::{ReplaySettings, Settings},
};

/// The episodes of a training run. The hyperparameters are in [`Settings`].
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// The scenario of every episode, or [`MIXED`](task::seeds::MIXED).
    pub scenario: String,
    /// Number of episodes, `e_total` in eq. 4.
    pub episodes: u32,
    /// The seed of the run.
    pub seed: u64,
    /// Number of environments in which the agent learns at the same time. They step in lockstep;
    /// when an episode ends, its environment starts the next episode that has not started yet.
    pub rooms: usize,
}

/// An error that interrupts a training run.
#[derive(Debug, Error)]
pub enum TrainingError<E> {
    /// An environment failed.
    #[error(transparent)]
    Environment(E),
    /// The environment did not reproduce the interrupted episode.
    #[error(
        "the environment is not reproducible: step {step} of the episode with seed {seed} differs \
         from the one before the interruption (was the environment restarted with different \
         parameters?)"
    )]
    NotReproducible {
        /// The number of the step at which a difference was detected, starting at 1; 0 is the
        /// reset.
        step: usize,
        /// The seed of the episode.
        seed: NonZeroU64,
    },
    /// The loss is infinite or NaN.
    #[error(
        "the loss is {loss} in episode {episode}: training diverged (try a smaller learning_rate)"
    )]
    Diverged {
        /// The loss.
        loss: f32,
        /// The number of finished episodes.
        episode: u32,
    },
    /// The listener failed.
    #[error(transparent)]
    Listener(#[from] anyhow::Error),
}

/// The progress of a training run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Progress {
    /// One record per finished episode. A checkpoint stores them as tensors.
    #[serde(skip)]
    pub records: Records,
    /// Number of steps, including those of unfinished episodes.
    pub total_steps: u64,
    /// Number of updates of the training network.
    pub updates: u64,
    /// Wall time from the first reset to the last update, excluding interruptions.
    pub wall: Duration,
    /// Wall time spent in updates.
    pub update_time: Duration,
    /// Index of the next episode to start.
    pub next_episode: u32,
    /// The current episode of each environment, or `None` if no episode is left for it.
    pub current: Vec<Option<CurrentEpisode>>,
    /// The unfinished step in all environments, if there is one.
    pub begun: Option<BegunStep>,
}

/// An unfinished episode.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CurrentEpisode {
    /// Index of the episode, starting at 0.
    pub episode: u32,
    /// The number of the current image in the replay memory; `None` before the reset.
    pub image: Option<u64>,
    /// The actions taken so far. A reset with the episode seed, followed by these actions, restores
    /// the environment.
    pub actions: Vec<Action>,
    /// Sum of the rewards so far.
    pub episode_return: f32,
    /// Sum of the losses so far.
    pub loss_sum: f64,
    /// Number of losses in `loss_sum`.
    pub losses: u32,
    /// Number of blocked moves so far.
    pub blocked: u32,
}

/// An unfinished step in all environments.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BegunStep {
    /// The action in each environment that has a current episode.
    pub actions: Vec<Action>,
    /// Number of updates already performed during the step, including those that were skipped
    /// because there were too few transitions.
    pub updates: u32,
}

/// Receives the progress of a training run.
pub trait Listener {
    /// Called with each decision and the index of its environment, starting at 0. By default, this
    /// method does nothing.
    fn decision(&mut self, _environment: usize, _decision: &Decision) {}

    /// Called at the end of each episode.
    ///
    /// # Errors
    ///
    /// An error interrupts the training run ([`TrainingError::Listener`]).
    fn episode(&mut self, training: &Training, record: &EpisodeRecord) -> anyhow::Result<()>;
}

/// A training run: the plan, the learner and the progress.
///
/// The [crate example](crate#examples) performs a training run.
///
/// # Examples
///
/// ```
/// use learning::{
///     settings::Preset,
///     training::{Plan, Training},
/// };
///
/// let plan = Plan { scenario: "empty".into(), episodes: 1000, seed: 1, rooms: 2 };
/// let training = Training::new(plan, Preset::Paper.settings())?;
/// assert_eq!(training.episode(), 0);
/// assert_eq!(training.progress.current.len(), 2);
/// # Ok::<(), candle_core::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Training {
    /// The episodes of the training run.
    pub plan: Plan,
    /// The progress so far.
    pub progress: Progress,
    pub(super) learner: DynaQ,
}

impl Training {
    /// Creates a training run that has not started.
    ///
    /// # Errors
    ///
    /// Returns an error if the settings do not describe a valid network.
    pub fn new(plan: Plan, settings: Settings) -> Result<Training, candle_core::Error> {
        let learner = DynaQ::new(settings, plan.seed, plan.rooms)?;
        let mut progress = Progress::default();
        for _ in 0..plan.rooms {
            let next = progress.next_episode(plan.episodes);
            progress.current.push(next);
        }
        Ok(Training { plan, progress, learner })
    }

    /// Selects the vector instructions to use (see [`DynaQ::set_arch`]).
    pub fn set_arch(&mut self, arch: Arch) {
        self.learner.set_arch(arch);
    }

    /// Returns the learner.
    pub fn learner(&self) -> &DynaQ {
        &self.learner
    }

    /// Returns the greedy policy of the training network.
    pub fn policy(&self) -> Policy {
        Policy::new(self.learner.network().clone_box(), &self.learner.settings)
    }

    /// Returns the number of finished episodes; with one environment, this is the index of the
    /// current episode.
    pub fn episode(&self) -> u32 {
        self.progress.records.len() as u32
    }

    /// Returns the exploration probability of an episode (eq. 4).
    fn epsilon_of(&self, episode: u32) -> f64 {
        self.learner.settings.exploration.epsilon.epsilon(episode, self.plan.episodes)
    }

    /// Returns the mean number of steps per second of wall time.
    pub fn steps_per_s(&self) -> f64 {
        self.progress.total_steps as f64 / self.progress.wall.as_secs_f64().max(f64::MIN_POSITIVE)
    }

    /// Returns the mean update time in microseconds, or 0 before the first update.
    pub fn update_us(&self) -> f64 {
        self.progress.update_time.as_secs_f64() * 1e6 / self.progress.updates.max(1) as f64
    }

    /// Trains until all episodes are finished.
    ///
    /// After an environment error, the training run can be saved
    /// ([`write_checkpoint`](Training::write_checkpoint)) and `run` can be called again. The new
    /// call restores the interrupted episodes and continues, with the same result as without the
    /// interruption.
    ///
    /// # Errors
    ///
    /// Returns an error if an environment fails or does not reproduce an interrupted episode, if
    /// training diverges, or if the listener fails.
    ///
    /// # Panics
    ///
    /// Panics if the number of environments differs from the plan.
    pub fn run<E: Environment>(
        &mut self,
        environments: &mut [E],
        listener: &mut impl Listener,
    ) -> Result<(), TrainingError<E::Error>> {
        let expected = self.plan.rooms;
        assert_eq!(
            environments.len(),
            expected,
            "the number of environments differs from the plan"
        );
        let mut counted = Instant::now();
        // The pending reset of each environment.
        let mut resets: Vec<Option<E::PendingReset>> = environments.iter().map(|_| None).collect();
        let all: Vec<usize> = (0..environments.len()).collect();
        self.begin_resets(environments, &all, &mut resets)?;
        while self.progress.current.iter().any(Option::is_some) {
            self.finish_resets(environments, &mut resets)?;
            let ended = self.step(environments, listener)?;
            self.progress.wall += counted.elapsed();
            counted = Instant::now();
            if !ended.is_empty() {
                // The listener runs while the environments reset.
                self.begin_resets(environments, &ended, &mut resets)?;
                for record in self.progress.records.recent(ended.len()) {
                    listener.episode(self, record)?;
                }
            }
        }
        Ok(())
    }

    /// Requests a reset in each of the given environments that has a current episode.
    fn begin_resets<E: Environment>(
        &self,
        environments: &mut [E],
        indices: &[usize],
        resets: &mut [Option<E::PendingReset>],
    ) -> Result<(), TrainingError<E::Error>> {
        for &index in indices {
            if let Some(CurrentEpisode { episode, .. }) = self.progress.current[index] {
                let Plan { scenario, seed, .. } = &self.plan;
                let scenario = episode_scenario(scenario, Purpose::Training, *seed, episode);
                let reset = environments[index].begin_reset(self.seed_of(episode), scenario);
                resets[index] = Some(reset.map_err(TrainingError::Environment)?);
            }
        }
        Ok(())
    }

    /// Returns the seed of an episode.
    fn seed_of(&self, episode: u32) -> NonZeroU64 {
        episode_seed(Purpose::Training, self.plan.seed, episode)
    }

    /// Finishes the pending resets, and restores interrupted episodes.
    fn finish_resets<E: Environment>(
        &mut self,
        environments: &mut [E],
        resets: &mut [Option<E::PendingReset>],
    ) -> Result<(), TrainingError<E::Error>> {
        for (index, (environment, reset)) in environments.iter_mut().zip(resets).enumerate() {
            let (Some(reset), Some(current)) = (reset.take(), &self.progress.current[index]) else {
                continue;
            };
            let seed = self.seed_of(current.episode);
            let mut image = environment.finish_reset(reset).map_err(TrainingError::Environment)?;
            // An interrupted episode is restored by repeating its actions.
            for (step, action) in current.actions.iter().enumerate() {
                let repeated = environment.step(*action).map_err(TrainingError::Environment)?;
                image = repeated.image;
                if repeated.terminated || repeated.truncated {
                    return Err(TrainingError::NotReproducible { step: step + 1, seed });
                }
            }
            let number = match current.image {
                None => self.learner.begin_episode(&image),
                Some(number) if self.learner.memory.frame(number).image == *image.bytes() => number,
                Some(_) => {
                    let step = current.actions.len();
                    return Err(TrainingError::NotReproducible { step, seed });
                }
            };
            if let Some(current) = &mut self.progress.current[index] {
                current.image = Some(number);
            }
        }
        Ok(())
    }

    /// Takes one step in each environment that has a current episode. Returns the indices of the
    /// environments whose episodes ended.
    fn step<E: Environment>(
        &mut self,
        environments: &mut [E],
        listener: &mut impl Listener,
    ) -> Result<Vec<usize>, TrainingError<E::Error>> {
        let current = &self.progress.current;
        let active: Vec<usize> =
            (0..current.len()).filter(|index| current[*index].is_some()).collect();
        // At time t, the agent observes s_t and chooses a_t, unless it already chose a_t before an
        // interruption.
        let actions = match &self.progress.begun {
            Some(begun) => begun.actions.clone(),
            None => {
                let states: Vec<(u64, f64)> = current
                    .iter()
                    .flatten()
                    .filter_map(|current| Some((current.image?, self.epsilon_of(current.episode))))
                    .collect();
                let decisions = self.learner.act(&states);
                for (index, decision) in active.iter().zip(&decisions) {
                    listener.decision(*index, decision);
                }
                let actions: Vec<Action> =
                    decisions.iter().map(|decision| decision.action).collect();
                self.progress.begun = Some(BegunStep { actions: actions.clone(), updates: 0 });
                actions
            }
        };
        // The environment transitions to s_t+1 and returns R_t+1. Experience replay is performed
        // while the environments are busy.
        let begin = |(index, action): (&usize, &Action)| environments[*index].begin_step(*action);
        let begun = active.iter().zip(&actions).map(begin).collect::<Result<Vec<_>, _>>();
        let begun = begun.map_err(TrainingError::Environment)?;
        let steps = self.plan_and_finish_steps(environments, &active, &actions, begun)?;
        self.progress.begun = None;
        let mut ended = Vec::new();
        for ((index, action), step) in active.into_iter().zip(actions).zip(steps) {
            self.progress.total_steps += 1;
            let slot = &mut self.progress.current[index];
            let Some(mut current) = slot.take() else {
                continue;
            };
            current.actions.push(action);
            current.episode_return += step.reward;
            current.blocked += u32::from(step.blocked);
            if step.terminated || step.truncated {
                // With the paper's settings, the target network is updated at the end of each
                // episode.
                self.learner.end_episode();
                self.record(current, step.terminated);
                let next = self.progress.next_episode(self.plan.episodes);
                self.progress.current[index] = next;
                ended.push(index);
            } else {
                *slot = Some(current);
            }
        }
        Ok(ended)
    }

    /// Performs the updates of a step. Waits for the step to finish as soon as an update needs its
    /// transitions, at the latest after the last update.
    ///
    /// The result is the same as if the transitions were stored before all updates: the indices of
    /// a batch depend only on the future size of the replay memory and, with prioritized replay, on
    /// priorities, which are the same for all new transitions. So batches that do not contain the
    /// newest transitions are known before the step ends.
    fn plan_and_finish_steps<E: Environment>(
        &mut self,
        environments: &mut [E],
        active: &[usize],
        actions: &[Action],
        begun: Vec<E::PendingStep>,
    ) -> Result<Vec<Step>, TrainingError<E::Error>> {
        let ReplaySettings { planning_steps, update_interval, .. } = self.learner.settings.replay;
        let intervals = |steps: u64| steps / update_interval.max(1) as u64;
        let total = self.progress.total_steps;
        let due = intervals(total + active.len() as u64) - intervals(total);
        let updates = due as usize * planning_steps;
        // The losses count for the episodes in turn; with an interval, not all of them have an
        // update in each step.
        let turn = if update_interval > 1 { intervals(total) as usize } else { 0 };
        let mut begun = Some(begun);
        let mut finished: Option<Vec<Step>> = None;
        while self.updates_made() < updates {
            let before = self.learner.replay_random.clone();
            let more = if begun.is_some() { active.len() } else { 0 };
            let is_sampled = self.learner.sample(more);
            if is_sampled
                && self.learner.batch_needs_next(more)
                && let Some(begun) = begun.take()
            {
                let steps = finish_steps(environments, active, begun).inspect_err(|_| {
                    // The update is performed after the training run resumes, and must sample the
                    // same batch.
                    self.learner.replay_random = before;
                })?;
                self.store(active, actions, &steps);
                finished = Some(steps);
            }
            if is_sampled {
                let turn = turn + self.updates_made() / planning_steps;
                self.update(active[turn % active.len()])?;
            }
            if let Some(begun) = &mut self.progress.begun {
                begun.updates += 1;
            }
        }
        if let Some(begun) = begun {
            let steps = finish_steps(environments, active, begun)?;
            self.store(active, actions, &steps);
            finished = Some(steps);
        }
        Ok(finished.unwrap_or_default())
    }

    /// Stores the transitions of a step.
    fn store(&mut self, active: &[usize], actions: &[Action], steps: &[Step]) {
        for ((index, action), step) in active.iter().zip(actions).zip(steps) {
            let current = self.progress.current[*index].as_mut();
            // Active environments have a current episode, whose image was set by the reset.
            if let Some(image) = current.and_then(|current| current.image.as_mut()) {
                *image = self.learner.store(*image, *action, step);
            }
        }
    }

    /// Returns the number of updates already performed or skipped during the step.
    fn updates_made(&self) -> usize {
        self.progress.begun.as_ref().map_or(0, |begun| begun.updates as usize)
    }

    /// Performs an update and adds its loss to the current episode of an environment.
    fn update<E>(&mut self, index: usize) -> Result<(), TrainingError<E>> {
        let started = Instant::now();
        self.learner.set_progress(f64::from(self.episode()) / f64::from(self.plan.episodes));
        let loss = self.learner.update();
        if !loss.is_finite() {
            return Err(TrainingError::Diverged { loss, episode: self.episode() });
        }
        self.progress.updates += 1;
        self.progress.update_time += started.elapsed();
        if let Some(current) = &mut self.progress.current[index] {
            current.loss_sum += f64::from(loss);
            current.losses += 1;
        }
        Ok(())
    }

    /// Adds the record of a finished episode.
    fn record(&mut self, ended: CurrentEpisode, terminated: bool) {
        let record = EpisodeRecord {
            episode: ended.episode,
            steps: ended.actions.len() as u32,
            episode_return: ended.episode_return,
            epsilon: self.epsilon_of(ended.episode),
            loss: (ended.losses > 0).then(|| ended.loss_sum / f64::from(ended.losses)),
            blocked: ended.blocked,
            terminated,
        };
        self.progress.records.push(record);
    }
}

impl Progress {
    /// Starts the next episode, if there is one.
    fn next_episode(&mut self, episodes: u32) -> Option<CurrentEpisode> {
        (self.next_episode < episodes).then(|| {
            let episode = self.next_episode;
            self.next_episode += 1;
            CurrentEpisode { episode, ..CurrentEpisode::default() }
        })
    }
}

/// Finishes the steps of all active environments. If one fails, none of the steps are stored.
fn finish_steps<E: Environment>(
    environments: &mut [E],
    active: &[usize],
    begun: Vec<E::PendingStep>,
) -> Result<Vec<Step>, TrainingError<E::Error>> {
    let finish = |(index, step): (&usize, E::PendingStep)| environments[*index].finish_step(step);
    let steps = active.iter().zip(begun).map(finish).collect::<Result<_, _>>();
    steps.map_err(TrainingError::Environment)
}

#[cfg(test)]
mod tests;
