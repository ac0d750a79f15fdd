#!/usr/bin/env bash
# Reproduces every result: trains both presets in every scenario, and one policy for all of them, each
# with several seeds, over DDS; tests what was trained; writes reproduction.json, the tables of
# docs/results.md and the short one of README.md.
#
#   launch_scripts/reproduce.sh [options]
#
#   --seeds N   seeds of each training, from 0 (default: 5)
#   --out DIR   where the trainings go (default: runs/reproduction)
#
# It takes hours; whatever was done when it is stopped is not done again.

set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/nodes.sh"

seeds=5 out=$root/runs/reproduction
while [[ $# -gt 0 ]]; do
    case "$1" in
        --seeds) need_value "$@" && seeds=$2 && shift 2 ;;
        --out) need_value "$@" && out=$2 && shift 2 ;;
        -h | --help) usage && exit 0 ;;
        *) fail "unknown option '$1'; see --help" ;;
    esac
done
[[ "$seeds" =~ ^[1-9][0-9]?$ ]] || fail "--seeds is '$seeds': expected 1 to 99"

# As agent_node and sim_node know them.
scenarios=(empty one_cylinder two_cylinders three_cylinders concave one_moving two_moving three_moving)
test_episodes=2000
build_nodes
mkdir -p "$out"
out=$(realpath "$out")
# A child in the background does not hear Ctrl-C: it is told to end, and saves what it has.
child=
trap 'kill -TERM "$child" 2>/dev/null; wait "$child"; exit 130' TERM INT

# What there is to do: a weight, which is about the share of the time that it takes; the file that it
# leaves when it is done; the command.
weights=() files=() commands=()
add() {
    weights+=("$1") files+=("$2")
    shift 2
    commands+=("$(printf '%q ' "$@")")
}
train() {
    local directory="$out/$2-$3-seed$4"
    add "$1" "$directory/report.html" train.sh --scenario "$2" --preset "$3" --seed "$4" \
        --evaluation-episodes "$test_episodes" --out "$directory"
}
for ((seed = 0; seed < seeds; seed++)); do
    for scenario in "${scenarios[@]}"; do
        train 3 "$scenario" paper "$seed"
        train 10 "$scenario" robust "$seed"
    done
    train 10 mixed robust "$seed"
    for scenario in "${scenarios[@]}"; do
        model="$out/mixed-robust-seed$seed"
        add 1 "$model/$scenario/evaluation.json" evaluate.sh --model "$model" \
            --scenario "$scenario" --episodes "$test_episodes" --out "$model/$scenario"
    done
done

total=0 left=0 spent=0 worked=0
for index in "${!files[@]}"; do
    total=$((total + weights[index]))
    [[ -f "${files[index]}" ]] || left=$((left + weights[index]))
done
for index in "${!files[@]}"; do
    [[ ! -f "${files[index]}" ]] || continue
    eval "command=(${commands[index]})"
    directory=$(dirname "${files[index]}")
    estimate=
    [[ "$worked" == 0 ]] || estimate=", about $((spent * left / worked / 60 + 1)) min left"
    printf '%3d %%%s: %s\n' $((100 * (total - left) / total)) "$estimate" \
        "${directory#"$out"/}"
    [[ ! -f "$directory/checkpoint.safetensors" ]] || command+=(--resume)
    mkdir -p "$directory"
    started=$SECONDS
    "$root/launch_scripts/${command[0]}" "${command[@]:1}" >"$directory.log" 2>&1 </dev/null &
    child=$!
    if ! wait "$child"; then
        tail -n 20 "$directory.log" >&2
        fail "this one failed; the whole log is $directory.log"
    fi
    [[ -f "${files[index]}" ]] || exit 130
    spent=$((spent + SECONDS - started)) worked=$((worked + weights[index]))
    left=$((left - weights[index]))
done

"$bin/agent_node" reproduction "$out" --json "$root/reproduction.json" \
    --results "$root/docs/results.md" --readme "$root/README.md"
echo "The results are in docs/results.md and reproduction.json."
