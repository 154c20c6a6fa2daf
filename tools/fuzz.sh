#!/usr/bin/env bash
# Fuzzes what pellucid reads: tools/fuzz.sh [SECONDS] [TARGET…], by default 600 seconds each of all targets, one after
# another. Prints a table and fails if there is a finding, whose input is then in fuzz/artifacts. New inputs are kept in
# target/fuzz/corpus, from which the next run goes on. CONTRIBUTING.md says what to do with a finding.
set -euo pipefail
cd "$(dirname "$0")/.."

seconds=600
if [[ ${1-} =~ ^[0-9]+$ ]]; then
    seconds=$1
    shift
fi

if ! cargo fuzz --version >/dev/null 2>&1; then
    echo "error: cargo-fuzz is missing (cargo install cargo-fuzz --locked)" >&2
    exit 1
fi

targets=("$@")
if [[ ${#targets[@]} = 0 ]]; then
    for file in fuzz/targets/*.rs; do targets+=("$(basename "$file" .rs)"); done
fi
for target in "${targets[@]}"; do
    if [[ ! -f fuzz/targets/$target.rs ]]; then
        echo "error: no target $target; there are: $(basename -s .rs fuzz/targets/*.rs | tr '\n' ' ')" >&2
        exit 2
    fi
done

# All unsafe code is in crates/gpu and crates/window, which no target reaches: a sanitizer, which takes nightly Rust,
# would find little and halve the speed. Debug assertions are on: sums that overflow are findings.
cargo fuzz build --sanitizer none --target-dir target/fuzz
host=$(rustc -vV | sed -n 's/^host: //p')

# A file per input: better not on a disk.
[[ -w /dev/shm ]] && export TMPDIR="${TMPDIR:-/dev/shm}"
export RAYON_NUM_THREADS=1

failed=0
rows=""
for target in "${targets[@]}"; do
    corpus=target/fuzz/corpus/$target artifacts=fuzz/artifacts/$target log=target/fuzz/$target.log
    mkdir -p "$corpus" "$artifacts"
    flags=(-max_total_time="$seconds" -timeout=10 -rss_limit_mb=512 -max_len=4096 -print_final_stats=1)
    # A byte of a picture may be a thousand pixels, each of which becomes a point of some 60 bytes.
    [[ $target = photo ]] && flags+=(-max_len=2048)
    [[ -f fuzz/dictionaries/$target.dict ]] && flags+=(-dict="fuzz/dictionaries/$target.dict")
    echo "== $target"
    found=0
    # Decoder libraries print their panics, which become errors: that is no news.
    "target/fuzz/$host/release/$target" "$corpus" "fuzz/corpus/$target" -artifact_prefix="$artifacts/" "${flags[@]}" \
        >"$log" 2>&1 || found=1
    if [[ $found = 1 ]]; then
        failed=1
        tail -n 30 "$log"
    fi
    executions=$(sed -n 's/^stat::number_of_executed_units: *//p' "$log")
    edges=$(sed -n 's/.* cov: \([0-9]*\) .*/\1/p' "$log" | tail -n 1)
    took=$(sed -n 's/^Done [0-9]* runs in \([0-9]*\) second.*/\1/p' "$log")
    rows+=$(printf '%-10s %8s %12s %8s %9s' "$target" "${took:--}" "${executions:--}" "${edges:--}" "$found")$'\n'
done
printf '\n%-10s %8s %12s %8s %9s\n%s' target seconds executions edges findings "$rows"
exit $failed
