#!/usr/bin/env bash
# Prepares the repository for cargo: every build from then on uses the corrected RustDDS.
#
#   launch_scripts/setup.sh
#
# Copies RustDDS from cargo's registry, applies patches/rustdds in the order of their numbers, and
# writes .cargo/corrected.toml, which .cargo/config.toml includes. Does nothing if that is up to date,
# and needs a network only while the crate has not been downloaded. All other scripts call it.
#
# With EVAC_UNCORRECTED=1 it does nothing: for testing a build with the published crate.

set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

fail() {
    echo "setup.sh: $*" >&2
    exit 1
}

case "${1:-}" in
    "") ;;
    -h | --help) sed -n '2,/^$/s/^# \{0,1\}//p' "$0" && exit 0 ;;
    *) fail "unknown option '$1'; see --help" ;;
esac

[[ "${EVAC_UNCORRECTED:-}" != 1 ]] || exit 0

wanted=$(sed -n 's/^rust-version = "\(.*\)"/\1/p' "$root/Cargo.toml")
command -v cargo >/dev/null ||
    fail "cargo not found: install Rust $wanted or later with rustup (https://rustup.rs)"
found=$(cargo --version | cut -d ' ' -f 2)
[[ $(printf '%s\n' "$wanted" "$found" | sort -V | head -n 1) == "$wanted" ]] ||
    fail "Rust $found is too old (expected: $wanted or later): run 'rustup update stable'"
command -v cc >/dev/null ||
    fail "cc not found: install a C compiler, which Rust links with (Debian: gcc)"

patches=("$root"/patches/rustdds/*.patch)
version=$(awk '$3 == "\"rustdds\"" { getline; gsub("\"", ""); print $3 }' "$root/Cargo.lock")
digest=$(cat "${patches[@]}" | sha256sum | cut -c 1-16)
name=rustdds-$version-$digest
directory=$root/.cargo/corrected
configuration=$root/.cargo/corrected.toml
# Relative to the repository, which can thus be moved.
setting="paths = [\".cargo/corrected/$name\"]"

is_current() {
    [[ -d "$directory/$name" && "$(cat "$configuration" 2>/dev/null)" == "$setting" ]]
}

if is_current; then
    exit 0
fi

mkdir -p "$directory"
# Without flock, two at once do the same work twice, and the second result is discarded.
if command -v flock >/dev/null; then
    exec {lock}>"$directory/lock"
    flock "$lock"
    if is_current; then
        exit 0
    fi
    # What a killed one has left.
    rm -rf "$directory"/incomplete.*
fi

if [[ ! -d "$directory/$name" ]]; then
    # From the directory above, where .cargo/config.toml does not apply: with it, cargo would name the
    # corrected copy. For this platform alone, so that nothing is downloaded for others.
    platform=$(rustc --version --verbose | sed -n 's/^host: //p')
    manifest=$(cd "$root/.." &&
        cargo metadata --locked --format-version 1 --filter-platform "$platform" \
            --manifest-path "$root/Cargo.toml" |
        grep --only-matching "[^\"]*/rustdds-$version/Cargo\.toml" | head -n 1) ||
        fail "cargo metadata does not name RustDDS $version"

    copy=$(mktemp -d "$directory/incomplete.XXXXXX")
    trap 'rm -rf "$copy"' EXIT
    cp -R "$(dirname "$manifest")/." "$copy"
    for patch in "${patches[@]}"; do
        if command -v patch >/dev/null; then
            patch --quiet --no-backup-if-mismatch --directory "$copy" --strip 1 <"$patch"
        elif command -v git >/dev/null; then
            # The copy is not part of the repository around it.
            GIT_CEILING_DIRECTORIES=$directory git -C "$copy" apply "$patch"
        else
            fail "neither patch nor git found, one of which corrects RustDDS: install patch"
        fi || fail "$(basename "$patch") does not apply to RustDDS $version"
        basename "$patch" .patch >>"$copy/CORRECTIONS"
    done
    chmod 755 "$copy"
    mv --no-target-directory "$copy" "$directory/$name" 2>/dev/null || [[ -d "$directory/$name" ]]
fi

echo "$setting" >"$configuration.incomplete.$$"
mv "$configuration.incomplete.$$" "$configuration"
for other in "$directory"/rustdds-*; do
    [[ "$other" == "$directory/$name" ]] || rm -rf "$other"
done
