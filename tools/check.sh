#!/usr/bin/env bash
# Everything that must hold before a change goes in: format, lints, docs, typos, licences, tests, in that order.
set -euo pipefail
cd "$(dirname "$0")/.."

step() { echo "== $*"; }

# Runs a tool that not everybody has; CI has all of them.
optional() {
    local tool=$1 how=$2
    shift 2
    step "$*"
    if command -v "$tool" >/dev/null; then
        "$@"
    else
        echo "note: skipped, $tool is not installed ($how)"
    fi
}

step cargo fmt --check
cargo fmt --check
step cargo clippy
cargo clippy --locked --all-targets -- -D warnings
step cargo clippy without the window
cargo clippy --locked -p pellucid-cli --no-default-features -- -D warnings
step cargo doc
RUSTDOCFLAGS="-D warnings" cargo doc --locked --no-deps
optional typos "cargo install --locked typos-cli" typos
optional cargo-deny "cargo install --locked cargo-deny" cargo deny --locked check
optional ruff "pip install ruff" ruff check tools/peers
optional ruff "pip install ruff" ruff format --check tools/peers
optional python3 "the scripts in tools/peers are in Python" python3 -m unittest discover tools/peers
step tools/test.sh
tools/test.sh
