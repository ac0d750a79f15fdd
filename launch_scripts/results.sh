#!/usr/bin/env bash
# Trains the paper's preset in the empty room with the seeds 0, 1 and 2, and writes the table of
# results into README.md.
#
#   launch_scripts/results.sh

set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/nodes.sh"

[[ "${1:-}" != -h && "${1:-}" != --help ]] || { usage && exit 0; }
build_nodes
# An interrupted training ends well; this script then ends, too.
trap 'exit 130' INT
runs=()
for seed in 0 1 2; do
    runs+=("$root/runs/empty-paper-seed$seed")
    "$root/launch_scripts/train.sh" --scenario empty --preset paper --seed "$seed" \
        --out "${runs[-1]}"
done
temporary=$(mktemp -d)
"$bin/agent_node" table "${runs[@]}" >"$temporary/table"
# The table stands between two comments.
sed -e "/<!-- results: begin -->/r $temporary/table" \
    -e '/<!-- results: begin -->/,/<!-- results: end -->/{/<!-- results/!d}' \
    "$root/README.md" >"$temporary/README.md"
cp "$temporary/README.md" "$root/README.md"
cat "$temporary/table"
