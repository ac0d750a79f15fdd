//! The variants of the preset `robust` that the study compares.

use experiments::reproduction::training_randomization;
use learning::settings::{Architecture, Preset, Settings, TargetUpdate};
use sim_node::reality::Randomization;

/// A training configuration of the study.
pub struct Variant {
    /// Identifies the variant in the tables and in `ablation.json`.
    pub name: &'static str,
    /// Number of training episodes.
    pub episodes: u32,
    /// The randomization of the training.
    pub randomization: Randomization,
    /// The hyperparameters.
    pub settings: Settings,
}

/// Returns all variants. The first is the full preset; the others each change one thing.
pub fn variants() -> Vec<Variant> {
    let robust = || Variant {
        name: "`robust`",
        episodes: Preset::Robust.episodes(),
        randomization: training_randomization(Preset::Robust),
        settings: Preset::Robust.settings(),
    };
    let with = |name, change: fn(&mut Settings)| Variant {
        name,
        settings: robust().settings.with(change),
        ..robust()
    };
    let randomized = |name, randomization| Variant { name, randomization, ..robust() };
    vec![
        robust(),
        randomized("no domain randomization", Randomization::None),
        randomized("randomization `mild`", Randomization::Mild),
        with("no prioritized replay", |s| s.replay.priority_exponent = 0.0),
        with("no shared encoder", |s| s.network.architecture = Architecture::Mlp),
        Variant {
            episodes: Preset::Robust.episodes() / 3,
            ..with("a third of the episodes, an update every step", |s| {
                s.replay.update_interval = 1;
            })
        },
        with("two updates every three steps", |s| s.replay.planning_steps = 2),
        with("no frame stacking", |s| s.network.observation_frames = 1),
        with("six stacked frames", |s| s.network.observation_frames = 6),
        with("hidden layers 128, 256, 128", |s| s.network.hidden_layers = vec![128, 256, 128]),
        with("no repetition avoidance", |s| s.exploration.avoid_repetition = false),
        with("no penalty for blocked moves", |s| s.replay.blocked_reward = 0.0),
        with("no mirror augmentation", |s| s.replay.mirror = false),
        with("no history dropout", |s| s.replay.history_dropout = 0.0),
        with("no weight decay", |s| s.optimizer.weight_decay = 0.0),
        with("constant learning rate", |s| s.optimizer.final_learning_rate_ratio = 1.0),
        with("learning rate of `paper`", |s| {
            s.optimizer.learning_rate = Preset::Paper.settings().optimizer.learning_rate;
        }),
        with("target network of `paper`", |s| {
            s.target.rate = Preset::Paper.settings().target.rate;
            s.target.update_at = TargetUpdate::Episode;
        }),
        with("double Q-learning", |s| s.target.double_q = true),
        with("batches of 128", |s| s.replay.batch_size = 128),
    ]
}
