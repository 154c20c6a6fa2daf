#!/usr/bin/env bash
# Runs the tests.
#
#   tools/test.sh               everything that one needs to trust a change
#   tools/test.sh --all         the long sweeps as well, and the barriers of a release build; takes an hour
#   tools/test.sh ARGUMENTS     `cargo test` with these arguments
#   CI=true tools/test.sh       everything that CI demands; PARTS says which of it (below)
#
# A machine without a Vulkan device fails: set PELLUCID_REQUIRE_GPU=0 to run the others there. What is skipped is
# printed, as `skipped: <test>: <reason>`.
#
# CI demands lints (tools/check.sh), the book (tools/book.sh), the suites with the long tests in a short form, and of
# the programs the barriers, the budget of registers on a GPU, a look at every step of tools/gpu/measure.sh, the Python
# package and pellucid-mpi. Everything is one debug build with one set of features. No skip is allowed but for the
# reasons that are named below. PARTS="lints suites programs" is all of it; "gpu lab host" and "cli window fuzz" are the
# two halves of the suites.
set -euo pipefail
cd "$(dirname "$0")/.."

all=false
if [[ ${1:-} == --all ]]; then
    all=true
    shift
fi
in_ci=false
if [[ ${CI:-} == true ]]; then in_ci=true; fi

needs=(--tests)
if $in_ci; then needs+=(--mpi); fi
tools/setup.sh "${needs[@]}"
export PELLUCID_REQUIRE_GPU="${PELLUCID_REQUIRE_GPU:-1}"
target=${CARGO_TARGET_DIR:-target}
mkdir -p "$target"
target=$(realpath "$target")
# One cache of shaders for all suites and runs: pellucid's own and Mesa's.
export PELLUCID_CACHE_DIR="${PELLUCID_CACHE_DIR:-$target/shaders}"
export MESA_SHADER_CACHE_DIR="${MESA_SHADER_CACHE_DIR:-$target/shaders}"
mkdir -p "$PELLUCID_CACHE_DIR" "$MESA_SHADER_CACHE_DIR"
# lavapipe draws with as many threads as there are cores. Where tests run beside each other, its threads wait for each
# other; without them the suites take a quarter less of the CPU.
export LP_NUM_THREADS="${LP_NUM_THREADS:-0}"
# CI builds everything once, so that nothing is incremental.
if $in_ci; then export CARGO_INCREMENTAL=0; fi

# Arguments may name targets of their own.
if (($# > 0)); then exec cargo test --locked --workspace "$@"; fi

step() { echo "== $*"; }

workspace=(--locked --workspace)
# Arguments for the tests themselves.
run=()
if $in_ci; then
    # Cargo compiles a crate anew for each set of features of what it depends on. With these the wheel of
    # tools/python.sh is made of what the tests are made of; crates/python/Cargo.toml explains `unified`.
    workspace+=(--features pellucid-cli/mpi,pellucid-python/unified)
    # Nobody has the real clouds but some developers; tests/data stands in for them.
    export PELLUCID_REQUIRE_ALL=1 PELLUCID_ALLOWED_SKIPS="${PELLUCID_ALLOWED_SKIPS:-no real clouds}"
    export PELLUCID_SHORT_SWEEPS=1
    # 20 sweeps of determinism and all variants of shaders have no short form but the one that runs anyway.
    run=(--include-ignored --skip gpu_assisted_validation --skip twenty_times --skip in_every_variant)
elif $all; then
    # GPU-assisted validation needs layers that no distribution has yet: CONTRIBUTING.md says how it is run.
    run=(--include-ignored --skip gpu_assisted_validation)
fi

# The names of all test binaries but those that need a feature; a new one is among them.
binaries() {
    local file
    for file in crates/*/tests/*.rs crates/*/tests/*/main.rs; do
        file=${file%/main.rs}
        file=$(basename "${file%.rs}")
        if [[ $file != mpi ]]; then echo "$file"; fi
    done
}

# Suites that use the device all the time. One at a time keeps no more than a core and a half busy.
device_suites=(gpu cli)
# Suites that run beside them: on the host alone, with small pictures, or waiting for windows most of the time. Units
# and examples are among them. `cargo test` without any target would build all examples, which clippy does faster.
# `lab` is the last suite: it uses the device, too, and takes as long as all others.
units=(--lib)
for name in drivers gpu-shape gpu-table layers-experiments samples-experiments soft-experiments spbr-experiments study; do units+=(--example "$name"); done
other_suites=()
for name in $(binaries | sort -u); do
    if [[ " lab ${device_suites[*]} " != *" $name "* ]]; then other_suites+=("$name"); fi
done
doc=true lab=true
# Whether the programs are tested as well, which CI demands: Python behind `lab`, since its tests keep a core busy one
# at a time, and the others behind the suites of the device.
programs=false

# Picks from both lists what PARTS names.
parts=" ${PARTS:-lints suites programs} "
has() { [[ $parts == *" $1 "* ]]; }
if $in_ci && has programs; then programs=true; fi
if ! has suites; then
    picked=()
    for name in "${device_suites[@]}"; do if has "$name"; then picked+=("$name"); fi; done
    device_suites=("${picked[@]}")
    picked=()
    for name in "${other_suites[@]}"; do
        # Units, and whatever is in neither half by name, go with `host`.
        if has "$name" || { has host && [[ " window fuzz " != *" $name "* ]]; }; then picked+=("$name"); fi
    done
    other_suites=("${picked[@]}")
    if ! has host; then units=() doc=false; fi
    if ! has lab; then lab=false; fi
fi

# Tests of one kind, all of them even if one fails.
tests() { cargo test "${workspace[@]}" --no-fail-fast "$@" -- "${run[@]}"; }
names() { printf -- '--test\n%s\n' "$@"; }

# start NAME FUNCTION: runs the function in the background, in a group of its own, which ends with this script.
start() {
    beside=$1
    log=$(mktemp)
    set -m
    "$2" >"$log" 2>&1 </dev/null &
    other=$!
    set +m
    # shellcheck disable=SC2064
    trap "kill -- -$other 2>/dev/null || true; rm -f '$log'" EXIT
}

# finish [STATUS]: waits for what was started, prints what it said, and names what failed of it at the end. Fails if it
# failed, or with the status of what ran beside it.
finish() {
    local status=${1:-0}
    wait "$other" || status=1
    trap - EXIT
    step "$beside"
    cat "$log"
    if ((status != 0)); then
        echo "error: failed:" >&2
        grep -hE '^test .* FAILED$|^error: ' "$log" >&2 || true
    fi
    rm -f "$log"
    return "$status"
}

# both NAME FUNCTION NAME FUNCTION: runs the first function in the background, and the second one beside it.
both() {
    local status=0
    step "$3; beside it $1"
    start "$1" "$2"
    "$4" || status=1
    finish "$status"
}

# Two rows of suites and programs, all of them even if one fails.
others=() devices=()
run_others() {
    local status=0
    if ((${#others[@]} > 0)); then tests "${others[@]}" || status=1; fi
    if $doc; then tests --doc || status=1; fi
    # Sweeps of determinism look for what depends on the order of workgroups: with threads.
    if $lab; then (unset LP_NUM_THREADS && tests --test lab) || status=1; fi
    if $programs; then tools/python.sh || status=1; fi
    return $status
}
run_devices() {
    local status=0
    if ((${#devices[@]} > 0)); then tests "${devices[@]}" || status=1; fi
    if $programs; then
        "$target/debug/examples/gpu-shape" --check || status=1
        tools/gpu/measure.sh --quick "$target/debug" || status=1
        tools/barriers.sh || status=1
        tools/mpi.sh || status=1
    fi
    return $status
}
suites() {
    local beside="${other_suites[*]}" first="${device_suites[*]}"
    if $doc; then beside+=" units documentation"; fi
    local last=()
    if $lab; then beside+=" lab" last=(--test lab); fi
    if $programs; then
        beside+=" Python" first+=" registers GPU barriers MPI" last+=(--test mpi)
        step "building the programs"
        cargo build "${workspace[@]}" --bins --example gpu-shape --example gpu-table
        export PELLUCID_BINARY=$target/debug/pellucid
    fi
    others=("${units[@]}")
    if ((${#other_suites[@]} > 0)); then mapfile -t -O ${#others[@]} others < <(names "${other_suites[@]}"); fi
    if ((${#device_suites[@]} > 0)); then mapfile -t devices < <(names "${device_suites[@]}"); fi
    step "building the tests"
    cargo test "${workspace[@]}" --no-run "${others[@]}" "${devices[@]}" "${last[@]}"
    both "${beside# }" run_others "${first# }" run_devices
}

if ! $in_ci; then
    suites
    if $all; then
        step "barriers of the release build"
        tools/barriers.sh
    fi
    exit
fi

# Python's packages are fetched and unpacked on one core, of which lints and builds leave some idle.
python_environment() { tools/python.sh --environment; }
if $programs; then start "Python's environment" python_environment; fi
if has lints; then
    tools/check.sh --lints
    step "the book"
    tools/book.sh
fi
if $programs; then finish; fi
if $programs || $lab || ((${#device_suites[@]} + ${#other_suites[@]} > 0)); then suites; fi
