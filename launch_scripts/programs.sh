# shellcheck shell=bash
# Sourced by the other scripts in this directory: common settings, and functions that build the programs.

root=$(CDPATH='' cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

# Keeps the nodes of other users on the same network out of a run.
export ROS_AUTOMATIC_DISCOVERY_RANGE="${ROS_AUTOMATIC_DISCOVERY_RANGE:-LOCALHOST}"

fail() {
    echo "$(basename "$0"): $*" >&2
    exit 1
}

# Prints the comment at the top of the script as help text.
usage() {
    sed -n '2,/^$/s/^# \{0,1\}//p' "$0"
}

# Handles the arguments of a script that has no options except --help.
accept_no_options() {
    case "${1:-}" in
        "") ;;
        -h | --help) usage && exit 0 ;;
        *) fail "unknown option '$1' (expected: --help)" ;;
    esac
}

check_openssl() {
    pkg-config --exists openssl 2>/dev/null ||
        fail "OpenSSL not found: security needs its headers and pkg-config (Debian: libssl-dev pkg-config)"
}

# Runs the cargo command $1 in release mode, with the remaining arguments.
run_cargo() {
    "$root/launch_scripts/setup.sh"
    # cargo reads .cargo/config.toml in the current directory and its parents.
    (cd "$root" && cargo "$1" --release --locked "${@:2}")
}

# Builds the nodes and evac, and sets `bin` to the directory that contains them.
build_nodes() {
    local options=()
    if [[ "${ROS_SECURITY_ENABLE:-}" == true ]]; then
        check_openssl
        options=(--features 'sim_node/security,agent_node/security')
    fi
    run_cargo build --package sim_node --package agent_node --package launcher "${options[@]}"
    # shellcheck disable=SC2034 # The scripts that source this file use it.
    bin=$(cd "$root" && realpath "${CARGO_TARGET_DIR:-target}")/release
}

# Builds the nodes, evac and the experiments.
build_experiments() {
    build_nodes
    # A separate command, because in a single one cargo would also enable the experiments' features in
    # the nodes' dependencies, and compile those a second time.
    run_cargo build --package experiments --features programs
}
