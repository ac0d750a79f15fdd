#!/usr/bin/env bash
# Tries random bytes on everything that reads what somebody else wrote.
#
#   tests/fuzz/run.sh [SECONDS] [TARGET...]    (default: 600 seconds for each target, one after another)

set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
seconds=${1:-600}
targets=("${@:2}")
[[ ${#targets[@]} -gt 0 ]] || targets=(service_requests parameters yaml model checkpoint)

# cargo fuzz takes options of a nightly compiler; this has a stable one take them, too.
export RUSTC_BOOTSTRAP=1
../../launch_scripts/setup.sh
cargo run --quiet --release --locked --example seeds
for target in "${targets[@]}"; do
    # More than any valid input takes; and what hangs or takes a gigabyte for it is wrong.
    cargo fuzz run --fuzz-dir . "$target" -- -max_total_time="$seconds" -max_len=65536 \
        -timeout=20 -rss_limit_mb=2048
done
