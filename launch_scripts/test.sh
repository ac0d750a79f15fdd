#!/usr/bin/env bash
# Runs every test, with its set-up: the nodes, and independent DDS peers from PyPI.
#
#   launch_scripts/test.sh [arguments for cargo test]
#
# The peers go into a virtual environment, .venv in the repository.

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

cargo test --release --locked --workspace "$@"
