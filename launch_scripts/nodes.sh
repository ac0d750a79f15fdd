# Sourced by the scripts beside it: builds the nodes, starts and stops them.

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

# Two people who train on one network must not step each other's rooms.
export ROS_AUTOMATIC_DISCOVERY_RANGE="${ROS_AUTOMATIC_DISCOVERY_RANGE:-LOCALHOST}"

fail() {
    echo "$(basename "$0"): $*" >&2
    exit 1
}

# The help text is the comment at the top of the script.
usage() {
    sed -n '2,/^$/s/^# \{0,1\}//p' "$0"
}

# A text as a string in YAML, which is what a ROS parameter is written in.
yaml() {
    printf "'%s'" "${1//\'/\'\'}"
}

# Ends the script unless the option $1 is followed by its value.
need_value() {
    [[ $# -ge 2 ]] || fail "$1 needs a value; see --help"
}

check_openssl() {
    pkg-config --exists openssl 2>/dev/null ||
        fail "security needs OpenSSL's headers and pkg-config (Debian: libssl-dev pkg-config)"
}

# Builds or tests by cargo's command $1.
run_cargo() {
    "$root/launch_scripts/setup.sh"
    # From the root, so that the settings in .cargo apply wherever the script is called from.
    (cd "$root" && cargo "$1" --release --locked "${@:2}")
}

build_nodes() {
    local options=()
    if [[ "${ROS_SECURITY_ENABLE:-}" == true ]]; then
        check_openssl
        options=(--features security)
    fi
    run_cargo build --package sim_node --package agent_node "${options[@]}"
    bin=$(cd "$root" && realpath "${CARGO_TARGET_DIR:-target}")/release
}

# Ends the script unless there is a trained model in the directory $1.
check_model() {
    [[ -n "$1" ]] || fail "which model? give --model DIR, the directory of a training"
    [[ -f "$1/config.yaml" ]] || fail "no trained model in $1: there is no config.yaml"
}

# The scenario that the model in the directory $1 was trained in.
scenario_of() {
    sed -n '/agent_node:/,$s/^ *scenario: //p' "$1/config.yaml" | head -n 1
}

# Runs a simulator in the background, and again if it dies: the agent takes the episode up. One that
# never lives for long is given up, and the agent told to end. The enclave counts where there is
# security; whoever gives another one wins.
start_simulator() {
    (
        child= failures=0
        trap 'kill -TERM "$child" 2>/dev/null; wait "$child"; exit 0' TERM INT
        while :; do
            start=$SECONDS
            "$bin/sim_node" --ros-args --enclave /evac/sim_node -- "$@" </dev/null &
            child=$!
            wait "$child" && exit 0
            [[ $((SECONDS - start)) -lt 10 ]] || failures=0
            failures=$((failures + 1))
            if [[ $failures == 10 ]]; then
                echo "sim_node ended with an error $failures times in a row; it is given up" >&2
                kill -TERM $$
                exit "$given_up"
            fi
            echo "sim_node ended with an error; it is started again" >&2
            sleep 1
        done
    ) &
    simulators+=($!)
}

# Starts $1 simulators: one where the agent is, several each in a namespace of its own.
start_simulators() {
    if [[ "$1" == 1 ]]; then
        start_simulator
    else
        local index
        for ((index = 0; index < $1; index++)); do
            start_simulator --ros-args -r "__ns:=/sim$index"
        done
    fi
}

# Runs the agent with a simulator beside it until the agent ends; returns its exit status. An agent that
# failed is started again, at most three times; a training goes on from the file $checkpoint.
run_agent() {
    local status=0 restarts=0 resume=()
    run_agent_once "$@" || status=$?
    # After a panic, or for want of memory: what is said to be an error would be one again.
    while [[ ($status == 101 || $status == 134) && $restarts -lt 3 ]]; do
        restarts=$((restarts + 1))
        echo "agent_node failed; it is started again ($restarts of at most 3 times)" >&2
        [[ ! -f "$checkpoint" ]] || resume=(--ros-args -p resume:=true)
        status=0
        run_agent_once "$@" "${resume[@]}" || status=$?
    done
    return "$status"
}

run_agent_once() {
    "$bin/agent_node" --ros-args --enclave /evac/agent_node -- "$@" </dev/null &
    agent=$!
    # Ctrl-C in a terminal reaches the agent itself; a signal to this script alone is passed on.
    trap 'kill -TERM "$agent" 2>/dev/null' TERM INT
    local status=0
    wait "$agent" || status=$?
    # A signal ends a wait early; the next one has the agent's own status.
    while [[ $status -gt 128 ]] && kill -0 "$agent" 2>/dev/null; do
        status=0
        wait "$agent" || status=$?
    done
    if [[ $status -gt 128 ]]; then
        status=0
        wait "$agent" || status=$?
    fi
    trap - TERM INT
    return "$status"
}

stop_simulators() {
    local simulator
    # Ctrl-C in a terminal may have ended them already.
    for simulator in "${simulators[@]}"; do
        kill -TERM "$simulator" 2>/dev/null || true
    done
    for simulator in "${simulators[@]}"; do
        wait "$simulator" 2>/dev/null || [[ $? != "$given_up" ]] || failed=true
    done
    simulators=()
}

# Sets `oracle` to the agent's option for the fewest possible steps of the test with seed $1 and $2
# episodes in scenario $3. Where each episode has a room of its own, nobody computes them.
compute_oracle() {
    oracle=()
    [[ "$3" != mixed && "$2" != 0 ]] || return 0
    "$bin/agent_node" seeds --seed "$1" --episodes "$2" >"$temporary/seeds"
    "$bin/sim_node" oracle --scenario "$3" --seeds "$temporary/seeds" >"$temporary/oracle.json"
    oracle=(--oracle "$temporary/oracle.json")
}

temporary=
checkpoint=
simulators=()
# The status of a simulator's loop that has given up, and whether one has.
given_up=3
failed=false
cleanup() {
    stop_simulators
    [[ -z "$temporary" ]] || rm -rf "$temporary"
    [[ "$failed" == false ]] || exit 1
}
trap cleanup EXIT
