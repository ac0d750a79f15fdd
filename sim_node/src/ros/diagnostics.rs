//! The diagnostics of the node: `camera` and `room`.

use std::{
    sync::{
        Arc,
        atomic::{AtomicU64, Ordering},
    },
    time::Instant,
};

use ros_runtime::diagnostics::{Diagnostics, Level, Report};

/// Event counts since the node started.
#[derive(Debug, Default)]
pub(super) struct Counters {
    /// Published images.
    pub(super) images: AtomicU64,
    /// Executed steps.
    pub(super) steps: AtomicU64,
    /// Started episodes.
    pub(super) episodes: AtomicU64,
    /// Refused requests and commands.
    pub(super) refused: AtomicU64,
}

impl Counters {
    /// Increments a counter.
    pub(super) fn count(counter: &AtomicU64) {
        counter.fetch_add(1, Ordering::Relaxed);
    }

    /// Creates the counters and registers them with `diagnostics` as `camera` and `room`.
    pub(super) fn reported_by(diagnostics: &Diagnostics) -> Arc<Counters> {
        let counters = Arc::new(Counters::default());
        let camera = counters.clone();
        let mut last = (Instant::now(), 0);
        diagnostics.add("camera", move || {
            let (now, images) = (Instant::now(), camera.images.load(Ordering::Relaxed));
            let (before, images_before) = std::mem::replace(&mut last, (now, images));
            let seconds = now.duration_since(before).as_secs_f64().max(f64::MIN_POSITIVE);
            let rate = (images - images_before) as f64 / seconds;
            Report {
                level: Level::Ok,
                message: format!("{rate:.1} images per second"),
                values: vec![("rate, 1/s", format!("{rate:.1}")), ("images", images.to_string())],
            }
        });
        let room = counters.clone();
        diagnostics.add("room", move || {
            let number = |counter: &AtomicU64| counter.load(Ordering::Relaxed).to_string();
            Report {
                level: Level::Ok,
                message: format!("episode {}", number(&room.episodes)),
                values: vec![
                    ("episodes", number(&room.episodes)),
                    ("steps", number(&room.steps)),
                    ("refused requests and commands", number(&room.refused)),
                ],
            }
        });
        counters
    }
}
