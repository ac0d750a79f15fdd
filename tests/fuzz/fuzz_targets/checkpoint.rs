//! A checkpoint, whose checksum is taken for right; a training that it brings back must go on.

#![no_main]

use learning::training::Training;
use evac_fuzz::{Files, Room, Silent, plan, settings};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let files = Files::new(&[("checkpoint.safetensors", data)]);
    let path = files.path("checkpoint.safetensors");
    if let Ok(mut training) = Training::load(&path, plan(), settings()) {
        // Until the room has had enough, or somebody sees that it is not the room of then.
        let _ = training.run(&mut [Room::new(20)], &mut Silent);
    }
});
