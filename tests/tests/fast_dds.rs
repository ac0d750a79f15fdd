//! Calls the services with Fast DDS, the DDS implementation of ROS 2's default middleware.
//!
//! `launch_scripts/test.sh --all` builds the C++ peer.

use evac_tests::{Nodes, assert_calls_the_services, fast_dds_peer};

#[test]
fn fast_dds_calls_the_services_with_the_mapping_of_rmw_fastrtps() {
    let mut nodes = Nodes::new();
    nodes.set_variable("RMW_IMPLEMENTATION", "rmw_fastrtps_cpp");
    nodes.start_simulator(&[]);
    assert_calls_the_services(&nodes, nodes.command(fast_dds_peer()));
}
