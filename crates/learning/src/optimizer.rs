//! The coefficients of an Adam step, shared by both backends.

use crate::settings::OptimizerSettings;

/// The coefficients of update `t`.
///
/// With `m^ = m / (1 - b1^t)` and `v^ = v / (1 - b2^t)`, the step
/// `w <- w - alpha m^ / (sqrt(v^) + epsilon)` equals `w - rate m / (sqrt(v) + epsilon')`, where
/// `rate = alpha sqrt(1 - b2^t) / (1 - b1^t)` and `epsilon' = epsilon sqrt(1 - b2^t)` (Kingma and
/// Ba, 2017, end of section 2).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rates {
    pub(crate) beta1: f32,
    pub(crate) beta2: f32,
    /// `1 - b1`
    pub(crate) rest1: f32,
    /// `1 - b2`
    pub(crate) rest2: f32,
    /// `alpha sqrt(1 - b2^t) / (1 - b1^t)`
    pub(crate) rate: f32,
    /// The factor applied to a weight before its step: `1 - alpha weight_decay` (Loshchilov and
    /// Hutter, 2019).
    pub(crate) keep: f32,
    /// `epsilon sqrt(1 - b2^t)`
    pub(crate) epsilon: f32,
}

impl Rates {
    /// Returns the coefficients of update number `step`, counted from 1, with step size
    /// `learning_rate`.
    pub(crate) fn new(settings: &OptimizerSettings, learning_rate: f64, step: u64) -> Rates {
        let OptimizerSettings { weight_decay, beta1, beta2, epsilon, .. } = *settings;
        let root = (1.0 - power(beta2, step)).sqrt();
        Rates {
            beta1: beta1 as f32,
            beta2: beta2 as f32,
            rest1: (1.0 - beta1) as f32,
            rest2: (1.0 - beta2) as f32,
            keep: (1.0 - learning_rate * weight_decay) as f32,
            rate: (learning_rate * root / (1.0 - power(beta1, step))) as f32,
            epsilon: (epsilon * root) as f32,
        }
    }
}

/// Returns `base^exponent`. Unlike `powi`, this function returns the same bits on every machine.
fn power(base: f64, exponent: u64) -> f64 {
    libm::pow(base, exponent as f64)
}
