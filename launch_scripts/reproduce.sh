#!/usr/bin/env bash
# Trains and evaluates every policy of docs/results.md.
# Builds the programs if necessary, then runs 'evac reproduce' with all arguments.
#
#   launch_scripts/reproduce.sh --help

set -euo pipefail
# shellcheck source-path=SCRIPTDIR source=programs.sh
source "$(dirname "${BASH_SOURCE[0]}")/programs.sh"

build_experiments
exec "$bin/evac" reproduce "$@"
