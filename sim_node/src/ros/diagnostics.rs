//! What the node says of itself on `/diagnostics`.

use std::{
    sync::{
        Arc,
        atomic::{AtomicU64, Ordering},
    },
    time::Instant,
};

use ros_runtime::diagnostics::{Diagnostics, Level, Report};

/// What has been counted since the start.
#[derive(Debug, Default)]
pub(super) struct Counters {
    pub(super) images: AtomicU64,
    pub(super) steps: AtomicU64,
    pub(super) episodes: AtomicU64,
    /// Requests and commands that were refused.
    pub(super) refused: AtomicU64,
}

impl Counters {
    /// Counts one more.
    pub(super) fn count(counter: &AtomicU64) {
        counter.fetch_add(1, Ordering::Relaxed);
    }

    /// Counters that are reported from now on.
    pub(super) fn reported_by(diagnostics: &Diagnostics) -> Arc<Counters> {
        let counters = Arc::new(Counters::default());
        let counted = counters.clone();
        let mut last = (Instant::now(), 0);
        diagnostics.add("camera", move || {
            let (now, images) = (Instant::now(), counted.images.load(Ordering::Relaxed));
            let (before, images_before) = std::mem::replace(&mut last, (now, images));
            let seconds = now.duration_since(before).as_secs_f64().max(f64::MIN_POSITIVE);
            let rate = (images - images_before) as f64 / seconds;
            Report {
                level: Level::Ok,
                message: format!("{rate:.1} images a second"),
                values: vec![("rate, 1/s", format!("{rate:.1}")), ("images", images.to_string())],
            }
        });
        let counted = counters.clone();
        diagnostics.add("room", move || {
            let number = |counter: &AtomicU64| counter.load(Ordering::Relaxed).to_string();
            Report {
                level: Level::Ok,
                message: format!("episode {}", number(&counted.episodes)),
                values: vec![
                    ("episodes", number(&counted.episodes)),
                    ("steps", number(&counted.steps)),
                    ("refused", number(&counted.refused)),
                ],
            }
        });
        counters
    }
}
