#!/usr/bin/env bash
# A training of a million steps over a bad network: builds what is not built, then 'evac soak' with all arguments.
#
#   launch_scripts/soak.sh --help

set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/programs.sh"

build_experiments
exec "$bin/evac" soak "$@"
