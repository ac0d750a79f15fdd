//! Deep Dyna-Q (the paper's section 2.3): images in, actions out. It knows no ROS, only an
//! [`Environment`](task::Environment).
//!
//! - [`greedy`]: the action of the greatest value.
//! - [`settings`]: the presets and every number of the method.
//! - [`training`]: the loop over episodes and steps; it reads beside the paper's Figure 2.
//! - [`dyna_q`]: the learner: act, remember, plan, end an episode.
//! - [`network`], [`perceptron`]: the networks as they are described and saved, and as they are
//!   computed and trained.
//! - [`observation`]: what a policy sees, and what it has tried.
//! - [`replay_memory`], [`exploration`]: what is remembered, and when chance decides.
//! - [`valuation`], [`policy`], [`evaluation`]: what the actions are worth to a network, what it does,
//!   and its greedy test.
//! - [`driver`]: a policy that drives by images alone.
//! - [`checkpoint`]: a training, laid down and taken up again.
//! - [`sequence`]: the random sequences of a run.
//! - [`run`], [`saver`]: a directory with what a training leaves behind, whole files only; it is written
//!   while the training goes on.

pub mod checkpoint;
pub mod driver;
pub mod dyna_q;
pub mod evaluation;
pub mod exploration;
pub mod greedy;
mod input;
pub mod network;
pub mod observation;
pub mod perceptron;
pub mod policy;
pub mod record;
pub mod replay_memory;
pub mod run;
pub mod saver;
pub mod sequence;
pub mod settings;
pub mod training;
pub mod valuation;
