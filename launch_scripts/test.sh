#!/usr/bin/env bash
# Builds and runs the tests, and installs the independent DDS peers that they need.
#
#   launch_scripts/test.sh [--all | --soak] [options of cargo test]
#
#   (no option)  the short tests, which take a few minutes
#   --all        also the long tests: killed processes, unreliable networks, interruptions, hostile packets, a full disk,
#                colcon, Fast DDS, security, the output shown in the tutorial. They need root and the
#                Debian packages that .ci/run installs. EVAC_ROS2=required adds the ROS 2 Jazzy tests;
#                source ROS 2 first
#   --soak       a training run of a million steps over an unreliable network (soak.sh)
#
# The peers from PyPI are installed in .venv, a virtual environment in the repository.

set -euo pipefail
# shellcheck source-path=SCRIPTDIR source=programs.sh
source "$(dirname "${BASH_SOURCE[0]}")/programs.sh"

all=false
case "${1:-}" in
    -h | --help) usage && exit 0 ;;
    --soak) shift && exec "$root/launch_scripts/soak.sh" "$@" ;;
    --all) shift && all=true ;;
esac
cd "$root"
"$root/launch_scripts/setup.sh"
command -v python3 >/dev/null ||
    fail "python3 not found: install Python 3.10 or later, which the tests' DDS peers need"

requirements=tests/peers/requirements.txt
if ! cmp --silent "$requirements" .venv/requirements.txt; then
    python3 -m venv .venv ||
        fail "python3 -m venv failed: install the module venv (Debian: python3-venv)"
    .venv/bin/python -m pip install --quiet --requirement "$requirements"
    # Records what is installed, so that the next run can skip pip.
    cp "$requirements" .venv/requirements.txt
fi
export EVAC_PYTHON="$root/.venv/bin/python"

run_cargo test --workspace "$@"
run_cargo test --package evac_tests --test corrections "$@"
[[ "$all" == true ]] || exit 0

# The preprocessor fails if a header is missing or has an unsupported version.
caller=tests/peers/fast_dds/step_caller.cpp
g++ -std=c++20 -M "$caller" >/dev/null 2>&1 ||
    fail "Fast DDS 2 not found: a test peer needs it (Debian 12: g++ libfastrtps-dev zlib1g-dev)"
check_openssl
peers=$(realpath "${CARGO_TARGET_DIR:-target}")/peers
mkdir -p "$peers"
g++ -std=c++20 -O2 -Wall -Wextra -o "$peers/step_caller" "$caller" -lfastrtps -lfastcdr -lz
export EVAC_FAST_DDS_PEER="$peers/step_caller"

long=(colcon fast_dds full_disk hostile interruptions kills network)
run_cargo test --package evac_tests "${long[@]/#/--test=}" "$@"
# --ignored is an option of the test binary, so it must follow `--`.
options=("$@")
[[ " $* " == *" -- "* ]] || options+=(--)
run_cargo test --package evac_tests --test pages "${options[@]}" --ignored
if [[ "${EVAC_ROS2:-}" == required ]]; then
    run_cargo test --package evac_tests --test ros2 "${options[@]}" --ignored
fi
run_cargo test --package evac_tests --features security --test security "$@"
