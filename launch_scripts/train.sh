#!/usr/bin/env bash
# Trains the agent over DDS, then evaluates it.
# Builds the programs if necessary, then runs 'evac train' with all arguments.
#
#   launch_scripts/train.sh --help

set -euo pipefail
# shellcheck source-path=SCRIPTDIR source=programs.sh
source "$(dirname "${BASH_SOURCE[0]}")/programs.sh"

build_nodes
exec "$bin/evac" train "$@"
