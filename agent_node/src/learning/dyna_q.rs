//! The learner: two networks, a memory, and what is done with them at each step.

use candle_core::{D, Device, Result, Tensor};
use rand::{Rng, RngExt};
use rand_chacha::ChaCha8Rng;

use super::{
    action::Action,
    adam::Adam,
    image::Image,
    network::QNetwork,
    replay_memory::ReplayMemory,
    seeds::{self, Sequence},
    settings::Settings,
};

/// What the agent does in a state, and why.
#[derive(Clone, Debug, PartialEq)]
pub struct Decision {
    /// The action.
    pub action: Action,
    /// The values that the training network gives the seven actions; none if this repeats a decision
    /// of before, which nobody needs to hear of again.
    pub values: Option<[f32; Action::COUNT]>,
    /// Whether chance chose the action, and not its value.
    pub explored: bool,
}

/// Deep Dyna-Q.
#[derive(Debug)]
pub struct DynaQ {
    pub(super) settings: Settings,
    /// `w_train`
    pub(super) train: QNetwork,
    /// `w_target`
    pub(super) target: QNetwork,
    pub(super) adam: Adam,
    pub(super) memory: ReplayMemory,
    pub(super) exploration_random: ChaCha8Rng,
    pub(super) replay_random: ChaCha8Rng,
}

/// A batch of experiences as the update takes it.
struct Batch {
    /// `[batch, 420]`
    states: Tensor,
    /// `[batch, 420]`
    next_states: Tensor,
    /// `[batch, 1]`, indices of actions
    actions: Tensor,
    /// `[batch]`
    rewards: Tensor,
    /// `[batch]`: gamma, or 0 where there is nothing to bootstrap from
    discounts: Tensor,
}

impl DynaQ {
    /// A learner that knows nothing; its target network starts as a copy of the training network.
    pub fn new(settings: Settings, seed: u64) -> Result<DynaQ> {
        let mut random = seeds::sequence(seed, Sequence::Weights);
        let train = QNetwork::new(&settings.hidden_layers, &mut random)?;
        let target = train.copied()?;
        let betas = (settings.adam_beta1, settings.adam_beta2);
        let adam =
            Adam::new(train.variables(), settings.learning_rate, betas, settings.adam_epsilon)?;
        Ok(DynaQ {
            memory: ReplayMemory::new(settings.memory_capacity),
            exploration_random: seeds::sequence(seed, Sequence::Exploration),
            replay_random: seeds::sequence(seed, Sequence::Replay),
            settings,
            train,
            target,
            adam,
        })
    }

    /// Chooses an action: with probability epsilon any of the seven alike, otherwise the best.
    pub fn act(&mut self, state: &Image, epsilon: f64) -> Result<Decision> {
        let values = self.train.values(state)?;
        let explored = self.exploration_random.random::<f64>() < epsilon;
        let action = match explored {
            true => random_action(&mut self.exploration_random),
            false => Action::greatest(&values),
        };
        Ok(Decision { action, values: Some(values), explored })
    }

    /// The first state of an episode.
    pub fn begin_episode(&mut self, state: &Image) {
        self.memory.begin_episode(state);
    }

    /// Stores the experience `(s, a, s', R)`; `s` is the state that was stored last.
    pub fn remember(&mut self, action: Action, reward: f32, terminated: bool, next_state: &Image) {
        self.memory.store(action, reward, terminated, next_state);
    }

    /// Experience replay: one update of the training network from a batch of memories. Returns the
    /// loss, or `None` while there are too few memories.
    pub fn plan(&mut self) -> Result<Option<f32>> {
        match self.draw() {
            Some(indices) => self.update(&indices).map(Some),
            None => Ok(None),
        }
    }

    /// Draws the batch of an update.
    pub(super) fn draw(&mut self) -> Option<Vec<usize>> {
        self.memory.draw(self.settings.batch_size, false, &mut self.replay_random)
    }

    /// Draws the batch of the update that follows the next experience, which is not there yet.
    pub(super) fn draw_ahead(&mut self) -> Option<Vec<usize>> {
        self.memory.draw(self.settings.batch_size, true, &mut self.replay_random)
    }

    /// One update of the training network from the experiences with these indices. Nothing is
    /// changed if the loss is not finite.
    pub(super) fn update(&mut self, indices: &[usize]) -> Result<f32> {
        let batch = self.batch(indices)?;
        let loss = loss(&self.train, &self.target, &batch)?;
        let value: f32 = loss.to_scalar()?;
        if value.is_finite() {
            self.adam.update(&loss.backward()?)?;
        }
        Ok(value)
    }

    /// Moves the target network towards the training network (eq. 6).
    pub fn end_episode(&mut self) -> Result<()> {
        self.target.move_towards(&self.train, self.settings.target_update as f32)
    }

    /// The network that is being trained.
    pub fn network(&self) -> &QNetwork {
        &self.train
    }

    fn batch(&self, indices: &[usize]) -> Result<Batch> {
        let size = indices.len();
        let mut states = vec![0.0; size * Image::BYTES];
        let mut next_states = vec![0.0; size * Image::BYTES];
        let mut actions = Vec::with_capacity(size);
        let mut rewards = Vec::with_capacity(size);
        let mut discounts = Vec::with_capacity(size);
        let rows = states.chunks_exact_mut(Image::BYTES);
        let next_rows = next_states.chunks_exact_mut(Image::BYTES);
        for ((row, next_row), index) in rows.zip(next_rows).zip(indices) {
            let experience = self.memory.get(*index);
            Image::write_input(self.memory.image(experience.state), row);
            Image::write_input(self.memory.image(experience.next_state), next_row);
            actions.push(u32::from(experience.action.index()));
            rewards.push(experience.reward);
            discounts.push(if experience.terminated { 0.0 } else { self.settings.discount as f32 });
        }
        let device = &Device::Cpu;
        Ok(Batch {
            states: Tensor::from_vec(states, (size, Image::BYTES), device)?,
            next_states: Tensor::from_vec(next_states, (size, Image::BYTES), device)?,
            actions: Tensor::from_vec(actions, (size, 1), device)?,
            rewards: Tensor::from_vec(rewards, size, device)?,
            discounts: Tensor::from_vec(discounts, size, device)?,
        })
    }
}

/// The mean over the batch of `(R + gamma max_a' Q(s', a'; w_target) - Q(s, a; w_train))^2` (eq. 5).
fn loss(train: &QNetwork, target: &QNetwork, batch: &Batch) -> Result<Tensor> {
    let best_next = target.forward(&batch.next_states)?.max(D::Minus1)?.detach();
    let targets = (&batch.rewards + (&batch.discounts * best_next)?)?;
    let values = train.forward(&batch.states)?.gather(&batch.actions, 1)?.squeeze(1)?;
    (targets - values)?.sqr()?.mean_all()
}

fn random_action(random: &mut impl Rng) -> Action {
    let index = random.random_range(0..Action::COUNT as u8);
    Action::try_from(index).expect("the range is that of the actions")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::learning::settings::Preset;

    fn image(brightness: u8) -> Image {
        Image::try_from([brightness; Image::BYTES].as_slice()).unwrap()
    }

    fn action(index: u8) -> Action {
        Action::try_from(index).unwrap()
    }

    /// A learner with a memory of one step, `terminated` or not.
    fn learner_after_one_step(terminated: bool) -> DynaQ {
        let settings = Settings { batch_size: 1, ..Preset::Paper.settings() };
        let mut learner = DynaQ::new(settings, 5).unwrap();
        learner.train.randomize(1);
        learner.target.randomize(2);
        learner.begin_episode(&image(50));
        learner.remember(action(2), -0.1, terminated, &image(200));
        learner
    }

    #[test]
    fn the_loss_is_equation_5_and_bootstraps_unless_terminated() {
        for terminated in [false, true] {
            let mut learner = learner_after_one_step(terminated);
            let value = learner.train.values(&image(50)).unwrap()[2];
            let next = learner.target.values(&image(200)).unwrap();
            let best = next.iter().copied().fold(f32::MIN, f32::max);
            let target = if terminated { -0.1 } else { -0.1 + 0.999 * best };
            let expected = (target - value).powi(2);
            let loss = learner.plan().unwrap().unwrap();
            assert!((loss - expected).abs() < 1e-5 * expected.max(1.0), "{loss} {expected}");
        }
    }

    #[test]
    fn an_update_moves_the_value_towards_its_target_and_leaves_the_target_network() {
        let mut learner = learner_after_one_step(true);
        let target_before = learner.target.values(&image(50)).unwrap();
        let error = |learner: &DynaQ| (learner.train.values(&image(50)).unwrap()[2] + 0.1).abs();
        let before = error(&learner);
        for _ in 0..20 {
            learner.plan().unwrap();
        }
        assert!(error(&learner) < before);
        assert_eq!(learner.target.values(&image(50)).unwrap(), target_before);
        learner.end_episode().unwrap();
        assert_ne!(learner.target.values(&image(50)).unwrap(), target_before);
    }

    #[test]
    fn no_update_before_the_batch_can_be_filled() {
        let mut learner = DynaQ::new(Preset::Paper.settings(), 5).unwrap();
        learner.begin_episode(&image(0));
        for step in 1..=50 {
            assert_eq!(learner.plan().unwrap(), None);
            learner.remember(action(0), -0.1, false, &image(step));
        }
        assert!(learner.plan().unwrap().is_some());
    }

    #[test]
    fn epsilon_one_explores_every_action_alike_and_zero_never_explores() {
        let mut learner = DynaQ::new(Preset::Paper.settings(), 5).unwrap();
        let mut counts = [0; Action::COUNT];
        for _ in 0..7000 {
            let decision = learner.act(&image(9), 1.0).unwrap();
            assert!(decision.explored);
            counts[usize::from(decision.action.index())] += 1;
        }
        assert!(counts.iter().all(|count| (880..1120).contains(count)), "{counts:?}");
        for _ in 0..100 {
            let decision = learner.act(&image(9), 0.0).unwrap();
            assert!(!decision.explored);
            assert_eq!(decision.action, Action::greatest(&decision.values.unwrap()));
        }
    }

    #[test]
    fn the_target_network_starts_as_the_training_network() {
        let learner = DynaQ::new(Preset::Paper.settings(), 5).unwrap();
        let (train, target) = (&learner.train, &learner.target);
        assert_eq!(train.values(&image(3)).unwrap(), target.values(&image(3)).unwrap());
    }
}
