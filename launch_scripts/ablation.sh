#!/usr/bin/env bash
# Trains and evaluates the preset robust with one change at a time.
# Builds the programs if necessary, then runs 'evac ablation' with all arguments.
#
#   launch_scripts/ablation.sh --help

set -euo pipefail
# shellcheck source-path=SCRIPTDIR source=programs.sh
source "$(dirname "${BASH_SOURCE[0]}")/programs.sh"

build_experiments
exec "$bin/evac" ablation "$@"
