//! Publishes the progress of training.

use evac_msgs::TrainingStatus;
use ros_interfaces::std_msgs::Header;
use ros_runtime::{Clock, Publisher};

use super::console::recent_success;
use learning::{record::EpisodeRecord, training::Training};

/// Publishes `training_status` for the episode of `record`, which has just ended.
pub(super) fn publish_status(
    publisher: &Publisher<TrainingStatus>,
    clock: &Clock,
    training: &Training,
    record: &EpisodeRecord,
) {
    publisher.publish_with(|| TrainingStatus {
        header: Header { stamp: clock.now(), ..Header::default() },
        episode: record.episode,
        episodes: training.plan.episodes,
        steps: record.steps,
        total_steps: training.progress.total_steps,
        episode_return: record.episode_return,
        epsilon: record.epsilon as f32,
        // NaN: no update in this episode.
        loss: record.loss.map_or(f32::NAN, |loss| loss as f32),
        steps_per_s: training.steps_per_s() as f32,
        success_rate: recent_success(&training.progress.records) as f32,
    });
}
