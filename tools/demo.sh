#!/usr/bin/env bash
# Renders the built-in scene to garden.png and prints what each GPU pass cost.
set -euo pipefail
cd "$(dirname "$0")/.."

tools/setup.sh
cargo build --release --locked --bin pellucid
# `cargo run` finds the binary wherever the target directory is.
pellucid() { cargo run --release --locked --quiet --bin pellucid -- "$@"; }

pellucid render -o garden.png
pellucid profile --frames 3
echo
echo "The picture: $PWD/garden.png"
