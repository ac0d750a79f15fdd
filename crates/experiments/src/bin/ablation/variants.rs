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
        without("one image", Settings { observation_frames: 1, ..robust.clone() }),
        without("may repeat itself", Settings { avoid_repetition: false, ..robust.clone() }),
        without(
            "blocked moves cost nothing more",
            Settings { blocked_reward: 0.0, ..robust.clone() },
        ),
        without("no mirror", Settings { mirror: false, ..robust.clone() }),
        without("always all images", Settings { history_dropout: 0.0, ..robust.clone() }),
        without("no weight decay", Settings { weight_decay: 0.0, ..robust.clone() }),
        without(
            "the paper's target network",
            Settings {
                target_update: paper.target_update,
                target_update_at: TargetUpdate::Episode,
                ..robust.clone()
            },
        ),
        without("with double Q-learning", Settings { double_q: true, ..robust }),
    ]
}
