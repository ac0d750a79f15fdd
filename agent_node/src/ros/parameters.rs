//! The node parameters that define the model and the training run.
//!
//! The descriptions are shown by `ros2 param describe` and by `evac train --help`; equation numbers
//! and symbols are those of the paper.

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};

use anyhow::{Context, anyhow};
use learning::{
    checkpoint::load_model,
    exploration::EpsilonDecay,
    policy::Policy,
    run::RunDirectory,
    settings::{
        Architecture, ExplorationSettings, OptimizerSettings, Preset, ReplaySettings, Settings,
        TargetSettings, TargetUpdate,
    },
};
use ros_runtime::parameters::{
    Descriptor, FromParameter, ParameterError, ParameterValue, Parameters, read_file_of,
};
use task::{Scenario, seeds::MIXED};

/// Parameter defaults from the config.yaml of a trained model; empty without a model.
#[derive(Debug, Default)]
pub(super) struct Defaults(BTreeMap<String, ParameterValue>);

impl Defaults {
    /// Reads the parameters of `agent_node` from the config.yaml in `directory`.
    ///
    /// # Errors
    ///
    /// Returns an error if the file cannot be read or contains no parameters of `agent_node`.
    pub(super) fn of_model(directory: &Path) -> anyhow::Result<Defaults> {
        let file = directory.join("config.yaml");
        let context = || format!("no trained model in {}", directory.display());
        let values = read_file_of(&file, "/agent_node").with_context(context)?;
        anyhow::ensure!(!values.is_empty(), "{}: no parameters of agent_node", file.display());
        Ok(Defaults(values))
    }

    /// Returns the default of a parameter: the value in config.yaml if there is one, otherwise
    /// `default`.
    fn get<T: FromParameter>(&self, name: &str, default: T) -> anyhow::Result<T> {
        let Some(value) = self.0.get(name) else {
            return Ok(default);
        };
        let converted = value.clone().converted(T::TYPE).ok();
        let invalid = || {
            anyhow!(
                "config.yaml of the model: parameter '{name}' is {value} (expected: {})",
                T::TYPE
            )
        };
        converted.as_ref().and_then(T::from_value).ok_or_else(invalid)
    }
}

/// Declares a read-only parameter.
pub(super) fn declare<T: FromParameter>(
    parameters: &Parameters,
    name: &str,
    default: T,
    description: &str,
) -> Result<T, ParameterError> {
    parameters.declare(name, default, Descriptor::read_only(description))
}

/// Declares a read-only integer parameter in the range `limits`, which must not exceed 2^53.
pub(super) fn count(
    parameters: &Parameters,
    name: &str,
    default: u64,
    limits: std::ops::RangeInclusive<u64>,
    description: &str,
) -> Result<u64, ParameterError> {
    let limits = *limits.start() as f64..=*limits.end() as f64;
    let descriptor = Descriptor::read_only(description).range(limits);
    Ok(parameters.declare(name, default as i64, descriptor)? as u64)
}

/// Declares a read-only floating-point parameter in the range `limits`.
fn number(
    parameters: &Parameters,
    name: &str,
    default: f64,
    limits: std::ops::RangeInclusive<f64>,
    description: &str,
) -> Result<f64, ParameterError> {
    parameters.declare(name, default, Descriptor::read_only(description).range(limits))
}

/// A trained model: a run directory and the settings in its config.yaml.
pub struct TrainedModel {
    pub(super) directory: PathBuf,
    pub(super) defaults: Defaults,
    settings: Settings,
}

impl TrainedModel {
    /// Declares the parameter `model` and the parameters that define the network and the
    /// observation. Their defaults are the values in the model's config.yaml.
    ///
    /// # Errors
    ///
    /// Returns an error if `model` is empty or names a directory without a trained model, or if a
    /// parameter is invalid.
    pub fn declare(parameters: &Parameters) -> anyhow::Result<TrainedModel> {
        let model = TrainedModel::declare_optional(parameters)?;
        let is_given = !model.directory.as_os_str().is_empty();
        anyhow::ensure!(is_given, "parameter 'model' is missing: set it with -p model:=DIRECTORY");
        Ok(model)
    }

    /// Like [`declare`](Self::declare), but `model` may be empty, in which case the defaults are
    /// those of the preset.
    pub(super) fn declare_optional(parameters: &Parameters) -> anyhow::Result<TrainedModel> {
        let description = "directory of a trained model, with model.safetensors and config.yaml";
        let directory = PathBuf::from(declare(parameters, "model", String::new(), description)?);
        let defaults = match directory.as_os_str().is_empty() {
            true => Defaults::default(),
            false => Defaults::of_model(&directory)?,
        };
        let (_, settings) = model_settings(parameters, &defaults)?;
        Ok(TrainedModel { directory, defaults, settings })
    }

    /// Loads the weights and returns the greedy policy of the model.
    ///
    /// # Errors
    ///
    /// Returns an error if `model.safetensors` cannot be read, is damaged, or contains a network
    /// whose shape does not match the settings.
    pub fn policy(&self) -> anyhow::Result<Policy> {
        let network = load_model(&self.directory.join(RunDirectory::MODEL), &self.settings)?;
        Ok(Policy::new(network, &self.settings))
    }
}

/// Declares the parameter `scenario`.
pub(super) fn scenario(parameters: &Parameters, defaults: &Defaults) -> anyhow::Result<String> {
    let choices = Scenario::ALL.map(Scenario::name).into_iter().chain([MIXED]);
    let description = "scenario of every episode; mixed draws a random scenario for each episode";
    let descriptor = Descriptor::read_only(description).choices(choices);
    let default = defaults.get("scenario", MIXED.to_owned())?;
    Ok(parameters.declare("scenario", default, descriptor)?)
}

/// Declares `preset` and the parameters that define the network and the observation.
pub(super) fn model_settings(
    parameters: &Parameters,
    defaults: &Defaults,
) -> anyhow::Result<(Preset, Settings)> {
    let choices = Descriptor::read_only(
        "set of default hyperparameters. paper: the published method; robust: adds stacked frames, \
         repetition avoidance, prioritized replay, data augmentation and a penalty for blocked \
         moves",
    )
    .choices(Preset::ALL);
    let preset: Preset = parameters
        .declare("preset", defaults.get("preset", Preset::default().to_string())?, choices)?
        .parse()?;
    let mut settings = preset.settings();
    let architecture = defaults.get("architecture", settings.network.architecture.to_string())?;
    settings.network.architecture = parameters
        .declare(
            "architecture",
            architecture,
            Descriptor::read_only(
                "architecture of the Q-network. mlp: a multilayer perceptron with hidden_layers, \
                 as in the paper; shared_encoder: like mlp, but the first hidden layer reads each \
                 of the stacked images separately, with the same weights; dueling: separate \
                 outputs for state value and advantages after hidden_layers; convolutional: two convolutional layers before hidden_layers; \
                 recurrent: the first hidden layer is a gated recurrent unit over the stacked \
                 images. The last three are 5 to 50 times slower",
            )
            .choices(Architecture::ALL),
        )?
        .parse()?;
    let hidden: Vec<i64> = settings.network.hidden_layers.iter().map(|size| *size as i64).collect();
    let sizes = Descriptor::read_only(
        "number of neurons in each hidden layer of the Q-network, from the input to the output",
    )
    .range(1.0..=65_536.0);
    let hidden = defaults.get("hidden_layers", hidden)?;
    let hidden = parameters.declare("hidden_layers", hidden, sizes)?;
    settings.network.hidden_layers = hidden.into_iter().map(|size| size as usize).collect();
    let architecture = settings.network.architecture;
    let first_reads_images =
        matches!(architecture, Architecture::SharedEncoder | Architecture::Recurrent);
    if first_reads_images && settings.network.hidden_layers.is_empty() {
        return Err(anyhow!(
            "parameter 'hidden_layers' is []: expected at least one layer, which reads the \
             stacked images in architecture {architecture}"
        ));
    }
    let frames = defaults.get("observation_frames", settings.network.observation_frames as i64)?;
    settings.network.observation_frames = count(
        parameters,
        "observation_frames",
        // A negative number in config.yaml becomes 0, which the limits reject.
        u64::try_from(frames).unwrap_or(0),
        1..=64,
        "number of stacked camera images in an observation: the latest image and those before it \
         in the episode, with the actions between them",
    )? as usize;
    let avoid_repetition =
        defaults.get("avoid_repetition", settings.exploration.avoid_repetition)?;
    settings.exploration.avoid_repetition = declare(
        parameters,
        "avoid_repetition",
        avoid_repetition,
        "exclude actions already taken in response to the same view within the last 50 steps of \
         the episode, in decisions and in the maximum over a' in eq. 5; if this excludes all \
         actions, the least recently taken one is allowed. Images show the same view if they \
         differ by no more than the camera noise, which is estimated from the image",
    )?;
    let mirror = defaults.get("mirror", settings.replay.mirror)?;
    settings.replay.mirror = declare(
        parameters,
        "mirror",
        mirror,
        "data augmentation: with probability 0.5, mirror a sampled transition by swapping left and \
         right in its images and actions; decisions then average the Q-values of both views",
    )?;
    Ok((preset, settings))
}

fn target_update_at(p: &Parameters, preset: TargetUpdate) -> anyhow::Result<TargetUpdate> {
    let choices = Descriptor::read_only(
        "when eq. 6 updates the target network: at the end of each episode, as in the paper, or \
         after each update of the training network",
    )
    .choices(TargetUpdate::ALL);
    Ok(p.declare("target_update_at", preset.to_string(), choices)?.parse()?)
}

/// Declares the training hyperparameters, with the defaults of the preset.
pub(super) fn training_settings(
    parameters: &Parameters,
    preset: Settings,
) -> anyhow::Result<Settings> {
    let settings = Settings {
        replay: replay_settings(parameters, &preset.replay)?,
        exploration: exploration_settings(parameters, &preset.exploration)?,
        optimizer: optimizer_settings(parameters, &preset.optimizer)?,
        target: target_settings(parameters, &preset.target)?,
        network: preset.network,
    };
    let ReplaySettings { batch_size, capacity, .. } = settings.replay;
    if batch_size > capacity {
        return Err(anyhow!(
            "parameter 'batch_size' is {batch_size}: expected at most memory_capacity, {capacity}"
        ));
    }
    Ok(settings)
}

fn replay_settings(p: &Parameters, preset: &ReplaySettings) -> anyhow::Result<ReplaySettings> {
    Ok(ReplaySettings {
        capacity: count(
            p,
            "memory_capacity",
            preset.capacity as u64,
            1..=10_000_000,
            "capacity of the replay memory, in transitions; the oldest transition is dropped first",
        )? as usize,
        batch_size: count(
            p,
            "batch_size",
            preset.batch_size as u64,
            1..=65_536,
            "number of transitions per update of the training network, sampled uniformly without \
             replacement or, if priority_exponent is positive, by priority; updates begin once the \
             replay memory holds this many",
        )? as usize,
        planning_steps: count(
            p,
            "planning_steps",
            preset.planning_steps as u64,
            0..=1_000,
            "n in Dyna-Q: number of updates of the training network after every \
             update_interval-th environment step",
        )? as usize,
        update_interval: count(
            p,
            "update_interval",
            preset.update_interval as u64,
            1..=10_000,
            "interval between updates of the training network, in environment steps",
        )? as usize,
        priority_exponent: number(
            p,
            "priority_exponent",
            preset.priority_exponent,
            0.0..=1.0,
            "prioritized replay: exponent alpha of the temporal-difference errors to which \
             sampling probabilities are proportional; 0 samples uniformly",
        )?,
        importance_exponent: number(
            p,
            "importance_exponent",
            preset.importance_exponent,
            0.0..=1.0,
            "prioritized replay: exponent beta of the importance-sampling weights at the start of \
             training; it increases linearly to 1 over the episodes",
        )?,
        blocked_reward: number(
            p,
            "blocked_reward",
            preset.blocked_reward,
            -1e3..=1e3,
            "value added to the reward of a blocked move in the replay memory (reward shaping); a \
             negative value discourages collisions; not used in evaluation",
        )?,
        mirror: preset.mirror,
        history_dropout: number(
            p,
            "history_dropout",
            preset.history_dropout,
            0.0..=1.0,
            "data augmentation: probability that a sampled transition keeps only its latest k \
             images, with k drawn uniformly from 1 to observation_frames",
        )?,
    })
}

fn exploration_settings(
    p: &Parameters,
    preset: &ExplorationSettings,
) -> anyhow::Result<ExplorationSettings> {
    let EpsilonDecay { minimum, maximum, fraction } = preset.epsilon;
    let epsilon = EpsilonDecay {
        minimum: number(
            p,
            "epsilon_min",
            minimum,
            0.0..=1.0,
            "epsilon_min in eq. 4: exploration probability that the decay approaches",
        )?,
        maximum: number(
            p,
            "epsilon_max",
            maximum,
            0.0..=1.0,
            "epsilon_max in eq. 4: exploration probability in the first episode",
        )?,
        fraction: number(
            p,
            "exploration_fraction",
            fraction,
            1e-6..=1e6,
            "P in eq. 4: fraction of training episodes after which epsilon is about epsilon_min",
        )?,
    };
    // avoid_repetition also defines the policy, so `model_settings` declares it.
    Ok(ExplorationSettings { epsilon, avoid_repetition: preset.avoid_repetition })
}

fn optimizer_settings(
    p: &Parameters,
    preset: &OptimizerSettings,
) -> anyhow::Result<OptimizerSettings> {
    Ok(OptimizerSettings {
        learning_rate: number(
            p,
            "learning_rate",
            preset.learning_rate,
            0.0..=1.0,
            "alpha (section 2.3): learning rate of Adam at the start of training",
        )?,
        final_learning_rate_ratio: number(
            p,
            "final_learning_rate_ratio",
            preset.final_learning_rate_ratio,
            0.0..=1e3,
            "learning rate at the end of training divided by learning_rate; the rate changes \
             linearly over the episodes; 1 keeps it constant",
        )?,
        weight_decay: number(
            p,
            "weight_decay",
            preset.weight_decay,
            0.0..=1e3,
            "decoupled weight decay (AdamW): each update multiplies the weights by 1 - alpha * \
             weight_decay",
        )?,
        beta1: number(
            p,
            "adam_beta1",
            preset.beta1,
            0.0..=0.999_999,
            "beta1 of Adam: decay rate of the running mean of the gradients",
        )?,
        beta2: number(
            p,
            "adam_beta2",
            preset.beta2,
            0.0..=0.999_999,
            "beta2 of Adam: decay rate of the running mean of the squared gradients",
        )?,
        epsilon: number(
            p,
            "adam_epsilon",
            preset.epsilon,
            0.0..=1.0,
            "epsilon of Adam: added to the denominator of a step to avoid division by zero",
        )?,
    })
}

fn target_settings(p: &Parameters, preset: &TargetSettings) -> anyhow::Result<TargetSettings> {
    Ok(TargetSettings {
        discount: number(
            p,
            "discount",
            preset.discount,
            0.0..=1.0,
            "gamma in eq. 5: discount factor for future rewards",
        )?,
        double_q: declare(
            p,
            "double_q",
            preset.double_q,
            "Double DQN: the training network selects the action a' in eq. 5 and the target \
             network estimates its value; if false, the target network does both",
        )?,
        rate: number(
            p,
            "target_update",
            preset.rate,
            0.0..=1.0,
            "tau in eq. 6: fraction by which the target network moves towards the training network",
        )?,
        update_at: target_update_at(p, preset.update_at)?,
    })
}
