#!/usr/bin/env bash
# Fuzzes everything that parses untrusted input.
#
#   tests/fuzz/run.sh [SECONDS] [TARGET...]    (default: 600 seconds for each target, one after another)

set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
seconds=${1:-600}
targets=("${@:2}")
[[ ${#targets[@]} -gt 0 ]] || targets=(service_requests parameters yaml model checkpoint)

# Makes the stable compiler accept the nightly options that cargo-fuzz uses.
export RUSTC_BOOTSTRAP=1
../../launch_scripts/setup.sh
cargo run --quiet --release --locked --example seeds
for target in "${targets[@]}"; do
    # -max_len allows inputs larger than the seeds. An input that causes a hang or uses gigabytes is a failure.
    cargo fuzz run --fuzz-dir . "$target" -- -max_total_time="$seconds" -max_len=65536 \
        -timeout=20 -rss_limit_mb=2048
done
