//! What happens beside a training: it is shown, published and saved.

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

/// Hears of the decisions and episodes of a training.
pub(super) struct TrainingListener {
    pub(super) console: Console,
    /// One for each room.
    pub(super) announcers: Vec<Announcer>,
    /// None once it cannot be written.
    pub(super) board: Option<TensorBoard>,
    pub(super) saver: Saver,
    pub(super) statuses: Publisher<TrainingStatus>,
    pub(super) clock: Clock,
    pub(super) state: LearnerState,
    pub(super) checkpoint_interval: u32,
    /// Episodes that were told of.
    pub(super) done: u32,
}

impl Listener for TrainingListener {
    fn decision(&mut self, room: usize, decision: &Decision) {
        self.announcers[room].announce(decision);
    }

    fn episode(&mut self, training: &Training, record: &EpisodeRecord) -> anyhow::Result<()> {
        if let Some(board) = &mut self.board
            && let Err(error) = board.record(record, training.progress.total_steps)
        {
            warn!("{:#}: the training goes on without", anyhow::Error::from(error));
            self.board = None;
        }
        publish_status(&self.statuses, &self.clock, training, record);
        self.state.update(training);
        self.console.training_episode(training);
        self.done += 1;
        let done = self.done;
        if done.is_multiple_of(self.checkpoint_interval) && done < training.plan.episodes {
            self.saver.save(training)?;
        }
        Ok(())
    }
}
