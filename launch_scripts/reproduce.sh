#!/usr/bin/env bash
# Trains and tests everything that the results show: builds what is not built, then 'evac reproduce' with all arguments.
#
#   launch_scripts/reproduce.sh --help

set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/programs.sh"

build_experiments
exec "$bin/evac" reproduce "$@"
