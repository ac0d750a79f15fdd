#!/usr/bin/env bash
# Builds the nodes and evac in target/release, with the corrections of RustDDS in patches/rustdds.
#
#   launch_scripts/build.sh
#
# With ROS_SECURITY_ENABLE=true, the nodes are built with SROS2 (docs/security.md).

set -euo pipefail
# shellcheck source-path=SCRIPTDIR source=programs.sh
source "$(dirname "${BASH_SOURCE[0]}")/programs.sh"

accept_no_options "$@"
build_nodes
