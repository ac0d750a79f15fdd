//! The training loop (the paper's Figure 2), in one room or in several at once.

use std::{
    num::NonZeroU64,
    time::{Duration, Instant},
};

use serde::{Deserialize, Serialize};
use task::{
    Action, Environment, Step,
    seeds::{Purpose, episode_scenario, episode_seed},
};
use thiserror::Error;

use super::{
    dyna_q::{Decision, DynaQ},
    perceptron::Arch,
    policy::Policy,
    record::{EpisodeRecord, Records},
    settings::Settings,
};

/// What a training is of, apart from the method's own numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// The scenario of every reset, or [`MIXED`](task::seeds::MIXED).
    pub scenario: String,
    /// `e_total` of eq. 4.
    pub episodes: u32,
    /// The seed of the run.
    pub seed: u64,
    /// How many rooms the agent learns in at once. They take a step each in turn; an episode that
    /// ends is followed by the next one that no room has begun.
    pub rooms: usize,
}

/// Why a training does not go on.
#[derive(Debug, Error)]
pub enum TrainingError<E> {
    /// The room does not answer as it should.
    #[error(transparent)]
    Environment(E),
    /// After an interruption the room is not what it was.
    #[error(
        "the room does not repeat itself: step {step} of the episode with seed {seed} shows another \
         image than before; was it started with other parameters?"
    )]
    NotRepeatable {
        /// The step, 0 for the reset.
        step: usize,
        /// The episode's seed.
        seed: NonZeroU64,
    },
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
    /// One record per finished episode; in a checkpoint they lie apart.
    #[serde(skip)]
    pub records: Records,
    /// Steps of all episodes, the unfinished one included.
    pub total_steps: u64,
    /// Updates of the training network.
    pub updates: u64,
    /// Time from the first reset to the last update, interruptions left out.
    pub wall: Duration,
    /// Time spent in updates.
    pub update_time: Duration,
    /// The first episode that no room has begun.
    pub next_episode: u32,
    /// The unfinished episode of each room; none where there are no more.
    pub current: Vec<Option<CurrentEpisode>>,
    /// The step that was begun in every room, if its end has not been seen.
    pub begun: Option<BegunStep>,
}

/// An episode under way.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CurrentEpisode {
    /// Its number.
    pub episode: u32,
    /// The number of the image that the robot sees; none before the first.
    pub image: Option<u64>,
    /// The actions taken so far. With the seed they bring the room back to this state.
    pub actions: Vec<Action>,
    /// The sum of the rewards so far.
    pub episode_return: f32,
    /// Sum and number of the losses so far.
    pub loss_sum: f64,
    /// How many losses the sum is of.
    pub losses: u32,
    /// Blocked moves so far.
    pub blocked: u32,
}

/// A step under way.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BegunStep {
    /// The action in each room that has an episode.
    pub actions: Vec<Action>,
    /// Updates that belong to it and are made already.
    pub updates: u32,
}

/// Who wants to know how the training goes.
pub trait Listener {
    /// The agent has decided what the robot in a room, counted from 0, is to do next.
    fn decision(&mut self, _room: usize, _decision: &Decision) {}

    /// An episode has ended.
    fn episode(&mut self, training: &Training, record: &EpisodeRecord) -> anyhow::Result<()>;
}

/// A training: the plan, the learner and how far they are.
#[derive(Clone, Debug)]
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
        let learner = DynaQ::new(settings, plan.seed, plan.rooms)?;
        let mut progress = Progress::default();
        for _ in 0..plan.rooms {
            let next = progress.next_episode(plan.episodes);
            progress.current.push(next);
        }
        Ok(Training { plan, progress, learner })
    }

    /// As [`DynaQ::set_arch`].
    pub fn set_arch(&mut self, arch: Arch) {
        self.learner.set_arch(arch);
    }

    /// The learner.
    pub fn learner(&self) -> &DynaQ {
        &self.learner
    }

    /// What has been learned so far, at work.
    pub fn policy(&self) -> Result<Policy, candle_core::Error> {
        Policy::new(&self.learner.network().network()?, &self.learner.settings)
    }

    /// How many episodes have ended; in one room, the number of the present one.
    pub fn episode(&self) -> u32 {
        self.progress.records.len() as u32
    }

    fn epsilon_of(&self, episode: u32) -> f64 {
        self.learner.settings.exploration.epsilon.epsilon(episode, self.plan.episodes)
    }

    /// Steps per second of wall time, so far.
    pub fn steps_per_s(&self) -> f64 {
        self.progress.total_steps as f64 / self.progress.wall.as_secs_f64().max(f64::MIN_POSITIVE)
    }

    /// Mean time of an update in microseconds; 0 before the first.
    pub fn update_us(&self) -> f64 {
        self.progress.update_time.as_secs_f64() * 1e6 / self.progress.updates.max(1) as f64
    }

    /// Trains until all episodes are done. After an error of a room, [`super::checkpoint`] can save
    /// the training, and `run` goes on from there as if nothing had happened.
    ///
    /// # Errors
    ///
    /// A room fails or does not repeat itself, the training diverges, or the listener fails.
    ///
    /// # Panics
    ///
    /// There must be as many rooms as the plan says.
    pub fn run<E: Environment>(
        &mut self,
        rooms: &mut [E],
        listener: &mut impl Listener,
    ) -> Result<(), TrainingError<E::Error>> {
        assert_eq!(rooms.len(), self.plan.rooms, "the training is for another number of rooms");
        let mut counted = Instant::now();
        // The reset under way in each room whose episode has not begun there.
        let mut resets: Vec<Option<E::PendingReset>> = rooms.iter().map(|_| None).collect();
        let all: Vec<usize> = (0..rooms.len()).collect();
        self.begin_resets(rooms, &all, &mut resets)?;
        while self.progress.current.iter().any(Option::is_some) {
            self.finish_resets(rooms, &mut resets)?;
            let ended = self.step(rooms, listener)?;
            self.progress.wall += counted.elapsed();
            counted = Instant::now();
            if !ended.is_empty() {
                // While the rooms make themselves ready, there is time to tell of the episodes.
                self.begin_resets(rooms, &ended, &mut resets)?;
                for record in self.progress.records.recent(ended.len()) {
                    listener.episode(self, record)?;
                }
            }
        }
        Ok(())
    }

    /// Asks some of the rooms for the episodes that they have next, if they have one.
    fn begin_resets<E: Environment>(
        &self,
        rooms: &mut [E],
        which: &[usize],
        resets: &mut [Option<E::PendingReset>],
    ) -> Result<(), TrainingError<E::Error>> {
        for &room in which {
            if let Some(CurrentEpisode { episode, .. }) = self.progress.current[room] {
                let Plan { scenario, seed, .. } = &self.plan;
                let scenario = episode_scenario(scenario, Purpose::Training, *seed, episode);
                let reset = rooms[room].begin_reset(self.seed_of(episode), scenario);
                resets[room] = Some(reset.map_err(TrainingError::Environment)?);
            }
        }
        Ok(())
    }

    fn seed_of(&self, episode: u32) -> NonZeroU64 {
        episode_seed(Purpose::Training, self.plan.seed, episode)
    }

    /// Waits for the rooms that were asked for an episode.
    fn finish_resets<E: Environment>(
        &mut self,
        rooms: &mut [E],
        resets: &mut [Option<E::PendingReset>],
    ) -> Result<(), TrainingError<E::Error>> {
        for (index, (room, reset)) in rooms.iter_mut().zip(resets).enumerate() {
            let (Some(reset), Some(current)) = (reset.take(), &self.progress.current[index]) else {
                continue;
            };
            let seed = self.seed_of(current.episode);
            let mut image = room.finish_reset(reset).map_err(TrainingError::Environment)?;
            // An interrupted episode: the room is brought back to where it was.
            for (step, action) in current.actions.iter().enumerate() {
                let again = room.step(*action).map_err(TrainingError::Environment)?;
                image = again.image;
                if again.terminated || again.truncated {
                    return Err(TrainingError::NotRepeatable { step: step + 1, seed });
                }
            }
            let number = match current.image {
                None => self.learner.begin_episode(&image),
                Some(number) if self.learner.memory.frame(number).image == *image.bytes() => number,
                Some(_) => {
                    let step = current.actions.len();
                    return Err(TrainingError::NotRepeatable { step, seed });
                }
            };
            if let Some(current) = &mut self.progress.current[index] {
                current.image = Some(number);
            }
        }
        Ok(())
    }

    /// One step in every room that has an episode. Returns the rooms whose episodes it ended.
    fn step<E: Environment>(
        &mut self,
        rooms: &mut [E],
        listener: &mut impl Listener,
    ) -> Result<Vec<usize>, TrainingError<E::Error>> {
        let current = &self.progress.current;
        let active: Vec<usize> =
            (0..current.len()).filter(|index| current[*index].is_some()).collect();
        // At time t the agent observes s_t and chooses a_t, unless it had chosen before it was
        // interrupted,
        let actions = match &self.progress.begun {
            Some(begun) => begun.actions.clone(),
            None => {
                let seen: Vec<(u64, f64)> = current
                    .iter()
                    .flatten()
                    .filter_map(|current| Some((current.image?, self.epsilon_of(current.episode))))
                    .collect();
                let decisions = self.learner.act(&seen);
                for (room, decision) in active.iter().zip(&decisions) {
                    listener.decision(*room, decision);
                }
                let actions: Vec<Action> =
                    decisions.iter().map(|decision| decision.action).collect();
                self.progress.begun = Some(BegunStep { actions: actions.clone(), updates: 0 });
                actions
            }
        };
        // then transitions to s_t+1 and receives R_t+1. Experience replay is performed every time
        // the agent takes a step: it begins while the room is at work.
        let begin = |(room, action): (&usize, &Action)| rooms[*room].begin_step(*action);
        let begun = active.iter().zip(&actions).map(begin).collect::<Result<Vec<_>, _>>();
        let begun = begun.map_err(TrainingError::Environment)?;
        let steps = self.plan_and_finish_steps(rooms, &active, &actions, begun)?;
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
                // The target network follows at the end of each episode.
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

    /// Makes the updates of a step, and waits for its end where one of them needs its experience.
    ///
    /// The result is that of remembering first and updating then: what a batch holds follows from the
    /// length that the memory will have, so a batch without the newest experiences is known before.
    fn plan_and_finish_steps<E: Environment>(
        &mut self,
        rooms: &mut [E],
        active: &[usize],
        actions: &[Action],
        begun: Vec<E::PendingStep>,
    ) -> Result<Vec<Step>, TrainingError<E::Error>> {
        let planning_steps = self.learner.settings.replay.planning_steps;
        let mut begun = Some(begun);
        let mut finished: Option<Vec<Step>> = None;
        while self.updates_made() < planning_steps * active.len() {
            let before = self.learner.replay_random.clone();
            let more = if begun.is_some() { active.len() } else { 0 };
            let is_drawn = self.learner.draw(more);
            if is_drawn
                && self.learner.batch_needs_next(more)
                && let Some(begun) = begun.take()
            {
                let steps = finish_steps(rooms, active, begun).inspect_err(|_| {
                    // The update was not made: made later, it must be the same one.
                    self.learner.replay_random = before;
                })?;
                self.remember(active, actions, &steps);
                finished = Some(steps);
            }
            if is_drawn {
                self.update(active[self.updates_made() / planning_steps])?;
            }
            if let Some(begun) = &mut self.progress.begun {
                begun.updates += 1;
            }
        }
        if let Some(begun) = begun {
            let steps = finish_steps(rooms, active, begun)?;
            self.remember(active, actions, &steps);
            finished = Some(steps);
        }
        Ok(finished.unwrap_or_default())
    }

    fn remember(&mut self, active: &[usize], actions: &[Action], steps: &[Step]) {
        for ((index, action), step) in active.iter().zip(actions).zip(steps) {
            let current = self.progress.current[*index].as_mut();
            // It is there, and has an image, since the room was reset.
            if let Some(image) = current.and_then(|current| current.image.as_mut()) {
                *image = self.learner.remember(*image, *action, step);
            }
        }
    }

    fn updates_made(&self) -> usize {
        self.progress.begun.as_ref().map_or(0, |begun| begun.updates as usize)
    }

    /// An update, on account of the episode in a room.
    fn update<E>(&mut self, room: usize) -> Result<(), TrainingError<E>> {
        let started = Instant::now();
        self.learner.set_progress(f64::from(self.episode()) / f64::from(self.plan.episodes));
        let loss = self.learner.update();
        if !loss.is_finite() {
            return Err(TrainingError::Diverged { loss, episode: self.episode() });
        }
        self.progress.updates += 1;
        self.progress.update_time += started.elapsed();
        if let Some(current) = &mut self.progress.current[room] {
            current.loss_sum += f64::from(loss);
            current.losses += 1;
        }
        Ok(())
    }

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
    /// Takes the next episode that no room has begun, if there is one.
    fn next_episode(&mut self, episodes: u32) -> Option<CurrentEpisode> {
        (self.next_episode < episodes).then(|| {
            let episode = self.next_episode;
            self.next_episode += 1;
            CurrentEpisode { episode, ..CurrentEpisode::default() }
        })
    }
}

/// The ends of the steps of all rooms, or none: an error must leave no half of them behind.
fn finish_steps<E: Environment>(
    rooms: &mut [E],
    active: &[usize],
    begun: Vec<E::PendingStep>,
) -> Result<Vec<Step>, TrainingError<E::Error>> {
    let finish = |(room, step): (&usize, E::PendingStep)| rooms[*room].finish_step(step);
    let steps = active.iter().zip(begun).map(finish).collect::<Result<_, _>>();
    steps.map_err(TrainingError::Environment)
}

#[cfg(test)]
mod tests;
