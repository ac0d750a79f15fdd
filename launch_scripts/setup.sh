#!/usr/bin/env bash
# Prepares the repository for cargo: every build from then on uses the corrected RustDDS.
#
#   launch_scripts/setup.sh
#
# Copies RustDDS from cargo's registry to .cargo/corrected, applies patches/rustdds in the order of
# their names, and writes .cargo/corrected/config.toml, which .cargo/config.toml includes. Does nothing
# if that is up to date, and downloads the crates of Cargo.lock where cargo has not done so. All other
# scripts call it. A copy that was changed by hand is not noticed: delete .cargo/corrected to undo it.
#
# With EVAC_UNCORRECTED=1 it does nothing: for testing a build with the published crate, in a clone
# that has not been set up.

set -euo pipefail
root=$(CDPATH='' cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

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
[[ -f "${patches[0]}" ]] || fail "no corrections found in $root/patches/rustdds: the clone is incomplete"
version=$(awk '$3 == "\"rustdds\"" { getline; gsub("\"", ""); print $3 }' "$root/Cargo.lock")
# Of the names, too: they are the list of corrections. And of this script.
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
# If this fails, cargo builds with the published crate, not with corrections of before.
rm -f "$configuration"

# The directory of RustDDS that cargo builds with, as seen from the directory $1.
crate_directory() {
    # For this platform alone, so that nothing is downloaded for others.
    local platform metadata
    platform=$(rustc --version --verbose | sed -n 's/^host: //p')
    metadata=$(cd "$1" && cargo metadata --locked --format-version 1 --filter-platform "$platform" \
        --manifest-path "$root/Cargo.toml") || fail "cargo metadata failed; see above"
    # The path of the manifest that follows the package's name and version.
    sed -e 's/{"name":"[^"]*","version":/\n&/g' -e 's/"manifest_path":/\n&/g' <<<"$metadata" |
        awk -v "package={\"name\":\"rustdds\",\"version\":\"$version\"" \
            'index($0, package) == 1 { found = 1 } found && /^"manifest_path"/ { print; found = 0 }' |
        sed -e 's/^"manifest_path":"\(\([^"\\]\|\\.\)*\)\/Cargo\.toml".*/\1/' -e 's/\\\(.\)/\1/g'
}

if [[ ! -d "$directory/$name" ]]; then
    # From the root of the file system: in the repository, and in one around it, a configuration may
    # name a corrected copy.
    original=$(crate_directory /)
    [[ -f "$original/Cargo.toml" ]] || fail "cargo metadata does not name RustDDS $version"

    copy=$(mktemp -d "$directory/incomplete.XXXXXX")
    trap 'rm -rf "$copy"' EXIT
    cp -R "$original/." "$copy"
    for patch in "${patches[@]}"; do
        if command -v patch >/dev/null; then
            patch --quiet --force --fuzz=0 --no-backup-if-mismatch --directory "$copy" --strip 1 <"$patch"
        elif command -v git >/dev/null; then
            # The copy is not part of the repository around it.
            GIT_CEILING_DIRECTORIES=$directory git -C "$copy" -c core.autocrlf=false \
                -c apply.whitespace=nowarn apply "$patch"
        else
            fail "neither patch nor git found, one of which corrects RustDDS: install patch"
        fi || fail "$(basename "$patch") does not apply to RustDDS $version"
        basename "$patch" .patch >>"$copy/CORRECTIONS"
    done
    chmod 755 "$copy"
    mv --no-target-directory "$copy" "$directory/$name" || [[ -d "$directory/$name" ]] ||
        fail "$directory/$name cannot be made; see above"
fi

echo "$setting" >"$directory/incomplete.config.$$"
mv "$directory/incomplete.config.$$" "$configuration"
found=$(crate_directory "$root")
[[ "$found" -ef "$directory/$name" ]] ||
    fail "cargo builds with $found, not with $directory/$name: the configuration of a directory above" \
        "has precedence; put the clone elsewhere"
for other in "$directory"/rustdds-*; do
    [[ "$other" == "$directory/$name" ]] || rm -rf "$other"
done
