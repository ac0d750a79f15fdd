#!/usr/bin/env bash
# Evaluates a trained model over DDS.
# Builds the programs if necessary, then runs 'evac evaluate' with all arguments.
#
#   launch_scripts/evaluate.sh --help

set -euo pipefail
# shellcheck source-path=SCRIPTDIR source=programs.sh
source "$(dirname "${BASH_SOURCE[0]}")/programs.sh"

build_nodes
exec "$bin/evac" evaluate "$@"
