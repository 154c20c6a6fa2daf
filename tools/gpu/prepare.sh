#!/usr/bin/env bash
# Prepares a measurement on a machine with a GPU, here, without one: builds release binaries, packs them, and has the
# driver at hand draw the pictures that the GPU's are compared with. All of it goes to .gpu, which git ignores and
# which travels along with the repository (docs/internals/measuring.md, "Measuring on a GPU").
#
#   tools/gpu/prepare.sh            # everything
#   tools/gpu/prepare.sh --check    # only whether what is there travels: its size, and what it needs of a system
set -euo pipefail
cd "$(dirname "$0")/../.."

say() { echo "prepare: $*"; }
fail() { echo "error: $*" >&2; exit 1; }

folder=.gpu
# More does not travel.
largest=$((60 << 20))
target=${CARGO_TARGET_DIR:-target}
programs=(pellucid gpu-table)

case ${1:-} in
    "" | --check) ;;
    -h | --help) sed -n '2,7s/^# \{0,1\}//p' "$0"; exit 0 ;;
    *) fail "unknown argument '$1'; usage: tools/gpu/prepare.sh [--check]" ;;
esac

build() {
    rm -rf "$folder"
    mkdir -p "$folder/bin"
    ${CARGO:-cargo} build --release --locked -p pellucid-cli --bin pellucid
    ${CARGO:-cargo} build --release --locked -p pellucid-lab --example gpu-table
    cp "$target/release/pellucid" "$target/release/examples/gpu-table" "$folder/bin"
    strip "${programs[@]/#/$folder/bin/}"
    git describe --always --dirty --abbrev=8 --exclude '*' >"$folder/commit"
    say "pictures of all methods on the driver at hand"
    "$folder/bin/gpu-table" record "$folder/pictures" >"$folder/record.log" || fail "no pictures: $folder/record.log"
    "$folder/bin/gpu-table" device >"$folder/pictures/driver.jsonl"
    # The machine may have no loader of Vulkan.
    local loader
    loader=$(PATH=$PATH:/usr/sbin:/sbin ldconfig -p | awk '$1 == "libvulkan.so.1" && /x86-64/ { print $NF; exit }')
    [[ -n $loader ]] || fail "no libvulkan.so.1 here to take along; install libvulkan1"
    mkdir -p "$folder/loader"
    cp -L "$loader" "$folder/loader/libvulkan.so.1"
    gzip -9 "${programs[@]/#/$folder/bin/}" "$folder/loader/libvulkan.so.1"
    # Pictures are compressed, and many small files travel slowly.
    tar -C "$folder" -cf "$folder/pictures.tar" pictures
    rm -r "$folder/pictures"
}

# Whether it travels.
check() {
    local file bytes tree
    for file in bin/pellucid.gz bin/gpu-table.gz loader/libvulkan.so.1.gz pictures.tar commit; do
        [[ -s $folder/$file ]] || fail "$folder/$file is missing; run tools/gpu/prepare.sh"
    done
    bytes=$(du -sb "$folder" | cut -f 1)
    # Tracked files and new ones travel as well.
    tree=$(git ls-files -coz --exclude-standard | du -cb --files0-from=- 2>/dev/null | tail -n 1 | cut -f 1)
    say "$folder has $bytes bytes, the repository $tree"
    ((bytes + tree <= largest)) || fail "together more than the $largest bytes that travel"
    say "needs $(gzip -dc "$folder/bin/gpu-table.gz" | grep -aoE 'GLIBC_2\.[0-9]+' | sort -uV | tail -n 1) or newer"
}

if [[ ${1:-} != --check ]]; then build; fi
check
say "then, on the machine with the GPU: OUT=DIR tools/gpu/measure.sh 400"
