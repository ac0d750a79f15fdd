#!/usr/bin/env bash
# Trains without each ingredient of the preset robust: builds what is not built, then 'evac ablation' with all arguments.
#
#   launch_scripts/ablation.sh --help

set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/programs.sh"

build_experiments
exec "$bin/evac" ablation "$@"
