#!/usr/bin/env bash
# Drives with a trained model, as in deployment: in a simulator or, with --robot, on a robot.
# Builds the programs if necessary, then runs 'evac drive' with all arguments.
#
#   launch_scripts/drive.sh --help

set -euo pipefail
# A robot is a separate host, so discovery covers the subnet by default instead of only this host.
if [[ " $* " == *" --robot "* ]]; then
    export ROS_AUTOMATIC_DISCOVERY_RANGE="${ROS_AUTOMATIC_DISCOVERY_RANGE:-SUBNET}"
fi
# shellcheck source-path=SCRIPTDIR source=programs.sh
source "$(dirname "${BASH_SOURCE[0]}")/programs.sh"

build_nodes
exec "$bin/evac" drive "$@"
