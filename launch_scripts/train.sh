#!/usr/bin/env bash
# Trains the agent over DDS, then tests it: two processes, simulator and agent.
#
#   launch_scripts/train.sh [options] [-- ROS arguments for the agent, such as -p epsilon_min:=0.05]
#
#   --scenario NAME   the room, or mixed: one of the eight, drawn for each episode (default: empty)
#   --preset NAME     the hyperparameters, robust or paper (default: robust)
#   --episodes N      training episodes (default: the preset's, 3000 or 1000)
#   --seed N          the run is a function of it (default: 0)
#   --evaluation-episodes N
#                     episodes of the test after the training (default: 1000)
#   --simulators N    how many simulators the agent learns in at once (default: 1)
#   --out DIR         where the run's files go (default: runs/SCENARIO-PRESET-seedN)
#   --resume          go on from the checkpoint in --out
#
# Ctrl-C saves the training and stops both nodes. The environment's ROS_DOMAIN_ID and
# ROS_AUTOMATIC_DISCOVERY_RANGE are followed; the range is LOCALHOST unless it is set.

set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/nodes.sh"

scenario=empty preset=robust episodes= test_episodes=1000 seed=0 count=1 out= resume=false more=()
while [[ $# -gt 0 ]]; do
    case "$1" in
        --scenario) need_value "$@" && scenario=$2 && shift 2 ;;
        --preset) need_value "$@" && preset=$2 && shift 2 ;;
        --episodes) need_value "$@" && episodes=$2 && shift 2 ;;
        --evaluation-episodes) need_value "$@" && test_episodes=$2 && shift 2 ;;
        --seed) need_value "$@" && seed=$2 && shift 2 ;;
        --simulators) need_value "$@" && count=$2 && shift 2 ;;
        --out) need_value "$@" && out=$2 && shift 2 ;;
        --resume) resume=true && shift ;;
        --) shift && more=("$@") && break ;;
        -h | --help) usage && exit 0 ;;
        *) fail "unknown option '$1'; see --help" ;;
    esac
done
[[ "$count" =~ ^[1-9][0-9]?$ && "$count" -le 64 ]] || fail "--simulators is '$count': expected 1 to 64"
out=${out:-$root/runs/$scenario-$preset-seed$seed}
checkpoint=$out/checkpoint.safetensors

build_nodes
temporary=$(mktemp -d)
# The test after the training is that of evaluation_seed, which is this unless the ROS arguments say
# otherwise; the agent leaves out what is of another test.
compute_oracle 1 "$test_episodes" "$scenario"

start_simulators "$count"
[[ -z "$episodes" ]] || more=(-p "episodes:=$episodes" "${more[@]}")
run_agent train "${oracle[@]}" --ros-args \
    -p "scenario:=$(yaml "$scenario")" -p "preset:=$(yaml "$preset")" \
    -p "seed:=$seed" -p "evaluation_episodes:=$test_episodes" -p "simulators:=$count" \
    -p "out:=$(yaml "$out")" \
    -p "resume:=$resume" "${more[@]}"
