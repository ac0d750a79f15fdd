//! Reports training progress to the console, topics, diagnostics and TensorBoard, and saves
//! checkpoints.

use evac_msgs::TrainingStatus;
use learning::{
    dyna_q::Decision,
    record::EpisodeRecord,
    saver::Saver,
    training::{Listener, Training},
};
use log::warn;
use report::TensorBoard;
use ros_runtime::{Clock, Publisher};

use super::{
    announcer::Announcer, console::Console, diagnostics::LearnerState, publishers::publish_status,
};

/// The [`Listener`] of `agent_node train`.
pub(super) struct TrainingListener {
    pub(super) console: Console,
    /// One announcer per environment, in the order of the environments.
    pub(super) announcers: Vec<Announcer>,
    /// `None` after a write error, which disables TensorBoard logging.
    pub(super) board: Option<TensorBoard>,
    pub(super) saver: Saver,
    pub(super) statuses: Publisher<TrainingStatus>,
    pub(super) clock: Clock,
    pub(super) state: LearnerState,
    pub(super) checkpoint_interval: u32,
    /// Number of reported episodes, including those before a resume. `Training::episode` may be
    /// ahead, because several environments can finish episodes in the same step.
    pub(super) reported_episodes: u32,
}

impl Listener for TrainingListener {
    fn decision(&mut self, environment: usize, decision: &Decision) {
        self.announcers[environment].announce(decision);
    }

    fn episode(&mut self, training: &Training, record: &EpisodeRecord) -> anyhow::Result<()> {
        if let Some(board) = &mut self.board
            && let Err(error) = board.record(record, training.progress.total_steps)
        {
            warn!("TensorBoard logging is disabled: {:#}", anyhow::Error::from(error));
            self.board = None;
        }
        publish_status(&self.statuses, &self.clock, training, record);
        self.state.update(training);
        self.console.training_episode(training);
        self.reported_episodes += 1;
        let reported = self.reported_episodes;
        // The caller of `Training::run` saves the last checkpoint.
        if reported.is_multiple_of(self.checkpoint_interval) && reported < training.plan.episodes {
            self.saver.save(training)?;
        }
        Ok(())
    }
}
