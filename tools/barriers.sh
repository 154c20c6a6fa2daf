#!/usr/bin/env bash
# A short turntable by every method, under synchronization validation. Frames whose passes nobody times have barriers
# only where one pass needs another's results. The checks that a debug build makes between passes bring barriers of
# their own, which would hide that one is missing, so that they are off. Checks in shaders stay, so that the cache of
# the tests has these shaders.
set -euo pipefail
cd "$(dirname "$0")/.."

# PELLUCID_BINARY names one that is built already.
if [[ -z ${PELLUCID_BINARY:-} ]]; then
    cargo build --locked --release
    PELLUCID_BINARY=${CARGO_TARGET_DIR:-target}/release/pellucid
fi
frames=$(mktemp -d)
trap 'rm -rf "$frames"' EXIT
export PELLUCID_VALIDATION=1 PELLUCID_CHECKS=shaders
# The table of methods, one in a row.
methods=$(sed -n '/<!-- methods: generated -->/,/<!-- methods: end -->/s/^| `\([a-z-]*\)`.*/\1/p' docs/methods.md)
# Peeling draws every point again for each layer. A twelfth of the built-in garden's points has the same passes, except
# those for lists longer than 256, which the whole garden has.
mkdir "$frames/garden"
"$PELLUCID_BINARY" -q scene garden --set points=40000 -o "$frames/garden"
# Two at a time: pictures as small as these keep no more than a core busy. xargs fails if one of them does.
for prefers in cpu gpu; do
    for method in $methods; do echo "$prefers $method thin $frames/garden/scene.toml"; done
    for method in abuffer linked-list; do echo "$prefers $method whole"; done
done | xargs -P 2 -L 1 bash -c 'PELLUCID_PREFER=$2 exec "$0" -q render "${@:5}" --turntable --frames=4 --size 96x64 --method "$3" \
    -o "$1/$2-$3-$4-%03d.png"' "$PELLUCID_BINARY" "$frames"
pictures=("$frames"/*.png)
echo "${#pictures[@]} frames of $(wc -w <<<"$methods") methods, no message"
