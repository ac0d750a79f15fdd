//! Adam (Kingma and Ba, 2017, algorithm 1) with decoupled weight decay (Loshchilov and Hutter,
//! 2019), fused with the gradient computation.

use pulp::Simd;

use super::{
    Perceptron,
    layer::{Finish, Layer, Product},
    tile::{Tiled, add_products, compute, take, vectors, vectors_mut},
};
use crate::{
    activations::{Activations, Floats, zeros},
    optimizer::Rates,
    settings::OptimizerSettings,
};

/// The optimizer of a perceptron. It computes the gradients of the weights layer by layer, starting
/// at the output, and updates each weight as soon as its gradient is known.
#[derive(Clone, Debug)]
pub struct Adam {
    /// The current step size, alpha.
    pub(super) learning_rate: f64,
    settings: OptimizerSettings,
    /// The number of updates so far, `t`.
    pub(super) step: u64,
    /// The running mean of the gradients, in the shape of the network.
    pub(super) first: Perceptron,
    /// The running mean of the squared gradients, in the shape of the network.
    pub(super) second: Perceptron,
    /// Number of samples in a batch.
    batch: usize,
    /// The input to the biases: 1 for each part of each sample.
    ones: Vec<f32>,
    /// Gradients of the loss with respect to the outputs and the inputs of a layer,
    /// `[batch * parts, width]`.
    gradients: [Floats; 2],
    /// The transposed weights of a layer, for the gradient with respect to its inputs.
    transposed: Floats,
}

impl Adam {
    /// Creates an optimizer for batches of `batch` samples.
    pub fn new(network: &Perceptron, batch: usize, settings: &OptimizerSettings) -> Adam {
        let widths = network.layers.iter().map(|layer| layer.parts * layer.width());
        let widest = widths.max().unwrap_or(0);
        let weights = |layer: &Layer| layer.outputs * layer.input_width();
        let most_weights = network.layers.iter().skip(1).map(weights).max().unwrap_or(0);
        Adam {
            learning_rate: settings.learning_rate,
            settings: settings.clone(),
            step: 0,
            first: network.zeros_like(),
            second: network.zeros_like(),
            batch,
            ones: vec![1.0; batch * network.parts()],
            gradients: [zeros(batch * widest), zeros(batch * widest)],
            transposed: zeros(most_weights),
        }
    }

    /// Returns the buffer for the gradient of the loss with respect to the outputs of the network,
    /// `[batch, width]`, padded like the activations. The buffer may be longer than this shape
    /// requires.
    pub fn output_gradient(&mut self) -> &mut [f32] {
        &mut self.gradients[0]
    }

    /// Backpropagates the output gradient through the forward pass in `activations`, and updates
    /// the weights with one step of Adam.
    pub fn update(&mut self, network: &mut Perceptron, activations: &Activations) {
        self.step += 1;
        let arch = network.arch;
        let rates = Rates::new(&self.settings, self.learning_rate, self.step);
        for index in (0..network.layers.len()).rev() {
            let layer = &mut network.layers[index];
            let (inputs, width) = (layer.inputs, layer.width());
            let rows = self.batch * layer.parts;
            let [gradient, input_gradient] = &mut self.gradients;
            let (input, input_stride) = match index {
                0 => (&activations.inputs, inputs),
                _ => (&activations.outputs[index - 1], layer.input_width()),
            };
            if index > 0 {
                arch.dispatch(|| layer.transpose(&mut self.transposed));
                let product = Product {
                    left: gradient,
                    left_stride: width,
                    rows,
                    right: &self.transposed,
                    terms: layer.outputs,
                    bias: None,
                    product: input_gradient,
                    width: input_stride,
                    finish: Finish::WherePositive(input),
                };
                compute(arch, product);
            }
            let gradient = &gradient[..rows * width];
            let (first, second) = (&mut self.first.layers[index], &mut self.second.layers[index]);
            let (weights, bias) = layer.parameters.split_at_mut(inputs * width);
            let (first, first_bias) = first.parameters.split_at_mut(inputs * width);
            let (second, second_bias) = second.parameters.split_at_mut(inputs * width);
            let of_weights = Descent {
                input,
                input_stride,
                inputs,
                gradient,
                width,
                parameters: weights,
                first,
                second,
                rates,
            };
            compute(arch, of_weights);
            let of_biases = Descent {
                input: &self.ones[..rows],
                input_stride: 1,
                inputs: 1,
                gradient,
                width,
                parameters: bias,
                first: first_bias,
                second: second_bias,
                rates,
            };
            compute(arch, of_biases);
            self.gradients.swap(0, 1);
        }
    }
}

/// The update of a layer's weights or biases, whose gradient is `input^T gradient`.
struct Descent<'a> {
    /// `[batch, inputs]`
    input: &'a [f32],
    input_stride: usize,
    inputs: usize,
    /// `[batch, width]`
    gradient: &'a [f32],
    width: usize,
    /// `[inputs, width]`
    parameters: &'a mut [f32],
    /// `[inputs, width]`
    first: &'a mut [f32],
    /// `[inputs, width]`
    second: &'a mut [f32],
    rates: Rates,
}

impl Tiled for Descent<'_> {
    fn size(&self) -> (usize, usize) {
        (self.inputs, self.width)
    }

    #[inline(always)]
    fn tile<S: Simd, const R: usize, const C: usize>(
        &mut self,
        simd: S,
        row: usize,
        column: usize,
    ) {
        let columns = self.width / S::F32_LANES;
        let left = self.input.chunks_exact(self.input_stride).map(|sample| take(sample, row));
        let samples = vectors::<S>(self.gradient).chunks_exact(columns);
        let right = samples.map(|sample| take(sample, column));
        let none = [[simd.splat_f32s(0.0); C]; R];
        let gradients = add_products::<S, R, C>(simd, none, left, right);
        let rates = self.rates;
        let (beta1, beta2) = (simd.splat_f32s(rates.beta1), simd.splat_f32s(rates.beta2));
        let (rest1, rest2) = (simd.splat_f32s(rates.rest1), simd.splat_f32s(rates.rest2));
        let keep = simd.splat_f32s(rates.keep);
        let (rate, epsilon) = (simd.splat_f32s(-rates.rate), simd.splat_f32s(rates.epsilon));
        for (r, gradients) in gradients.iter().enumerate() {
            let start = (row + r) * columns + column;
            let parameters = &mut vectors_mut::<S>(self.parameters)[start..start + C];
            let first = &mut vectors_mut::<S>(self.first)[start..start + C];
            let second = &mut vectors_mut::<S>(self.second)[start..start + C];
            for c in 0..C {
                let gradient = gradients[c];
                first[c] = simd.mul_add_f32s(beta1, first[c], simd.mul_f32s(rest1, gradient));
                let square = simd.mul_f32s(simd.mul_f32s(rest2, gradient), gradient);
                second[c] = simd.mul_add_f32s(beta2, second[c], square);
                let deviation = simd.add_f32s(simd.sqrt_f32s(second[c]), epsilon);
                let step = simd.div_f32s(first[c], deviation);
                let kept = simd.mul_f32s(keep, parameters[c]);
                parameters[c] = simd.mul_add_f32s(rate, step, kept);
            }
        }
    }
}
