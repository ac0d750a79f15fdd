//! Adam (Kingma and Ba, 2017, algorithm 1) with decoupled weight decay (Loshchilov and Hutter, 2019),
//! fused with the gradient that it takes.

use pulp::Simd;

use super::{
    Activations, Perceptron,
    layer::{Finish, Floats, Layer, Product, zeros},
    tile::{Tiled, add_products, compute, take, vectors, vectors_mut},
};
use crate::settings::OptimizerSettings;

/// The optimizer of a network: it works out the gradients of the weights, layer by layer from the
/// last, and moves each weight as soon as its gradient is there.
#[derive(Clone, Debug)]
pub struct Adam {
    /// Alpha.
    pub(crate) learning_rate: f64,
    /// How fast weights shrink, in units of alpha.
    weight_decay: f64,
    /// Decay of the mean of the gradients.
    beta1: f64,
    /// Decay of the mean of the squared gradients.
    beta2: f64,
    /// Added to the root of the second moment.
    epsilon: f64,
    /// `t`, the number of updates made.
    pub(crate) step: u64,
    /// The mean of the gradients, in the shape of the network.
    pub(crate) first: Perceptron,
    /// The mean of the squared gradients, in the shape of the network.
    pub(crate) second: Perceptron,
    /// One for each sample: the input of the biases.
    ones: Vec<f32>,
    /// Gradients of the loss by the outputs of a layer, and by its inputs. `[batch, width]`
    gradients: [Floats; 2],
    /// Weights of a layer as the gradient of its inputs takes them.
    transposed: Floats,
}

/// The numbers of one update. With `m^ = m / (1 - b1^t)` and `v^ = v / (1 - b2^t)`,
/// `w <- w - alpha m^ / (sqrt(v^) + epsilon)` is `w - rate m / (sqrt(v) + epsilon')`, where
/// `rate = alpha sqrt(1 - b2^t) / (1 - b1^t)` and `epsilon' = epsilon sqrt(1 - b2^t)`.
#[derive(Clone, Copy)]
struct Rates {
    beta1: f32,
    beta2: f32,
    /// `1 - b1`, `1 - b2`
    rest1: f32,
    rest2: f32,
    rate: f32,
    /// What is left of a weight before it moves: `1 - alpha weight_decay`.
    keep: f32,
    epsilon: f32,
}

impl Adam {
    /// An optimizer that has made no update yet, for batches of so many samples.
    pub fn new(network: &Perceptron, batch: usize, settings: &OptimizerSettings) -> Adam {
        let OptimizerSettings { learning_rate, weight_decay, beta1, beta2, epsilon, .. } =
            *settings;
        let widest = network.layers.iter().map(Layer::width).max().unwrap_or(0);
        let weights = |layer: &Layer| layer.outputs * layer.input_width();
        let most_weights = network.layers.iter().skip(1).map(weights).max().unwrap_or(0);
        Adam {
            learning_rate,
            weight_decay,
            beta1,
            beta2,
            epsilon,
            step: 0,
            first: network.zeros_like(),
            second: network.zeros_like(),
            ones: vec![1.0; batch],
            gradients: [zeros(batch * widest), zeros(batch * widest)],
            transposed: zeros(most_weights),
        }
    }

    /// Where the gradient of the loss by the network's outputs is written before an update: row by
    /// row, padded as the activations are.
    pub fn output_gradient(&mut self) -> &mut [f32] {
        &mut self.gradients[0]
    }

    /// Moves the weights against the gradient of the loss: backward propagation of the output
    /// gradient through the forward pass that the activations hold.
    pub fn update(&mut self, network: &mut Perceptron, activations: &Activations) {
        self.step += 1;
        let arch = network.arch;
        let rates = self.rates();
        let batch = self.ones.len();
        for index in (0..network.layers.len()).rev() {
            let layer = &mut network.layers[index];
            let (inputs, width) = (layer.inputs, layer.width());
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
                    rows: batch,
                    right: &self.transposed,
                    terms: layer.outputs,
                    bias: None,
                    product: input_gradient,
                    width: input_stride,
                    finish: Finish::WherePositive(input),
                };
                compute(arch, product);
            }
            let gradient = &gradient[..batch * width];
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
                input: &self.ones,
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

    fn rates(&self) -> Rates {
        let root = (1.0 - power(self.beta2, self.step)).sqrt();
        Rates {
            beta1: self.beta1 as f32,
            beta2: self.beta2 as f32,
            rest1: (1.0 - self.beta1) as f32,
            rest2: (1.0 - self.beta2) as f32,
            keep: (1.0 - self.learning_rate * self.weight_decay) as f32,
            rate: (self.learning_rate * root / (1.0 - power(self.beta1, self.step))) as f32,
            epsilon: (self.epsilon * root) as f32,
        }
    }
}

/// The update of a layer's weights by the gradient `input^T gradient`.
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

/// `base` to the power of `exponent`: the same bits on every machine, which `powi` does not promise.
fn power(base: f64, exponent: u64) -> f64 {
    libm::pow(base, exponent as f64)
}
