#!/usr/bin/env bash
# Trains the agent over DDS, then tests it: two processes, simulator and agent.
#
#   launch_scripts/train.sh [options] [-- ROS arguments for the agent, such as -p epsilon_min:=0.05]
#
#   --scenario NAME   the room (default: empty)
#   --preset NAME     the hyperparameters (default: paper)
#   --episodes N      training episodes (default: 1000)
#   --seed N          the run is a function of it (default: 0)
#   --simulators N    how many simulators the agent learns in at once (default: 1)
#   --out DIR         where the run's files go (default: runs/SCENARIO-PRESET-seedN)
#   --resume          go on from the checkpoint in --out
#
# Ctrl-C saves the training and stops both nodes. The environment's ROS_DOMAIN_ID and
# ROS_AUTOMATIC_DISCOVERY_RANGE are followed; the range is LOCALHOST unless it is set.

set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/nodes.sh"

scenario=empty preset=paper episodes=1000 seed=0 count=1 out= resume=false more=()
while [[ $# -gt 0 ]]; do
    case "$1" in
        --scenario) need_value "$@" && scenario=$2 && shift 2 ;;
        --preset) need_value "$@" && preset=$2 && shift 2 ;;
        --episodes) need_value "$@" && episodes=$2 && shift 2 ;;
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

build_nodes
temporary=$(mktemp -d)
oracle="$temporary/oracle.json"
# The test after the training is that of evaluation_seed and evaluation_episodes, which are these
# unless the ROS arguments say otherwise; the agent leaves out what is of another test.
compute_oracle "$oracle" 1 1000 "$scenario"

start_simulators "$count"
run_agent train --oracle "$oracle" --ros-args \
    -p "scenario:=$(yaml "$scenario")" -p "preset:=$(yaml "$preset")" \
    -p "episodes:=$episodes" -p "seed:=$seed" -p "simulators:=$count" \
    -p "out:=$(yaml "$out")" \
    -p "resume:=$resume" "${more[@]}"
