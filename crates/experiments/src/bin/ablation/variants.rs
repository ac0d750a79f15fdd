//! The preset, and what is left of it without one ingredient each.

use learning::settings::{Preset, Settings, TargetUpdate};

/// A training that is compared with others.
pub struct Variant {
    /// What is different, for people.
    pub name: &'static str,
    pub episodes: u32,
    pub settings: Settings,
}

/// All of them: the whole preset first. The others have a third of its episodes, as the second
/// one, which they are to be compared with.
pub fn variants() -> Vec<Variant> {
    let robust = Preset::Robust.settings();
    let paper = Preset::Paper.settings();
    let episodes = Preset::Robust.episodes();
    let without = |name, settings| Variant { name, episodes: episodes / 3, settings };
    vec![
        Variant { name: "robust", episodes, settings: robust.clone() },
        without("a third of the episodes", robust.clone()),
        without("one image", robust.clone().with(|s| s.network.observation_frames = 1)),
        without(
            "may repeat itself",
            robust.clone().with(|s| s.exploration.avoid_repetition = false),
        ),
        without(
            "blocked moves cost nothing more",
            robust.clone().with(|s| s.replay.blocked_reward = 0.0),
        ),
        without("no mirror", robust.clone().with(|s| s.replay.mirror = false)),
        without("always all images", robust.clone().with(|s| s.replay.history_dropout = 0.0)),
        without("no weight decay", robust.clone().with(|s| s.optimizer.weight_decay = 0.0)),
        without(
            "the paper's target network",
            robust.clone().with(|s| {
                s.target.rate = paper.target.rate;
                s.target.update_at = TargetUpdate::Episode;
            }),
        ),
        without("with double Q-learning", robust.with(|s| s.target.double_q = true)),
    ]
}
