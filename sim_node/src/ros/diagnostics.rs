//! The diagnostics of the node: `camera`, `room` and `perturbations`.

use std::{
    sync::{
        Arc,
        atomic::{AtomicU64, Ordering},
    },
    time::Instant,
};

use parking_lot::Mutex;
use ros_runtime::diagnostics::{Diagnostics, Level, Report};

use crate::{
    reality::{Conditions, Randomization, Reality, Tint},
    world::World,
};

/// Event counts since the node started.
#[derive(Debug, Default)]
pub(super) struct Counters {
    /// Published images.
    pub(super) images: AtomicU64,
    /// Images lost on their way from the camera.
    pub(super) lost_images: AtomicU64,
    /// Executed steps.
    pub(super) steps: AtomicU64,
    /// Started episodes.
    pub(super) episodes: AtomicU64,
    /// Refused requests and commands.
    pub(super) refused: AtomicU64,
    /// The perturbations, and what was drawn for the current episode.
    perturbations: Mutex<(Reality, Conditions)>,
}

impl Counters {
    /// Increments a counter.
    pub(super) fn count(counter: &AtomicU64) {
        counter.fetch_add(1, Ordering::Relaxed);
    }

    /// Records the perturbations of an episode that starts.
    pub(super) fn record_perturbations(&self, world: &World) {
        let mut recorded = self.perturbations.lock();
        if recorded.0 != *world.reality() || recorded.1 != *world.conditions() {
            *recorded = (*world.reality(), world.conditions().clone());
        }
    }

    /// Creates the counters and registers them with `diagnostics` as `camera`, `room` and
    /// `perturbations`.
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
                values: vec![
                    ("rate, 1/s", format!("{rate:.1}")),
                    ("images", images.to_string()),
                    ("lost images", camera.lost_images.load(Ordering::Relaxed).to_string()),
                ],
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
        let perturbed = counters.clone();
        diagnostics.add("perturbations", move || {
            let (reality, conditions) = perturbed.perturbations.lock().clone();
            Report {
                level: Level::Ok,
                message: Randomization::matching(&reality)
                    .map_or("custom".to_owned(), |level| level.to_string()),
                values: values(&conditions),
            }
        });
        counters
    }
}

/// Returns what was drawn for an episode, and the strength of its noise.
fn values(conditions: &Conditions) -> Vec<(&'static str, String)> {
    let Conditions { camera, light, surfaces, motion, odometry, obstacles, .. } = conditions;
    let number = |value: f64| format!("{value:.3}");
    let degrees = |angle: f64| number(angle.to_degrees());
    let tint = |tint: &Tint| format!("{} {}", degrees(tint.hue), number(tint.brightness));
    vec![
        ("camera noise, grey levels", number(camera.noise)),
        ("camera gain", number(camera.gain)),
        ("camera white balance, RGB", camera.color.map(number).join(" ")),
        ("camera pitch error, degrees", degrees(camera.pitch)),
        ("camera roll error, degrees", degrees(camera.roll)),
        ("camera yaw error, degrees", degrees(camera.yaw)),
        ("camera height error, m", number(camera.height)),
        ("camera field of view error", number(camera.lens)),
        ("camera latency, s", number(camera.latency)),
        ("camera drop rate", number(camera.drop_rate)),
        ("light azimuth error, degrees", degrees(light.azimuth)),
        ("light elevation error, degrees", degrees(light.elevation)),
        ("hue turn of walls, degrees, and brightness", tint(&surfaces.wall)),
        ("hue turn of exit, degrees, and brightness", tint(&surfaces.exit)),
        ("hue turn of obstacles, degrees, and brightness", tint(&surfaces.obstacle)),
        ("hue turn of floor, degrees, and brightness", tint(&surfaces.floor)),
        ("hue turn of sky, degrees, and brightness", tint(&surfaces.sky)),
        ("turn noise, degrees", degrees(motion.turn_noise)),
        ("turn bias, degrees", degrees(motion.turn_bias)),
        ("step noise", number(motion.step_noise)),
        ("step bias", number(motion.step_bias)),
        ("blocked moves stop short", motion.stops_short.to_string()),
        ("odometry noise", number(odometry.noise)),
        ("odometry drift of distances", number(odometry.step_drift)),
        ("odometry drift of turns", number(odometry.turn_drift)),
        ("obstacle speed factor", number(obstacles.speed)),
    ]
}
