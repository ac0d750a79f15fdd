//! A fully connected layer.

use candle_core::{Device, Tensor};
use pulp::Simd;

use crate::activations::{Floats, zeros};

use super::tile::{Tiled, add_products, padded, take, vectors, vectors_mut};

/// The weights and biases of a layer, or Adam's moments in the same shape.
///
/// Row `i` holds the weights from input `i` to each output; the last row holds the biases. Rows are
/// padded with zeros, which remain zero because their gradients are always zero. The same holds for
/// the rows of inputs that are padding.
#[derive(Clone, Debug)]
pub(super) struct Layer {
    /// Number of inputs, including padding between the parts of a shared first layer.
    pub(super) inputs: usize,
    pub(super) outputs: usize,
    /// Number of parts of a sample to which the layer is applied ([`Shape::parts`]).
    ///
    /// [`Shape::parts`]: crate::network::Shape::parts
    pub(super) parts: usize,
    /// Number of consecutive inputs before padding.
    group: usize,
    /// `[inputs + 1, width]`
    pub(super) parameters: Floats,
}

impl Layer {
    /// Creates a layer of zeros that is applied to `parts` parts of a sample. If the previous layer
    /// is applied to several parts, its outputs for each of them are padded: the inputs of this
    /// layer are then `groups` groups of `group` numbers with padding after each group.
    pub(super) fn zeros(groups: usize, group: usize, outputs: usize, parts: usize) -> Layer {
        let inputs = if groups == 1 { group } else { groups * padded(group) };
        Layer { inputs, outputs, parts, group, parameters: zeros((inputs + 1) * padded(outputs)) }
    }

    /// Returns a layer of the same shape, filled with zeros.
    pub(super) fn zeros_like(&self) -> Layer {
        Layer { parameters: zeros(self.parameters.len()), ..*self }
    }

    /// Returns the index of an input, given its index without padding.
    fn input(&self, unpadded: usize) -> usize {
        unpadded / self.group * padded(self.group) + unpadded % self.group
    }

    /// Returns the number of inputs without padding.
    pub(super) fn unpadded_inputs(&self) -> usize {
        let groups = if self.inputs == self.group { 1 } else { self.inputs / padded(self.group) };
        groups * self.group
    }

    /// Returns the number of inputs, padded like the outputs of the previous layer.
    pub(super) fn input_width(&self) -> usize {
        padded(self.inputs)
    }

    /// Returns the number of outputs, including padding.
    pub(super) fn width(&self) -> usize {
        padded(self.outputs)
    }

    /// Copies the weights, `[outputs, inputs]`, and the biases, `[outputs]`, from tensors.
    pub(super) fn read(&mut self, weight: &Tensor, bias: &Tensor) -> candle_core::Result<()> {
        let width = self.width();
        let columns: Vec<Vec<f32>> = weight.to_vec2()?;
        for (output, column) in columns.iter().enumerate() {
            for (input, value) in column.iter().enumerate() {
                let input = self.input(input);
                self.parameters[input * width + output] = *value;
            }
        }
        let biases = self.inputs * width;
        self.parameters[biases..biases + self.outputs].copy_from_slice(&bias.to_vec1()?);
        Ok(())
    }

    /// Returns the weights, `[outputs, inputs]`, and the biases, `[outputs]`.
    pub(super) fn tensors(&self) -> candle_core::Result<[Tensor; 2]> {
        let (width, device) = (self.width(), &Device::Cpu);
        let number = |input: usize, output: usize| self.parameters[input * width + output];
        let inputs = self.unpadded_inputs();
        let weight: Vec<f32> = (0..self.outputs)
            .flat_map(|output| (0..inputs).map(move |input| number(self.input(input), output)))
            .collect();
        let bias: Vec<f32> = (0..self.outputs).map(|output| number(self.inputs, output)).collect();
        Ok([
            Tensor::from_vec(weight, (self.outputs, inputs), device)?,
            Tensor::from_vec(bias, self.outputs, device)?,
        ])
    }

    /// Writes the transposed weights, `[outputs, input_width]`, without changing the padding.
    pub(super) fn transpose(&self, transposed: &mut [f32]) {
        const BLOCK: usize = 4;
        let (width, stride) = (self.width(), self.input_width());
        let whole = self.inputs / BLOCK * BLOCK;
        for output in (0..self.outputs).step_by(BLOCK) {
            let height = BLOCK.min(self.outputs - output);
            let columns = &mut transposed[output * stride..][..height * stride];
            for input in (0..whole).step_by(BLOCK) {
                let rows: [[f32; BLOCK]; BLOCK] = std::array::from_fn(|row| {
                    take(&self.parameters, (input + row) * width + output)
                });
                for (column, to) in columns.chunks_exact_mut(stride).enumerate() {
                    to[input..input + BLOCK].copy_from_slice(&rows.map(|row| row[column]));
                }
            }
            for input in whole..self.inputs {
                for (column, to) in columns.chunks_exact_mut(stride).enumerate() {
                    to[input] = self.parameters[input * width + output + column];
                }
            }
        }
    }
}

/// The function applied to each sum before it is written.
#[derive(Clone, Copy)]
pub(super) enum Finish<'a> {
    /// The identity.
    Linear,
    /// `max(0, sum)`.
    Relu,
    /// Backpropagation through a ReLU: the sum where the given output of the ReLU is positive, and
    /// 0 elsewhere. The output has the same shape as the product.
    WherePositive(&'a [f32]),
}

/// The matrix product `product = finish(bias + left right)`.
pub(super) struct Product<'a> {
    /// `[rows, terms]`
    pub(super) left: &'a [f32],
    /// Number of floats from the start of a row of `left` to the start of the next row.
    pub(super) left_stride: usize,
    pub(super) rows: usize,
    /// `[terms, width]`
    pub(super) right: &'a [f32],
    pub(super) terms: usize,
    /// `[width]`
    pub(super) bias: Option<&'a [f32]>,
    /// `[rows, width]`
    pub(super) product: &'a mut [f32],
    pub(super) width: usize,
    pub(super) finish: Finish<'a>,
}

impl Tiled for Product<'_> {
    fn size(&self) -> (usize, usize) {
        (self.rows, self.width)
    }

    #[inline(always)]
    fn tile<S: Simd, const R: usize, const C: usize>(
        &mut self,
        simd: S,
        row: usize,
        column: usize,
    ) {
        let columns = self.width / S::F32_LANES;
        let zero = simd.splat_f32s(0.0);
        let start = match self.bias {
            Some(bias) => [take(vectors::<S>(bias), column); R],
            None => [[zero; C]; R],
        };
        let mut rows: [&[f32]; R] = [&[]; R];
        for (r, values) in rows.iter_mut().enumerate() {
            *values = &self.left[(row + r) * self.left_stride..][..self.terms];
        }
        let left = (0..self.terms).map(|term| {
            let mut values = [0.0; R];
            for r in 0..R {
                values[r] = rows[r][term];
            }
            values
        });
        let right = vectors::<S>(self.right).chunks_exact(columns).map(|row| take(row, column));
        let sums = add_products::<S, R, C>(simd, start, left, right);
        for (r, sums) in sums.iter().enumerate() {
            let start = (row + r) * columns + column;
            let product = &mut vectors_mut::<S>(self.product)[start..start + C];
            match self.finish {
                Finish::Linear => product.copy_from_slice(sums),
                Finish::Relu => {
                    for c in 0..C {
                        // With this operand order, a NaN is preserved and then detected in the
                        // loss.
                        product[c] = simd.max_f32s(zero, sums[c]);
                    }
                }
                Finish::WherePositive(output) => {
                    let output = &vectors::<S>(output)[start..start + C];
                    for c in 0..C {
                        let positive = simd.greater_than_f32s(output[c], zero);
                        product[c] = simd.select_f32s(positive, sums[c], zero);
                    }
                }
            }
        }
    }
}
