//! The action values that a network assigns to states.

use pulp::Arch;
use task::Action;

use super::{
    activations::Activations,
    backend::Network,
    observation::{Augmentation, Moment},
};

/// The augmentations that yield a state and its mirror image. A network trained with mirrored
/// transitions gives two estimates of the same values for the two; their mean has a smaller error.
const BOTH: [Augmentation; 2] =
    [Augmentation::NONE, Augmentation { mirrored: true, ..Augmentation::NONE }];

/// The buffers for the forward passes on which decisions are based in training, evaluation and
/// deployment.
///
/// # Examples
///
/// ```
/// use learning::{
///     architectures::backend, observation::History, settings::Preset, valuation::Valuation,
/// };
/// use task::{Image, Random};
///
/// let settings = Preset::Paper.settings();
/// let backend = backend(&settings, &mut Random::from_key([0; 4]))?;
/// let mut valuation = Valuation::new(backend.train(), 1, false, 1);
/// let mut history = History::new(1);
/// history.begin(Image::try_from(vec![0u8; Image::BYTES])?);
/// let states = std::iter::once(history.past());
/// let values: Vec<[f32; 7]> = valuation.of(backend.train(), states).collect();
/// assert_eq!(values, [[0.0; 7]]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Valuation {
    activations: Activations,
    frames: usize,
    augmentations: &'static [Augmentation],
}

impl Valuation {
    /// Creates buffers for networks of the same shape as `network`, observations of `frames`
    /// stacked images, and at most `states` states per call. If `mirror` is true, values are the
    /// mean over a state and its mirror image.
    pub fn new(network: &dyn Network, frames: usize, mirror: bool, states: usize) -> Valuation {
        let augmentations = &BOTH[..if mirror { 2 } else { 1 }];
        let activations = network.activations(states * augmentations.len());
        Valuation { activations, frames, augmentations }
    }

    /// Selects the vector instructions used to write observations.
    pub(crate) fn set_arch(&mut self, arch: Arch) {
        self.activations.set_arch(arch);
    }

    /// Returns the values of the seven actions in each state. A state is given by the moments of
    /// its episode, newest first.
    ///
    /// `network` must have the shape of the network that the buffers were created for. States
    /// beyond the maximum number are not evaluated.
    pub fn of<'a, Past>(
        &mut self,
        network: &dyn Network,
        states: impl Iterator<Item = Past>,
    ) -> impl Iterator<Item = [f32; Action::COUNT]>
    where
        Past: Iterator<Item = Moment<'a>> + Clone,
    {
        let augmentations = self.augmentations;
        let augmented = |state: Past| {
            augmentations.iter().map(move |augmentation| (state.clone(), *augmentation))
        };
        let mut count = 0;
        let observations = states.inspect(|_| count += 1).flat_map(augmented);
        self.activations.read_observations(self.frames, observations);
        network.forward(&mut self.activations);
        let mut outputs = self.activations.outputs();
        (0..count).map(move |_| mean(augmentations, &mut outputs))
    }
}

/// Returns the mean action values over the augmentations of a state, given the network outputs for
/// each augmentation.
fn mean<'a>(
    augmentations: &[Augmentation],
    outputs: impl Iterator<Item = &'a [f32]>,
) -> [f32; Action::COUNT] {
    let mut values = [0.0; Action::COUNT];
    for (augmentation, outputs) in augmentations.iter().zip(outputs) {
        for (action, value) in Action::ALL.into_iter().zip(&mut values) {
            *value += outputs[usize::from(augmentation.action(action).index())];
        }
    }
    values.map(|sum| sum / augmentations.len() as f32)
}

#[cfg(test)]
mod tests {
    use task::Image;

    use super::*;
    use crate::{
        network::{QNetwork, Shape},
        perceptron::Perceptron,
        sequence::Sequence,
        settings::{Preset, Settings},
    };

    fn network(settings: &Settings) -> Perceptron {
        let mut random = Sequence::Weights.random(1);
        let network = QNetwork::new(&Shape::of(&settings.network), &mut random).unwrap();
        Perceptron::new(&network.randomized(2)).unwrap()
    }

    fn moments<'a>(images: &'a [[u8; Image::BYTES]], action: Action) -> Vec<Moment<'a>> {
        images.iter().map(|image| Moment { image, action: Some(action) }).collect()
    }

    #[test]
    fn a_mirrored_state_has_mirrored_values() {
        let settings = Preset::Robust.settings();
        let network = network(&settings);
        let images: Vec<[u8; Image::BYTES]> = (0..2)
            .map(|shift| std::array::from_fn(|index| (7 * index + 40 * shift) as u8))
            .collect();
        let mirrored: Vec<_> = images.iter().map(Image::mirrored).collect();
        let action = Action::try_from(1).unwrap();
        let states = [moments(&images, action), moments(&mirrored, action.mirrored())];
        let states = states.iter().map(|moments| moments.iter().copied());
        let mut valuation = Valuation::new(
            &network,
            settings.network.observation_frames,
            settings.replay.mirror,
            2,
        );
        let values: Vec<_> = valuation.of(&network, states.clone()).collect();
        for action in Action::ALL {
            let [own, other] = [action, action.mirrored()].map(|a| usize::from(a.index()));
            assert!((values[0][own] - values[1][other]).abs() < 1e-6, "{values:?}");
        }
        assert!(values[0] != values[1]);
        // Without mirroring, the values are the outputs of the network.
        let mut valuation = Valuation::new(&network, settings.network.observation_frames, false, 2);
        let plain: Vec<_> = valuation.of(&network, states).collect();
        for action in Action::ALL {
            let [own, other] = [action, action.mirrored()].map(|a| usize::from(a.index()));
            let mean = (plain[0][own] + plain[1][other]) / 2.0;
            assert!((values[0][own] - mean).abs() < 1e-6, "{plain:?} {values:?}");
        }
    }
}
