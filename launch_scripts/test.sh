#!/usr/bin/env bash
# Runs every test, with its set-up: the nodes, and independent DDS peers.
#
#   launch_scripts/test.sh [arguments for cargo test]
#
# The peers from PyPI go into a virtual environment, .venv in the repository. One more is built with
# Fast DDS where that is installed; elsewhere its test is skipped, unless EVAC_FAST_DDS=required. The
# tests of security, which take another build, are run with EVAC_SECURITY=required.

set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/nodes.sh"

[[ "${1:-}" != -h && "${1:-}" != --help ]] || { usage && exit 0; }
cd "$root"
check_rust
command -v python3 >/dev/null ||
    fail "there is no python3, which the independent DDS peers need: install Python 3.10 or later"

requirements=tests/peers/requirements.txt
if ! cmp --silent "$requirements" .venv/requirements.txt; then
    python3 -m venv .venv ||
        fail "python3 cannot make virtual environments: install its venv (Debian: python3-venv)"
    .venv/bin/python -m pip install --quiet --requirement "$requirements"
    # What is installed, so that the next run need not ask.
    cp "$requirements" .venv/requirements.txt
fi
export EVAC_PYTHON="$root/.venv/bin/python"

# The preprocessor knows whether every header is there, in a version that will do.
caller=tests/peers/fast_dds/step_caller.cpp
if g++ -std=c++20 -M "$caller" >/dev/null 2>&1; then
    peers=$(realpath "${CARGO_TARGET_DIR:-target}")/peers
    mkdir -p "$peers"
    g++ -std=c++20 -O2 -Wall -Wextra -o "$peers/step_caller" "$caller" -lfastrtps -lfastcdr -lz
    export EVAC_FAST_DDS_PEER="$peers/step_caller"
else
    missing="no Fast DDS 2 to build a peer with (Debian 12: g++ libfastrtps-dev zlib1g-dev)"
    [[ "${EVAC_FAST_DDS:-}" != required ]] || fail "$missing"
    echo "$(basename "$0"): SKIPPED: the services as Fast DDS calls them: $missing" >&2
fi

run_cargo test --workspace "$@"

if [[ "${EVAC_SECURITY:-}" == required ]]; then
    check_openssl
    run_cargo test --workspace --features security --test security "$@"
else
    echo "$(basename "$0"): SKIPPED: the tests of security, without EVAC_SECURITY=required" >&2
fi
