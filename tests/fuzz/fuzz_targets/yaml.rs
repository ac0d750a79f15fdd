//! Parses a parameter file.

#![no_main]

use libfuzzer_sys::fuzz_target;
use ros_runtime::parameters::read_file_of;

fuzz_target!(|data: &[u8]| {
    let file = evac_fuzz::Files::new(&[("parameters.yaml", data)]);
    let _ = read_file_of(&file.path("parameters.yaml"), "/robot1/one/two/sim_node");
});
