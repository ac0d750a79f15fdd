//! What a peer that calls the services must find.

use std::{num::NonZeroU64, path::PathBuf, process::Command};

use crc::{CRC_32_ISO_HDLC, Crc};
use sim_node::world::WorldSettings;
use task::{Action, Environment};

use crate::{Nodes, PATIENCE, Room};

/// How many steps a caller of the services takes.
const STEPS: u64 = 1000;

/// The peer with Fast DDS that `launch_scripts/test.sh --all` builds.
pub fn fast_dds_peer() -> PathBuf {
    std::env::var_os("EVAC_FAST_DDS_PEER")
        .expect("EVAC_FAST_DDS_PEER names the peer: run launch_scripts/test.sh --all")
        .into()
}

/// Has a peer take [`STEPS`] steps with the actions 1, 2, ... 6, 0, ...; an episode that is over is
/// followed by one with the next seed, from 1. All must be as by world and camera alone.
pub fn assert_calls_the_services(nodes: &Nodes, mut caller: Command) {
    let (steps, timeout) = (STEPS.to_string(), PATIENCE.as_secs().to_string());
    let (status, text, error) = nodes.run(caller.args(["--steps", &steps, "--timeout", &timeout]));
    assert!(status.success(), "{error}");
    let found: serde_json::Value = serde_json::from_str(&text).expect("JSON");

    let mut room = Room::new(WorldSettings::default());
    let (mut seed, mut escapes, mut over) = (0, 0u64, true);
    let crc = Crc::<u32>::new(&CRC_32_ISO_HDLC);
    let mut digest = crc.digest();
    for sequence in 1..=STEPS {
        if over {
            seed += 1;
            let seed = NonZeroU64::new(seed).expect("it counts from 1");
            digest.update(room.reset(seed, "empty").expect("a reset").bytes());
        }
        let action = Action::try_from((sequence % 7) as u8).expect("an action");
        let step = room.step(action).expect("a step");
        digest.update(step.image.bytes());
        escapes += u64::from(step.terminated);
        over = step.terminated || step.truncated;
    }
    let expected = serde_json::json!({
        "right": STEPS, "escapes": escapes, "checksum": digest.finalize(),
    });
    assert_eq!(found, expected);
}
