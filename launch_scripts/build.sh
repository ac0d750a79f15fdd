#!/usr/bin/env bash
# Builds the nodes and evac with the corrected RustDDS, in target/release.
#
#   launch_scripts/build.sh
#
# With ROS_SECURITY_ENABLE=true the nodes are built with SROS2 (docs/security.md).

set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/programs.sh"

[[ $# == 0 ]] || { usage && exit 0; }
build_nodes
