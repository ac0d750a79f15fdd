//! The learner: two networks, a memory, and what is done with them at each step.

use candle_core::Result;
use rand::{Rng, RngExt};
use rand_chacha::ChaCha8Rng;

use super::{
    action::Action,
    image::Image,
    network::QNetwork,
    perceptron::{Activations, Adam, Perceptron},
    policy,
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
#[derive(Clone, Debug)]
pub struct DynaQ {
    pub(super) settings: Settings,
    /// `w_train`
    pub(super) train: Perceptron,
    /// `w_target`
    pub(super) target: Perceptron,
    pub(super) adam: Adam,
    pub(super) memory: ReplayMemory,
    pub(super) exploration_random: ChaCha8Rng,
    pub(super) replay_random: ChaCha8Rng,
    /// The forward pass of the state in each room, and of a batch.
    activations: Activations,
    batch_activations: Activations,
    /// The indices of the batch that was drawn last.
    pub(super) batch: Vec<usize>,
    /// `R + gamma max_a' Q(s', a'; w_target)` for each experience of it.
    targets: Vec<f32>,
}

impl DynaQ {
    /// A learner that knows nothing, and learns in so many rooms at once; its target network starts
    /// as a copy of the training network.
    pub fn new(settings: Settings, seed: u64, rooms: usize) -> Result<DynaQ> {
        let mut random = seeds::sequence(seed, Sequence::Weights);
        let train = Perceptron::new(&QNetwork::new(&settings.hidden_layers, &mut random)?)?;
        let betas = (settings.adam_beta1, settings.adam_beta2);
        let batch = settings.batch_size;
        let (rate, epsilon) = (settings.learning_rate, settings.adam_epsilon);
        Ok(DynaQ {
            memory: ReplayMemory::new(settings.memory_capacity, rooms),
            exploration_random: seeds::sequence(seed, Sequence::Exploration),
            replay_random: seeds::sequence(seed, Sequence::Replay),
            settings,
            target: train.clone(),
            adam: Adam::new(&train, batch, rate, betas, epsilon),
            activations: train.activations(rooms),
            batch_activations: train.activations(batch),
            batch: vec![0; batch],
            targets: vec![0.0; batch],
            train,
        })
    }

    /// Chooses an action in each room, given what is seen there and epsilon: with probability epsilon
    /// any of the seven alike, otherwise the best. There are at most as many as the learner was made
    /// for.
    pub fn act(&mut self, states: &[(&Image, f64)]) -> Vec<Decision> {
        self.activations.read_images(states.iter().map(|(image, _)| image.bytes()));
        self.train.forward(&mut self.activations);
        let random = &mut self.exploration_random;
        let decide = |((_, epsilon), outputs): (&(&Image, f64), &[f32])| {
            let values = policy::of_actions(outputs);
            let explored = random.random::<f64>() < *epsilon;
            let action = match explored {
                true => random_action(random),
                false => Action::greatest(&values),
            };
            Decision { action, values: Some(values), explored }
        };
        states.iter().zip(self.activations.outputs()).map(decide).collect()
    }

    /// The first state of an episode; returns its number.
    pub fn begin_episode(&mut self, state: &Image) -> u64 {
        self.memory.begin_episode(state)
    }

    /// Stores the experience `(s, a, s', R)`, given the number of `s`; returns that of `s'`.
    pub fn remember(
        &mut self,
        state: u64,
        action: Action,
        reward: f32,
        terminated: bool,
        next_state: &Image,
    ) -> u64 {
        self.memory.store(state, action, reward, terminated, next_state)
    }

    /// Experience replay: one update of the training network from a batch of memories. Returns the
    /// loss, or `None` while there are too few memories.
    pub fn plan(&mut self) -> Option<f32> {
        self.draw(0).then(|| self.update())
    }

    /// Draws the batch of an update; false while there are too few memories. It is that of an update
    /// after `more` further experiences, which need not be there yet.
    pub(super) fn draw(&mut self, more: usize) -> bool {
        self.memory.draw(&mut self.batch, more, &mut self.replay_random)
    }

    /// Whether the batch needs one of the next experiences, so many of them.
    pub(super) fn batch_needs_next(&self, more: usize) -> bool {
        self.batch.iter().any(|index| self.memory.is_among_next(*index, more))
    }

    /// One update of the training network from the batch that was drawn. Returns the loss, the mean
    /// over the batch of `(R + gamma max_a' Q(s', a'; w_target) - Q(s, a; w_train))^2` (eq. 5);
    /// nothing is changed if it is not finite.
    pub(super) fn update(&mut self) -> f32 {
        let batch = &self.batch;
        let (memory, activations) = (&self.memory, &mut self.batch_activations);
        memory.fetch(batch);
        let experiences = || batch.iter().map(|index| memory.get(*index));
        activations
            .read_images(experiences().map(|experience| memory.image(experience.next_state)));
        self.target.forward(activations);
        for ((target, values), experience) in
            self.targets.iter_mut().zip(activations.outputs()).zip(experiences())
        {
            let best = values[..Action::COUNT].iter().copied().fold(f32::NEG_INFINITY, f32::max);
            let discount = if experience.terminated { 0.0 } else { self.settings.discount as f32 };
            *target = experience.reward + discount * best;
        }

        activations.read_images(experiences().map(|experience| memory.image(experience.state)));
        self.train.forward(activations);
        let gradient = self.adam.output_gradient();
        gradient.fill(0.0);
        let mut loss = 0.0;
        let size = batch.len() as f32;
        let rows = gradient.chunks_exact_mut(activations.output_width());
        for (((gradient, values), target), experience) in
            rows.zip(activations.outputs()).zip(&self.targets).zip(experiences())
        {
            let action = usize::from(experience.action.index());
            let error = values[action] - target;
            loss += error * error / size;
            gradient[action] = 2.0 * error / size;
        }
        if loss.is_finite() {
            self.adam.update(&mut self.train, activations);
        }
        loss
    }

    /// Moves the target network towards the training network (eq. 6).
    pub fn end_episode(&mut self) {
        self.target.move_towards(&self.train, self.settings.target_update as f32);
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

    fn values(network: &Perceptron, image: &Image) -> [f32; Action::COUNT] {
        policy::values(network, &mut network.activations(1), image)
    }

    fn action(index: u8) -> Action {
        Action::try_from(index).unwrap()
    }

    /// A learner with a memory of one step, `terminated` or not.
    fn learner_after_one_step(terminated: bool) -> DynaQ {
        let settings = Settings { batch_size: 1, ..Preset::Paper.settings() };
        let mut learner = DynaQ::new(settings, 5, 1).unwrap();
        for (network, seed) in [(&mut learner.train, 1), (&mut learner.target, 2)] {
            network.read(&network.network().unwrap().randomized(seed)).unwrap();
        }
        let state = learner.begin_episode(&image(50));
        learner.remember(state, action(2), -0.1, terminated, &image(200));
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
        for step in 1..=50 {
            assert_eq!(learner.plan(), None);
            state = learner.remember(state, action(0), -0.1, false, &image(step));
        }
        assert!(learner.plan().is_some());
    }

    #[test]
    fn epsilon_one_explores_every_action_alike_and_zero_never_explores() {
        let mut learner = DynaQ::new(Preset::Paper.settings(), 5, 1).unwrap();
        let mut counts = [0; Action::COUNT];
        for _ in 0..7000 {
            let decision = learner.act(&[(&image(9), 1.0)]).remove(0);
            assert!(decision.explored);
            counts[usize::from(decision.action.index())] += 1;
        }
        assert!(counts.iter().all(|count| (880..1120).contains(count)), "{counts:?}");
        for _ in 0..100 {
            let decision = learner.act(&[(&image(9), 0.0)]).remove(0);
            assert!(!decision.explored);
            assert_eq!(decision.action, Action::greatest(&decision.values.unwrap()));
        }
    }

    #[test]
    fn deciding_for_several_rooms_at_once_is_deciding_for_one_after_the_other() {
        let mut learner = DynaQ::new(Preset::Paper.settings(), 5, 3).unwrap();
        let images = [image(9), image(120), image(240)];
        let states: Vec<(&Image, f64)> = images.iter().zip([0.5, 0.1, 0.9]).collect();
        let mut alone = learner.clone();
        for _ in 0..50 {
            let each: Vec<Decision> =
                states.iter().flat_map(|state| alone.act(std::slice::from_ref(state))).collect();
            assert_eq!(learner.act(&states), each);
        }
    }

    #[test]
    fn the_target_network_starts_as_the_training_network() {
        let learner = DynaQ::new(Preset::Paper.settings(), 5, 1).unwrap();
        let (train, target) = (&learner.train, &learner.target);
        assert_eq!(values(train, &image(3)), values(target, &image(3)));
    }
}
