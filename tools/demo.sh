#!/usr/bin/env bash
# Renders the built-in scene to garden.png and prints what each GPU pass cost.
set -euo pipefail
cd "$(dirname "$0")/.."

tools/setup.sh
# Without the window, whose crates take as long to compile as all others.
package=(--release --locked --package pellucid-cli --bin pellucid --no-default-features)
cargo build "${package[@]}"
# `cargo run` finds the binary wherever the target directory is.
pellucid() { cargo run --quiet "${package[@]}" -- "$@"; }

pellucid render -o garden.png
pellucid profile --frames 3
echo
echo "The picture: $PWD/garden.png"
echo "\`cargo build --release\` makes target/release/pellucid with its window, \`pellucid view\`."
