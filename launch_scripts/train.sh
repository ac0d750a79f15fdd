#!/usr/bin/env bash
# Trains the agent over DDS, then tests it: builds what is not built, then 'evac train' with all arguments.
#
#   launch_scripts/train.sh --help

set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/programs.sh"

build_nodes
exec "$bin/evac" train "$@"
