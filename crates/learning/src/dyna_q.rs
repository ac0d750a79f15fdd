//! The learner: chooses actions, stores transitions and updates the networks.

use candle_core::Result;
use pulp::Arch;
use task::{Action, Image, Random, Step};

use super::{
    activations::Activations,
    architectures::backend,
    backend::{Backend, Network},
    greedy::{ActionSet, greedy_action},
    observation::Augmentation,
    priorities::Priorities,
    replay_memory::ReplayMemory,
    sequence::Sequence,
    settings::{OptimizerSettings, ReplaySettings, Settings, TargetUpdate},
    valuation::Valuation,
};

/// The action for a state, and how it was chosen.
#[derive(Clone, Debug, PartialEq)]
pub struct Decision {
    /// The chosen action.
    pub action: Action,
    /// The values of the seven actions according to the network.
    pub values: [f32; Action::COUNT],
    /// Whether the action is random; otherwise it is greedy.
    pub explored: bool,
}

/// A deep Dyna-Q learner.
///
/// It does not step environments itself; [`Training`](crate::training::Training) runs the loop.
/// Images are referred to by their numbers in the replay memory.
///
/// # Examples
///
/// One step of the loop:
///
/// ```
/// use learning::{dyna_q::DynaQ, settings::Preset};
/// use task::{Image, STEP_REWARD, Step};
///
/// let settings = Preset::Paper.settings().with(|s| s.replay.batch_size = 1);
/// let mut learner = DynaQ::new(settings, 1, 1)?;
/// let image = Image::try_from(vec![0u8; Image::BYTES])?;
/// let state = learner.begin_episode(&image);
///
/// let epsilon = 0.5;
/// let decision = learner.act(&[(state, epsilon)]).remove(0);
/// let (terminated, truncated, blocked) = (false, true, false);
/// let step = Step { image, reward: STEP_REWARD, terminated, truncated, blocked };
/// learner.store(state, decision.action, &step);
/// let loss = learner.plan();
/// assert!(loss.is_some());
/// learner.end_episode();
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct DynaQ {
    pub(super) settings: Settings,
    pub(super) backend: Box<dyn Backend>,
    pub(super) memory: ReplayMemory,
    /// The priorities of the stored transitions; `None` with uniform sampling.
    pub(super) priorities: Option<Priorities>,
    pub(super) exploration_random: Random,
    pub(super) replay_random: Random,
    /// The buffers for the forward pass over the current states, one state per environment.
    valuation: Valuation,
    /// The buffers for a forward pass over a batch.
    pub(super) batch_activations: Activations,
    /// The replay memory indices of the latest batch, `[batch]`.
    pub(super) batch: Vec<usize>,
    /// `R + gamma Q(s', a'; w_target)` for each transition of the batch.
    targets: Vec<f32>,
    /// `a'`, the best action in the next state of each transition of the batch.
    choices: Vec<Action>,
    /// The augmentation of each transition of the batch.
    pub(super) augmentations: Vec<Augmentation>,
    /// The importance-sampling weight of each transition of the batch; 1 with uniform sampling.
    weights: Vec<f32>,
    /// The progress of training, 0 to 1.
    progress: f64,
}

impl DynaQ {
    /// Creates a learner with random weights and an empty replay memory, for `environments`
    /// interleaved environments. `seed` is the seed of the run.
    ///
    /// # Errors
    ///
    /// Returns an error if the settings do not describe a valid network.
    pub fn new(settings: Settings, seed: u64, environments: usize) -> Result<DynaQ> {
        let mut random = Sequence::Weights.random(seed);
        let frames = settings.network.observation_frames;
        let backend = backend(&settings, &mut random)?;
        let ReplaySettings { capacity, batch_size: batch, priority_exponent, .. } = settings.replay;
        let is_prioritized = priority_exponent > 0.0;
        let avoid_repetition = settings.exploration.avoid_repetition;
        Ok(DynaQ {
            memory: ReplayMemory::new(capacity, environments, frames, avoid_repetition),
            priorities: is_prioritized.then(|| Priorities::new(priority_exponent)),
            exploration_random: Sequence::Exploration.random(seed),
            replay_random: Sequence::Replay.random(seed),
            valuation: Valuation::new(
                backend.train(),
                frames,
                settings.replay.mirror,
                environments,
            ),
            settings,
            batch_activations: backend.train().activations(batch),
            batch: vec![0; batch],
            targets: vec![0.0; batch],
            choices: vec![Action::default(); batch],
            augmentations: vec![Augmentation::NONE; batch],
            weights: vec![1.0; batch],
            progress: 0.0,
            backend,
        })
    }

    /// Selects the vector instructions to use; by default, the widest that the processor supports.
    /// This does not change the results of the kernels ([`arches`](crate::perceptron::arches)).
    pub fn set_arch(&mut self, arch: Arch) {
        self.backend.set_arch(arch);
        self.valuation.set_arch(arch);
        self.batch_activations.set_arch(arch);
    }

    /// Chooses an action in each environment (epsilon-greedy).
    ///
    /// Each element of `states` consists of the image number of a state and the value of epsilon.
    /// With probability epsilon, the action is uniformly random; otherwise, it is the action with
    /// the highest value. Actions excluded by
    /// [`avoid_repetition`](crate::settings::ExplorationSettings::avoid_repetition) are never
    /// chosen. `states` must not contain more than one state per environment.
    pub fn act(&mut self, states: &[(u64, f64)]) -> Vec<Decision> {
        let memory = &self.memory;
        let pasts = states.iter().map(|(state, _)| memory.past(*state));
        let values = self.valuation.of(self.backend.train(), pasts);
        let random = &mut self.exploration_random;
        let decide = |((state, epsilon), values): (&(u64, f64), [f32; Action::COUNT])| {
            let excluded = memory.frame(*state).tried;
            let explored = random.chance(*epsilon);
            let action = match explored {
                true => random_action(random, excluded),
                false => greedy_action(&values, excluded),
            };
            Decision { action, values, explored }
        };
        states.iter().zip(values).map(decide).collect()
    }

    /// Stores the first image of an episode and returns its number.
    pub fn begin_episode(&mut self, state: &Image) -> u64 {
        self.memory.begin_episode(state)
    }

    /// Stores the transition `(s, a, s', R)`, where `state` is the number of `s`, and returns the
    /// number of `s'`.
    ///
    /// # Panics
    ///
    /// Panics if no image with the number `state` is stored.
    pub fn store(&mut self, state: u64, action: Action, step: &Step) -> u64 {
        let penalty = if step.blocked { self.settings.replay.blocked_reward as f32 } else { 0.0 };
        self.announce(1);
        self.memory.store(state, action, step.reward + penalty, step.terminated, &step.image)
    }

    /// Performs experience replay: updates the training network from a batch of stored transitions.
    /// Returns the loss, or `None` if there are too few transitions.
    pub fn plan(&mut self) -> Option<f32> {
        self.sample(0).then(|| self.update())
    }

    /// Assigns the priority of a new transition to each of the next `more` transitions, before they
    /// are stored.
    fn announce(&mut self, more: usize) {
        if let Some(priorities) = &mut self.priorities {
            self.memory.next_indices(more).for_each(|index| priorities.announce(index));
        }
    }

    /// Samples the batch for an update, and its augmentations. Returns false if there are too few
    /// transitions.
    ///
    /// The batch is sampled as if `more` further transitions had already been stored.
    pub(super) fn sample(&mut self, more: usize) -> bool {
        self.announce(more);
        let random = &mut self.replay_random;
        let is_sampled = match &self.priorities {
            None => self.memory.sample(&mut self.batch, more, random),
            Some(priorities) => {
                let is_enough = self.memory.len_with(more) >= self.batch.len();
                if is_enough {
                    priorities.sample(&mut self.batch, random);
                }
                is_enough
            }
        };
        let observation_frames = self.settings.network.observation_frames;
        let ReplaySettings { mirror, history_dropout, .. } = self.settings.replay;
        // Without augmentation, no random numbers are drawn.
        if is_sampled && (mirror || history_dropout > 0.0) {
            for augmentation in &mut self.augmentations {
                augmentation.mirrored = mirror && random.chance(0.5);
                augmentation.frames = match random.chance(history_dropout) {
                    true => 1 + random.below(observation_frames),
                    false => observation_frames,
                };
            }
        }
        is_sampled
    }

    /// Returns whether the batch contains any of the next `more` transitions to be stored.
    pub(super) fn batch_needs_next(&self, more: usize) -> bool {
        self.batch.iter().any(|index| self.memory.is_among_next(*index, more))
    }

    /// Updates the training network from the sampled batch and, with [`TargetUpdate::Update`], the
    /// target network. Returns the loss: the mean of
    /// `(R + gamma Q(s', a'; w_target) - Q(s, a; w_train))^2` over the batch (eq. 5), where `a'` is
    /// the best action in `s'`; with prioritized replay, multiplied by the importance-sampling
    /// weights. If the loss is not finite, the networks are unchanged.
    pub(super) fn update(&mut self) -> f32 {
        if let Some(priorities) = &self.priorities {
            let initial = self.settings.replay.importance_exponent;
            let beta = initial + (1.0 - initial) * self.progress;
            priorities.importance_weights(&self.batch, beta, &mut self.weights);
        }
        let frames = self.settings.network.observation_frames;
        let double_q = self.settings.target.double_q;
        let (memory, activations) = (&self.memory, &mut self.batch_activations);
        memory.fetch(&self.batch);
        let transitions =
            || self.batch.iter().map(|index| memory.get(*index)).zip(&self.augmentations);

        let next_states = transitions()
            .map(|(transition, augmentation)| (memory.past(transition.next_state), *augmentation));
        activations.read_observations(frames, next_states);
        let (train, target) = (self.backend.train(), self.backend.target());
        let selector = if double_q { train } else { target };
        selector.forward(activations);
        for ((choice, values), (transition, augmentation)) in
            self.choices.iter_mut().zip(activations.outputs()).zip(transitions())
        {
            let excluded = augmentation.actions(memory.frame(transition.next_state).tried);
            let (values, _padding) =
                values.split_first_chunk().expect("the output has a value for each action");
            *choice = greedy_action(values, excluded);
        }
        if double_q {
            target.forward(activations);
        }
        for (((target, values), choice), (transition, _)) in
            self.targets.iter_mut().zip(activations.outputs()).zip(&self.choices).zip(transitions())
        {
            let best = values[usize::from(choice.index())];
            let discount =
                if transition.terminated { 0.0 } else { self.settings.target.discount as f32 };
            *target = transition.reward + discount * best;
        }

        let states = transitions()
            .map(|(transition, augmentation)| (memory.past(transition.state), *augmentation));
        activations.read_observations(frames, states);
        train.forward(activations);
        let gradient = self.backend.output_gradient();
        gradient.fill(0.0);
        let mut loss = 0.0;
        let size = self.batch.len() as f32;
        let rows = gradient.chunks_exact_mut(activations.output_width());
        let rows = rows.zip(activations.outputs()).zip(self.targets.iter_mut().zip(&self.weights));
        for (((gradient, values), (target, weight)), (transition, augmentation)) in
            rows.zip(transitions())
        {
            let action = usize::from(augmentation.action(transition.action).index());
            let error = values[action] - *target;
            loss += weight * error * error / size;
            gradient[action] = weight * 2.0 * error / size;
            // The targets are no longer needed; their place is taken by the errors.
            *target = error;
        }
        if let Some(priorities) = &mut self.priorities
            && loss.is_finite()
        {
            for (index, error) in self.batch.iter().zip(&self.targets) {
                priorities.set_error(*index, *error);
            }
        }
        if loss.is_finite() {
            self.backend.update(activations);
            if self.settings.target.update_at == TargetUpdate::Update {
                self.update_target();
            }
        }
        loss
    }

    /// Sets Adam's step size and the exponent of the importance-sampling weights according to the
    /// progress of training, 0 to 1.
    pub fn set_progress(&mut self, progress: f64) {
        self.progress = progress;
        let OptimizerSettings { learning_rate, final_learning_rate_ratio, .. } =
            self.settings.optimizer;
        let final_rate = learning_rate * final_learning_rate_ratio;
        self.backend.set_learning_rate(learning_rate + (final_rate - learning_rate) * progress);
    }

    /// Ends an episode and, with [`TargetUpdate::Episode`], updates the target network.
    pub fn end_episode(&mut self) {
        if self.settings.target.update_at == TargetUpdate::Episode {
            self.update_target();
        }
    }

    /// Moves the target network towards the training network (eq. 6).
    fn update_target(&mut self) {
        self.backend.update_target(self.settings.target.rate as f32);
    }

    /// Returns the training network.
    pub fn network(&self) -> &dyn Network {
        self.backend.train()
    }
}

/// Returns a uniformly random action that is not excluded.
fn random_action(random: &mut Random, excluded: ActionSet) -> Action {
    let count = Action::COUNT - excluded.len();
    let index = random.below(count.max(1));
    let mut allowed = Action::ALL.into_iter().filter(|action| !excluded.contains(*action));
    allowed.nth(index).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{policy::Policy, settings::Preset};

    fn image(brightness: u8) -> Image {
        Image::try_from([brightness; Image::BYTES].as_slice()).unwrap()
    }

    fn values(network: &dyn Network, image: &Image) -> [f32; Action::COUNT] {
        let mut policy = Policy::new(network.clone_box(), &Preset::Paper.settings());
        policy.begin(image.clone());
        policy.decide().values
    }

    fn action(index: u8) -> Action {
        Action::try_from(index).unwrap()
    }

    fn step(image: Image, terminated: bool) -> Step {
        Step { image, reward: -0.1, terminated, truncated: false, blocked: false }
    }

    /// Gives the training network and the target network different random weights.
    fn randomize(backend: &mut dyn Backend) {
        let mut random = Random::from_key([1; 4]);
        for (_, network) in backend.networks_mut().into_iter().take(2) {
            let tensors = network.tensors().unwrap().into_iter();
            let tensors = tensors.map(|(name, tensor)| {
                (name, crate::weights::normal(tensor.dims(), 0.1, &mut random).unwrap())
            });
            network.read("", &tensors.collect()).unwrap();
        }
    }

    /// Returns a learner with one stored transition.
    fn learner_after_one_step(terminated: bool) -> DynaQ {
        let settings = Preset::Paper.settings().with(|s| s.replay.batch_size = 1);
        let mut learner = DynaQ::new(settings, 5, 1).unwrap();
        randomize(&mut *learner.backend);
        let state = learner.begin_episode(&image(50));
        learner.store(state, action(2), &step(image(200), terminated));
        learner
    }

    #[test]
    fn the_loss_matches_equation_5_and_bootstraps_unless_terminated() {
        for terminated in [false, true] {
            let mut learner = learner_after_one_step(terminated);
            let value = values(learner.backend.train(), &image(50))[2];
            let next = values(learner.backend.target(), &image(200));
            let best = next.iter().copied().fold(f32::MIN, f32::max);
            let target = if terminated { -0.1 } else { -0.1 + 0.999 * best };
            let expected = (target - value).powi(2);
            let loss = learner.plan().unwrap();
            assert!((loss - expected).abs() < 1e-5 * expected.max(1.0), "{loss}, not {expected}");
        }
    }

    #[test]
    fn an_update_moves_only_the_training_network() {
        let mut learner = learner_after_one_step(true);
        let target_before = values(learner.backend.target(), &image(50));
        let error = |learner: &DynaQ| (values(learner.backend.train(), &image(50))[2] + 0.1).abs();
        let before = error(&learner);
        for _ in 0..20 {
            learner.plan();
        }
        assert!(error(&learner) < before);
        assert_eq!(values(learner.backend.target(), &image(50)), target_before);
        learner.end_episode();
        assert_ne!(values(learner.backend.target(), &image(50)), target_before);
    }

    #[test]
    fn does_not_update_before_a_batch_is_available() {
        let mut learner = DynaQ::new(Preset::Paper.settings(), 5, 1).unwrap();
        let mut state = learner.begin_episode(&image(0));
        for number in 1..=50 {
            assert_eq!(learner.plan(), None);
            state = learner.store(state, action(0), &step(image(number), false));
        }
        assert!(learner.plan().is_some());
    }

    #[test]
    fn explores_uniformly_with_epsilon_1_and_never_with_epsilon_0() {
        let mut learner = DynaQ::new(Preset::Paper.settings(), 5, 1).unwrap();
        let state = learner.begin_episode(&image(9));
        let mut counts = [0; Action::COUNT];
        for _ in 0..7000 {
            let decision = learner.act(&[(state, 1.0)]).remove(0);
            assert!(decision.explored);
            counts[usize::from(decision.action.index())] += 1;
        }
        assert!(counts.iter().all(|count| (880..1120).contains(count)), "{counts:?}");
        for _ in 0..100 {
            let decision = learner.act(&[(state, 0.0)]).remove(0);
            assert!(!decision.explored);
            let best = greedy_action(&decision.values, ActionSet::NONE);
            assert_eq!(decision.action, best);
        }
    }

    #[test]
    fn acting_in_all_environments_at_once_equals_acting_in_each_separately() {
        for preset in Preset::ALL {
            let mut learner = DynaQ::new(preset.settings(), 5, 3).unwrap();
            randomize(&mut *learner.backend);
            let images = [image(9), image(120), image(240)];
            let states = images.iter().map(|image| learner.begin_episode(image));
            let states: Vec<(u64, f64)> = states.zip([0.5, 0.1, 0.9]).collect();
            let mut single = learner.clone();
            for _ in 0..50 {
                let each = states.iter().flat_map(|state| single.act(std::slice::from_ref(state)));
                assert_eq!(learner.act(&states), each.collect::<Vec<Decision>>());
            }
        }
    }

    #[test]
    fn acts_like_the_policy_without_exploration() {
        for preset in Preset::ALL {
            let mut learner = DynaQ::new(preset.settings(), 5, 1).unwrap();
            randomize(&mut *learner.backend);
            let network = learner.network().clone_box();
            let mut policy = Policy::new(network, &preset.settings());
            let mut state = learner.begin_episode(&image(1));
            policy.begin(image(1));
            for number in 1..200u8 {
                let decision = learner.act(&[(state, 0.0)]).remove(0);
                assert_eq!(decision, policy.decide(), "{preset}, step {number}");
                // Images repeat immediately, after a while, or for many steps.
                let next = image(if number > 150 { 9 } else { number / 2 % 30 });
                policy.observe(decision.action, next.clone());
                state = learner.store(state, decision.action, &step(next, false));
            }
        }
    }

    #[test]
    fn does_not_repeat_an_action_that_did_not_change_the_image() {
        let mut learner = DynaQ::new(Preset::Robust.settings(), 5, 1).unwrap();
        let mut state = learner.begin_episode(&image(1));
        for epsilon in [0.0, 1.0] {
            let mut taken = Vec::new();
            for _ in 0..Action::COUNT {
                let decision = learner.act(&[(state, epsilon)]).remove(0);
                assert!(!taken.contains(&decision.action), "{taken:?}, {:?}", decision.action);
                taken.push(decision.action);
                state = learner.store(state, decision.action, &step(image(1), false));
            }
        }
    }

    #[test]
    fn the_target_network_starts_as_a_copy_of_the_training_network() {
        let learner = DynaQ::new(Preset::Paper.settings(), 5, 1).unwrap();
        let (train, target) = (learner.backend.train(), learner.backend.target());
        assert_eq!(values(train, &image(3)), values(target, &image(3)));
    }
}
