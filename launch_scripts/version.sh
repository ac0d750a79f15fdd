#!/usr/bin/env bash
# Copies the version in Cargo.toml to every package.xml, where ROS tools read it.
#
#   launch_scripts/version.sh

set -euo pipefail
# shellcheck source-path=SCRIPTDIR source=programs.sh
source "$(dirname "${BASH_SOURCE[0]}")/programs.sh"

accept_no_options "$@"
version=$(sed -n 's/^version = "\(.*\)"$/\1/p' "$root/Cargo.toml" | head -n 1)
[[ -n "$version" ]] || fail "no version in $root/Cargo.toml"
for package in agent_node launch_scripts msgs sim_node; do
    sed -i "s|<version>.*</version>|<version>$version</version>|" "$root/$package/package.xml"
done
