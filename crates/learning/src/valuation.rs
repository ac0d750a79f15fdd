//! What the actions are worth in a state, according to a network.

use task::Action;

use super::{
    observation::{Moment, View},
    perceptron::{Activations, Arch, Perceptron},
};

/// How a decision looks at a state: as it is, and where mirrored memories are learnt from, also in
/// the mirror. What the network has learnt of both is the same room, so the mean of the two answers
/// errs less than either.
const BOTH: [View; 2] = [View::PLAIN, View { mirrored: true, ..View::PLAIN }];

/// A forward pass that decisions are made from, in training as in the test.
#[derive(Clone, Debug)]
pub struct Valuation {
    activations: Activations,
    frames: usize,
    views: &'static [View],
}

impl Valuation {
    /// For networks of this form with `frames` stacked images, and at most `states` states at once. With
    /// `mirror` the values are the mean over the state and its mirror image.
    pub fn new(network: &Perceptron, frames: usize, mirror: bool, states: usize) -> Valuation {
        let views = &BOTH[..if mirror { 2 } else { 1 }];
        let activations = network.activations(states * views.len());
        Valuation { activations, frames, views }
    }

    /// Computes by these vector instructions from now on.
    pub(crate) fn set_arch(&mut self, arch: Arch) {
        self.activations.set_arch(arch);
    }

    /// The values of the actions in each state, which is given by the present moment and those before
    /// it. There are at most as many states as this was made for.
    pub fn of<'a, Past>(
        &mut self,
        network: &Perceptron,
        states: impl Iterator<Item = Past>,
    ) -> impl Iterator<Item = [f32; Action::COUNT]>
    where
        Past: Iterator<Item = Moment<'a>> + Clone,
    {
        let views = self.views;
        let looked_at = |state: Past| views.iter().map(move |view| (state.clone(), *view));
        let mut count = 0;
        let observations = states.inspect(|_| count += 1).flat_map(looked_at);
        self.activations.read_observations(self.frames, observations);
        network.forward(&mut self.activations);
        let mut outputs = self.activations.outputs();
        (0..count).map(move |_| mean(views, &mut outputs))
    }
}

/// The mean over the views of a state, given the outputs for each.
fn mean<'a>(views: &[View], outputs: impl Iterator<Item = &'a [f32]>) -> [f32; Action::COUNT] {
    let mut values = [0.0; Action::COUNT];
    for (view, outputs) in views.iter().zip(outputs) {
        for (action, value) in Action::ALL.into_iter().zip(&mut values) {
            *value += outputs[usize::from(view.action(action).index())];
        }
    }
    values.map(|sum| sum / views.len() as f32)
}

#[cfg(test)]
mod tests {
    use task::Image;

    use super::*;
    use crate::{
        network::QNetwork,
        observation::input_size,
        sequence::Sequence,
        settings::{Preset, Settings},
    };

    fn network(settings: &Settings) -> Perceptron {
        let inputs = input_size(settings.network.observation_frames);
        let mut random = Sequence::Weights.random(1);
        let network = QNetwork::new(inputs, &settings.network.hidden_layers, &mut random).unwrap();
        Perceptron::new(&network.randomized(2)).unwrap()
    }

    fn moments<'a>(images: &'a [[u8; Image::BYTES]], action: Action) -> Vec<Moment<'a>> {
        images.iter().map(|image| Moment { image, action: Some(action) }).collect()
    }

    #[test]
    fn a_mirrored_room_has_mirrored_values() {
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
        // Without a mirror it is what the network says of the room as it is.
        let mut valuation = Valuation::new(&network, settings.network.observation_frames, false, 2);
        let plain: Vec<_> = valuation.of(&network, states).collect();
        for action in Action::ALL {
            let [own, other] = [action, action.mirrored()].map(|a| usize::from(a.index()));
            let mean = (plain[0][own] + plain[1][other]) / 2.0;
            assert!((values[0][own] - mean).abs() < 1e-6, "{plain:?} {values:?}");
        }
    }
}
