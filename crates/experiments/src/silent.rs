//! Who does not want to know how a training or a test goes.

use learning::{
    evaluation::TestListener,
    record::EpisodeRecord,
    training::{Listener, Training},
};

/// Listens, and does nothing.
pub struct Silent;

impl Listener for Silent {
    fn episode(&mut self, _training: &Training, _record: &EpisodeRecord) -> anyhow::Result<()> {
        Ok(())
    }
}

impl TestListener for Silent {}
