//! Checks that an independent client can call `/reset` and `/step`.

use std::{num::NonZeroU64, path::PathBuf, process::Command};

use crc::{CRC_32_ISO_HDLC, Crc};
use sim_node::world::WorldSettings;
use task::{Action, Environment};

use crate::{Nodes, Room, TIMEOUT};

/// Number of steps that the client takes.
const STEPS: u64 = 1000;

/// Returns the path of the Fast DDS client, which `launch_scripts/test.sh --all` builds.
///
/// # Panics
///
/// Panics if `EVAC_FAST_DDS_PEER` is not set.
pub fn fast_dds_peer() -> PathBuf {
    std::env::var_os("EVAC_FAST_DDS_PEER")
        .expect("EVAC_FAST_DDS_PEER must name the peer: run launch_scripts/test.sh --all")
        .into()
}

/// Runs a client that takes `STEPS` steps with the actions 1, 2, ..., 6, 0, ... and, whenever an
/// episode ends, starts the next; the seeds are 1, 2, ... Asserts that it received the images and
/// outcomes that the simulation in this process produces for the same seeds and actions.
///
/// # Panics
///
/// Panics if the client fails or its output differs.
pub fn assert_calls_the_services(nodes: &Nodes, mut caller: Command) {
    let (steps, timeout) = (STEPS.to_string(), TIMEOUT.as_secs().to_string());
    let (status, text, error) = nodes.run(caller.args(["--steps", &steps, "--timeout", &timeout]));
    assert!(status.success(), "{error}");
    let found: serde_json::Value = serde_json::from_str(&text).expect("JSON");

    let mut room = Room::new(WorldSettings::default());
    let (mut seed, mut successes, mut is_over) = (0, 0u64, true);
    let crc = Crc::<u32>::new(&CRC_32_ISO_HDLC);
    let mut digest = crc.digest();
    for sequence in 1..=STEPS {
        if is_over {
            seed += 1;
            let seed = NonZeroU64::new(seed).expect("seeds start at 1");
            digest.update(room.reset(seed, "empty").expect("a reset").bytes());
        }
        let action = Action::try_from((sequence % 7) as u8).expect("an action");
        let step = room.step(action).expect("a step");
        digest.update(step.image.bytes());
        successes += u64::from(step.terminated);
        is_over = step.terminated || step.truncated;
    }
    let expected = serde_json::json!({
        "right": STEPS, "escapes": successes, "checksum": digest.finalize(),
    });
    assert_eq!(found, expected);
}
