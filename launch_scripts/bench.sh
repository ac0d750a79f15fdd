#!/usr/bin/env bash
# Measures the speed of the learner, the simulator and the network.
# Builds the programs if necessary, then runs 'evac bench' with all arguments.
#
#   launch_scripts/bench.sh --help

set -euo pipefail
# shellcheck source-path=SCRIPTDIR source=programs.sh
source "$(dirname "${BASH_SOURCE[0]}")/programs.sh"

build_experiments
exec "$bin/evac" bench "$@"
