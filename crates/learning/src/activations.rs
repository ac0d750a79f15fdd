//! The buffers of a forward pass.

use std::slice::ChunksExactMut;

use aligned_vec::{AVec, ConstAlign};
use pulp::{Arch, NullaryFnOnce};

use crate::observation::{Augmentation, Moment, input_size, write_input};

/// A buffer aligned to cache lines, so that no vector crosses a line boundary.
pub(crate) type Floats = AVec<f32, ConstAlign<64>>;

/// Returns a buffer of `count` zeros.
pub(crate) fn zeros(count: usize) -> Floats {
    AVec::from_iter(64, std::iter::repeat_n(0.0, count))
}

/// The inputs of a batch and the outputs of each layer.
///
/// [`Network::activations`](crate::backend::Network::activations) creates them with the shapes that
/// a network needs.
#[derive(Clone, Debug)]
pub struct Activations {
    /// `[batch, input_count]`
    pub(crate) inputs: Floats,
    /// `[batch, width]` for each layer; the last one holds the action values.
    pub(crate) outputs: Vec<Floats>,
    input_count: usize,
    output_width: usize,
    batch: usize,
    arch: Arch,
}

impl Activations {
    /// Creates buffers for `batch` samples of `input_count` numbers, and for layers with the given
    /// widths.
    pub(crate) fn new(
        batch: usize,
        input_count: usize,
        widths: impl IntoIterator<Item = usize>,
        arch: Arch,
    ) -> Activations {
        let widths: Vec<usize> = widths.into_iter().collect();
        Activations {
            inputs: zeros(batch * input_count),
            outputs: widths.iter().map(|width| zeros(batch * width)).collect(),
            input_count,
            output_width: widths.last().copied().unwrap_or(0),
            batch,
            arch,
        }
    }

    /// Selects the vector instructions used to write observations.
    pub(crate) fn set_arch(&mut self, arch: Arch) {
        self.arch = arch;
    }

    /// Returns the number of samples in the batch.
    pub fn batch(&self) -> usize {
        self.batch
    }

    /// Iterates over the samples; each item holds the inputs of a sample, `[input_count]`.
    pub fn inputs_mut(&mut self) -> impl Iterator<Item = &mut [f32]> {
        self.inputs.chunks_exact_mut(self.input_count)
    }

    /// Writes observations of `frames` stacked images as inputs, one per sample.
    ///
    /// Each observation is given by the moments of its episode, newest first, and its augmentation.
    /// If there are fewer observations than samples, the remaining inputs keep their values.
    pub fn read_observations<'a, Past>(
        &mut self,
        frames: usize,
        observations: impl Iterator<Item = (Past, Augmentation)>,
    ) where
        Past: Iterator<Item = Moment<'a>>,
    {
        debug_assert_eq!(self.input_count, input_size(frames));
        let inputs = self.inputs.chunks_exact_mut(self.input_count);
        self.arch.dispatch(ReadObservations { frames, inputs, observations });
    }

    /// Iterates over the samples; each item holds the outputs of a sample, `[output_width]`: the
    /// seven action values, followed by any padding.
    pub fn outputs(&self) -> impl Iterator<Item = &[f32]> {
        self.outputs.last().into_iter().flat_map(|last| last.chunks_exact(self.output_width))
    }

    /// Returns the number of outputs of a sample, including padding.
    pub fn output_width(&self) -> usize {
        self.output_width
    }
}

/// This is a named type because the compiler might not inline a closure into the code for the
/// selected instructions.
struct ReadObservations<'a, Observations> {
    frames: usize,
    inputs: ChunksExactMut<'a, f32>,
    observations: Observations,
}

impl<'a, Past, Observations> NullaryFnOnce for ReadObservations<'_, Observations>
where
    Past: Iterator<Item = Moment<'a>>,
    Observations: Iterator<Item = (Past, Augmentation)>,
{
    type Output = ();

    #[inline(always)]
    fn call(self) {
        for (input, (past, augmentation)) in self.inputs.zip(self.observations) {
            write_input(past, self.frames, augmentation, input);
        }
    }
}
