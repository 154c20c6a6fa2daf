#!/usr/bin/env bash
# Everything that must hold before a change goes in: format, lints, docs, typos, licences, tests, in that order. With --lints
# all but the tests, as CI runs it from tools/test.sh.
set -euo pipefail
cd "$(dirname "$0")/.."

case ${1:-} in
    "" | --lints) ;;
    *) echo "error: unknown argument '$1'; usage: tools/check.sh [--lints]" >&2; exit 2 ;;
esac

step() { echo "== $*"; }

# Debian packages none of these, so that CI does without them; whoever makes a release has them.
ci_lacks=" typos cargo-deny ruff "

# Runs a tool that not everybody has. CI fails without it, unless it is one of those above.
optional() {
    local tool=$1 how=$2
    shift 2
    step "$*"
    if command -v "$tool" >/dev/null; then
        "$@"
    elif [[ ${CI:-} == true && $ci_lacks != *" $tool "* ]]; then
        echo "error: $tool is not installed ($how)" >&2
        exit 1
    else
        echo "note: skipped, $tool is not installed ($how)"
    fi
}

step cargo fmt --all --check
cargo fmt --all --check
step cargo clippy
cargo clippy --locked --workspace --all-targets -- -D warnings
step cargo clippy without the window
cargo clippy --locked -p pellucid-cli --no-default-features -- -D warnings
step cargo doc
RUSTDOCFLAGS="-D warnings" cargo doc --locked --workspace --no-deps
optional typos "cargo install --locked typos-cli" typos
optional cargo-deny "cargo install --locked cargo-deny" cargo deny --locked check
optional ruff "pip install ruff" ruff check tools/peers
optional ruff "pip install ruff" ruff format --check tools/peers
optional python3 "the scripts in tools/peers are in Python" python3 -m unittest discover tools/peers
if [[ ${1:-} != --lints ]]; then
    step tools/test.sh
    # What CI demands besides was just looked at.
    CI='' tools/test.sh
fi
