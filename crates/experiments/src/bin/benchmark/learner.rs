//! Measures network updates and inference, and the sgemm rate that bounds the update.

use std::{num::NonZeroU64, time::Instant};

use candle_core::{Device, Tensor};
use experiments::Room;
use learning::{
    dyna_q::DynaQ,
    network::Shape,
    settings::{Preset, Settings},
};
use sim_node::world::WorldSettings;
use task::{Action, Environment};

use crate::quantile::median;

/// Baseline and learner alternate, so that both run under the same machine load.
const ROUNDS: usize = 15;
const UPDATES_A_ROUND: usize = 1000;
const INFERENCES_A_ROUND: usize = 2000;

/// The measurements of one preset; each is a median or derived from one.
pub struct LearnerFigures {
    pub preset: Preset,
    /// Rate of a 1024 x 1024 x 1024 matrix product with the `gemm` crate on one thread, in GFLOP/s.
    pub sgemm_gflops: f64,
    /// Time per update, in microseconds: sampling the batch, all passes, and the Adam step.
    pub update_us: f64,
    /// Time that the arithmetic of an update would take at the sgemm rate, in microseconds.
    pub update_roofline_us: f64,
    /// Time to evaluate the Q-values of one state, in microseconds.
    pub inference_us: f64,
}

pub fn measure() -> anyhow::Result<Vec<LearnerFigures>> {
    Preset::ALL.into_iter().map(measure_preset).collect()
}

fn measure_preset(preset: Preset) -> anyhow::Result<LearnerFigures> {
    let settings = preset.settings();
    let mut learner = DynaQ::new(settings.clone(), 0, 1)?;
    let state = fill_memory(&mut learner, settings.replay.capacity)?;
    let (mut sgemm, mut update, mut inference) = (Vec::new(), Vec::new(), Vec::new());
    let matrix = Tensor::rand(-1f32, 1f32, (1024, 1024), &Device::Cpu)?;
    for _ in 0..ROUNDS {
        let started = Instant::now();
        std::hint::black_box(matrix.matmul(&matrix)?);
        sgemm.push(2.0 * 1024f64.powi(3) / started.elapsed().as_secs_f64() / 1e9);
        for _ in 0..UPDATES_A_ROUND {
            let started = Instant::now();
            let loss = learner.plan();
            update.push(started.elapsed().as_secs_f64() * 1e6);
            anyhow::ensure!(loss.is_some_and(f32::is_finite), "update failed: no finite loss");
        }
        let started = Instant::now();
        for _ in 0..INFERENCES_A_ROUND {
            std::hint::black_box(learner.act(&[(state, 0.0)]));
        }
        inference.push(started.elapsed().as_secs_f64() * 1e6 / INFERENCES_A_ROUND as f64);
    }
    let sgemm_gflops = median(&mut sgemm);
    Ok(LearnerFigures {
        preset,
        sgemm_gflops,
        update_us: median(&mut update),
        update_roofline_us: update_flop(&settings) / sgemm_gflops / 1e3,
        inference_us: median(&mut inference),
    })
}

/// Returns the number of multiplications and additions in one update: a forward pass through both
/// networks (with double Q-learning, a second pass through the training network) and a backward
/// pass that computes the gradients of the weights and of all layer inputs except the observation.
fn update_flop(settings: &Settings) -> f64 {
    let shape = Shape::of(&settings.network);
    // A shared first layer is applied to each part: it has as many products as it has inputs in all
    // parts together, times its outputs.
    let mut inputs = shape.inputs;
    let mut products = Vec::new();
    for (layer, outputs) in shape.hidden_layers.iter().chain([&Action::COUNT]).enumerate() {
        products.push(inputs * outputs);
        inputs = outputs * if layer == 0 { shape.parts } else { 1 };
    }
    let all: usize = products.iter().sum();
    let passes = if settings.target.double_q { 5 } else { 4 };
    2.0 * settings.replay.batch_size as f64 * (passes * all - products[0]) as f64
}

/// Fills the replay memory with `count` transitions from random actions in the scenario `empty`.
/// Returns the index of the last state.
fn fill_memory(learner: &mut DynaQ, count: usize) -> anyhow::Result<u64> {
    let mut room = Room::new(WorldSettings::default());
    let mut seed = NonZeroU64::MIN;
    let mut state = learner.begin_episode(&room.reset(seed, "empty")?);
    for _ in 0..count {
        let decision = learner.act(&[(state, 1.0)]).remove(0);
        let step = room.step(decision.action)?;
        state = learner.store(state, decision.action, &step);
        if step.terminated || step.truncated {
            seed = seed.saturating_add(1);
            state = learner.begin_episode(&room.reset(seed, "empty")?);
        }
    }
    Ok(state)
}
