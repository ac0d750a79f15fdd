#!/usr/bin/env bash
# Measures speed: builds what is not built, then 'evac bench' with all arguments.
#
#   launch_scripts/bench.sh --help

set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/programs.sh"

build_experiments
exec "$bin/evac" bench "$@"
