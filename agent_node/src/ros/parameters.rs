//! The node's parameters: every option of the scripts and every number of a preset.

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
        ExplorationSettings, OptimizerSettings, Preset, ReplaySettings, Settings, TargetSettings,
        TargetUpdate,
    },
};
use ros_runtime::parameters::{
    Descriptor, FromParameter, ParameterError, ParameterValue, Parameters, read_file_of,
};
use task::{Scenario, seeds::MIXED};

/// What a parameter is unless somebody says otherwise: as a trained model's config.yaml says, or
/// else the program.
#[derive(Debug, Default)]
pub(super) struct Defaults(BTreeMap<String, ParameterValue>);

impl Defaults {
    /// Those of a trained model: what its network and its observation are made of.
    pub(super) fn of_model(directory: &Path) -> anyhow::Result<Defaults> {
        let file = directory.join("config.yaml");
        let context = || format!("no trained model in {}", directory.display());
        let values = read_file_of(&file, "/agent_node").with_context(context)?;
        anyhow::ensure!(!values.is_empty(), "{} says nothing of agent_node", file.display());
        Ok(Defaults(values))
    }

    fn get<T: FromParameter>(&self, name: &str, default: T) -> anyhow::Result<T> {
        let Some(value) = self.0.get(name) else {
            return Ok(default);
        };
        let converted = value.clone().converted(T::TYPE).ok();
        let wrong = || anyhow!("the model's config.yaml: {name} is {value}, expected {}", T::TYPE);
        converted.as_ref().and_then(T::from_value).ok_or_else(wrong)
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

/// Declares a read-only whole number within limits.
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

fn number(
    parameters: &Parameters,
    name: &str,
    default: f64,
    limits: std::ops::RangeInclusive<f64>,
    description: &str,
) -> Result<f64, ParameterError> {
    parameters.declare(name, default, Descriptor::read_only(description).range(limits))
}

/// A trained model, as its directory describes it.
pub struct TrainedModel {
    pub(super) directory: PathBuf,
    pub(super) defaults: Defaults,
    settings: Settings,
}

impl TrainedModel {
    /// Declares `model` and what makes its network and its observation.
    ///
    /// # Errors
    ///
    /// There is no trained model where `model` says, or a parameter is wrong.
    pub fn declare(parameters: &Parameters) -> anyhow::Result<TrainedModel> {
        let model = TrainedModel::declare_optional(parameters)?;
        let is_given = !model.directory.as_os_str().is_empty();
        anyhow::ensure!(is_given, "parameter 'model' is missing: give -p model:=DIRECTORY");
        Ok(model)
    }

    /// As [`declare`](Self::declare), but `model` may be missing: then the defaults are the program's.
    pub(super) fn declare_optional(parameters: &Parameters) -> anyhow::Result<TrainedModel> {
        let description = "the directory of a training, with model.safetensors and config.yaml";
        let directory = PathBuf::from(declare(parameters, "model", String::new(), description)?);
        let defaults = match directory.as_os_str().is_empty() {
            true => Defaults::default(),
            false => Defaults::of_model(&directory)?,
        };
        let (_, settings) = model_settings(parameters, &defaults)?;
        Ok(TrainedModel { directory, defaults, settings })
    }

    /// What the model does.
    pub fn policy(&self) -> anyhow::Result<Policy> {
        let network = load_model(&self.directory.join(RunDirectory::MODEL), &self.settings)?;
        Ok(Policy::new(&network, &self.settings)?)
    }
}

/// Declares `scenario`.
pub(super) fn scenario(parameters: &Parameters, defaults: &Defaults) -> anyhow::Result<String> {
    let choices = Scenario::ALL.map(Scenario::name).into_iter().chain([MIXED]);
    let description = "the scenario of every reset; mixed: one of all, drawn for each";
    let descriptor = Descriptor::read_only(description).choices(choices);
    let default = defaults.get("scenario", "empty".to_owned())?;
    Ok(parameters.declare("scenario", default, descriptor)?)
}

/// Declares `preset` and what makes the network and the observation.
pub(super) fn model_settings(
    parameters: &Parameters,
    defaults: &Defaults,
) -> anyhow::Result<(Preset, Settings)> {
    let choices = Descriptor::read_only("a named set of hyperparameters").choices(Preset::ALL);
    let preset: Preset = parameters
        .declare("preset", defaults.get("preset", Preset::default().to_string())?, choices)?
        .parse()?;
    let mut settings = preset.settings();
    let hidden: Vec<i64> = settings.network.hidden_layers.iter().map(|size| *size as i64).collect();
    let sizes = Descriptor::read_only("neurons of each hidden layer").range(1.0..=65_536.0);
    let hidden = defaults.get("hidden_layers", hidden)?;
    let hidden = parameters.declare("hidden_layers", hidden, sizes)?;
    settings.network.hidden_layers = hidden.into_iter().map(|size| size as usize).collect();
    let frames = defaults.get("observation_frames", settings.network.observation_frames as i64)?;
    settings.network.observation_frames = count(
        parameters,
        "observation_frames",
        // A model's own number may be anything; below the range it is refused as 0 is.
        u64::try_from(frames).unwrap_or(0),
        1..=64,
        "images in an observation: the present one and those before it, with the actions between",
    )? as usize;
    let avoids = defaults.get("avoid_repetition", settings.exploration.avoid_repetition)?;
    settings.exploration.avoid_repetition = declare(
        parameters,
        "avoid_repetition",
        avoids,
        "leave out actions that were tried from the very same image, not long ago in the episode",
    )?;
    Ok((preset, settings))
}

fn target_update_at(p: &Parameters, preset: TargetUpdate) -> anyhow::Result<TargetUpdate> {
    let choices = Descriptor::read_only("when eq. 6 is applied: after each episode or update")
        .choices(TargetUpdate::ALL);
    Ok(p.declare("target_update_at", preset.to_string(), choices)?.parse()?)
}

/// Declares the hyperparameters of a training; each is the preset's unless it is given.
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
            "how many experiences the replay memory keeps; the oldest goes first",
        )? as usize,
        batch_size: count(
            p,
            "batch_size",
            preset.batch_size as u64,
            1..=65_536,
            "how many different experiences an update is made from",
        )? as usize,
        planning_steps: count(
            p,
            "planning_steps",
            preset.planning_steps as u64,
            0..=1_000,
            "Dyna-Q's n: updates per step",
        )? as usize,
        blocked_reward: number(
            p,
            "blocked_reward",
            preset.blocked_reward,
            -1e3..=1e3,
            "what a blocked move adds to its reward, in training",
        )?,
        mirror: declare(
            p,
            "mirror",
            preset.mirror,
            "learn from half of the memories with left and right exchanged",
        )?,
        history_dropout: number(
            p,
            "history_dropout",
            preset.history_dropout,
            0.0..=1.0,
            "share of the memories of which only some of the images are seen",
        )?,
    })
}

fn exploration_settings(
    p: &Parameters,
    preset: &ExplorationSettings,
) -> anyhow::Result<ExplorationSettings> {
    let EpsilonDecay { minimum, maximum, fraction } = preset.epsilon;
    let epsilon = EpsilonDecay {
        minimum: number(p, "epsilon_min", minimum, 0.0..=1.0, "eq. 4")?,
        maximum: number(p, "epsilon_max", maximum, 0.0..=1.0, "eq. 4")?,
        fraction: number(
            p,
            "exploration_fraction",
            fraction,
            1e-6..=1e6,
            "P of eq. 4: the share of the episodes after which epsilon is about its minimum",
        )?,
    };
    // The policy of a trained model goes by avoid_repetition, too: it is declared with the model's.
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
            "alpha, the step size of Adam",
        )?,
        final_learning_rate_ratio: number(
            p,
            "final_learning_rate_ratio",
            preset.final_learning_rate_ratio,
            0.0..=1e3,
            "what share of learning_rate is left at the end, a straight line from the beginning",
        )?,
        weight_decay: number(
            p,
            "weight_decay",
            preset.weight_decay,
            0.0..=1e3,
            "by what a weight shrinks in an update, in units of alpha",
        )?,
        beta1: number(
            p,
            "adam_beta1",
            preset.beta1,
            0.0..=0.999_999,
            "decay of Adam's mean of the gradients",
        )?,
        beta2: number(
            p,
            "adam_beta2",
            preset.beta2,
            0.0..=0.999_999,
            "decay of Adam's mean of the squared gradients",
        )?,
        epsilon: number(
            p,
            "adam_epsilon",
            preset.epsilon,
            0.0..=1.0,
            "what keeps Adam from dividing by zero",
        )?,
    })
}

fn target_settings(p: &Parameters, preset: &TargetSettings) -> anyhow::Result<TargetSettings> {
    Ok(TargetSettings {
        discount: number(p, "discount", preset.discount, 0.0..=1.0, "gamma")?,
        double_q: declare(
            p,
            "double_q",
            preset.double_q,
            "double Q-learning: one network chooses the action that the other one values",
        )?,
        rate: number(p, "target_update", preset.rate, 0.0..=1.0, "tau of eq. 6")?,
        update_at: target_update_at(p, preset.update_at)?,
    })
}
