#!/usr/bin/env bash
# A training of a million steps over a bad network: which steps were lost or repeated, whether the
# result is that of the same training without a network, and whether the nodes grow.
#
#   launch_scripts/soak.sh [--episodes N] [--loss P] [--repetition P] [--delay MS] [--cut-interval N]
#                          [--out FILE]
#
#   --episodes N       training episodes, each in a scenario drawn for it (default: 28000, more than
#                      a million steps)
#   --loss P           the chance that a frame of the network is lost (default: 0.002)
#   --repetition P     the chance that it comes twice (default: 0.01)
#   --delay MS         the longest delay of a frame; they overtake each other (default: 0.2)
#   --cut-interval N   after how many steps the network is cut off for 5 s, again and again
#                      (default: 100000)
#   --out FILE         where the figures go, as JSON (default: soak.json)
#
# Fails if a step was lost or repeated, if the result differs, or if a node holds more memory or
# handles at the end than after the first 50,000 steps. It makes two network namespaces and a relay
# between them, for which it needs root, Linux, util-linux and iproute2.

set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/nodes.sh"

episodes=28000 loss=0.002 repetition=0.01 delay=0.2 cut_interval=100000 out=soak.json
while [[ $# -gt 0 ]]; do
    case "$1" in
        --episodes) need_value "$@" && episodes=$2 && shift 2 ;;
        --loss) need_value "$@" && loss=$2 && shift 2 ;;
        --repetition) need_value "$@" && repetition=$2 && shift 2 ;;
        --delay) need_value "$@" && delay=$2 && shift 2 ;;
        --cut-interval) need_value "$@" && cut_interval=$2 && shift 2 ;;
        --out) need_value "$@" && out=$2 && shift 2 ;;
        -h | --help) usage && exit 0 ;;
        *) fail "unknown option '$1'; see --help" ;;
    esac
done

build_nodes
# Not in one with the nodes, which would then be built for both of its own features and theirs.
run_cargo build --package evac_tests --features benchmark --bin soak
"$bin/soak" --episodes "$episodes" --loss "$loss" --repetition "$repetition" --delay "$delay" \
    --cut-interval "$cut_interval" --out "$out"
