#!/usr/bin/env bash
# Trains for a million steps over an unreliable network.
# Builds the programs if necessary, then runs 'evac soak' with all arguments.
#
#   launch_scripts/soak.sh --help

set -euo pipefail
# shellcheck source-path=SCRIPTDIR source=programs.sh
source "$(dirname "${BASH_SOURCE[0]}")/programs.sh"

build_experiments
exec "$bin/evac" soak "$@"
