//! Deep Dyna-Q (section 2.3 of the paper): an agent that learns to act from camera images.
//!
//! The crate is independent of ROS. It trains and evaluates agents in any environment that
//! implements [`task::Environment`]: a simulator (in process or over DDS) or a robot.
//!
//! Training:
//!
//! - [`settings`]: all hyperparameters, and the presets.
//! - [`training`]: the training loop (Figure 2 of the paper) in one or several environments.
//! - [`dyna_q`]: the learner, which chooses actions, stores transitions and updates the networks.
//! - [`replay_memory`]: the transitions that updates sample from.
//! - [`priorities`]: prioritized replay.
//! - [`exploration`]: epsilon decay (eq. 4).
//! - [`sequence`]: the random sequences of a run.
//! - [`record`]: one record per training episode.
//!
//! Acting:
//!
//! - [`observation`]: stacked images as network input, and the actions already tried.
//! - [`similarity`]: whether two images show the same view, despite camera noise.
//! - [`valuation`]: the action values of states.
//! - [`greedy`]: the action with the highest value.
//! - [`policy`]: the greedy policy of a trained network.
//! - [`evaluation`]: evaluation episodes of a policy.
//! - [`driver`]: a policy in deployment, which acts on a stream of timestamped images.
//!
//! Networks:
//!
//! - [`backend`]: the interface between the learner and its networks.
//! - [`architectures`]: creates the backend or the network that the settings describe.
//! - [`network`]: the multilayer perceptron as it is initialized and saved.
//! - [`perceptron`]: the backend for multilayer perceptrons: allocation-free SIMD kernels.
//! - [`autograd`]: the backend for all other architectures: candle's tensors and automatic
//!   differentiation.
//! - [`activations`]: the buffers of a forward pass.
//! - [`weights`]: initial weights, and validation of saved weights.
//!
//! Files:
//!
//! - [`checkpoint`]: saves a training run and resumes it with an identical result.
//! - [`run`]: the directory of a run, whose files are replaced atomically.
//! - [`saver`]: saves a training run from a background thread.
//!
//! # Examples
//!
//! Trains an agent in a corridor, then asks its policy for an action:
//!
//! ```
//! use std::{convert::Infallible, num::NonZeroU64};
//!
//! use learning::{
//!     record::EpisodeRecord,
//!     settings::Preset,
//!     training::{Listener, Plan, Training},
//! };
//! use task::{Action, EXIT_REWARD, Environment, Image, STEP_REWARD, Step};
//!
//! const EXIT: u8 = 2;
//!
//! /// A corridor with the exit two steps ahead, so narrow that every turn is blocked.
//! #[derive(Default)]
//! struct Corridor {
//!     position: u8,
//!     steps: u32,
//! }
//!
//! impl Corridor {
//!     /// The image gets brighter as the robot approaches the exit.
//!     fn image(&self) -> Image {
//!         let bytes = vec![100 * self.position; Image::BYTES];
//!         Image::try_from(bytes).expect("the buffer has the size of an image")
//!     }
//! }
//!
//! impl Environment for Corridor {
//!     type Error = Infallible;
//!     type PendingReset = ();
//!     type PendingStep = Action;
//!
//!     fn begin_reset(&mut self, _seed: NonZeroU64, _scenario: &str) -> Result<(), Infallible> {
//!         *self = Corridor::default();
//!         Ok(())
//!     }
//!
//!     fn finish_reset(&mut self, _pending: ()) -> Result<Image, Infallible> {
//!         Ok(self.image())
//!     }
//!
//!     fn begin_step(&mut self, action: Action) -> Result<Action, Infallible> {
//!         Ok(action)
//!     }
//!
//!     fn finish_step(&mut self, action: Action) -> Result<Step, Infallible> {
//!         let blocked = action.turn_degrees() != 0;
//!         self.position += u8::from(!blocked);
//!         self.steps += 1;
//!         let terminated = self.position == EXIT;
//!         let truncated = !terminated && self.steps == 20;
//!         let reward = if terminated { EXIT_REWARD } else { STEP_REWARD };
//!         Ok(Step { image: self.image(), reward, terminated, truncated, blocked })
//!     }
//! }
//!
//! /// Counts the training episodes that reach the exit.
//! #[derive(Default)]
//! struct Successes(u32);
//!
//! impl Listener for Successes {
//!     fn episode(&mut self, _training: &Training, record: &EpisodeRecord) -> anyhow::Result<()> {
//!         self.0 += u32::from(record.terminated);
//!         Ok(())
//!     }
//! }
//!
//! let plan = Plan { scenario: "corridor".into(), episodes: 20, seed: 1, rooms: 1 };
//! let settings = Preset::Paper.settings().with(|s| s.network.hidden_layers = vec![16]);
//! let mut training = Training::new(plan, settings)?;
//! let mut successes = Successes::default();
//! training.run(&mut [Corridor::default()], &mut successes)?;
//! assert_eq!(training.episode(), 20);
//! assert!(successes.0 > 0);
//!
//! let mut policy = training.policy();
//! policy.begin(Corridor::default().image());
//! let decision = policy.decide();
//! assert!(!decision.explored);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod activations;
pub mod architectures;
pub mod autograd;
pub mod backend;
pub mod checkpoint;
pub mod driver;
pub mod dyna_q;
pub mod evaluation;
pub mod exploration;
pub mod greedy;
mod input;
pub mod network;
pub mod observation;
mod optimizer;
pub mod perceptron;
pub mod policy;
pub mod priorities;
pub mod record;
pub mod replay_memory;
pub mod run;
pub mod saver;
pub mod sequence;
pub mod settings;
pub mod similarity;
pub mod training;
pub mod valuation;
pub mod weights;
