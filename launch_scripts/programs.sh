# Sourced by the scripts beside it: builds the programs, and starts `evac`, which does the rest.

root=$(CDPATH='' cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

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

# Builds the nodes and `evac`, and sets `bin` to where they are.
build_nodes() {
    local options=()
    if [[ "${ROS_SECURITY_ENABLE:-}" == true ]]; then
        check_openssl
        options=(--features sim_node/security,agent_node/security)
    fi
    run_cargo build --package sim_node --package agent_node --package launcher "${options[@]}"
    bin=$(cd "$root" && realpath "${CARGO_TARGET_DIR:-target}")/release
}

# Builds the programs that measure, too.
build_experiments() {
    build_nodes
    # Not in one with the nodes, which would then be built for both of its own features and theirs.
    run_cargo build --package experiments --features programs
}
