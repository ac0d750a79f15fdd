#!/usr/bin/env bash
# Makes every later cargo build in this repository use RustDDS with the corrections in patches/rustdds.
#
#   launch_scripts/setup.sh
#
# Copies RustDDS from cargo's registry to .cargo/corrected, applies the patches in patches/rustdds in
# file name order, and writes .cargo/corrected/config.toml, which .cargo/config.toml includes. Downloads the
# crates of Cargo.lock if they are missing. Does nothing if the copy is up to date. All other scripts
# call it. It does not detect manual changes to the copy: delete .cargo/corrected to discard them.
#
# With EVAC_UNCORRECTED=1 it does nothing, so that a clone that was never set up can be tested with the
# published crate.

set -euo pipefail
root=$(CDPATH='' cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

fail() {
    echo "setup.sh: $*" >&2
    exit 1
}

case "${1:-}" in
    "") ;;
    -h | --help) sed -n '2,/^$/s/^# \{0,1\}//p' "$0" && exit 0 ;;
    *) fail "unknown option '$1' (expected: --help)" ;;
esac

[[ "${EVAC_UNCORRECTED:-}" != 1 ]] || exit 0

required=$(sed -n 's/^rust-version = "\(.*\)"/\1/p' "$root/Cargo.toml")
command -v cargo >/dev/null ||
    fail "cargo not found: install Rust $required or later with rustup (https://rustup.rs)"
installed=$(cargo --version | cut -d ' ' -f 2)
[[ $(printf '%s\n' "$required" "$installed" | sort -V | head -n 1) == "$required" ]] ||
    fail "Rust $installed is too old (expected: $required or later): run 'rustup update stable'"
command -v cc >/dev/null ||
    fail "cc not found: install a C compiler, which Rust needs to link programs (Debian: gcc)"

patches=("$root"/patches/rustdds/*.patch)
[[ -f "${patches[0]}" ]] || fail "no patches found in $root/patches/rustdds: the clone is incomplete"
version=$(awk '$3 == "\"rustdds\"" { getline; gsub("\"", ""); print $3 }' "$root/Cargo.lock")
# Covers the patches, their names (which the copy lists as its corrections), and this script.
digest=$(cd "$root" && sha256sum patches/rustdds/*.patch launch_scripts/setup.sh | sha256sum | cut -c 1-16)
name=rustdds-$version-$digest
directory=$root/.cargo/corrected
configuration=$directory/config.toml
# Relative to .cargo, so that the repository can be moved.
setting="paths = [\"corrected/$name\"]"

is_current() {
    [[ -d "$directory/$name" && "$(cat "$configuration" 2>/dev/null)" == "$setting" ]]
}

if is_current; then
    exit 0
fi

mkdir -p "$directory"
# Without flock, concurrent runs each make a copy, and only the first copy is kept.
if command -v flock >/dev/null; then
    exec {lock}>"$directory/lock"
    flock "$lock"
    if is_current; then
        exit 0
    fi
    # Left behind by a run that was killed.
    rm -rf "$directory"/incomplete.*
fi
# If a later step fails, cargo builds with the published crate instead of an outdated copy.
rm -f "$configuration"

# Prints the directory of the RustDDS that cargo uses when it runs in the directory $1.
crate_directory() {
    # Limited to this platform, so that cargo downloads no crates for others.
    local platform metadata
    platform=$(rustc --version --verbose | sed -n 's/^host: //p')
    metadata=$(cd "$1" && cargo metadata --locked --format-version 1 --filter-platform "$platform" \
        --manifest-path "$root/Cargo.toml") || fail "cargo metadata failed; see the error above"
    # Selects the manifest path that follows the name and version of RustDDS.
    sed -e 's/{"name":"[^"]*","version":/\n&/g' -e 's/"manifest_path":/\n&/g' <<<"$metadata" |
        awk -v "package={\"name\":\"rustdds\",\"version\":\"$version\"" \
            'index($0, package) == 1 { found = 1 } found && /^"manifest_path"/ { print; found = 0 }' |
        sed -e 's/^"manifest_path":"\(\([^"\\]\|\\.\)*\)\/Cargo\.toml".*/\1/' -e 's/\\\(.\)/\1/g'
}

if [[ ! -d "$directory/$name" ]]; then
    # Runs cargo in `/`, because a .cargo/config.toml in the repository or above it may point to a
    # corrected copy.
    original=$(crate_directory /)
    [[ -f "$original/Cargo.toml" ]] || fail "RustDDS $version not found in the output of cargo metadata"

    copy=$(mktemp -d "$directory/incomplete.XXXXXX")
    trap 'rm -rf "$copy"' EXIT
    cp -R "$original/." "$copy"
    for patch in "${patches[@]}"; do
        if command -v patch >/dev/null; then
            patch --quiet --force --fuzz=0 --no-backup-if-mismatch --directory "$copy" --strip 1 <"$patch"
        elif command -v git >/dev/null; then
            # Prevents git from treating the copy as a part of the repository.
            GIT_CEILING_DIRECTORIES=$directory git -C "$copy" -c core.autocrlf=false \
                -c apply.whitespace=nowarn apply "$patch"
        else
            fail "neither patch nor git found: install patch, which applies the corrections"
        fi || fail "$(basename "$patch") does not apply to RustDDS $version"
        basename "$patch" .patch >>"$copy/CORRECTIONS"
    done
    chmod 755 "$copy"
    mv --no-target-directory "$copy" "$directory/$name" || [[ -d "$directory/$name" ]] ||
        fail "cannot create $directory/$name; see the error above"
fi

echo "$setting" >"$directory/incomplete.config.$$"
mv "$directory/incomplete.config.$$" "$configuration"
used=$(crate_directory "$root")
[[ "$used" -ef "$directory/$name" ]] ||
    fail "cargo builds with $used instead of $directory/$name: the cargo configuration of a directory" \
        "above takes precedence; put the clone elsewhere"
for other in "$directory"/rustdds-*; do
    [[ "$other" == "$directory/$name" ]] || rm -rf "$other"
done
