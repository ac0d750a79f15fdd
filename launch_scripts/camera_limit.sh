#!/usr/bin/env bash
# Estimates how short the paths can be for a robot that sees only through its camera.
# Builds the programs if necessary, then runs 'evac camera-limit' with all arguments.
#
#   launch_scripts/camera_limit.sh --help

set -euo pipefail
# shellcheck source-path=SCRIPTDIR source=programs.sh
source "$(dirname "${BASH_SOURCE[0]}")/programs.sh"

build_experiments
exec "$bin/evac" camera-limit "$@"
