//! The learner: two networks, a memory, and what is done with them at each step.

use candle_core::Result;
use task::{Action, Image, Random, Step};

use super::{
    greedy::{ActionSet, greedy_action},
    network::QNetwork,
    observation::{View, input_size},
    perceptron::{Activations, Adam, Arch, Perceptron},
    replay_memory::ReplayMemory,
    sequence::Sequence,
    settings::{OptimizerSettings, ReplaySettings, Settings, TargetUpdate},
    valuation::Valuation,
};

/// What the agent does in a state, and why.
#[derive(Clone, Debug, PartialEq)]
pub struct Decision {
    /// The action.
    pub action: Action,
    /// What the seven actions are worth to the training network.
    pub values: [f32; Action::COUNT],
    /// Whether chance chose the action, and not its value.
    pub explored: bool,
}

/// Deep Dyna-Q.
#[derive(Clone, Debug)]
pub struct DynaQ {
    pub(super) settings: Settings,
    /// `w_train`
    pub(super) train: Perceptron,
    /// `w_target`
    pub(super) target: Perceptron,
    pub(super) adam: Adam,
    pub(super) memory: ReplayMemory,
    pub(super) exploration_random: Random,
    pub(super) replay_random: Random,
    /// The forward pass of the state in each room.
    valuation: Valuation,
    /// That of a batch.
    pub(super) batch_activations: Activations,
    /// The indices of the batch that was drawn last.
    pub(super) batch: Vec<usize>,
    /// `R + gamma Q(s', a'; w_target)` for each experience of it.
    targets: Vec<f32>,
    /// `a'`, the best action in each next state.
    choices: Vec<Action>,
    /// How each experience is looked at.
    pub(super) views: Vec<View>,
}

impl DynaQ {
    /// A learner that knows nothing, and learns in so many rooms at once; its target network starts
    /// as a copy of the training network.
    pub fn new(settings: Settings, seed: u64, rooms: usize) -> Result<DynaQ> {
        let mut random = Sequence::Weights.random(seed);
        let frames = settings.network.observation_frames;
        let network =
            QNetwork::new(input_size(frames), &settings.network.hidden_layers, &mut random)?;
        let train = Perceptron::new(&network)?;
        let batch = settings.replay.batch_size;
        Ok(DynaQ {
            memory: ReplayMemory::new(settings.replay.capacity, rooms, frames),
            exploration_random: Sequence::Exploration.random(seed),
            replay_random: Sequence::Replay.random(seed),
            adam: Adam::new(&train, batch, &settings.optimizer),
            valuation: Valuation::new(&train, frames, settings.replay.mirror, rooms),
            settings,
            target: train.clone(),
            batch_activations: train.activations(batch),
            batch: vec![0; batch],
            targets: vec![0.0; batch],
            choices: vec![Action::default(); batch],
            views: vec![View::PLAIN; batch],
            train,
        })
    }

    /// Computes by these vector instructions from now on, and not by the widest that there are. It
    /// changes no result ([`arches`](crate::perceptron::arches)).
    pub fn set_arch(&mut self, arch: Arch) {
        self.train.set_arch(arch);
        self.target.set_arch(arch);
        self.valuation.set_arch(arch);
        self.batch_activations.set_arch(arch);
    }

    /// Chooses an action in each room, given the number of what is seen there and epsilon: with
    /// probability epsilon any action that is not left out, each alike, otherwise the best of these.
    /// There are at most as many as the learner was made for.
    pub fn act(&mut self, states: &[(u64, f64)]) -> Vec<Decision> {
        let memory = &self.memory;
        let values =
            self.valuation.of(&self.train, states.iter().map(|(state, _)| memory.past(*state)));
        let random = &mut self.exploration_random;
        let decide = |((state, epsilon), values): (&(u64, f64), [f32; Action::COUNT])| {
            let excluded = match self.settings.exploration.avoid_repetition {
                true => memory.frame(*state).tried,
                false => ActionSet::NONE,
            };
            let explored = random.chance(*epsilon);
            let action = match explored {
                true => random_action(random, excluded),
                false => greedy_action(&values, excluded),
            };
            Decision { action, values, explored }
        };
        states.iter().zip(values).map(decide).collect()
    }

    /// The first state of an episode; returns its number.
    pub fn begin_episode(&mut self, state: &Image) -> u64 {
        self.memory.begin_episode(state)
    }

    /// Stores the experience `(s, a, s', R)`, given the number of `s`; returns that of `s'`.
    pub fn remember(&mut self, state: u64, action: Action, step: &Step) -> u64 {
        let extra = if step.blocked { self.settings.replay.blocked_reward as f32 } else { 0.0 };
        self.memory.store(state, action, step.reward + extra, step.terminated, &step.image)
    }

    /// Experience replay: one update of the training network from a batch of memories. Returns the
    /// loss, or `None` while there are too few memories.
    pub fn plan(&mut self) -> Option<f32> {
        self.draw(0).then(|| self.update())
    }

    /// Draws the batch of an update; false while there are too few memories. It is that of an update
    /// after `more` further experiences, which need not be there yet.
    pub(super) fn draw(&mut self, more: usize) -> bool {
        let random = &mut self.replay_random;
        let is_drawn = self.memory.draw(&mut self.batch, more, random);
        let observation_frames = self.settings.network.observation_frames;
        let ReplaySettings { mirror, history_dropout, .. } = self.settings.replay;
        // No number is drawn for what a preset does without.
        if is_drawn && (mirror || history_dropout > 0.0) {
            for view in &mut self.views {
                view.mirrored = mirror && random.chance(0.5);
                view.frames = match random.chance(history_dropout) {
                    true => 1 + random.below(observation_frames),
                    false => observation_frames,
                };
            }
        }
        is_drawn
    }

    /// Whether the batch needs one of the next experiences, so many of them.
    pub(super) fn batch_needs_next(&self, more: usize) -> bool {
        self.batch.iter().any(|index| self.memory.is_among_next(*index, more))
    }

    /// One update of the training network from the batch that was drawn. Returns the loss, the mean
    /// over the batch of `(R + gamma max_a' Q(s', a'; w_target) - Q(s, a; w_train))^2` (eq. 5);
    /// nothing is changed if it is not finite.
    pub(super) fn update(&mut self) -> f32 {
        let frames = self.settings.network.observation_frames;
        let (double_q, avoid_repetition) =
            (self.settings.target.double_q, self.settings.exploration.avoid_repetition);
        let (memory, activations) = (&self.memory, &mut self.batch_activations);
        memory.fetch(&self.batch);
        let experiences = || self.batch.iter().map(|index| memory.get(*index)).zip(&self.views);

        let next_states = experiences().map(|(e, view)| (memory.past(e.next_state), *view));
        activations.read_observations(frames, next_states);
        let choosing = if double_q { &self.train } else { &self.target };
        choosing.forward(activations);
        for ((choice, values), (experience, view)) in
            self.choices.iter_mut().zip(activations.outputs()).zip(experiences())
        {
            let excluded = match avoid_repetition {
                true => view.actions(memory.frame(experience.next_state).tried),
                false => ActionSet::NONE,
            };
            let (values, _padding) = values.split_first_chunk().expect("a value for each action");
            *choice = greedy_action(values, excluded);
        }
        if double_q {
            self.target.forward(activations);
        }
        for (((target, values), choice), (experience, _)) in
            self.targets.iter_mut().zip(activations.outputs()).zip(&self.choices).zip(experiences())
        {
            let best = values[usize::from(choice.index())];
            let discount =
                if experience.terminated { 0.0 } else { self.settings.target.discount as f32 };
            *target = experience.reward + discount * best;
        }

        let states = experiences().map(|(e, view)| (memory.past(e.state), *view));
        activations.read_observations(frames, states);
        self.train.forward(activations);
        let gradient = self.adam.output_gradient();
        gradient.fill(0.0);
        let mut loss = 0.0;
        let size = self.batch.len() as f32;
        let rows = gradient.chunks_exact_mut(activations.output_width());
        for (((gradient, values), target), (experience, view)) in
            rows.zip(activations.outputs()).zip(&self.targets).zip(experiences())
        {
            let action = usize::from(view.action(experience.action).index());
            let error = values[action] - target;
            loss += error * error / size;
            gradient[action] = 2.0 * error / size;
        }
        if loss.is_finite() {
            self.adam.update(&mut self.train, activations);
            if self.settings.target.update_at == TargetUpdate::Update {
                self.update_target();
            }
        }
        loss
    }

    /// Says how much of the training is done, from 0 to 1.
    pub fn set_progress(&mut self, progress: f64) {
        let OptimizerSettings { learning_rate, final_learning_rate_ratio, .. } =
            self.settings.optimizer;
        let last = learning_rate * final_learning_rate_ratio;
        self.adam.learning_rate = learning_rate + (last - learning_rate) * progress;
    }

    /// An episode has ended.
    pub fn end_episode(&mut self) {
        if self.settings.target.update_at == TargetUpdate::Episode {
            self.update_target();
        }
    }

    /// Moves the target network towards the training network (eq. 6).
    fn update_target(&mut self) {
        self.target.move_towards(&self.train, self.settings.target.rate as f32);
    }

    /// The network that is being trained.
    pub fn network(&self) -> &Perceptron {
        &self.train
    }

    /// Everything that has the shape of the network, by the prefix of its names in a checkpoint.
    pub(super) fn parameters(&self) -> [(&'static str, &Perceptron); 4] {
        [
            ("train.", &self.train),
            ("target.", &self.target),
            ("adam.first.", &self.adam.first),
            ("adam.second.", &self.adam.second),
        ]
    }

    /// As [`DynaQ::parameters`].
    pub(super) fn parameters_mut(&mut self) -> [(&'static str, &mut Perceptron); 4] {
        [
            ("train.", &mut self.train),
            ("target.", &mut self.target),
            ("adam.first.", &mut self.adam.first),
            ("adam.second.", &mut self.adam.second),
        ]
    }
}

/// Any action that is not excluded.
fn random_action(random: &mut Random, excluded: ActionSet) -> Action {
    let allowed = Action::COUNT - excluded.len();
    let place = random.below(allowed.max(1)) as u8;
    let mut actions = Action::ALL.into_iter().filter(|action| !excluded.contains(*action));
    actions.nth(place.into()).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{policy::Policy, settings::Preset};

    fn image(brightness: u8) -> Image {
        Image::try_from([brightness; Image::BYTES].as_slice()).unwrap()
    }

    fn values(network: &Perceptron, image: &Image) -> [f32; Action::COUNT] {
        let network = network.network().unwrap();
        let mut policy = Policy::new(&network, &Preset::Paper.settings()).unwrap();
        policy.begin(image.clone());
        policy.decide().values
    }

    fn action(index: u8) -> Action {
        Action::try_from(index).unwrap()
    }

    fn step(image: Image, terminated: bool) -> Step {
        Step { image, reward: -0.1, terminated, truncated: false, blocked: false }
    }

    /// A learner with a memory of one step, `terminated` or not.
    fn learner_after_one_step(terminated: bool) -> DynaQ {
        let settings = Preset::Paper.settings().with(|s| s.replay.batch_size = 1);
        let mut learner = DynaQ::new(settings, 5, 1).unwrap();
        for (network, seed) in [(&mut learner.train, 1), (&mut learner.target, 2)] {
            network.read(&network.network().unwrap().randomized(seed)).unwrap();
        }
        let state = learner.begin_episode(&image(50));
        learner.remember(state, action(2), &step(image(200), terminated));
        learner
    }

    #[test]
    fn the_loss_is_equation_5_and_bootstraps_unless_terminated() {
        for terminated in [false, true] {
            let mut learner = learner_after_one_step(terminated);
            let value = values(&learner.train, &image(50))[2];
            let next = values(&learner.target, &image(200));
            let best = next.iter().copied().fold(f32::MIN, f32::max);
            let target = if terminated { -0.1 } else { -0.1 + 0.999 * best };
            let expected = (target - value).powi(2);
            let loss = learner.plan().unwrap();
            assert!((loss - expected).abs() < 1e-5 * expected.max(1.0), "{loss} {expected}");
        }
    }

    #[test]
    fn an_update_moves_the_value_towards_its_target_and_leaves_the_target_network() {
        let mut learner = learner_after_one_step(true);
        let target_before = values(&learner.target, &image(50));
        let error = |learner: &DynaQ| (values(&learner.train, &image(50))[2] + 0.1).abs();
        let before = error(&learner);
        for _ in 0..20 {
            learner.plan();
        }
        assert!(error(&learner) < before);
        assert_eq!(values(&learner.target, &image(50)), target_before);
        learner.end_episode();
        assert_ne!(values(&learner.target, &image(50)), target_before);
    }

    #[test]
    fn no_update_before_the_batch_can_be_filled() {
        let mut learner = DynaQ::new(Preset::Paper.settings(), 5, 1).unwrap();
        let mut state = learner.begin_episode(&image(0));
        for number in 1..=50 {
            assert_eq!(learner.plan(), None);
            state = learner.remember(state, action(0), &step(image(number), false));
        }
        assert!(learner.plan().is_some());
    }

    #[test]
    fn epsilon_one_explores_every_action_alike_and_zero_never_explores() {
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
    fn deciding_for_several_rooms_at_once_is_deciding_for_one_after_the_other() {
        for preset in Preset::ALL {
            let mut learner = DynaQ::new(preset.settings(), 5, 3).unwrap();
            learner.train.read(&learner.train.network().unwrap().randomized(1)).unwrap();
            let images = [image(9), image(120), image(240)];
            let states = images.iter().map(|image| learner.begin_episode(image));
            let states: Vec<(u64, f64)> = states.zip([0.5, 0.1, 0.9]).collect();
            let mut alone = learner.clone();
            for _ in 0..50 {
                let each = states.iter().flat_map(|state| alone.act(std::slice::from_ref(state)));
                assert_eq!(learner.act(&states), each.collect::<Vec<Decision>>());
            }
        }
    }

    /// Training decides as the trained policy will, by the same observation.
    #[test]
    fn without_exploration_the_learner_does_what_the_policy_does() {
        for preset in Preset::ALL {
            let mut learner = DynaQ::new(preset.settings(), 5, 1).unwrap();
            let network = learner.train.network().unwrap().randomized(3);
            learner.train.read(&network).unwrap();
            let mut policy = Policy::new(&network, &preset.settings()).unwrap();
            let mut state = learner.begin_episode(&image(1));
            policy.begin(image(1));
            for number in 1..200u8 {
                let decision = learner.act(&[(state, 0.0)]).remove(0);
                assert_eq!(decision, policy.decide(), "{preset}, step {number}");
                // Some images come twice, some again after a while, and some for long.
                let next = image(if number > 150 { 9 } else { number / 2 % 30 });
                policy.observe(decision.action, next.clone());
                state = learner.remember(state, decision.action, &step(next, false));
            }
        }
    }

    #[test]
    fn what_was_tried_in_vain_is_not_repeated() {
        let mut learner = DynaQ::new(Preset::Robust.settings(), 5, 1).unwrap();
        let mut state = learner.begin_episode(&image(1));
        for epsilon in [0.0, 1.0] {
            let mut done = Vec::new();
            for _ in 0..Action::COUNT {
                let decision = learner.act(&[(state, epsilon)]).remove(0);
                assert!(!done.contains(&decision.action), "{done:?} and {:?}", decision.action);
                done.push(decision.action);
                state = learner.remember(state, decision.action, &step(image(1), false));
            }
        }
    }

    #[test]
    fn the_target_network_starts_as_the_training_network() {
        let learner = DynaQ::new(Preset::Paper.settings(), 5, 1).unwrap();
        let (train, target) = (&learner.train, &learner.target);
        assert_eq!(values(train, &image(3)), values(target, &image(3)));
    }
}
