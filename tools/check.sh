#!/usr/bin/env bash
# Everything that must hold before a change goes in: format, lints, docs, typos, licenses, tests, in that order. With
# --lints all but the tests, as CI runs it from tools/test.sh.
set -euo pipefail
cd "$(dirname "$0")/.."

case ${1:-} in
    "" | --lints) ;;
    *) echo "error: unknown argument '$1'; usage: tools/check.sh [--lints]" >&2; exit 2 ;;
esac

step() { echo "== $*"; }

# Debian packages none of the first three; the fourth would be packaged for a Python of its own. CI does without them,
# and whoever makes a release has them.
ci_lacks=" typos cargo-deny ruff numpy "

# Says that a tool is missing, and what to do. In CI an error, unless the tool is one of those above.
missing() {
    local tool=$1 how=$2
    if [[ ${CI:-} == true && $ci_lacks != *" $tool "* ]]; then
        echo "error: $tool is not installed ($how)" >&2
        exit 1
    fi
    echo "note: skipped, $tool is not installed ($how)"
}

# Runs a tool that not everybody has.
optional() {
    local tool=$1 how=$2
    shift 2
    step "$*"
    if command -v "$tool" >/dev/null; then "$@"; else missing "$tool" "$how"; fi
}

step cargo fmt --all --check
cargo fmt --all --check
# In CI with MPI, as the tests are built there: nothing is compiled twice.
features=()
if [[ ${CI:-} == true ]]; then features=(--features pellucid-cli/mpi,pellucid-python/unified); fi
step cargo clippy
cargo clippy --locked --workspace "${features[@]}" --all-targets -- -D warnings
# Other features compile most crates again. On GitHub the job of the oldest Rust does it.
if [[ ${CI:-} != true ]]; then
    step cargo clippy without the window
    cargo clippy --locked -p pellucid-cli --no-default-features -- -D warnings
fi
step cargo doc
RUSTDOCFLAGS="-D warnings" cargo doc --locked --workspace "${features[@]}" --no-deps
optional typos "cargo install --locked typos-cli" typos
optional cargo-deny "cargo install --locked cargo-deny" cargo deny --locked check
optional ruff "pip install ruff" ruff check tools/gpu tools/papers tools/peers tools/pictures tools/witnesses
optional ruff "pip install ruff" ruff format --check tools/gpu tools/papers tools/peers tools/pictures tools/witnesses
for folder in gpu papers peers pictures witnesses; do
    optional python3 "the scripts in tools/$folder are in Python" python3 -m unittest discover "tools/$folder"
done
if command -v python3 >/dev/null && ! python3 -c 'import numpy' 2>/dev/null; then
    missing numpy "pip install numpy; the tests of tools/peers and tools/witnesses need it"
fi
if [[ ${1:-} != --lints ]]; then
    step tools/test.sh
    # The other demands of CI were just checked.
    CI='' tools/test.sh
fi
