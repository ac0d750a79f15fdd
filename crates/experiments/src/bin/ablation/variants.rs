//! The variants of the preset `robust` that the study compares.

use learning::settings::{Preset, Settings, TargetUpdate};

/// A training configuration of the study.
pub struct Variant {
    /// Identifies the variant in `ablation.json`. It must not change, because results are looked up
    /// by this key.
    pub key: &'static str,
    /// The row label in the tables.
    pub label: &'static str,
    /// Number of training episodes.
    pub episodes: u32,
    /// The hyperparameters.
    pub settings: Settings,
}

/// Returns all variants. The first is the full preset; all others train for a third of its
/// episodes. The second differs from the first only in the number of episodes and is the reference
/// for the variants after it.
pub fn variants() -> Vec<Variant> {
    let robust = Preset::Robust.settings();
    let paper = Preset::Paper.settings();
    let episodes = Preset::Robust.episodes();
    let short = |key, label, settings| Variant { key, label, episodes: episodes / 3, settings };
    vec![
        Variant { key: "robust", label: "`robust`", episodes, settings: robust.clone() },
        short("a third of the episodes", "a third of the episodes", robust.clone()),
        short(
            "one image",
            "no frame stacking",
            robust.clone().with(|s| s.network.observation_frames = 1),
        ),
        short(
            "may repeat itself",
            "no repetition mask",
            robust.clone().with(|s| s.exploration.avoid_repetition = false),
        ),
        short(
            "blocked moves cost nothing more",
            "no extra cost for blocked moves",
            robust.clone().with(|s| s.replay.blocked_reward = 0.0),
        ),
        short(
            "no mirror",
            "no mirror augmentation",
            robust.clone().with(|s| s.replay.mirror = false),
        ),
        short(
            "always all images",
            "no history dropout",
            robust.clone().with(|s| s.replay.history_dropout = 0.0),
        ),
        short(
            "no weight decay",
            "no weight decay",
            robust.clone().with(|s| s.optimizer.weight_decay = 0.0),
        ),
        short(
            "the paper's target network",
            "target network of `paper`",
            robust.clone().with(|s| {
                s.target.rate = paper.target.rate;
                s.target.update_at = TargetUpdate::Episode;
            }),
        ),
        short(
            "with double Q-learning",
            "with double Q-learning",
            robust.with(|s| s.target.double_q = true),
        ),
    ]
}
