#!/usr/bin/env bash
# Drives with a trained model as on a robot: the agent hears only camera/image and says only action. A
# simulator takes the robot's place, unless there is one.
#
#   launch_scripts/drive.sh --model DIR [options] [-- ROS arguments for the agent]
#
#   --model DIR        the directory of a training
#   --scenario NAME    the room (default: that of the training)
#   --seed N           other rooms (default: 0)
#   --frame-rate N     images a second (default: 20)
#   --motion-time S    how long a move takes, in seconds (default: 0.1)
#   --settle-time S    how long after an image that it has answered the agent waits for the next one,
#                      in seconds (default: 0.2)
#   --robot            there is a robot: start no simulator, and look for it in the whole subnet unless
#                      ROS_AUTOMATIC_DISCOVERY_RANGE says otherwise
#
# It drives until Ctrl-C; an episode that is over is followed by the next. Another terminal sees how it
# goes: 'ros2 topic echo /episode', or /diagnostics.

set -euo pipefail
range=${ROS_AUTOMATIC_DISCOVERY_RANGE:-}
source "$(dirname "${BASH_SOURCE[0]}")/nodes.sh"

model= scenario= seed=0 frame_rate=20 motion_time=0.1 settle_time=0.2 robot=false more=()
while [[ $# -gt 0 ]]; do
    case "$1" in
        --model) need_value "$@" && model=$2 && shift 2 ;;
        --scenario) need_value "$@" && scenario=$2 && shift 2 ;;
        --seed) need_value "$@" && seed=$2 && shift 2 ;;
        --frame-rate) need_value "$@" && frame_rate=$2 && shift 2 ;;
        --motion-time) need_value "$@" && motion_time=$2 && shift 2 ;;
        --settle-time) need_value "$@" && settle_time=$2 && shift 2 ;;
        --robot) robot=true && shift ;;
        --) shift && more=("$@") && break ;;
        -h | --help) usage && exit 0 ;;
        *) fail "unknown option '$1'; see --help" ;;
    esac
done
check_model "$model"
scenario=${scenario:-$(scenario_of "$model")}
if [[ "$robot" == true ]]; then
    # It is elsewhere in the network, unless somebody says otherwise.
    export ROS_AUTOMATIC_DISCOVERY_RANGE=${range:-SUBNET}
elif [[ "$scenario" == mixed ]]; then
    fail "the model was trained in all rooms: choose one with --scenario"
fi

build_nodes
if [[ "$robot" == false ]]; then
    start_simulator --ros-args -p "scenario:=$(yaml "$scenario")" -p "seed:=$seed" \
        -p "frame_rate:=$frame_rate" -p "motion_time:=$motion_time" -p auto_reset:=true
fi
run_agent drive --ros-args -p "model:=$(yaml "$model")" -p "settle_time:=$settle_time" "${more[@]}"
