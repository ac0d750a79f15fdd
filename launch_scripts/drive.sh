#!/usr/bin/env bash
# Drives with a trained model as on a robot: builds what is not built, then 'evac drive' with all arguments.
#
#   launch_scripts/drive.sh --help

set -euo pipefail
# A robot is elsewhere in the network, unless the variable says otherwise.
if [[ " $* " == *" --robot "* ]]; then
    export ROS_AUTOMATIC_DISCOVERY_RANGE="${ROS_AUTOMATIC_DISCOVERY_RANGE:-SUBNET}"
fi
source "$(dirname "${BASH_SOURCE[0]}")/programs.sh"

build_nodes
exec "$bin/evac" drive "$@"
