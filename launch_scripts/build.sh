#!/usr/bin/env bash
# Builds both nodes with the corrected RustDDS, in target/release.
#
#   launch_scripts/build.sh
#
# With ROS_SECURITY_ENABLE=true they are built with SROS2 (docs/security.md).

set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/nodes.sh"

[[ $# == 0 ]] || { usage && exit 0; }
build_nodes
