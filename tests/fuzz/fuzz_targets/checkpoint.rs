//! Loads a checkpoint without verifying its checksum. If it loads, the training run must continue.

#![no_main]

use learning::training::Training;
use evac_fuzz::{Files, Room, NullListener, plan, settings};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let files = Files::new(&[("checkpoint.safetensors", data)]);
    let path = files.path("checkpoint.safetensors");
    if let Ok(mut training) = Training::load(&path, plan(), settings()) {
        // Ends with an error when the environment fails or differs from the checkpoint's.
        let _ = training.run(&mut [Room::new(20)], &mut NullListener);
    }
});
