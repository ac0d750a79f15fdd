//! A listener that ignores all events.

use learning::{
    evaluation::EvaluationListener,
    record::EpisodeRecord,
    training::{Listener, Training},
};

/// Ignores all events of a training run or an evaluation.
pub struct NullListener;

impl Listener for NullListener {
    fn episode(&mut self, _training: &Training, _record: &EpisodeRecord) -> anyhow::Result<()> {
        Ok(())
    }
}

impl EvaluationListener for NullListener {}
