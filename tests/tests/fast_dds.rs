//! The services as Fast DDS, the DDS of ROS 2's default middleware, calls them.
//!
//! `launch_scripts/test.sh --all` builds the peer, which is not on PyPI.

use evac_tests::{Nodes, assert_calls_the_services, fast_dds_peer};

#[test]
fn fast_dds_calls_the_services_as_its_rmw_maps_them() {
    let mut nodes = Nodes::new();
    nodes.set_variable("RMW_IMPLEMENTATION", "rmw_fastrtps_cpp");
    nodes.start_simulator(&[]);
    assert_calls_the_services(&nodes, nodes.command(fast_dds_peer()));
}
