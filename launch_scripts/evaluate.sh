#!/usr/bin/env bash
# Tests a trained model over DDS: the best action always, no exploration.
#
#   launch_scripts/evaluate.sh --model DIR [options] [-- ROS arguments for the agent]
#
#   --model DIR       the directory of a training
#   --scenario NAME   the room, or mixed (default: that of the training)
#   --episodes N      test episodes (default: 1000)
#   --seed N          another seed, other rooms (default: 1)
#   --max-steps N     steps after which an episode counts as a failure (default: 200)
#   --out DIR         where evaluation.json goes (default: the directory of the model)

set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/nodes.sh"

model= scenario= episodes=1000 seed=1 max_steps=200 out= more=()
while [[ $# -gt 0 ]]; do
    case "$1" in
        --model) need_value "$@" && model=$2 && shift 2 ;;
        --scenario) need_value "$@" && scenario=$2 && shift 2 ;;
        --episodes) need_value "$@" && episodes=$2 && shift 2 ;;
        --seed) need_value "$@" && seed=$2 && shift 2 ;;
        --max-steps) need_value "$@" && max_steps=$2 && shift 2 ;;
        --out) need_value "$@" && out=$2 && shift 2 ;;
        --) shift && more=("$@") && break ;;
        -h | --help) usage && exit 0 ;;
        *) fail "unknown option '$1'; see --help" ;;
    esac
done
check_model "$model"
out=${out:-$model}
scenario=${scenario:-$(scenario_of "$model")}

build_nodes
temporary=$(mktemp -d)
compute_oracle "$seed" "$episodes" "$scenario"

start_simulators 1
run_agent evaluate "${oracle[@]}" --ros-args \
    -p "model:=$(yaml "$model")" -p "scenario:=$(yaml "$scenario")" \
    -p "episodes:=$episodes" -p "seed:=$seed" -p "max_steps:=$max_steps" \
    -p "out:=$(yaml "$out")" "${more[@]}"
