#!/usr/bin/env bash
# A short turntable by every method, by the release build under synchronization validation. Frames whose passes nobody
# times have barriers only where one pass needs another's results, and the checks of a debug build between passes bring
# barriers of their own: only a release build shows a barrier that is missing.
set -euo pipefail
cd "$(dirname "$0")/.."

# PELLUCID_BINARY names one that is built already.
if [[ -z ${PELLUCID_BINARY:-} ]]; then
    cargo build --locked --release
    PELLUCID_BINARY=${CARGO_TARGET_DIR:-target}/release/pellucid
fi
frames=$(mktemp -d)
trap 'rm -rf "$frames"' EXIT
export PELLUCID_VALIDATION=1
# The table of methods, one in a row.
methods=$(sed -n '/<!-- methods: generated -->/,/<!-- methods: end -->/s/^| `\([a-z-]*\)`.*/\1/p' docs/methods.md)
for prefers in cpu gpu; do
    for method in $methods; do
        PELLUCID_PREFER=$prefers "$PELLUCID_BINARY" -q render --turntable --frames=4 --size 96x64 --method "$method" \
            -o "$frames/$prefers-$method-%03d.png"
    done
done
pictures=("$frames"/*.png)
echo "${#pictures[@]} frames of $(wc -w <<<"$methods") methods, no message"
