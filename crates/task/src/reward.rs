//! What a step is worth (the paper's section 3).

/// The reward of the step that reaches the exit.
pub const EXIT_REWARD: f32 = 0.0;

/// The reward of every other step, a blocked one included.
pub const STEP_REWARD: f32 = -0.1;
