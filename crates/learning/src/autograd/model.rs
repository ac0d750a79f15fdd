//! The architectures, built from candle-nn's layers.

use candle_core::{Error, Module, Result, Tensor};
use candle_nn::{
    Linear, VarBuilder, linear,
    rnn::{GRU, GRUConfig, RNN, gru},
};
use task::{Action, Image};

use crate::{
    network::NO_FIRST_LAYER,
    observation::input_size,
    settings::{Architecture, NetworkSettings},
};

/// Output channels of the two convolutions.
const CHANNELS: [usize; 2] = [16, 32];
/// Height and width of the convolution kernels, in pixels.
const KERNEL: usize = 3;

/// A network that maps observations, `[batch, inputs]`, to action values, `[batch, 7]`.
#[derive(Debug)]
pub(super) struct Model {
    trunk: Trunk,
    pub(super) hidden: Vec<Linear>,
    pub(super) head: Head,
    frames: usize,
}

/// The layers before the hidden layers.
#[derive(Debug)]
enum Trunk {
    /// No layers: the observation is the input to the hidden layers.
    Flat,
    /// A layer with ReLU that is applied to each stacked image and the action that led to it.
    SharedEncoder(Linear),
    /// Two convolutions over the stacked images; the colour channels of all images are the input
    /// channels.
    Convolutional([Linear; 2]),
    /// A gated recurrent unit (Cho et al., 2014) that reads the images, oldest first, each together
    /// with the action that led to it.
    Recurrent(GRU),
}

/// The output layers.
#[derive(Debug)]
pub(super) enum Head {
    /// One linear layer.
    Plain(Linear),
    /// `Q = V + A - mean(A)` (Wang et al., 2016, eq. 9).
    Dueling { value: Linear, advantage: Linear },
}

/// Returns whether a parameter belongs to an output layer.
pub(super) fn is_output(name: &str) -> bool {
    ["output.", "value.", "advantage."].iter().any(|layer| name.starts_with(layer))
}

impl Model {
    /// Builds the layers that the settings describe.
    ///
    /// # Errors
    ///
    /// Returns an error if a network with a shared encoder or a recurrent network has no hidden
    /// layer, or if `builder` fails.
    pub(super) fn new(settings: &NetworkSettings, builder: VarBuilder<'_>) -> Result<Model> {
        let frames = settings.observation_frames;
        let mut hidden_layers = settings.hidden_layers.as_slice();
        let (trunk, mut width) = match settings.architecture {
            Architecture::Mlp | Architecture::Dueling => (Trunk::Flat, input_size(frames)),
            Architecture::SharedEncoder => {
                let Some((outputs, rest)) = hidden_layers.split_first() else {
                    return Err(Error::Msg(NO_FIRST_LAYER.to_owned()));
                };
                hidden_layers = rest;
                let encoder = linear(input_size(frames) / frames, *outputs, builder.pp("encoder"))?;
                (Trunk::SharedEncoder(encoder), frames * outputs)
            }
            Architecture::Convolutional => {
                let [first, second] = CHANNELS;
                let area = KERNEL * KERNEL;
                let layers = [
                    linear(area * Image::CHANNELS * frames, first, builder.pp("conv.0"))?,
                    linear(area * first, second, builder.pp("conv.1"))?,
                ];
                let lost = layers.len() * (KERNEL - 1);
                let pixels = (Image::HEIGHT - lost) * (Image::WIDTH - lost);
                let actions = (frames - 1) * Action::COUNT;
                (Trunk::Convolutional(layers), second * pixels + actions)
            }
            Architecture::Recurrent => {
                let Some((state, rest)) = hidden_layers.split_first() else {
                    return Err(Error::Msg(NO_FIRST_LAYER.to_owned()));
                };
                hidden_layers = rest;
                let inputs = Image::BYTES + Action::COUNT;
                let unit = gru(inputs, *state, GRUConfig::default(), builder.pp("gru"))?;
                (Trunk::Recurrent(unit), *state)
            }
        };
        let mut hidden = Vec::new();
        for (index, outputs) in hidden_layers.iter().enumerate() {
            hidden.push(linear(width, *outputs, builder.pp(format!("layers.{index}")))?);
            width = *outputs;
        }
        let head = match settings.architecture {
            Architecture::Dueling => Head::Dueling {
                value: linear(width, 1, builder.pp("value"))?,
                advantage: linear(width, Action::COUNT, builder.pp("advantage"))?,
            },
            _ => Head::Plain(linear(width, Action::COUNT, builder.pp("output"))?),
        };
        Ok(Model { trunk, hidden, head, frames })
    }

    /// Computes the action values, `[batch, 7]`, for observations, `[batch, inputs]`.
    pub(super) fn forward(&self, inputs: &Tensor) -> Result<Tensor> {
        let mut values = match &self.trunk {
            Trunk::Flat => inputs.clone(),
            Trunk::SharedEncoder(encoder) => {
                let (batch, count) = inputs.dims2()?;
                let rows = inputs.reshape((batch * self.frames, count / self.frames))?;
                encoder.forward(&rows)?.relu()?.reshape((batch, ()))?
            }
            Trunk::Convolutional(layers) => self.convolve(inputs, layers)?,
            Trunk::Recurrent(unit) => self.recur(inputs, unit)?,
        };
        for layer in &self.hidden {
            values = layer.forward(&values)?.relu()?;
        }
        match &self.head {
            Head::Plain(output) => output.forward(&values),
            Head::Dueling { value, advantage } => {
                let (value, advantage) = (value.forward(&values)?, advantage.forward(&values)?);
                let mean = advantage.mean_keepdim(1)?;
                advantage.broadcast_add(&(value - mean)?)
            }
        }
    }

    /// Splits observations into images, `[batch, frames, 420]`, and the actions between them,
    /// `[batch, frames - 1, 7]`, both ordered from newest to oldest.
    fn split(&self, inputs: &Tensor) -> Result<(Tensor, Tensor)> {
        let (batch, frames) = (inputs.dim(0)?, self.frames);
        let rows = inputs.reshape((batch, frames, ()))?;
        let images = rows.narrow(2, 0, Image::BYTES)?;
        let actions = match frames {
            1 => Tensor::zeros((batch, 0, Action::COUNT), inputs.dtype(), inputs.device())?,
            _ => rows.narrow(1, 0, frames - 1)?.narrow(2, Image::BYTES, Action::COUNT)?,
        };
        Ok((images.contiguous()?, actions.contiguous()?))
    }

    /// Computes the inputs to the hidden layers: the outputs of the convolutions, then the actions.
    ///
    /// A convolution is a linear layer that is applied to each patch of `KERNEL` x `KERNEL` pixels.
    /// As a matrix product it is several times as fast as candle's own convolution on a CPU.
    fn convolve(&self, inputs: &Tensor, layers: &[Linear]) -> Result<Tensor> {
        let (images, actions) = self.split(inputs)?;
        let (batch, frames, _) = images.dims3()?;
        let pixels = (batch, frames, Image::HEIGHT, Image::WIDTH, Image::CHANNELS);
        let stack = (batch, Image::HEIGHT, Image::WIDTH, frames * Image::CHANNELS);
        let mut values = images.reshape(pixels)?.permute((0, 2, 3, 1, 4))?.reshape(stack)?;
        for layer in layers {
            values = layer.forward(&patches(&values)?)?.relu()?;
        }
        Tensor::cat(&[values.flatten_from(1)?, actions.flatten_from(1)?], 1)
    }

    /// Computes the state of the recurrent unit, `[batch, state]`, after it has read the newest
    /// image.
    fn recur(&self, inputs: &Tensor, unit: &GRU) -> Result<Tensor> {
        let (images, actions) = self.split(inputs)?;
        let (batch, frames, _) = images.dims3()?;
        // The observation does not contain the action that led to the oldest image.
        let none = Tensor::zeros((batch, 1, Action::COUNT), inputs.dtype(), inputs.device())?;
        let moments = Tensor::cat(&[images, Tensor::cat(&[actions, none], 1)?], 2)?;
        let mut state = unit.zero_state(batch)?;
        for age in (0..frames).rev() {
            let moment = moments.narrow(1, age, 1)?.squeeze(1)?.contiguous()?;
            state = unit.step(&moment, &state)?;
        }
        Ok(state.h)
    }
}

/// Returns the patches around the pixels of `[batch, height, width, channels]`, as
/// `[batch, height - 2, width - 2, 9 * channels]`.
fn patches(values: &Tensor) -> Result<Tensor> {
    let (_, height, width, _) = values.dims4()?;
    let (height, width) = (height + 1 - KERNEL, width + 1 - KERNEL);
    let shifts = (0..KERNEL).flat_map(|row| (0..KERNEL).map(move |column| (row, column)));
    let shifted =
        shifts.map(|(row, column)| values.narrow(1, row, height)?.narrow(2, column, width));
    // `cat` returns a transposed view, of which a linear layer takes no matrix product.
    Tensor::cat(&shifted.collect::<Result<Vec<_>>>()?, 3)?.contiguous()
}
