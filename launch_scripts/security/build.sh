#!/usr/bin/env bash
# Builds both nodes with security, in target/release: see docs/security.md.

set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../nodes.sh"

[[ $# == 0 ]] || { usage && exit 0; }
ROS_SECURITY_ENABLE=true build_nodes
echo "sim_node and agent_node are in $bin, with security."
