#!/usr/bin/env bash
# Measures learner, simulator and network beside their rulers: a table, and the figures as JSON.
#
#   launch_scripts/bench.sh [--out FILE] [--peers] [--scale]
#
#   --out FILE   where the figures go (default: bench.json)
#   --peers      measures other people's software in the same run: PyTorch, Stable-Baselines3 and
#                CycloneDDS from PyPI, and CycloneDDS's ddsperf where it is on the PATH (Debian:
#                cyclonedds-tools)
#   --scale      trains in 1, 2, 4 and 8 rooms at once that take 10 ms for a move: ten minutes more
#
# The peers from PyPI go into a virtual environment, .venv-bench in the repository: some 5 GB, because
# PyTorch's package brings CUDA along. A run takes one or two minutes, in which nothing else should
# run on the machine.

set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/nodes.sh"

out=bench.json peers=false scale=()
while [[ $# -gt 0 ]]; do
    case "$1" in
        --out) need_value "$@" && out=$2 && shift 2 ;;
        --peers) peers=true && shift ;;
        --scale) scale=(--scale) && shift ;;
        -h | --help) usage && exit 0 ;;
        *) fail "unknown option '$1'; see --help" ;;
    esac
done

arguments=(--out "$out" "${scale[@]}")
if "$peers"; then
    command -v python3 >/dev/null ||
        fail "there is no python3, which the peers need: install Python 3.11 or later"
    requirements=$root/tests/peers/benchmark/requirements.txt
    environment=$root/.venv-bench
    if ! cmp --silent "$requirements" "$environment/requirements.txt"; then
        python3 -m venv "$environment" ||
            fail "python3 cannot make virtual environments: install its venv (Debian: python3-venv)"
        "$environment/bin/python" -m pip install --quiet --requirement "$requirements"
        # What is installed, so that the next run need not ask.
        cp "$requirements" "$environment/requirements.txt"
    fi
    arguments+=(--peers "$environment/bin/python")
fi

build_nodes
# Not in one with the nodes, which would then be built for both of its own features and theirs.
run_cargo build --package evac_tests --features benchmark
# candle's matrix product, which the update is measured by, on one thread.
RAYON_NUM_THREADS=1 "$bin/benchmark" "${arguments[@]}"
