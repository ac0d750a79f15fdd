#!/usr/bin/env bash
# Tests a trained model over DDS: builds what is not built, then 'evac evaluate' with all arguments.
#
#   launch_scripts/evaluate.sh --help

set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/programs.sh"

build_nodes
exec "$bin/evac" evaluate "$@"
