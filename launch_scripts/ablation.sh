#!/usr/bin/env bash
# Trains the preset robust without each of its ingredients, in every scenario, and writes what becomes
# of it into docs/results.md.
#
#   launch_scripts/ablation.sh [--seed N] [--jobs N] [--out FILE]
#
#   --seed N     the seed of the trainings (default: 0)
#   --jobs N     trainings at the same time (default: 2)
#   --out FILE   the figures as JSON; what is there already is not done again
#                (default: ablation.json)
#
# World and learner share a process here, which changes no result: no nodes, no DDS.

set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/nodes.sh"

seed=0 jobs=2 out=$root/ablation.json
while [[ $# -gt 0 ]]; do
    case "$1" in
        --seed) need_value "$@" && seed=$2 && shift 2 ;;
        --jobs) need_value "$@" && jobs=$2 && shift 2 ;;
        --out) need_value "$@" && out=$(realpath "$2") && shift 2 ;;
        -h | --help) usage && exit 0 ;;
        *) fail "unknown option '$1'; see --help" ;;
    esac
done
run_cargo build --package evac_tests --features benchmark --bin ablation
cd "$root"
exec "$(realpath "${CARGO_TARGET_DIR:-target}")/release/ablation" --seed "$seed" --jobs "$jobs" \
    --out "$out" --results docs/results.md
