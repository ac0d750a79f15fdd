//! Adam (Kingma and Ba, 2017, algorithm 1), its moments open to checkpoints.
//!
//! candle-nn's AdamW keeps its moments to itself, so a checkpoint could not hold them; this one
//! also works in place, in one pass over the weights.

use candle_core::{CpuStorage, InplaceOp2, Layout, Result, Tensor, Var, backprop::GradStore};

/// The optimizer of a list of variables.
#[derive(Debug)]
pub struct Adam {
    /// Alpha.
    learning_rate: f64,
    /// Decay of the mean of the gradients.
    beta1: f64,
    /// Decay of the mean of the squared gradients.
    beta2: f64,
    /// Added to the root of the second moment.
    epsilon: f64,
    /// `t`, the number of updates made.
    pub(super) step: u64,
    variables: Vec<Var>,
    /// Shape `[2, n]` for each variable of n numbers: the first moment, the second.
    pub(super) moments: Vec<Tensor>,
}

impl Adam {
    /// An optimizer that has made no update yet.
    pub fn new(
        variables: Vec<Var>,
        learning_rate: f64,
        (beta1, beta2): (f64, f64),
        epsilon: f64,
    ) -> Result<Adam> {
        let moments = variables
            .iter()
            .map(|variable| {
                Tensor::zeros((2, variable.elem_count()), variable.dtype(), variable.device())
            })
            .collect::<Result<_>>()?;
        Ok(Adam { learning_rate, beta1, beta2, epsilon, step: 0, variables, moments })
    }

    /// Moves the variables against their gradients.
    pub fn update(&mut self, gradients: &GradStore) -> Result<()> {
        self.step += 1;
        let step = self.step as i32;
        let moments = Moments { beta1: self.beta1 as f32, beta2: self.beta2 as f32 };
        let descent = Descent {
            learning_rate: self.learning_rate as f32,
            bias1: (1.0 - self.beta1.powi(step)) as f32,
            bias2: (1.0 - self.beta2.powi(step)) as f32,
            epsilon: self.epsilon as f32,
        };
        for (variable, state) in self.variables.iter().zip(&self.moments) {
            if let Some(gradient) = gradients.get(variable) {
                state.inplace_op2(&gradient.contiguous()?, &moments)?;
                variable.inplace_op2(state, &descent)?;
            }
        }
        Ok(())
    }
}

/// `m <- b1 m + (1 - b1) g`, `v <- b2 v + (1 - b2) g^2`.
struct Moments {
    beta1: f32,
    beta2: f32,
}

/// `w <- w - alpha m^ / (sqrt(v^) + epsilon)`, where `m^ = m / (1 - b1^t)`, `v^ = v / (1 - b2^t)`.
struct Descent {
    learning_rate: f32,
    bias1: f32,
    bias2: f32,
    epsilon: f32,
}

impl InplaceOp2 for Moments {
    fn name(&self) -> &'static str {
        "adam-moments"
    }

    fn cpu_fwd(
        &self,
        moments: &mut CpuStorage,
        moments_layout: &Layout,
        gradient: &CpuStorage,
        gradient_layout: &Layout,
    ) -> Result<()> {
        let gradient = floats(gradient, gradient_layout)?;
        let (first, second) = floats_mut(moments, moments_layout)?.split_at_mut(gradient.len());
        for ((first, second), gradient) in first.iter_mut().zip(second).zip(gradient) {
            *first = self.beta1 * *first + (1.0 - self.beta1) * gradient;
            *second = self.beta2 * *second + (1.0 - self.beta2) * gradient * gradient;
        }
        Ok(())
    }
}

impl InplaceOp2 for Descent {
    fn name(&self) -> &'static str {
        "adam-descent"
    }

    fn cpu_fwd(
        &self,
        weights: &mut CpuStorage,
        weights_layout: &Layout,
        moments: &CpuStorage,
        moments_layout: &Layout,
    ) -> Result<()> {
        let weights = floats_mut(weights, weights_layout)?;
        let (first, second) = floats(moments, moments_layout)?.split_at(weights.len());
        for ((weight, first), second) in weights.iter_mut().zip(first).zip(second) {
            let (mean, variance) = (first / self.bias1, second / self.bias2);
            *weight -= self.learning_rate * mean / (variance.sqrt() + self.epsilon);
        }
        Ok(())
    }
}

/// `target <- target + tau (train - target)` (eq. 6).
pub(super) struct TowardsTraining {
    pub(super) tau: f32,
}

impl InplaceOp2 for TowardsTraining {
    fn name(&self) -> &'static str {
        "target-update"
    }

    fn cpu_fwd(
        &self,
        target: &mut CpuStorage,
        target_layout: &Layout,
        train: &CpuStorage,
        train_layout: &Layout,
    ) -> Result<()> {
        let train = floats(train, train_layout)?;
        for (target, train) in floats_mut(target, target_layout)?.iter_mut().zip(train) {
            *target += self.tau * (train - *target);
        }
        Ok(())
    }
}

fn floats<'a>(storage: &'a CpuStorage, layout: &Layout) -> Result<&'a [f32]> {
    let (start, end) = contiguous(layout)?;
    Ok(&storage.as_slice::<f32>()?[start..end])
}

fn floats_mut<'a>(storage: &'a mut CpuStorage, layout: &Layout) -> Result<&'a mut [f32]> {
    let (start, end) = contiguous(layout)?;
    match storage {
        CpuStorage::F32(values) => Ok(&mut values[start..end]),
        _ => candle_core::bail!("expected 32-bit floats"),
    }
}

fn contiguous(layout: &Layout) -> Result<(usize, usize)> {
    match layout.contiguous_offsets() {
        Some(offsets) => Ok(offsets),
        None => candle_core::bail!("expected a contiguous tensor"),
    }
}

#[cfg(test)]
mod tests {
    use candle_core::Device;
    use candle_nn::{AdamW, Optimizer, ParamsAdamW};

    use super::*;

    /// Without weight decay, candle-nn's AdamW is Adam: the two agree over hundreds of updates.
    #[test]
    fn it_is_candles_adam_without_weight_decay() {
        let start = Tensor::new(&[[0.5f32, -1.0, 2.0], [0.1, 0.0, -0.3]], &Device::Cpu).unwrap();
        let (ours, theirs) = (Var::from_tensor(&start).unwrap(), Var::from_tensor(&start).unwrap());
        let mut adam = Adam::new(vec![ours.clone()], 1e-2, (0.9, 0.999), 1e-7).unwrap();
        let parameters =
            ParamsAdamW { lr: 1e-2, beta1: 0.9, beta2: 0.999, eps: 1e-7, weight_decay: 0.0 };
        let mut reference = AdamW::new(vec![theirs.clone()], parameters).unwrap();
        // A valley with a bend: sum of (w^2 - 1)^2.
        let loss = |w: &Var| ((w.sqr()? - 1.0)?.sqr()?).sum_all();
        for _ in 0..300 {
            adam.update(&loss(&ours).unwrap().backward().unwrap()).unwrap();
            reference.backward_step(&loss(&theirs).unwrap()).unwrap();
        }
        let difference = (ours.as_tensor() - theirs.as_tensor()).unwrap().abs().unwrap();
        let greatest: f32 = difference.max_all().unwrap().to_scalar().unwrap();
        assert!(greatest < 1e-5, "{greatest}");
    }
}
